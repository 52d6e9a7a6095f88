#include "host/io/pattern/panel_placement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <utility>

#include "host/geometry/aabb.hpp"
#include "host/input/counted.hpp"
#include "host/input/quantity.hpp"
#include "host/io/pattern/surface_tree.hpp"
#include "weft/core/at.hpp"

namespace weft::io {
namespace {

/// [vertices of a panel] Straps that touch a shoulder begin with a fifth of them in it.
constexpr double most_within = 0.4;
/// [sizes of the body] Seams between the front and the back are up to a third of it wide.
constexpr double widest_seam = 0.45;
/// [m] Points are looked at this far from where they are: a ray must not pass through a vertex.
constexpr Vec3<double> beside{1.3e-7, 2.1e-7, 3.7e-7};

/// Whether a ray along an axis leaves a surface more often than it enters, or less often where that
/// faces inwards.
bool starts_within(const SurfaceTree& surface, const Vec3<double>& from, int axis) {
  const int u = (axis + 1) % 3, w = (axis + 2) % 3;
  Aabb ray;
  ray.include(from);
  ray.hi[axis] = std::numeric_limits<double>::max();
  int crossings = 0;
  auto visit = [&](Index triangle) {
    const Corners x = surface.corners(triangle);
    double side[3], sum = 0, along = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<double> a = x[(k + 1) % 3] - from, b = x[(k + 2) % 3] - from;
      side[k] = a[u] * b[w] - a[w] * b[u];
      sum += side[k];
      along += side[k] * (x[k][axis] - from[axis]);
    }
    const bool ahead = side[0] > 0 && side[1] > 0 && side[2] > 0;
    const bool back = side[0] < 0 && side[1] < 0 && side[2] < 0;
    if ((ahead || back) && along / sum > 0) crossings += ahead ? 1 : -1;
  };
  surface.visit_boxes(ray, visit);
  return crossings != 0;
}

/// Along most axes, since surfaces may be open.
bool is_within(const SurfaceTree& surface, const Vec3<double>& x) {
  int votes = 0;
  for (int axis = 0; axis < 3; ++axis) votes += starts_within(surface, x + beside, axis) ? 1 : 0;
  return votes >= 2;
}

std::string metres(double length) {
  return short_number(std::round(100 * length) / 100) + " m";
}

std::string percent(double share) {
  return std::to_string(std::lround(100 * share)) + " %";
}

/// A line about panels that begin within the body; empty: none do.
std::string panels_within(const Garment& garment, const Mesh& body) {
  const SurfaceTree surface(body);
  std::string text;
  for (const GarmentPanel& panel : garment.panels) {
    int within = 0;
    for (Index v = 0; v < panel.vertex_count; ++v)
      within += is_within(surface, garment.mesh.positions[at(panel.first_vertex + v)]) ? 1 : 0;
    const double share = static_cast<double>(within) / panel.vertex_count;
    if (share > most_within)
      text += (text.empty() ? "" : ", ") + panel.name + " (" + percent(share) + ")";
  }
  if (text.empty()) return text;
  return "pattern.panels: of these, more than " + percent(most_within) +
         " begins within the body, around which panels should stand: " + text;
}

const std::string& panel_of(const Garment& garment, Index vertex) {
  const auto after =
      std::upper_bound(garment.panels.begin(), garment.panels.end(), vertex,
                       [](Index v, const GarmentPanel& panel) { return v < panel.first_vertex; });
  return std::prev(after)->name;
}

/// A line about seams that are too wide to close around the body; empty: there are none.
std::string wide_seams(const Garment& garment, const Mesh& body) {
  const double most = widest_seam * aabb_of(body.positions).longest_side();
  const std::vector<Vec3<double>>& x = garment.mesh.positions;
  const GarmentSeam* widest = nullptr;
  double largest = most;
  int count = 0;
  for (const GarmentSeam& seam : garment.seams) {
    double gap = 0;
    for (const auto& [a, b] : seam.pairs)
      gap += length(x[at(a)] - x[at(b)]) / static_cast<double>(seam.pairs.size());
    if (!(gap > most)) continue;
    ++count;
    if (widest != nullptr && gap <= largest) continue;
    largest = gap;
    widest = &seam;
  }
  if (widest == nullptr) return {};
  const auto& [a, b] = widest->pairs.front();
  return "pattern.stitches[" + std::to_string(widest->stitch) + "]: " + panel_of(garment, a) +
         " and " + panel_of(garment, b) + " are sewn together, but stand " + metres(largest) +
         " apart" +
         (count > 1
              ? ", and the sides of " + counted(count - 1, "more stitch") + " over " + metres(most)
              : "") +
         "; does each panel stand on its own side of the body?";
}

}  // namespace

std::vector<std::string> misplaced_panels(const Garment& garment, const Mesh& body) {
  std::vector<std::string> lines;
  if (body.triangles.empty()) return lines;
  for (std::string line : {panels_within(garment, body), wide_seams(garment, body)})
    if (!line.empty()) lines.push_back(std::move(line));
  return lines;
}

}  // namespace weft::io
