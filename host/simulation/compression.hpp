#pragma once

#include <vector>

#include "host/model/model.hpp"

namespace weft {

/// What the triangles of a remeshed cloth see of a compression until it is decided: as much as
/// before where a triangle has stayed, and where it is new, the least of those around its corners.
/// @param shares       [cloth triangles] as the scene before numbers them; empty: 1
/// @param input_before [inputs] number before the remesh; -1: a new vertex
/// @return [cloth triangles] as the scene now numbers them; empty: 1
std::vector<double> carried_compression(const Model& from, const std::vector<double>& shares,
                                        const std::vector<Index>& input_before, const Model& to);

/// Shares of compression between those before and those wanted, such that elastic energy grows by
/// little: of `joules`, each triangle that would gain any may gain what its share of their area is.
/// @param before, wanted [cloth triangles] as the scene numbers them; empty: 1
/// @param positions [m] [vertices] as the model numbers them
std::vector<double> limited_compression(const Model& model,
                                        const std::vector<Vec3<double>>& positions,
                                        const std::vector<double>& before,
                                        const std::vector<double>& wanted, double joules);

}  // namespace weft
