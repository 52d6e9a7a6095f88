#include "host/scene/seams/sewing.hpp"

#include "host/scene/seams/groups.hpp"
#include "weft/core/at.hpp"

#include <algorithm>

namespace weft {
bool Sewing::complete() const {
  return !welded.empty() &&
         std::all_of(welded.begin(), welded.end(), [](unsigned char w) { return w != 0; });
}

std::vector<Index> input_offsets(const Scene& scene) {
  std::vector<Index> offsets{0};
  for (const Cloth& cloth : scene.cloths)
    offsets.push_back(offsets.back() + static_cast<Index>(cloth.mesh.positions.size()));
  return offsets;
}

std::vector<SeamPair> seam_pairs(const Scene& scene) {
  const std::vector<Index> offsets = input_offsets(scene);
  std::vector<SeamPair> pairs;
  for (const Seam& seam : scene.seams)
    for (std::size_t k = 0; k < seam.vertices[0].size(); ++k)
      pairs.push_back({{offsets[at(seam.cloths[0])] + seam.vertices[0][k],
                        offsets[at(seam.cloths[1])] + seam.vertices[1][k]},
                       seam.weld_distance.value_or(0)});
  return pairs;
}

Sewing sewing_at_start(const Scene& scene) {
  std::vector<Vec3<double>> positions;
  for (const Cloth& cloth : scene.cloths)
    positions.insert(positions.end(), cloth.mesh.positions.begin(), cloth.mesh.positions.end());
  Sewing sewing;
  for (const SeamPair& pair : seam_pairs(scene))
    sewing.welded.push_back(pair.weld_distance > 0 &&
                            length(positions[at(pair.v[1])] - positions[at(pair.v[0])]) <=
                                pair.weld_distance);
  return sewing;
}

std::vector<Index> grouped(std::size_t count, const std::vector<SeamPair>& pairs) {
  Groups groups(count);
  for (const SeamPair& pair : pairs) groups.join(pair.v[0], pair.v[1]);
  return groups.lowest();
}

std::vector<Index> joined_inputs(const Scene& scene, const std::vector<unsigned char>& welded) {
  std::vector<SeamPair> joined;
  if (!welded.empty()) {
    const std::vector<SeamPair> pairs = seam_pairs(scene);
    for (std::size_t k = 0; k < pairs.size(); ++k)
      if (welded[k] != 0) joined.push_back(pairs[k]);
  }
  return grouped(at(input_offsets(scene).back()), joined);
}

void average_joined(const std::vector<Index>& joined, std::vector<Vec3<double>>& values) {
  std::vector<int> count(values.size(), 1);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto first = static_cast<std::size_t>(joined[i]);
    if (first == i) continue;
    values[first] += values[i];
    ++count[first];
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    if (count[i] > 1) values[i] *= 1.0 / count[i];
}

}  // namespace weft
