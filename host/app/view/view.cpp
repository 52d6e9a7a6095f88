#include "host/app/view/view.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "host/app/render/frame_choice.hpp"
#include "host/app/render/run_scene.hpp"
#include "host/app/render/value_scale.hpp"
#include "host/app/run/allow_path.hpp"
#include "host/app/run/frame_parts.hpp"
#include "host/app/run/progress.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_output.hpp"
#include "host/app/view/pin_distances.hpp"
#include "host/app/view/player_page.hpp"
#include "host/app/view/player_run.hpp"
#include "host/app/view/run_facts.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/render/picture_values.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Thicknesses beyond which the page tells no difference, as in pictures.
constexpr double contact_reach = 2;

/// Thicknesses by which a pin may be beside its place without having given way.
constexpr double rounding_of_pins = 1e-2;

/// Browsers hold no text of more than 512 MB, and are slow long before.
constexpr std::size_t largest_page = 400'000'000;

struct Request {
  std::string input;
  std::string output;  ///< empty: view.html in the directory of the run
  std::string beside;  ///< another run; empty: none
  std::string frames;  ///< empty: all
  std::vector<std::string> allowed;
};

Json triple(const Vec3<double>& v) {
  return {v[0], v[1], v[2]};
}

/// Where the camera of a scene is at its first key. The player's camera has no roll.
Json camera_json(const Camera& camera) {
  if (camera.keys.empty()) return nullptr;
  const CameraKey& key = camera.keys.front();
  return {{"position", triple(key.position)},
          {"look_at", triple(key.look_at)},
          {"field_of_view", key.field_of_view},
          {"aspect", static_cast<double>(camera.width) / camera.height}};
}

/// A run that is to be shown.
class ShownRun {
 public:
  ShownRun(const std::string& input, const Request& request)
      : input_(input),
        sequence_(io::open_sequence(input, io::Uv::where_all, request.allowed)),
        places_(chosen_frames(sequence_->frames(), request.frames)),
        run_(scene_of_run(input, request.allowed)) {}

  std::size_t frame_count() const { return places_.size(); }

  /// Finds the ranges of what will be stored.
  PlayerRanges survey() const {
    PlayerRanges ranges;
    if (scene() != nullptr) ranges.contact = contact_reach;
    for (const std::size_t place : places_) {
      const PlayerFrame frame = read(place);
      for (const auto& cloth : frame.meshes.cloths)
        ranges.cloths.include(aabb_of(cloth.mesh.positions));
      for (const auto& body : frame.meshes.obstacles)
        ranges.obstacles.include(aabb_of(body.mesh.positions));
      ranges.obstacles.include(aabb_of(frame.displaced));
      const io::CornerValues strain = io::strain_values(frame.meshes.cloths);
      if (extent_of(strain))
        ranges.strain = std::max(ranges.strain, std::max(torn_triangles_apart(strain), 1e-3));
      ranges.compliance = std::max(ranges.compliance, farthest(frame));
    }
    return ranges;
  }

  /// @param progress gets a call per frame
  template <class Progress>
  PlayerRun stored(const PlayerRanges& ranges, const Progress& progress) const {
    PlayerRun run(facts(), ranges);
    for (const std::size_t place : places_) {
      PlayerFrame frame = read(place);
      if (ranges.strain > 0) frame.strain = io::strain_values(frame.meshes.cloths);
      if (ranges.contact > 0)
        frame.contact = io::contact_values(frame.meshes.cloths, frame.meshes.obstacles,
                                           contact_thickness(scene()->contact), contact_reach);
      run.add(frame);
      progress(sequence_->describe(place), run.size());
    }
    return run;
  }

 private:
  const Scene* scene() const { return run_.scene ? &*run_.scene : nullptr; }

  PlayerFrame read(std::size_t place) const {
    PlayerFrame frame;
    frame.number = sequence_->frames()[place];
    frame.time = frame.number / sequence_->frame_rate();
    frame.meshes = parted(io::in_world(sequence_->read(place)), scene());
    if (scene() != nullptr) frame.pins = pin_distances(*scene(), frame.meshes.cloths, frame.time);
    if (!is_folder(input_)) return frame;
    const RunDirectory directory(input_);
    const std::optional<Mesh> displaced = directory.read_displaced(frame.number);
    if (!displaced) return frame;
    std::size_t count = 0;
    for (const auto& body : frame.meshes.obstacles) count += body.mesh.positions.size();
    if (count != displaced->positions.size())
      throw SceneError(directory.displaced(frame.number).string(), "vertices",
                       std::to_string(displaced->positions.size()),
                       fmt::format("{}, as the obstacles of the frame have", count));
    frame.displaced = displaced->positions;
    return frame;
  }

  /// [m] Largest distance of an obstacle or a pin from its prescribed place. Pins miss theirs by
  /// rounding, which counts as nothing.
  double farthest(const PlayerFrame& frame) const {
    double largest = 0;
    for (const std::vector<float>& cloth : frame.pins)
      for (const float distance : cloth)
        if (distance > rounding_of_pins * contact_thickness(scene()->contact))
          largest = std::max<double>(largest, distance);
    if (frame.displaced.empty()) return largest;
    std::size_t v = 0;
    for (const auto& body : frame.meshes.obstacles)
      for (const Vec3<double>& p : body.mesh.positions)
        largest = std::max(largest, length(frame.displaced[v++] - p));
    return largest;
  }

  Json facts() const {
    Json facts = run_facts(input_);
    // The last name alone: a page is passed on, and where its run was is nobody's business.
    const fs::path path = fs::absolute(input_).lexically_normal();
    facts["folder"] =
        one_line((path.has_filename() ? path : path.parent_path()).filename().string());
    facts["camera"] = scene() != nullptr ? camera_json(scene()->camera) : Json(nullptr);
    facts["thickness"] =
        scene() != nullptr ? Json(contact_thickness(scene()->contact)) : Json(nullptr);
    return facts;
  }

  std::string input_;
  std::unique_ptr<io::MeshSequence> sequence_;
  std::vector<std::size_t> places_;
  RunScene run_;
};

/// @throws SceneError if the page must not be written there
fs::path output_of(const Request& request) {
  if (!request.output.empty()) {
    const std::string ending = fs::path(request.output).extension().string();
    if (ending != ".html" && ending != ".htm")
      throw SceneError("", "-o", request.output, "a file name that ends in .html");
    refuse_unwritable(request.output, "-o");
    return request.output;
  }
  const fs::path file = fs::path(is_folder(request.input) ? request.input : "") / "view.html";
  // A stranger's run may hold a link, through which the page would replace another file.
  std::error_code error;
  if (fs::is_symlink(file, error))
    throw SceneError(file.string(), "-o", "a link", "a file; -o FILE.html names another one");
  return file;
}

/// Scales of two runs beside each other are the same, so that colours compare.
void unite_scales(std::vector<PlayerRanges>& ranges) {
  double strain = 0, compliance = 0;
  for (const PlayerRanges& r : ranges) {
    strain = std::max(strain, r.strain);
    compliance = std::max(compliance, r.compliance);
  }
  for (PlayerRanges& r : ranges) {
    if (r.strain > 0) r.strain = rounded_up(strain);
    if (r.compliance > 0) r.compliance = rounded_up(compliance);
  }
}

void view(const Request& request) {
  const PageShell shell = built_shell();
  if (shell.head.empty())
    throw SceneError(
        "weft view: this build lacks three.js; install libjs-three and build the program again");
  const fs::path output = output_of(request);
  std::vector<ShownRun> shown;
  shown.emplace_back(request.input, request);
  if (!request.beside.empty()) shown.emplace_back(request.beside, request);

  std::vector<PlayerRanges> ranges;
  std::size_t count = 0;
  for (const ShownRun& run : shown) {
    ranges.push_back(run.survey());
    count += run.frame_count();
  }
  unite_scales(ranges);

  FrameProgress progress(stdout, count);
  std::vector<PlayerRun> runs;
  std::size_t done = 0, size = 0;
  for (std::size_t r = 0; r < shown.size(); ++r) {
    runs.push_back(shown[r].stored(ranges[r], [&](const std::string& label, std::size_t bytes) {
      if (size + bytes > largest_page)
        throw SceneError("", "--frames", request.frames.empty() ? "all" : request.frames,
                         fmt::format("fewer frames, such as ::4: the page would have more than {} "
                                     "MB",
                                     largest_page / 1'000'000));
      progress.frame(++done, label);
    }));
    size += runs.back().size();
  }
  progress.end();
  const std::string page = player_page(shell, runs);
  write_file_atomically(output, page);
  fmt::print("{} in {}, {:.1f} MB; open it in a browser\n", counted(count, "frame"),
             one_line(output.string()), static_cast<double>(page.size()) / 1e6);
}

}  // namespace

void add_view_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand =
      app.add_subcommand("view", "Make a page that plays the frames of a run in a browser");
  auto request = std::make_shared<Request>();
  add_shown_frames(*subcommand, request->input, request->frames);
  subcommand->add_option("-o,--output", request->output, "The page; default: DIR/view.html")
      ->type_name("FILE.html");
  subcommand
      ->add_option("--beside", request->beside,
                   "Another run, to the right of the first and at the same time")
      ->type_name("DIR");
  add_allow_path(*subcommand, request->allowed);
  subcommand->callback([request, &exit_code] {
    view(*request);
    exit_code = 0;
  });
}

}  // namespace weft::app
