#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "host/scene/surfaces.hpp"
#include "host/untangle/contour.hpp"
#include "weft/shapes.hpp"

/// Surfaces that run through each other.
namespace weft::test {

using Point = Vec3<double>;

/// A grid of n x n cells and `size` m in the xy plane, each vertex taken elsewhere.
inline Mesh bent_grid(Index n, double size, const std::function<Point(const Point&)>& place) {
  Mesh mesh = make_grid({size, size}, {n, n}, Diagonals::alternating);
  for (Point& x : mesh.positions) x = place(x);
  return mesh;
}

inline Mesh flat_grid(Index n, double size, const Point& centre) {
  return bent_grid(n, size, [&](const Point& x) { return x + centre; });
}

inline Mesh moved(Mesh mesh, const Point& way) {
  for (Point& x : mesh.positions) x += way;
  return mesh;
}

/// All cloths, then all obstacles.
/// @param held cloth vertices that do not move, by cloth and position
inline IntersectingSurfaces tangled(
    const std::vector<Mesh>& cloths, const std::vector<Mesh>& obstacles = {},
    const std::function<bool(std::size_t, const Point&)>& held = nullptr) {
  IntersectingSurfaces s;
  const auto add = [&](const Mesh& mesh, std::size_t number) {
    const auto first = static_cast<Index>(s.points.size());
    for (const Point& x : mesh.positions) {
      s.points.push_back(x);
      const bool fixed = number >= cloths.size() || (held && held(number, x));
      s.inverse_mass.push_back(fixed ? 0 : 1);
    }
    for (const Tri& t : mesh.triangles) {
      s.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
      s.mesh.push_back(static_cast<Index>(number));
    }
    s.solid.push_back(number >= cloths.size() && is_closed(mesh));
  };
  for (std::size_t i = 0; i < cloths.size(); ++i) add(cloths[i], i);
  s.cloth_triangle_count = static_cast<Index>(s.triangles.size());
  for (std::size_t i = 0; i < obstacles.size(); ++i) add(obstacles[i], cloths.size() + i);
  return s;
}

/// Contours of surfaces as they stand.
inline Contours contours_of(const IntersectingSurfaces& s) {
  const SurfaceTopology topology(s.triangles, s.points.size());
  const std::vector<unsigned char> awake(s.points.size(), 1);
  return ContourSearch(s, topology).find(awake);
}

// ---- intersections; none of them is symmetric, so that nothing lies exactly on anything

inline Mesh cone() {
  return bent_grid(24, 1, [](const Point& x) {
    const double r = std::hypot(x[0] + 0.01, x[1] + 0.02);
    return Point{x[0] + 0.011, x[1] + 0.007, -0.1 + std::max(0.0, 0.3 - r)};
  });
}

/// A ridge along y that ends in borders.
inline Mesh ridge() {
  return bent_grid(24, 1, [](const Point& x) {
    return Point{x[0] * 0.6 + 0.011, x[1] * 0.8 + 0.003,
                 -0.1 + 0.2 * std::exp(-std::pow(x[0] / 0.1, 2))};
  });
}

inline Mesh tilted_grid(Index n, double angle, const Point& shift) {
  return bent_grid(n, 1, [&](const Point& x) {
    const Point y = x + shift;
    return Point{y[0] * std::cos(angle) - y[2] * std::sin(angle) + 0.013, y[1] + 0.007,
                 y[0] * std::sin(angle) + y[2] * std::cos(angle) + 0.0031};
  });
}

/// Crosses the border of a sheet of 1 m, and that sheet crosses its border.
inline Mesh beside() {
  return bent_grid(20, 1, [](const Point& x) {
    return Point{x[0] + 0.803, 0.99 * x[1] + 0.313, 0.3 * (x[1] + 0.383) * std::cos(2 * x[0])};
  });
}

inline Mesh wavy(double along_x, double along_y, double phase, double height) {
  return bent_grid(20, 1, [=](const Point& x) {
    return Point{x[0] + 0.01 + phase / 100, x[1] + 0.02,
                 height + 0.04 * std::sin(along_x * x[0] + along_y * x[1] + phase)};
  });
}

/// A sheet that runs through itself all over: waves of random direction and size on half of it.
inline Mesh crumpled(unsigned seed, int waves, double size) {
  unsigned state = seed;
  const auto random = [&] {  // -1 to 1; the same everywhere, which std::mt19937's adaptors are not
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / (1 << 23) - 1;
  };
  struct Wave {
    double x, y, phase, size;
    int axis;
  };
  std::vector<Wave> all;
  for (int i = 0; i < waves; ++i) {
    Wave wave{};
    wave.x = 10 * random();
    wave.y = 10 * random();
    wave.phase = 3 * random();
    wave.size = size * random();
    wave.axis = i % 3;
    all.push_back(wave);
  }
  return bent_grid(30, 1, [&](const Point& x) {
    Point y = x * 0.5;
    for (const Wave& w : all) y[w.axis] += w.size * std::sin(w.x * x[0] + w.y * x[1] + w.phase);
    return y;
  });
}

/// A strip, bent but hardly stretched, whose profile crosses itself as a loop does.
inline Mesh looped(double turn) {
  constexpr Index n = 64;
  Mesh mesh = make_grid({1.6, 0.4}, {n, 16}, Diagonals::alternating);
  for (Point& x : mesh.positions) {
    // The angle of the profile is that of a loop, a little tighter towards one border.
    Point y{0, x[1], 0.03 * x[1]};
    const int steps = 200;
    for (int i = 0; i < steps; ++i) {
      const double s = x[0] * (i + 0.5) / steps;
      const double angle = turn * (1 + 0.1 * x[1]) * std::tanh(6 * s);
      y[0] += x[0] / steps * std::cos(angle);
      y[2] += x[0] / steps * std::sin(angle);
    }
    x = y;
  }
  return mesh;
}

/// Several meshes as one, which then runs through itself.
inline Mesh as_one(const std::vector<Mesh>& parts) {
  Mesh all;
  for (const Mesh& part : parts) {
    const auto first = static_cast<Index>(all.positions.size());
    all.positions.insert(all.positions.end(), part.positions.begin(), part.positions.end());
    for (const Tri& t : part.triangles)
      all.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
  }
  return all;
}

/// Head, neck and shoulders, which overlap.
inline std::vector<Mesh> bust() {
  Mesh shoulders = make_capsule(0.07, 0.3, 8);
  for (Point& x : shoulders.positions) x = {x[2], x[0], x[1] - 0.3};
  return {make_icosphere(0.11, 4), moved(make_capsule(0.06, 0.2, 8), {0, 0, -0.15}), shoulders};
}

/// A hood of 6 rings^2 triangles that closes below a head of 0.11 m, out of place by `shift`.
inline Mesh hood(Index rings, const Point& shift) {
  constexpr double radius = 0.12, opening = 0.08, turn = 1.9;
  Mesh mesh = make_disc(1, rings);
  for (Point& x : mesh.positions) {
    const double s = std::hypot(x[0], x[1]);
    const double angle = std::min(s / 0.6, 1.0) * turn;
    const double skirt = std::max(s - 0.6, 0.0) / 0.4;
    const double r = radius * std::sin(angle) * (1 - skirt) + opening * skirt;
    const double around = std::atan2(x[1], x[0]);
    x = Point{r * std::cos(around), r * std::sin(around), radius * std::cos(angle) - 0.16 * skirt} +
        shift;
  }
  return mesh;
}

/// Five pleats whose layers lean on each other and cross in waves, n^2 triangles.
inline Mesh pleats(Index n) {
  Mesh mesh = make_grid({1, 0.5}, {n, n / 2}, Diagonals::alternating);
  for (Point& x : mesh.positions) {
    const double place = 5 * (x[0] + 0.5);
    const double layer = std::floor(place);
    const double along = place - layer;
    const double up = std::fmod(layer, 2) == 0 ? along : 1 - along;
    x = {0.01 * up + 0.004 * place + 0.004 * std::sin(40 * x[1] + 1.3 * layer), x[1], 0.1 * up};
  }
  return mesh;
}

}  // namespace weft::test
