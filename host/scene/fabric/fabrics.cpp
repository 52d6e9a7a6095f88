#include "host/scene/fabric/fabrics.hpp"

#include <algorithm>

namespace weft {
namespace {

/// A fabric that Wang, O'Brien and Ramamoorthi 2011 measured.
Fabric wang(const char* name, const char* description, double density,
            const OrthotropicStretch& stretch, const OrthotropicBending& bending) {
  Fabric fabric{name, description, "Wang, O'Brien and Ramamoorthi 2011", {}, false};
  fabric.material.density = density;
  fabric.material.orthotropic = stretch;
  fabric.material.orthotropic_bending = bending;
  return fabric;
}

/// A fabric with numbers that make it behave like its kind.
Fabric estimate(const char* name, const char* description, const char* reasoning, double density,
                const OrthotropicStretch& stretch, const OrthotropicBending& bending) {
  Fabric fabric{name, description, reasoning, {}, true};
  fabric.material.density = density;
  fabric.material.orthotropic = stretch;
  fabric.material.orthotropic_bending = bending;
  return fabric;
}

/// The measurements are tables of stress over strain, and of bending moment over curvature, which
/// belong to the program ARCSim. These numbers are those of the linear sheet that is as stiff as
/// the tables are halfway between small strain and a stretch of 1/6, that is at 1/12, and at small
/// curvature. In ARCSim's terms, with row 0 of "stretching" at small strain and rows 1, 3 and 5
/// at 0, 45 and 90 degrees from the warp, all doubled as ARCSim doubles them:
///   c11 = row 0 + row 1,  c22 = row 0 + row 5,  c33 = row 0 + row 3,
///   c12 = row 0 + (row 1 + row 5) / 2
///   warp = c11 - c12^2 / c22,  weft = c22 - c12^2 / c11,  nu = c12 / c22,  shear = c33 / 2
/// and with the first column b of "bending" as read_arcsim_material() takes it:
///   D11 = b2 / 4,  D22 = b0 / 4,  D12 = 0,  D66 = b1 / 4 - (D11 + D22) / 4
/// Three digits; tests/unit/io/fabrics.cpp compares them with the tables. Above each line stands
/// what the authors call the fabric. Density is theirs.
///
/// Estimates follow from a weight and a bending length c that are usual for the kind: the bending
/// stiffness is density * 9.81 m/s^2 * c^3 (Peirce's cantilever). scenes/README.md has the same
/// reasoning for users.
/// @cite wang2011
std::vector<Fabric> make_fabrics() {
  return {
      // pink-ribbon-brown
      wang("blanket", "blanket: polyester", 0.228, {278, 533, 0.248, 79.9},
           {1.49e-05, 2.93e-05, 0, 1.08e-05}),
      // A shirting. Threads carry in proportion to their weight: stretching and shear are those of
      // cotton_polyester times 0.15 / 0.22. c = 20 mm gives a drape coefficient of 68 %, the middle
      // of the 60 to 76 % that are published for cottons (docs/validation.md).
      estimate(
          "cotton", "shirt: cotton, plain weave",
          "estimate: drapes at 68 %, published for cottons are 60 to 76 %, bending length 20 mm; "
          "stretching is cotton_polyester scaled to the weight",
          0.15, {2820, 2860, 0.0144, 77}, {1.18e-05, 1.18e-05, 0, 4.2e-06}),
      // royal-target
      wang("cotton_polyester", "trousers: 65 % cotton, 35 % polyester", 0.22,
           {4130, 4190, 0.0144, 113}, {3.14e-05, 3.14e-05, 0, 1.13e-05}),
      // 11oz-black-denim
      wang("denim", "jeans: 99 % cotton, 1 % spandex", 0.324, {436, 2060, 0.0247, 68.7},
           {2.42e-05, 1.6e-05, 0, 8.27e-06}),
      // gray-interlock
      wang("interlock", "t-shirt: 60 % cotton, 40 % polyester", 0.187, {56.1, 392, 0.125, 40.5},
           {3.57e-06, 5.8e-06, 0, 3.85e-06}),
      // The nearest fabric that was measured is an interlock, which is a double jersey.
      wang("jersey", "t-shirt: jersey, with the numbers of interlock", 0.187,
           {56.1, 392, 0.125, 40.5}, {3.57e-06, 5.8e-06, 0, 3.85e-06}),
      // Sheep nappa of 0.8 mm, isotropic. Memon et al. 2021 (doi 10.3390/ma14164553) measured drape
      // coefficients of 47 to 70 % on such leathers of 0.64 to 0.96 mm; c = 17.5 mm gives 58 %.
      // 20 MPa of Young's modulus at small strain.
      estimate("leather", "jacket: sheep leather of 0.8 mm",
               "estimate: drapes at 58 %, the middle of the sheep leathers of Memon et al. 2021; "
               "bending length 17.5 mm, Young's modulus 20 MPa",
               0.55, {16000, 16000, 0.3, 6150}, {2.9e-05, 2.9e-05, 8.7e-06, 1.01e-05}),
      // tango-red-jet-set
      wang("light_jacket", "jacket: polyester", 0.113, {106, 516, 0.147, 27.9},
           {5.09e-06, 3.57e-06, 0, 3.32e-06}),
      // Copy paper of 80 g/m^2 and 0.1 mm, as a homogeneous plate of 3 GPa.
      estimate("paper", "copy paper of 80 g/m^2",
               "estimate: homogeneous plate of 0.1 mm with a Young's modulus of 3 GPa", 0.08,
               {300000, 300000, 0.3, 115000}, {0.000275, 0.000275, 8.24e-05, 9.62e-05}),
      // white-dots-on-blk
      wang("polyester", "tablecloth: polyester", 0.128, {4110, 4180, 0.0118, 60.3},
           {7.82e-06, 1.29e-05, 0, 4.98e-06}),
      // camel-ponte-roma
      wang("ponte_roma", "jacket: 60 % polyester, 40 % rayon", 0.284, {107, 230, 0.108, 38.3},
           {9.29e-06, 9.09e-06, 0, 3.66e-06}),
      // ivory-rib-knit
      wang("rib_knit", "underwear: 95 % cotton, 5 % spandex", 0.276, {95.3, 320, 0.0112, 55.4},
           {8.06e-06, 1.16e-05, 0, 2.6e-06}),
      // Crepe de chine. c = 12 mm gives a drape coefficient of 31 %, where 20 to 40 % are published
      // for silks (docs/validation.md). Stretching and shear: cotton_polyester scaled to the
      // weight.
      estimate(
          "silk", "blouse: crepe de chine",
          "estimate: drapes at 31 %, published for silks are 20 to 40 %, bending length 12 mm; "
          "stretching is cotton_polyester scaled to the weight",
          0.075, {1410, 1430, 0.0144, 38}, {1.27e-06, 1.27e-06, 0, 6.35e-07}),
      // navy-sparkle-sweat
      wang("sweatshirt", "sweater: 96 % polyester, 4 % spandex", 0.224, {26.5, 146, 0.271, 11.9},
           {1.14e-05, 1.49e-05, 0, 3.45e-06}),
      // white-swim-solid
      wang("swimwear", "swimsuit: 87 % nylon, 13 % spandex", 0.204, {81.9, 212, 0.168, 48.4},
           {1.28e-05, 1.51e-05, 0, 7.75e-06}),
      // A light worsted in plain weave. The numbers are of the size that one FAST test report has,
      // which circulates without author or journal: 168 g/m^2; bending 5.6 and 5.0 uN m; 0.7, 1.9,
      // 4.6 % along the warp and 0.4, 1.9, 5.9 % along the weft at 4.9, 19.6 and 98.1 N/m, of which
      // the first two give the stretching; shear 26 N/m.
      estimate("wool", "suit: light worsted, plain weave",
               "estimate: of the size that an unpublished FAST test of a worsted has", 0.17,
               {1220, 1000, 0.02, 26}, {5.6e-06, 5e-06, 0, 2.65e-06}),
  };
}

}  // namespace

const std::vector<Fabric>& fabrics() {
  static const std::vector<Fabric> all = make_fabrics();
  return all;
}

const Fabric* find_fabric(const std::string& name) {
  const auto& all = fabrics();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Fabric& f) { return name == f.name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace weft
