#include "host/render/close_up.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <utility>

#include "host/render/picture_scene.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using shading::Float3;
using shading::Part;

/// Ten edge lengths across.
constexpr double edges_around = 5;
/// [radii] Triangles are kept up to here, so that surfaces reach the border of the picture.
constexpr double kept_around = 1.5;
constexpr int directions = 96;
/// Triangles of a cloth that vote for a direction, at most.
constexpr std::size_t votes_max = 400;
/// If the best direction shows a smaller share of the cloth, obstacles are no reason to avoid
/// another one: they are drawn as wires.
constexpr double seen_min = 0.25;
/// [radii] from a surface to where rays that leave it begin.
constexpr float off_surface = 1e-3f;

/// The cloth triangle with the corner that is nearest to a place.
struct NearestCloth {
  double distance = std::numeric_limits<double>::infinity();  ///< [m]
  double edge = 0;                                            ///< [m] mean length of its edges
};

NearestCloth nearest_cloth(const std::vector<Part>& cloths, const Vec3<double>& place) {
  NearestCloth nearest;
  for (const Part& cloth : cloths)
    for (const Tri& t : cloth.triangles) {
      const auto x = [&](int k) -> const Vec3<double>& {
        return cloth.source->mesh.positions[static_cast<std::size_t>(t.v[k])];
      };
      const double distance =
          std::min({length(x(0) - place), length(x(1) - place), length(x(2) - place)});
      if (distance >= nearest.distance) continue;
      nearest = {distance, (length(x(1) - x(0)) + length(x(2) - x(1)) + length(x(0) - x(2))) / 3};
    }
  return nearest;
}

/// Meshes without the triangles whose boxes are farther than `reach` from a place.
std::vector<NamedMesh> cropped(const std::vector<Part>& parts, const Vec3<double>& place,
                               double reach) {
  const Vec3<double> to_corner{reach, reach, reach};
  const Aabb around{place - to_corner, place + to_corner};
  std::vector<NamedMesh> result;
  for (const Part& part : parts) {
    const std::vector<Vec3<double>>& x = part.source->mesh.positions;
    NamedMesh& mesh = result.emplace_back(NamedMesh{part.source->name, {}});
    mesh.mesh.positions = x;
    for (const Tri& t : part.triangles) {
      Aabb box;
      for (const Index v : t.v) box.include(x[static_cast<std::size_t>(v)]);
      if (box.overlaps(around)) mesh.mesh.triangles.push_back(t);
    }
  }
  return result;
}

/// A piece of cloth that should be visible.
struct Vote {
  Float3 point, normal;
  double weight = 0;
};

/// Votes of a cloth's triangles within the unit ball; all together weigh 1.
void add_votes(const shading::Surface& surface, std::vector<Vote>& votes) {
  std::vector<Vote> own;
  for (const Tri& t : surface.triangles) {
    const Float3 &a = surface.position(t.v[0]), &b = surface.position(t.v[1]),
                 &c = surface.position(t.v[2]);
    const Float3 point = (a + b + c) * (1.0f / 3);
    const float distance = length(point);
    if (distance < 1)
      own.push_back({point, shading::normalized(cross(b - a, c - a)), 1 - distance});
  }
  const std::size_t stride = own.size() / votes_max + 1;
  double sum = 0;
  for (std::size_t i = 0; i < own.size(); i += stride) sum += own[i].weight;
  for (std::size_t i = 0; i < own.size(); i += stride) {
    own[i].weight /= sum;
    votes.push_back(own[i]);
  }
}

/// Unit vectors that are evenly spread, the one nearest to the usual view first (Vogel's spiral).
std::vector<Vec3<double>> spread_directions(const PictureOptions& options) {
  const double azimuth = options.azimuth_degrees * shading::pi / 180;
  const double elevation = options.elevation_degrees * shading::pi / 180;
  const Vec3<double> usual{std::cos(azimuth) * std::cos(elevation),
                           std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
  std::vector<Vec3<double>> result;
  const double golden = shading::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < directions; ++i) {
    const double z = 1 - (2 * i + 1.0) / directions;
    const double r = std::sqrt(1 - z * z);
    result.push_back({r * std::cos(golden * i), r * std::sin(golden * i), z});
  }
  std::stable_sort(result.begin(), result.end(),
                   [&](const auto& a, const auto& b) { return dot(a, usual) > dot(b, usual); });
  return result;
}

struct Sight {
  Vec3<double> direction{0, 0, 1};  ///< from the place to the eye
  double seen = -1;                 ///< share of the cloth, foreshortened
};

/// The direction from which an eye at `distance` sees most of the cloth.
/// @param distance [radii]
Sight best_sight(const std::vector<shading::Surface>& surfaces, double distance,
                 const PictureOptions& options) {
  std::vector<Vote> votes;
  for (const shading::Surface& s : surfaces)
    if (s.cloth) add_votes(s, votes);
  double all = 0;
  for (const Vote& vote : votes) all += vote.weight;
  const shading::RayScene rays(surfaces);
  Sight best;
  for (const Vec3<double>& direction : spread_directions(options)) {
    const Float3 eye = vec_cast<float>(direction * distance);
    double seen = 0;
    for (const Vote& vote : votes) {
      const Float3 way = eye - vote.point;
      const float far = length(way);
      const Float3 unit = way * (1 / far);
      if (rays.blocked(vote.point + unit * off_surface, unit, far)) continue;
      seen += vote.weight / all * std::abs(static_cast<double>(dot(unit, vote.normal)));
    }
    if (seen > best.seen) best = {direction, seen};
  }
  return best;
}

/// Draws the edges of an obstacle instead of its faces.
void draw_as_wires(NamedMesh& obstacle, std::vector<Wire>& wires) {
  const auto& x = obstacle.mesh.positions;
  std::set<std::pair<Index, Index>> edges;
  for (const Tri& t : obstacle.mesh.triangles)
    for (int k = 0; k < 3; ++k) edges.insert(std::minmax(t.v[k], t.v[(k + 1) % 3]));
  for (const auto& [a, b] : edges)
    wires.push_back({x[static_cast<std::size_t>(a)], x[static_cast<std::size_t>(b)]});
  obstacle.mesh.triangles.clear();
}

}  // namespace

CloseUp close_up(const std::vector<NamedMesh>& cloths, const std::vector<NamedMesh>& obstacles,
                 const Vec3<double>& place, const PictureOptions& options) {
  shading::check_options(options);
  const shading::Contents whole = shading::make_contents(cloths, obstacles, nullptr);
  const NearestCloth nearest = nearest_cloth(whole.cloths, place);
  if (!(nearest.edge > 0))
    throw SceneError("", "picture", "no cloth about the place", "a cloth with finite corners");
  CloseUp result;
  result.radius = std::max(edges_around * nearest.edge, 1.2 * nearest.distance);
  result.cloths = cropped(whole.cloths, place, kept_around * result.radius);
  result.obstacles = cropped(whole.obstacles, place, kept_around * result.radius);
  const shading::Contents contents =
      shading::make_contents(result.cloths, result.obstacles, nullptr);
  const double half_height = shading::half_height(options);
  const double half_width = half_height * options.width / options.height;
  const double distance = result.radius / std::min(half_height, half_width);
  const std::vector<shading::Surface> surfaces =
      shading::make_surfaces(contents, {place, 1 / result.radius}, nullptr);
  Sight sight = best_sight(surfaces, distance / result.radius, options);
  if (sight.seen < seen_min) {
    std::vector<shading::Surface> cloth_only = surfaces;
    std::erase_if(cloth_only, [](const shading::Surface& s) { return !s.cloth; });
    sight = best_sight(cloth_only, distance / result.radius, options);
  }
  const Vec3<double>& direction = sight.direction;
  result.options = options;
  result.options.automatic_camera = false;
  result.options.eye = place + direction * distance;
  result.options.look_at = place;
  result.options.up = {0, 0, 1};
  result.options.subject.reset();
  result.options.ground = false;
  result.options.edges = true;
  const Float3 towards_eye = vec_cast<float>(direction);
  for (std::size_t o = 0; o < result.obstacles.size(); ++o) {
    const shading::RayScene alone({surfaces[result.cloths.size() + o]});
    if (alone.blocked(towards_eye * off_surface, towards_eye, std::numeric_limits<float>::max()))
      draw_as_wires(result.obstacles[o], result.options.wires);
  }
  for (int k = 0; k < 3; ++k) {
    Vec3<double> arm{0, 0, 0};
    arm[k] = nearest.edge;
    result.options.wires.push_back({place - arm, place + arm});
  }
  return result;
}

}  // namespace weft::io
