#include "host/lab/plan/plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "host/geometry/planar_domain.hpp"
#include "host/implicit/contact/self_certificate.hpp"
#include "host/model/model.hpp"
#include "host/model/model_part.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/scene/origin.hpp"
#include "host/scene/seams/sewing.hpp"

namespace weft::lab {
namespace {

/// A number with three digits.
std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

double largest_bending(const Material& m) {
  if (!m.orthotropic_bending) return m.bending_stiffness;
  return std::max(
      {m.orthotropic_bending->warp, m.orthotropic_bending->weft, m.orthotropic_bending->twist});
}

bool moves(const Obstacle& obstacle) {
  return !obstacle.motion.empty() || obstacle.deformation != nullptr || obstacle.driven;
}

template <class List, class Test>
bool any(const List& list, Test test) {
  return std::any_of(list.begin(), list.end(), test);
}

/// The self certificate of the implicit step at the scene's start, for one step at the initial
/// velocities; the first step tests about the same motion.
std::string self_contact_at_start(const Scene& scene) {
  const std::string unproved = "nothing proves that the cloth cannot reach itself";
  if (scene.method == "asynchronous") return unproved;
  if (!scene.contact.self_certificate) return unproved + ": contact.self_certificate is false";
  const Model model = make_model(scene, sewing_at_start(scene).welded);
  const std::vector<Tri> cloth(model.triangles.begin(),
                               model.triangles.begin() + model.cloth_triangle_count);
  SelfCertificate<double> certificate(
      planar_domains(model.cloth_vertex_count, cloth, model.material_points),
      contact_thickness(scene.contact), 1);
  if (certificate.pieces() == 0) return unproved + ": some cloth is not one convex panel";
  if (!certificate.of_use())
    return unproved + ": its mesh is as fine as the thickness, or it has too many panels";
  std::vector<Vec3<double>> ends = model.positions;
  for (std::size_t v = 0; v < ends.size(); ++v)
    ends[v] += longest_step(scene.time) * model.velocities[v];
  const bool holds = certificate.holds(
      [&](int) {
        return SelfCertificate<double>::Motion{model.positions, ends};
      },
      [](const std::function<void(int)>& part) { part(0); });
  return holds
             ? "the cloth provably cannot reach itself at the start; on the CPU, steps repeat the "
               "proof and skip the search for its pairs while it holds; after failed proofs they "
               "try it less often"
             : unproved +
                   " at the start: it is folded, or panels are side by side; on the CPU, later "
                   "steps try the proof again, and skip the search for its pairs while it holds";
}

StagePlan plan_self_contact(const Scene& scene) {
  if (!scene.contact.self)
    return {"self-contact", Verdict::left_out, "contact.self is false", "", "contact.self=false"};
  return {"self-contact", Verdict::needed, self_contact_at_start(scene), ""};
}

StagePlan plan_obstacles(const Scene& scene) {
  if (scene.obstacles.empty())
    return {"contact with obstacles", Verdict::left_out, "there are none", ""};
  return {"contact with obstacles", Verdict::needed, "the cloth may reach them", ""};
}

StagePlan plan_obstacle_motion(const Scene& scene) {
  if (!any(scene.obstacles, moves))
    return {"motion of obstacles", Verdict::left_out,
            "none moves: their part of the spatial hash is built once", "",
            "model.obstacle_motion=false"};
  return {"motion of obstacles", Verdict::needed, "some move", ""};
}

StagePlan plan_friction(const Scene& scene) {
  const bool rubs = (scene.contact.self && scene.contact.friction > 0) ||
                    any(scene.obstacles, [](const Obstacle& o) { return o.friction > 0; });
  if (!rubs)
    return {"friction", Verdict::left_out, "nothing that can touch has friction",
            scene.contact.friction > 0 ? "model.friction=false" : "", "model.friction=false"};
  return {"friction", Verdict::needed, "it decides whether cloth slides", ""};
}

StagePlan plan_wind(const Scene& scene) {
  if (!(scene.wind.density > 0))
    return {"wind", Verdict::left_out, "there is no air", "", "wind.density=0"};
  if (length(scene.wind.velocity) == 0)
    return {"wind", Verdict::needed, "still air brakes moving cloth", ""};
  return {"wind", Verdict::needed, "air of " + text(length(scene.wind.velocity)) + " m/s", ""};
}

StagePlan plan_bending(const Scene& scene) {
  const bool bends = any(scene.materials, [](const Material& m) { return largest_bending(m) > 0; });
  if (!bends)
    return {"bending", Verdict::left_out, "no material resists it", "", "model.bending=false"};
  const double scale = bending_length(scene), edge = mean_edge(scene);
  if (scale > 0 && scale < edge / 4)
    return {"bending", Verdict::offered,
            "sheets bend under their weight over " + text(scale) +
                " m, less than a quarter of the "
                "mean edge of " +
                text(edge) + " m, so this mesh hardly shows it",
            "model.bending=false"};
  return {"bending", Verdict::needed,
          scale > 0 ? "sheets bend under their weight over " + text(scale) +
                          " m, and the mean edge is " + text(edge) + " m"
                    : "without gravity, nothing shows that it is small",
          ""};
}

StagePlan plan_precision(const Scene& scene) {
  constexpr double unit = 0x1p-23;
  Scene placed = scene;
  choose_origin(placed);  // as the simulation does
  const double reach = largest_coordinate(placed);
  const double grain = reach * unit;
  const std::string fact = "single precision rounds coordinates of up to " + text(reach) +
                           " m to " + text(grain) + " m; the contact thickness is " +
                           text(contact_thickness(scene.contact)) + " m";
  const bool fine = grain < contact_thickness(scene.contact) / 100;
  if (scene.precision == Precision::single_precision)
    return {"double precision", fine ? Verdict::left_out : Verdict::offered,
            fact + (fine ? "" : ": too coarse; use double"), fine ? "" : "precision=double"};
  if (scene.method == "asynchronous")
    return {"double precision", Verdict::needed, "the method has no other precision", ""};
  return {"double precision", fine ? Verdict::offered : Verdict::needed, fact,
          fine ? "precision=float" : ""};
}

/// The method itself, or that of its slices of time.
const std::string& method_of_steps(const Scene& scene) {
  return scene.method == "time_parallel" ? scene.time_parallel.method : scene.method;
}

StagePlan plan_remeshing(const Scene& scene) {
  if (remeshes(scene) || slices_remesh(scene))
    return {"remeshing", Verdict::needed,
            "the method " + method_of_steps(scene) + " refines meshes where they bend", ""};
  const bool curved = any(scene.cloths, [](const Cloth& c) { return !c.rest_positions.empty(); });
  if (curved || scene.method == "asynchronous" || scene.refinement.when != Refinement::When::never)
    return {"remeshing", Verdict::left_out, "the meshes stay as they are", ""};
  return {"remeshing", Verdict::offered,
          "flat parts need fewer triangles; the method adaptive finds them",
          "method.type=adaptive"};
}

/// Cloth at rest may sleep, see SleepingStep.
StagePlan plan_rest(const Scene& scene) {
  const std::string stage = "regions at rest";
  if (scene.method != "implicit")
    return {stage, Verdict::missing,
            "the method " + scene.method + " simulates them like all other cloth", ""};
  const std::vector<Index> piece =
      cloth_components(make_model(scene, sewing_at_start(scene).welded));
  const Index pieces = piece.empty() ? 0 : *std::max_element(piece.begin(), piece.end()) + 1;
  const std::string count = std::to_string(pieces) + (pieces == 1 ? " component" : " components");
  const double distance = scene.implicit.sleep_distance;
  if (distance > 0)
    return {stage, Verdict::needed,
            "on CPU threads, steps skip resting cloth (" + count + "); the error is at most " +
                text(distance) + " m if it does not speed up by itself",
            "", "method.implicit.sleep_distance=0"};
  return {
      stage, Verdict::offered,
      "cloth at rest is simulated like all other cloth; on CPU threads, " + count + " could sleep",
      "method.implicit.sleep_distance=" + text(contact_thickness(scene.contact) / 10)};
}

StagePlan plan_camera(const Scene& scene) {
  const std::string stage = "cloth out of view";
  if (method_of_steps(scene) == "view")
    return {stage, Verdict::needed, "the method view makes it coarser, but still simulates it", ""};
  const bool flat = std::all_of(scene.cloths.begin(), scene.cloths.end(),
                                [](const Cloth& c) { return c.rest_positions.empty(); });
  if (scene.camera.keys.empty() || !flat || scene.method == "asynchronous" ||
      scene.refinement.when != Refinement::When::never)
    return {stage, Verdict::needed,
            scene.camera.keys.empty() ? "the scene has no camera of its own"
                                      : "the method view cannot simulate this scene",
            ""};
  return {stage, Verdict::offered, "the method view uses coarser meshes there", "method.type=view"};
}

/// A part of the scene that is there or not.
StagePlan plan_part(const std::string& stage, bool there, const std::string& why) {
  return {stage, there ? Verdict::needed : Verdict::left_out, there ? why : "the scene has none",
          ""};
}

}  // namespace

const char* describe(Verdict verdict) {
  switch (verdict) {
    case Verdict::needed:
      return "needed";
    case Verdict::left_out:
      return "left out";
    case Verdict::in_need:
      return "within target";
    case Verdict::offered:
      return "try without";
    case Verdict::missing:
      return "not offered";
  }
  return "unknown";
}

double bending_length(const Scene& scene) {
  const double g = length(scene.gravity);
  double largest = 0;
  if (g > 0)
    for (const Material& m : scene.materials)
      largest = std::max(largest, std::cbrt(largest_bending(m) / (m.density * g)));
  return largest;
}

double mean_edge(const Scene& scene) {
  double sum = 0;
  std::size_t count = 0;
  for (const Cloth& cloth : scene.cloths) {
    const Mesh& mesh = cloth.mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Tri& corners =
          mesh.material_triangles.empty() ? mesh.triangles[t] : mesh.material_triangles[t];
      for (int k = 0; k < 3; ++k, ++count)
        sum += length(mesh.material[static_cast<std::size_t>(corners.v[k])] -
                      mesh.material[static_cast<std::size_t>(corners.v[(k + 1) % 3])]);
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

double largest_coordinate(const Scene& scene) {
  double largest = 0;
  const auto reach = [&](const Vec3<double>& x) {
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(x[k]));
  };
  for (const Cloth& cloth : scene.cloths)
    for (const auto& x : cloth.mesh.positions) reach(x);
  for (const Obstacle& obstacle : scene.obstacles) {
    for (const auto& x : obstacle.mesh.positions)
      if (obstacle.motion.empty()) reach(apply(obstacle.transform, x));
    for (const Keyframe& key : obstacle.motion)
      for (const auto& x : obstacle.mesh.positions) reach(apply(key.transform, x));
  }
  return largest;
}

std::vector<StagePlan> plan_stages(const Scene& scene) {
  const bool limited =
      any(scene.materials, [](const Material& m) { return m.strain_limits.has_value(); });
  const bool damped = any(scene.materials, [](const Material& m) {
    return m.damping_mass > 0 || m.damping_stiffness > 0;
  });
  return {
      plan_obstacles(scene),
      plan_obstacle_motion(scene),
      plan_self_contact(scene),
      plan_friction(scene),
      {"stretching", Verdict::needed, "every cloth needs it", ""},
      plan_part("strain limits", limited, "materials have them"),
      plan_bending(scene),
      plan_part("damping", damped, "materials have it"),
      plan_part("pressure", any(scene.cloths, [](const Cloth& c) { return c.pressure != 0; }),
                "cloths have it"),
      plan_wind(scene),
      plan_part("handles", !scene.handles.empty(), "springs pull"),
      plan_part("seams", !scene.seams.empty(), "panels are sewn"),
      plan_part("refinement", scene.refinement.when != Refinement::When::never,
                "once all seams are sewn"),
      plan_remeshing(scene),
      plan_precision(scene),
      plan_rest(scene),
      plan_camera(scene),
  };
}

}  // namespace weft::lab
