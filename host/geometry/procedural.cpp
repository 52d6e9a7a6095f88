#include "weft/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <unordered_map>

#include "host/geometry/add_cell.hpp"
#include "weft/core/assert.hpp"

namespace weft {
namespace {

/// Coordinate of lattice line i of n, exactly antisymmetric about the centre.
double lattice(double size, Index i, Index n) {
  return size * (static_cast<double>(2 * std::int64_t{i} - n) / (2.0 * n));
}

/// Two triangles of a cell with corners counter-clockwise from the lower left.
/// Numbers the lattice points on the surface of a box as they are met.
class BoxSurface {
 public:
  BoxSurface(const Vec3<double>& size, const std::array<Index, 3>& cells)
      : size_(size), cells_(cells) {}

  /// One side: `axis` is its normal, towards + or -.
  void add_side(int axis, bool positive) {
    const auto a = static_cast<std::size_t>(axis);
    // u, v, axis is a right-handed frame, or a left-handed one on the negative side.
    std::size_t u = (a + 1) % 3;
    std::size_t v = (a + 2) % 3;
    if (!positive) std::swap(u, v);
    std::array<Index, 3> at{};
    at[a] = positive ? cells_[a] : 0;
    for (Index j = 0; j < cells_[v]; ++j)
      for (Index i = 0; i < cells_[u]; ++i) {
        std::array<Index, 4> corners{};
        for (std::size_t k = 0; k < 4; ++k) {
          at[u] = i + (k == 1 || k == 2 ? 1 : 0);
          at[v] = j + (k >= 2 ? 1 : 0);
          corners[k] = vertex(at);
        }
        add_cell(mesh.triangles, corners, (i + j) % 2 != 0);
      }
  }

  Mesh mesh;

 private:
  Index vertex(const std::array<Index, 3>& at) {
    const std::uint64_t key =
        (static_cast<std::uint64_t>(at[0]) * (static_cast<std::uint64_t>(cells_[1]) + 1) +
         static_cast<std::uint64_t>(at[1])) *
            (static_cast<std::uint64_t>(cells_[2]) + 1) +
        static_cast<std::uint64_t>(at[2]);
    const auto [entry, is_new] =
        numbers_.try_emplace(key, static_cast<Index>(mesh.positions.size()));
    if (is_new)
      mesh.positions.push_back({lattice(size_[0], at[0], cells_[0]),
                                lattice(size_[1], at[1], cells_[1]),
                                lattice(size_[2], at[2], cells_[2])});
    return entry->second;
  }

  Vec3<double> size_;
  std::array<Index, 3> cells_;
  std::unordered_map<std::uint64_t, Index> numbers_;
};

Mesh unit_icosahedron() {
  const double scale = 1.0 / std::sqrt(1.0 + std::numbers::phi * std::numbers::phi);
  const double a = scale;
  const double b = std::numbers::phi * scale;
  Mesh mesh;
  mesh.positions = {{-a, b, 0},  {a, b, 0},  {-a, -b, 0}, {a, -b, 0}, {0, -a, b},  {0, a, b},
                    {0, -a, -b}, {0, a, -b}, {b, 0, -a},  {b, 0, a},  {-b, 0, -a}, {-b, 0, a}};
  mesh.triangles = {{{0, 11, 5}}, {{0, 5, 1}},  {{0, 1, 7}},   {{0, 7, 10}}, {{0, 10, 11}},
                    {{1, 5, 9}},  {{5, 11, 4}}, {{11, 10, 2}}, {{10, 7, 6}}, {{7, 1, 8}},
                    {{3, 9, 4}},  {{3, 4, 2}},  {{3, 2, 6}},   {{3, 6, 8}},  {{3, 8, 9}},
                    {{4, 9, 5}},  {{2, 4, 11}}, {{6, 2, 10}},  {{8, 6, 7}},  {{9, 8, 1}}};
  return mesh;
}

/// Splits each triangle of a mesh on the unit sphere in four.
void subdivide(Mesh& mesh) {
  std::unordered_map<std::uint64_t, Index> middles;
  middles.reserve(mesh.triangles.size() * 2);
  const auto middle = [&](Index p, Index q) {
    const auto [low, high] = std::minmax(p, q);
    const std::uint64_t key =
        (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint64_t>(high);
    const auto [entry, is_new] =
        middles.try_emplace(key, static_cast<Index>(mesh.positions.size()));
    if (is_new) {
      const Vec3<double> sum = mesh.positions[static_cast<std::size_t>(low)] +
                               mesh.positions[static_cast<std::size_t>(high)];
      mesh.positions.push_back(sum * (1.0 / length(sum)));
    }
    return entry->second;
  };
  std::vector<Tri> finer;
  finer.reserve(mesh.triangles.size() * 4);
  for (const Tri& t : mesh.triangles) {
    const Index m01 = middle(t.v[0], t.v[1]);
    const Index m12 = middle(t.v[1], t.v[2]);
    const Index m20 = middle(t.v[2], t.v[0]);
    finer.push_back({{t.v[0], m01, m20}});
    finer.push_back({{m01, t.v[1], m12}});
    finer.push_back({{m20, m12, t.v[2]}});
    finer.push_back({{m01, m12, m20}});
  }
  mesh.triangles = std::move(finer);
}

/// Adds vertices on a circle about the z axis, counter-clockwise.
/// @param phase [rad] where the first one is
void add_ring(Mesh& mesh, Index count, double radius, double z, double phase) {
  for (Index i = 0; i < count; ++i) {
    const double angle = phase + 2 * std::numbers::pi * i / count;
    mesh.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
  }
}

/// Triangles between ring k - 1 and ring k around a pole, which is ring 0, of which ring k has
/// sectors * k vertices. Counter-clockwise seen from above, if the rings are.
void add_fan(std::vector<Tri>& triangles, Index sectors, Index k, Index inner, Index outer,
             bool mirrored) {
  const Index inner_count = std::max<Index>(sectors * (k - 1), 1);
  const Index outer_count = sectors * k;
  const auto add = [&](Index a, Index b, Index c) {
    triangles.push_back(mirrored ? Tri{{a, c, b}} : Tri{{a, b, c}});
  };
  for (Index s = 0; s < sectors; ++s)
    for (Index i = 0; i < k; ++i) {
      const Index in = inner + (s * (k - 1) + i) % inner_count;
      const Index next_out = outer + (s * k + i + 1) % outer_count;
      add(in, outer + s * k + i, next_out);
      if (i + 1 < k) add(in, next_out, inner + (s * (k - 1) + i + 1) % inner_count);
    }
}

/// Sectors of a capsule's caps, as of an icosahedron.
constexpr Index capsule_sectors = 5;

/// Rows of a capsule's tube, whose triangles would be equilateral if length allowed it.
Index capsule_rows(double radius, double length, Index rings) {
  const double side = 2 * std::numbers::pi * radius / (capsule_sectors * rings);
  return static_cast<Index>(std::round(length / (side * std::numbers::sqrt3 / 2)));
}

}  // namespace

Mesh make_grid(const Vec2<double>& size, const std::array<Index, 2>& cells, Diagonals diagonals) {
  const auto [nx, ny] = cells;
  WEFT_ASSERT(nx >= 1 && ny >= 1);
  Mesh mesh;
  const auto count = static_cast<std::size_t>(nx + 1) * static_cast<std::size_t>(ny + 1);
  mesh.positions.reserve(count);
  mesh.material.reserve(count);
  mesh.triangles.reserve(2 * static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny));
  for (Index j = 0; j <= ny; ++j)
    for (Index i = 0; i <= nx; ++i) {
      const Vec2<double> at{lattice(size[0], i, nx), lattice(size[1], j, ny)};
      mesh.positions.push_back({at[0], at[1], 0});
      mesh.material.push_back(at);
    }
  for (Index j = 0; j < ny; ++j)
    for (Index i = 0; i < nx; ++i)
      add_cell(mesh.triangles,
               {grid_vertex(nx, i, j), grid_vertex(nx, i + 1, j), grid_vertex(nx, i + 1, j + 1),
                grid_vertex(nx, i, j + 1)},
               diagonals == Diagonals::alternating && (i + j) % 2 != 0);
  return mesh;
}

Mesh make_icosphere(double radius, int subdivisions) {
  WEFT_ASSERT(subdivisions >= 0 && subdivisions <= 10);
  Mesh mesh = unit_icosahedron();
  for (int s = 0; s < subdivisions; ++s) subdivide(mesh);
  for (Vec3<double>& x : mesh.positions) x *= radius;
  return mesh;
}

Mesh make_box(const Vec3<double>& size, const std::array<Index, 3>& cells) {
  BoxSurface surface(size, cells);
  for (int axis = 0; axis < 3; ++axis) {
    surface.add_side(axis, false);
    surface.add_side(axis, true);
  }
  return std::move(surface.mesh);
}

double capsule_triangles(double radius, double length, Index rings) {
  const double around = static_cast<double>(capsule_sectors) * rings;
  const double side = 2 * std::numbers::pi * radius / around;
  return 2 * around * rings + 2 * around * std::round(length / (side * std::numbers::sqrt3 / 2));
}

Mesh make_capsule(double radius, double length, Index rings) {
  WEFT_ASSERT(rings >= 1);
  const Index around = capsule_sectors * rings;
  const Index rows = capsule_rows(radius, length, rings);
  const auto polar = [&](Index k) { return std::numbers::pi / 2 * k / rings; };
  Mesh mesh;
  mesh.positions.push_back({0, 0, -length / 2 - radius});
  Index below = 0;
  for (Index k = 1; k <= rings; ++k) {
    const auto ring = static_cast<Index>(mesh.positions.size());
    if (k < rings)
      add_ring(mesh, capsule_sectors * k, radius * std::sin(polar(k)),
               -length / 2 - radius * std::cos(polar(k)), 0);
    else
      add_ring(mesh, around, radius, rows == 0 ? 0 : -length / 2, 0);
    add_fan(mesh.triangles, capsule_sectors, k, below, ring, true);
    below = ring;
  }
  for (Index j = 1; j <= rows; ++j) {
    const auto ring = static_cast<Index>(mesh.positions.size());
    add_ring(mesh, around, radius, length * (static_cast<double>(j) / rows - 0.5),
             std::numbers::pi * j / around);
    for (Index i = 0; i < around; ++i) {
      const Index next = (i + 1) % around;
      mesh.triangles.push_back({{below + i, below + next, ring + i}});
      mesh.triangles.push_back({{below + next, ring + next, ring + i}});
    }
    below = ring;
  }
  for (Index k = rings; k >= 1; --k) {
    const auto ring = static_cast<Index>(mesh.positions.size());
    if (k > 1)
      add_ring(mesh, capsule_sectors * (k - 1), radius * std::sin(polar(k - 1)),
               length / 2 + radius * std::cos(polar(k - 1)), std::numbers::pi * rows / around);
    else
      mesh.positions.push_back({0, 0, length / 2 + radius});
    add_fan(mesh.triangles, capsule_sectors, k, ring, below, false);
    below = ring;
  }
  return mesh;
}

Mesh make_disc(double radius, Index rings) {
  WEFT_ASSERT(rings >= 1);
  constexpr Index sectors = 6;
  Mesh mesh;
  mesh.positions.push_back({0, 0, 0});
  Index inner = 0;
  for (Index k = 1; k <= rings; ++k) {
    const auto ring = static_cast<Index>(mesh.positions.size());
    add_ring(mesh, sectors * k, radius * k / rings, 0, 0);
    add_fan(mesh.triangles, sectors, k, inner, ring, false);
    inner = ring;
  }
  for (const Vec3<double>& x : mesh.positions) mesh.material.push_back({x[0], x[1]});
  return mesh;
}

Index annulus_start(double inner, double outer, Index rings) {
  // More than any mesh can have still is a number.
  constexpr double most = 1e8;
  return static_cast<Index>(std::clamp(std::round(inner / (outer - inner) * rings), 1.0, most));
}

Mesh make_annulus(double inner, double outer, Index rings) {
  WEFT_ASSERT(inner > 0 && inner < outer && rings >= 1);
  constexpr Index sectors = 6;
  const Index start = annulus_start(inner, outer, rings);
  Mesh mesh;
  Index below = 0;
  for (Index k = 0; k <= rings; ++k) {
    const auto ring = static_cast<Index>(mesh.positions.size());
    const double share = static_cast<double>(k) / rings;
    add_ring(mesh, sectors * (start + k), inner * (1 - share) + outer * share, 0, 0);
    if (k > 0) add_fan(mesh.triangles, sectors, start + k, below, ring, false);
    below = ring;
  }
  for (const Vec3<double>& x : mesh.positions) mesh.material.push_back({x[0], x[1]});
  return mesh;
}

Mesh make_tube(double radius, double height, const std::array<Index, 2>& cells) {
  const auto [around, along] = cells;
  WEFT_ASSERT(around >= 3 && along >= 1);
  const double width = 2 * radius * around * std::sin(std::numbers::pi / around);
  Mesh mesh;
  for (Index j = 0; j <= along; ++j) {
    const double z = lattice(height, j, along);
    add_ring(mesh, around, radius, z, 0);
    for (Index i = 0; i <= around; ++i) mesh.material.push_back({lattice(width, i, around), z});
  }
  for (Index j = 0; j < along; ++j)
    for (Index i = 0; i < around; ++i) {
      const Index next = (i + 1) % around;
      const bool mirrored = (i + j) % 2 != 0;
      add_cell(mesh.triangles,
               {j * around + i, j * around + next, (j + 1) * around + next, (j + 1) * around + i},
               mirrored);
      add_cell(mesh.material_triangles,
               {grid_vertex(around, i, j), grid_vertex(around, i + 1, j),
                grid_vertex(around, i + 1, j + 1), grid_vertex(around, i, j + 1)},
               mirrored);
    }
  return mesh;
}

double icosphere_edge(int subdivisions) {
  // The icosahedron's edge is 1.0515 of the radius. Each split halves the chord, but the new
  // vertices are pushed out to the sphere, which lengthens the mean edge to 1.20 of the radius
  // over 2^subdivisions in the limit.
  constexpr std::array<double, 3> coarse{1.0515, 0.5823, 0.2983};
  if (subdivisions < 3) return coarse[static_cast<std::size_t>(std::max(subdivisions, 0))];
  return 1.20 / std::pow(2.0, subdivisions);
}

}  // namespace weft
