#include <algorithm>

#include "host/input/safe_text.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/scene/fabric/fabrics.hpp"
#include "host/scene/fabric/rigidity.hpp"

namespace weft::io {
namespace {

/// Refuses those of `keys` that stand beside `key`, which says the same in another way.
void refuse_beside(const Fields& fields, const std::string& key,
                   const std::vector<std::string>& keys) {
  for (const std::string& other : keys)
    if (fields.has(other)) fields.refuse(other, "a value that stands alone, without " + key);
}

MeasuredStretch read_measured(Fields& fields) {
  Fields measured = fields.object("measured", {"form", "stretching"});
  MeasuredStretch result;
  result.form = measured.choice("form", {"wang", "wang_arcsim"}, 0) == 0
                    ? MeasuredStretch::Form::energy
                    : MeasuredStretch::Form::arcsim;
  const auto rows = measured.number_lists("stretching", 4, 4);
  if (rows.size() != result.rows.size())
    measured.refuse("stretching", "6 rows of 4 numbers: c11, c12, c22, c33");
  for (std::size_t i = 0; i < rows.size(); ++i)
    std::copy(rows[i].begin(), rows[i].end(), result.rows[i].begin());
  return result;
}

/// Writes down what a fabric says and no key of its own replaces.
void record_fabric(Fields& fields, const Material& material) {
  if (const auto& s = material.orthotropic; s && !fields.has("orthotropic"))
    fields.record("orthotropic", {{"stretch_stiffness", {s->warp, s->weft}},
                                  {"poisson_ratio", s->poisson_ratio},
                                  {"shear_stiffness", s->shear}});
  if (const auto& b = material.orthotropic_bending; b && !fields.has("orthotropic_bending"))
    fields.record(
        "orthotropic_bending",
        {{"stiffness", {b->warp, b->weft}}, {"coupling", b->coupling}, {"twist", b->twist}});
}

void read_stretch(Fields& fields, Material& material) {
  if (fields.has("measured")) {
    refuse_beside(fields, "measured", {"stretch_stiffness", "orthotropic"});
    material.orthotropic.reset();
    material.measured = read_measured(fields);
    return;
  }
  if (material.orthotropic && !fields.has("orthotropic") && !fields.has("stretch_stiffness"))
    return;  // of a fabric
  if (!fields.has("orthotropic")) {
    material.orthotropic.reset();
    material.stretch_stiffness = fields.number("stretch_stiffness", material.stretch_stiffness);
    return;
  }
  refuse_beside(fields, "orthotropic", {"stretch_stiffness"});
  Fields threads =
      fields.object("orthotropic", {"stretch_stiffness", "poisson_ratio", "shear_stiffness"});
  const auto stiffness = threads.vector<2>("stretch_stiffness");
  const double ratio = threads.number("poisson_ratio", 0);
  material.orthotropic = {stiffness[0], stiffness[1], ratio, threads.number("shear_stiffness")};
}

void read_bending(Fields& fields, Material& material) {
  if (material.orthotropic_bending && !fields.has("orthotropic_bending") &&
      !fields.has("bending_stiffness"))
    return;  // of a fabric
  if (!fields.has("orthotropic_bending")) {
    material.orthotropic_bending.reset();
    material.bending_stiffness = fields.number("bending_stiffness", material.bending_stiffness);
    return;
  }
  refuse_beside(fields, "orthotropic_bending", {"bending_stiffness"});
  Fields threads = fields.object("orthotropic_bending", {"stiffness", "coupling", "twist"});
  const auto stiffness = threads.vector<2>("stiffness", quantity::bending);
  OrthotropicBending bending = huber_bending(
      stiffness[0], stiffness[1],
      material.orthotropic ? material.orthotropic->poisson_ratio : material.poisson_ratio);
  bending.coupling = threads.number("coupling", bending.coupling);
  bending.twist = threads.number("twist", bending.twist);
  material.orthotropic_bending = bending;
}

/// What the keys of a material start from.
Material read_fabric(Fields& fields) {
  if (!fields.has("fabric")) return {};
  std::vector<std::string> names;
  for (const Fabric& fabric : fabrics()) names.push_back(fabric.name);
  return fabrics()[fields.choice("fabric", names, {})].material;
}

Material read_material(Fields& list, const std::string& name) {
  Fields fields = list.object(
      name, {"fabric", "density", "stretch_stiffness", "poisson_ratio", "bending_stiffness",
             "orthotropic", "orthotropic_bending", "measured", "damping", "strain_limits"});
  Material material = read_fabric(fields);
  material.name = name;
  material.density = fields.number("density", material.density);
  material.poisson_ratio =
      fields.number("poisson_ratio", quantity::poisson_ratio, material.poisson_ratio);
  read_stretch(fields, material);
  read_bending(fields, material);
  record_fabric(fields, material);
  if (fields.has("strain_limits")) {
    const auto limits = fields.vector<2>("strain_limits");
    material.strain_limits = StrainLimits{limits[0], limits[1]};
  }
  Fields damping = fields.object("damping", {"mass", "stiffness"});
  material.damping_mass = damping.number("mass", material.damping_mass);
  material.damping_stiffness = damping.number("stiffness", material.damping_stiffness);
  return material;
}

}  // namespace

std::vector<Material> read_materials(Fields& root) {
  std::vector<Material> materials;
  Fields list = root.object("materials", {});
  for (const std::string& name : list.present_keys()) {
    if (std::any_of(name.begin(), name.end(), is_control))
      list.refuse(name, "a name with control characters", "names that can be printed");
    materials.push_back(read_material(list, name));
  }
  return materials;
}

}  // namespace weft::io
