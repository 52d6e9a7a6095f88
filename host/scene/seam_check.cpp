#include "host/scene/seam_check.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "host/input/checker.hpp"
#include "host/input/counted.hpp"
#include "host/scene/defaults.hpp"
#include "host/scene/seams/stacked_triangles.hpp"
#include "host/scene/validate.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

std::string field_of(std::size_t seam) {
  return "seams[" + std::to_string(seam) + "]";
}

/// Vertices of all cloths under one number each.
class Numbering {
 public:
  explicit Numbering(const Scene& scene) : scene_(scene) {
    for (const Cloth& cloth : scene.cloths)
      first_.push_back(first_.back() + static_cast<Index>(cloth.mesh.positions.size()));
  }

  Index count() const { return first_.back(); }
  Index number(Index cloth, Index vertex) const { return first_[at(cloth)] + vertex; }
  Index cloth_of(Index number) const {
    const auto after = std::upper_bound(first_.begin(), first_.end(), number);
    return static_cast<Index>(after - first_.begin()) - 1;
  }
  /// vertex 3 of cloth "front"
  std::string name(Index number) const {
    const Index cloth = cloth_of(number);
    return "vertex " + std::to_string(number - first_[at(cloth)]) + " of cloth \"" +
           scene_.cloths[at(cloth)].name + "\"";
  }

 private:
  const Scene& scene_;
  std::vector<Index> first_{0};  ///< [cloths + 1]
};

/// Vertices that sewing makes one.
class Classes {
 public:
  Classes(const Scene& scene, const Numbering& numbering)
      : parent_(at(numbering.count())), sewn_(at(numbering.count()), false) {
    std::iota(parent_.begin(), parent_.end(), Index{0});
    for (const Seam& seam : scene.seams) {
      for (std::size_t k = 0; k < seam.vertices[0].size(); ++k)
        join(numbering.number(seam.cloths[0], seam.vertices[0][k]),
             numbering.number(seam.cloths[1], seam.vertices[1][k]));
    }
    // A parent has the smaller number, so that one pass is enough.
    for (Index& parent : parent_) parent = parent_[at(parent)];
  }

  bool sewn(Index number) const { return sewn_[at(number)]; }
  Index find(Index number) const { return parent_[at(number)]; }

 private:
  /// The smaller number stands for both; paths are halved on the way.
  void join(Index a, Index b) {
    sewn_[at(a)] = sewn_[at(b)] = true;
    a = top(a);
    b = top(b);
    parent_[at(std::max(a, b))] = std::min(a, b);
  }
  Index top(Index number) {
    while (parent_[at(number)] != number) {
      parent_[at(number)] = parent_[at(parent_[at(number)])];
      number = parent_[at(number)];
    }
    return number;
  }

  std::vector<Index> parent_;
  std::vector<bool> sewn_;
};

/// One side of a triangle whose ends are both sewn to something.
struct Side {
  std::array<Index, 2> classes;  ///< smaller first
  std::array<Index, 2> ends;     ///< vertices in the numbering, in the triangle's own direction
  Index triangle = 0;            ///< of the cloth
  bool forward = true;           ///< along the classes

  std::array<Index, 2> edge() const {
    return {std::min(ends[0], ends[1]), std::max(ends[0], ends[1])};
  }
};

[[noreturn]] void refuse(const Scene& scene, const std::string& field, const std::string& value,
                         const std::string& allowed) {
  throw SceneError(scene.file, field, value, allowed);
}

/// @throws SceneError if a triangle has two corners of one class
std::vector<Side> sewn_sides(const Scene& scene, const Numbering& numbering,
                             const Classes& classes) {
  std::vector<Side> sides;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const std::vector<Tri>& triangles = scene.cloths[c].mesh.triangles;
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const Index from = numbering.number(static_cast<Index>(c), triangles[t].v[k]);
        const Index to = numbering.number(static_cast<Index>(c), triangles[t].v[(k + 1) % 3]);
        if (!classes.sewn(from) || !classes.sewn(to)) continue;
        const Index a = classes.find(from);
        const Index b = classes.find(to);
        if (a == b)
          refuse(scene, "seams",
                 numbering.name(from) + " sewn to " + numbering.name(to) +
                     ", both corners of its triangle " + std::to_string(t),
                 "no seam that closes a triangle");
        sides.push_back(
            {{std::min(a, b), std::max(a, b)}, {from, to}, static_cast<Index>(t), a < b});
      }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::pair(a.classes, a.edge()) < std::pair(b.classes, b.edge());
  });
  return sides;
}

std::string side_text(const Side& side, const Numbering& numbering) {
  return "triangle " + std::to_string(side.triangle) + " (" + numbering.name(side.ends[0]) +
         " to " + numbering.name(side.ends[1]) + ")";
}

/// Sides of one triangle only in their own mesh, in runs that become one edge.
/// @param visit called with each such run
template <class Visit>
void for_each_joined_edge(const std::vector<Side>& sides, const Visit& visit) {
  std::vector<Side> joined;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool like_last = i > 0 && sides[i].edge() == sides[i - 1].edge();
    const bool like_next = i + 1 < sides.size() && sides[i].edge() == sides[i + 1].edge();
    if (!like_last && !like_next) joined.push_back(sides[i]);
    const bool ends = i + 1 == sides.size() || sides[i + 1].classes != sides[i].classes;
    if (ends && !joined.empty()) visit(joined);
    if (ends) joined.clear();
  }
}

void check_orientation(const Scene& scene, const Numbering& numbering,
                       const std::vector<Side>& sides) {
  for_each_joined_edge(sides, [&](const std::vector<Side>& edge) {
    if (edge.size() != 2 || edge[0].forward != edge[1].forward) return;
    refuse(scene, "seams",
           side_text(edge[0], numbering) + " and " + side_text(edge[1], numbering) +
               " run the same way along the edge that they get in common",
           "triangles that run along it in opposite directions: one panel must be turned over");
  });
}

void check_stacked(const Scene& scene) {
  const std::vector<StackedTriangles> stacked = stacked_triangles(scene);
  if (stacked.empty()) return;
  const auto name = [&](std::size_t k) {
    return "triangle " + std::to_string(stacked[0].triangle[k]) + " of cloth \"" +
           scene.cloths[at(stacked[0].cloth[k])].name + "\"";
  };
  refuse(scene, "seams",
         name(0) + " and " + name(1) + ", which get the same three corners by welding, " +
             std::to_string(stacked.size()) +
             (stacked.size() == 1 ? " pair in all" : " pairs in all"),
         "triangles that do not lie on each other: more cells between what is sewn, or "
         "weld_distance 0");
}

/// Two vertices that are sewn together, and by which seam.
struct Pair {
  std::array<Index, 2> numbers;  ///< smaller first
  std::size_t seam = 0;
};

void check_vertices(const Scene& scene, std::size_t i) {
  const Seam& seam = scene.seams[i];
  for (std::size_t side = 0; side < 2; ++side)
    if (seam.cloths[side] < 0 || at(seam.cloths[side]) >= scene.cloths.size())
      refuse(scene, field_of(i) + ".cloths[" + std::to_string(side) + "]",
             std::to_string(seam.cloths[side]),
             "the number of one of the " + std::to_string(scene.cloths.size()) +
                 " cloths, counted from 0");
  if (seam.vertices[0].size() != seam.vertices[1].size())
    refuse(scene, field_of(i) + ".vertices",
           std::to_string(seam.vertices[0].size()) + " and " +
               counted(seam.vertices[1].size(), "vertex"),
           "as many in each");
  if (seam.vertices[0].empty())
    refuse(scene, field_of(i) + ".vertices", "none", "at least one pair");
  for (std::size_t side = 0; side < 2; ++side) {
    const Cloth& cloth = scene.cloths[at(seam.cloths[side])];
    for (std::size_t k = 0; k < seam.vertices[side].size(); ++k) {
      const Index v = seam.vertices[side][k];
      if (v < 0 || at(v) >= cloth.mesh.positions.size())
        refuse(scene,
               field_of(i) + ".vertices[" + std::to_string(side) + "][" + std::to_string(k) + "]",
               std::to_string(v),
               "0 to " + std::to_string(cloth.mesh.positions.size() - 1) +
                   ", the vertices of cloth \"" + cloth.name + "\"");
    }
  }
}

void check_values(const Scene& scene, std::size_t i) {
  const Seam& seam = scene.seams[i];
  const Checker check(scene.file, field_of(i));
  if (seam.stiffness) check.within("stiffness", *seam.stiffness, quantity::stiffness);
  check.within("start_time", seam.start_time, quantity::instant_from_zero);
  check.within("ramp_time", seam.ramp_time, quantity::duration_or_zero);
  if (!seam.weld_distance) return;
  const double least = thickness_of(scene) / 2;
  if (!(*seam.weld_distance == 0 || *seam.weld_distance >= least))
    check.refuse("weld_distance", text_of(*seam.weld_distance),
                 "0 for never, or at least half the contact thickness, " + text_of(least) +
                     ": contact keeps pairs from coming closer");
  check.within("weld_distance", *seam.weld_distance, quantity::length_or_zero);
}

void check_pairs(const Scene& scene, const Numbering& numbering) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < scene.seams.size(); ++i) {
    const Seam& seam = scene.seams[i];
    for (std::size_t k = 0; k < seam.vertices[0].size(); ++k) {
      const Index a = numbering.number(seam.cloths[0], seam.vertices[0][k]);
      const Index b = numbering.number(seam.cloths[1], seam.vertices[1][k]);
      if (a == b)
        refuse(scene, field_of(i),
               "pair " + std::to_string(k) + ", " + numbering.name(a) + " sewn to itself",
               "two different vertices");
      pairs.push_back({{std::min(a, b), std::max(a, b)}, i});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::pair(a.numbers, a.seam) < std::pair(b.numbers, b.seam);
  });
  for (std::size_t k = 1; k < pairs.size(); ++k)
    if (pairs[k].numbers == pairs[k - 1].numbers)
      refuse(scene, field_of(pairs[k].seam),
             numbering.name(pairs[k].numbers[0]) + " sewn to " +
                 numbering.name(pairs[k].numbers[1]) + " twice",
             "each pair once");
}

void check_refinement(const Scene& scene) {
  const Refinement& refinement = scene.refinement;
  if (refinement.levels < 1 || refinement.levels > 6)
    refuse(scene, "refine.levels", std::to_string(refinement.levels), "an integer from 1 to 6");
  if (refinement.when == Refinement::When::never) return;
  std::size_t triangles = 0;
  for (const Cloth& cloth : scene.cloths) triangles += cloth.mesh.triangles.size();
  const std::size_t refined = triangles << (2 * refinement.levels);
  if (refined > most_elements)
    refuse(scene, "refine.levels",
           std::to_string(refinement.levels) + " (" + counted(refined, "triangle") + ")",
           "levels that make up to " + std::to_string(most_elements) + " triangles");
  if (scene.seams.empty())
    refuse(scene, "refine.when", "\"sewn\" in a scene without seams", "at least one seam");
  for (std::size_t i = 0; i < scene.seams.size(); ++i)
    if (scene.seams[i].weld_distance == 0)
      refuse(scene, field_of(i) + ".weld_distance", "0 beside refine",
             "a distance > 0, since cloth is refined once all seams are welded");
  if (scene.output.format == FrameFormat::pc2 || scene.output.format == FrameFormat::glb)
    refuse(
        scene, "output.format",
        scene.output.format == FrameFormat::pc2 ? "\"pc2\" beside refine" : "\"glb\" beside refine",
        "obj, ply or usda: the triangles of a point cache and of a glb may not change");
}

}  // namespace

void validate_seams(const Scene& scene) {
  for (std::size_t i = 0; i < scene.seams.size(); ++i) {
    check_vertices(scene, i);
    check_values(scene, i);
  }
  check_refinement(scene);
  if (scene.seams.empty()) return;
  const Numbering numbering(scene);
  check_pairs(scene, numbering);
  check_orientation(scene, numbering, sewn_sides(scene, numbering, Classes(scene, numbering)));
  check_stacked(scene);
}

}  // namespace weft
