#include "host/geometry/mesh_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "host/input/counted.hpp"
#include "host/input/quantity.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Collects offenders of one kind and throws if there are any.
class Offenders {
 public:
  Offenders(const MeshOrigin& origin, const char* array, const char* noun)
      : origin_(origin), array_(array), noun_(noun) {}

  void add(std::size_t number, const std::string& detail = {}) {
    if (count_++ < shown_max) {
      if (!list_.empty()) list_ += ", ";
      list_ += std::to_string(number) + detail;
    }
  }
  bool any() const { return count_ > 0; }
  /// @param repairable whether repair_mesh() takes such offenders away
  void refuse_any(const char* what, const char* allowed, bool repairable = false) const {
    if (count_ == 0) return;
    std::string value =
        std::string(what) + " (" + noun_for(static_cast<std::int64_t>(count_), noun_) + " " + list_;
    if (count_ > shown_max) value += " and " + std::to_string(count_ - shown_max) + " more";
    value += ")";
    if (!origin_.name.empty()) value += " in \"" + origin_.name + "\"";
    throw SceneError(
        origin_.file, origin_.field + "." + array_, value,
        allowed + std::string(repairable ? ", or \"repair\": true of a mesh file" : ""));
  }

 private:
  static constexpr std::size_t shown_max = 5;
  const MeshOrigin& origin_;
  const char* array_;
  const char* noun_;
  std::size_t count_ = 0;
  std::string list_;
};

/// Entries sorted by a small integer key: bucket k is entries[first[k]] to entries[first[k + 1]].
template <class Entry>
struct Buckets {
  std::vector<std::size_t> first;
  std::vector<Entry> entries;
};

/// @param emit calls its argument with (key, entry) for each entry; called twice
template <class Entry, class Emit>
Buckets<Entry> fill_buckets(std::size_t key_count, const Emit& emit) {
  Buckets<Entry> buckets;
  buckets.first.assign(key_count + 1, 0);
  emit([&](Index key, const Entry&) { ++buckets.first[at(key) + 1]; });
  for (std::size_t k = 0; k < key_count; ++k) buckets.first[k + 1] += buckets.first[k];
  buckets.entries.resize(buckets.first.back());
  std::vector<std::size_t> next(buckets.first.begin(), buckets.first.end() - 1);
  emit([&](Index key, const Entry& entry) { buckets.entries[next[at(key)]++] = entry; });
  return buckets;
}

void check_counts(const Mesh& mesh, const MeshOrigin& origin, bool needs_material) {
  constexpr auto most = static_cast<std::size_t>(std::numeric_limits<Index>::max());
  const auto refuse = [&](const char* array, const std::string& value, const char* allowed) {
    const std::string in = origin.name.empty() ? "" : " in \"" + origin.name + "\"";
    throw SceneError(origin.file, origin.field + "." + array, value + in, allowed);
  };
  if (mesh.positions.empty()) refuse("positions", "no vertices", "at least three");
  if (mesh.triangles.empty()) refuse("triangles", "no triangles", "at least one");
  if (mesh.positions.size() > most / 3)
    refuse("positions", counted(mesh.positions.size(), "vertex"), "up to 715827882");
  if (mesh.triangles.size() > most / 3)
    refuse("triangles", counted(mesh.triangles.size(), "triangle"), "up to 715827882");
  if (mesh.material.empty() && needs_material)
    refuse("material", "no material coordinates",
           "one pair per vertex, the flat pattern in metres");
  if (mesh.material_triangles.empty()) {
    if (!mesh.material.empty() && mesh.material.size() != mesh.positions.size())
      refuse("material", counted(mesh.material.size(), "pair"),
             ("one pair for each of the " + counted(mesh.positions.size(), "vertex")).c_str());
  } else if (mesh.material_triangles.size() != mesh.triangles.size()) {
    refuse("material_triangles", counted(mesh.material_triangles.size(), "triangle"),
           ("one for each of the " + counted(mesh.triangles.size(), "triangle")).c_str());
  }
  if (!mesh.group.empty() && mesh.group.size() != mesh.triangles.size())
    refuse("group", counted(mesh.group.size(), "number"),
           ("one for each of the " + counted(mesh.triangles.size(), "triangle")).c_str());
}

template <int N>
void check_finite(const std::vector<Vec<double, N>>& array, const char* name,
                  const MeshOrigin& origin) {
  Offenders bad(origin, name, "vertex");
  for (std::size_t v = 0; v < array.size(); ++v)
    for (int k = 0; k < N; ++k)
      if (!std::isfinite(array[v][k])) {
        bad.add(v, std::isnan(array[v][k]) ? ": nan" : ": inf");
        break;
      }
  bad.refuse_any("coordinates that are no numbers", "finite numbers");
}

void check_corners(const Mesh& mesh, const MeshOrigin& origin) {
  const auto vertex_count = static_cast<Index>(mesh.positions.size());
  Offenders outside(origin, "triangles", "triangle");
  Offenders repeated(origin, "triangles", "triangle");
  std::vector<bool> used(mesh.positions.size(), false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Tri& tri = mesh.triangles[t];
    bool inside = true;
    for (const Index v : tri.v)
      if (v < 0 || v >= vertex_count) {
        if (inside) outside.add(t, ": vertex " + std::to_string(v));
        inside = false;
      } else {
        used[at(v)] = true;
      }
    if (tri.v[0] == tri.v[1] || tri.v[1] == tri.v[2] || tri.v[2] == tri.v[0]) repeated.add(t);
  }
  outside.refuse_any("vertex number out of range",
                     ("0 to " + std::to_string(vertex_count - 1)).c_str());
  repeated.refuse_any("corner repeated", "three different vertices", true);
  Offenders isolated(origin, "positions", "vertex");
  for (std::size_t v = 0; v < used.size(); ++v)
    if (!used[v]) isolated.add(v);
  isolated.refuse_any("isolated vertex", "vertices that are part of a triangle", true);
}

/// Corners in material space, and numbers of groups.
void check_references(const Mesh& mesh, const MeshOrigin& origin) {
  const auto outside = [](Index i, std::size_t count) {
    return i < 0 || static_cast<std::size_t>(i) >= count;
  };
  Offenders corners(origin, "material_triangles", "triangle");
  for (std::size_t t = 0; t < mesh.material_triangles.size(); ++t)
    for (const Index v : mesh.material_triangles[t].v)
      if (outside(v, mesh.material.size())) {
        corners.add(t, ": pair " + std::to_string(v));
        break;
      }
  corners.refuse_any(
      "material coordinate out of range",
      ("less than " + std::to_string(mesh.material.size()) + ", counted from 0").c_str());
  Offenders groups(origin, "group", "triangle");
  for (std::size_t t = 0; t < mesh.group.size(); ++t)
    if (outside(mesh.group[t], mesh.group_names.size()))
      groups.add(t, ": group " + std::to_string(mesh.group[t]));
  groups.refuse_any(
      "group out of range",
      ("less than " + std::to_string(mesh.group_names.size()) + ", counted from 0").c_str());
}

void check_duplicates(const Mesh& mesh, const MeshOrigin& origin) {
  struct Entry {
    std::array<Index, 2> others{};  ///< the two larger corners, in order
    std::size_t triangle = 0;
  };
  auto buckets = fill_buckets<Entry>(mesh.positions.size(), [&](const auto& put) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      std::array<Index, 3> v{mesh.triangles[t].v[0], mesh.triangles[t].v[1],
                             mesh.triangles[t].v[2]};
      std::sort(v.begin(), v.end());
      put(v[0], Entry{{v[1], v[2]}, t});
    }
  });
  Offenders bad(origin, "triangles", "triangle");
  for (std::size_t k = 0; k + 1 < buckets.first.size(); ++k) {
    const auto begin = buckets.entries.begin() + static_cast<std::ptrdiff_t>(buckets.first[k]);
    const auto end = buckets.entries.begin() + static_cast<std::ptrdiff_t>(buckets.first[k + 1]);
    std::sort(begin, end, [](const Entry& a, const Entry& b) {
      return std::pair(a.others, a.triangle) < std::pair(b.others, b.triangle);
    });
    for (auto e = begin; e != end && e + 1 != end; ++e)
      if (e->others == (e + 1)->others)
        bad.add((e + 1)->triangle, " like " + std::to_string(e->triangle));
  }
  bad.refuse_any("duplicate triangle", "each set of three vertices once", true);
}

void check_edges(const Mesh& mesh, const MeshOrigin& origin) {
  struct Entry {
    Index high = 0;
    bool forward = false;  ///< the triangle runs from the lower to the higher vertex
    std::size_t triangle = 0;
  };
  auto buckets = fill_buckets<Entry>(mesh.positions.size(), [&](const auto& put) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const Index a = mesh.triangles[t].v[k];
        const Index b = mesh.triangles[t].v[(k + 1) % 3];
        put(std::min(a, b), Entry{std::max(a, b), a < b, t});
      }
  });
  Offenders crowded(origin, "triangles", "edge");
  Offenders flipped(origin, "triangles", "triangle");
  for (std::size_t low = 0; low + 1 < buckets.first.size(); ++low) {
    const auto begin = buckets.entries.begin() + static_cast<std::ptrdiff_t>(buckets.first[low]);
    const auto end = buckets.entries.begin() + static_cast<std::ptrdiff_t>(buckets.first[low + 1]);
    std::sort(begin, end, [](const Entry& a, const Entry& b) {
      return std::pair(a.high, a.triangle) < std::pair(b.high, b.triangle);
    });
    for (auto e = begin; e != end;) {
      const auto next = std::find_if(e, end, [&](const Entry& x) { return x.high != e->high; });
      if (next - e > 2) {
        std::string detail = "-";
        detail += std::to_string(e->high);
        detail += " of triangles";
        for (auto f = e; f != next && f - e < 4; ++f)
          detail.append(" ").append(std::to_string(f->triangle));
        crowded.add(low, detail);
      } else if (next - e == 2 && e->forward == (e + 1)->forward) {
        flipped.add((e + 1)->triangle, " beside " + std::to_string(e->triangle));
      }
      e = next;
    }
  }
  crowded.refuse_any("non-manifold edge", "one or two triangles an edge", true);
  flipped.refuse_any("triangle oriented against its neighbour", "one orientation throughout", true);
}

template <int N>
void check_extent(const std::vector<Vec<double, N>>& points, const char* name,
                  const MeshOrigin& origin) {
  Offenders bad(origin, name, "vertex");
  for (std::size_t v = 0; v < points.size(); ++v)
    for (int k = 0; k < N; ++k)
      if (!quantity::coordinate.holds(points[v][k])) {
        bad.add(v, ": " + short_number(points[v][k]));
        break;
      }
  bad.refuse_any("coordinates out of range", quantity::coordinate.allowed().c_str());
}

double longest_sq(double a, double b, double c) {
  return std::max({a, b, c});
}

void check_world_areas(const Mesh& mesh, const MeshOrigin& origin) {
  Offenders bad(origin, "triangles", "triangle");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Tri& tri = mesh.triangles[t];
    const Vec3<double> e1 = mesh.positions[at(tri.v[1])] - mesh.positions[at(tri.v[0])];
    const Vec3<double> e2 = mesh.positions[at(tri.v[2])] - mesh.positions[at(tri.v[0])];
    const double edge_sq = longest_sq(length_sq(e1), length_sq(e2), length_sq(e2 - e1));
    if (!(length(cross(e1, e2)) > min_relative_height * edge_sq)) bad.add(t);
  }
  // Beside an edge that is too long, other heights count as zero.
  if (bad.any()) check_extent(mesh.positions, "positions", origin);
  bad.refuse_any("zero area in world space", "triangles with an area", true);
}

void check_material_areas(const Mesh& mesh, const MeshOrigin& origin) {
  Offenders flat(origin, "material", "triangle");
  Offenders inverted(origin, "material", "triangle");
  const std::vector<Tri>& corners_of =
      mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
  for (std::size_t t = 0; t < corners_of.size(); ++t) {
    const Tri& tri = corners_of[t];
    const Vec2<double> e1 = mesh.material[at(tri.v[1])] - mesh.material[at(tri.v[0])];
    const Vec2<double> e2 = mesh.material[at(tri.v[2])] - mesh.material[at(tri.v[0])];
    const double edge_sq = longest_sq(length_sq(e1), length_sq(e2), length_sq(e2 - e1));
    const double twice_area = e1[0] * e2[1] - e1[1] * e2[0];
    if (!(std::abs(twice_area) > min_relative_height * edge_sq))
      flat.add(t);
    else if (twice_area < 0)
      inverted.add(t);
  }
  if (flat.any()) check_extent(mesh.material, "material", origin);
  flat.refuse_any("zero area in material space", "triangles with an area", true);
  inverted.refuse_any("inverted in material space",
                      "material coordinates counter-clockwise like the triangle itself");
}

/// Height of a triangle in material space over its longest edge, in units of that edge.
double relative_height(const Mesh& mesh, const Tri& tri) {
  const Vec2<double> e1 = mesh.material[at(tri.v[1])] - mesh.material[at(tri.v[0])];
  const Vec2<double> e2 = mesh.material[at(tri.v[2])] - mesh.material[at(tri.v[0])];
  return std::abs(e1[0] * e2[1] - e1[1] * e2[0]) /
         longest_sq(length_sq(e1), length_sq(e2), length_sq(e2 - e1));
}

template <int N>
void check_edge_lengths(const std::vector<Vec<double, N>>& points,
                        const std::vector<Tri>& triangles, const char* name,
                        const MeshOrigin& origin) {
  const double least_sq = quantity::least_length * quantity::least_length;
  Offenders bad(origin, name, "triangle");
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec<double, N>&a = points[at(triangles[t].v[0])], &b = points[at(triangles[t].v[1])],
                      &c = points[at(triangles[t].v[2])];
    if (!(longest_sq(length_sq(b - a), length_sq(c - a), length_sq(c - b)) >= least_sq)) bad.add(t);
  }
  bad.refuse_any(
      "triangle too small",
      ("a longest edge of at least " + short_number(quantity::least_length) + " m").c_str());
}

}  // namespace

void check_slivers(const Mesh& mesh, const MeshOrigin& origin, double least) {
  Offenders bad(origin, "material", "triangle");
  const std::vector<Tri>& corners =
      mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
  for (std::size_t t = 0; t < corners.size(); ++t)
    if (!(relative_height(mesh, corners[t]) >= least)) bad.add(t);
  bad.refuse_any("sliver",
                 ("triangles of at least 1 : " + std::to_string(std::llround(1 / least)) +
                  " (height over longest edge) in this precision")
                     .c_str(),
                 true);
}

void check_size(const Mesh& mesh, const MeshOrigin& origin) {
  check_extent(mesh.positions, "positions", origin);
  check_extent(mesh.material, "material", origin);
  check_edge_lengths(mesh.positions, mesh.triangles, "triangles", origin);
  if (mesh.material.empty()) return;
  check_edge_lengths(mesh.material,
                     mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles,
                     "material", origin);
}

void check_mesh(const Mesh& mesh, const MeshOrigin& origin, bool needs_material) {
  check_counts(mesh, origin, needs_material);
  check_finite(mesh.positions, "positions", origin);
  check_finite(mesh.material, "material", origin);
  check_corners(mesh, origin);
  check_references(mesh, origin);
  check_duplicates(mesh, origin);
  check_edges(mesh, origin);
  check_world_areas(mesh, origin);
  if (needs_material) check_material_areas(mesh, origin);
}

}  // namespace weft
