#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "host/lab/chart/compare.hpp"
#include "weft/core/at.hpp"

namespace weft::lab {
namespace {

/// Corners of a triangle in material space.
const Tri& material_corners(const Mesh& mesh, std::size_t triangle) {
  return mesh.material_triangles.empty() ? mesh.triangles[triangle]
                                         : mesh.material_triangles[triangle];
}

/// Number of the connected piece of each vertex, in the order of their first vertices.
/// @return how many there are
Index find_components(const Mesh& mesh, std::vector<Index>& piece) {
  std::vector<Index> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto root = [&](Index v) {
    while (parent[at(v)] != v) v = parent[at(v)] = parent[at(parent[at(v)])];
    return v;
  };
  for (const Tri& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) {
      const Index a = root(t.v[0]), b = root(t.v[k]);
      parent[at(std::max(a, b))] = std::min(a, b);
    }
  piece.assign(parent.size(), -1);
  Index count = 0;
  for (std::size_t v = 0; v < parent.size(); ++v) {
    const Index first = root(static_cast<Index>(v));
    if (at(first) == v)
      piece[v] = count++;
    else
      piece[v] = piece[at(first)];
  }
  return count;
}

/// Triangles of one piece, found by where they are in material space.
class MaterialMap {
 public:
  MaterialMap(const Mesh& mesh, std::vector<std::size_t> triangles)
      : mesh_(mesh), triangles_(std::move(triangles)) {
    constexpr double far = std::numeric_limits<double>::max();
    low_ = {far, far};
    Vec2<double> high{-far, -far};
    for (const std::size_t t : triangles_)
      for (const Index v : material_corners(mesh_, t).v)
        for (int k = 0; k < 2; ++k) {
          low_[k] = std::min(low_[k], mesh_.material[at(v)][k]);
          high[k] = std::max(high[k], mesh_.material[at(v)][k]);
        }
    cells_ = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(triangles_.size()) / 4)));
    for (int k = 0; k < 2; ++k)
      size_[k] = std::max((high[k] - low_[k]) / cells_, std::numeric_limits<double>::min());
    buckets_.resize(static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_));
    for (const std::size_t t : triangles_) enter(t);
  }

  /// The triangle that contains a point, or comes closest to that, of those around it.
  /// @return number, and the point's barycentric coordinates, none below 0
  std::pair<std::size_t, Vec3<double>> find(const Vec2<double>& x) const {
    std::pair<std::size_t, Vec3<double>> best{triangles_.front(), {1, 0, 0}};
    double deepest = -std::numeric_limits<double>::max();
    const int column = cell(x, 0), row = cell(x, 1);
    for (int reach = 1; reach <= cells_ && deepest < -1e100; reach *= 2)
      for (int j = std::max(0, row - reach); j <= std::min(cells_ - 1, row + reach); ++j)
        for (int i = std::max(0, column - reach); i <= std::min(cells_ - 1, column + reach); ++i)
          for (const std::size_t t : bucket(i, j)) {
            const Vec3<double> w = weights(t, x);
            const double depth = std::min({w[0], w[1], w[2]});
            if (depth > deepest) {
              deepest = depth;
              best = {t, w};
            }
          }
    Vec3<double>& w = best.second;
    for (int k = 0; k < 3; ++k) w[k] = std::max(0.0, w[k]);
    w = (1 / (w[0] + w[1] + w[2])) * w;
    return best;
  }

 private:
  int cell(const Vec2<double>& x, int axis) const {
    const double place = std::floor((x[axis] - low_[axis]) / size_[axis]);
    return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(cells_ - 1)));
  }
  const std::vector<std::size_t>& bucket(int i, int j) const {
    return buckets_[static_cast<std::size_t>(j) * static_cast<std::size_t>(cells_) +
                    static_cast<std::size_t>(i)];
  }
  void enter(std::size_t t) {
    int low[2] = {cells_, cells_}, high[2] = {0, 0};
    for (const Index v : material_corners(mesh_, t).v)
      for (int k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], cell(mesh_.material[at(v)], k));
        high[k] = std::max(high[k], cell(mesh_.material[at(v)], k));
      }
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i)
        const_cast<std::vector<std::size_t>&>(bucket(i, j)).push_back(t);
  }
  Vec3<double> weights(std::size_t t, const Vec2<double>& x) const {
    const Tri& corners = material_corners(mesh_, t);
    const Vec2<double> o = mesh_.material[at(corners.v[0])];
    const Vec2<double> a = mesh_.material[at(corners.v[1])] - o;
    const Vec2<double> b = mesh_.material[at(corners.v[2])] - o;
    const Vec2<double> d = x - o;
    const double det = a[0] * b[1] - a[1] * b[0];
    if (det == 0) return {-1e200, -1e200, -1e200};
    const double u = (d[0] * b[1] - d[1] * b[0]) / det;
    const double v = (a[0] * d[1] - a[1] * d[0]) / det;
    return {1 - u - v, u, v};
  }

  const Mesh& mesh_;
  std::vector<std::size_t> triangles_;
  Vec2<double> low_{0, 0}, size_{1, 1};
  int cells_ = 1;
  std::vector<std::vector<std::size_t>> buckets_;
};

bool same_triangles(const Mesh& a, const Mesh& b) {
  return a.positions.size() == b.positions.size() && a.triangles.size() == b.triangles.size() &&
         std::equal(a.triangles.begin(), a.triangles.end(), b.triangles.begin(),
                    [](const Tri& s, const Tri& t) {
                      return s.v[0] == t.v[0] && s.v[1] == t.v[1] && s.v[2] == t.v[2];
                    });
}

}  // namespace

Resampling::Resampling(const Mesh& reference, const Mesh& mesh) {
  if (same_triangles(reference, mesh)) {
    known_ = true;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const auto i = static_cast<Index>(v);
      places_.push_back({{{i, i, i}}, {1, 0, 0}});
    }
    return;
  }
  if (!reference.material.empty() && !mesh.material.empty()) by_material(reference, mesh);
}

void Resampling::by_material(const Mesh& reference, const Mesh& mesh) {
  std::vector<Index> reference_piece, piece;
  const Index count = find_components(reference, reference_piece);
  if (find_components(mesh, piece) != count) return;
  std::vector<std::vector<std::size_t>> triangles(at(count));
  for (std::size_t t = 0; t < reference.triangles.size(); ++t)
    triangles[at(reference_piece[at(reference.triangles[t].v[0])])].push_back(t);
  std::vector<MaterialMap> maps;
  for (auto& list : triangles) {
    if (list.empty()) return;
    maps.emplace_back(reference, std::move(list));
  }
  places_.resize(mesh.positions.size());
  std::vector<unsigned char> placed(mesh.positions.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::size_t v = at(mesh.triangles[t].v[k]);
      if (placed[v]) continue;
      placed[v] = 1;
      const Vec2<double>& x = mesh.material[at(material_corners(mesh, t).v[k])];
      const auto [triangle, weights] = maps[at(piece[v])].find(x);
      places_[v] = {reference.triangles[triangle], weights};
    }
  known_ = std::all_of(placed.begin(), placed.end(), [](unsigned char p) { return p != 0; });
}

std::vector<Vec3<double>> Resampling::positions(const std::vector<Vec3<double>>& from) const {
  std::vector<Vec3<double>> result;
  result.reserve(places_.size());
  for (const Place& p : places_) {
    Vec3<double> x{0, 0, 0};
    for (int k = 0; k < 3; ++k)
      if (p.weights[k] > 0) x += p.weights[k] * from[at(p.corners.v[k])];
    result.push_back(x);
  }
  return result;
}

}  // namespace weft::lab
