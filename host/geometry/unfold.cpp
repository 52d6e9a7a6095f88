#include "host/geometry/unfold.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace weft {
namespace {

std::size_t place(Index i) {
  return static_cast<std::size_t>(i);
}

/// Coordinates of one vertex this near to each other, in edge lengths, are one.
constexpr double same_place = 1e-6;

class Unfolding {
 public:
  explicit Unfolding(Mesh& mesh)
      : mesh_(mesh), corners_(mesh.triangles.size()), of_vertex_(mesh.positions.size()) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) at_edge_[edge(t, k)].push_back({static_cast<Index>(t), k});
  }

  void run() {
    std::vector<bool> laid(mesh_.triangles.size(), false);
    double right = 0;  // where the pieces so far end
    for (std::size_t root = 0; root < laid.size(); ++root) {
      if (laid[root]) continue;
      laid[root] = true;
      const std::size_t first = mesh_.material.size();
      lay_first(root);
      std::vector<Index> queue{static_cast<Index>(root)};
      for (std::size_t next = 0; next < queue.size(); ++next)
        for (int k = 0; k < 3; ++k)
          for (const Side& side : at_edge_.at(edge(place(queue[next]), k))) {
            if (laid[place(side.triangle)]) continue;
            laid[place(side.triangle)] = true;
            lay_beside(place(queue[next]), k, side);
            queue.push_back(side.triangle);
          }
      right = move_beside(first, right);
    }
    bool one_each = true;
    for (std::size_t t = 0; t < corners_.size(); ++t)
      for (int k = 0; k < 3; ++k)
        one_each = one_each && of_vertex_[place(mesh_.triangles[t].v[k])].size() == 1;
    if (!one_each) {
      mesh_.material_triangles = std::move(corners_);
      return;
    }
    std::vector<Vec2<double>> by_vertex;
    for (const std::vector<Index>& own : of_vertex_)
      by_vertex.push_back(own.empty() ? Vec2<double>{0, 0} : mesh_.material[place(own[0])]);
    mesh_.material = std::move(by_vertex);
  }

 private:
  struct Side {
    Index triangle;
    int corner;  ///< where the edge begins
  };

  std::pair<Index, Index> edge(std::size_t t, int k) const {
    return std::minmax({mesh_.triangles[t].v[k], mesh_.triangles[t].v[(k + 1) % 3]});
  }
  const Vec3<double>& position(std::size_t t, int k) const {
    return mesh_.positions[place(mesh_.triangles[t].v[k % 3])];
  }

  /// The coordinate of a corner: one that its vertex has already, if it is at the same place.
  void put(std::size_t t, int k, const Vec2<double>& u, double size) {
    std::vector<Index>& own = of_vertex_[place(mesh_.triangles[t].v[k])];
    for (const Index m : own)
      if (length(mesh_.material[place(m)] - u) <= same_place * size) {
        corners_[t].v[k] = m;
        return;
      }
    corners_[t].v[k] = static_cast<Index>(mesh_.material.size());
    own.push_back(corners_[t].v[k]);
    mesh_.material.push_back(u);
  }

  void lay_first(std::size_t t) {
    const Vec3<double> a = position(t, 1) - position(t, 0);
    const Vec3<double> b = position(t, 2) - position(t, 0);
    Vec3<double> normal = cross(a, b);
    normal *= 1.0 / length(normal);
    const Vec3<double> along =
        std::abs(normal[0]) < 0.9 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
    Vec3<double> u = along - normal * dot(along, normal);
    u *= 1.0 / length(u);
    const Vec3<double> v = cross(normal, u);
    const double size = length(a);
    put(t, 0, {0, 0}, size);
    put(t, 1, {dot(a, u), dot(a, v)}, size);
    put(t, 2, {dot(b, u), dot(b, v)}, size);
  }

  /// Lays a triangle at the edge of another that begins at corner k of that one.
  void lay_beside(std::size_t from, int k, const Side& side) {
    const auto t = place(side.triangle);
    const int j = side.corner;
    const Index begin = mesh_.triangles[t].v[j];
    const bool opposed = begin == mesh_.triangles[from].v[(k + 1) % 3];
    const Index m0 = corners_[from].v[opposed ? (k + 1) % 3 : k];
    const Index m1 = corners_[from].v[opposed ? k : (k + 1) % 3];
    corners_[t].v[j] = m0;
    corners_[t].v[(j + 1) % 3] = m1;
    const Vec2<double> u0 = mesh_.material[place(m0)];
    Vec2<double> along = mesh_.material[place(m1)] - u0;
    along *= 1.0 / length(along);
    const Vec3<double> edge = position(t, j + 1) - position(t, j);
    const Vec3<double> to_third = position(t, j + 2) - position(t, j);
    const double size = length(edge);
    // To the left of the edge, as corners run counter-clockwise.
    const double x = dot(edge, to_third) / size;
    const double y = length(cross(edge, to_third)) / size;
    put(t, (j + 2) % 3, u0 + along * x + Vec2<double>{-along[1], along[0]} * y, size);
  }

  /// Moves the coordinates from `first` on beside what lies left of `right`.
  /// @return where they end
  double move_beside(std::size_t first, double right) {
    double low = mesh_.material[first][0], high = low;
    for (std::size_t m = first; m < mesh_.material.size(); ++m) {
      low = std::min(low, mesh_.material[m][0]);
      high = std::max(high, mesh_.material[m][0]);
    }
    if (first == 0) return high + (high - low) / 8;
    for (std::size_t m = first; m < mesh_.material.size(); ++m) mesh_.material[m][0] += right - low;
    return right + (high - low) * 9 / 8;
  }

  Mesh& mesh_;
  std::vector<Tri> corners_;
  std::vector<std::vector<Index>> of_vertex_;  ///< coordinates of each vertex
  std::map<std::pair<Index, Index>, std::vector<Side>> at_edge_;
};

}  // namespace

void unfold(Mesh& mesh) {
  mesh.material.clear();
  mesh.material_triangles.clear();
  Unfolding(mesh).run();
}

}  // namespace weft
