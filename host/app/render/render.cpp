#include "host/app/render/render.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <regex>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/app/render/frame_choice.hpp"
#include "host/app/render/movie.hpp"
#include "host/app/render/render_view.hpp"
#include "host/app/render/run_scene.hpp"
#include "host/app/render/value_scale.hpp"
#include "host/app/run/allow_path.hpp"
#include "host/app/run/frame_parts.hpp"
#include "host/app/run/number_range.hpp"
#include "host/app/run/output_folder.hpp"
#include "host/app/run/progress.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/render/picture.hpp"
#include "host/render/picture_legend.hpp"
#include "host/render/picture_values.hpp"
#include "host/render/png_file.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

/// Thicknesses beyond which "contact" tells no difference: below the distance of neighbours in a
/// mesh whose cells are at least four thicknesses wide, as the default thickness has it.
constexpr double contact_reach = 2;

struct Request {
  std::string input;
  std::string output;  ///< empty: pictures/ in the directory of the run
  std::string frames;  ///< empty: all
  std::string size;    ///< empty: that of the scene's camera
  int samples = io::PictureOptions{}.samples;
  std::string color = "cloth";
  std::string range;  ///< empty: from the frames
  std::string camera;
  std::string beside;                        ///< another run; empty: none
  std::optional<double> azimuth, elevation;  ///< [degrees]
  bool edges = false;
  std::string movie;                 ///< empty: none
  bool overwrite = false;            ///< pictures that are there
  std::vector<std::string> allowed;  ///< folders of files that the scene and meshes name
};

/// Two numbers around a separator.
std::optional<std::pair<double, double>> pair_of(const std::string& text, char separator) {
  const std::size_t at = text.find(separator);
  if (at == std::string::npos) return {};
  std::pair<double, double> result;
  for (auto [part, value] : {std::pair{text.substr(0, at), &result.first},
                             std::pair{text.substr(at + 1), &result.second}}) {
    std::size_t used = 0;
    try {
      *value = std::stod(part, &used);
    } catch (const std::exception&) {
      return {};
    }
    if (used != part.size() || !std::isfinite(*value)) return {};
  }
  return result;
}

/// What colours the cloth.
class Coloring {
 public:
  enum class Kind { cloth, strain, height, contact, view };

  /// @param scene null: not known
  /// @throws SceneError for another range, or a thickness that is not known
  Coloring(const Request& request, const Scene* scene) {
    kind_ = request.color == "strain"    ? Kind::strain
            : request.color == "height"  ? Kind::height
            : request.color == "contact" ? Kind::contact
            : request.color == "view"    ? Kind::view
                                         : Kind::cloth;
    if (kind_ == Kind::view) {
      if (scene == nullptr || scene->camera.keys.empty())
        throw SceneError("", "--color", "view", "a run whose scene has a camera");
      scene_ = scene;
    }
    if (kind_ == Kind::contact) {
      if (scene == nullptr)
        throw SceneError("", "--color", "contact",
                         "a run whose scene.json can be read: it tells the thickness");
      thickness_ = contact_thickness(scene->contact);
    }
    if (request.range.empty()) return;
    range_ = pair_of(request.range, ':');
    if (!range_ || !(range_->first < range_->second))
      throw SceneError("", "--range", request.range, "LOW:HIGH, two numbers, LOW < HIGH");
    if (kind_ == Kind::cloth)
      throw SceneError("", "--range", request.range, "a --color that has numbers");
  }

  bool has_numbers() const { return kind_ != Kind::cloth; }
  bool is_of_edges() const { return kind_ == Kind::view; }

  /// Widens the range by one frame that is shown.
  void see(const io::FrameMeshes& meshes) {
    if (range_ || (kind_ != Kind::strain && kind_ != Kind::height)) return;
    const io::CornerValues values = numbers(meshes, 0);
    const std::optional<Extent> extent = extent_of(values);
    if (!extent) return;
    // A few torn triangles must not take the whole scale.
    seen_high_ =
        std::max(seen_high_, kind_ == Kind::strain ? torn_triangles_apart(values) : extent->high);
    seen_low_ = std::min(seen_low_, extent->low);
  }

  /// After see() of all of these.
  /// @throws SceneError if there is nothing to show
  void settle() {
    if (range_ || kind_ == Kind::cloth) return;
    if (kind_ == Kind::contact) {
      range_ = {0, contact_reach};
      return;
    }
    if (kind_ == Kind::view) {
      range_ = {0, 1};
      return;
    }
    if (!(seen_high_ >= seen_low_))
      throw SceneError("", "--color", "strain", "frames with material coordinates");
    if (kind_ == Kind::strain)
      range_ = {0, std::max(rounded_up(seen_high_), 1e-3)};
    else
      range_ = {seen_low_, std::max(seen_high_, seen_low_ + 1e-6)};
  }

  io::PictureValues values(const io::FrameMeshes& meshes, double time) const {
    return {numbers(meshes, time), range_->first, range_->second};
  }

  io::Legend legend() const {
    const auto [low, high] = *range_;
    if (kind_ == Kind::strain) return {"strain (%)", 100 * low, 100 * high, true, true};
    if (kind_ == Kind::height) return {"height (m)", low, high, false, false};
    if (kind_ == Kind::view) return {"view factor", low, high, false, false};
    return {"gap / thickness", low, high, false, true};
  }

 private:
  io::CornerValues numbers(const io::FrameMeshes& meshes, double time) const {
    if (kind_ == Kind::view) return view_factor_values(meshes, *scene_, time);
    if (kind_ == Kind::strain) return io::strain_values(meshes.cloths);
    if (kind_ == Kind::height) return io::height_values(meshes.cloths);
    return io::contact_values(meshes.cloths, meshes.obstacles, thickness_, contact_reach);
  }

  Kind kind_ = Kind::cloth;
  const Scene* scene_ = nullptr;  ///< of view factors
  double thickness_ = 0;
  std::optional<std::pair<double, double>> range_;
  double seen_low_ = std::numeric_limits<double>::infinity();
  double seen_high_ = -std::numeric_limits<double>::infinity();
};

/// A picture as a rendering calls it.
bool is_picture(const fs::path& file) {
  static const std::regex pattern(R"(\d{5,9}\.png)");
  return std::regex_match(file.filename().string(), pattern);
}

class Rendering {
 public:
  explicit Rendering(const Request& request)
      : request_(request),
        sequence_(io::open_sequence(request.input, io::Uv::material, request.allowed)),
        places_(chosen_frames(sequence_->frames(), request.frames)),
        run_(scene_of_run(request.input, request.allowed)),
        coloring_(request, scene()) {
    if (run_.scene) camera_ = run_.scene->camera;
    if (!request.beside.empty())
      other_ = io::open_sequence(request.beside, io::Uv::material, request.allowed);
    for (std::size_t k = 0; other_ && k < places_.size(); ++k) other_place(places_[k]);
    settle_camera();
  }

  void execute() {
    choose_output();
    std::unique_ptr<Movie> movie = start_movie();
    note_unknown_shapes();
    survey();
    settle_output();
    FrameProgress progress(stdout, places_.size());
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const int number = sequence_->frames()[places_[k]];
      const fs::path file = output_ / fmt::format("{:05}.png", number);
      const io::Image image = picture(places_[k]);
      io::write_png(file, image);
      if (movie) movie->add(image);
      progress.frame(k + 1, file.string());
    }
    progress.end();
    if (movie) movie->finish();
    fmt::print("{} in {}{}\n", counted(places_.size(), "picture"), output_.string(),
               movie ? ", film " + request_.movie : "");
  }

 private:
  const Scene* scene() const { return run_.scene ? &*run_.scene : nullptr; }

  /// Meshes of others need not name the cloths that they hold.
  void note_unknown_shapes() const {
    if (run_.no_shapes.empty()) return;
    const io::FrameMeshes frame = sequence_->read(places_.front());
    if (frame.cloths.size() == 1 && frame.cloths.front().mesh.group_names.empty())
      fmt::print(stderr, "weft: warning: each connected piece is shown as a cloth: {}\n",
                 one_line(run_.no_shapes));
  }

  void settle_camera() {
    if ((request_.camera == "scene" || request_.camera == "outside") && camera_.keys.empty())
      throw SceneError("", "--camera", request_.camera,
                       "auto, as the scene of this run has no camera");
    if (request_.camera == "outside") drawn_ = camera_;
    if (request_.camera == "auto" || request_.camera == "outside") camera_.keys.clear();
    const bool turned = request_.azimuth || request_.elevation;
    if (turned && !camera_.keys.empty())
      throw SceneError("", request_.azimuth ? "--azimuth" : "--elevation", "a scene with a camera",
                       "--camera auto");
    options_.width = camera_.width;
    options_.height = camera_.height;
    if (!request_.size.empty()) {
      static const std::regex pattern(R"((\d{1,5})x(\d{1,5}))");
      std::smatch match;
      if (std::regex_match(request_.size, match, pattern)) {
        options_.width = std::stoi(match[1]);
        options_.height = std::stoi(match[2]);
      }
      if (match.empty() || std::min(options_.width, options_.height) < 1 ||
          std::max(options_.width, options_.height) > 16384)
        throw SceneError("", "--size", request_.size, "WIDTHxHEIGHT, each from 1 to 16384");
    }
    if (request_.samples < 1 || request_.samples > 4096)
      throw SceneError("", "--samples", std::to_string(request_.samples), "1 to 4096");
    if (run_.scene) options_ = io::upright(options_, run_.scene->gravity);
    options_.samples = request_.samples;
    options_.azimuth_degrees = request_.azimuth.value_or(options_.azimuth_degrees);
    options_.elevation_degrees = request_.elevation.value_or(options_.elevation_degrees);
    options_.edges = request_.edges;
    options_.coloured_edges = coloring_.is_of_edges();
  }

  /// @throws SceneError if an earlier rendering is there
  void choose_output() {
    output_ = request_.output;
    if (output_.empty())
      output_ = fs::path(is_folder(request_.input) ? request_.input : "") / "pictures";
    if (request_.overwrite) return;
    if (const std::size_t count = earlier_pictures().size(); count > 0)
      throw SceneError(output_.string(), "-o", "a folder with " + counted(count, "picture"),
                       "a folder without pictures; --overwrite replaces them");
  }

  std::vector<fs::path> earlier_pictures() const {
    std::vector<fs::path> files = files_in(output_);
    std::erase_if(files, [](const fs::path& file) { return !is_picture(file); });
    return files;
  }

  /// Makes the folder, without the pictures of an earlier rendering.
  void settle_output() const {
    make_output_folder(output_);
    for (const fs::path& file : earlier_pictures()) remove_file(file);
  }

  io::FrameMeshes meshes(std::size_t place) const {
    return parted(io::in_world(sequence_->read(place)), scene());
  }

  double time_of(std::size_t place) const {
    return sequence_->frames()[place] / sequence_->frame_rate();
  }

  /// Where the other run has the same frame.
  std::size_t other_place(std::size_t place) const {
    const std::vector<int>& numbers = other_->frames();
    const int number = sequence_->frames()[place];
    const auto found = std::find(numbers.begin(), numbers.end(), number);
    if (found == numbers.end())
      throw SceneError("", "--beside", request_.beside,
                       fmt::format("a run that has the frame {} too", number));
    return static_cast<std::size_t>(found - numbers.begin());
  }

  /// Lines of the scene's camera; where it looks they are as deep as the middle of the cloths.
  std::vector<io::Wire> wires(std::size_t place) const {
    if (!drawn_) return {};
    return frustum_wires(*drawn_, time_of(place), middle_);
  }

  /// Goes through all frames of the run, those that get no picture too: the camera shows a part of
  /// a motion as it would the whole. Colours show the pictures' own values.
  void survey() {
    io::PictureSubject subject;
    for (std::size_t place = 0; place < sequence_->frames().size(); ++place) {
      const io::FrameMeshes frame = meshes(place);
      io::add_to_subject(subject, frame.cloths, frame.obstacles);
      if (std::binary_search(places_.begin(), places_.end(), place)) coloring_.see(frame);
    }
    coloring_.settle();
    middle_ = 0.5 * (subject.low + subject.high);
    std::vector<Vec3<double>> ends;
    for (std::size_t place = 0; drawn_ && place < sequence_->frames().size(); ++place)
      for (const io::Wire& wire : wires(place)) ends.insert(ends.end(), {wire.from, wire.to});
    io::add_points_to_subject(subject, ends);
    options_.subject = std::move(subject);
    if (camera_.keys.empty()) {
      const io::FrameMeshes first = meshes(places_.front());
      options_ = io::frame_camera(first.cloths, first.obstacles, options_);
    }
  }

  io::Image picture(std::size_t place) const {
    io::Image image = picture(place, meshes(place));
    if (other_)
      image = beside(
          image, picture(place, parted(io::in_world(other_->read(other_place(place))), scene())));
    if (coloring_.has_numbers()) io::draw_legend(image, coloring_.legend());
    return image;
  }

  io::Image picture(std::size_t place, const io::FrameMeshes& frame) const {
    io::PictureOptions options = io::with_camera(options_, camera_, time_of(place));
    options.width = options_.width;
    options.height = options_.height;
    options.wires = wires(place);
    if (!coloring_.has_numbers()) return render_picture(frame.cloths, frame.obstacles, options);
    const io::PictureValues values = coloring_.values(frame, time_of(place));
    return render_picture(frame.cloths, frame.obstacles, options, &values);
  }

  int picture_width() const { return other_ ? beside_width(options_.width) : options_.width; }

  std::unique_ptr<Movie> start_movie() {
    if (request_.movie.empty()) return nullptr;
    const std::vector<int>& numbers = sequence_->frames();
    const int step = places_.size() > 1 ? numbers[places_[1]] - numbers[places_[0]] : 1;
    return std::make_unique<Movie>(request_.movie, picture_width(), options_.height,
                                   sequence_->frame_rate() / step);
  }

  const Request& request_;
  std::unique_ptr<io::MeshSequence> sequence_;
  std::unique_ptr<io::MeshSequence> other_;  ///< null: none
  std::vector<std::size_t> places_;
  RunScene run_;
  Coloring coloring_;
  Camera camera_;
  std::optional<Camera> drawn_;   ///< whose frustum is shown
  Vec3<double> middle_{0, 0, 0};  ///< [m] of what the motion shows
  io::PictureOptions options_;
  fs::path output_;
};

void add_looks(CLI::App& subcommand, Request& request) {
  subcommand
      .add_option("--color", request.color,
                  "cloth: a hue a cloth, the back paler. strain: largest principal stretch of a "
                  "triangle less 1, from its material coordinates; the scale ends at the 99.5th "
                  "percentile of the frame with the largest, and compressed triangles count as "
                  "0. height: above z = 0. contact: distance of a vertex to the nearest other "
                  "surface, in units of the scene's contact thickness, up to 2; parts of one "
                  "cloth closer than 3 thicknesses in the material do not count. view: edges by "
                  "what the scene's camera makes of their triangles, the view factor")
      ->type_name("C")
      ->check(CLI::IsMember({"cloth", "strain", "height", "contact", "view"}));
  subcommand
      .add_option("--range", request.range,
                  "Ends of the colour scale (strain as a share, 0.01 for 1 %), instead of those "
                  "found in the frames that are shown")
      ->type_name("LOW:HIGH");
  subcommand
      .add_option("--camera", request.camera,
                  "scene: the scene's camera; auto: one that holds still and sees the whole "
                  "motion; outside: the same, with what the scene's camera sees as lines; default: "
                  "the scene's, if it has one")
      ->type_name("K")
      ->check(CLI::IsMember({"scene", "auto", "outside"}));
  subcommand
      .add_option("--beside", request.beside,
                  "Another run of the scene, such as one by another method, to its right")
      ->type_name("DIR");
  subcommand
      .add_option("--azimuth", request.azimuth, "Of the automatic camera, from +x; default: -60")
      ->type_name("DEGREES")
      ->check(number_range(-360, 360));
  subcommand
      .add_option("--elevation", request.elevation,
                  "Of the automatic camera, above the horizon; default: 22")
      ->type_name("DEGREES")
      ->check(number_range(-85, 85));
  subcommand.add_flag("--edges", request.edges, "Thin lines along the edges of the triangles");
}

}  // namespace

void add_render_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand =
      app.add_subcommand("render", "Make pictures of the frames of a run, and a film");
  auto request = std::make_shared<Request>();
  add_shown_frames(*subcommand, request->input, request->frames);
  subcommand
      ->add_option("-o,--output", request->output,
                   "Directory of the pictures, NNNNN.png; default: DIR/pictures")
      ->type_name("DIR");
  subcommand
      ->add_option("--size", request->size,
                   "Of the pictures [pixels]; default: that of the scene's camera, 960x720")
      ->type_name("WxH");
  subcommand->add_option("--samples", request->samples, "Rays a pixel; default: 16")
      ->type_name("N");
  add_looks(*subcommand, *request);
  subcommand
      ->add_option("--movie", request->movie,
                   "Also make a film (H.264) at the run's frame rate; needs ffmpeg")
      ->type_name("FILE.mp4");
  subcommand->add_flag("--overwrite", request->overwrite,
                       "Replace the pictures of an earlier rendering in the directory");
  add_allow_path(*subcommand, request->allowed);
  subcommand->callback([request, &exit_code] {
    Rendering(*request).execute();
    exit_code = 0;
  });
}

}  // namespace weft::app
