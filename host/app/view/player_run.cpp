#include "host/app/view/player_run.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "host/input/safe_text.hpp"

namespace weft::app {
namespace {

using Json = nlohmann::ordered_json;

std::vector<Vec3<double>> all_positions(const std::vector<io::NamedMesh>& meshes) {
  std::vector<Vec3<double>> all;
  for (const io::NamedMesh& named : meshes)
    all.insert(all.end(), named.mesh.positions.begin(), named.mesh.positions.end());
  return all;
}

/// 32 bits per corner, little endian; vertices are numbered through all meshes.
std::string triangle_bytes(const std::vector<io::NamedMesh>& meshes) {
  std::string bytes;
  std::uint32_t first = 0;
  for (const io::NamedMesh& named : meshes) {
    for (const Tri& t : named.mesh.triangles)
      for (const Index v : t.v) {
        const std::uint32_t number = first + static_cast<std::uint32_t>(v);
        for (int shift = 0; shift < 32; shift += 8)
          bytes += static_cast<char>(number >> shift & 0xff);
      }
    first += static_cast<std::uint32_t>(named.mesh.positions.size());
  }
  return bytes;
}

/// Names and numbers of triangles, in the order of triangle_bytes().
Json parts(const std::vector<io::NamedMesh>& meshes) {
  Json list = Json::array();
  for (const io::NamedMesh& named : meshes)
    list.push_back({{"name", one_line(named.name)}, {"triangles", named.mesh.triangles.size()}});
  return list;
}

std::vector<float> first_corners(const io::CornerValues& values) {
  std::vector<float> list;
  for (const auto& cloth : values)
    for (std::size_t corner = 0; corner < cloth.size(); corner += 3) list.push_back(cloth[corner]);
  return list;
}

/// Values at corners as values at vertices.
std::vector<float> vertex_values(const std::vector<io::NamedMesh>& meshes,
                                 const io::CornerValues& values) {
  std::vector<float> list;
  for (std::size_t m = 0; m < values.size(); ++m) {
    const Mesh& mesh = meshes[m].mesh;
    const std::size_t first = list.size();
    list.resize(first + mesh.positions.size(), std::nanf(""));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        list[first + static_cast<std::size_t>(mesh.triangles[t].v[k])] = values[m][3 * t + k];
  }
  return list;
}

std::vector<float> distances(const std::vector<Vec3<double>>& a,
                             const std::vector<Vec3<double>>& b) {
  std::vector<float> list;
  for (std::size_t v = 0; v < a.size(); ++v)
    list.push_back(static_cast<float>(length(a[v] - b[v])));
  return list;
}

Json json_of(const Aabb& box) {
  if (box.empty()) return nullptr;
  return {{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}};
}

}  // namespace

int PlayerRun::store(Kind kind, std::string bytes) {
  if (bytes.empty()) return -1;
  Last& last = last_[kind];
  if (last.number >= 0 && last.bytes == bytes) return last.number;
  blobs_.push_back(base64(bytes));
  size_ += blobs_.back().size();
  last = {std::move(bytes), static_cast<int>(blobs_.size()) - 1};
  return last.number;
}

void PlayerRun::add(const PlayerFrame& frame) {
  const io::FrameMeshes& meshes = frame.meshes;
  Json topology{
      {"cloths", parts(meshes.cloths)},
      {"obstacles", parts(meshes.obstacles)},
      {"cloth_triangles", store(cloth_triangles, triangle_bytes(meshes.cloths))},
      {"obstacle_triangles", store(obstacle_triangles, triangle_bytes(meshes.obstacles))}};
  if (topologies_.empty() || topologies_.back() != topology)
    topologies_.push_back(std::move(topology));

  const std::vector<Vec3<double>> prescribed = all_positions(meshes.obstacles);
  const std::vector<Vec3<double>> cloth_places = all_positions(meshes.cloths);
  const bool own_boxes = ranges_.cloths.empty() && ranges_.obstacles.empty();
  Aabb cloth_box = ranges_.cloths, obstacle_box = ranges_.obstacles;
  if (own_boxes) {
    cloth_box.include(aabb_of(cloth_places));
    obstacle_box.include(aabb_of(prescribed));
    cloths_.include(aabb_of(cloth_places));
    obstacles_.include(aabb_of(prescribed));
  }
  std::string cloth, obstacle, strain, contact, displaced, compliance, pins;
  append_positions(cloth, cloth_places, cloth_box);
  append_positions(obstacle, prescribed, obstacle_box);
  if (ranges_.strain > 0) append_levels(strain, first_corners(frame.strain), 0, ranges_.strain);
  if (ranges_.contact > 0)
    append_levels(contact, vertex_values(meshes.cloths, frame.contact), 0, ranges_.contact);
  if (ranges_.compliance > 0 && !frame.displaced.empty()) {
    append_positions(displaced, frame.displaced, obstacle_box);
    append_levels(compliance, distances(prescribed, frame.displaced), 0, ranges_.compliance);
  }
  if (ranges_.compliance > 0)
    for (const std::vector<float>& distances_of_cloth : frame.pins)
      append_levels(pins, distances_of_cloth, 0, ranges_.compliance);
  frames_.push_back({{"number", frame.number},
                     {"time", frame.time},
                     {"topology", topologies_.size() - 1},
                     {"cloth", store(cloth_positions, std::move(cloth))},
                     {"obstacles", store(obstacle_positions, std::move(obstacle))},
                     {"strain", store(strain_levels, std::move(strain))},
                     {"contact", store(contact_levels, std::move(contact))},
                     {"displaced", store(displaced_positions, std::move(displaced))},
                     {"compliance", store(compliance_levels, std::move(compliance))},
                     {"pins", store(pin_levels, std::move(pins))}});
  if (!own_boxes) return;
  frames_.back()["cloth_box"] = json_of(cloth_box);
  frames_.back()["obstacle_box"] = json_of(obstacle_box);
}

Json PlayerRun::json() const {
  const Aabb& cloths = ranges_.cloths.empty() ? cloths_ : ranges_.cloths;
  const Aabb& obstacles = ranges_.obstacles.empty() ? obstacles_ : ranges_.obstacles;
  return {{"facts", facts_},
          {"cloth_box", json_of(cloths)},
          {"obstacle_box", json_of(obstacles)},
          {"position_error", std::max(largest_error(cloths), largest_error(obstacles))},
          {"scales",
           {{"strain", ranges_.strain},
            {"contact", ranges_.contact},
            {"compliance", ranges_.compliance}}},
          {"topologies", topologies_},
          {"frames", frames_}};
}

Json PlayerRun::news(std::size_t frames, std::size_t topologies, std::size_t blobs,
                     std::size_t steps) const {
  const auto rest = [](const auto& list, std::size_t from) {
    Json json = Json::array();
    for (std::size_t i = from; i < list.size(); ++i) json.push_back(list[i]);
    return json;
  };
  return {{"frames", rest(frames_, frames)}, {"topologies", rest(topologies_, topologies)},
          {"blobs", rest(blobs_, blobs)},    {"steps", rest(facts_.at("steps"), steps)},
          {"cloth_box", json_of(cloths_)},   {"obstacle_box", json_of(obstacles_)}};
}

}  // namespace weft::app
