#include "benchmarks/physics/sheets.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "benchmarks/physics/delaunay.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::physics {
namespace {

using Point = Vec2<double>;

/// Uniform in [0, 1), the same for every standard library.
double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

/// How the body of the sheet is cut up.
struct Pattern {
  double spacing_x;  ///< [m]
  double spacing_y;  ///< [m]
  int rows;          ///< of cells across the width
};

Pattern pattern_of(const SheetShape& s, double aspect) {
  const double dx = s.length / s.cells;
  const int rows = std::max(1, static_cast<int>(std::lround(s.width / dx * aspect)));
  return {dx, s.width / rows, rows};
}

/// Appends columns of aligned cells between x0 and x1, sharing vertices that are there already.
void add_columns(Mesh& mesh, const SheetShape& s, int rows, double x0, double x1, int columns) {
  std::map<std::pair<long long, long long>, Index> known;
  const double grain = s.width / rows * 1e-3;
  const auto key = [&](double x, double y) {
    return std::pair(std::llround(x / grain), std::llround(y / grain));
  };
  for (std::size_t v = 0; v < mesh.material.size(); ++v)
    known[key(mesh.material[v][0], mesh.material[v][1])] = static_cast<Index>(v);
  const auto vertex = [&](int i, int j) {
    const Point p{x0 + (x1 - x0) * i / columns, -s.width / 2 + s.width * j / rows};
    const auto [found, is_new] =
        known.try_emplace(key(p[0], p[1]), static_cast<Index>(mesh.material.size()));
    if (is_new) mesh.material.push_back(p);
    return found->second;
  };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Index a = vertex(i, j);
      const Index b = vertex(i + 1, j);
      const Index c = vertex(i + 1, j + 1);
      const Index d = vertex(i, j + 1);
      if (s.mirrored && 2 * j >= rows) {
        mesh.triangles.push_back({{a, b, d}});
        mesh.triangles.push_back({{b, c, d}});
      } else {
        mesh.triangles.push_back({{a, b, c}});
        mesh.triangles.push_back({{a, c, d}});
      }
    }
}

/// A lattice of squares turned by `angle`, without what comes too close to the sides.
std::vector<Point> lattice_points(const SheetShape& s, double d, double angle) {
  const double c = std::cos(angle);
  const double n = std::sin(angle);
  const int reach = static_cast<int>((s.length + s.width) / d) + 2;
  std::vector<Point> points;
  for (int j = -reach; j <= reach; ++j)
    for (int i = -reach; i <= reach; ++i) {
      const Point p{s.length / 2 + d * (c * i - n * j), d * (n * i + c * j)};
      if (p[0] >= 0.5 * d && p[0] <= s.length - 0.5 * d && std::abs(p[1]) <= s.width / 2 - 0.5 * d)
        points.push_back(p);
    }
  return points;
}

std::vector<Point> jittered_points(const SheetShape& s, const Pattern& pattern, double jitter,
                                   std::mt19937_64& random) {
  std::vector<Point> points;
  for (int j = 1; j < pattern.rows; ++j)
    for (int i = 1; i < s.cells; ++i) {
      const double u = jitter * (2 * uniform(random) - 1);
      const double v = jitter * (2 * uniform(random) - 1);
      points.push_back({pattern.spacing_x * (i + u), pattern.spacing_y * (j + v) - s.width / 2});
    }
  return points;
}

/// Darts that are thrown until hardly any finds a place (Cook 1986): about one a square of side d.
std::vector<Point> random_points(const SheetShape& s, double d, std::mt19937_64& random) {
  const double radius = 0.84 * d;
  std::map<std::pair<int, int>, std::vector<Point>> cells;
  const auto cell = [&](const Point& p) {
    return std::pair(static_cast<int>(std::floor(p[0] / radius)),
                     static_cast<int>(std::floor(p[1] / radius)));
  };
  std::vector<Point> points;
  const auto darts = static_cast<long>(60 * s.length * s.width / (d * d));
  for (long n = 0; n < darts; ++n) {
    const double x = 0.5 * d + uniform(random) * (s.length - d);
    const double y = (uniform(random) - 0.5) * (s.width - d);
    const auto [i, j] = cell({x, y});
    bool free = s.width > d;
    for (int a = -1; a <= 1; ++a)
      for (int b = -1; b <= 1; ++b)
        if (const auto found = cells.find({i + a, j + b}); found != cells.end())
          for (const Point& p : found->second) free = free && length(p - Point{x, y}) >= radius;
    if (!free) continue;
    cells[{i, j}].push_back({x, y});
    points.push_back({x, y});
  }
  // Neighbours in turn, so that the triangulation does not have far to walk.
  std::sort(points.begin(), points.end(), [&](const Point& p, const Point& q) {
    return std::pair(cell(p), p[1]) < std::pair(cell(q), q[1]);
  });
  return points;
}

/// The body of the sheet around given points, its sides evenly divided.
Mesh triangulated(const SheetShape& s, const Pattern& pattern, const std::vector<Point>& within) {
  const double y = s.width / 2;
  Mesh mesh;
  mesh.material = {{0, -y}, {s.length, -y}, {s.length, y}, {0, y}};
  for (int i = 1; i < s.cells; ++i)
    for (const double side : {-y, y}) mesh.material.push_back({pattern.spacing_x * i, side});
  for (int j = 1; j < pattern.rows; ++j)
    for (const double side : {0.0, s.length})
      mesh.material.push_back({side, pattern.spacing_y * j - y});
  const std::size_t on_sides = mesh.material.size() - 4;
  mesh.material.insert(mesh.material.end(), within.begin(), within.end());
  mesh.triangles = triangulate_rectangle(mesh.material, on_sides);
  return mesh;
}

Mesh read_sheet(const std::string& path) {
  Mesh mesh = io::read_mesh(path);
  if (mesh.material.empty() || !mesh.material_triangles.empty()) {
    mesh.material.clear();
    mesh.material_triangles.clear();
    for (const auto& p : mesh.positions) {
      if (std::abs(p[2]) > 1e-9)
        throw SceneError(path, "mesh", "a mesh that is not flat", "a mesh in the xy plane");
      mesh.material.push_back({p[0], p[1]});
    }
  }
  return mesh;
}

}  // namespace

std::vector<Parameter> mesh_parameters() {
  return {{"mesh", "aligned", "aligned, rotated, irregular, random, aniso, or FILE.obj"},
          {"aspect", "4", "aniso: length of a cell along x over that along y"},
          {"angle", "30", "rotated: [degrees]"},
          {"jitter", "0.3", "irregular: largest displacement, in cells"},
          {"seed", "1", "irregular, random"}};
}

Mesh make_sheet(const SheetShape& s, const Parameters& parameters) {
  const std::string& kind = parameters.text("mesh");
  Mesh mesh;
  if (kind.ends_with(".obj")) {
    mesh = read_sheet(kind);
  } else {
    parameters.one_of("mesh", {"aligned", "rotated", "irregular", "random", "aniso"});
    const Pattern pattern = pattern_of(s, kind == "aniso" ? parameters.positive("aspect") : 1);
    std::mt19937_64 random(static_cast<std::uint64_t>(parameters.count("seed", 0)));
    if (kind == "rotated")
      mesh = triangulated(s, pattern,
                          lattice_points(s, pattern.spacing_x,
                                         parameters.number("angle") * std::numbers::pi / 180));
    else if (kind == "irregular")
      mesh = triangulated(s, pattern,
                          jittered_points(s, pattern, parameters.number("jitter"), random));
    else if (kind == "random")
      mesh = triangulated(s, pattern, random_points(s, pattern.spacing_x, random));
    else
      add_columns(mesh, s, pattern.rows, 0, s.length, s.cells);
    const double before = s.columns_before * pattern.spacing_x;
    const double after = s.columns_after * pattern.spacing_x;
    if (s.columns_before > 0) add_columns(mesh, s, pattern.rows, -before, 0, s.columns_before);
    if (s.columns_after > 0)
      add_columns(mesh, s, pattern.rows, s.length, s.length + after, s.columns_after);
  }
  mesh.positions.clear();
  for (const Point& p : mesh.material) mesh.positions.push_back({p[0], p[1], 0});
  return mesh;
}

std::vector<Index> vertices_where(const Mesh& mesh,
                                  const std::function<bool(const Vec2<double>&)>& condition) {
  std::vector<Index> found;
  for (std::size_t v = 0; v < mesh.material.size(); ++v)
    if (condition(mesh.material[v])) found.push_back(static_cast<Index>(v));
  return found;
}

namespace {

double slack(const Mesh& mesh) {
  double largest = 0;
  for (const Point& p : mesh.material)
    largest = std::max({largest, std::abs(p[0]), std::abs(p[1])});
  return 1e-6 * largest;
}

}  // namespace

std::vector<Index> vertices_before(const Mesh& mesh, double limit) {
  return vertices_where(mesh, [x = limit + slack(mesh)](const Point& p) { return p[0] <= x; });
}

std::vector<Index> vertices_after(const Mesh& mesh, double limit) {
  return vertices_where(mesh, [x = limit - slack(mesh)](const Point& p) { return p[0] >= x; });
}

std::vector<Index> outline(const Mesh& mesh) {
  std::map<std::pair<Index, Index>, int> uses;
  for (const Tri& t : mesh.triangles)
    for (int j = 0; j < 3; ++j) ++uses[std::minmax(t.v[j], t.v[(j + 1) % 3])];
  std::set<Index> found;
  for (const auto& [edge, count] : uses)
    if (count == 1) found.insert({edge.first, edge.second});
  return {found.begin(), found.end()};
}

std::vector<double> vertex_areas(const Mesh& mesh) {
  std::vector<double> areas(mesh.material.size());
  for (const Tri& t : mesh.triangles) {
    const Point a = mesh.material[at(t.v[1])] - mesh.material[at(t.v[0])];
    const Point b = mesh.material[at(t.v[2])] - mesh.material[at(t.v[0])];
    for (const Index v : t.v) areas[at(v)] += (a[0] * b[1] - a[1] * b[0]) / 6;
  }
  return areas;
}

}  // namespace weft::physics
