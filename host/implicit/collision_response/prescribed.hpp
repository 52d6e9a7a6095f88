#pragma once

#include <string>
#include <vector>

#include "host/state/store.hpp"

namespace weft {

/// The obstacles and pinned cloths of prescribed vertices, each once, on one line.
std::string prescribed_names(const Scene& scene, const Model& model,
                             const std::vector<Index>& vertices);

}  // namespace weft
