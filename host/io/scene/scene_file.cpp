#include "host/io/scene/scene_file.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/file_bytes.hpp"
#include "host/exec/device_text.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/arcsim/arcsim_scene.hpp"
#include "host/io/json/overrides.hpp"
#include "host/io/scene/scene_fabrics.hpp"
#include "host/io/scene/scene_garments.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/scene/camera.hpp"
#include "host/scene/defaults.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

void refuse_mesh(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  for (const char* mesh : {".obj", ".ply", ".usda", ".glb"})
    if (ending == mesh)
      throw SceneError(path.string(), "scene", "a mesh file",
                       "a scene file, such as \"weft new\" writes for meshes");
}

}  // namespace

SceneFile read_scene_file(const std::filesystem::path& path,
                          const std::vector<std::string>& overrides,
                          const std::vector<std::string>& allowed,
                          const std::vector<std::string>& experimental) {
  SceneFile result;
  Scene& scene = result.scene;
  scene.file = path.string();
  refuse_mesh(path);
  nlohmann::json document = parse_json(read_file_bytes(path), scene.file);
  ReadableFolders folders(path, allowed);
  if (is_arcsim_scene(document)) {
    ArcsimScene translated = weft_scene_of(document, path, allowed);
    folders = arcsim_folders(path, allowed);
    document = std::move(translated.scene);
    scene.warnings = std::move(translated.warnings);
  }
  for (const auto& folder : folders.folders()) result.folders.push_back(folder.string());
  for (const std::string& text : overrides) apply_override(document, text, scene.file);
  for (const std::string& text : experimental) apply_experimental(document, text, scene.file);
  const bool triangles_overridden =
      std::any_of(overrides.begin(), overrides.end(),
                  [](const std::string& text) { return text.starts_with("triangles="); });

  const nlohmann::json experimental_values = read_experimental(document, scene);
  name_materials_of_fabrics(document, scene.file, scene.warnings);
  Fields root(
      document, result.resolved, scene.file, "",
      {"name",      "description", "triangles", "gravity",   "time",   "materials", "cloths",
       "obstacles", "pins",        "handles",   "seams",     "refine", "bending",   "wind",
       "contact",   "solver",      "method",    "precision", "output", "camera",    "jitter",
       "remeshing", "model",       "device",    "units",     "up",     "garments"});
  scene.name = root.text("name", one_line(path.stem().string()));
  root.text("description", "");
  result.device = root.text("device", "auto");
  if (!is_device_text(result.device)) root.refuse("device", device_texts);
  const auto triangles = root.integer("triangles", 20000, 100, 40'000'000);
  read_settings(root, scene);
  read_adaptive(root, scene);
  scene.materials = read_materials(root);
  std::vector<ClothGroup> groups =
      read_cloths(root, folders, static_cast<double>(triangles), triangles_overridden, scene);
  std::vector<GarmentCloth> garments = read_garments(root, folders, scene, groups);
  if (scene.cloths.empty()) root.refuse("cloths", "at least one cloth, or garments");
  const double edge = mean_cell_edge(scene.cloths);
  if (!std::isfinite(edge) || !(edge > 0))
    root.refuse("cloths", "triangles without a finite area", "triangles with an area");
  read_contact(root, scene);
  read_obstacles(root, folders, edge, scene);
  sew_garments(garments, scene);
  read_pins(root, groups, scene);
  read_handles(root, groups, scene);
  attach_garments(garments, scene);
  read_seams(root, groups, scene);
  read_refinement(root, scene);
  read_precision(root, scene);
  read_jitter(root, edge, scene);
  read_wind(root, scene);
  read_camera(root, scene);
  read_model(root, scene);
  hide_experimental(result.resolved);
  if (!experimental_values.is_null()) root.record(experimental_key, experimental_values);
  validate(scene);
  warn_of_mistakes(result.resolved, groups, scene);
  return result;
}

Scene read_scene(const std::filesystem::path& path, const std::vector<std::string>& overrides,
                 const std::vector<std::string>& allowed,
                 const std::vector<std::string>& experimental) {
  return read_scene_file(path, overrides, allowed, experimental).scene;
}

nlohmann::json resolved_scene_json(const std::filesystem::path& path,
                                   const std::vector<std::string>& overrides) {
  return read_scene_file(path, overrides).resolved;
}

Scene read_scene_settings(const std::filesystem::path& path) {
  Scene scene;
  scene.file = path.string();
  nlohmann::json document = parse_json(read_file_bytes(path), scene.file);
  read_experimental(document, scene);
  nlohmann::json scratch;
  Fields root(document, scratch, scene.file, "", {});
  scene.name = root.text("name", one_line(path.stem().string()));
  read_settings(root, scene);
  if (!(scene.time.frame_rate > 0)) root.refuse("time", "a frame_rate > 0");
  read_contact(root, scene);
  read_camera(root, scene);
  validate_camera(scene.camera, scene.file);
  validate_view(scene);
  return scene;
}

}  // namespace weft::io
