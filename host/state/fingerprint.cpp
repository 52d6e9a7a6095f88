#include "host/state/fingerprint.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <map>

#include "host/base/checksum.hpp"
#include "host/input/checker.hpp"
#include "host/input/safe_text.hpp"
#include "host/scene/origin.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Longer values are kept as a checksum.
constexpr std::size_t text_max = 120;
constexpr char checksum_mark = '#';
/// Most differences that one message names.
constexpr std::size_t named_max = 4;

std::string shown(bool value) {
  return value ? "true" : "false";
}
std::string shown(int value) {
  return std::to_string(value);
}
std::string shown(double value) {
  return text_of(value);
}
std::string shown(const std::string& value) {
  return value;
}
template <int N>
std::string shown(const Vec<double, N>& v) {
  std::string text = "[";
  for (int k = 0; k < N; ++k) text += (k > 0 ? ", " : "") + shown(v[k]);
  return text + "]";
}
std::string shown(const Transform& t) {
  return "translate " + shown(t.translate) + " rotate " + shown(t.rotation_angle) + " about " +
         shown(t.rotation_axis) + " scale " + shown(t.scale);
}
std::string shown(const Keyframe& key) {
  return shown(key.time) + ": " + shown(key.transform) +
         (key.interpolation == Interpolation::linear ? " linear" : "");
}
std::string shown(const CameraKey& key) {
  return shown(key.time) + ": from " + shown(key.position) + " to " + shown(key.look_at) + " up " +
         shown(key.up) + " field " + shown(key.field_of_view) + (key.jump ? " jump" : "");
}
template <class T>
std::string shown(const std::vector<T>& values) {
  std::string text = "[";
  for (const T& value : values) text += (text.size() > 1 ? ", " : "") + shown(value);
  return text + "]";
}

std::string text_of_checksum(const Checksum& checksum) {
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "%c%016llx", checksum_mark,
                static_cast<unsigned long long>(checksum.value()));
  return text.data();
}

/// The parts of a scene, one after the other.
class Parts {
 public:
  explicit Parts(const Scene& scene) : scene_(scene) {}

  Fingerprint take() {
    add("method.type", scene_.method);
    add("gravity", scene_.gravity);
    add_origin();
    if (scene_.time.automatic) {
      add("time.step", std::string("auto"));
      add("time.tolerance", scene_.time.tolerance);
    } else {
      add("time.step", scene_.time.step);
    }
    add("time.frame_rate", scene_.time.frame_rate);
    add("precision", static_cast<int>(scene_.precision));
    add("solver.integrator", static_cast<int>(scene_.integrator));
    add("bending", static_cast<int>(scene_.bending));
    for (std::size_t i = 0; i < scene_.materials.size(); ++i) add_material(i);
    for (std::size_t i = 0; i < scene_.cloths.size(); ++i) add_cloth(i);
    for (std::size_t i = 0; i < scene_.obstacles.size(); ++i) add_obstacle(i);
    for (std::size_t i = 0; i < scene_.pins.size(); ++i) add_pin(i);
    for (std::size_t i = 0; i < scene_.handles.size(); ++i) add_handle(i);
    for (std::size_t i = 0; i < scene_.seams.size(); ++i) add_seam(i);
    for (std::size_t i = 0; i < scene_.garment_starts.size(); ++i) add_garment_start(i);
    add("refine.when", static_cast<int>(scene_.refinement.when));
    add("refine.levels", scene_.refinement.levels);
    add("wind.density", scene_.wind.density);
    add("wind.velocity", scene_.wind.velocity);
    add("wind.drag", scene_.wind.drag);
    add_contact();
    if (scene_.method == "asynchronous")
      add_asynchronous();
    else
      add_solver();
    if (remeshes(scene_) || slices_remesh(scene_)) add_remeshing();
    if (scene_.method == "view" || scene_.time_parallel.method == "view") add_view();
    return std::move(parts_);
  }

 private:
  template <class T>
  void add(const std::string& name, const T& value) {
    std::string text = shown(value);
    if (text.size() > text_max) {
      Checksum checksum;
      checksum.add(text.data(), text.size());
      text = text_of_checksum(checksum);
    }
    // They end up in messages, and between zero bytes.
    parts_.emplace_back(without_controls(name), without_controls(text));
  }
  void add(const std::string& name, const Checksum& checksum) {
    parts_.emplace_back(without_controls(name), text_of_checksum(checksum));
  }

  std::string material_name(std::size_t i) const {
    const std::string& name = scene_.materials[i].name;
    return name.empty() ? numbered("materials", i) : "materials." + name;
  }

  void add_material(std::size_t i) {
    const Material& m = scene_.materials[i];
    const std::string name = material_name(i) + ".";
    add(name + "density", m.density);
    add(name + "stretch_stiffness", m.stretch_stiffness);
    add(name + "poisson_ratio", m.poisson_ratio);
    add(name + "bending_stiffness", m.bending_stiffness);
    add(name + "damping.mass", m.damping_mass);
    add(name + "damping.stiffness", m.damping_stiffness);
    if (m.orthotropic)
      add(name + "orthotropic",
          std::vector<double>{m.orthotropic->warp, m.orthotropic->weft,
                              m.orthotropic->poisson_ratio, m.orthotropic->shear});
    if (m.measured) {
      std::vector<double> values{static_cast<double>(m.measured->form)};
      for (const auto& row : m.measured->rows) values.insert(values.end(), row.begin(), row.end());
      add(name + "measured", values);
    }
    if (m.orthotropic_bending)
      add(name + "orthotropic_bending",
          std::vector<double>{m.orthotropic_bending->warp, m.orthotropic_bending->weft,
                              m.orthotropic_bending->coupling, m.orthotropic_bending->twist});
    if (m.strain_limits)
      add(name + "strain_limits", std::vector<double>{m.strain_limits->min, m.strain_limits->max});
  }

  void add_origin() {
    const Vec3<double> origin = origin_of(scene_);
    if (origin != Vec3<double>{0, 0, 0}) add("origin", std::vector<Vec3<double>>{origin});
  }

  void add_mesh(const std::string& name, const Mesh& mesh) {
    Checksum checksum;
    checksum.add(mesh.positions);
    checksum.add(mesh.material);
    checksum.add(mesh.triangles);
    checksum.add(mesh.material_triangles);
    add(name, checksum);
  }

  /// Such as "cloths.skirt.", or "cloths[1]." if another has the name of this one.
  template <class T>
  static std::string name_in(const char* list, const std::vector<T>& parts, std::size_t i) {
    const auto same = [&](const T& other) { return other.name == parts[i].name; };
    const bool unique = std::count_if(parts.begin(), parts.end(), same) == 1;
    return (unique ? list + ("." + parts[i].name) : numbered(list, i)) + ".";
  }

  void add_cloth(std::size_t i) {
    const Cloth& cloth = scene_.cloths[i];
    const std::string name = name_in("cloths", scene_.cloths, i);
    add_mesh(name + "mesh", cloth.mesh);
    add(name + "material", material_name(static_cast<std::size_t>(cloth.material)));
    Checksum triangle_material, rest;
    triangle_material.add(cloth.triangle_material);
    rest.add(cloth.rest_positions);
    if (!cloth.triangle_material.empty()) add(name + "triangle_material", triangle_material);
    if (!cloth.rest_positions.empty()) add(name + "rest", rest);
    add(name + "pressure", cloth.pressure);
    // Initial velocities have done all that they do once there is a state.
    if (cloth.remeshing) add(name + "remeshing", values_of(*cloth.remeshing));
  }

  void add_obstacle(std::size_t i) {
    const Obstacle& obstacle = scene_.obstacles[i];
    const std::string name = name_in("obstacles", scene_.obstacles, i);
    add_mesh(name + "mesh", obstacle.mesh);
    add(name + "friction", obstacle.friction);
    add(name + "transform", obstacle.transform);
    add(name + "motion", obstacle.motion);
    if (obstacle.deformation && !obstacle.live) {
      Checksum checksum;
      checksum.add(obstacle.deformation->checksum());
      add(name + "deformation", checksum);
    }
    if (obstacle.live) add(name + "live", true);
    if (!obstacle.driven) return;
    const DrivenBody& body = *obstacle.driven;
    add(name + "driven.axis", std::vector<Vec3<double>>{body.origin, body.axis});
    add(name + "driven.motor",
        std::vector<double>{body.inertia, body.torque, body.start_time, body.end_time});
  }

  void add_pin(std::size_t i) {
    const Pin& pin = scene_.pins[i];
    const std::string name = numbered("pins", i) + ".";
    add(name + "cloth", pin.cloth);
    add(name + "vertices", pin.vertices);
    add(name + "motion", pin.motion);
    add(name + "obstacle", pin.obstacle);
    add(name + "release_time", pin.release_time);
  }

  void add_handle(std::size_t i) {
    const Handle& h = scene_.handles[i];
    const std::string name = numbered("handles", i) + ".";
    add(name + "shape", static_cast<int>(h.shape));
    add(name + "cloth", h.cloth);
    add(name + "vertices", h.vertices);
    add(name + "motion", h.motion);
    if (length(h.along) > 0) add(name + "along", h.along);
    add(name + "stiffness", h.stiffness);
    add(name + "times", std::vector<double>{h.start_time, h.end_time, h.fade_time});
    if (h.carrier.obstacle >= 0) {
      add(name + "carrier.obstacle", h.carrier.obstacle);
      add(name + "carrier.vertices", h.carrier.vertices);
      add(name + "carrier.start", h.carrier.start);
    }
    if (h.shape != Handle::Shape::circle) return;
    add(name + "circle.circumference", h.circumference);
    add(name + "circle.direction", h.direction);
    add(name + "circle.frame", std::vector<Vec3<double>>{h.center, h.axis0, h.axis1});
  }

  void add_garment_start(std::size_t i) {
    const GarmentStart& start = scene_.garment_starts[i];
    const std::string name = numbered("garments", i) + ".";
    add(name + "cloth", start.cloth);
    add(name + "start", static_cast<int>(start.start));
    Checksum apart;
    apart.add(start.apart);
    if (!start.apart.empty()) add(name + "apart", apart);
  }

  void add_seam(std::size_t i) {
    const Seam& seam = scene_.seams[i];
    const std::string name = numbered("seams", i) + ".";
    add(name + "cloths", std::vector<Index>{seam.cloths[0], seam.cloths[1]});
    add(name + "vertices", std::vector<std::vector<Index>>{seam.vertices[0], seam.vertices[1]});
    add(name + "stiffness", seam.stiffness.value_or(0));
    add(name + "times", std::vector<double>{seam.start_time, seam.ramp_time});
    add(name + "weld_distance", seam.weld_distance.value_or(0));
  }

  /// Not contact.self_certificate, nor below transport and rebalance: they change no bits.
  void add_contact() {
    const ContactSettings& c = scene_.contact;
    add("contact.self", c.self);
    add("contact.thickness", contact_thickness(c));
    add("contact.friction", c.friction);
    add("contact.stiffness", c.stiffness);
    add("contact.zone_rounds", c.zone_rounds);
    add("contact.substep_bisections", c.substep_bisections);
    add("contact.compliance_distance", compliance_distance(c));
  }

  void add_solver() {
    const SolverSettings& s = scene_.solver;
    add("solver.tolerance", s.tolerance);
    add("solver.max_iterations", s.max_iterations);
    add("solver.preconditioner", static_cast<int>(s.preconditioner));
    add("solver.newton_iterations", s.newton_iterations);
    add("solver.newton_tolerance", s.newton_tolerance);
    add("solver.line_search", s.line_search);
    add("solver.partial_rows", s.partial_rows);
    add("method.implicit.sleep_distance", scene_.implicit.sleep_distance);
    add("method.implicit.sleep_window", scene_.implicit.sleep_window);
  }

  /// Windows and how pairs are told apart change no results. Caps end a run, and whoever raises one
  /// goes on from there.
  void add_asynchronous() {
    const AsynchronousSettings& a = scene_.asynchronous;
    add("method.asynchronous.stiffness", a.stiffness);
    add("method.asynchronous.restitution", a.restitution);
  }

  static std::vector<double> values_of(const Remeshing& r) {
    return {r.size_min,           r.size_max,        r.refine_angle,
            r.refine_compression, r.refine_velocity, r.aspect_min};
  }
  void add_remeshing() {
    add("remeshing", values_of(scene_.adaptive.remeshing));
    add("remeshing.flip_threshold", scene_.adaptive.flip_threshold);
    add("remeshing.energy_share", scene_.adaptive.energy_share);
  }

  void add_view() {
    const ViewSettings& v = scene_.view;
    add("method.view",
        std::vector<double>{v.factor_back, v.factor_out, v.margin, v.anticipation,
                            v.transfer_threshold, v.pixel_min, v.compensation_power});
    add("method.view.two_sided", v.two_sided);
    add("method.view.occlusion", v.occlusion);
    add("method.view.predict_obstacles", v.predict_obstacles);
    add("method.view.compensation", static_cast<int>(v.compensation));
    add("camera.keys", scene_.camera.keys);
    add("camera.resolution", std::vector<int>{scene_.camera.width, scene_.camera.height});
  }

  const Scene& scene_;
  Fingerprint parts_;
};

}  // namespace

Fingerprint fingerprint_of(const Scene& scene) {
  return Parts(scene).take();
}

std::vector<std::string> differences_between(const Fingerprint& then, const Fingerprint& now) {
  const std::map<std::string, std::string> before(then.begin(), then.end());
  const std::map<std::string, std::string> after(now.begin(), now.end());
  std::vector<std::string> differences;
  for (const auto& [name, value] : now) {
    const auto old = before.find(name);
    if (old == before.end())
      differences.push_back(name + " is new");
    else if (old->second == value)
      continue;
    else if (value.starts_with(checksum_mark) || old->second.starts_with(checksum_mark))
      differences.push_back(name + " has changed");
    else
      differences.push_back(name + " was " + old->second + ", now " + value);
  }
  for (const auto& [name, value] : then)
    if (!after.contains(name)) differences.push_back(name + " is gone");
  return differences;
}

void refuse_differences(const std::vector<std::string>& differences,
                        const std::filesystem::path& file) {
  if (differences.empty()) return;
  std::string text;
  for (std::size_t k = 0; k < std::min(differences.size(), named_max); ++k)
    text += (k > 0 ? "; " : "") + differences[k];
  if (differences.size() > named_max)
    text += "; and " + std::to_string(differences.size() - named_max) + " more";
  throw SceneError(file.string(), "checkpoint of another scene", text,
                   "the scene that it was written from; --resume-changed takes the state over all "
                   "the same");
}

std::string fingerprint_bytes(const Fingerprint& fingerprint) {
  std::string bytes;
  for (const auto& [name, value] : fingerprint) {
    bytes += name + '\0';
    bytes += value + '\0';
  }
  return bytes;
}

bool fingerprint_from(const std::string& bytes, Fingerprint& fingerprint) {
  fingerprint.clear();
  std::size_t place = 0;
  const auto next = [&](std::string& text) {
    const std::size_t end = bytes.find('\0', place);
    if (end == std::string::npos) return false;
    text = bytes.substr(place, end - place);
    place = end + 1;
    // It ends up in a message.
    return std::none_of(text.begin(), text.end(), is_control);
  };
  while (place < bytes.size()) {
    std::pair<std::string, std::string> part;
    if (!next(part.first) || !next(part.second)) return false;
    fingerprint.push_back(std::move(part));
  }
  return true;
}

}  // namespace weft
