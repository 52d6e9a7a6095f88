#include "host/io/arcsim/arcsim_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/io/arcsim/arcsim_material.hpp"
#include "host/io/arcsim/arcsim_motion.hpp"
#include "host/io/arcsim/arcsim_obj.hpp"
#include "host/io/arcsim/arcsim_remeshing.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double default_duration = 10;  ///< [s]
constexpr int max_pattern_files = 10000;
constexpr std::int64_t int_max = std::numeric_limits<int>::max();

json vector_json(const Vec3<double>& x) {
  return {x[0], x[1], x[2]};
}

/// Translates one document.
class Translator {
 public:
  Translator(const json& document, const fs::path& file, ReadableFolders folders)
      : document_(document),
        file_(file.string()),
        folders_(std::move(folders)),
        root_(document_, scratch_, file_, "", {}) {}

  ArcsimScene run() {
    warn_unknown(root_,
                 {"frame_time", "frame_steps", "end_time", "end_frame", "timestep", "save_frames",
                  "duration", "cloths", "motions", "handles", "obstacles", "morphs", "gravity",
                  "wind", "friction", "obs_friction", "disable", "magic"});
    scene_ = {{"materials", json::object()},
              {"cloths", json::array()},
              {"obstacles", json::array()},
              {"pins", json::array()},
              {"handles", json::array()}};
    scene_["gravity"] = vector_json(root_.vector<3>("gravity", Vec3<double>{0, 0, 0}));
    read_magic();
    read_time();
    read_wind();
    read_motions();
    read_cloths();
    read_obstacles();
    read_handles();
    read_disabled();
    if (!remeshed_.empty()) set_adaptive();
    if (has_entries("morphs")) warn("morphs", "morph targets do not pull the cloth");
    return {std::move(scene_), std::move(warnings_)};
  }

 private:
  struct ClothFile {
    fs::path path;
    ArcsimExtras extras;
    std::set<Index> pinned;
  };

  /// One line a key, however often the key is there.
  void warn(const std::string& key, const std::string& what) {
    if (warned_.insert(key).second) warnings_.push_back(file_ + ": " + key + ": " + what);
  }

  void warn_unknown(const Fields& fields, const std::vector<std::string>& known) {
    for (const std::string& key : fields.present_keys())
      if (std::find(known.begin(), known.end(), key) == known.end())
        warn(fields.path_of(key), "not a key of ARCSim 0.2; ignored");
  }

  bool has_entries(const std::string& key) const {
    return document_.contains(key) && !document_.at(key).empty();
  }

  /// Objects of a list; none if the key is absent or null, as old files have it.
  std::vector<Fields> entries(const std::string& key) {
    if (!has_entries(key)) return {};
    return root_.objects(key, {});
  }

  /// @throws SceneError for one that must not be read
  std::optional<fs::path> find_file(const fs::path& given, const std::string& field) const {
    if (given.native().find('\0') != std::string::npos) return {};
    for (const fs::path& base : folders_.folders()) {
      const fs::path path = (base / given).lexically_normal();
      if (!is_there(path)) continue;
      folders_.require(path, file_, field);
      return path;
    }
    return {};
  }

  fs::path read_path(Fields& fields, const std::string& key) const {
    const std::string given = fields.text(key);
    const auto path = given.empty() ? std::nullopt : find_file(given, fields.path_of(key));
    if (path) return *path;
    std::string allowed = "the name of a file in ";
    for (std::size_t k = 0; k < folders_.folders().size(); ++k)
      allowed += (k > 0 ? " or " : "") + folders_.folders()[k].string();
    fields.refuse(key, allowed);
  }

  void read_time() {
    double frame = 0;
    double end = std::numeric_limits<double>::infinity();
    std::int64_t steps = 1;
    if (root_.has("frame_time")) {
      frame = root_.positive("frame_time");
      steps = root_.integer("frame_steps", 1, 1, int_max);
      if (root_.has("end_time")) end = root_.positive("end_time");
      if (root_.has("end_frame"))
        end =
            std::min(end, frame * static_cast<double>(root_.integer("end_frame", {}, 1, int_max)));
      for (const char* key : {"timestep", "save_frames"})
        if (root_.has(key)) warn(key, "ignored, since frame_time is there");
    } else {
      steps = root_.integer("save_frames", 1, 1, int_max);
      frame = root_.positive("timestep") * static_cast<double>(steps);
    }
    if (root_.has("duration")) {
      const double duration = root_.positive("duration");
      if (!root_.has("frame_time"))
        end = duration;
      else if (std::isinf(end))
        warn("duration", "ARCSim ignores it beside frame_time and never ends; taken as the end");
      else
        warn("duration", "ignored, since frame_time is there");
      if (std::isinf(end)) end = duration;
    }
    if (std::isinf(end)) {
      warn("end_time", "the scene has no end; stopped after " +
                           std::to_string(static_cast<int>(default_duration)) + " s");
      end = default_duration;
    }
    const double frames = std::ceil(end / frame - 1e-9);
    if (!(frames <= static_cast<double>(int_max)))
      root_.refuse(root_.has("frame_time") ? "frame_time" : "timestep", "at most 2^31 - 1 frames");
    scene_["time"] = {{"step", frame / static_cast<double>(steps)},
                      {"frame_rate", 1 / frame},
                      {"frames", static_cast<std::int64_t>(std::max(1.0, frames))}};
  }

  void read_magic() {
    Fields magic = root_.object("magic", {});
    const std::vector<std::string> idle{"fixed_high_res_mesh",  "collision_stiffness",
                                        "projection_thickness", "rib_stiffening",
                                        "combine_tensors",      "preserve_creases"};
    std::vector<std::string> known = idle;
    known.insert(known.end(), {"handle_stiffness", "repulsion_thickness", "edge_flip_threshold"});
    warn_unknown(magic, known);
    for (const std::string& key : idle)
      if (magic.has(key)) warn("magic." + key, "has no counterpart; ignored");
    if (magic.has("edge_flip_threshold"))
      flip_threshold_ = std::max(0.0, magic.number("edge_flip_threshold"));
    handle_stiffness_ = magic.positive("handle_stiffness", 1e3);
    scene_["contact"] = {{"thickness", magic.positive("repulsion_thickness", 1e-3)},
                         {"friction", root_.number("friction", 0.6)}};
  }

  void read_wind() {
    Fields wind = root_.object("wind", {"density", "velocity", "drag"});
    scene_["wind"] = {{"density", wind.number("density", 1.0)},
                      {"velocity", vector_json(wind.vector<3>("velocity", Vec3<double>{0, 0, 0}))},
                      {"drag", wind.number("drag", 0.0)}};
  }

  void read_motions() {
    if (!has_entries("motions")) return;
    const json& list = document_.at("motions");
    if (root_.is_object("motions")) {
      Fields capture = root_.object("motions", {"motfile", "fps", "transform"});
      const fs::path path = read_path(capture, "motfile");
      motions_ =
          read_mot(path, capture.positive("fps"), read_arcsim_transform(capture, "transform"));
      return;
    }
    if (!list.is_array())
      root_.refuse("motions", "a list of motions, or {motfile, fps, transform}");
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = "motions[" + std::to_string(i) + "]";
      if (!list[i].is_array() || list[i].empty())
        throw SceneError(file_, path, short_text(list[i]), "a list of keys, at least one");
      std::vector<Fields> keys;
      std::vector<json> scratch(list[i].size());
      for (std::size_t k = 0; k < list[i].size(); ++k)
        keys.emplace_back(list[i][k], scratch[k], file_, path + "[" + std::to_string(k) + "]",
                          std::vector<std::string>{"time", "transform", "velocity"});
      motions_.push_back(read_arcsim_keys(keys));
    }
  }

  /// @return nothing for -1
  const Motion* read_motion(Fields& fields) const {
    const std::int64_t i =
        fields.integer("motion", -1, -1, static_cast<std::int64_t>(motions_.size()) - 1);
    return i < 0 ? nullptr : &motions_[static_cast<std::size_t>(i)];
  }

  void read_cloths() {
    for (Fields& fields : entries("cloths")) {
      warn_unknown(fields, {"mesh", "transform", "velocity", "materials", "remeshing"});
      ClothFile cloth;
      cloth.path = read_path(fields, "mesh");
      cloth.extras = read_arcsim_extras(cloth.path);
      for (const std::string& what : cloth.extras.ignored)
        warn(fields.path_of("mesh") + " " + what, "ignored");
      json entry{{"name", cloth_name(cloths_.size())}, {"mesh", cloth.path.string()}};
      entry["transform"] = transform_json(read_arcsim_transform(fields, "transform"));
      Fields velocity = fields.object("velocity", {"linear", "angular", "origin"});
      const auto angular = velocity.vector<3>("angular", Vec3<double>{0, 0, 0});
      const auto origin = velocity.vector<3>("origin", Vec3<double>{0, 0, 0});
      entry["velocity"] =
          vector_json(velocity.vector<3>("linear", Vec3<double>{0, 0, 0}) - cross(angular, origin));
      entry["angular_velocity"] = vector_json(angular);
      entry["material"] = read_cloth_materials(fields, cloth.path);
      if (fields.has("remeshing")) {
        if (json block = read_arcsim_remeshing(fields); block.is_null())
          warn("cloths[].remeshing", "without size the mesh stays as it is in the file");
        else
          remeshed_.push_back(std::move(block));
      }
      scene_["cloths"].push_back(std::move(entry));
      cloths_.push_back(std::move(cloth));
    }
    if (cloths_.empty()) root_.refuse("cloths", "at least one cloth");
  }

  static std::string cloth_name(std::size_t i) { return "cloth_" + std::to_string(i); }

  /// A name, or one for each label of faces.
  json read_cloth_materials(Fields& fields, const fs::path& mesh_path) {
    std::vector<std::string> names;
    for (Fields& material : fields.objects("materials", {}))
      names.push_back(add_material(material));
    if (names.empty()) fields.refuse("materials", "at least one material");
    const Mesh mesh = read_mesh(mesh_path, Uv::material, folders_);
    const std::string prefix = "label_";
    std::vector<bool> used(mesh.group_names.size(), false);
    for (const Index group : mesh.group) used[static_cast<std::size_t>(group)] = true;
    json by_group = json::object();
    bool several = false;
    for (std::size_t g = 0; g < used.size(); ++g) {
      if (!used[g]) continue;
      const std::string& group = mesh.group_names[g];
      std::size_t label = 0;
      if (group.starts_with(prefix) && group.size() < 12)
        label = static_cast<std::size_t>(std::atoll(group.c_str() + prefix.size()));
      if (label >= names.size())
        fields.refuse("materials", std::to_string(names.size()) + " materials",
                      "one for each face label of " + mesh_path.string() + ", which has " + group);
      by_group[group] = names[label];
      several = several || names[label] != names[0];
    }
    return several ? by_group : json(names[0]);
  }

  std::string add_material(Fields& fields) {
    warn_unknown(fields, {"data", "density_mult", "stretching_mult", "bending_mult", "thicken",
                          "damping", "strain_limits", "yield_curv", "weakening"});
    const fs::path path = read_path(fields, "data");
    ArcsimFactors factors;
    factors.density = fields.positive("density_mult", 1.0);
    factors.stretching = fields.positive("stretching_mult", 1.0);
    factors.bending = fields.number("bending_mult", 1.0);
    factors.thicken = fields.positive("thicken", 1.0);
    factors.damping = fields.number("damping", 0.0);
    bool averaged = false;
    Material material = read_arcsim_material(path, factors, averaged);
    if (averaged)
      warn("cloths[].materials[].data", "the tables of bending count at small curvature only");
    for (const char* key : {"yield_curv", "weakening"})
      if (fields.has(key))
        warn(std::string("cloths[].materials[].") + key, "no plasticity; ignored");
    json entry{{"density", material.density},
               {"poisson_ratio", material.poisson_ratio},
               {"damping", {{"mass", 0.0}, {"stiffness", material.damping_stiffness}}}};
    if (material.measured)
      entry["measured"] = {{"form", "wang_arcsim"}, {"stretching", material.measured->rows}};
    else
      entry["stretch_stiffness"] = material.stretch_stiffness;
    if (const auto& bending = material.orthotropic_bending)
      entry["orthotropic_bending"] = {{"stiffness", {bending->warp, bending->weft}},
                                      {"coupling", bending->coupling},
                                      {"twist", bending->twist}};
    else
      entry["bending_stiffness"] = material.bending_stiffness;
    if (fields.has("strain_limits")) {
      const auto limits = fields.vector<2>("strain_limits");
      // below 0 nothing is limited
      entry["strain_limits"] = {std::max(limits[0], 0.0), limits[1]};
    }
    json& all = scene_["materials"];
    std::string name = material.name;
    for (int k = 2; all.contains(name) && all[name] != entry; ++k)
      name = material.name + "_" + std::to_string(k);
    all[name] = std::move(entry);
    return name;
  }

  void add_obstacle(const fs::path& path, const Transform& transform, const Motion* motion) {
    json entry{{"name", "obstacle_" + std::to_string(scene_["obstacles"].size())},
               {"mesh", path.string()},
               {"repair", true},
               {"friction", root_.number("obs_friction", 0.3)},
               {"transform", transform_json(transform)}};
    if (motion) entry["motion"] = motion_json(composed(*motion, transform));
    scene_["obstacles"].push_back(std::move(entry));
  }

  void read_obstacles() {
    if (root_.has("obstacles") && document_.at("obstacles").is_string()) {
      read_obstacle_files();
      return;
    }
    for (Fields& fields : entries("obstacles")) {
      warn_unknown(fields, {"mesh", "transform", "motion", "start_time", "end_time"});
      const fs::path path = read_path(fields, "mesh");
      const Transform transform = read_arcsim_transform(fields, "transform");
      const Motion* motion = read_motion(fields);
      if (fields.number("start_time", 0.0) > 0)
        warn("obstacles[].start_time", "the obstacle is there from the start");
      if (fields.has("end_time") && !std::isinf(fields.number("end_time")))
        warn("obstacles[].end_time", "the obstacle stays until the end");
      add_obstacle(path, transform, motion);
    }
  }

  /// The pattern form: one %d or %0Nd.
  void read_obstacle_files() {
    const std::string pattern = root_.text("obstacles");
    const std::string allowed = "a list, or the name of files with one %d or %04d in it";
    const std::size_t percent = pattern.find('%');
    if (percent == std::string::npos) root_.refuse("obstacles", allowed);
    std::size_t end = percent + 1;
    std::size_t width = 0;
    for (; end < pattern.size() && pattern[end] >= '0' && pattern[end] <= '9'; ++end)
      width = std::min<std::size_t>(10 * width + static_cast<std::size_t>(pattern[end] - '0'), 100);
    if (end >= pattern.size() || pattern[end] != 'd' || width > 9 ||
        pattern.find('%', end) != std::string::npos)
      root_.refuse("obstacles", allowed);
    const char fill = pattern[percent + 1] == '0' ? '0' : ' ';
    for (int i = 0; i < max_pattern_files; ++i) {
      std::string number = std::to_string(i);
      if (number.size() < width) number.insert(0, width - number.size(), fill);
      const auto path =
          find_file(pattern.substr(0, percent) + number + pattern.substr(end + 1), "obstacles");
      if (!path && i == 0) root_.refuse("obstacles", allowed + "; there is no file with 0");
      if (!path) return;
      const auto k = static_cast<std::size_t>(i);
      if (!motions_.empty() && k >= motions_.size())
        root_.refuse("obstacles",
                     "one motion for each file; there are " + std::to_string(motions_.size()));
      add_obstacle(*path, {}, motions_.empty() ? nullptr : &motions_[k]);
    }
  }

  void read_handles() {
    for (Fields& fields : entries("handles")) {
      warn_unknown(fields, {"type", "cloth", "label", "nodes", "motion", "start_time", "end_time",
                            "fade_time", "circumference", "u", "center", "axis0", "axis1"});
      const std::size_t type = fields.choice("type", {"node", "circle", "glue"}, 0);
      const auto cloth = static_cast<std::size_t>(
          fields.integer("cloth", 0, 0, static_cast<std::int64_t>(cloths_.size()) - 1));
      const double start = fields.number("start_time", 0.0);
      const double fade = fields.number("fade_time", 0.0);
      json entry{{"cloth", cloth_name(cloth)}, {"motion", json::array()}};
      if (const Motion* motion = read_motion(fields)) entry["motion"] = motion_json(*motion);
      json end_time = nullptr;
      if (fields.has("end_time")) end_time = fields.number("end_time");
      std::vector<Index> vertices = read_nodes(fields, cloths_[cloth], type == 2);
      if (type == 0 && start <= 0 && fade == 0) {
        vertices = add_pin(entry, vertices, end_time, cloths_[cloth]);
        if (vertices.empty()) continue;
      }
      entry[type == 2 ? "glue" : "vertices"] = vertices;
      if (type == 1) entry["circle"] = read_circle(fields);
      entry["stiffness"] = handle_stiffness_;
      entry["start_time"] = std::max(0.0, start);
      entry["end_time"] = end_time;
      entry["fade_time"] = fade;
      scene_["handles"].push_back(std::move(entry));
    }
  }

  static std::vector<Index> read_nodes(Fields& fields, const ClothFile& cloth, bool pair) {
    const auto count = static_cast<std::int64_t>(cloth.extras.node_label.size());
    std::vector<Index> vertices;
    if (fields.has("nodes")) {
      const auto nodes = fields.integers("nodes", 0, count - 1,
                                         pair ? std::optional<std::size_t>(2) : std::nullopt);
      for (const std::int64_t v : nodes) vertices.push_back(static_cast<Index>(v));
    } else {
      const std::int64_t label = fields.integer("label", {}, -int_max, int_max);
      vertices = vertices_with_label(cloth.extras, label);
      if (vertices.empty())
        fields.refuse("label", "a label of nodes (nl) of " + cloth.path.string());
    }
    if (vertices.empty()) fields.refuse("nodes", "at least one node");
    return vertices;
  }

  /// Pins what no pin holds yet.
  /// @return the rest
  std::vector<Index> add_pin(json entry, const std::vector<Index>& vertices, const json& end_time,
                             ClothFile& cloth) {
    std::vector<Index> free;
    std::vector<Index> taken;
    for (const Index v : vertices) (cloth.pinned.insert(v).second ? free : taken).push_back(v);
    if (free.empty()) return taken;
    entry["vertices"] = free;
    entry["release_time"] = end_time;
    scene_["pins"].push_back(std::move(entry));
    return taken;
  }

  static json read_circle(Fields& fields) {
    const Vec2<double> u = fields.vector<2>("u");
    return {{"circumference", fields.positive("circumference")},
            {"direction", {u[0], u[1]}},
            {"center", vector_json(fields.vector<3>("center"))},
            {"axis0", vector_json(fields.vector<3>("axis0"))},
            {"axis1", vector_json(fields.vector<3>("axis1"))}};
  }

  /// In ARCSim each cloth has its own criteria, and cloths without a block are not remeshed.
  void set_adaptive() {
    json criteria = remeshed_.front();
    if (remeshed_.size() < cloths_.size())
      warn("cloths[].remeshing", "missing beside others; its mesh adapts as theirs do");
    for (const json& other : remeshed_)
      if (other != criteria)
        warn("cloths[].remeshing",
             "not that of the first cloth that has one, which counts for all");
    scene_["experimental"] = {{"remeshing.aspect_min", criteria.at("aspect_min")}};
    criteria.erase("aspect_min");
    scene_["remeshing"] = std::move(criteria);
    if (!remeshes_) return;
    scene_["method"] = {{"type", "adaptive"}};
    if (flip_threshold_) scene_["experimental"]["remeshing.flip_threshold"] = *flip_threshold_;
  }

  void read_disabled() {
    if (!has_entries("disable")) return;
    const std::vector<std::string> known{"proximity", "physics",    "strainlimiting", "collision",
                                         "remeshing", "separation", "popfilter",      "plasticity"};
    for (const std::size_t k : root_.choices("disable", known)) {
      if (k == 0 || k == 1 || k == 3) warn("disable " + known[k], "cannot be left out");
      if (k == 4) remeshes_ = false;
    }
  }

  const json& document_;
  std::string file_;
  ReadableFolders folders_;
  json scratch_;
  Fields root_;
  json scene_;
  std::vector<std::string> warnings_;
  std::set<std::string> warned_;
  std::vector<Motion> motions_;
  std::vector<ClothFile> cloths_;
  double handle_stiffness_ = 1e3;
  std::optional<double> flip_threshold_;  ///< if the file gives one
  std::vector<json> remeshed_;            ///< criteria of each cloth that has some
  bool remeshes_ = true;                  ///< unless disabled
};

}  // namespace

bool is_arcsim_scene(const json& document) {
  if (!document.is_object()) return false;
  if (document.contains("frame_time") || document.contains("timestep")) return true;
  const auto cloths = document.find("cloths");
  return cloths != document.end() && cloths->is_array() &&
         std::any_of(cloths->begin(), cloths->end(), [](const json& cloth) {
           return cloth.is_object() && cloth.contains("materials") &&
                  cloth.at("materials").is_array();
         });
}

ReadableFolders arcsim_folders(const fs::path& file, const std::vector<std::string>& allowed) {
  ReadableFolders folders(file, allowed);
  const fs::path own = folders.folders().front();
  if (own.filename() == "conf") folders.add(own.parent_path());
  return folders;
}

ArcsimScene weft_scene_of(const json& document, const fs::path& file,
                          const std::vector<std::string>& allowed) {
  return Translator(document, file, arcsim_folders(file, allowed)).run();
}

std::vector<std::string> convert_arcsim(const fs::path& in, const fs::path& out,
                                        const std::vector<std::string>& allowed) {
  const json document = parse_json(read_file_bytes(in), in.string());
  if (!is_arcsim_scene(document))
    throw SceneError(in.string(), "frame_time", "missing",
                     "a scene of ARCSim, or \"pattern\" as a sewing pattern of GarmentCode has it");
  ArcsimScene translated = weft_scene_of(document, in, allowed);
  std::string description = "From " + in.filename().string() + " of ARCSim.";
  for (const std::string& line : translated.warnings) description += " " + line + ".";
  translated.scene["name"] = in.stem().string();
  translated.scene["description"] = description;
  write_file_atomically(out, translated.scene.dump(2) + "\n");
  return translated.warnings;
}

}  // namespace weft::io
