#include "host/app/convert_pattern.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "host/app/new/mesh_guess.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/pattern/garment_scene.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "host/scene/fabric/fabrics.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

/// A body as patterns see it: in metres, with y up.
Mesh read_body(const std::string& file, const Mesh& garment, std::vector<std::string>& notes) {
  Mesh body = io::read_mesh(file, io::Uv::ignore);
  const FileBox box = box_of(body), cloth = box_of(garment);
  const Guess units = guess_units(cloth, box);
  const double unit = units.value == "cm" ? 0.01 : units.value == "mm" ? 0.001 : 1;
  const bool z_up = guess_up(cloth, box, fs::path(file).extension().string()).value == "z";
  if (units.value != "m" || z_up)
    notes.push_back(
        fmt::format("{}: taken for {}, with {} up", file, units.value, z_up ? "z" : "y"));
  for (Vec3<double>& x : body.positions) {
    if (z_up) x = {x[0], x[2], -x[1]};
    x *= unit;
  }
  return body;
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

}  // namespace

std::vector<std::string> convert_pattern(const PatternRequest& request) {
  const nlohmann::json document = io::parse_json(read_file_bytes(request.input), request.input);
  const io::SewingPattern pattern = io::read_sewing_pattern(document, request.input);
  const std::string fabric_name = fabric(request.fabric).name;
  if (!(request.edge > 0))
    throw SceneError("", "--edge", fmt::format("{}", request.edge), "a length > 0 m");
  io::Garment garment = io::make_garment(pattern, request.edge);
  std::vector<std::string> notes = garment.notes;

  const fs::path output = request.output;
  const std::string stem = safe_file_name(output.stem().string());
  io::GarmentSceneRequest scene;
  scene.name = cloth_name(pattern.name);
  scene.description =
      one_line(fmt::format("{} panels from {}, edges of {:.3g} mm", garment.panels.size(),
                           fs::path(request.input).filename().string(), 1000 * request.edge));
  scene.fabric = fabric_name;
  scene.garment_file = stem + "_garment.obj";
  Mesh body;
  if (!request.body.empty()) {
    scene.body_file = stem + "_body.obj";
    const fs::path copy = output.parent_path() / scene.body_file;
    std::error_code error;
    if (fs::equivalent(copy, request.body, error) && !error)
      throw SceneError("", "--body", request.body, "another file than the scene's own copy of it");
    body = read_body(request.body, garment.mesh, notes);
    io::refuse_far_panels(garment, body, request.input);
    io::write_obj(copy, {{"body", body}});
  }
  io::relax_start(garment, request.edge, body);
  io::write_garment(output.parent_path() / scene.garment_file, scene.name, garment);
  write_file_atomically(output, io::garment_scene(garment, scene).dump(1) + "\n");
  fmt::print("{}: {} panels, {} stitches, {} triangles\n", one_line(request.output),
             garment.panels.size(), garment.seams.size(), garment.mesh.triangles.size());
  return notes;
}

}  // namespace weft::app
