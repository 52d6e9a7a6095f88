#include "host/app/new/new_scene.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/app/new/mesh_guess.hpp"
#include "host/app/new/scene_draft.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/scratch_folder.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/scene/defaults.hpp"
#include "host/scene/motion.hpp"
#include "host/scene/required_fabric.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

struct NewRequest {
  std::string cloth;
  std::string body;
  std::string output = "scene.json";
  std::string fabric = default_fabric;
  std::string units;
  std::string up;
  bool comments = true;
};

/// The file as a scene in `folder` names it.
std::string named_from(const fs::path& folder, const std::string& file) {
  return fs::relative(fs::canonical(file), fs::weakly_canonical(folder)).generic_string();
}

fs::path folder_of(const std::string& output) {
  const fs::path parent = fs::path(output).parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

/// A word of a command, in quotation marks if the shell would take it apart.
std::string shell_word(const std::string& word) {
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("_-./+,", c) != nullptr;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string command_of(const NewRequest& r) {
  std::string text = "weft new " + shell_word(r.cloth);
  if (!r.body.empty()) text += " " + shell_word(r.body);
  if (r.output != "scene.json") text += " -o " + shell_word(r.output);
  if (r.fabric != default_fabric) text += " --fabric " + r.fabric;
  if (!r.units.empty()) text += " --units " + r.units;
  if (!r.up.empty()) text += " --up " + r.up;
  return text;
}

/// Number of vertices, and lengths of edges.
std::string facts_of(const Mesh& mesh) {
  std::vector<double> lengths;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(t.v[k]),
                 b = static_cast<std::size_t>(t.v[(k + 1) % 3]);
      lengths.push_back(length(mesh.positions[a] - mesh.positions[b]));
    }
  std::sort(lengths.begin(), lengths.end());
  return fmt::format("{}, {}; edges of {:.3g} to {:.3g} mm, {:.3g} mm in the middle",
                     counted(mesh.positions.size(), "vertex"),
                     counted(mesh.triangles.size(), "triangle"), 1000 * lengths.front(),
                     1000 * lengths.back(), 1000 * lengths[lengths.size() / 2]);
}

std::string fabric_facts(const std::string& name) {
  const Fabric& fabric = *find_fabric(name);
  return fmt::format("{}, {} kg/m^2, {}", fabric.description, fabric.material.density,
                     fabric.estimate ? "an estimate" : "measured");
}

/// A scene without a body: flat cloth gets a floor to fall on, upright cloth is pinned at its top.
void hold_up(const Aabb& cloth, double edge, SceneDraft& draft) {
  const Vec3<double> size = cloth.size();
  constexpr double upright = 0.2;
  if (size[2] < upright * std::max(size[0], size[1])) {
    draft.floor = cloth.lo[2] - 0.3 * cloth.longest_side();
    return;
  }
  const double margin = std::max(edge, 0.01 * cloth.longest_side());
  draft.pin_low = cloth.lo - Vec3<double>{margin, margin, 0};
  (*draft.pin_low)[2] = cloth.hi[2] - std::max(edge / 2, 0.02 * size[2]);
  draft.pin_high = cloth.hi + Vec3<double>{margin, margin, margin};
}

/// Long enough to fall onto what is below, and to come to rest there.
void choose_frames(double fall, SceneDraft& draft) {
  constexpr double rate = 25, rest = 1.5, gravity = 9.81;
  constexpr int least = 50, most = 250;
  const double seconds = rest + std::sqrt(2 * std::max(fall, 0.0) / gravity);
  draft.frames = std::clamp(static_cast<int>(std::ceil(rate * seconds)), least, most);
  draft.frames_reason = fmt::format("{:.3g} s", draft.frames / rate);
  if (fall > 0.001)
    draft.frames_reason += fmt::format(": the cloth falls {:.3g} m, and comes to rest", fall);
}

/// The scene with the meshes' own paths, as it stands so far.
io::SceneFile read_draft(const SceneDraft& draft, const NewRequest& request,
                         const ScratchFolder& scratch) {
  SceneDraft there = draft;
  there.cloth_file = fs::canonical(request.cloth).string();
  std::vector<std::string> allowed{fs::canonical(request.cloth).parent_path().string()};
  if (!request.body.empty()) {
    there.body_file = fs::canonical(request.body).string();
    allowed.push_back(fs::canonical(request.body).parent_path().string());
  }
  const fs::path file = scratch.path() / "scene.json";
  write_file_atomically(file, draft_text(there, Comments::none), Durability::none);
  return io::read_scene_file(file, {}, allowed);
}

/// Without repair if that goes.
io::SceneFile read_or_repair(SceneDraft& draft, const NewRequest& request,
                             const ScratchFolder& scratch) {
  try {
    return read_draft(draft, request, scratch);
  } catch (const SceneError& refused) {
    draft.repaired = "unknown";
    draft.repair_body = !request.body.empty();
    io::SceneFile file;
    try {
      file = read_draft(draft, request, scratch);
    } catch (const SceneError&) {
      throw refused;  // repair does not help, so the mesh as it is counts
    }
    draft.repaired = refused.what();
    return file;
  }
}

Aabb placed_box(const Obstacle& obstacle) {
  Mesh mesh = obstacle.mesh;
  for (Vec3<double>& x : mesh.positions) x = apply(obstacle.transform, x);
  return aabb_of(mesh.positions);
}

/// Makes a file that must not be there yet.
void write_new_file(const std::string& path, const std::string& text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0)
    throw SceneError(
        "", "-o", path + " (" + (errno == EEXIST ? "is there already" : std::strerror(errno)) + ")",
        "a file that can be made; weft new replaces none");
  const ssize_t written = ::write(file, text.data(), text.size());
  const int reason = written < 0 ? errno : ENOSPC;
  if (::close(file) == 0 && written == static_cast<ssize_t>(text.size())) return;
  ::unlink(path.c_str());
  throw SceneError("", "-o", path + " (" + std::strerror(reason) + ")",
                   "a file that can be written");
}

void refuse_existing(const std::string& path) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(path, error)))
    throw SceneError("", "-o", path + " (is there already)",
                     "a file that can be made; weft new replaces none");
}

SceneDraft draft_of(const NewRequest& request) {
  const Mesh cloth = io::read_mesh(request.cloth, io::Uv::where_all);
  const Aabb cloth_box = aabb_of(cloth.positions);
  std::optional<Aabb> body_box;
  if (!request.body.empty())
    body_box = aabb_of(io::read_mesh(request.body, io::Uv::ignore).positions);

  SceneDraft draft;
  const fs::path folder = folder_of(request.output);
  // A scene is called after its file, so that runs go to out/<name>; "scene" would say nothing.
  const std::string file = fs::path(request.output).stem().string();
  draft.name = safe_file_name(file == "scene" ? fs::path(request.cloth).stem().string() : file);
  draft.command = command_of(request);
  draft.units = request.units.empty() ? guess_units(cloth_box, body_box)
                                      : Guess{request.units, "given by --units"};
  draft.up = request.up.empty()
                 ? guess_up(cloth_box, body_box, fs::path(request.cloth).extension().string())
                 : Guess{request.up, "given by --up"};
  draft.cloth_file = named_from(folder, request.cloth);
  draft.textured = !cloth.material.empty();
  draft.fabric = required_fabric(request.fabric, "--fabric").name;
  draft.fabric_facts = fabric_facts(draft.fabric);
  if (!request.body.empty()) draft.body_file = named_from(folder, request.body);
  return draft;
}

/// Adds the values that follow from the cloth in metres.
void complete(SceneDraft& draft, const NewRequest& request) {
  const ScratchFolder scratch;
  const io::SceneFile first = read_or_repair(draft, request, scratch);
  const Mesh& cloth = first.scene.cloths.at(0).mesh;
  const Aabb box = aabb_of(cloth.positions);
  const double edge = mean_cell_edge(first.scene.cloths);
  draft.cloth_facts = facts_of(cloth);
  draft.cloth_size = box.longest_side();
  draft.cloth_centre = box.center();
  draft.thickness = thickness_of(first.scene);
  draft.thickness_reason = fmt::format(
      "m; the cloth repels from this distance on: 1 mm, or a quarter of the cells of {:.3g} mm",
      1000 * edge);
  double fall = 0;
  if (request.body.empty())
    hold_up(box, edge, draft);
  else
    fall = box.lo[2] - placed_box(first.scene.obstacles.at(0)).hi[2];
  if (draft.floor) fall = box.lo[2] - *draft.floor;
  choose_frames(fall, draft);
  draft.camera = io::framing_camera(read_draft(draft, request, scratch).scene);
  // The camera passes the same checks as the rest.
  for (const std::string& warning : read_draft(draft, request, scratch).scene.warnings)
    fmt::print(stderr, "weft: warning: {}\n", one_line(warning));
}

/// Folders that the scene may not read without being told, as words.
std::string allowed_words(const SceneDraft& draft, const NewRequest& request) {
  std::vector<std::string> folders;
  for (const auto& [named, file] :
       {std::pair(draft.cloth_file, request.cloth), std::pair(draft.body_file, request.body)}) {
    if (!named.starts_with("../")) continue;
    const std::string folder = folder_of(file).string();
    if (std::find(folders.begin(), folders.end(), folder) == folders.end())
      folders.push_back(folder);
  }
  std::string text;
  for (const std::string& folder : folders) text += " --allow-path " + shell_word(folder);
  return text;
}

void write_scene(const NewRequest& request) {
  if (!request.output.ends_with(".json"))
    throw SceneError("", "-o", request.output, "a file name that ends in .json");
  refuse_existing(request.output);
  SceneDraft draft = draft_of(request);
  complete(draft, request);
  write_new_file(request.output,
                 draft_text(draft, request.comments ? Comments::lines : Comments::none));
  fmt::print("{}: units {} ({}); up {} ({}); fabric {}\n", request.output, draft.units.value,
             draft.units.reason, draft.up.value, draft.up.reason, draft.fabric);
  fmt::print("weft run {}{}\n", shell_word(request.output), allowed_words(draft, request));
}

}  // namespace

void add_new_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand = app.add_subcommand("new", "Write a scene for mesh files of your own");
  const auto request = std::make_shared<NewRequest>();
  subcommand->add_option("cloth", request->cloth, "Mesh of the cloth")
      ->required()
      ->type_name("FILE");
  subcommand->add_option("body", request->body, "Mesh of a body that the cloth meets")
      ->type_name("FILE");
  subcommand->add_option("-o,--output", request->output, "Scene to write; must not be there yet")
      ->type_name("FILE")
      ->capture_default_str();
  subcommand
      ->add_option("--fabric", request->fabric,
                   "Fabric of the cloth, one of those that weft info --fabrics lists")
      ->type_name("NAME")
      ->capture_default_str();
  subcommand->add_option("--units", request->units, "Unit of the mesh files; default: guessed")
      ->check(CLI::IsMember({"m", "cm", "mm", "in", "ft"}));
  subcommand->add_option("--up", request->up, "Axis of the mesh files that is up; default: guessed")
      ->check(CLI::IsMember({"y", "z"}));
  subcommand->add_flag_callback(
      "--no-comments", [request] { request->comments = false; },
      "Write plain JSON, for other programs");
  subcommand->callback([request, &exit_code] {
    write_scene(*request);
    exit_code = 0;
  });
}

}  // namespace weft::app
