#include "host/io/spool/frame_spool.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <utility>

#include "host/base/checksum.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/safe_text.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little);

constexpr char file_magic[8] = {'W', 'E', 'F', 'T', 'S', 'P', 'L', '1'};
/// Of a spool whose points are relative to an origin, which stands between header and names.
constexpr char placed_magic[8] = {'W', 'E', 'F', 'T', 'S', 'P', 'L', '2'};
constexpr std::uint32_t block_magic = 0x4b4c4253;
constexpr std::uint32_t max_meshes = 1 << 20;
constexpr std::uint32_t max_name = 1 << 12;
constexpr Index max_entries = std::numeric_limits<Index>::max() / 3;

struct RawHeader {
  char magic[8];
  double frame_rate;
  std::uint32_t mesh_count;
  /// Of all names, each led by a byte for its kind and ended by a zero: 'c' a cloth, 'o' an
  /// obstacle, 'g' a group and 'p' a part of the mesh before.
  std::uint32_t name_bytes;
};
static_assert(sizeof(RawHeader) == 24);

struct RawBlock {
  std::uint32_t magic;
  std::int32_t frame;
  std::uint32_t mesh;
  std::int32_t points;     ///< -1: those of the frame before
  std::int32_t triangles;  ///< -1: topology of the frame before
  std::int32_t material;
  std::int32_t material_triangles;
  std::uint32_t flags;
  std::uint64_t checksum;  ///< of the payload
};
static_assert(sizeof(RawBlock) == 40);
constexpr std::uint32_t flag_grouped = 1;
constexpr std::uint32_t flag_parted = 2;
constexpr std::uint32_t flag_velocities = 4;

[[noreturn]] void refuse(const fs::path& path, const std::string& field, const std::string& value) {
  throw SceneError(path.string(), field, value, "a spool of frames as weft writes it");
}

template <class T>
void append_bytes(std::string& bytes, const T* values, std::size_t count) {
  if (count > 0) bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

/// Takes `count` values off the front of `bytes`.
template <class T>
std::vector<T> take(const char*& bytes, Index count) {
  std::vector<T> values(static_cast<std::size_t>(count));
  if (count > 0) std::memcpy(values.data(), bytes, values.size() * sizeof(T));
  bytes += values.size() * sizeof(T);
  return values;
}

std::uint64_t topology_bytes(const SpoolBlock& b) {
  const auto count = [](Index n) { return static_cast<std::uint64_t>(n); };
  return sizeof(Tri) * (count(b.triangles) + count(b.material_triangles)) +
         sizeof(Vec2<float>) * count(b.material) +
         sizeof(Index) * count(b.triangles) * ((b.grouped ? 1 : 0) + (b.parted ? 1 : 0));
}

std::uint64_t point_bytes(const SpoolBlock& b) {
  return sizeof(Vec3<float>) * static_cast<std::uint64_t>(b.points) * (b.velocities ? 2 : 1);
}

template <class T, int N>
bool same(const std::vector<Vec<T, N>>& a, const std::vector<Vec<T, N>>& b) {
  // As bytes, so that a NaN equals itself.
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}
bool same(const std::vector<Tri>& a, const std::vector<Tri>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Tri)) == 0);
}

template <int N>
std::vector<Vec<double, N>> in_double(const std::vector<Vec<float, N>>& values) {
  std::vector<Vec<double, N>> result;
  result.reserve(values.size());
  for (const auto& x : values) result.push_back(vec_cast<double>(x));
  return result;
}

bool in_range(const std::vector<Index>& labels, std::size_t count) {
  return std::all_of(labels.begin(), labels.end(), [&](Index label) {
    return label >= 0 && static_cast<std::size_t>(label) < count;
  });
}

bool in_range(const std::vector<Tri>& triangles, Index count) {
  return std::all_of(triangles.begin(), triangles.end(), [&](const Tri& t) {
    return std::all_of(t.v, t.v + 3, [&](Index v) { return v >= 0 && v < count; });
  });
}

}  // namespace

// --------------------------------------------------------------------------------------- reading
SpoolReader::SpoolReader(const fs::path& path)
    : path_(path), file_(open_regular_file(path, O_RDONLY, "read")) {
  struct stat status = {};
  if (::fstat(file_.number(), &status) != 0) fail_on(path, "read");
  size_ = static_cast<std::uint64_t>(status.st_size);
  read_header();
  read_index();
}

void SpoolReader::read_header() {
  RawHeader raw = {};
  if (read_at(path_, file_.number(), 0, &raw, sizeof raw) != sizeof raw)
    refuse(path_, "header", "something else");
  const bool placed = std::memcmp(raw.magic, placed_magic, sizeof placed_magic) == 0;
  if (!placed && std::memcmp(raw.magic, file_magic, sizeof file_magic) != 0)
    refuse(path_, "header", "something else");
  std::uint64_t names_begin = sizeof raw;
  if (placed) {
    if (read_at(path_, file_.number(), sizeof raw, origin_.e, sizeof origin_.e) !=
            sizeof origin_.e ||
        !std::isfinite(origin_[0]) || !std::isfinite(origin_[1]) || !std::isfinite(origin_[2]))
      refuse(path_, "origin", "no place");
    names_begin += sizeof origin_.e;
  }
  if (!std::isfinite(raw.frame_rate) || !(raw.frame_rate > 0))
    refuse(path_, "frame rate", "a value out of range");
  if (raw.mesh_count > max_meshes || raw.name_bytes > size_ - names_begin)
    refuse(path_, "meshes", std::to_string(raw.mesh_count));
  frame_rate_ = raw.frame_rate;
  std::string names(raw.name_bytes, '\0');
  if (read_at(path_, file_.number(), names_begin, names.data(), names.size()) != names.size())
    refuse(path_, "names", "end of file");
  for (std::size_t at = 0; at < names.size();) {
    const std::size_t end = names.find('\0', at);
    if (end == std::string::npos || end == at || end - at > max_name ||
        std::any_of(&names[at], &names[end], is_control))
      refuse(path_, "names", "a damaged list");
    std::string name = names.substr(at + 1, end - at - 1);
    if (names[at] == 'l' && !meshes_.empty() && !meshes_.back().part_names.empty()) {
      SpooledMesh& mesh = meshes_.back();
      mesh.part_labels.resize(mesh.part_names.size());
      mesh.part_labels.back() = std::move(name);
    } else if ((names[at] == 'g' || names[at] == 'p') && !meshes_.empty()) {
      SpooledMesh& mesh = meshes_.back();
      (names[at] == 'g' ? mesh.group_names : mesh.part_names).push_back(std::move(name));
    } else {
      meshes_.push_back({std::move(name), names[at] == 'o'});
    }
    at = end + 1;
  }
  for (SpooledMesh& mesh : meshes_)
    if (!mesh.part_labels.empty()) mesh.part_labels.resize(mesh.part_names.size());
  if (meshes_.size() != raw.mesh_count) refuse(path_, "names", std::to_string(meshes_.size()));
  ends_.push_back(names_begin + raw.name_bytes);
}

void SpoolReader::read_index() {
  std::uint64_t at = ends_[0];
  std::vector<SpoolBlock> current(meshes_.size());
  while (!meshes_.empty()) {
    const auto place = static_cast<std::uint32_t>(frames_.size());
    int frame = 0;
    for (std::uint32_t m = 0; m < meshes_.size(); ++m) {
      RawBlock raw = {};
      if (at + sizeof raw > size_) return;
      read_at(path_, file_.number(), at, &raw, sizeof raw);
      const auto allowed = [](std::int32_t n, std::int32_t low) {
        return n >= low && n <= max_entries;
      };
      if (m == 0) frame = raw.frame;
      const bool whole = raw.triangles >= 0;
      if (raw.magic != block_magic || raw.mesh != m || raw.frame != frame || frame < 0 ||
          (!frames_.empty() && frame <= frames_.back()) || !allowed(raw.points, -1) ||
          !allowed(raw.triangles, -1) || !allowed(raw.material, 0) ||
          !allowed(raw.material_triangles, 0) ||
          (place == 0 && (raw.points < 0 || raw.triangles < 0)))
        refuse(path_, "block at byte " + std::to_string(at), "damaged");
      SpoolBlock& b = current[m];
      b.offset = at + sizeof raw;
      b.checksum = raw.checksum;
      b.triangles = whole ? raw.triangles : 0;
      b.material = whole ? raw.material : 0;
      b.material_triangles = whole ? raw.material_triangles : 0;
      b.grouped = whole && (raw.flags & flag_grouped) != 0;
      b.parted = whole && (raw.flags & flag_parted) != 0;
      if (whole) b.topology_from = place;
      b.points = std::max(raw.points, 0);
      b.velocities = raw.points >= 0 && (raw.flags & flag_velocities) != 0;
      if (raw.points >= 0) b.points_from = place;
      const std::uint64_t payload = topology_bytes(b) + point_bytes(b);
      if (payload > size_ - b.offset) return;  // killed while it was written
      at = b.offset + payload;
    }
    frames_.push_back(frame);
    ends_.push_back(at);
    blocks_.insert(blocks_.end(), current.begin(), current.end());
  }
}

std::string SpoolReader::payload(const SpoolBlock& block) const {
  std::string bytes(topology_bytes(block) + point_bytes(block), '\0');
  if (read_at(path_, file_.number(), block.offset, bytes.data(), bytes.size()) != bytes.size() ||
      checksum_of(bytes) != block.checksum)
    refuse(path_, "block at byte " + std::to_string(block.offset), "a wrong checksum");
  return bytes;
}

Mesh SpoolReader::read(std::size_t frame, std::size_t mesh) const {
  const SpoolBlock& own = block(frame, mesh);
  Mesh result;
  {
    const SpoolBlock& from = block(own.topology_from, mesh);
    const std::string bytes = payload(from);
    const char* at = bytes.data();
    result.triangles = take<Tri>(at, from.triangles);
    result.material_triangles = take<Tri>(at, from.material_triangles);
    result.material = in_double(take<Vec2<float>>(at, from.material));
    if (from.grouped) result.group = take<Index>(at, from.triangles);
    if (from.parted) result.part = take<Index>(at, from.triangles);
    if (own.points_from == own.topology_from)
      result.positions = in_double(take<Vec3<float>>(at, from.points));
  }
  if (own.points_from != own.topology_from) {
    const SpoolBlock& from = block(own.points_from, mesh);
    const std::string bytes = payload(from);
    const char* at = bytes.data() + topology_bytes(from);
    result.positions = in_double(take<Vec3<float>>(at, from.points));
  }
  result.group_names = meshes_[mesh].group_names;
  result.part_names = meshes_[mesh].part_names;
  result.part_labels = meshes_[mesh].part_labels;
  const std::string field = "block at byte " + std::to_string(own.offset);
  if (result.triangles.empty()) refuse(path_, field, "no triangles");
  const bool one_each = result.material_triangles.empty();
  if (one_each ? !result.material.empty() && result.material.size() != result.positions.size()
               : result.material_triangles.size() != result.triangles.size())
    refuse(path_, field, "material coordinates of some corners only");
  if (!in_range(result.triangles, static_cast<Index>(result.positions.size())) ||
      !in_range(result.material_triangles, static_cast<Index>(result.material.size())))
    refuse(path_, field, "corners out of range");
  if (!in_range(result.group, result.group_names.size()) ||
      !in_range(result.part, result.part_names.size()))
    refuse(path_, field, "groups out of range");
  return result;
}

std::vector<Vec3<double>> SpoolReader::velocities(std::size_t frame, std::size_t mesh) const {
  const SpoolBlock& from = block(block(frame, mesh).points_from, mesh);
  if (!from.velocities) return {};
  const std::string bytes = payload(from);
  const char* at = bytes.data() + topology_bytes(from) +
                   sizeof(Vec3<float>) * static_cast<std::uint64_t>(from.points);
  return in_double(take<Vec3<float>>(at, from.points));
}

// --------------------------------------------------------------------------------------- writing
std::vector<SpooledMesh> spooled_meshes(const FrameMeshes& first) {
  std::vector<SpooledMesh> about;
  for (const bool obstacle : {false, true})
    for (const NamedMesh& named : obstacle ? first.obstacles : first.cloths)
      about.push_back({named.name, obstacle, named.mesh.group_names, named.mesh.part_names,
                       named.mesh.part_labels});
  return about;
}

SpoolWriter::SpoolWriter(const fs::path& path, double frame_rate, std::vector<SpooledMesh> meshes,
                         const Vec3<double>& origin)
    : path_(path),
      file_(open_regular_file(path, O_WRONLY | O_CREAT, "open for writing")),
      meshes_(std::move(meshes)),
      last_(meshes_.size()) {
  std::string names;
  const auto add_name = [&](char kind, const std::string& name) {
    names += kind;
    names += name;
    names += '\0';
  };
  for (const SpooledMesh& mesh : meshes_) {
    add_name(mesh.obstacle ? 'o' : 'c', mesh.name);
    for (const std::string& group : mesh.group_names)
      add_name('g', one_line(group).substr(0, max_name - 1));
    for (std::size_t p = 0; p < mesh.part_names.size(); ++p) {
      add_name('p', one_line(mesh.part_names[p]).substr(0, max_name - 1));
      if (p < mesh.part_labels.size() && !mesh.part_labels[p].empty())
        add_name('l', one_line(mesh.part_labels[p]).substr(0, max_name - 1));
    }
  }
  RawHeader raw = {};
  const bool placed = origin != Vec3<double>{0, 0, 0};
  std::memcpy(raw.magic, placed ? placed_magic : file_magic, sizeof raw.magic);
  raw.frame_rate = frame_rate;
  raw.mesh_count = static_cast<std::uint32_t>(meshes_.size());
  raw.name_bytes = static_cast<std::uint32_t>(names.size());
  std::string bytes;
  append_bytes(bytes, &raw, 1);
  if (placed) append_bytes(bytes, origin.e, 3);
  bytes += names;
  if (::ftruncate(file_.number(), 0) != 0) fail_on(path_, "write");
  write_all(path_, file_.number(), bytes);
}

SpoolWriter::SpoolWriter(const fs::path& path, int last_frame) : path_(path) {
  const SpoolReader reader(path);
  meshes_ = reader.meshes();
  last_.resize(meshes_.size());
  const auto& frames = reader.frames();
  const auto kept = static_cast<std::size_t>(
      std::upper_bound(frames.begin(), frames.end(), last_frame) - frames.begin());
  for (std::size_t m = 0; kept > 0 && m < meshes_.size(); ++m) {
    Mesh mesh = reader.read(kept - 1, m);
    last_[m] = {std::move(mesh.triangles),
                std::move(mesh.material_triangles),
                in_single(mesh.material),
                std::move(mesh.group),
                std::move(mesh.part),
                in_single(mesh.positions),
                in_single(reader.velocities(kept - 1, m))};
  }
  if (kept > 0) last_frame_ = frames[kept - 1];
  file_ = open_regular_file(path, O_WRONLY, "open for writing");
  if (::ftruncate(file_.number(), static_cast<off_t>(reader.bytes_of(kept))) != 0 ||
      ::lseek(file_.number(), 0, SEEK_END) < 0)
    fail_on(path_, "write");
}

void SpoolWriter::append(int frame, const std::vector<const Mesh*>& meshes,
                         const std::vector<std::vector<Vec3<double>>>& velocities) {
  if (meshes.size() != meshes_.size())
    throw SceneError(path_.string(), "meshes", std::to_string(meshes.size()),
                     std::to_string(meshes_.size()) + ", as in the first frame");
  if (frame <= last_frame_)
    throw SceneError(path_.string(), "frame", std::to_string(frame),
                     "more than " + std::to_string(last_frame_));
  std::string bytes;
  for (std::size_t m = 0; m < meshes.size(); ++m)
    add_block(bytes, frame, m, *meshes[m],
              m < velocities.size() ? velocities[m] : std::vector<Vec3<double>>());
  write_all(path_, file_.number(), bytes);
  last_frame_ = frame;
}

void SpoolWriter::append(int frame, const FrameMeshes& meshes) {
  std::vector<const Mesh*> list;
  for (const NamedMesh& mesh : meshes.cloths) list.push_back(&mesh.mesh);
  for (const NamedMesh& mesh : meshes.obstacles) list.push_back(&mesh.mesh);
  append(frame, list, meshes.cloth_velocities);
}

void SpoolWriter::add_block(std::string& bytes, int frame, std::size_t mesh, const Mesh& content,
                            const std::vector<Vec3<double>>& velocities) {
  const SpooledMesh& about = meshes_[mesh];
  // A label a triangle, of the names that the spool knows, or none at all.
  const auto labels = [&](const std::vector<Index>& all, const std::vector<std::string>& names) {
    const bool known = all.size() == content.triangles.size() && in_range(all, names.size());
    return known ? all : std::vector<Index>();
  };
  Last now{content.triangles,
           content.material_triangles,
           in_single(content.material),
           labels(content.group, about.group_names),
           labels(content.part, about.part_names),
           in_single(content.positions),
           {}};
  if (velocities.size() == content.positions.size()) now.velocities = in_single(velocities);
  Last& before = last_[mesh];
  const bool first = last_frame_ < 0;
  const bool same_topology = !first && same(now.triangles, before.triangles) &&
                             same(now.material_triangles, before.material_triangles) &&
                             same(now.material, before.material) && now.group == before.group &&
                             now.part == before.part;
  const bool same_points =
      !first && same(now.points, before.points) && same(now.velocities, before.velocities);
  std::string payload;
  if (!same_topology) {
    append_bytes(payload, now.triangles.data(), now.triangles.size());
    append_bytes(payload, now.material_triangles.data(), now.material_triangles.size());
    append_bytes(payload, now.material.data(), now.material.size());
    append_bytes(payload, now.group.data(), now.group.size());
    append_bytes(payload, now.part.data(), now.part.size());
  }
  if (!same_points) {
    append_bytes(payload, now.points.data(), now.points.size());
    append_bytes(payload, now.velocities.data(), now.velocities.size());
  }
  RawBlock raw = {};
  raw.magic = block_magic;
  raw.frame = frame;
  raw.mesh = static_cast<std::uint32_t>(mesh);
  raw.points = same_points ? -1 : static_cast<std::int32_t>(now.points.size());
  raw.triangles = same_topology ? -1 : static_cast<std::int32_t>(now.triangles.size());
  raw.material = same_topology ? 0 : static_cast<std::int32_t>(now.material.size());
  raw.material_triangles =
      same_topology ? 0 : static_cast<std::int32_t>(now.material_triangles.size());
  if (!same_topology && !now.group.empty()) raw.flags |= flag_grouped;
  if (!same_topology && !now.part.empty()) raw.flags |= flag_parted;
  if (!same_points && !now.velocities.empty()) raw.flags |= flag_velocities;
  raw.checksum = checksum_of(payload);
  append_bytes(bytes, &raw, 1);
  bytes += payload;
  before = std::move(now);
}

void SpoolWriter::sync() const {
  if (::fsync(file_.number()) != 0) fail_on(path_, "fsync");
}

}  // namespace weft::io
