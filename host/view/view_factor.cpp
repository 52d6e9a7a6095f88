#include "host/view/view_factor.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <queue>
#include <utility>

#include "host/scene/camera.hpp"
#include "host/view/occlusion.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// A triangle in the camera's frame.
struct Face {
  Vec3<double> x[3];

  Vec3<double> centre() const { return (1.0 / 3) * (x[0] + x[1] + x[2]); }
  /// Whether the eye is on its front side. The camera's frame is left-handed.
  bool is_front() const { return dot(cross(x[1] - x[0], x[2] - x[0]), x[0]) > 0; }
};

Face face_of(const ViewCamera& camera, const Tri& t, const std::vector<Vec3<double>>& positions) {
  Face f;
  for (int j = 0; j < 3; ++j) f.x[j] = camera.seen(positions[at(t.v[j])]);
  return f;
}

/// Distances from the frustum. [triangles] [m]
std::vector<double> frustum_distances(const ViewCamera& camera, const std::vector<Face>& faces) {
  std::vector<double> distances;
  distances.reserve(faces.size());
  for (const Face& f : faces) distances.push_back(frustum_distance(camera.frustum(), f.x));
  return distances;
}

/// How far each hidden triangle is, along the cloth, from one that is in view; what is farther than
/// the margin, or not connected with any, is at the margin. The others are at 0. [m]
std::vector<double> hidden_distances(const std::vector<Face>& faces, const ViewSurface& surface,
                                     const std::vector<unsigned char>& hidden,
                                     const std::vector<double>& from_frustum, double margin) {
  std::vector<double> distance(faces.size(), 0);
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  for (std::size_t t = 0; t < faces.size(); ++t) {
    if (hidden[t] != 0)
      distance[t] = margin;
    else if (from_frustum[t] == 0)
      front.push({0, static_cast<Index>(t)});
  }
  while (!front.empty()) {
    const auto [d, t] = front.top();
    front.pop();
    if (d > distance[at(t)]) continue;
    for (const Index n : surface.across[at(t)]) {
      if (n < 0 || hidden[at(n)] == 0) continue;
      const double there = d + length(faces[at(n)].centre() - faces[at(t)].centre());
      if (there >= distance[at(n)]) continue;
      distance[at(n)] = there;
      front.push({there, n});
    }
  }
  return distance;
}

std::vector<Face> faces_of(const ViewCamera& camera, const ViewSurface& surface,
                           const ViewPlaces& places) {
  std::vector<Face> faces;
  faces.reserve(surface.triangles.size());
  for (const Tri& t : surface.triangles) faces.push_back(face_of(camera, t, places.cloth));
  return faces;
}

bool same_view(const CameraKey& a, const CameraKey& b) {
  return a.position == b.position && a.look_at == b.look_at && a.up == b.up &&
         a.field_of_view == b.field_of_view;
}

}  // namespace

double smoothed_factor(double facing, double distance, const ViewSettings& settings) {
  if (!(distance > 0)) return facing;
  if (distance >= settings.margin) return settings.factor_out;
  return facing - distance / settings.margin * (facing - settings.factor_out);
}

double anticipation_weight(double delay, double window) {
  if (!(delay > 0)) return 1;
  return window > delay ? 1 - delay / window : 0;
}

std::vector<double> view_factors(const ViewCamera& camera, const ViewSurface& surface,
                                 const ViewPlaces& places, const ViewSettings& settings) {
  const std::vector<Face> faces = faces_of(camera, surface, places);
  std::vector<double> distances = frustum_distances(camera, faces);
  if (settings.occlusion) {
    const std::vector<double> more = hidden_distances(
        faces, surface, hidden_triangles(camera, surface, places), distances,
        settings.margin > 0 ? settings.margin : std::numeric_limits<double>::infinity());
    for (std::size_t t = 0; t < more.size(); ++t) distances[t] = std::max(distances[t], more[t]);
  }
  std::vector<double> factors;
  factors.reserve(faces.size());
  for (std::size_t t = 0; t < faces.size(); ++t) {
    const bool front = settings.two_sided || faces[t].is_front();
    factors.push_back(smoothed_factor(front ? 1 : settings.factor_back, distances[t], settings));
  }
  return factors;
}

std::vector<unsigned char> out_of_frustum(const ViewCamera& camera, const ViewSurface& surface,
                                          const ViewPlaces& places) {
  std::vector<unsigned char> out;
  for (const double d : frustum_distances(camera, faces_of(camera, surface, places)))
    out.push_back(d > 0 ? 1 : 0);
  return out;
}

std::vector<double> transferred_factors(const std::vector<double>& factors,
                                        const ViewSurface& surface, double threshold) {
  std::vector<double> result = factors;
  for (std::size_t t = 0; t < factors.size(); ++t)
    for (const Index n : surface.across[t])
      if (n >= 0 && factors[at(n)] - factors[t] > threshold)
        result[t] = std::max(result[t], (factors[at(n)] + factors[t]) / 2);
  return result;
}

std::vector<ViewInstant> view_instants(const Camera& camera, const ViewSettings& settings,
                                       double frame_rate, double time) {
  const double window = settings.anticipation / frame_rate;
  std::vector<double> delays{0};
  for (int frame = 1; frame < settings.anticipation; ++frame) delays.push_back(frame / frame_rate);
  for (const CameraKey& key : camera.keys)
    if (key.time > time && key.time < time + window) delays.push_back(key.time - time);
  std::sort(delays.begin(), delays.end());
  std::vector<ViewInstant> instants;
  std::vector<CameraKey> keys;
  for (const double delay : delays) {
    const CameraKey key = camera_at(camera, time + delay);
    const double weight = anticipation_weight(delay, window);
    const bool known = !settings.predict_obstacles &&
                       std::any_of(keys.begin(), keys.end(),
                                   [&](const CameraKey& k) { return same_view(k, key); });
    if (known || !(weight > 0)) continue;
    keys.push_back(key);
    instants.push_back({ViewCamera(key, camera.width, camera.height), delay, weight});
  }
  return instants;
}

double ViewField::factor(Index triangle) const {
  double greatest = 0;
  for (const View& view : views) greatest = std::max(greatest, view.factors[at(triangle)]);
  return greatest;
}

ViewField look(const std::vector<ViewInstant>& instants, const ViewSurface& surface,
               const std::function<ViewPlaces(double)>& places_at, const ViewSettings& settings) {
  ViewField field{{}, settings};
  for (const ViewInstant& instant : instants) {
    ViewField::View view{instant, places_at(instant.delay), {}};
    view.factors = transferred_factors(view_factors(instant.camera, surface, view.places, settings),
                                       surface, settings.transfer_threshold);
    for (double& factor : view.factors) factor *= instant.weight;
    field.views.push_back(std::move(view));
  }
  return field;
}

}  // namespace weft
