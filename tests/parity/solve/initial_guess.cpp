#include "weft/kernels/solve/initial_guess.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// Rows 100 to 899 of 1000 cloth vertices, with and without the two optional velocities, and with
/// two of three components that fall.
template <class T, bool with_start, bool with_iterate, bool with_falling = true>
struct InitialGuessCase {
  using Scalar = T;
  static constexpr Index count = 1000, row_begin = 100, row_count = 800;
  Random random{6};
  std::vector<Vec3<T>> positions_t1 = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> base = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> start =
      with_start ? random.vectors<T>(count, -20, 20) : std::vector<Vec3<T>>{};
  std::vector<Vec3<T>> iterate =
      with_iterate ? random.vectors<T>(count, -20, 20) : std::vector<Vec3<T>>{};
  std::vector<unsigned char> fixed = random.marks(count, 3);
  std::vector<Vec3<T>> x = random.vectors<T>(count, -20, 20);
  std::vector<Index> component_of_vertex, held = {0, 1, 0};
  std::vector<Vec3<T>> base_velocities = random.vectors<T>(count, -20, 20);
  std::vector<T> damping_mass = random.numbers<T>(count, 0, 4);
  Vec3<T> gravity{T(0.5), T(-0.25), T(-9.75)};
  T h = T(0.0625);

  InitialGuessCase() {
    if (!with_falling) held.clear();
    for (Index v = 0; v < count; ++v) component_of_vertex.push_back(v % 3);
  }

  Outputs compute(Device& device, Index parts) const {
    const auto target = upload(device, positions_t1), base_d = upload(device, base);
    const auto start_d = upload(device, start), iterate_d = upload(device, iterate);
    const auto fixed_d = upload(device, fixed);
    const auto x_d = upload(device, x);
    const auto held_d = upload(device, held), component_d = upload(device, component_of_vertex);
    const auto base_velocities_d = upload(device, base_velocities);
    const auto damping_d = upload(device, damping_mass);
    for (const auto& [begin, size] : parts_of(row_count, parts))
      launch(device.compute(),
             SolveInitialGuess<T>{row_begin + begin, size, target.span(), base_d.span(),
                                  start_d.span(), iterate_d.span(), fixed_d.span(), h, x_d.span(),
                                  held_d.span(), component_d.span(), base_velocities_d.span(),
                                  damping_d.span(), gravity});
    return {output("x", download(x_d))};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> result;
    for (Index v = 0; v < count; ++v) {
      const auto n = static_cast<std::size_t>(v);
      Vec3<double> guess = vec_cast<double>(x[n]);
      if (v >= row_begin && v < row_begin + row_count)
        for (int c = 0; c < 3; ++c) {
          const double now = with_iterate ? double{iterate[n][c]} : 0.0;
          if (fixed[n] != 0)
            guess[c] = (double{positions_t1[n][c]} - double{base[n][c]}) / double{h} - now;
          else if (!with_start)
            guess[c] = 0;
          else if (with_falling && v % 3 != 1)
            guess[c] = (double{base_velocities[n][c]} + double{h} * double{gravity[c]}) /
                           (1 + double{h} * double{damping_mass[n]}) -
                       now;
          else
            guess[c] = double{start[n][c]} - now;
        }
      result.push_back(guess);
    }
    return {output("x", result)};
  }
};

using Cases =
    testing::Types<InitialGuessCase<float, true, false>, InitialGuessCase<float, true, true>,
                   InitialGuessCase<float, true, true, false>, InitialGuessCase<float, false, true>,
                   InitialGuessCase<double, true, false>, InitialGuessCase<double, true, true>,
                   InitialGuessCase<double, false, true>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveInitialGuess, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
