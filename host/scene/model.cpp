#include "host/scene/model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "weft/elements/hinge.hpp"

namespace weft {
namespace {

/// Spreads the low 21 bits of x to every third bit.
std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// Numbers of `points` along a Morton curve; equal codes keep their order.
std::vector<Index> morton_order(const std::vector<Vec3<double>>& points) {
  Vec3<double> lo = points.front();
  Vec3<double> hi = points.front();
  for (const auto& p : points)
    for (int c = 0; c < 3; ++c) {
      lo[c] = std::min(lo[c], p[c]);
      hi[c] = std::max(hi[c], p[c]);
    }
  const double extent = std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2], 1e-300});
  std::vector<std::uint64_t> code(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double share = (points[i][c] - lo[c]) / extent;
      code[i] |= spread_bits(static_cast<std::uint64_t>(share * 2097151.0)) << c;
    }
  std::vector<Index> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
    return code[static_cast<std::size_t>(a)] < code[static_cast<std::size_t>(b)];
  });
  return order;
}

void add_cloth_vertices(const Scene& scene, Model& m) {
  std::vector<Vec3<double>> points;
  std::vector<Index> cloth;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    m.input_offset.push_back(static_cast<Index>(points.size()));
    for (const auto& p : scene.cloths[c].mesh.positions) {
      points.push_back(p);
      cloth.push_back(static_cast<Index>(c));
    }
  }
  m.input_offset.push_back(static_cast<Index>(points.size()));
  m.to_input = morton_order(points);
  m.to_internal.resize(points.size());
  m.cloth_vertex_count = static_cast<Index>(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto input = static_cast<std::size_t>(m.to_input[i]);
    m.to_internal[input] = static_cast<Index>(i);
    const Index which = cloth[input];
    const Cloth& owner = scene.cloths[static_cast<std::size_t>(which)];
    m.cloth_of_vertex.push_back(which);
    m.positions.push_back(points[input]);
    m.velocities.push_back(owner.velocity);
    m.material_points.push_back(
        owner.mesh.material[input - static_cast<std::size_t>(
                                        m.input_offset[static_cast<std::size_t>(which)])]);
  }
}

void add_cloth_triangles(const Scene& scene, Model& m) {
  struct Placed {
    Tri tri;
    Index material;
  };
  std::vector<Placed> placed;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    for (const Tri& t : scene.cloths[c].mesh.triangles) {
      Placed p{{}, scene.cloths[c].material};
      for (int j = 0; j < 3; ++j)
        p.tri.v[j] = m.to_internal[static_cast<std::size_t>(m.input_offset[c] + t.v[j])];
      placed.push_back(p);
    }
  // Along the vertex order, so that neighbours in the list share vertices.
  std::stable_sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return std::min({a.tri.v[0], a.tri.v[1], a.tri.v[2]}) <
           std::min({b.tri.v[0], b.tri.v[1], b.tri.v[2]});
  });
  m.mass.assign(m.to_input.size(), 0);
  m.damping_mass.assign(m.to_input.size(), 0);
  for (const Placed& p : placed) {
    const auto at = [&](int j) { return m.material_points[static_cast<std::size_t>(p.tri.v[j])]; };
    const Vec2<double> a = at(1) - at(0);
    const Vec2<double> b = at(2) - at(0);
    const double det = a[0] * b[1] - a[1] * b[0];
    const Material& material = scene.materials[static_cast<std::size_t>(p.material)];
    m.triangles.push_back(p.tri);
    m.material.push_back(p.material);
    m.area.push_back(det / 2);
    m.inv_rest.push_back({{b[1] / det, -b[0] / det, -a[1] / det, a[0] / det}});
    for (const Index v : p.tri.v) {
      const double share = material.density * det / 6;
      m.mass[static_cast<std::size_t>(v)] += share;
      m.damping_mass[static_cast<std::size_t>(v)] += share * material.damping_mass;
    }
  }
  for (std::size_t i = 0; i < m.mass.size(); ++i) m.damping_mass[i] /= m.mass[i];
  m.cloth_triangle_count = static_cast<Index>(m.triangles.size());
  m.mean_mass =
      std::accumulate(m.mass.begin(), m.mass.end(), 0.0) / static_cast<double>(m.mass.size());
}

void add_obstacles(const Scene& scene, Model& m) {
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    const auto first = m.cloth_vertex_count + static_cast<Index>(m.obstacle_points.size());
    for (const auto& p : scene.obstacles[o].mesh.positions) {
      m.obstacle_points.push_back(p);
      m.obstacle_of_vertex.push_back(static_cast<Index>(o));
    }
    for (const Tri& t : scene.obstacles[o].mesh.triangles)
      m.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
  }
  m.vertex_count = m.cloth_vertex_count + static_cast<Index>(m.obstacle_points.size());
  std::vector<Vec3<double>> placed;
  place_obstacles(scene, m, 0, placed);
  m.positions.insert(m.positions.end(), placed.begin(), placed.end());
  m.velocities.resize(m.positions.size(), Vec3<double>{0, 0, 0});
}

/// One side of an edge: the triangle, and its corner opposite the edge.
struct Side {
  Edge edge;
  Index triangle;
  Index opposite;
  bool forward;  ///< the triangle runs from edge.v[0] to edge.v[1]
};

std::vector<Side> sorted_sides(const Model& m) {
  std::vector<Side> sides;
  sides.reserve(3 * m.triangles.size());
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (int j = 0; j < 3; ++j) {
      const Index a = m.triangles[t].v[j];
      const Index b = m.triangles[t].v[(j + 1) % 3];
      sides.push_back({{{std::min(a, b), std::max(a, b)}},
                       static_cast<Index>(t),
                       m.triangles[t].v[(j + 2) % 3],
                       a < b});
    }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.edge.v[0] != b.edge.v[0] ? a.edge.v[0] < b.edge.v[0] : a.edge.v[1] < b.edge.v[1];
  });
  return sides;
}

void add_hinge(const Scene& scene, Model& m, const Side& p, const Side& q) {
  const Side& front = p.forward ? p : q;
  const Side& back = p.forward ? q : p;
  const auto rest = [&](Index v) { return m.material_points[static_cast<std::size_t>(v)]; };
  const auto area = [&](const Side& s) { return m.area[static_cast<std::size_t>(s.triangle)]; };
  const auto material = [&](const Side& s) -> const Material& {
    return scene
        .materials[static_cast<std::size_t>(m.material[static_cast<std::size_t>(s.triangle)])];
  };
  const double edge_length = length(rest(p.edge.v[1]) - rest(p.edge.v[0]));
  const double bending = (material(p).bending_stiffness + material(q).bending_stiffness) / 2;
  m.hinges.push_back({{p.edge.v[0], p.edge.v[1], front.opposite, back.opposite}});
  m.hinge_stiffness.push_back(hinge_coefficient(bending, edge_length, area(p) + area(q)));
  m.hinge_rest_angle.push_back(0);  // material space is flat
  m.hinge_damping.push_back((material(p).damping_stiffness + material(q).damping_stiffness) / 2);
}

void add_edges_and_hinges(const Scene& scene, Model& m) {
  const std::vector<Side> sides = sorted_sides(m);
  double edge_sum = 0;
  for (std::size_t s = 0; s < sides.size();) {
    std::size_t end = s + 1;
    while (end < sides.size() && sides[end].edge.v[0] == sides[s].edge.v[0] &&
           sides[end].edge.v[1] == sides[s].edge.v[1])
      ++end;
    m.edges.push_back(sides[s].edge);
    if (sides[s].edge.v[0] < m.cloth_vertex_count) {
      m.cloth_edge_count = static_cast<Index>(m.edges.size());
      edge_sum += length(m.material_points[static_cast<std::size_t>(sides[s].edge.v[1])] -
                         m.material_points[static_cast<std::size_t>(sides[s].edge.v[0])]);
      // validate() has refused edges with more than two triangles or with triangles that disagree.
      if (end - s == 2) add_hinge(scene, m, sides[s], sides[s + 1]);
    }
    s = end;
  }
  m.mean_edge = edge_sum / m.cloth_edge_count;
}

void add_pins(const Scene& scene, Model& m) {
  std::vector<std::uint8_t> taken(m.to_input.size(), 0);
  for (std::size_t p = 0; p < scene.pins.size(); ++p)
    for (const Index local : scene.pins[p].vertices) {
      const Index input = m.input_offset[static_cast<std::size_t>(scene.pins[p].cloth)] + local;
      const Index v = m.to_internal[static_cast<std::size_t>(input)];
      if (taken[static_cast<std::size_t>(v)] != 0)
        continue;  // the first pin that names it holds it
      taken[static_cast<std::size_t>(v)] = 1;
      m.pinned.push_back({v, static_cast<Index>(p), m.positions[static_cast<std::size_t>(v)]});
    }
}

}  // namespace

Model make_model(const Scene& scene) {
  validate(scene);
  Model m;
  add_cloth_vertices(scene, m);
  add_cloth_triangles(scene, m);
  add_obstacles(scene, m);
  add_edges_and_hinges(scene, m);
  add_pins(scene, m);
  return m;
}

void place_obstacles(const Scene& scene, const Model& model, double time,
                     std::vector<Vec3<double>>& out) {
  std::vector<Transform> transforms;
  for (const Obstacle& o : scene.obstacles)
    transforms.push_back(o.motion.empty() ? o.transform : transform_at(o.motion, time));
  out.resize(model.obstacle_points.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = apply(transforms[static_cast<std::size_t>(model.obstacle_of_vertex[i])],
                   model.obstacle_points[i]);
}

bool pin_holds(const Pin& pin, double time) {
  return time < pin.release_time;
}

Vec3<double> pinned_position(const Scene& scene, const Model::PinnedVertex& pinned, double time) {
  const Motion& motion = scene.pins[static_cast<std::size_t>(pinned.pin)].motion;
  return motion.empty() ? pinned.initial : apply(transform_at(motion, time), pinned.initial);
}

}  // namespace weft
