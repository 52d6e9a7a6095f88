#pragma once

#include <vector>

#include "weft/scene.hpp"

// Numbers behind MembraneSamples and MembraneRidges, made from measured tables.

namespace weft {

/// Coefficients over strain exactly as ARCSim evaluates the tables. For each strain G, with the
/// larger eigenvalue of 2 G + I, its root w and the angle of its eigenvector to the warp (0 where
/// the eigenvalues are equal): the last five rows, interpolated in the angle folded to [0, 90]
/// degrees, are blended with the first by clamp(6 (w - 1), 0, 1); negative numbers become 0; all is
/// doubled.
/// @return [MembraneSamples::value_count] [N/m]
/// @cite wang2011
std::vector<double> sample_measured(const MeasuredStretch& measured);

/// An energy fitted to the tables.
struct MeasuredFit {
  std::vector<double> values;  ///< [MembraneRidges::value_count]
  /// Root mean square, over the strains of the fit, of the error of the stress over that of the
  /// stress itself, both per strain.
  double error = 0;
};

/// Convex energy whose stress is nearest to that of sample_measured(), in the least-squares sense,
/// over stretches of 0.85 to 1.35 in all directions. Strains count by their inverse length, so that
/// small ones, in which cloth spends its time, are met as well as large ones.
MeasuredFit fit_measured(const MeasuredStretch& measured);

/// The numbers that a material's law of stretching reads; empty if it has no table.
std::vector<double> stretch_table(const Material& material);

}  // namespace weft
