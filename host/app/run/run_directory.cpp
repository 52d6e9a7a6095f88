#include "host/app/run/run_directory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <regex>
#include <string>
#include <system_error>
#include <utility>

#include "host/app/run/output_folder.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_operations.hpp"
#include "host/time_parallel/material_frame.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t checkpoints_kept = 2;

const std::regex frame_name(R"((?:cloth|obstacle)_(\d{5,9})\.(?:obj|ply))");
const std::regex displaced_name(R"(displaced_(\d{5,9})\.obj)");
const std::regex cache_name(R"((?:cloth|obstacle)\.[A-Za-z0-9_-]+\.pc2)");
/// Files that hold all frames of a mesh or of the run, and the meshes that they move.
const std::regex joint_name(
    R"((?:cloth|obstacle)\.[A-Za-z0-9_-]+\.(?:pc2|obj|origin\.json)|animation\.(?:usda|glb)(?:\.spool)?|obstacle\.(?:obj|ply))");
const std::regex checkpoint_name(R"(checkpoint_(\d{5,9})\.weft)");
const std::regex single_name(R"(report\.json|steps\.jsonl|preview\.png|failure\.png|scene\.json)");
const std::regex end_name(R"(report\.json|preview\.png|failure\.png)");
/// Of the method "time_parallel" and of --need, which remove them themselves.
const std::regex method_name(R"(partition\.json|need\.json)");
/// What an atomic write leaves behind if it is killed.
const std::regex temporary_name(
    R"(\.(?:cloth[_.]|obstacle[_.]|animation\.|displaced_|checkpoint_|report\.|steps\.|preview\.|failure\.|scene\.).*\.tmp)");

bool matches(const fs::path& path, const std::regex& pattern) {
  return std::regex_match(path.filename().string(), pattern);
}

/// The number in a name, if it is of this pattern.
std::optional<int> number_of(const fs::path& path, const std::regex& pattern) {
  std::smatch match;
  const std::string name = path.filename().string();
  if (!std::regex_match(name, match, pattern)) return std::nullopt;
  return std::stoi(match[1]);
}

bool is_of_run(const fs::path& path) {
  const auto names = {&frame_name,      &displaced_name, &joint_name,
                      &checkpoint_name, &single_name,    &method_name};
  return std::any_of(names.begin(), names.end(),
                     [&](const std::regex* name) { return matches(path, *name); });
}

/// Whether all triangles of one group are of one part, too.
bool divides(const std::vector<Index>& group, const std::vector<Index>& part, std::size_t groups) {
  std::vector<Index> part_of(groups, -1);
  for (std::size_t t = 0; t < group.size(); ++t) {
    Index& own = part_of[static_cast<std::size_t>(group[t])];
    if (own >= 0 && own != part[t]) return false;
    own = part[t];
  }
  return true;
}

/// The panels of a cloth as parts: its groups or its parts. Of a sewing pattern with labels groups
/// are panels and parts are labels: the groups then divide the parts.
void add_panels(const Mesh& from, Mesh& to) {
  const std::size_t triangles = to.triangles.size();
  const bool groups = from.group.size() == triangles, parts = from.part.size() == triangles;
  if (!groups && !parts) return;
  const bool labelled = groups && parts && from.group_names.size() > from.part_names.size() &&
                        divides(from.group, from.part, from.group_names.size());
  const bool take_groups = labelled || !parts;
  to.part = take_groups ? from.group : from.part;
  to.part_names = take_groups ? from.group_names : from.part_names;
  if (!labelled) return;
  to.part_labels.resize(to.part_names.size());
  for (std::size_t t = 0; t < triangles; ++t)
    to.part_labels[static_cast<std::size_t>(to.part[t])] =
        from.part_names[static_cast<std::size_t>(from.part[t])];
}

/// Materials as groups, and panels as parts.
void add_groups(const Scene& scene, const Cloth& cloth, const Mesh& from, Mesh& to) {
  const std::size_t triangles = to.triangles.size();
  for (const Material& material : scene.materials) to.group_names.push_back(material.name);
  const bool each = cloth.triangle_material.size() == triangles;
  to.group = each ? cloth.triangle_material : std::vector<Index>(triangles, cloth.material);
  add_panels(from, to);
}

void write_meshes(const fs::path& stem, FrameFormat format, Precision precision,
                  const std::vector<io::NamedMesh>& meshes) {
  if (format == FrameFormat::ply)
    io::write_ply(stem.string() + ".ply", meshes, precision, io::Normals::vertex);
  else
    io::write_obj(stem.string() + ".obj", meshes, io::Normals::vertex, io::Groups::panels);
}

}  // namespace

FrameMeshes frame_meshes(const Scene& scene, const Frame& frame) {
  return frame_meshes(scene, frame, cloth_meshes(scene));
}

FrameMeshes frame_meshes(const Scene& scene, const Frame& frame,
                         const std::vector<const Mesh*>& cloths) {
  FrameMeshes meshes;
  meshes.origin = frame.origin;
  for (std::size_t i = 0; i < scene.cloths.size(); ++i) {
    const Mesh& mesh = *cloths[i];
    meshes.cloths.push_back({scene.cloths[i].name,
                             {frame.cloth_positions[i],
                              mesh.material,
                              mesh.triangles,
                              mesh.material_triangles,
                              {},
                              {}}});
    add_groups(scene, scene.cloths[i], mesh, meshes.cloths.back().mesh);
  }
  meshes.cloth_velocities = frame.cloth_velocities;
  const bool displaced = frame.any_displaced();
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const auto at = [&](const std::vector<Vec3<double>>& positions) {
      return io::NamedMesh{scene.obstacles[i].name,
                           {positions, {}, scene.obstacles[i].mesh.triangles, {}, {}, {}}};
    };
    meshes.obstacles.push_back(at(frame.obstacle_positions[i]));
    if (displaced) meshes.displaced.push_back(at(frame.simulated_obstacle(i)));
  }
  return meshes;
}

fs::path RunDirectory::checkpoint(int frame) const {
  return path_ / fmt::format("checkpoint_{:05}.weft", frame);
}

fs::path RunDirectory::displaced(int frame) const {
  return displaced() / fmt::format("displaced_{:05}.obj", frame);
}

fs::path RunDirectory::cache(const std::string& name, bool obstacle) const {
  return frames() / ((obstacle ? "obstacle." : "cloth.") + name + ".pc2");
}

fs::path RunDirectory::cached_mesh(const std::string& name, bool obstacle) const {
  return cache(name, obstacle).replace_extension(".obj");
}

std::vector<fs::path> RunDirectory::caches() const {
  std::vector<fs::path> files = files_in(frames());
  std::erase_if(files, [](const fs::path& file) { return !matches(file, cache_name); });
  return files;
}

void RunDirectory::create() const {
  make_output_folder(frames());
}

bool RunDirectory::holds_run() const {
  const auto any = [](const fs::path& directory) {
    const auto files = files_in(directory);
    return std::any_of(files.begin(), files.end(), is_of_run);
  };
  const auto files = files_in(path_);
  return any(frames()) || any(displaced()) ||
         std::any_of(files.begin(), files.end(), [&](const fs::path& file) {
           return is_of_run(file) && file.filename() != failure().filename();
         });
}

void RunDirectory::refuse_run() const {
  if (!holds_run()) return;
  // The method "time_parallel" goes on from its partition.
  const bool resumable = !checkpoints().empty() || is_there(path_ / "partition.json");
  throw SceneError(path_.string(), "-o", "a directory that holds another run",
                   std::string("another directory, ") +
                       (resumable ? "--resume latest to continue that run, " : "") +
                       "or --overwrite to replace it");
}

void RunDirectory::refuse_links() const {
  const auto refuse = [](const fs::path& path) {
    throw SceneError(path.string(), "-o", "a symbolic link in a directory of a run",
                     "files and folders of the directory itself");
  };
  std::error_code error;
  for (const fs::path& folder : {frames(), displaced()})
    if (fs::is_symlink(folder, error)) refuse(folder);
  for (const fs::path& directory : {path_, frames(), displaced()})
    for (const fs::path& file : files_in(directory))
      if (fs::is_symlink(file, error) && is_of_run(file)) refuse(file);
}

void RunDirectory::clear_frames() const {
  for (const auto& file : files_in(frames()))
    if (matches(file, frame_name) || matches(file, joint_name) || matches(file, temporary_name))
      remove_file(file);
  remove_displaced_after(-1);
}

void RunDirectory::clear() const {
  clear_frames();
  for (const auto& file : files_in(path_))
    if (matches(file, checkpoint_name) || matches(file, single_name) ||
        matches(file, temporary_name))
      remove_file(file);
}

void RunDirectory::remove_displaced_after(int frame) const {
  for (const auto& file : files_in(displaced()))
    if (number_of(file, displaced_name).value_or(-1) > frame || matches(file, temporary_name))
      remove_file(file);
  std::error_code error;
  fs::remove(displaced(), error);  // fails if it is not empty
}

void RunDirectory::clear_after(int frame, const fs::path& keep) const {
  for (const auto& file : files_in(frames()))
    if (number_of(file, frame_name).value_or(-1) > frame || matches(file, temporary_name))
      remove_file(file);
  remove_displaced_after(frame);
  std::error_code error;
  for (const auto& file : files_in(path_)) {
    const bool later = number_of(file, checkpoint_name).value_or(-1) > frame;
    if ((later && !fs::equivalent(file, keep, error)) || matches(file, end_name) ||
        matches(file, temporary_name))
      remove_file(file);
  }
}

std::vector<fs::path> RunDirectory::checkpoints() const {
  std::vector<std::pair<int, fs::path>> found;
  for (const auto& file : files_in(path_))
    if (const auto number = number_of(file, checkpoint_name); number && is_file(file))
      found.emplace_back(*number, file);
  std::sort(found.rbegin(), found.rend());
  std::vector<fs::path> files;
  for (auto& [number, file] : found) files.push_back(std::move(file));
  return files;
}

void RunDirectory::save_checkpoint(const fs::path& file, const std::string& state) const {
  write_file_atomically(file, state);
  const std::vector<fs::path> all = checkpoints();
  for (std::size_t i = checkpoints_kept; i < all.size(); ++i)
    if (all[i] != file) remove_file(all[i]);
}

void RunDirectory::write_frame(const Scene& scene, const FrameMeshes& meshes, int number,
                               Obstacles obstacles) const {
  const bool far = meshes.origin != Vec3<double>{0, 0, 0};
  if (far)
    return write_frame(scene, io::in_world(meshes), number, obstacles, Precision::double_precision);
  write_frame(scene, meshes, number, obstacles, scene.precision);
}

void RunDirectory::write_frame(const Scene& scene, const FrameMeshes& meshes, int number,
                               Obstacles obstacles, Precision precision) const {
  // The obstacle first: a cloth frame without its obstacle could not be checked.
  if (!meshes.obstacles.empty() && obstacles != Obstacles::none)
    write_meshes(
        frames() / (obstacles == Obstacles::of_all_frames ? std::string("obstacle")
                                                          : fmt::format("obstacle_{:05}", number)),
        scene.output.format, Precision::double_precision, meshes.obstacles);
  write_meshes(frames() / fmt::format("cloth_{:05}", number), scene.output.format, precision,
               meshes.cloths);
}

std::optional<Mesh> RunDirectory::read_displaced(int number) const {
  const fs::path file = displaced(number);
  if (!is_there(file)) return std::nullopt;
  return io::read_mesh(file, io::Uv::ignore);
}

void RunDirectory::write_displaced(const FrameMeshes& meshes, int number) const {
  const fs::path file = displaced(number);
  if (meshes.displaced.empty()) return remove_file(file);
  make_output_folder(displaced());
  io::write_obj(file, io::in_world(meshes).displaced, io::Normals::vertex);
}

}  // namespace weft::app
