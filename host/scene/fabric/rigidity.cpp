#include "host/scene/fabric/rigidity.hpp"

#include <algorithm>
#include <cmath>

namespace weft {

OrthotropicBending huber_bending(double warp, double weft, double poisson_ratio) {
  const double coupling = poisson_ratio * weft;
  return {warp, weft, coupling, (std::sqrt(warp * weft) - coupling) / 2};
}

OrthotropicBending directional_bending(double warp, double weft, double halfway) {
  const double twist = halfway - (warp + weft) / 4;
  if (twist >= 0) return {warp, weft, 0, twist};
  return {warp, weft, std::max(2 * twist, -std::sqrt(warp * weft)), 0};
}

Mat3<double> bending_rigidity(const Material& material) {
  if (material.orthotropic_bending) {
    const OrthotropicBending& d = *material.orthotropic_bending;
    return {{d.warp, d.coupling, 0, d.coupling, d.weft, 0, 0, 0, 4 * d.twist}};
  }
  const double b = material.bending_stiffness;
  const double nu = material.poisson_ratio;
  return {{b, nu * b, 0, nu * b, b, 0, 0, 0, 2 * (1 - nu) * b}};
}

double mean_bending_stiffness(const Material& material) {
  if (!material.orthotropic_bending) return material.bending_stiffness;
  const OrthotropicBending& d = *material.orthotropic_bending;
  return 0.375 * (d.warp + d.weft) + (d.coupling + 2 * d.twist) / 4;
}

}  // namespace weft
