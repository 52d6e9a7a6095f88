#include "host/geometry/mesh_repair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "host/geometry/drop_triangles.hpp"
#include "host/geometry/mesh_check.hpp"
#include "host/geometry/sliver_repair.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Sentence of counts.
class Account {
 public:
  void add(const char* subcommand, std::size_t count, const char* one, const char* many) {
    if (count == 0) return;
    if (!text_.empty()) text_ += "; ";
    text_ +=
        std::string(subcommand) + " " + std::to_string(count) + " " + (count == 1 ? one : many);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// @return how many vertices went
std::size_t join_vertices(Mesh& mesh) {
  std::map<std::tuple<double, double, double>, Index> first;
  std::vector<Index> number;
  std::size_t joined = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3<double>& x = mesh.positions[v];
    // adding 0 makes -0 and 0 one place
    const auto [entry, is_new] =
        first.try_emplace({x[0] + 0.0, x[1] + 0.0, x[2] + 0.0}, static_cast<Index>(v));
    number.push_back(entry->second);
    if (!is_new) ++joined;
  }
  if (joined == 0) return 0;
  if (!mesh.material.empty() && mesh.material_triangles.empty())
    mesh.material_triangles = mesh.triangles;
  for (Tri& t : mesh.triangles)
    for (Index& v : t.v) v = number[at(v)];
  return joined;
}

/// Twice the signed area in material space; positive without material coordinates.
double material_area(const Mesh& mesh, std::size_t t) {
  if (mesh.material.empty()) return 1;
  const Tri& tri = mesh.material_triangles.empty() ? mesh.triangles[t] : mesh.material_triangles[t];
  const Vec2<double> a = mesh.material[at(tri.v[1])] - mesh.material[at(tri.v[0])];
  const Vec2<double> b = mesh.material[at(tri.v[2])] - mesh.material[at(tri.v[0])];
  const double area = a[0] * b[1] - a[1] * b[0];
  const double edge_sq = std::max({length_sq(a), length_sq(b), length_sq(b - a)});
  return std::abs(area) > min_relative_height * edge_sq ? area : 0;
}

bool has_three_corners(const Tri& tri) {
  return tri.v[0] != tri.v[1] && tri.v[1] != tri.v[2] && tri.v[2] != tri.v[0];
}

bool has_area(const Mesh& mesh, std::size_t t) {
  const Tri& tri = mesh.triangles[t];
  if (!has_three_corners(tri)) return false;
  const Vec3<double> a = mesh.positions[at(tri.v[1])] - mesh.positions[at(tri.v[0])];
  const Vec3<double> b = mesh.positions[at(tri.v[2])] - mesh.positions[at(tri.v[0])];
  const double edge_sq = std::max({length_sq(a), length_sq(b), length_sq(b - a)});
  return length(cross(a, b)) > min_relative_height * edge_sq && material_area(mesh, t) != 0;
}

std::size_t drop_degenerate(Mesh& mesh) {
  std::vector<bool> marked(mesh.triangles.size(), false);
  for (std::size_t t = 0; t < marked.size(); ++t) marked[t] = !has_area(mesh, t);
  return drop_triangles(mesh, marked);
}

using EdgeKey = std::pair<Index, Index>;

EdgeKey edge_of(const Tri& tri, int j) {
  return std::minmax(tri.v[j], tri.v[(j + 1) % 3]);
}

/// Drops triangles without area that are not part of a surface: those with a repeated corner, and
/// those beyond two at an edge.
std::size_t drop_loose_degenerate(Mesh& mesh) {
  std::map<EdgeKey, int> count;
  for (const Tri& tri : mesh.triangles)
    for (int j = 0; j < 3; ++j) ++count[edge_of(tri, j)];
  std::vector<bool> marked(mesh.triangles.size(), false);
  for (std::size_t t = 0; t < marked.size(); ++t) {
    const Tri& tri = mesh.triangles[t];
    bool loose = !has_three_corners(tri);
    for (int j = 0; j < 3; ++j) loose = loose || count[edge_of(tri, j)] > 2;
    marked[t] = loose && !has_area(mesh, t);
    if (marked[t])
      for (int j = 0; j < 3; ++j) --count[edge_of(tri, j)];
  }
  return drop_triangles(mesh, marked);
}

std::size_t drop_duplicates(Mesh& mesh) {
  std::vector<bool> marked(mesh.triangles.size(), false);
  std::set<std::array<Index, 3>> seen;
  for (std::size_t t = 0; t < marked.size(); ++t) {
    std::array<Index, 3> v{mesh.triangles[t].v[0], mesh.triangles[t].v[1], mesh.triangles[t].v[2]};
    std::sort(v.begin(), v.end());
    marked[t] = !seen.insert(v).second;
  }
  return drop_triangles(mesh, marked);
}

std::size_t drop_crowded(Mesh& mesh) {
  std::vector<bool> marked(mesh.triangles.size(), false);
  std::map<EdgeKey, int> count;
  for (std::size_t t = 0; t < marked.size(); ++t) {
    for (int j = 0; j < 3; ++j) marked[t] = marked[t] || count[edge_of(mesh.triangles[t], j)] == 2;
    if (marked[t]) continue;
    for (int j = 0; j < 3; ++j) ++count[edge_of(mesh.triangles[t], j)];
  }
  return drop_triangles(mesh, marked);
}

struct Orientation {
  std::size_t turned = 0;
  std::size_t dropped = 0;
};

/// Turns triangles part by part. Each edge has one or two triangles by now.
class Orienter {
 public:
  explicit Orienter(Mesh& mesh) : mesh_(mesh), turn_(mesh.triangles.size(), unknown) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int j = 0; j < 3; ++j) sides_[edge_of(mesh.triangles[t], j)].push_back(t);
  }

  Orientation run() {
    for (std::size_t t = 0; t < turn_.size(); ++t)
      if (turn_[t] == unknown) orient_part(t);
    Orientation result;
    std::vector<bool> marked(turn_.size(), false);
    for (std::size_t t = 0; t < turn_.size(); ++t) {
      if (turn_[t] == turned) {
        std::swap(mesh_.triangles[t].v[1], mesh_.triangles[t].v[2]);
        if (!mesh_.material_triangles.empty())
          std::swap(mesh_.material_triangles[t].v[1], mesh_.material_triangles[t].v[2]);
        ++result.turned;
      }
    }
    for (const auto& [edge, sides] : sides_)
      if (sides.size() == 2 && !marked[sides[0]] && !marked[sides[1]] &&
          runs(sides[0], edge) == runs(sides[1], edge))
        marked[sides[1]] = true;
    result.dropped = drop_triangles(mesh_, marked);
    return result;
  }

 private:
  enum Turn : unsigned char { unknown, kept, turned };

  /// Whether the triangle runs along the edge from its lower to its higher vertex.
  bool runs(std::size_t t, const EdgeKey& edge) const {
    for (int j = 0; j < 3; ++j)
      if (mesh_.triangles[t].v[j] == edge.first && mesh_.triangles[t].v[(j + 1) % 3] == edge.second)
        return true;
    return false;
  }

  void orient_part(std::size_t seed) {
    std::vector<std::size_t> part{seed};
    turn_[seed] = kept;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const std::size_t t = part[k];
      for (int j = 0; j < 3; ++j) {
        const EdgeKey edge = edge_of(mesh_.triangles[t], j);
        for (const std::size_t other : sides_.at(edge)) {
          if (turn_[other] != unknown) continue;
          const bool agree = runs(t, edge) != runs(other, edge);
          turn_[other] = agree == (turn_[t] == kept) ? kept : turned;
          part.push_back(other);
        }
      }
    }
    std::size_t good = 0;
    for (const std::size_t t : part)
      good += (material_area(mesh_, t) > 0) == (turn_[t] == kept) ? 1 : 0;
    if (2 * good >= part.size()) return;
    for (const std::size_t t : part) turn_[t] = turn_[t] == kept ? turned : kept;
  }

  Mesh& mesh_;
  std::vector<Turn> turn_;
  std::map<EdgeKey, std::vector<std::size_t>> sides_;
};

/// Drops entries that no triangle names.
template <class Entry>
std::size_t drop_unused(std::vector<Entry>& entries, std::vector<Tri>& triangles,
                        std::vector<Index>& number) {
  number.assign(entries.size(), -1);
  for (const Tri& t : triangles)
    for (const Index v : t.v) number[at(v)] = 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<Index>(kept);
    entries[kept++] = entries[i];
  }
  const std::size_t dropped = entries.size() - kept;
  entries.resize(kept);
  for (Tri& t : triangles)
    for (Index& v : t.v) v = number[at(v)];
  return dropped;
}

std::size_t drop_isolated(Mesh& mesh) {
  std::vector<Index> number;
  const bool one_each = mesh.material_triangles.empty() && !mesh.material.empty();
  const std::size_t dropped = drop_unused(mesh.positions, mesh.triangles, number);
  if (one_each) {
    for (std::size_t v = 0; v < number.size(); ++v)
      if (number[v] >= 0) mesh.material[at(number[v])] = mesh.material[v];
    mesh.material.resize(mesh.positions.size());
  } else if (!mesh.material.empty()) {
    drop_unused(mesh.material, mesh.material_triangles, number);
  }
  return dropped;
}

}  // namespace

std::string repair_mesh(Mesh& mesh, double least_height) {
  Account account;
  const std::size_t joined = join_vertices(mesh);
  account.add("joined", joined, "vertex", "vertices");
  // What is part of a surface would leave a tear; as slivers they are removed without one.
  const bool removes_slivers = least_height > 0;
  const std::size_t degenerate =
      removes_slivers ? drop_loose_degenerate(mesh) : drop_degenerate(mesh);
  account.add("dropped", degenerate, "triangle without area", "triangles without area");
  account.add("dropped", drop_duplicates(mesh), "duplicate triangle", "duplicate triangles");
  account.add("dropped", drop_crowded(mesh), "triangle beyond two at an edge",
              "triangles beyond two at an edge");
  const Orientation orientation = Orienter(mesh).run();
  account.add("turned", orientation.turned, "triangle", "triangles");
  account.add("dropped", orientation.dropped, "triangle of a one-sided part",
              "triangles of a one-sided part");
  SliverRepair slivers;
  if (removes_slivers) slivers = repair_slivers(mesh, least_height);
  account.add("collapsed", slivers.collapsed, "short edge of a sliver", "short edges of slivers");
  account.add("flipped", slivers.flipped, "long edge of a sliver", "long edges of slivers");
  account.add("dropped", slivers.dropped, "sliver of the outline", "slivers of the outline");
  if (removes_slivers)
    account.add("dropped", drop_degenerate(mesh), "triangle without area that is left",
                "triangles without area that are left");
  // Vertices that were joined, by themselves or along an edge, are not isolated ones.
  const std::size_t unused = drop_isolated(mesh);
  account.add("dropped", unused - std::min(unused, joined + slivers.collapsed), "isolated vertex",
              "isolated vertices");
  return account.text();
}

}  // namespace weft
