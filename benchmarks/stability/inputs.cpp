// One NaN in every number and array of a scene in turn.
#include <fmt/format.h>

#include <functional>
#include <limits>
#include <memory>
#include <utility>

#include "benchmarks/stability/run.hpp"
#include "weft/error.hpp"

namespace weft::stability {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A number of the scene, and where it is.
struct Field {
  std::string name;
  std::function<double&(Scene&)> of;
};

std::vector<Field> mesh_fields() {
  return {
      {"cloth positions", [](Scene& s) -> double& { return s.cloths[0].mesh.positions[30][1]; }},
      {"cloth material coordinates",
       [](Scene& s) -> double& { return s.cloths[0].mesh.material[30][1]; }},
      {"cloth rest positions",
       [](Scene& s) -> double& { return s.cloths[2].rest_positions[3][1]; }},
      {"obstacle positions",
       [](Scene& s) -> double& { return s.obstacles[0].mesh.positions[3][1]; }},
  };
}

std::vector<Field> part_fields() {
  return {
      {"cloth pressure", [](Scene& s) -> double& { return s.cloths[0].pressure; }},
      {"cloth velocity", [](Scene& s) -> double& { return s.cloths[0].velocity[1]; }},
      {"cloth angular velocity",
       [](Scene& s) -> double& { return s.cloths[0].angular_velocity[1]; }},
      {"cloth velocity origin", [](Scene& s) -> double& { return s.cloths[0].velocity_origin[1]; }},
      {"obstacle translation",
       [](Scene& s) -> double& { return s.obstacles[0].transform.translate[1]; }},
      {"obstacle axis",
       [](Scene& s) -> double& { return s.obstacles[0].transform.rotation_axis[1]; }},
      {"obstacle angle",
       [](Scene& s) -> double& { return s.obstacles[0].transform.rotation_angle; }},
      {"obstacle scale", [](Scene& s) -> double& { return s.obstacles[0].transform.scale; }},
      {"obstacle friction", [](Scene& s) -> double& { return s.obstacles[0].friction; }},
      {"pin motion time", [](Scene& s) -> double& { return s.pins[0].motion[1].time; }},
      {"pin motion translation",
       [](Scene& s) -> double& { return s.pins[0].motion[1].transform.translate[1]; }},
      {"pin release time", [](Scene& s) -> double& { return s.pins[0].release_time; }},
      {"handle motion", [](Scene& s) -> double& { return s.handles[0].motion[1].transform.scale; }},
      {"handle stiffness", [](Scene& s) -> double& { return s.handles[0].stiffness; }},
      {"handle start", [](Scene& s) -> double& { return s.handles[0].start_time; }},
      {"handle end", [](Scene& s) -> double& { return s.handles[0].end_time; }},
      {"handle fade", [](Scene& s) -> double& { return s.handles[0].fade_time; }},
      {"circle circumference", [](Scene& s) -> double& { return s.handles[1].circumference; }},
      {"circle direction", [](Scene& s) -> double& { return s.handles[1].direction[1]; }},
      {"circle centre", [](Scene& s) -> double& { return s.handles[1].center[1]; }},
      {"circle axis", [](Scene& s) -> double& { return s.handles[1].axis1[1]; }},
      {"seam stiffness", [](Scene& s) -> double& { return s.seams[0].stiffness.emplace(); }},
      {"seam start", [](Scene& s) -> double& { return s.seams[0].start_time; }},
      {"seam ramp", [](Scene& s) -> double& { return s.seams[0].ramp_time; }},
      {"seam weld distance",
       [](Scene& s) -> double& { return s.seams[0].weld_distance.emplace(); }},
  };
}

std::vector<Field> material_fields() {
  return {
      {"density", [](Scene& s) -> double& { return s.materials[0].density; }},
      {"stretch stiffness", [](Scene& s) -> double& { return s.materials[0].stretch_stiffness; }},
      {"Poisson's ratio", [](Scene& s) -> double& { return s.materials[0].poisson_ratio; }},
      {"bending stiffness", [](Scene& s) -> double& { return s.materials[0].bending_stiffness; }},
      {"damping by mass", [](Scene& s) -> double& { return s.materials[0].damping_mass; }},
      {"damping by stiffness",
       [](Scene& s) -> double& { return s.materials[0].damping_stiffness; }},
      {"warp", [](Scene& s) -> double& { return s.materials[1].orthotropic->warp; }},
      {"weft", [](Scene& s) -> double& { return s.materials[1].orthotropic->weft; }},
      {"orthotropic Poisson's ratio",
       [](Scene& s) -> double& { return s.materials[1].orthotropic->poisson_ratio; }},
      {"shear", [](Scene& s) -> double& { return s.materials[1].orthotropic->shear; }},
      {"bending warp",
       [](Scene& s) -> double& { return s.materials[1].orthotropic_bending->warp; }},
      {"bending weft",
       [](Scene& s) -> double& { return s.materials[1].orthotropic_bending->weft; }},
      {"bending coupling",
       [](Scene& s) -> double& { return s.materials[1].orthotropic_bending->coupling; }},
      {"bending twist",
       [](Scene& s) -> double& { return s.materials[1].orthotropic_bending->twist; }},
      {"measured table", [](Scene& s) -> double& { return s.materials[2].measured->rows[3][1]; }},
      {"strain limit below", [](Scene& s) -> double& { return s.materials[2].strain_limits->min; }},
      {"strain limit above", [](Scene& s) -> double& { return s.materials[2].strain_limits->max; }},
  };
}

std::vector<Field> setting_fields() {
  return {
      {"gravity", [](Scene& s) -> double& { return s.gravity[1]; }},
      {"time step", [](Scene& s) -> double& { return s.time.step; }},
      {"frame rate", [](Scene& s) -> double& { return s.time.frame_rate; }},
      {"wind density", [](Scene& s) -> double& { return s.wind.density; }},
      {"wind velocity", [](Scene& s) -> double& { return s.wind.velocity[1]; }},
      {"wind drag", [](Scene& s) -> double& { return s.wind.drag; }},
      {"contact thickness", [](Scene& s) -> double& { return s.contact.thickness.emplace(); }},
      {"contact friction", [](Scene& s) -> double& { return s.contact.friction; }},
      {"contact stiffness", [](Scene& s) -> double& { return s.contact.stiffness; }},
      {"compliance distance",
       [](Scene& s) -> double& { return s.contact.compliance_distance.emplace(); }},
      {"solver tolerance", [](Scene& s) -> double& { return s.solver.tolerance; }},
      {"Newton tolerance", [](Scene& s) -> double& { return s.solver.newton_tolerance; }},
      {"camera time", [](Scene& s) -> double& { return s.camera.keys[0].time; }},
      {"camera position", [](Scene& s) -> double& { return s.camera.keys[0].position[1]; }},
      {"camera view", [](Scene& s) -> double& { return s.camera.keys[0].field_of_view; }},
      {"remeshing size", [](Scene& s) -> double& { return s.adaptive.remeshing.size_min; }},
      {"remeshing angle", [](Scene& s) -> double& { return s.adaptive.remeshing.refine_angle; }},
      {"remeshing compression",
       [](Scene& s) -> double& { return s.adaptive.remeshing.refine_compression; }},
      {"remeshing velocity",
       [](Scene& s) -> double& { return s.adaptive.remeshing.refine_velocity; }},
      {"remeshing aspect", [](Scene& s) -> double& { return s.adaptive.remeshing.aspect_min; }},
      {"flip threshold", [](Scene& s) -> double& { return s.adaptive.flip_threshold; }},
      {"energy share", [](Scene& s) -> double& { return s.adaptive.energy_share; }},
      {"factor of backs", [](Scene& s) -> double& { return s.view.factor_back; }},
      {"factor out of view", [](Scene& s) -> double& { return s.view.factor_out; }},
      {"margin of the view", [](Scene& s) -> double& { return s.view.margin; }},
      {"anticipation", [](Scene& s) -> double& { return s.view.anticipation; }},
      {"transfer threshold", [](Scene& s) -> double& { return s.view.transfer_threshold; }},
      {"smallest edge in pixels", [](Scene& s) -> double& { return s.view.pixel_min; }},
      {"power of compensation", [](Scene& s) -> double& { return s.view.compensation_power; }},
      {"ratio of costs", [](Scene& s) -> double& { return s.time_parallel.ratio; }},
      {"coarsening", [](Scene& s) -> double& { return s.time_parallel.coarsening; }},
      {"coarse step", [](Scene& s) -> double& { return s.time_parallel.coarse_step; }},
      {"recovery factor", [](Scene& s) -> double& { return s.time_parallel.recovery_factor; }},
      {"recovery tolerance",
       [](Scene& s) -> double& { return s.time_parallel.recovery_tolerance; }},
      {"tolerance of seams",
       [](Scene& s) -> double& { return s.time_parallel.boundary_tolerance; }},
      {"window", [](Scene& s) -> double& { return s.asynchronous.window; }},
      {"layer stiffness", [](Scene& s) -> double& { return s.asynchronous.stiffness; }},
      {"restitution", [](Scene& s) -> double& { return s.asynchronous.restitution; }},
      {"smallest step", [](Scene& s) -> double& { return s.asynchronous.smallest_step; }},
  };
}

/// A scene in which all is given that the method takes.
Scene everything(const Setup& setup) {
  Scene scene = sheet_on_sphere(setup, 0.005);
  const bool all = setup.method != "asynchronous";
  scene.materials.resize(3, scene.materials[0]);
  scene.materials[1].orthotropic = OrthotropicStretch{};
  scene.materials[1].orthotropic_bending = OrthotropicBending{};
  if (all) scene.materials[2].measured.emplace().rows.fill({10, 2, 5, 4});
  if (all) scene.materials[2].strain_limits = StrainLimits{0.8, 1.2};
  for (std::size_t m = 0; m < 3; ++m) scene.materials[m].name = fmt::format("material {}", m);
  scene.cloths.push_back(square(4, 0.3));
  scene.cloths.push_back(square(4, 0.5));
  for (std::size_t c = 0; c < 3; ++c) scene.cloths[c].name = fmt::format("sheet {}", c);
  if (setup.method == "implicit") scene.cloths[2].rest_positions = scene.cloths[2].mesh.positions;
  Transform there;
  there.translate = {0, 0, 0.1};
  const Motion motion{{0, {}}, {1, there}};
  scene.pins.push_back({0, {0, 1}, motion, -1, 1e9});
  if (!all) return scene;
  scene.handles.resize(2);
  scene.handles[0].vertices = {5};
  scene.handles[0].motion = motion;
  scene.handles[0].end_time = 2;
  scene.handles[1].shape = Handle::Shape::circle;
  scene.handles[1].vertices = {7, 8};
  scene.handles[1].circumference = 0.3;
  scene.wind.density = 1.2;
  if (setup.method == "time_parallel") return scene;
  Seam seam;
  seam.cloths[1] = 1;
  seam.vertices[0] = {100};
  seam.vertices[1] = {0};
  scene.seams.push_back(seam);
  return scene;
}

/// Whether everything() of the method has the field.
bool is_there(const Setup& setup, const Field& field) {
  if (setup.method != "implicit" && field.name == "cloth rest positions") return false;
  if (setup.method == "time_parallel" && field.name.starts_with("seam")) return false;
  if (setup.method != "asynchronous") return true;
  for (const char* part : {"handle", "circle", "seam", "measured", "strain"})
    if (field.name.starts_with(part)) return false;
  return true;
}

/// Whether a scene that is valid otherwise is refused for a NaN in each field in turn.
void each_is_refused(const Setup& setup, const std::vector<Field>& fields) {
  try {
    validate(everything(setup));
  } catch (const SceneError& error) {
    throw Wrong(std::string("refused without any NaN: ") + error.what());
  }
  std::string accepted, refused;
  int count = 0;
  for (const Field& field : fields) {
    if (!is_there(setup, field)) continue;
    Scene scene = everything(setup);
    field.of(scene) = nan;
    ++count;
    try {
      run(std::move(scene), setup, 2);
      accepted += (accepted.empty() ? "" : ", ") + field.name;
    } catch (const SceneError& error) {
      refused = error.what();
    } catch (const SimulationError& error) {
      accepted += (accepted.empty() ? "" : ", ") + field.name + " (until it ran)";
    }
  }
  if (!accepted.empty()) throw Wrong("a NaN was accepted in: " + accepted);
  throw SceneError(fmt::format("all {}, such as: {}", count, refused));
}

/// Where it stands until 0.02 s, and nowhere after that.
class BreakingShape final : public Deformation {
 public:
  explicit BreakingShape(std::vector<Vec3<double>> shape) : shape_(std::move(shape)) {}
  void positions(double time, Span<Vec3<double>> out) const override {
    for (std::size_t v = 0; v < shape_.size(); ++v) out[v] = shape_[v];
    if (time > 0.02) out[3][1] = nan;
  }
  std::uint64_t checksum() const override { return 1; }

 private:
  std::vector<Vec3<double>> shape_;
};

void broken_sequence(const Setup& setup) {
  Scene scene = sheet_on_sphere(setup, 0.005);
  scene.obstacles[0].deformation =
      std::make_shared<BreakingShape>(scene.obstacles[0].mesh.positions);
  jitter(scene, setup);
  must_be_refused([&] { run(std::move(scene), setup, 10); },
                  "a moving obstacle with a NaN at 0.02 s");
}

}  // namespace

std::vector<Case> input_cases() {
  return {
      {"nan_in_meshes", "a NaN in each array of the meshes in turn: each is refused",
       [](const Setup& s) { each_is_refused(s, mesh_fields()); }},
      {"nan_in_parts", "the same in cloths, obstacles, pins, handles, seams",
       [](const Setup& s) { each_is_refused(s, part_fields()); }},
      {"nan_in_materials", "the same in materials",
       [](const Setup& s) { each_is_refused(s, material_fields()); }},
      {"nan_in_settings", "the same in all settings",
       [](const Setup& s) { each_is_refused(s, setting_fields()); }},
      {"nan_on_the_way", "a moving obstacle has a NaN from 0.02 s on: the step is refused",
       broken_sequence},
  };
}

}  // namespace weft::stability
