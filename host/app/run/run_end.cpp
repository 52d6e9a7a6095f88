#include "host/app/run/run_end.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <thread>

#include "host/app/process/show.hpp"
#include "host/input/counted.hpp"
#include "host/render/close_up.hpp"
#include "host/render/picture.hpp"
#include "host/render/png_file.hpp"

namespace weft::app {
namespace {

/// Small, so that drawing takes about a second on one core.
io::PictureOptions failure_options() {
  io::PictureOptions options;
  options.width = 800;
  options.height = 600;
  options.samples = 8;
  return options;
}

/// A picture that shows whether the run went well. `weft render` makes better ones.
io::PictureOptions preview_options(const Scene& scene, double time) {
  io::PictureOptions options = io::with_camera(io::upright({}, scene.gravity), scene.camera, time);
  constexpr double longest_side = 480;
  const double shrink = std::min(1.0, longest_side / std::max(options.width, options.height));
  options.width = std::max(1, static_cast<int>(std::lround(shrink * options.width)));
  options.height = std::max(1, static_cast<int>(std::lround(shrink * options.height)));
  options.samples = 3;
  return options;
}

}  // namespace

bool draws_preview(const RunRequest& request) {
  return request.preview.value_or(::isatty(STDOUT_FILENO) != 0 && ::isatty(STDERR_FILENO) != 0);
}

lab::DisplacedVerdict validate_frame(const FrameMeshes& meshes, bool sewn, bool self) {
  lab::ValidatorOptions options;
  options.sewn = sewn;
  options.self = self;
  options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const Mesh obstacle = io::joined(meshes.obstacles);
  const Mesh displaced = io::joined(meshes.displaced);
  Mesh cloth = io::joined(meshes.cloths);
  cloth.material.clear();  // nobody asks this verdict for inversions
  cloth.material_triangles.clear();
  return lab::validate(cloth, meshes.obstacles.empty() ? nullptr : &obstacle,
                       meshes.displaced.empty() ? nullptr : &displaced, options);
}

void warn_of_intersections(const lab::DisplacedVerdict& verdict, const RunDirectory& directory) {
  if (verdict.intersections() == 0) return;
  show(stderr, "weft: warning: the last frame has {}; weft check {} names them\n",
       counted(verdict.intersections(), "intersection"), directory.path().string());
}

bool write_preview(const RunDirectory& directory, const Scene& scene, const FrameMeshes& meshes,
                   double time) {
  try {
    const auto options = preview_options(scene, time);
    io::write_png(directory.preview(),
                  io::render_picture(meshes.cloths, meshes.obstacles, options));
    return true;
  } catch (const std::exception& error) {
    show(stderr, "weft: warning: no preview: {}\n", error.what());
    return false;
  }
}

bool write_failure_picture(const RunDirectory& directory, const FrameMeshes& meshes,
                           const std::optional<Vec3<double>>& place) {
  if (!place) return false;
  try {
    const auto& obstacles = meshes.displaced.empty() ? meshes.obstacles : meshes.displaced;
    const io::CloseUp view = io::close_up(meshes.cloths, obstacles, *place, failure_options());
    io::write_png(directory.failure(),
                  io::render_picture(view.cloths, view.obstacles, view.options));
    return true;
  } catch (const std::exception& error) {
    show(stderr, "weft: warning: no picture of the failure: {}\n", error.what());
    return false;
  }
}

}  // namespace weft::app
