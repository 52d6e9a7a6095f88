#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/input/readable_folders.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/json/transform_fields.hpp"
#include "weft/scene.hpp"

/// Readers of the parts of a scene, in the order in which read_scene_file() calls them. All throw
/// SceneError.
namespace weft::io {

/// A part of a cloth's border with a name.
struct ClothEdge {
  std::vector<Index> vertices;  ///< in order along the edge
  bool closed = false;          ///< the last is a neighbour of the first
};

/// One entry of "cloths": the cloths made of it, which are several if it has copies.
struct ClothGroup {
  std::string name;
  Index first = 0;  ///< into Scene::cloths
  Index count = 1;
  std::optional<std::array<Index, 2>> cells;  ///< of a grid or panel
  std::map<std::string, ClothEdge> edges;     ///< none of a mesh file
};

/// Most triangles that the grids and primitives of a scene may add up to.
inline constexpr double max_made_triangles = 5e7;

/// List of keys under `key`
Motion read_motion(Fields& fields, const std::string& key);
/// A path as the scene gives it, relative to the scene's own directory, made absolute.
std::filesystem::path resolved_path(const Fields& fields, const std::filesystem::path& given);

/// Absolute path of the file that `key` names, relative to the scene's own directory; recorded.
/// @param folders that it must lie below
std::filesystem::path read_path(Fields& fields, const std::string& key,
                                const ReadableFolders& folders);

/// Repairs the mesh of a file and notes in Scene::warnings what repair_mesh() did, if anything.
/// @param least_height [1] see there
/// @throws SceneError if it dropped every triangle
void repair_from_file(Mesh& mesh, const std::filesystem::path& path, double least_height,
                      Scene& scene);

/// The key of a resolved scene that holds experimental values. It is no part of the schema.
inline constexpr const char* experimental_key = "experimental";
/// Sets a value in a scene that is not read yet, as `--experimental path=value` asks.
void apply_experimental(nlohmann::json& scene, const std::string& text, const std::string& file);
/// Removes the values that apply_experimental() has set from a scene. Reads them, or moves them to
/// where the reader of their object finds them.
/// @return the values by path, for the resolved scene; null: none
/// @throws SceneError if the scene has such a value among its keys
nlohmann::json read_experimental(nlohmann::json& document, Scene& scene);
/// Removes the values that are no keys of scenes from a resolved scene.
void hide_experimental(nlohmann::json& resolved);

/// Warns of a mesh that stands upright along y while gravity acts along z, or the other way round:
/// at least 1.5 times as tall as wide in x and 2.5 times as along gravity, but not flat, and
/// nothing turns it.
/// @param field of the mesh, for the message
void warn_of_axes(const Mesh& mesh, const Transform& transform, const std::string& field,
                  Scene& scene);
/// Three digits, for messages.
std::string rounded_text(double value);
/// Whether cloth of this size [m], 30 to 3,000, may be in centimetres or millimetres.
bool may_be_in_other_units(double size);
/// Warns of such a cloth from a file, unless the scene scales it.
void warn_of_units(const Mesh& mesh, const Transform& transform, const std::string& field,
                   Scene& scene);
/// Warns of values that are mistakes more often than not: large patterns, densities in g/m^2, steps
/// longer than a frame, a thickness above the cells, angles in radians.
/// @param resolved the whole scene
/// @param groups   those of its "cloths" first
void warn_of_mistakes(const nlohmann::json& resolved, const std::vector<ClothGroup>& groups,
                      Scene& scene);

/// remeshing of the scene
void read_adaptive(Fields& root, Scene& scene);
std::vector<Material> read_materials(Fields& root);
/// @param folders   of the files that the scene names
/// @param triangles how many the grids without cells share
std::vector<ClothGroup> read_cloths(Fields& root, const ReadableFolders& folders, double triangles,
                                    bool triangles_overridden, Scene& scene);
/// @param folders of the files that the scene names
/// @param edge    [m] length of the cloths' cells, which primitives follow if they give no
/// resolution
void read_obstacles(Fields& root, const ReadableFolders& folders, double edge, Scene& scene);
/// Obstacles that change their shape: fills the mesh, as it is at time 0, and the deformation.
/// @param kind "sequence", "skinned" or "capture": a key of `fields`
/// @param folders of the files that the scene names
/// @param edge [m] length of edges that a body made here aims at
void read_body(Fields& fields, const std::string& kind, const ReadableFolders& folders, double edge,
               Scene& scene, Obstacle& obstacle);
void read_pins(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene);
void read_handles(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene);
/// After contact, whose thickness is the default of weld_distance.
void read_seams(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene);
/// refine
void read_refinement(Fields& root, Scene& scene);
/// precision; the default depends on what has been read of everything else
void read_precision(Fields& root, Scene& scene);
/// jitter: moves every vertex of the cloths, after all that chooses vertices by where they are. The
/// rest shape stays.
/// @param edge [m] length of the cloths' cells, which limits the amplitude
void read_jitter(Fields& root, double edge, Scene& scene);
void read_wind(Fields& root, Scene& scene);
/// Leaves out what `model` says: bending, friction, motion of obstacles. After all parts.
void read_model(Fields& root, Scene& scene);
/// keys, resolution; with the method "view" one key that frames the scene if there is none
void read_camera(Fields& root, Scene& scene);
/// A camera at rest that sees all cloths at the start, and the obstacles that are not much larger
/// throughout their motion.
/// @throws SceneError if nothing has finite corners
CameraKey framing_camera(const Scene& scene);
/// view of a method
void read_view(Fields& method, ViewSettings& settings);
/// gravity, time, solver, method, output
void read_settings(Fields& root, Scene& scene);
/// After the cloths, whose edges limit the default thickness.
void read_contact(Fields& root, Scene& scene);

}  // namespace weft::io
