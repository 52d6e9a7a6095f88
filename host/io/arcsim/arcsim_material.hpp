#pragma once

#include <filesystem>
#include <string>

#include "weft/scene.hpp"

namespace weft::io {

/// What a cloth's entry in "materials" says beside the name of the file.
struct ArcsimFactors {
  double density = 1;     ///< density_mult
  double stretching = 1;  ///< stretching_mult
  double bending = 1;     ///< bending_mult
  double thicken = 1;     ///< multiplies all three
  double damping = 0;     ///< [s] stiffness-proportional
};

/// A material file of ARCSim: tables after Wang, O'Brien and Ramamoorthi 2011. Those of stretching,
/// times stretching and thicken, become Material::measured, evaluated as ARCSim does, unless they
/// are those of an isotropic sheet. The other numbers are of the isotropic sheet that is closest at
/// small strain. With c = (c11 + c22) / 2 and c12 from the first row of "stretching":
///   nu = c12 / c, held within [-0.9, 0.49]
///   stretch stiffness = 2 c (1 - nu^2) stretching thicken
/// where the 2 is the doubling with which ARCSim evaluates its tables. The rows of "bending" are of
/// hinges along 0, 45 and 90 degrees from the warp, their first columns at small curvature; a hinge
/// bends the sheet across itself. With b the first column,
///   bending stiffness along the weft, halfway and along the warp = b / 4 bending thicken
/// since ARCSim gives a hinge the energy b l^2 theta^2 / (8 (A1 + A2)), and weft the bending
/// stiffness B the energy B l^2 theta^2 / (2 (A1 + A2)). Where the three are not one number they
/// become Material::orthotropic_bending, see directional_bending(); bending_stiffness is their
/// mean. Where Material::measured holds the stretching, Poisson's ratio is 0: it is of bending
/// alone then, and the table of bending couples nothing.
/// @param averaged out, set to whether the table of bending depends on the curvature, which is left
///                 out
/// @throws SceneError naming file and key
Material read_arcsim_material(const std::filesystem::path& path, const ArcsimFactors& factors,
                              bool& averaged);

}  // namespace weft::io
