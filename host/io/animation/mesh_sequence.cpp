#include "host/io/animation/mesh_sequence.hpp"
#include "host/base/file_extension.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <utility>

#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "host/io/spool/frame_spool.hpp"
#include "host/io/usd/usd_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

constexpr int max_frame = 999'999'999;

/// Frames a second of a run, if its scene.json says.
std::optional<double> frame_rate_of(const fs::path& run) {
  const fs::path file = run / "scene.json";
  if (!is_file(file)) return {};
  const auto scene = nlohmann::json::parse(read_file_bytes(file), nullptr, false);
  if (!scene.is_object() || !scene.contains("time") || !scene["time"].is_object()) return {};
  const auto& time = scene["time"];
  if (!time.contains("frame_rate") || !time["frame_rate"].is_number()) return {};
  const double rate = time["frame_rate"].get<double>();
  return std::isfinite(rate) && rate > 0 ? std::optional(rate) : std::nullopt;
}

/// Groups beside objects are panels.
Mesh with_panels(Mesh mesh) {
  if (mesh.object.empty() || !mesh.part.empty()) return mesh;
  mesh.part = mesh.group;
  mesh.part_names = mesh.group_names;
  return mesh;
}

/// Numbered meshes: cloths and perhaps obstacles, a file a frame.
class NumberedFiles final : public MeshSequence {
 public:
  using Files = std::map<int, fs::path>;

  /// @param still obstacles of the frames without a file of their own; empty: none
  /// @throws SceneError if there is no frame, or a cloth has no obstacle although others have
  NumberedFiles(const fs::path& where, Files cloths, Files obstacles, fs::path still, Uv uv,
                std::vector<std::string> allowed)
      : cloths_(std::move(cloths)),
        obstacles_(std::move(obstacles)),
        still_(std::move(still)),
        uv_(uv),
        allowed_(std::move(allowed)) {
    if (cloths_.empty())
      throw SceneError(where.string(), "frames", "no frame",
                       "the folder of a run, or at least one numbered mesh");
    for (const auto& [number, file] : cloths_) {
      frames_.push_back(number);
      if (!obstacles_.empty() && still_.empty() && !obstacles_.contains(number))
        throw SceneError(file.string(), "obstacle", "no mesh of this number",
                         "an obstacle for every frame, or for none");
    }
    if (const auto rate = frame_rate_of(where)) frame_rate_ = *rate;
  }

  FrameMeshes read(std::size_t place) const override {
    const int number = frames_[place];
    FrameMeshes meshes;
    meshes.joined = true;
    // Not Uv::material, with which polygons of one frame are split otherwise than those of another.
    Mesh cloth = read(cloths_.at(number), uv_ == Uv::ignore ? uv_ : Uv::where_some);
    if (uv_ != Uv::where_some) drop_incomplete_material(cloth);
    meshes.cloths.push_back({"cloth", std::move(cloth)});
    const auto obstacle = obstacles_.find(number);
    const fs::path& file = obstacle != obstacles_.end() ? obstacle->second : still_;
    if (!file.empty()) meshes.obstacles.push_back({"obstacle", read(file, Uv::ignore)});
    return meshes;
  }
  std::string describe(std::size_t place) const override {
    return cloths_.at(frames_[place]).string();
  }

 private:
  Mesh read(const fs::path& file, Uv uv) const {
    return with_panels(read_mesh(file, uv, ReadableFolders(file, allowed_)));
  }

  Files cloths_;
  Files obstacles_;
  fs::path still_;
  Uv uv_;
  std::vector<std::string> allowed_;
};

/// Meshes whose points stand in caches, or that do not move.
class CachedMeshes final : public MeshSequence {
 public:
  struct Member {
    fs::path topology;
    std::string name;
    bool obstacle = false;
    fs::path cache;  ///< empty: does not move
  };

  CachedMeshes(fs::path where, const std::vector<Member>& members, Uv uv)
      : where_(std::move(where)) {
    for (const Member& member : members) add(member, uv);
    std::optional<PointCacheHeader> first;
    Index samples = 0;
    for (const Part& part : parts_) {
      if (!part.cache) continue;
      const PointCacheHeader& header = part.cache->header();
      if (first &&
          (header.start_frame != first->start_frame || header.sample_rate != first->sample_rate))
        throw SceneError(part.cache->path().string(), "start frame and sample rate",
                         "other values than in the caches beside it", "the same in all");
      // A run that was killed may have written one cache further than another.
      samples = first ? std::min(samples, header.sample_count) : header.sample_count;
      if (!first) first = header;
    }
    if (!first || samples == 0)
      throw SceneError(where_.string(), "frames", "no frame", "point caches with samples");
    for (Index k = 0; k < samples; ++k) {
      const double number = first->start_frame + k * first->sample_rate;
      if (!(number >= 0 && number <= max_frame))
        throw SceneError(where_.string(), "frame", std::to_string(number), "0 to 999999999");
      // Samples between whole frames are counted through.
      frames_.push_back(first->sample_rate >= 1 ? static_cast<int>(std::lround(number)) : k);
    }
  }

  FrameMeshes read(std::size_t place) const override {
    FrameMeshes meshes;
    if (!parts_.empty()) meshes.origin = parts_.front().origin;
    for (const Part& part : parts_) {
      NamedMesh mesh = part.mesh;
      if (part.cache) part.cache->read(static_cast<Index>(place), mesh.mesh.positions);
      move_origin(mesh.mesh, part.origin, meshes.origin);
      (part.obstacle ? meshes.obstacles : meshes.cloths).push_back(std::move(mesh));
    }
    return meshes;
  }
  std::string describe(std::size_t place) const override {
    return where_.string() + ": frame " + std::to_string(frames_[place]);
  }
  void set_frame_rate(double rate) { frame_rate_ = rate; }

 private:
  struct Part {
    NamedMesh mesh;
    bool obstacle = false;
    std::unique_ptr<PointCache> cache;
    Vec3<double> origin{0, 0, 0};  ///< [m] of mesh and cache
  };

  void add(const Member& member, Uv uv) {
    const bool with_uv = !member.obstacle && uv != Uv::ignore;
    Part part{{member.name,
               with_panels(read_mesh(member.topology, with_uv ? Uv::where_all : Uv::ignore))},
              member.obstacle,
              nullptr,
              read_cache_origin(member.topology)};
    if (!member.cache.empty()) {
      part.cache = std::make_unique<PointCache>(member.cache);
      const auto count = static_cast<std::size_t>(part.cache->point_count());
      if (count != part.mesh.mesh.positions.size())
        throw SceneError(member.cache.string(), "points", std::to_string(count),
                         std::to_string(part.mesh.mesh.positions.size()) + ", as in " +
                             member.topology.string());
    }
    parts_.push_back(std::move(part));
  }

  fs::path where_;
  std::vector<Part> parts_;
};

/// The spool of a run that has not ended.
class SpooledMeshes final : public MeshSequence {
 public:
  SpooledMeshes(const fs::path& path, Uv uv) : reader_(path), uv_(uv) {
    frames_ = reader_.frames();
    frame_rate_ = reader_.frame_rate();
    if (frames_.empty())
      throw SceneError(path.string(), "frames", "no frame", "at least one whole frame");
  }

  FrameMeshes read(std::size_t place) const override {
    FrameMeshes meshes;
    meshes.origin = reader_.origin();
    for (std::size_t m = 0; m < reader_.meshes().size(); ++m) {
      const SpooledMesh& about = reader_.meshes()[m];
      if (!about.obstacle) meshes.cloth_velocities.push_back(reader_.velocities(place, m));
      NamedMesh mesh{about.name, reader_.read(place, m)};
      require_finite(mesh.mesh.positions, place, about.name);
      require_finite(mesh.mesh.material, place, about.name);
      if (uv_ == Uv::ignore) {
        mesh.mesh.material.clear();
        mesh.mesh.material_triangles.clear();
      }
      (about.obstacle ? meshes.obstacles : meshes.cloths).push_back(std::move(mesh));
    }
    return meshes;
  }
  std::string describe(std::size_t place) const override {
    return reader_.path().string() + ": frame " + std::to_string(frames_[place]);
  }

 private:
  template <int N>
  void require_finite(const std::vector<Vec<double, N>>& values, std::size_t place,
                      const std::string& name) const {
    for (const Vec<double, N>& x : values)
      for (int k = 0; k < N; ++k)
        if (!std::isfinite(x[k]))
          throw SceneError(describe(place), name, std::isnan(x[k]) ? "nan" : "inf",
                           "finite numbers");
  }

  SpoolReader reader_;
  Uv uv_;
};

class UsdMeshes final : public MeshSequence {
 public:
  UsdMeshes(const fs::path& path, Uv uv) : path_(path), file_(path), uv_(uv) {
    frame_rate_ = file_.frame_rate();
    const auto& times = file_.times();
    const bool whole = std::all_of(times.begin(), times.end(), [](double t) {
      return t >= 0 && t <= max_frame && t == std::floor(t);
    });
    // Time codes between whole frames are counted through.
    for (std::size_t k = 0; k < times.size(); ++k)
      frames_.push_back(whole ? static_cast<int>(times[k]) : static_cast<int>(k));
  }

  FrameMeshes read(std::size_t place) const override {
    FrameMeshes meshes;
    meshes.origin = file_.origin(0);
    for (std::size_t m = 0; m < file_.meshes().size(); ++m) {
      const UsdMeshPrim& prim = file_.meshes()[m];
      Mesh mesh = file_.read(m, file_.times()[place], prim.obstacle ? Uv::ignore : uv_);
      move_origin(mesh, file_.origin(m), meshes.origin);
      if (!prim.obstacle)
        meshes.cloth_velocities.push_back(file_.velocities(m, file_.times()[place]));
      (prim.obstacle ? meshes.obstacles : meshes.cloths).push_back({prim.name, std::move(mesh)});
    }
    return meshes;
  }
  std::string describe(std::size_t place) const override {
    return path_.string() + ": frame " + std::to_string(frames_[place]);
  }

 private:
  fs::path path_;
  UsdFile file_;
  Uv uv_;
};

/// cloth.NAME.obj and obstacle.NAME.obj, with .pc2 beside them.
std::vector<CachedMeshes::Member> cached_members(const fs::path& frames) {
  static const std::regex pattern(R"((cloth|obstacle)\.(.+)\.obj)");
  std::vector<CachedMeshes::Member> members;
  for (const fs::path& file : files_in(frames)) {
    std::smatch match;
    const std::string name = file.filename().string();
    if (!std::regex_match(name, match, pattern)) continue;
    CachedMeshes::Member member{file, match[2], match[1] == "obstacle", file};
    member.cache.replace_extension(".pc2");
    if (member.obstacle && !is_there(member.cache)) member.cache.clear();
    members.push_back(std::move(member));
  }
  return members;
}

std::unique_ptr<MeshSequence> open_run(const fs::path& run, Uv uv,
                                       const std::vector<std::string>& allowed) {
  const fs::path frames = is_folder(run / "frames") ? run / "frames" : run;
  const fs::path usd = frames / "animation.usda";
  // The spool first: as long as there is one it knows more than the file.
  for (const char* name : {"animation.usda.spool", "animation.glb.spool"})
    if (is_there(frames / name)) return std::make_unique<SpooledMeshes>(frames / name, uv);
  if (is_there(usd)) return std::make_unique<UsdMeshes>(usd, uv);
  const auto members = cached_members(frames);
  if (!members.empty()) {
    auto sequence = std::make_unique<CachedMeshes>(frames, members, uv);
    if (const auto rate = frame_rate_of(run)) sequence->set_frame_rate(*rate);
    return sequence;
  }
  static const std::regex pattern(R"((cloth|obstacle)_(\d{1,9})\.(obj|ply))");
  NumberedFiles::Files cloths, obstacles;
  for (const fs::path& file : files_in(frames)) {
    std::smatch match;
    const std::string name = file.filename().string();
    if (std::regex_match(name, match, pattern))
      (match[1] == "cloth" ? cloths : obstacles).emplace(std::stoi(match[2]), file);
  }
  return std::make_unique<NumberedFiles>(run, std::move(cloths), std::move(obstacles),
                                         still_obstacles(frames), uv, allowed);
}

std::unique_ptr<MeshSequence> open_numbered(const fs::path& path, const NumberedName& name, Uv uv,
                                            const std::vector<std::string>& allowed) {
  NumberedFiles::Files files;
  const fs::path directory = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (const fs::path& file : files_in(directory)) {
    const int number = name.number_in(file.filename().string());
    if (number >= 0) files.emplace(number, file);
  }
  if (files.empty())
    throw SceneError(path.string(), "frames", "no file of this pattern", "at least one");
  return std::make_unique<NumberedFiles>(path, std::move(files), NumberedFiles::Files(), fs::path(),
                                         uv, allowed);
}

std::unique_ptr<MeshSequence> open_cache(const fs::path& path, Uv uv) {
  for (const char* extension : {".obj", ".ply"}) {
    fs::path topology = path;
    topology.replace_extension(extension);
    if (!is_there(topology)) continue;
    const CachedMeshes::Member member{topology, path.stem().string(), false, path};
    return std::make_unique<CachedMeshes>(path, std::vector{member}, uv);
  }
  throw SceneError(path.string(), "topology", "no " + path.stem().string() + ".obj beside it",
                   "a point cache beside the mesh, .obj or .ply, whose points it moves");
}

}  // namespace

NumberedName::NumberedName(const std::string& pattern) : before_(pattern) {
  const std::size_t percent = pattern.find('%');
  if (percent == std::string::npos) return;
  // By hand: a pattern may be of any length, and std::regex recurses character by character.
  std::size_t at = percent + 1;
  width_ = 1;
  if (at + 1 < pattern.size() && pattern[at] == '0' && pattern[at + 1] >= '1' &&
      pattern[at + 1] <= '9') {
    width_ = static_cast<std::size_t>(pattern[at + 1] - '0');
    at += 2;
  }
  if (at >= pattern.size() || pattern[at] != 'd' || pattern.find('%', at) != std::string::npos)
    throw SceneError("", "name of a sequence of files", quoted_start(pattern),
                     "one place for a number, such as %05d");
  has_place_ = true;
  before_ = pattern.substr(0, percent);
  after_ = pattern.substr(at + 1);
}

std::string NumberedName::with(int number) const {
  if (!has_place_) return before_;
  const std::string digits = std::to_string(number);
  return before_ + std::string(width_ - std::min(width_, digits.size()), '0') + digits + after_;
}

int NumberedName::number_in(const std::string& name) const {
  if (!has_place_ || name.size() <= before_.size() + after_.size() || !name.starts_with(before_) ||
      !name.ends_with(after_))
    return -1;
  const std::string digits =
      name.substr(before_.size(), name.size() - before_.size() - after_.size());
  const bool good =
      digits.size() >= width_ && digits.size() <= 9 &&
      std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  return good ? std::stoi(digits) : -1;
}

fs::path still_obstacles(const fs::path& frames) {
  for (const char* name : {"obstacle.obj", "obstacle.ply"})
    if (is_file(frames / name)) return frames / name;
  return {};
}

bool has_frame_caches(const fs::path& frames) {
  for (const char* name : {"animation.usda", "animation.usda.spool", "animation.glb.spool"})
    if (is_there(frames / name)) return true;
  return !cached_members(frames).empty();
}

std::unique_ptr<MeshSequence> open_sequence(const fs::path& path, Uv uv,
                                            const std::vector<std::string>& allowed) {
  if (is_folder(path)) return open_run(path, uv, allowed);
  const NumberedName name(path.filename().string());
  if (name.has_place()) return open_numbered(path, name, uv, allowed);
  const std::string extension = lower_extension(path);
  if (extension == ".pc2") return open_cache(path, uv);
  if (extension == ".usda") return std::make_unique<UsdMeshes>(path, uv);
  if (extension == ".spool") return std::make_unique<SpooledMeshes>(path, uv);
  if (!is_there(path)) fail_on(path, "read", ENOENT);
  return std::make_unique<NumberedFiles>(path, NumberedFiles::Files{{0, path}},
                                         NumberedFiles::Files(), fs::path(), uv, allowed);
}

}  // namespace weft::io
