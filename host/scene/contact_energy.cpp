#include "host/scene/contact_energy.hpp"

#include <cstddef>
#include <vector>

#include "host/scene/fabric/material_areas.hpp"

namespace weft {

double energy_of_contacts(const Scene& scene, double step) {
  const std::vector<MaterialAreas> areas = areas_by_material(scene);
  double mass = 0;
  for (std::size_t m = 0; m < areas.size(); ++m) mass += areas[m].sum * scene.materials[m].density;
  const double thickness = contact_thickness(scene.contact);
  const double speed = thickness / step;
  return mass * (length(scene.gravity) * thickness + speed * speed);
}

}  // namespace weft
