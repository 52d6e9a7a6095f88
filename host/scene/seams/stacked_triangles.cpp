#include "host/scene/seams/stacked_triangles.hpp"

#include <algorithm>
#include <cstddef>

#include "host/scene/seams/sewing.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

struct Corners {
  std::array<Index, 3> classes;  ///< ascending
  Index cloth;
  Index triangle;
};

}  // namespace

std::vector<StackedTriangles> stacked_triangles(const Scene& scene) {
  const std::vector<Index> offsets = input_offsets(scene);
  std::vector<SeamPair> pairs = seam_pairs(scene);
  std::erase_if(pairs, [](const SeamPair& pair) { return !(pair.weld_distance > 0); });
  const std::vector<Index> joined = grouped(at(offsets.back()), pairs);
  std::vector<bool> sewn(joined.size(), false);
  for (const SeamPair& pair : pairs)
    for (const Index v : pair.v) sewn[at(v)] = true;
  std::vector<Corners> all;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const std::vector<Tri>& triangles = scene.cloths[c].mesh.triangles;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      Corners corners{{}, static_cast<Index>(c), static_cast<Index>(t)};
      bool any_sewn = false;
      for (std::size_t j = 0; j < 3; ++j) {
        const Index input = offsets[c] + triangles[t].v[j];
        corners.classes[j] = joined[at(input)];
        any_sewn = any_sewn || sewn[at(input)];
      }
      if (!any_sewn) continue;
      std::sort(corners.classes.begin(), corners.classes.end());
      all.push_back(corners);
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Corners& a, const Corners& b) { return a.classes < b.classes; });
  std::vector<StackedTriangles> stacked;
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].classes == all[i - 1].classes)
      stacked.push_back({{all[i - 1].cloth, all[i].cloth}, {all[i - 1].triangle, all[i].triangle}});
  return stacked;
}

}  // namespace weft
