#include "host/scene/intersection_check.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/parallel.hpp"
#include "host/geometry/box_tree.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "host/scene/inside_obstacle.hpp"
#include "host/scene/lift.hpp"
#include "host/scene/surfaces.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

// ---- what to say

/// Such as "0.00123".
std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value + 0.0);
  return text;
}

std::string short_text(const Point& x) {
  return "(" + short_text(x[0]) + ", " + short_text(x[1]) + ", " + short_text(x[2]) + ")";
}

/// By how much to lift a cloth out of the obstacles; empty if no lift does it.
std::string lift_advice(const Scene& scene, const Surfaces& surfaces, std::size_t cloth) {
  const auto lift = lift_clear(scene, surfaces, cloth);
  if (!lift) return {};
  return ", such as " + name_of(scene, cloth) + " lifted by " + short_text(lift->distance) +
         " m along " + short_text(lift->direction);
}

/// Whether two triangles have corners at one place that are not one vertex.
bool have_duplicate_vertices(const Surfaces& surfaces, Index a, Index b) {
  for (const Index v : surfaces.triangles[at(a)].v)
    for (const Index w : surfaces.triangles[at(b)].v)
      if (v != w && surfaces.points[at(v)] == surfaces.points[at(w)]) return true;
  return false;
}

/// Counts pairs of triangles and keeps the lowest few.
class FoundPairs {
 public:
  void add(Index a, Index b) {
    ++count_;
    lowest_.emplace_back(std::min(a, b), std::max(a, b));
    std::sort(lowest_.begin(), lowest_.end());
    if (lowest_.size() > shown_max) lowest_.pop_back();
  }
  void add(const FoundPairs& more) {
    count_ += more.count_;
    lowest_.insert(lowest_.end(), more.lowest_.begin(), more.lowest_.end());
    std::sort(lowest_.begin(), lowest_.end());
    if (lowest_.size() > shown_max) lowest_.resize(shown_max);
  }
  void refuse_any(const Scene& scene, const Surfaces& surfaces, const std::string& note) const {
    if (count_ == 0) return;
    std::string list;
    std::string place;
    std::string advice;
    for (const auto& [a, b] : lowest_) {
      const std::size_t s = surfaces.mesh_of(a);
      const std::size_t t = surfaces.mesh_of(b);
      list += list.empty() ? "triangles " : ", ";
      list += std::to_string(a - surfaces.first_triangle[s]);
      if (s != t) list += " of " + name_of(scene, s);
      list += " and " + std::to_string(b - surfaces.first_triangle[t]) + " of " + name_of(scene, t);
    }
    const auto& [a, b] = lowest_.front();
    const std::size_t cloth = surfaces.mesh_of(a);
    if (surfaces.mesh_of(b) >= scene.cloths.size()) {
      const Corners x = surfaces.corners(a);
      place = ", one at " + short_text((1.0 / 3) * (x[0] + x[1] + x[2]));
      advice = lift_advice(scene, surfaces, cloth);
    } else if (surfaces.mesh_of(b) == cloth && have_duplicate_vertices(surfaces, a, b)) {
      advice = ", or \"repair\": true of a mesh file, which joins vertices at one place";
    }
    throw SceneError(
        scene.file, title_of(scene, cloth),
        list + " intersect, " + std::to_string(count_) +
            (count_ == 1 ? " pair in all" : " pairs in all") + place + note,
        "a start free of intersections, touching included" + advice +
            (scene.contact.untangle ? "" : ", or contact.untangle true, which moves cloth apart"));
  }

 private:
  static constexpr std::size_t shown_max = 4;
  std::int64_t count_ = 0;
  std::vector<std::pair<Index, Index>> lowest_;
};

void refuse_intersections(const Scene& scene, const Surfaces& surfaces, const std::string& note) {
  const Index cloth_end = surfaces.first_triangle[scene.cloths.size()];
  const BoxTree cloth(surfaces.points, surfaces.triangles, 0, cloth_end, touching);
  std::optional<BoxTree> obstacle;
  if (!scene.obstacles.empty())
    obstacle.emplace(surfaces.points, surfaces.triangles, cloth_end, surfaces.first_triangle.back(),
                     touching);
  // Of the nodes of a level all that is below, and all of it against obstacles; of those above, as
  // many but one, only their halves against each other.
  const std::size_t level = std::min<std::size_t>(cloth.leaf_count, 256);
  std::vector<FoundPairs> found(level);
  for_each_index(setup_threads(at(cloth_end)), level, [&](std::size_t k) {
    const auto visit = [&](Index a, Index b) {
      if (triangles_intersect(surfaces.triangles[at(a)], surfaces.triangles[at(b)],
                              surfaces.corners(a), surfaces.corners(b)))
        found[k].add(a, b);
    };
    if (scene.contact.self) visit_own_pairs(cloth, level + k, visit);
    if (scene.contact.self && k > 0) visit_pairs(cloth, 2 * k, cloth, 2 * k + 1, visit);
    if (obstacle) visit_pairs(cloth, level + k, *obstacle, 1, visit);
  });
  FoundPairs all;
  for (const FoundPairs& some : found) all.add(some);
  all.refuse_any(scene, surfaces, note);
}

void refuse_inside_obstacles(const Scene& scene, const Surfaces& surfaces) {
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    if (const auto inside = part_inside_obstacle(scene, surfaces, c))
      throw SceneError(scene.file, title_of(scene, c),
                       "a start inside " + title_of(scene, scene.cloths.size() + inside->obstacle) +
                           ", with vertex " + std::to_string(inside->vertex) +
                           " and all that hangs together with it",
                       "a start outside of closed obstacles" + lift_advice(scene, surfaces, c) +
                           (scene.contact.untangle
                                ? "; contact.untangle moves out only cloth that passes through "
                                  "the surface of an obstacle"
                                : ""));
}

}  // namespace

void refuse_intersecting_start(const Scene& scene, const std::vector<unsigned char>& welded,
                               const std::string& note) {
  const Surfaces surfaces = surfaces_at_start(scene, welded);
  refuse_intersections(scene, surfaces, note);
  refuse_inside_obstacles(scene, surfaces);
}

}  // namespace weft
