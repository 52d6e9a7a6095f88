#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/exec/host_devices.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"
#include "weft/error.hpp"
#include "weft/exec/buffer.hpp"

namespace weft::parity {

/// Largest difference that two evaluations of one formula may show, as a share of the largest
/// magnitude in the array. Bits may differ: nvcc fuses a * b + c, the host's compiler does not.
template <class T>
inline constexpr double tolerance = std::is_same_v<T, float> ? 1e-5 : 1e-12;

/// Numbers that are the same on every machine for one seed.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}

  /// Exact in float, so that float and double inputs of one seed agree.
  template <class T>
  T uniform(double low, double high) {
    const double share = static_cast<double>(engine_() >> 8) / 16777216.0;
    return static_cast<T>(static_cast<float>(low + share * (high - low)));
  }
  template <class T>
  Vec3<T> vector(double low, double high) {
    Vec3<T> v{};
    for (int c = 0; c < 3; ++c) v[c] = uniform<T>(low, high);
    return v;
  }
  template <class T>
  std::vector<Vec3<T>> vectors(std::size_t count, double low, double high) {
    std::vector<Vec3<T>> all(count);
    for (Vec3<T>& v : all) v = vector<T>(low, high);
    return all;
  }
  template <class T>
  std::vector<T> numbers(std::size_t count, double low, double high) {
    std::vector<T> all(count);
    for (T& v : all) v = uniform<T>(low, high);
    return all;
  }
  /// One mark in `every` is 1.
  std::vector<unsigned char> marks(std::size_t count, unsigned every) {
    std::vector<unsigned char> all(count);
    for (unsigned char& m : all) m = engine_() % every == 0 ? 1 : 0;
    return all;
  }
  template <class T>
  void shuffle(std::vector<T>& all) {
    for (std::size_t i = all.size(); i > 1; --i) std::swap(all[i - 1], all[engine_() % i]);
  }

 private:
  std::mt19937 engine_;
};

/// A crumpled grid of 20 x 18 cells of 0.1 m, each cut in two.
template <class T>
struct Sheet {
  static constexpr Index across = 20, up = 18;
  std::vector<Tri> triangles;
  std::vector<Hinge> hinges;  ///< the diagonals
  std::vector<Vec3<T>> positions;

  explicit Sheet(Random& random) {
    const auto at = [](Index i, Index j) { return j * (across + 1) + i; };
    for (Index j = 0; j <= up; ++j)
      for (Index i = 0; i <= across; ++i)
        positions.push_back(Vec3<T>{static_cast<T>(0.1f * static_cast<float>(i)),
                                    static_cast<T>(0.1f * static_cast<float>(j)), T(0)} +
                            random.vector<T>(-0.02, 0.02));
    for (Index j = 0; j < up; ++j)
      for (Index i = 0; i < across; ++i) {
        const Index a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
        triangles.push_back({{a, b, c}});
        triangles.push_back({{a, c, d}});
        hinges.push_back({{a, c, d, b}});
      }
  }
};

template <class T>
Buffer<T> upload(Device& device, const std::vector<T>& values) {
  Buffer<T> buffer(device, values.size());
  device.compute().copy(buffer.data(), values.data(), values.size() * sizeof(T));
  device.compute().sync();
  return buffer;
}

template <class T>
std::vector<T> download(const Buffer<T>& buffer) {
  std::vector<T> values(buffer.size());
  buffer.device().compute().copy(values.data(), buffer.data(), buffer.size() * sizeof(T));
  buffer.device().compute().sync();
  return values;
}

/// What a kernel wrote, by name, as plain numbers.
struct Output {
  std::string name;
  std::vector<double> values;
};
using Outputs = std::vector<Output>;

template <class T>
requires std::is_arithmetic_v<T>
void append_numbers(std::vector<double>& all, T value) {
  all.push_back(static_cast<double>(value));
}
template <class T, int N>
void append_numbers(std::vector<double>& all, const Vec<T, N>& value) {
  for (const T component : value.e) all.push_back(static_cast<double>(component));
}
template <class T, int R, int C>
void append_numbers(std::vector<double>& all, const Mat<T, R, C>& value) {
  for (const T component : value.e) all.push_back(static_cast<double>(component));
}
template <class V>
Output output(std::string name, const std::vector<V>& values) {
  Output result{std::move(name), {}};
  for (const V& value : values) append_numbers(result.values, value);
  return result;
}

inline void expect_close(const Outputs& found, const Outputs& reference, double tolerance) {
  ASSERT_EQ(found.size(), reference.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const std::vector<double>& a = found[k].values;
    const std::vector<double>& b = reference[k].values;
    ASSERT_EQ(a.size(), b.size()) << found[k].name;
    double scale = 0;
    for (const double value : b) scale = std::max(scale, std::abs(value));
    ASSERT_GT(scale, 0) << found[k].name << " is all zero: this would test nothing";
    for (std::size_t i = 0; i < a.size(); ++i)
      ASSERT_LE(std::abs(a[i] - b[i]), tolerance * scale)  // false for NaN
          << found[k].name << ", number " << i << ": " << a[i] << " instead of " << b[i];
  }
}

inline void expect_same_bits(const Outputs& found, const Outputs& reference) {
  ASSERT_EQ(found.size(), reference.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    ASSERT_EQ(found[k].values.size(), reference[k].values.size()) << found[k].name;
    for (std::size_t i = 0; i < found[k].values.size(); ++i)
      ASSERT_EQ(std::bit_cast<std::uint64_t>(found[k].values[i]),
                std::bit_cast<std::uint64_t>(reference[k].values[i]))
          << found[k].name << ", number " << i;
  }
}

/// GPU 0, once for each GPU number given. Nothing where there is no CUDA, which `why` explains;
/// with WEFT_REQUIRE_CUDA=1 in the environment that is a failure of the running test.
inline std::optional<DeviceSet> find_cuda(const std::vector<int>& gpus, std::string& why) {
  try {
    return cuda_devices(gpus);
  } catch (const DeviceError& error) {
    why = error.what();
  }
  const char* required = std::getenv("WEFT_REQUIRE_CUDA");
  if (required != nullptr && std::string_view(required) == "1")
    ADD_FAILURE() << "WEFT_REQUIRE_CUDA=1, but: " << why;
  return std::nullopt;
}

/// Lists of GPUs on which results must have the same bits: some that share GPU 0, as find_cuda
/// takes them, and such of several GPUs as this machine has.
inline std::vector<std::vector<int>> gpu_lists() {
  std::vector<std::vector<int>> lists = {{0}, {0, 0}, {0, 0, 0}, {0, 0, 0, 0, 0}};
  for (const std::vector<int>& gpus : {std::vector<int>{0, 1},
                                       {1, 0, 1},
                                       {0, 1, 2},
                                       {0, 1, 2, 3},
                                       {0, 1, 2, 3, 4},
                                       {0, 1, 2, 3, 4, 5, 6, 7}}) {
    try {
      cuda_devices({*std::max_element(gpus.begin(), gpus.end())});
      lists.push_back(gpus);
    } catch (const DeviceError&) {
      break;  // no GPU of that number
    }
  }
  return lists;
}

/// First item and number of items of each part of a range cut into `parts`, the last part first.
/// Cuts lie at multiples of `multiple`.
inline std::vector<std::pair<Index, Index>> parts_of(Index count, Index parts, Index multiple = 1) {
  std::vector<std::pair<Index, Index>> result;
  Index end = count;
  for (Index part = parts - 1; part >= 0; --part) {
    const Index begin = count * part / parts / multiple * multiple;
    if (end > begin) result.emplace_back(begin, end - begin);
    end = begin;
  }
  return result;
}

/// Checks of one kernel at one precision. Case is
///   struct Case {
///     using Scalar = float or double;
///     static constexpr double tolerance;               only where it is not that of Scalar
///     Case();                                          valid random inputs
///     Outputs compute(Device&, Index parts) const;     by the kernel, in that many launches
///     Outputs reference() const;                       in double, by code of the test itself
///   };
template <class Case>
class KernelParity : public testing::Test {
 protected:
  static constexpr double allowed() {
    if constexpr (requires { Case::tolerance; })
      return Case::tolerance;
    else
      return tolerance<typename Case::Scalar>;
  }
  Outputs compute_on_host(Index parts) {
    // Poisoned memory: an output that is not written is NaN.
    const DeviceSet devices = host_devices(1, {.poison = true});
    return case_.compute(devices[0], parts);
  }
  Case case_;
};

TYPED_TEST_SUITE_P(KernelParity);

TYPED_TEST_P(KernelParity, HostAgreesWithPlainDouble) {
  expect_close(this->compute_on_host(1), this->case_.reference(), this->allowed());
}

TYPED_TEST_P(KernelParity, HostInPartsGivesTheSameBits) {
  expect_same_bits(this->compute_on_host(5), this->compute_on_host(1));
}

TYPED_TEST_P(KernelParity, CudaAgreesWithHost) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const Outputs whole = this->case_.compute((*cuda)[0], 1);
  expect_close(whole, this->compute_on_host(1), this->allowed());
  expect_same_bits(this->case_.compute((*cuda)[0], 5), whole);
}

REGISTER_TYPED_TEST_SUITE_P(KernelParity, HostAgreesWithPlainDouble, HostInPartsGivesTheSameBits,
                            CudaAgreesWithHost);

}  // namespace weft::parity
