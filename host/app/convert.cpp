#include "host/app/convert.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/app/convert_outlines.hpp"
#include "host/app/convert_pattern.hpp"
#include "host/app/run/allow_path.hpp"
#include "host/app/run/output_folder.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_extension.hpp"
#include "host/base/temporary_file.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/arcsim/arcsim_scene.hpp"
#include "host/io/gltf/glb_file.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "host/io/mesh/split_objects.hpp"
#include "host/io/mesh/welded_mesh.hpp"
#include "host/io/pattern/outline_file.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/spool/frame_spool.hpp"
#include "host/io/usd/usd_file.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using io::FrameMeshes;
using io::MeshSequence;
using io::NamedMesh;

struct ConvertRequest {
  std::vector<std::string> files;  ///< inputs and the output
  std::string input;               ///< the first one
  std::string output;
  std::vector<std::string> frames;   ///< numbers, or "last"; empty: all
  std::string only;                  ///< empty: cloths and obstacles
  bool weld = false;                 ///< cloths as one mesh each
  std::vector<std::string> allowed;  ///< folders of files that the input names, beside its own
  PatternRequest pattern;            ///< for sewing patterns
  std::vector<std::string> pattern_options{};  ///< those of them that were given
};

/// The frames that are asked for, by their place in a sequence, in increasing order.
/// @throws SceneError for a frame that is not there
std::vector<std::size_t> chosen_places(const MeshSequence& sequence,
                                       const ConvertRequest& request) {
  const std::vector<int>& numbers = sequence.frames();
  std::vector<std::size_t> places;
  for (const std::string& given : request.frames) {
    long long number = -1;
    if (given != "last" && !io::parse_number(given, number))
      throw SceneError("", "--frame", one_line(given), "the number of a frame, or last");
    const auto found = given == "last" ? numbers.end() - 1
                                       : std::lower_bound(numbers.begin(), numbers.end(), number);
    if (found == numbers.end() || (given != "last" && *found != number))
      throw SceneError(request.input, "--frame", given,
                       numbers.size() == 1
                           ? std::to_string(numbers[0])
                           : fmt::format("one of the {} frames from {} to {}", numbers.size(),
                                         numbers.front(), numbers.back()));
    places.push_back(static_cast<std::size_t>(found - numbers.begin()));
  }
  if (request.frames.empty())
    for (std::size_t k = 0; k < numbers.size(); ++k) places.push_back(k);
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

/// The objects that numbered files join under this name, under names of their own.
std::vector<NamedMesh> by_object(std::vector<NamedMesh> meshes, const char* joined) {
  std::vector<NamedMesh> all;
  for (NamedMesh& mesh : meshes) {
    if (mesh.name != joined) {
      all.push_back(std::move(mesh));
      continue;
    }
    for (NamedMesh& object : io::split_objects(std::move(mesh))) all.push_back(std::move(object));
  }
  return all;
}

/// Reads a frame and leaves out what is not wanted.
FrameMeshes read_parts(const MeshSequence& sequence, std::size_t place,
                       const ConvertRequest& request) {
  FrameMeshes meshes = sequence.read(place);
  if (meshes.joined) meshes.cloth_velocities.clear();
  if (meshes.joined) meshes.cloths = by_object(std::move(meshes.cloths), "cloth");
  if (meshes.joined) meshes.obstacles = by_object(std::move(meshes.obstacles), "obstacle");
  if (request.only == "cloths") meshes.obstacles.clear();
  if (request.only == "obstacles") {
    meshes.cloths.clear();
    meshes.cloth_velocities.clear();
  }
  if (meshes.cloths.empty() && meshes.obstacles.empty())
    throw SceneError(request.input, "--only", request.only, "what the input has");
  return meshes;
}

/// Frames as they are written.
class Frames {
 public:
  /// @param places of the frames that are going to be read
  Frames(const MeshSequence& sequence, const std::vector<std::size_t>& places,
         const ConvertRequest& request)
      : sequence_(sequence), request_(request) {
    if (!request.weld) return;
    for (const std::size_t place : places) note_welds(place);
  }

  /// @param seams gets the seam edges of cloths if these are welded; may be null
  FrameMeshes read(std::size_t place, io::SeamEdges* seams = nullptr) const {
    FrameMeshes meshes = read_parts(sequence_, place, request_);
    if (seams != nullptr) seams->clear();
    if (!request_.weld) return meshes;
    meshes.cloth_velocities.clear();
    for (std::size_t c = 0; c < meshes.cloths.size(); ++c) {
      io::WeldedMesh welded = io::welded(meshes.cloths[c].mesh, welds_[c].numbers());
      meshes.cloths[c].mesh = std::move(welded.mesh);
      if (seams != nullptr) seams->push_back(std::move(welded.seam_edges));
    }
    return meshes;
  }

 private:
  void note_welds(std::size_t place) {
    const FrameMeshes meshes = read_parts(sequence_, place, request_);
    if (welds_.empty()) {
      welds_.resize(meshes.cloths.size());
      for (const NamedMesh& cloth : meshes.cloths) counts_.push_back(cloth.mesh.positions.size());
    }
    for (std::size_t c = 0; c < std::max(welds_.size(), meshes.cloths.size()); ++c) {
      const bool same = c < welds_.size() && c < meshes.cloths.size() &&
                        meshes.cloths[c].mesh.positions.size() == counts_[c];
      if (!same)
        throw SceneError(sequence_.describe(place), "--weld",
                         "cloths with other vertices than in the frames before",
                         "a topology that stays as it is, or --frame N");
      welds_[c].add(meshes.cloths[c].mesh.positions);
    }
  }

  const MeshSequence& sequence_;
  const ConvertRequest& request_;
  std::vector<io::Weld> welds_;      ///< [cloths] empty: nothing is welded
  std::vector<std::size_t> counts_;  ///< [cloths] vertices
};

/// Whether two names are of one file that is there.
bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) && !error;
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// @throws SceneError if the output would replace an input, or a frame of one
void refuse_replacing_input(const fs::path& output, const ConvertRequest& request) {
  const std::string name = output.filename().string();
  const auto replaces = [&](const fs::path& input) {
    if (!is_there(output)) return false;
    if (same_file(output, input)) return true;
    if (is_folder(input)) {
      const fs::path frames = is_folder(input / "frames") ? input / "frames" : input;
      return same_file(folder_of(output), frames) &&
             (name.starts_with("cloth") || name.starts_with("obstacle") ||
              name.starts_with("animation"));
    }
    if (lower_extension(input) == ".json") return false;
    return io::NumberedName(input.filename().string()).number_in(name) >= 0 &&
           same_file(folder_of(output), folder_of(input));
  };
  if (std::any_of(request.files.begin(), request.files.end() - 1, replaces))
    throw SceneError(output.string(), "OUT", "the input", "another file");
}

std::vector<NamedMesh> all_of(FrameMeshes meshes) {
  std::vector<NamedMesh> all = std::move(meshes.cloths);
  for (NamedMesh& mesh : meshes.obstacles) all.push_back(std::move(mesh));
  return all;
}

/// A frame as one mesh file, or each as one of its own.
void convert_to_meshes(const MeshSequence& sequence, const std::vector<std::size_t>& places,
                       const ConvertRequest& request) {
  const fs::path output = request.output;
  const io::NumberedName name(output.filename().string());
  if (places.size() > 1 && !name.has_place())
    throw SceneError(request.output, "OUT", fmt::format("one file for {} frames", places.size()),
                     "a name with a place for the frame's number, such as " +
                         output.stem().string() + "_%05d" + output.extension().string() +
                         ", or --frame N");
  const auto file_of = [&](std::size_t place) {
    return output.parent_path() / name.with(sequence.frames()[place]);
  };
  for (const std::size_t place : places) refuse_replacing_input(file_of(place), request);
  const Frames frames(sequence, places, request);
  io::SeamEdges seams;
  for (const std::size_t place : places) {
    const auto meshes = all_of(io::in_world(frames.read(place, &seams)));
    const fs::path file = file_of(place);
    if (lower_extension(output) == ".ply")
      io::write_ply(file, meshes, Precision::double_precision, io::Normals::vertex, seams);
    else
      io::write_obj(file, meshes, io::Normals::vertex, io::Groups::panels, seams);
  }
}

/// Name of the cache of a mesh: OUT itself if there is only one.
/// @param taken by earlier meshes
fs::path cache_name(const fs::path& output, const std::string& mesh, bool only_one,
                    std::set<fs::path>& taken) {
  if (only_one) return output;
  const std::string stem = output.stem().string() + "_" + safe_file_name(mesh);
  const std::string ending = output.extension().string();
  fs::path file = output.parent_path() / (stem + ending);
  for (int k = 2; !taken.insert(file).second; ++k)
    file = output.parent_path() / (stem + "_" + std::to_string(k) + ending);
  return file;
}

void convert_to_caches(const MeshSequence& sequence, const std::vector<std::size_t>& places,
                       const ConvertRequest& request) {
  std::vector<io::PointCacheWriter> caches;
  std::vector<Mesh> first;
  std::set<fs::path> taken;
  // Frames at equal distances keep their numbers; others are counted through.
  const auto number = [&](std::size_t k) { return sequence.frames()[places[k]]; };
  const int distance = places.size() > 1 ? number(1) - number(0) : 1;
  for (std::size_t k = 1; k < places.size(); ++k)
    if (number(k) - number(k - 1) != distance)
      throw SceneError(request.output, "--frame", "frames at several distances",
                       "frames at equal distances, as a point cache has them");
  std::optional<Vec3<double>> origin;
  const Frames frames(sequence, places, request);
  for (const std::size_t place : places) {
    FrameMeshes frame = frames.read(place);
    // A mesh that is the input stays as it is, so its cache has to be in world positions too.
    if (!origin)
      origin = same_file(fs::path(request.output).replace_extension(".obj"), request.input)
                   ? Vec3<double>{0, 0, 0}
                   : io::local_origin(frame);
    io::move_origin(frame, *origin);
    const auto meshes = all_of(std::move(frame));
    for (std::size_t m = 0; caches.size() < meshes.size() && m < meshes.size(); ++m) {
      const fs::path file = cache_name(request.output, meshes[m].name, meshes.size() == 1, taken);
      refuse_replacing_input(file, request);
      fs::path topology = file;
      topology.replace_extension(".obj");
      io::write_cache_origin(file, *origin);
      if (!same_file(topology, request.input))
        io::write_obj(topology, {meshes[m]}, io::Normals::vertex, io::Groups::panels);
      caches.emplace_back(
          file,
          io::PointCacheHeader{static_cast<Index>(meshes[m].mesh.positions.size()),
                               static_cast<double>(number(0)), static_cast<double>(distance), 0});
      first.push_back(meshes[m].mesh);
    }
    if (meshes.size() != caches.size())
      throw SceneError(sequence.describe(place), "meshes", std::to_string(meshes.size()),
                       std::to_string(caches.size()) + ", as in the first frame");
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      const auto same = [](const Tri& a, const Tri& b) { return std::equal(a.v, a.v + 3, b.v); };
      const auto& triangles = meshes[m].mesh.triangles;
      if (!std::equal(triangles.begin(), triangles.end(), first[m].triangles.begin(),
                      first[m].triangles.end(), same))
        throw SceneError(sequence.describe(place), "triangles of " + meshes[m].name,
                         "others than in the first frame",
                         "for .pc2 a topology that stays as it is; .usda and numbered .obj and "
                         ".ply may change it");
      caches[m].append(meshes[m].mesh.positions);
    }
  }
}

/// Into a file that holds all frames of an attribute in one place.
/// @param write makes it of a spool
template <class Write>
void convert_to_animation(const MeshSequence& sequence, const std::vector<std::size_t>& places,
                          const ConvertRequest& request, const Write& write) {
  const fs::path output = request.output;
  const TemporaryFile spool(output.parent_path() /
                            ("." + output.filename().string() + ".spool.tmp"));
  std::optional<io::SpoolWriter> writer;
  std::optional<Vec3<double>> origin;
  const Frames frames(sequence, places, request);
  io::SeamEdges seams;
  for (const std::size_t place : places) {
    FrameMeshes meshes = frames.read(place, &seams);
    if (!origin) origin = io::local_origin(meshes);
    io::move_origin(meshes, *origin);
    if (!writer)
      writer.emplace(spool.path, sequence.frame_rate(), io::spooled_meshes(meshes), *origin);
    writer->append(sequence.frames()[place], meshes);
  }
  write(output, io::SpoolReader(spool.path), seams);
}

/// @throws SceneError if an option for sewing patterns was given
void refuse_pattern_options(const ConvertRequest& request) {
  if (!request.pattern_options.empty())
    throw SceneError("", request.pattern_options.front(), "beside " + request.input,
                     "this option only for a sewing pattern of GarmentCode (.json)");
}

/// @throws SceneError if there are several inputs, which only sewing patterns may be
void refuse_several(const ConvertRequest& request) {
  if (request.files.size() > 2)
    throw SceneError("", "IN", counted(request.files.size() - 1, "file"),
                     "one, or several sewing patterns of GarmentCode (.json)");
}

/// Makes the folder that the output stands in, where it is missing.
void make_folder_of(const fs::path& output) {
  if (output.has_parent_path()) make_output_folder(output.parent_path(), "OUT");
}

/// A scene of ARCSim, or sewing patterns, as a scene of weft; outlines as a sewing pattern.
void convert_scene(const ConvertRequest& request) {
  if (io::holds_outlines(request.input)) {
    refuse_pattern_options(request);
    refuse_several(request);
    make_folder_of(request.output);
    return convert_outlines(request.input, request.output);
  }
  const auto document = io::parse_json(read_file_bytes(request.input), request.input);
  const bool is_pattern = io::is_sewing_pattern(document);
  if (!io::is_arcsim_scene(document) &&
      (io::resembles_sewing_pattern(document) || !request.pattern_options.empty()))
    io::require_sewing_pattern(document, request.input);
  make_folder_of(request.output);
  std::vector<std::string> lines;
  if (is_pattern) {
    PatternRequest pattern = request.pattern;
    pattern.inputs.assign(request.files.begin(), request.files.end() - 1);
    pattern.output = request.output;
    lines = convert_patterns(pattern);
  } else {
    refuse_pattern_options(request);
    refuse_several(request);
    lines = io::convert_arcsim(request.input, request.output, request.allowed);
  }
  for (const std::string& line : lines) fmt::print(stderr, "weft: warning: {}\n", one_line(line));
}

void convert(const ConvertRequest& request) {
  const std::string to = lower_extension(request.output);
  refuse_replacing_input(request.output, request);
  if (to == ".json") return convert_scene(request);
  if (to != ".obj" && to != ".ply" && to != ".pc2" && to != ".usda" && to != ".glb")
    throw SceneError(request.output, "format", "\"" + to + "\"",
                     ".obj, .ply, .pc2, .usda, .glb, or .json for a scene");
  refuse_pattern_options(request);
  refuse_several(request);
  const auto sequence = io::open_sequence(request.input, io::Uv::where_some, request.allowed);
  const auto places = chosen_places(*sequence, request);
  make_folder_of(request.output);
  if (to == ".pc2")
    convert_to_caches(*sequence, places, request);
  else if (to == ".usda")
    convert_to_animation(*sequence, places, request,
                         [](const fs::path& file, const io::SpoolReader& spool,
                            const io::SeamEdges&) { io::write_usd(file, spool); });
  else if (to == ".glb")
    convert_to_animation(*sequence, places, request,
                         [](const fs::path& file, const io::SpoolReader& spool,
                            const io::SeamEdges& seams) { io::write_glb(file, spool, seams); });
  else
    convert_to_meshes(*sequence, places, request);
}

}  // namespace

void add_convert_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand = app.add_subcommand("convert", "Write meshes and animations in another format");
  auto request = std::make_shared<ConvertRequest>();
  subcommand
      ->add_option(
          "files", request->files,
          "IN: directory of a run, animation (.usda, .pc2), numbered meshes (DIR/%05d.obj), a "
          "mesh, a scene of ARCSim, outlines (.svg, .dxf), or sewing patterns of GarmentCode from "
          "the inside out. OUT: .obj or .ply (several frames: NAME_%05d.obj), .pc2, .usda, .glb; "
          ".json for a scene, or for a pattern from outlines")
      ->required()
      ->expected(2, CLI::detail::expected_max_vector_size)
      ->type_name("IN... OUT");
  subcommand->add_option("--frame", request->frames, "Only this frame, or last; may be repeated")
      ->type_name("N")
      ->allow_extra_args(false);
  subcommand->add_option("--only", request->only, "cloths or obstacles")
      ->check(CLI::IsMember({"cloths", "obstacles"}))
      ->type_name("KIND");
  subcommand->add_option("--body", request->pattern.body, "Sewing pattern: mesh of the body")
      ->type_name("MESH");
  subcommand
      ->add_option("--edge", request->pattern.edge, "Sewing pattern: length of edges, in metres")
      ->capture_default_str()
      ->type_name("M");
  subcommand
      ->add_option("--fabric", request->pattern.fabric, "Sewing pattern: fabric of all panels")
      ->capture_default_str()
      ->type_name("NAME");
  subcommand->add_flag("--weld", request->weld,
                       "Each cloth as one mesh: vertices that seams have joined become one, and "
                       "seam edges are written");
  add_allow_path(*subcommand, request->allowed);
  subcommand->callback([request, subcommand, &exit_code] {
    for (const char* option : {"--body", "--edge", "--fabric"})
      if (subcommand->count(option) > 0) request->pattern_options.emplace_back(option);
    request->input = request->files.front();
    request->output = request->files.back();
    convert(*request);
    exit_code = 0;
  });
}

}  // namespace weft::app
