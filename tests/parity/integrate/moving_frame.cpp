#include "weft/kernels/integrate/moving_frame.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 1000 vertices of three pieces, which move at random, or mostly turn and one of them meets
/// something.
template <class T, bool turns>
struct MovingFrameCase {
  using Scalar = T;
  static constexpr Index count = 1000;
  static constexpr Index pieces = 3;
  Random random{23};
  std::vector<Vec3<T>> positions = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> velocities = random.vectors<T>(count, -10, 10);
  std::vector<Index> component_of_vertex = numbers(count, 7, pieces);
  std::vector<Index> sample = numbers(pieces * moving_frame_samples, 389, count);
  T dt = T(0.0078125);

  MovingFrameCase() {
    if (!turns) return;
    for (std::size_t v = 0; v < velocities.size(); ++v)
      velocities[v] = T(0.1) * velocities[v] + Vec3<T>{3, 0, 1} +
                      cross(Vec3<T>{T(4), T(-9), T(2)}, positions[v]);
  }

  /// `count` numbers below `limit`, not in order.
  static std::vector<Index> numbers(Index count, Index stride, Index limit) {
    std::vector<Index> all;
    for (Index k = 0; k < count; ++k) all.push_back(k * stride % limit);
    return all;
  }

  Outputs compute(Device& device, Index parts) const {
    const auto x = upload(device, positions), v = upload(device, velocities);
    const auto piece = upload(device, component_of_vertex), sample_d = upload(device, sample);
    const Buffer<Vec3<T>> turned(device, count), moved(device, count), rate(device, count),
        guess(device, count), relative(device, count);
    const auto meets = upload(device, std::vector<Index>{0, turns ? 1 : 0, 0});
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             IntegrateMovingFrame<T>{
                 x.span(), v.span(), piece.span().subspan(b, n), sample_d.span(), meets.span(), dt,
                 static_cast<T>(moving_frame_angle_min), begin, turned.span().subspan(b, n),
                 moved.span().subspan(b, n), rate.span().subspan(b, n), guess.span().subspan(b, n),
                 relative.span().subspan(b, n)});
    }
    return {output("turned", download(turned)), output("positions", download(moved)),
            output("velocities", download(rate)), output("guess", download(guess)),
            output("relative", download(relative))};
  }

  Vec3<double> mean_of_samples(const std::vector<Vec3<T>>& values, Index piece) const {
    Vec3<double> mean{};
    for (int k = 0; k < moving_frame_samples; ++k)
      mean += (1.0 / moving_frame_samples) * vec_cast<double>(values[sample_at(piece, k)]);
    return mean;
  }

  std::size_t sample_at(Index piece, int k) const {
    return static_cast<std::size_t>(
        sample[static_cast<std::size_t>(piece * moving_frame_samples + k)]);
  }

  /// Of samples; its inertia is a thousandth larger than it is.
  Vec3<double> spin_of(Index piece) const {
    const Vec3<double> centre = mean_of_samples(positions, piece);
    const Vec3<double> drift = mean_of_samples(velocities, piece);
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
    double squares = 0, energy = 0;
    for (int k = 0; k < moving_frame_samples; ++k) {
      const std::size_t s = sample_at(piece, k);
      const Vec3<double> a = vec_cast<double>(positions[s]) - centre;
      const Vec3<double> u = vec_cast<double>(velocities[s]) - drift;
      const Eigen::Vector3d arm(a[0], a[1], a[2]), relative(u[0], u[1], u[2]);
      inertia += arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose();
      momentum += arm.cross(relative);
      squares += arm.squaredNorm();
      energy += relative.squaredNorm();
    }
    inertia += 0.001 * squares * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d spin = inertia.inverse() * momentum;
    EXPECT_EQ(turns, spin.dot(momentum) > 0.5 * energy);
    return turns && piece != 1 ? Vec3<double>{spin[0], spin[1], spin[2]} : Vec3<double>{};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> turned, moved, rate, guess, relative;
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const Index piece = component_of_vertex[v];
      const Vec3<double> centre = mean_of_samples(positions, piece);
      const Vec3<double> drift = mean_of_samples(velocities, piece), spin = spin_of(piece);
      const Vec3<double> x = vec_cast<double>(positions[v]),
                         start = vec_cast<double>(velocities[v]);
      const double speed = length(spin);
      const double angle = 2 * std::atan(double{dt} * speed / 2);
      const auto turn = [&](const Vec3<double>& a) {
        if (!(speed > 0)) return a;
        const Eigen::Vector3d axis(spin[0] / speed, spin[1] / speed, spin[2] / speed);
        const Eigen::Vector3d b =
            Eigen::AngleAxisd(angle, axis) * Eigen::Vector3d(a[0], a[1], a[2]);
        return Vec3<double>{b[0], b[1], b[2]};
      };
      const Vec3<double> arm = x - centre;
      turned.push_back(centre + turn(arm));
      moved.push_back(turned.back() + double{dt} * drift);
      rate.push_back((1 / double{dt}) * (moved.back() - x));
      relative.push_back(turn(start - drift - cross(spin, arm)));
      guess.push_back(rate.back() + relative.back());
    }
    return {output("turned", turned), output("positions", moved), output("velocities", rate),
            output("guess", guess), output("relative", relative)};
  }
};

using Cases = testing::Types<MovingFrameCase<float, false>, MovingFrameCase<double, false>,
                             MovingFrameCase<float, true>, MovingFrameCase<double, true>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateMovingFrame, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
