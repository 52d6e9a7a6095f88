#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/state/store.hpp"

namespace weft {

/// [m] by which the scene lets prescribed vertex v give way; empty: it does not say.
std::optional<double> declared_compliance(const Scene& scene, const Model& model, Index v);

/// The obstacles and pinned cloths of prescribed vertices, each once, on one line.
std::string prescribed_names(const Scene& scene, const Model& model,
                             const std::vector<Index>& vertices);

}  // namespace weft
