#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/rotation.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// [rad] Rotations that are left to the solve: it takes them for strains below 1e-6.
constexpr double moving_frame_angle_min = 1e-3;

/// Vertices of a component of cloth whose mean motion is taken for that of the piece as a whole.
constexpr int moving_frame_samples = 16;

/// First iterate of the linearly implicit step: every component of cloth where it starts, moved
/// along as a rigid body by its mean velocity V and, if that is most of what its samples move
/// otherwise and it meets nothing else, its mean angular velocity w about their centre c:
/// x_k = c + R (x_n - c) + dt V, with R Cayley's rotation by some dt w.
///
/// No element sees a translation, so that the solution about x_k is that about c + R (x_n - c); but
/// it is v_{n+1} - v_k that is solved for. Its differences between neighbours would be rounded in
/// proportion to V otherwise, and stretching of small triangles that fly multiplies that to more
/// than their weight. A linear system about x_n itself takes a rotation by an angle a for a strain
/// of a^2 / 2, which stiff cloth takes back in the next step: sheets that spin lose several times
/// the energy that they lose with implicit Euler.
/// Reads: positions and velocities of the samples and of its own vertex. Writes: own vertex.
/// Order: samples in their order. Ghosts: none (every rank does all vertices). Flags: none.
template <class T>
struct IntegrateMovingFrame {
  Span<const Vec3<T>> positions;          ///< [all cloth vertices] [m] x_n
  Span<const Vec3<T>> velocities;         ///< [all cloth vertices] [m/s] v_n
  Span<const Index> component_of_vertex;  ///< [cloth vertices]
  Span<const Index> sample;               ///< [moving_frame_samples * pieces] vertices
  Span<const Index> meets;                ///< [pieces] 1: does not turn; empty: all may
  T dt;                                   ///< [s]
  T angle_min;                            ///< [rad] components turn by more in dt, or not at all
  Index begin = 0;                        ///< first vertex
  Span<Vec3<T>> turned_positions;         ///< [cloth vertices] [m] x_k - dt V
  Span<Vec3<T>> iterate_positions;        ///< [cloth vertices] [m] x_k
  Span<Vec3<T>> iterate_velocities;       ///< [cloth vertices] [m/s] (x_k - x_n) / dt
  /// [cloth vertices] [m/s] the same and, turned by R, what the vertex has beyond V + w x (x_n - c)
  Span<Vec3<T>> turned_velocities;
  /// [cloth vertices] [m/s] velocities relative to the frame, turned by R
  Span<Vec3<T>> relative_velocities;

  WEFT_HD Index count() const noexcept { return static_cast<Index>(component_of_vertex.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(i);
    const auto first = static_cast<std::size_t>(component_of_vertex[v]) *
                       static_cast<std::size_t>(moving_frame_samples);
    Vec3<T> velocity_sum{}, position_sum{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(moving_frame_samples); ++k) {
      const auto s = static_cast<std::size_t>(sample[first + k]);
      velocity_sum += velocities[s];
      position_sum += positions[s];
    }
    const Vec3<T> drift = (T(1) / T(moving_frame_samples)) * velocity_sum;
    const Vec3<T> centre = (T(1) / T(moving_frame_samples)) * position_sum;
    const Vec3<T>& x = positions[static_cast<std::size_t>(begin) + v];
    const Vec3<T>& start = velocities[static_cast<std::size_t>(begin) + v];
    turned_positions[v] = x;
    iterate_positions[v] = x + dt * drift;
    iterate_velocities[v] = drift;
    turned_velocities[v] = start;
    relative_velocities[v] = start - drift;
    if (!meets.empty() && meets[static_cast<std::size_t>(component_of_vertex[v])] != 0) return;
    const Vec3<T> spin = angular_velocity(first, centre, drift);
    if (!(dt * length(spin) > angle_min)) return;
    const Vec3<T> arm = x - centre;
    const Vec3<T> turned_arm = turn(arm, spin);
    turned_positions[v] = centre + turned_arm;
    iterate_positions[v] = turned_positions[v] + dt * drift;
    iterate_velocities[v] = drift + (T(1) / dt) * (turned_arm - arm);
    relative_velocities[v] = turn(start - drift - cross(spin, arm), spin);
    turned_velocities[v] = iterate_velocities[v] + relative_velocities[v];
  }

 private:
  /// That with which samples of equal masses have their angular momentum about the centre; 0 if
  /// they move otherwise for the most part. [rad/s]
  WEFT_HD Vec3<T> angular_velocity(std::size_t first, const Vec3<T>& centre,
                                   const Vec3<T>& drift) const noexcept {
    Vec3<T> momentum{};
    Mat3<T> spread{};
    T energy = T(0);
    for (std::size_t k = 0; k < static_cast<std::size_t>(moving_frame_samples); ++k) {
      const auto s = static_cast<std::size_t>(sample[first + k]);
      const Vec3<T> arm = positions[s] - centre;
      const Vec3<T> relative = velocities[s] - drift;
      momentum += cross(arm, relative);
      spread += outer(arm, arm);
      energy += dot(relative, relative);
    }
    // A thousandth more than the inertia is: samples on a line leave it singular.
    const T trace = spread(0, 0) + spread(1, 1) + spread(2, 2);
    const Vec3<T> spin =
        inverse_symmetric(T(1.001) * trace * Mat3<T>::identity() - spread) * momentum;
    return dot(spin, momentum) > energy / T(2) ? spin : Vec3<T>{};
  }

  WEFT_HD Vec3<T> turn(const Vec3<T>& x, const Vec3<T>& spin) const noexcept {
    return cayley_turned(x, (dt / T(2)) * spin);
  }
};

}  // namespace weft
