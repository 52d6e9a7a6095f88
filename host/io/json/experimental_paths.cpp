#include "host/io/json/experimental_paths.hpp"

#include <algorithm>
#include <iterator>

namespace weft::io {
namespace {

constexpr const char* paths[] = {
    "bending",
    "contact.self_certificate",
    "contact.substep_bisections",
    "contact.zone_rounds",
    "jitter.seed",
    "method.asynchronous.layers",
    "method.asynchronous.narrow",
    "method.asynchronous.optimistic",
    "method.asynchronous.restitution",
    "method.asynchronous.rollbacks",
    "method.asynchronous.smallest_step",
    "method.asynchronous.stiffness",
    "method.asynchronous.window",
    "method.implicit.sleep_window",
    "method.time_parallel.blend_frames",
    "method.time_parallel.boundary_tolerance",
    "method.time_parallel.coarse_integrator",
    "method.time_parallel.coarse_mesh",
    "method.time_parallel.coarse_newton_iterations",
    "method.time_parallel.coarse_newton_tolerance",
    "method.time_parallel.coarse_step",
    "method.time_parallel.coarse_thickness",
    "method.time_parallel.coarse_tolerance",
    "method.time_parallel.coarsening",
    "method.time_parallel.partition",
    "method.time_parallel.ratio",
    "method.time_parallel.recovery.factor",
    "method.time_parallel.recovery.iterations",
    "method.time_parallel.recovery.tolerance",
    "method.view.anticipation",
    "method.view.compensation",
    "method.view.compensation_power",
    "method.view.factor_back",
    "method.view.margin",
    "method.view.pixel_min",
    "method.view.predict_obstacles",
    "method.view.transfer_threshold",
    "remeshing.aspect_min",
    "remeshing.energy_share",
    "remeshing.flip_threshold",
    "solver.line_search",
    "solver.max_iterations",
    "solver.newton_tolerance",
    "solver.partial_rows",
    "solver.preconditioner",
    "solver.rebalance",
    "solver.transport",
};

}  // namespace

std::span<const char* const> experimental_paths() {
  return paths;
}

bool is_experimental(std::string_view path) {
  return path == stiffness_path ||
         std::find(std::begin(paths), std::end(paths), path) != std::end(paths);
}

bool is_hidden(std::string_view path) {
  return is_experimental(path) || path == "method.asynchronous" ||
         path == "method.time_parallel.recovery";
}

}  // namespace weft::io
