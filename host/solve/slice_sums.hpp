#pragma once

#include <utility>

#include "host/solve/simd.hpp"
#include "weft/kernels/solve/pcg.hpp"

namespace weft::pcg {

/// Products of the rows of a slice with a vector, one row beside the other. A row is summed in the
/// order of the calls.
template <class T>
class SliceSums {
 public:
  /// Begins with the masses' part.
  /// @param all  numbers of the vector, vertex by vertex; referred to, and readable up to
  ///             HostDevice::readable_beyond bytes beyond the last
  /// @param own  [host_slice] the rows' vertices   @param mass [host_slice]
  SliceSums(const T* all, const Index* own, const T* mass) noexcept : all_(all) {
    for_each_part([&](auto part) {
      own_[part] = gather_vectors(all, own + first<part>);
      const auto m = load_values(mass + first<part>);
      sum_[part] = {m * own_[part].x, m * own_[part].y, m * own_[part].z};
    });
  }

  /// @param term [3][host_slice]
  void add(const T* term) noexcept {
    for_each_part([&](auto part) {
      sum_[part].x += load_values(term + first<part>);
      sum_[part].y += load_values(term + host_slice + first<part>);
      sum_[part].z += load_values(term + 2 * host_slice + first<part>);
    });
  }

  /// Adds 3 x 3 blocks times differences to the rows' own vertices.
  /// @param value, column of a slot, see BlockEll
  void add_blocks(const T* value, const Index* column) noexcept {
    for_each_part([&](auto part) {
      const SimdVectors<T> d = differences<part>(column);
      const T* from = value + first<part>;
      const auto at = [from](int k) { return load_values(from + k * host_slice); };
      sum_[part].x += at(0) * d.x + at(1) * d.y + at(2) * d.z;
      sum_[part].y += at(3) * d.x + at(4) * d.y + at(5) * d.z;
      sum_[part].z += at(6) * d.x + at(7) * d.y + at(8) * d.z;
    });
  }

  /// The same of multiples of the identity, see ScalarEll.
  void add_scalars(const T* value, const Index* column) noexcept {
    for_each_part([&](auto part) {
      const SimdVectors<T> d = differences<part>(column);
      const auto factor = load_values(value + first<part>);
      sum_[part].x += factor * d.x;
      sum_[part].y += factor * d.y;
      sum_[part].z += factor * d.z;
    });
  }

  /// The first `count` rows.
  void store(Vec3<T>* to, Index count) const noexcept {
    T sum[3][host_slice];
    for_each_part([&](auto part) {
      store_values(sum_[part].x, sum[0] + first<part>);
      store_values(sum_[part].y, sum[1] + first<part>);
      store_values(sum_[part].z, sum[2] + first<part>);
    });
    for (Index row = 0; row < count; ++row) to[row] = {sum[0][row], sum[1][row], sum[2][row]};
  }

 private:
  static constexpr Index parts = host_slice / Simd<T>::width;
  /// First row of a part.
  template <Index part>
  static constexpr Index first = part* Simd<T>::width;

  /// Not a loop: compilers keep arrays in registers only if all their indices are constants.
  template <class Use>
  static void for_each_part(const Use& use) noexcept {
    [&]<Index... part>(std::integer_sequence<Index, part...>) {
      (use(std::integral_constant<Index, part>{}), ...);
    }
    (std::make_integer_sequence<Index, parts>{});
  }

  template <Index part>
  SimdVectors<T> differences(const Index* column) const noexcept {
    SimdVectors<T> d = gather_vectors(all_, column + first<part>);
    d.x -= own_[part].x;
    d.y -= own_[part].y;
    d.z -= own_[part].z;
    return d;
  }

  const T* all_;
  SimdVectors<T> own_[parts];
  SimdVectors<T> sum_[parts];
};

}  // namespace weft::pcg
