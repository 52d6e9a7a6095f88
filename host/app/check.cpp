#include "host/app/check.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <regex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/app/run/allow_path.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_output.hpp"
#include "host/app/run/sewn_scene.hpp"
#include "host/app/worn_check.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/split_objects.hpp"
#include "host/lab/check/displaced_verdict.hpp"
#include "host/lab/check/report_json.hpp"
#include "host/lab/worn/worn_json.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using io::NamedMesh;
using lab::DisplacedVerdict;
using lab::FrameVerdict;
using Json = nlohmann::ordered_json;

enum CheckExitCode { nothing_found = 0, something_found = 1, bad_input = 2 };

/// What CLI11 hands over for an option whose optional value is left out.
const std::string no_value = "true";

struct CheckRequest {
  std::vector<std::string> inputs;
  std::string obstacle;  ///< empty: the obstacle of the frame
  bool json = false;
  std::string json_file;  ///< empty: standard output
  bool no_self = false;
  bool sewn = false;
  bool quiet = false;
  bool worn = false;                 ///< whether garments are worn, too
  WornRequest worn_of;               ///< of each input; the rest is filled in
  std::vector<std::string> allowed;  ///< folders of files that meshes name, beside their own
};

/// One cloth mesh to check.
struct Frame {
  fs::path cloth;     ///< with a sequence: what to call the frame
  fs::path obstacle;  ///< empty: none, or that of the sequence
  std::shared_ptr<const io::MeshSequence> sequence = nullptr;  ///< null: `cloth` is a file
  std::size_t place = 0;                                       ///< of the frame in the sequence
  lab::ValidatorOptions options{};                             ///< of the run's scene
  fs::path displaced{};  ///< all obstacles as simulated; empty: none was displaced
};

/// What the run's scene asks of its frames.
lab::ValidatorOptions options_of_run(const fs::path& directory) {
  lab::ValidatorOptions options;
  const fs::path file = directory / "scene.json";
  if (!is_file(file)) return options;
  const Json scene = Json::parse(read_file_bytes(file), nullptr, false);
  if (!scene.is_object()) return options;
  options.sewn = sews(scene);
  const Json off = false;
  options.self = !(scene.contains("contact") && scene["contact"].is_object() &&
                   scene["contact"].value("self", Json(true)) == off);
  return options;
}

/// The obstacle that cloth has displaced farthest in a frame.
struct DisplacedBody {
  std::string name;
  double distance = 0;  ///< [m] of the vertex that is farthest from its prescribed place
};

struct Outcome {
  std::optional<DisplacedVerdict> verdict;
  std::string nonfinite;     ///< what the mesh reader said where it met a NaN or an infinity
  std::string error;         ///< why the frame could not be checked, one line
  DisplacedBody farthest{};  ///< set if the frame is clean only against displaced obstacles

  bool only_against_displaced() const {
    return error.empty() && nonfinite.empty() && verdict && verdict->clean_against_displaced();
  }
  bool found() const {
    return !nonfinite.empty() ||
           (verdict && !verdict->clean() && !verdict->clean_against_displaced());
  }
  bool clean() const { return error.empty() && !found() && !only_against_displaced(); }
};

/// Number and path of each file NAME_NNNNN.obj or .ply, in order of number, then path.
std::multimap<long, fs::path> numbered_meshes(const fs::path& directory, const std::string& name) {
  const std::regex pattern(name + R"(_(\d{1,9})\.(obj|ply))");
  std::multimap<long, fs::path> found;
  for (const auto& path : files_in(directory)) {
    std::smatch match;
    const std::string file = path.filename().string();
    if (std::regex_match(file, match, pattern)) found.emplace(std::stol(match[1]), path);
  }
  return found;
}

/// File of the displaced obstacles of a run's frame; empty: none, or another obstacle is asked for.
fs::path displaced_of(const fs::path& directory, int number, const fs::path& obstacle) {
  const fs::path file = RunDirectory(directory).displaced(number);
  return obstacle.empty() && is_there(file) ? file : fs::path();
}

/// Frames of what holds several in a file: point caches, USD.
std::vector<Frame> frames_of_sequence(const fs::path& path, const fs::path& obstacle) {
  const std::shared_ptr<const io::MeshSequence> sequence = io::open_sequence(path);
  std::vector<Frame> list;
  for (std::size_t k = 0; k < sequence->frames().size(); ++k) {
    list.push_back({sequence->describe(k), obstacle, sequence, k});
    if (fs::is_directory(path))
      list.back().displaced = displaced_of(path, sequence->frames()[k], obstacle);
  }
  return list;
}

/// Frames of a run.
/// @param obstacle takes the place of every obstacle of the run, unless empty
/// @throws SceneError if there is no frame, or a cloth frame lacks its obstacle although others
///         have one: checked without it, it would pass for clean
std::vector<Frame> frames_of_run(const fs::path& directory, const fs::path& obstacle) {
  const fs::path frames = directory / "frames";
  const auto cloths = numbered_meshes(frames, "cloth");
  std::vector<Frame> list;
  if (io::has_frame_caches(frames)) list = frames_of_sequence(directory, obstacle);
  if (cloths.empty() && list.empty())
    throw SceneError(directory.string(), "frames", "no frame",
                     "a directory with frames as weft run writes them, such as "
                     "frames/cloth_NNNNN.obj");
  const auto obstacles = numbered_meshes(frames, "obstacle");
  const fs::path still = io::still_obstacles(frames);
  for (const auto& [number, cloth] : cloths) {
    Frame frame{cloth, obstacle};
    if (obstacle.empty() && !(obstacles.empty() && still.empty())) {
      const auto match = obstacles.find(number);
      if (match == obstacles.end() && still.empty())
        throw SceneError(cloth.string(), "obstacle", "no mesh of this number",
                         "frames/obstacle_NNNNN.obj or .ply for every frame, or for none");
      frame.obstacle = match == obstacles.end() ? still : match->second;
    }
    frame.displaced = displaced_of(directory, static_cast<int>(number), obstacle);
    list.push_back(std::move(frame));
  }
  return list;
}

/// Whether a file is of a format that holds frames rather than one mesh.
bool holds_several(const fs::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".pc2" || extension == ".usda" || extension == ".spool";
}

std::vector<Frame> frames_of(const CheckRequest& request) {
  std::vector<Frame> frames;
  for (const auto& input : request.inputs) {
    if (!is_there(input)) fail_on(input, "read", ENOENT);
    if (fs::is_directory(input)) {
      auto run = frames_of_run(input, request.obstacle);
      const lab::ValidatorOptions options = options_of_run(input);
      for (Frame& frame : run) frame.options = options;
      frames.insert(frames.end(), run.begin(), run.end());
    } else if (holds_several(input)) {
      const auto all = frames_of_sequence(input, request.obstacle);
      frames.insert(frames.end(), all.begin(), all.end());
    } else {
      frames.push_back({input, request.obstacle});
    }
  }
  return frames;
}

/// Whether a reader's complaint is about a NaN or an infinity as the value.
/// @param message "FILE: field: value; allowed: ..."
bool about_nonfinite(const std::string& message, const fs::path& file) {
  std::string value = message.substr(0, message.find("; allowed: "));
  if (value.starts_with(file.string())) value.erase(0, file.string().size());
  static const std::regex word(R"((^|[^a-z])(nan|inf|infinity)([^a-z]|$))", std::regex::icase);
  return std::regex_search(value, word);
}

/// Reads a mesh; a NaN or an infinity in it is a finding, which is written to the outcome.
std::optional<Mesh> read(const fs::path& path, io::Uv uv, const std::vector<std::string>& allowed,
                         Outcome& outcome) {
  try {
    return io::read_mesh(path, uv, ReadableFolders(path, allowed));
  } catch (const SceneError& e) {
    (about_nonfinite(e.what(), path) ? outcome.nonfinite : outcome.error) = e.what();
    return std::nullopt;
  }
}

/// Reads a frame of a sequence; a NaN or an infinity in it is a finding.
/// @param obstacles in world positions; out: set if the sequence has any and it is empty
/// @param origin    out: [m] what cloth and obstacles are relative to; they keep the exact numbers
///                  of the file
std::optional<Mesh> read(const Frame& frame, std::vector<NamedMesh>& obstacles,
                         Vec3<double>& origin, Outcome& outcome) {
  try {
    io::FrameMeshes meshes = frame.sequence->read(frame.place);
    origin = meshes.origin;
    for (NamedMesh& other : obstacles) io::move_origin(other.mesh, {0, 0, 0}, origin);
    if (obstacles.empty()) obstacles = std::move(meshes.obstacles);
    return io::joined(meshes.cloths);
  } catch (const SceneError& e) {
    (about_nonfinite(e.what(), frame.cloth) ? outcome.nonfinite : outcome.error) = e.what();
    return std::nullopt;
  }
}

double largest_distance(const std::vector<Vec3<double>>& a, const std::vector<Vec3<double>>& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) largest = std::max(largest, length(a[v] - b[v]));
  return largest;
}

/// Names the obstacle that is farthest from its prescribed place.
/// @param prescribed by obstacle where the frame's format names these, else as one mesh
/// @param displaced  by obstacle
/// @throws SceneError if the two do not have the same vertices
DisplacedBody farthest_displaced(const std::vector<NamedMesh>& prescribed,
                                 const std::vector<NamedMesh>& displaced, const fs::path& file) {
  // Point caches are in the order of their names; .ply has no names but the order of the scene.
  const Mesh all = io::joined(prescribed);
  DisplacedBody farthest;
  std::size_t first = 0;
  for (const NamedMesh& body : displaced) {
    const std::size_t count = body.mesh.positions.size();
    const auto named = std::find_if(prescribed.begin(), prescribed.end(),
                                    [&](const NamedMesh& m) { return m.name == body.name; });
    std::vector<Vec3<double>> places;
    if (named != prescribed.end())
      places = named->mesh.positions;
    else if (prescribed.size() == 1 && first + count <= all.positions.size())
      places.assign(all.positions.begin() + static_cast<std::ptrdiff_t>(first),
                    all.positions.begin() + static_cast<std::ptrdiff_t>(first + count));
    if (places.size() != count)
      throw SceneError(file.string(), body.name, counted(count, "vertex"),
                       "the vertices of the frame's obstacle");
    const double distance = largest_distance(places, body.mesh.positions);
    if (distance > farthest.distance) farthest = {body.name, distance};
    first += count;
  }
  return farthest;
}

Outcome validate_frame(const Frame& frame, const std::vector<std::string>& allowed,
                       lab::ValidatorOptions options) {
  Outcome outcome;
  options.sewn = options.sewn || frame.options.sewn;
  options.self = options.self && frame.options.self;
  try {
    std::vector<NamedMesh> obstacles;
    if (!frame.obstacle.empty())
      if (auto mesh = read(frame.obstacle, io::Uv::ignore, allowed, outcome))
        obstacles.push_back({"", std::move(*mesh)});
    Vec3<double> origin{0, 0, 0};
    const std::optional<Mesh> cloth = frame.sequence
                                          ? read(frame, obstacles, origin, outcome)
                                          : read(frame.cloth, io::Uv::where_all, allowed, outcome);
    std::optional<Mesh> displaced;
    if (!frame.displaced.empty())
      displaced = read(frame.displaced, io::Uv::ignore, allowed, outcome);
    if (displaced) io::move_origin(*displaced, {0, 0, 0}, origin);
    if (!cloth || !outcome.error.empty()) return outcome;
    const Mesh obstacle = io::joined(obstacles);
    outcome.verdict = lab::validate(*cloth, obstacles.empty() ? nullptr : &obstacle,
                                    displaced ? &*displaced : nullptr, options);
    if (!outcome.only_against_displaced()) return outcome;
    if (obstacles.size() == 1 && obstacles[0].name.empty())
      obstacles = io::split_objects(std::move(obstacles[0]));
    outcome.farthest = farthest_displaced(obstacles, io::split_objects({"", std::move(*displaced)}),
                                          frame.displaced);
  } catch (const std::exception& e) {
    outcome.error = frame.cloth.string() + ": " + e.what();
  }
  return outcome;
}

/// Checks frames on all cores and hands each outcome to report(index) in the order of the frames,
/// one at a time, as soon as it and all before it are there.
template <class Report>
void validate_all(const std::vector<Frame>& frames, const std::vector<std::string>& allowed,
                  lab::ValidatorOptions options, std::vector<Outcome>& outcomes, Report&& report) {
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t workers = std::min(cores, frames.size());
  options.threads = workers > 0 ? static_cast<int>(cores / workers) : 1;
  outcomes.resize(frames.size());
  std::vector<bool> done(frames.size(), false);
  std::size_t reported = 0;
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i; (i = next.fetch_add(1)) < frames.size();) {
      Outcome outcome = validate_frame(frames[i], allowed, options);
      const std::lock_guard lock(mutex);
      outcomes[i] = std::move(outcome);
      done[i] = true;
      for (; reported < frames.size() && done[reported]; ++reported) report(reported);
    }
  };
  std::vector<std::jthread> threads;
  for (std::size_t w = 1; w < workers; ++w) threads.emplace_back(work);
  work();
}

constexpr std::size_t shown = 5;  // findings of a kind spelled out in a line

std::string describe_pairs(const FrameVerdict& v, lab::PairKind kind, std::int64_t count,
                           const char* name) {
  if (count == 0) return {};
  std::string text = fmt::format("; {} {} {}:", count, name, noun_for(count, "intersection"));
  std::size_t listed = 0;
  for (const auto& pair : v.pairs)
    if (pair.kind == kind && listed < shown) {
      text += fmt::format(" ({}, {})", pair.a, pair.b);
      ++listed;
    }
  return text + (static_cast<std::size_t>(count) > listed ? " ..." : "");
}

std::string describe(const lab::Findings& f, const char* name) {
  if (f.count == 0) return {};
  std::string text = fmt::format("; {} {}:", f.count, name);
  const std::size_t listed = std::min(shown, f.list.size());
  for (std::size_t i = 0; i < listed; ++i) text += fmt::format(" {}", f.list[i]);
  return text + (static_cast<std::size_t>(f.count) > listed ? " ..." : "");
}

/// The line of a frame in which something was found.
std::string describe(const Frame& frame, const Outcome& outcome) {
  std::string text;
  if (!outcome.nonfinite.empty()) text += "; non-finite vertex: " + outcome.nonfinite;
  if (outcome.verdict) {
    const FrameVerdict* v = &outcome.verdict->prescribed;
    text += describe_pairs(*v, lab::PairKind::cloth_cloth, v->cloth_cloth_count, "cloth-cloth");
    text += describe_pairs(*v, lab::PairKind::cloth_obstacle, v->cloth_obstacle_count,
                           "cloth-obstacle");
    text += describe(v->inverted, "inverted");
    text += describe(v->degenerate, "degenerate");
    text += describe(v->nonfinite, "non-finite vertices");
    text += describe(v->nonfinite_obstacle, "non-finite obstacle vertices");
  }
  return frame.cloth.string() + ": " + text.substr(2);
}

struct Summary {
  std::size_t frames = 0;
  std::size_t clean = 0;
  std::size_t only_against_displaced = 0;
  std::size_t bad = 0;
  std::size_t unreadable = 0;
  std::int64_t intersections = 0;  ///< of bad frames

  int exit_code() const {
    return unreadable > 0 ? bad_input : bad > 0 ? something_found : nothing_found;
  }
};

Summary summarize(const std::vector<Outcome>& outcomes) {
  Summary s;
  s.frames = outcomes.size();
  for (const auto& o : outcomes) {
    s.clean += o.clean();
    s.only_against_displaced += o.only_against_displaced();
    s.unreadable += !o.error.empty();
    s.bad += o.found();
    if (o.verdict) s.intersections += o.verdict->intersections();
  }
  return s;
}

Json to_json(const std::vector<Frame>& frames, const std::vector<Outcome>& outcomes,
             const Summary& summary) {
  Json list = Json::array();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Json entry{{"cloth", frames[i].cloth.string()}};
    entry["obstacle"] =
        frames[i].obstacle.empty() ? Json(nullptr) : Json(frames[i].obstacle.string());
    entry["clean"] = outcomes[i].clean();
    entry["clean_against_displaced"] = outcomes[i].only_against_displaced();
    if (!frames[i].displaced.empty()) entry["displaced"] = frames[i].displaced.string();
    if (outcomes[i].only_against_displaced()) {
      entry["displaced_body"] = outcomes[i].farthest.name;
      entry["displaced_by_m"] = outcomes[i].farthest.distance;
    }
    if (!outcomes[i].error.empty()) entry["error"] = outcomes[i].error;
    if (!outcomes[i].nonfinite.empty()) entry["nonfinite"] = outcomes[i].nonfinite;
    if (outcomes[i].verdict) entry["verdict"] = lab::to_json(outcomes[i].verdict->prescribed);
    list.push_back(std::move(entry));
  }
  return {{"frames", std::move(list)},
          {"summary",
           {{"frames", summary.frames},
            {"clean_against_displaced", summary.only_against_displaced},
            {"bad", summary.bad},
            {"unreadable", summary.unreadable},
            {"intersections", summary.intersections},
            {"clean", summary.exit_code() == nothing_found}}}};
}

/// One line for all frames that are clean only against displaced obstacles: the one in which an
/// obstacle is farthest from its prescribed place.
void warn_of_displaced(const std::vector<Frame>& frames, const std::vector<Outcome>& outcomes,
                       const Summary& summary) {
  if (summary.only_against_displaced == 0) return;
  std::size_t worst = 0;
  for (std::size_t i = 1; i < outcomes.size(); ++i)
    if (outcomes[i].farthest.distance > outcomes[worst].farthest.distance) worst = i;
  const DisplacedBody& body = outcomes[worst].farthest;
  const std::size_t others = summary.only_against_displaced - 1;
  // Names come from files that a stranger may have written.
  const std::string text =
      fmt::format("{}: clean only against {} where cloth displaced it, by {:.4g} m{}",
                  frames[worst].cloth.string(), body.name, body.distance,
                  others == 0 ? "" : "; " + counted(others, "more such frame"));
  fmt::print(stderr, "weft: warning: {}\n", one_line(text));
}

/// report.json of a run; none: the input is no run.
std::optional<Json> report_of(const std::string& input) {
  const RunDirectory directory(input);
  if (!is_there(directory.steps())) return std::nullopt;
  return Json::parse(bytes_if_readable(directory.report()), nullptr, false);
}

/// Why a run is not whole; empty: it is, or the input is no run.
std::string incomplete(const std::string& input) {
  const std::optional<Json> report = report_of(input);
  if (!report) return {};
  if (!report->is_object()) return "has no report.json, so it goes on or was killed";
  if (!report->contains("failure") || !(*report)["failure"].is_string()) return {};
  return "is not whole: " + (*report)["failure"].get<std::string>();
}

/// Frames of a run that failed, or was killed, are clean too: a line for each directory of a run
/// that is not whole.
void warn_of_incomplete(const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs)
    if (const std::string why = incomplete(input); !why.empty())
      fmt::print(stderr, "weft: warning: {}\n", one_line(input + ": the run " + why));
}

/// Why the last frame of a run is not where its cloth is to end; empty: it is, or the input is no
/// run.
std::string why_unfinished(const std::string& input) {
  if (const std::string why = incomplete(input); !why.empty()) return "the run " + why;
  const std::optional<Json> report = report_of(input);
  const Json no = false;
  return report && report->value("rested", Json()) == no ? "has not come to rest" : "";
}

/// Whether garments are worn at the end of each input, with a line for each garment, or for each of
/// its faults. What is not whole, or does not rest, is not worn yet.
/// @param text whether to print these
/// @return a garment an entry
Json check_all_worn(const CheckRequest& request, bool text, bool& all_worn) {
  Json list = Json::array();
  for (const std::string& input : request.inputs) {
    WornRequest one = request.worn_of;
    one.input = input;
    one.obstacle = request.obstacle;
    one.sewn = request.sewn || options_of_run(input).sewn;
    one.allowed = request.allowed;
    WornOutcome outcome = check_worn(one);
    if (text && !outcome.start_known)
      fmt::print("{}\n", one_line(input + ": the start is not known, so labels and openings alone "
                                          "decide; --start or --allow-path may help"));
    const std::string unfinished = why_unfinished(input);
    for (lab::GarmentVerdict& garment : outcome.garments) {
      if (!unfinished.empty()) garment.faults.push_back(unfinished);
      const std::string name = input + ": garment " + garment.name + ": ";
      if (text && garment.worn()) fmt::print("{}\n", one_line(name + "worn"));
      for (const std::string& fault : garment.faults)
        if (text) fmt::print("{}\n", one_line(name + fault));
      all_worn = all_worn && garment.worn();
      Json entry = lab::to_json(garment);
      entry["input"] = input;
      list.push_back(std::move(entry));
    }
  }
  return list;
}

int run(const CheckRequest& request) {
  const std::vector<Frame> frames = frames_of(request);
  const bool text = !request.quiet && !(request.json && request.json_file.empty());
  lab::ValidatorOptions options;
  options.self = !request.no_self;
  options.sewn = request.sewn;
  std::vector<Outcome> outcomes;
  validate_all(frames, request.allowed, options, outcomes, [&](std::size_t i) {
    if (!outcomes[i].error.empty()) fmt::print(stderr, "weft: {}\n", one_line(outcomes[i].error));
    if (text && outcomes[i].found()) fmt::print("{}\n", one_line(describe(frames[i], outcomes[i])));
  });

  const Summary summary = summarize(outcomes);
  if (text)
    fmt::print("{} checked: {} clean, {}{} with findings, {} unreadable; {}\n",
               counted(summary.frames, "frame"), summary.clean,
               summary.only_against_displaced == 0
                   ? ""
                   : fmt::format("{} clean only against displaced bodies, ",
                                 summary.only_against_displaced),
               summary.bad, summary.unreadable, counted(summary.intersections, "intersection"));
  if (text && !request.no_self &&
      std::any_of(frames.begin(), frames.end(), [](const Frame& f) { return !f.options.self; }))
    fmt::print("contact.self is false in the scene: cloth against cloth was left out\n");
  if (!request.quiet) warn_of_displaced(frames, outcomes, summary);
  if (!request.quiet) warn_of_incomplete(request.inputs);
  bool all_worn = true;
  const Json worn =
      request.worn && summary.unreadable == 0 ? check_all_worn(request, text, all_worn) : Json();
  if (request.json) {
    Json json = to_json(frames, outcomes, summary);
    if (request.worn) json["worn"] = worn;
    const std::string report = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    if (request.json_file.empty()) {
      fmt::print("{}", report);
    } else {
      std::ofstream file(request.json_file, std::ios::binary);
      file << report;
      if (!file.flush())
        throw SceneError(request.json_file, "--json", "no file", "a writable path");
    }
  }
  return all_worn ? summary.exit_code() : std::max<int>(summary.exit_code(), something_found);
}

/// Makes sense of the optional value of --json. `--json DIR` asks for the report of DIR: a mesh or
/// any other file that is no report must never be overwritten by one.
/// @throws SceneError if the value is neither a report nor something to check
void settle_json(CheckRequest& request) {
  const std::string value = std::exchange(request.json_file, {});
  if (value.empty() || value == no_value) return;
  if (fs::path(value).extension() == ".json") {
    refuse_unwritable(value, "--json");
    request.json_file = value;
  } else if (fs::exists(value))
    request.inputs.push_back(value);
  else
    throw SceneError("", "--json", value, "a file name that ends in .json");
}

}  // namespace

void add_check_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand = app.add_subcommand(
      "check", "Check frames independently: intersections, inversions, degenerate triangles, NaN");
  auto request = std::make_shared<CheckRequest>();
  subcommand
      ->add_option("inputs", request->inputs,
                   "Directory of a run, or cloth meshes (.obj, .ply, .pc2, .usda)")
      ->type_name("DIR|MESH");
  auto* json = subcommand
                   ->add_option("--json", request->json_file,
                                "Report as JSON to FILE.json, or to standard output without FILE")
                   ->expected(0, 1)
                   ->type_name("[FILE.json]");
  subcommand->add_option("--obstacle", request->obstacle,
                         "Obstacle mesh for every frame, instead of the frame's own");
  subcommand->add_flag("--no-self", request->no_self, "Leave cloth against cloth out");
  subcommand->add_flag(
      "--sewn", request->sewn,
      "Cloth vertices at exactly one place are one, as after sewing; a run's directory "
      "tells that by itself");
  auto* worn = subcommand->add_flag(
      "--worn", request->worn,
      "Check too that garments are worn at the end: around the parts of the body that they were "
      "made for, not slid, turned, inside out or overstretched");
  subcommand
      ->add_option("--body", request->worn_of.body,
                   "Name of the obstacle that wears them; default: body, or the only one")
      ->type_name("NAME")
      ->needs(worn);
  subcommand
      ->add_option("--segmentation", request->worn_of.segmentation,
                   "Vertices of the body by part, as {\"left_arm\": [0, 1, ...], ...}; default: "
                   "limbs are found by themselves")
      ->type_name("FILE.json")
      ->needs(worn);
  subcommand
      ->add_option("--start", request->worn_of.start,
                   "Cloth at the start; default: frame 0, or the scene of the run")
      ->type_name("MESH")
      ->needs(worn);
  add_allow_path(*subcommand, request->allowed);
  subcommand->add_flag("--quiet", request->quiet,
                       "Print errors only; the exit code tells the rest");
  subcommand->callback([request, json, &exit_code] {
    request->json = json->count() > 0;
    try {
      settle_json(*request);
      if (request->inputs.empty())
        throw SceneError("", "inputs", "nothing", "a directory of a run, or meshes");
      exit_code = run(*request);
    } catch (const std::exception& e) {
      fmt::print(stderr, "weft: {}\n", one_line(e.what()));
      exit_code = bad_input;
    }
  });
}

}  // namespace weft::app
