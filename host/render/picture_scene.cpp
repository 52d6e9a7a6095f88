#include "host/render/picture_scene.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

namespace weft::io::shading {
namespace {

/// Corner normals: area-weighted means of the triangles around a vertex. Obstacles keep edges
/// sharper than 40 degrees; cloth has no edges, only folds.
std::vector<Float3> corner_normals(const Surface& s) {
  std::vector<Float3> face, vertex_sum(s.positions.size(), Float3{0, 0, 0});
  std::vector<std::vector<std::size_t>> around(s.cloth ? 0 : s.positions.size());
  for (const Tri& t : s.triangles) {
    const Float3 origin = s.position(t.v[0]);
    face.push_back(cross(s.position(t.v[1]) - origin, s.position(t.v[2]) - origin));
    for (const Index v : t.v) {
      vertex_sum[static_cast<std::size_t>(v)] += face.back();
      if (!s.cloth) around[static_cast<std::size_t>(v)].push_back(face.size() - 1);
    }
  }
  constexpr float edge_cosine = 0.766f;
  std::vector<Float3> normals;
  for (std::size_t t = 0; t < face.size(); ++t)
    for (const Index v : s.triangles[t].v) {
      Float3 sum = vertex_sum[static_cast<std::size_t>(v)];
      if (!s.cloth) {
        sum = {0, 0, 0};
        for (const std::size_t other : around[static_cast<std::size_t>(v)])
          if (dot(face[t], face[other]) >= edge_cosine * length(face[t]) * length(face[other]))
            sum += face[other];
      }
      normals.push_back(normalized(length_sq(sum) > 0 ? sum : face[t]));
    }
  return normals;
}

/// @param values [3 * triangles of the mesh], as they are; null: none
Surface make_surface(const Part& part, const Placement& place, bool cloth,
                     const std::vector<float>* values, const PictureValues* range) {
  Surface s;
  s.cloth = cloth;
  std::vector<bool> held;
  for (const Vec3<double>& p : part.source->mesh.positions) {
    held.push_back(usable(p) && Placement::holds(place(p)));
    s.positions.push_back(held.back() ? vec_cast<float>(place(p)) : Float3{0, 0, 0});
  }
  for (std::size_t i = 0; i < part.triangles.size(); ++i) {
    const Tri& t = part.triangles[i];
    if (!std::all_of(t.v, t.v + 3, [&](Index v) { return held[static_cast<std::size_t>(v)]; }))
      continue;
    s.triangles.push_back(t);
    for (std::size_t k = 0; values != nullptr && k < 3; ++k)
      s.values.push_back(static_cast<float>(((*values)[3 * part.numbers[i] + k] - range->low) /
                                            (range->high - range->low)));
  }
  s.normals = corner_normals(s);
  return s;
}

/// Muted hues (linear RGB), front and back of a cloth: the back is paler, so that a fold shows.
constexpr std::array<std::array<Float3, 2>, 6> palette{{
    {{{0.430f, 0.130f, 0.090f}, {0.600f, 0.380f, 0.280f}}},  // terracotta
    {{{0.090f, 0.165f, 0.265f}, {0.290f, 0.390f, 0.490f}}},  // slate blue
    {{{0.490f, 0.310f, 0.110f}, {0.620f, 0.490f, 0.300f}}},  // ochre
    {{{0.150f, 0.230f, 0.150f}, {0.350f, 0.430f, 0.330f}}},  // sage
    {{{0.225f, 0.115f, 0.185f}, {0.440f, 0.310f, 0.390f}}},  // plum
    {{{0.075f, 0.200f, 0.205f}, {0.280f, 0.420f, 0.420f}}},  // teal
}};
constexpr Float3 obstacle_colour{0.50f, 0.465f, 0.425f};

void check_values(const Contents& contents, const PictureValues& values) {
  if (!(values.low < values.high))
    throw SceneError("", "picture.values",
                     std::to_string(values.low) + " to " + std::to_string(values.high),
                     "low < high");
  bool good = values.corners.size() == contents.cloths.size();
  for (std::size_t i = 0; good && i < contents.cloths.size(); ++i)
    good = values.corners[i].size() == 3 * contents.cloths[i].source->mesh.triangles.size();
  if (!good)
    throw SceneError("", "picture.values", "another number of values",
                     "one for each corner of each cloth's triangles");
}

}  // namespace

std::vector<Surface> make_surfaces(const Contents& contents, const Placement& place,
                                   const PictureValues* values) {
  std::vector<Surface> surfaces;
  if (values != nullptr) check_values(contents, *values);
  for (std::size_t i = 0; i < contents.cloths.size(); ++i) {
    surfaces.push_back(make_surface(contents.cloths[i], place, true,
                                    values != nullptr ? &values->corners[i] : nullptr, values));
    surfaces.back().front = palette[i % palette.size()][0];
    surfaces.back().back = palette[i % palette.size()][1];
  }
  for (const Part& obstacle : contents.obstacles) {
    surfaces.push_back(make_surface(obstacle, place, false, nullptr, nullptr));
    surfaces.back().front = surfaces.back().back = obstacle_colour;
    surfaces.back().catcher = contents.is_catcher(obstacle);
  }
  return surfaces;
}

Surface wire_surface(const std::vector<Wire>& wires, const Placement& place,
                     const Vec3<double>& eye, double width) {
  Surface s;
  s.front = s.back = {0.015f, 0.015f, 0.018f};
  for (const Wire& wire : wires) {
    const Vec3<double> ends[2] = {place(wire.from), place(wire.to)};
    if (!Placement::holds(ends[0]) || !Placement::holds(ends[1]) || ends[0] == ends[1]) continue;
    const Frame frame(vec_cast<float>(normalized(ends[1] - ends[0])));
    const auto first = static_cast<Index>(s.positions.size());
    for (const Vec3<double>& end : ends) {
      const auto radius = static_cast<float>(width / 2 * length(end - place(eye)));
      const Float3 x = vec_cast<float>(end);
      for (const Float3& side : {frame.x, frame.y, -frame.x, -frame.y})
        s.positions.push_back(x + side * radius);
    }
    for (Index k = 0; k < 4; ++k) {
      const Index a = first + k, b = first + (k + 1) % 4;
      s.triangles.push_back({{a, b, b + 4}});
      s.triangles.push_back({{a, b + 4, a + 4}});
    }
  }
  s.normals = corner_normals(s);
  return s;
}

}  // namespace weft::io::shading
