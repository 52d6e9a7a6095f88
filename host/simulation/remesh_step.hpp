#pragma once

#include <memory>

#include "host/simulation/remeshing.hpp"
#include "host/simulation/run.hpp"
#include "weft/report.hpp"

namespace weft {

/// Remeshes the cloths of a scene to what their state asks for, and replaces the run by one on the
/// new meshes. If that changes the energy too much, it is tried once more with less, and else left
/// for later.
/// @param scene,adaptive change with the run
template <class T>
RemeshReport remesh_step(Scene& scene, const Sewing& sewing, AdaptiveRun& adaptive,
                         DeviceSet& devices, std::unique_ptr<Run<T>>& run);

}  // namespace weft
