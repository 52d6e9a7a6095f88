#include "host/app/convert_pattern.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

#include "host/app/new/mesh_guess.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/pattern/garment_on_body.hpp"
#include "host/io/pattern/garment_scene.hpp"
#include "host/io/pattern/panel_placement.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "host/lab/worn/waist.hpp"
#include "host/scene/required_fabric.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

/// [body heights] from the body's waist, within which a pattern's waist may stand.
constexpr double waist_tolerance = 0.05;
/// [body heights] above its waist from which a garment hangs from the shoulders.
constexpr double bodice_least = 0.1;

/// One of the patterns.
struct Input {
  std::string file;
  nlohmann::json document;
  io::Garment garment;
  io::GarmentEntry entry;
};

/// Share of a garment's height around which a body has to be.
constexpr double worn_least = 0.5;

bool worn(const Input& input, const Mesh& body) {
  return io::height_around_body(input.garment, body) >= worn_least;
}

Mesh z_up_to_y_up(Mesh mesh) {
  for (Vec3<double>& x : mesh.positions) x = {x[0], x[2], -x[1]};
  return mesh;
}

/// A body as patterns see it: in metres, with y up.
Mesh read_body(const std::string& file, const std::vector<Input>& inputs,
               std::vector<std::string>& notes) {
  Mesh body = io::read_mesh(file, io::Uv::ignore);
  const Aabb box = aabb_of(body.positions);
  const Aabb cloth = aabb_of(inputs.front().garment.mesh.positions);
  const Guess units = guess_units(cloth, box);
  const double unit = units.value == "cm" ? 0.01 : units.value == "mm" ? 0.001 : 1;
  for (Vec3<double>& x : body.positions) x *= unit;
  // guess_up() compares the places of cloth and body in one frame, but panels always have y up. If
  // they stand around the body with one axis only, that is its up axis.
  const Mesh turned = z_up_to_y_up(body);
  bool z_up = guess_up(cloth, box, fs::path(file).extension().string()).value == "z";
  const auto count = [&](const Mesh& as_read) {
    return std::count_if(inputs.begin(), inputs.end(),
                         [&](const Input& input) { return worn(input, as_read); });
  };
  const auto with_y = count(body), with_z = count(turned);
  if (with_y != with_z) z_up = with_z > with_y;
  if (units.value != "m" || z_up)
    notes.push_back(
        fmt::format("{}: taken for {}, with {} up", file, units.value, z_up ? "z" : "y"));
  return z_up ? turned : body;
}

/// A name that a cloth may have.
std::string cloth_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    name += plain || c == '-' ? c : '_';
  }
  return name.empty() ? "garment" : name;
}

/// Reads a pattern and gives it a name that none has yet.
Input read_input(const std::string& file, double edge, const std::string& stem,
                 std::vector<Input>& known, std::vector<std::string>& notes) {
  Input input{file, io::parse_json(read_file_bytes(file), file), {}, {}};
  io::require_sewing_pattern(input.document, file);
  const io::SewingPattern pattern = io::read_sewing_pattern(input.document, file);
  input.garment = io::make_garment(pattern, edge, {"", "--edge"});
  notes.insert(notes.end(), input.garment.notes.begin(), input.garment.notes.end());
  const std::string name = cloth_name(pattern.name);
  const auto taken = [&](const std::string& text) {
    return std::any_of(known.begin(), known.end(),
                       [&](const Input& other) { return other.entry.name == text; });
  };
  input.entry.name = name;
  for (int k = 2; taken(input.entry.name); ++k) input.entry.name = fmt::format("{}_{}", name, k);
  input.entry.pattern_file = stem + "_" + input.entry.name + ".json";
  input.entry.held = io::labels_to_hold(input.garment);
  return input;
}

/// Has waists that stand far from the body's waist held there. Others are let go where a bodice
/// holds them: its length says how far down they go.
void hold_at_waist(std::vector<Input>& inputs, const Mesh& body) {
  const auto labelled = [](const io::HeldLabel& held) { return held.label == io::waist_label; };
  std::optional<lab::Waist> waist;
  for (Input& input : inputs) {
    const auto held = std::find_if(input.entry.held.begin(), input.entry.held.end(), labelled);
    if (held == input.entry.held.end()) continue;
    if (!waist) waist = lab::find_waist(body, {0, 1, 0});
    if (!waist) return;
    double mean = 0;
    for (const io::GarmentLabel& label : input.garment.labels)
      if (label.label == held->label)
        for (const Index v : label.vertices)
          mean +=
              input.garment.mesh.positions[at(v)][1] / static_cast<double>(label.vertices.size());
    double top = mean;
    for (const Vec3<double>& x : input.garment.mesh.positions) top = std::max(top, x[1]);
    if (std::abs(mean - waist->height) > waist_tolerance * waist->body_height)
      held->height = std::round(1000 * waist->height) / 1000;
    else if (top - mean > bodice_least * waist->body_height)
      input.entry.held.erase(held);
  }
}

/// @throws SceneError if a file that is read would be overwritten
void refuse_own_copy(const fs::path& copy, const std::string& input, const std::string& field) {
  std::error_code error;
  if (fs::equivalent(copy, input, error) && !error)
    throw SceneError("", field, input, "another file than the scene's own copy of it");
}

}  // namespace

std::vector<std::string> convert_patterns(const PatternRequest& request) {
  io::GarmentSceneRequest scene;
  scene.fabric = required_fabric(request.fabric, "--fabric").name;
  scene.edge = request.edge;
  if (!(request.edge > 0))
    throw SceneError("", "--edge", fmt::format("{}", request.edge), "a length > 0 m");
  const fs::path output = request.output, folder = output.parent_path();
  const std::string stem = safe_file_name(output.stem().string());
  std::vector<std::string> notes;
  std::vector<Input> inputs;
  std::string files;
  std::size_t panels = 0, stitches = 0, triangles = 0;
  for (const std::string& file : request.inputs) {
    inputs.push_back(read_input(file, request.edge, stem, inputs, notes));
    const Input& input = inputs.back();
    refuse_own_copy(output, file, "OUT");
    refuse_own_copy(folder / input.entry.pattern_file, file, "IN");
    files += (files.empty() ? "" : ", ") + fs::path(file).filename().string();
    panels += input.garment.panels.size();
    stitches += input.garment.seams.size();
    triangles += input.garment.mesh.triangles.size();
  }
  scene.name = cloth_name(inputs.size() == 1 ? inputs.front().entry.name : stem);
  scene.description = one_line(fmt::format("{} from {}, edges of {:.3g} mm",
                                           counted(panels, "panel"), files, 1000 * request.edge));
  if (!request.body.empty()) {
    scene.body_file = stem + "_body.obj";
    refuse_own_copy(folder / scene.body_file, request.body, "--body");
    const Mesh body = read_body(request.body, inputs, notes);
    for (const Input& input : inputs) {
      for (const std::string& line : io::misplaced_panels(input.garment, body))
        notes.push_back(input.file + ": " + line);
      io::refuse_far_panels(input.garment, body, input.file);
      io::refuse_other_size(input.garment, body, input.document, input.file);
      if (!worn(input, body))
        notes.push_back(fmt::format(
            "{}: the panels do not stand around the body of {}; check that the body stands, its up "
            "axis, and the units of both",
            input.file, request.body));
    }
    hold_at_waist(inputs, body);
    io::write_obj(folder / scene.body_file, {{"body", body}});
  }
  for (const Input& input : inputs) scene.garments.push_back(input.entry);
  for (const Input& input : inputs)
    io::copy_pattern(input.document, input.file, folder / input.entry.pattern_file);
  write_file_atomically(output, io::garment_scene(scene).dump(1) + "\n");
  fmt::print("{}: {}, {}, {}\n", one_line(request.output), counted(panels, "panel"),
             counted(stitches, "stitch"), counted(triangles, "triangle"));
  for (const Input& input : inputs)
    for (const io::HeldLabel& held : input.entry.held)
      fmt::print("{}: edges labelled {} are held {}, see \"attach\" in the scene\n",
                 input.entry.name, held.label,
                 held.height ? fmt::format("at a height of {} m, the body's waist", *held.height)
                             : "at the mean height where they start");
  return notes;
}

}  // namespace weft::app
