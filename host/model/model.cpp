#include "host/model/model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "host/base/buckets.hpp"
#include "host/base/parallel.hpp"
#include "host/geometry/morton.hpp"
#include "host/model/material_points.hpp"
#include "host/model/material_rows.hpp"
#include "host/model/seam_stiffness.hpp"
#include "host/model/start_thickness.hpp"
#include "host/scene/fabric/rigidity.hpp"
#include "host/scene/live_shape.hpp"
#include "host/scene/origin.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/scene/validate.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/hinge.hpp"

namespace weft {
namespace {

void add_cloth_vertices(const Scene& scene, const std::vector<Index>& joined, Model& m) {
  std::vector<Vec3<double>> points;
  std::vector<Vec3<double>> velocities;
  std::vector<Vec2<double>> rest;
  std::vector<Index> cloth;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const Cloth& owner = scene.cloths[c];
    for (const auto& p : owner.mesh.positions) {
      points.push_back(p);
      velocities.push_back(owner.velocity +
                           cross(owner.angular_velocity, p - owner.velocity_origin));
      cloth.push_back(static_cast<Index>(c));
    }
    append_material_points(owner.mesh, rest);
  }
  m.input_offset = input_offsets(scene);
  average_joined(joined, points);
  average_joined(joined, velocities);
  std::vector<Index> single;  // inputs, one of each that are one vertex
  std::vector<Vec3<double>> single_points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (joined[i] != static_cast<Index>(i)) continue;
    single.push_back(static_cast<Index>(i));
    single_points.push_back(points[i]);
  }
  m.cloth_vertex_count = static_cast<Index>(single.size());
  m.to_internal.resize(points.size());
  for (const Index place : morton_order(single_points)) {
    const Index input = single[static_cast<std::size_t>(place)];
    const auto i = static_cast<std::size_t>(input);
    m.to_internal[i] = static_cast<Index>(m.to_input.size());
    m.to_input.push_back(input);
    m.cloth_of_vertex.push_back(cloth[i]);
    m.positions.push_back(points[i]);
    m.velocities.push_back(velocities[i]);
    m.material_points.push_back(rest[i]);
  }
  for (std::size_t i = 0; i < points.size(); ++i)
    m.to_internal[i] = m.to_internal[static_cast<std::size_t>(joined[i])];
}

/// Corners of the cloth's triangles in material space, in the order of Model::triangles.
using RestCorners = std::vector<std::array<Vec2<double>, 3>>;

RestCorners add_cloth_triangles(const Scene& scene, Model& m) {
  std::vector<Index> first{0};  // number of the first triangle of each cloth, and of all
  for (const Cloth& cloth : scene.cloths)
    first.push_back(first.back() + static_cast<Index>(cloth.mesh.triangles.size()));
  const auto count = at(first.back());
  const unsigned threads = setup_threads(count);
  const auto cloth_of = [&](Index number) {
    return static_cast<std::size_t>(std::upper_bound(first.begin(), first.end(), number) -
                                    first.begin() - 1);
  };
  const auto inputs_of = [&](Index number) {
    const std::size_t c = cloth_of(number);
    Tri inputs = scene.cloths[c].mesh.triangles[at(number - first[c])];
    for (Index& v : inputs.v) v += m.input_offset[c];
    return inputs;
  };
  const auto vertex = [&](Index input) { return m.to_internal[at(input)]; };
  std::vector<Index> lowest(count);
  for_each_index(threads, count, [&](std::size_t n) {
    const Tri inputs = inputs_of(static_cast<Index>(n));
    lowest[n] = std::min({vertex(inputs.v[0]), vertex(inputs.v[1]), vertex(inputs.v[2])});
  });
  // Along the vertex order, so that neighbours in the list share vertices.
  m.input_triangle = buckets_by(first.back(), static_cast<Index>(m.to_input.size()), [&](Index i) {
                       return lowest[at(i)];
                     }).item;
  m.triangles.resize(count);
  m.input_corners.resize(count);
  m.material.resize(count);
  m.area.resize(count);
  m.inv_rest.resize(count);
  if (std::any_of(scene.cloths.begin(), scene.cloths.end(),
                  [](const Cloth& cloth) { return cloth.pressure != 0; }))
    m.pressure.resize(count);
  RestCorners rest(count);
  for_each_index(threads, count, [&](std::size_t t) {
    const Index number = m.input_triangle[t];
    const std::size_t c = cloth_of(number);
    const Cloth& cloth = scene.cloths[c];
    const std::size_t own = at(number - first[c]);
    m.input_corners[t] = inputs_of(number);
    for (std::size_t j = 0; j < 3; ++j) m.triangles[t].v[j] = vertex(m.input_corners[t].v[j]);
    m.material[t] = cloth.triangle_material.empty() ? cloth.material : cloth.triangle_material[own];
    if (!m.pressure.empty()) m.pressure[t] = cloth.pressure;
    rest[t] = material_corners(cloth.mesh, own);
    const Vec2<double> a = rest[t][1] - rest[t][0];
    const Vec2<double> b = rest[t][2] - rest[t][0];
    const double det = a[0] * b[1] - a[1] * b[0];
    m.area[t] = det / 2;
    m.inv_rest[t] = {{b[1] / det, -b[0] / det, -a[1] / det, a[0] / det}};
  });
  m.mass.assign(m.to_input.size(), 0);
  m.damping_mass.assign(m.to_input.size(), 0);
  for (std::size_t t = 0; t < count; ++t) {
    const Material& material = scene.materials[at(m.material[t])];
    const double share = material.density * (2 * m.area[t]) / 6;
    for (const Index v : m.triangles[t].v) {
      m.mass[at(v)] += share;
      m.damping_mass[at(v)] += share * material.damping_mass;
    }
  }
  for (std::size_t i = 0; i < m.mass.size(); ++i) m.damping_mass[i] /= m.mass[i];
  m.cloth_triangle_count = static_cast<Index>(m.triangles.size());
  return rest;
}

void add_obstacles(const Scene& scene, Model& m) {
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    m.obstacle_offset.push_back(static_cast<Index>(m.obstacle_points.size()));
    const Index first = m.cloth_vertex_count + m.obstacle_offset.back();
    for (const auto& p : scene.obstacles[o].mesh.positions) {
      m.obstacle_points.push_back(p);
      m.obstacle_of_vertex.push_back(static_cast<Index>(o));
    }
    for (const Tri& t : scene.obstacles[o].mesh.triangles)
      m.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
  }
  m.obstacle_offset.push_back(static_cast<Index>(m.obstacle_points.size()));
  m.vertex_count = m.cloth_vertex_count + m.obstacle_offset.back();
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
  bool forward;   ///< the triangle runs from edge.v[0] to edge.v[1]
  double length;  ///< [m] at rest in this triangle's piece of the pattern; obstacle: 0
  int corner;     ///< of the triangle, at which the edge begins
};

/// Ends of number s % 3 of the sides of triangle s / 3, the lower one first.
std::pair<Index, Index> ends_of(const Model& m, Index s) {
  const Index* v = m.triangles[at(s / 3)].v;
  return std::minmax(v[s % 3], v[(s + 1) % 3]);
}

/// The same side.
Side side_of(const Model& m, const RestCorners& rest, Index s) {
  const std::size_t t = at(s / 3);
  const int j = s % 3;
  const Index* v = m.triangles[t].v;
  const Index a = v[j], b = v[(j + 1) % 3];
  return {{{std::min(a, b), std::max(a, b)}},
          s / 3,
          v[(j + 2) % 3],
          a < b,
          t < rest.size() ? length(rest[t][static_cast<std::size_t>((j + 1) % 3)] -
                                   rest[t][static_cast<std::size_t>(j)])
                          : 0,
          j};
}

/// All sides, by the lower vertex of their edges: ascending by the higher one, then by triangles.
Buckets sorted_sides(const Model& m) {
  const unsigned threads = setup_threads(m.triangles.size());
  Buckets sides = buckets_by(static_cast<Index>(3 * m.triangles.size()), m.vertex_count,
                             [&](Index s) { return ends_of(m, s).first; });
  for_each_index(threads, at(m.vertex_count), [&](std::size_t v) {
    std::sort(sides.begin(static_cast<Index>(v)), sides.end(static_cast<Index>(v)),
              [&](Index a, Index b) {
                const Index high_a = ends_of(m, a).second, high_b = ends_of(m, b).second;
                return high_a != high_b ? high_a < high_b : a < b;
              });
  });
  return sides;
}

void add_rest_positions(const Scene& scene, Model& m) {
  if (std::all_of(scene.cloths.begin(), scene.cloths.end(),
                  [](const Cloth& cloth) { return cloth.rest_positions.empty(); }))
    return;
  std::vector<unsigned char> has_shape;  // by input
  for (const Cloth& cloth : scene.cloths) {
    std::vector<Vec3<double>> shape = cloth.rest_positions;
    shape.resize(cloth.mesh.positions.size());
    m.rest_positions.insert(m.rest_positions.end(), shape.begin(), shape.end());
    has_shape.resize(m.rest_positions.size(), cloth.rest_positions.empty() ? 0 : 1);
  }
  for (const Tri& inputs : m.input_corners)
    m.shaped.push_back(has_shape[static_cast<std::size_t>(inputs.v[0])]);
}

/// Input number of corner j of the triangle of a side, counted from where its edge begins.
Index input_of(const Model& m, const Side& side, int j) {
  return m.input_corners[static_cast<std::size_t>(side.triangle)].v[(side.corner + j) % 3];
}

/// Whether both sides are those of one edge of one cloth, and not joined by a seam.
bool same_piece(const Model& m, const Side& p, const Side& q) {
  return std::minmax({input_of(m, p, 0), input_of(m, p, 1)}) ==
         std::minmax({input_of(m, q, 0), input_of(m, q, 1)});
}

/// Material space is flat, and so are seams.
double rest_angle(const Model& m, const Side& front, const Side& back) {
  if (m.shaped.empty() || m.shaped[static_cast<std::size_t>(front.triangle)] == 0 ||
      !same_piece(m, front, back))
    return 0;
  const Index inputs[4] = {input_of(m, front, 0), input_of(m, front, 1), input_of(m, front, 2),
                           input_of(m, back, 2)};
  Vec3<double> y[4];
  for (int i = 0; i < 4; ++i) y[i] = m.rest_positions[static_cast<std::size_t>(inputs[i])];
  return hinge_angle(y);
}

void add_hinge(const Scene& scene, Model& m, const Side& p, const Side& q) {
  const Side& front = p.forward ? p : q;
  const Side& back = p.forward ? q : p;
  const auto area = [&](const Side& s) { return m.area[static_cast<std::size_t>(s.triangle)]; };
  const auto material = [&](const Side& s) -> const Material& {
    return scene
        .materials[static_cast<std::size_t>(m.material[static_cast<std::size_t>(s.triangle)])];
  };
  // Sides that are sewn together need not be of one length.
  const double edge_length = (p.length + q.length) / 2;
  const double bending =
      (mean_bending_stiffness(material(p)) + mean_bending_stiffness(material(q))) / 2;
  m.hinges.push_back({{p.edge.v[0], p.edge.v[1], front.opposite, back.opposite}});
  m.hinge_stiffness.push_back(hinge_coefficient(bending, edge_length, area(p) + area(q)));
  m.hinge_rest_angle.push_back(rest_angle(m, front, back));
  m.hinge_damping.push_back((material(p).damping_stiffness + material(q).damping_stiffness) / 2);
}

/// By how much of an edge's length at rest its ends may miss it in Model::material_points.
constexpr double cut_share = 1e-3;

/// Whether no triangle at an edge of cloth finds its ends in Model::material_points as at rest.
bool is_cut(const Model& m, const std::vector<Side>& sides) {
  const Index* v = sides.front().edge.v;
  if (m.cloth_of_vertex[at(v[0])] != m.cloth_of_vertex[at(v[1])]) return true;
  const double apart = length(m.material_points[at(v[1])] - m.material_points[at(v[0])]);
  return std::none_of(sides.begin(), sides.end(), [&](const Side& side) {
    return std::abs(apart - side.length) <= cut_share * side.length;
  });
}

/// The hinges of an edge. Where more than two triangles meet, those of one piece bend against each
/// other.
void add_hinges(const Scene& scene, Model& m, const std::vector<Side>& sides) {
  for (std::size_t p = 0; p < sides.size(); ++p)
    for (std::size_t q = p + 1; q < sides.size(); ++q)
      if (sides[p].forward != sides[q].forward && sides[p].opposite != sides[q].opposite &&
          (sides.size() == 2 || same_piece(m, sides[p], sides[q])))
        add_hinge(scene, m, sides[p], sides[q]);
}

void add_edges_and_hinges(const Scene& scene, const RestCorners& rest, Model& m) {
  const Buckets sorted = sorted_sides(m);
  // Calls use() with `sides` set for each edge whose lower vertex is v.
  const auto visit = [&](Index v, std::vector<Side>& sides, const auto& use) {
    for (const Index* s = sorted.begin(v); s != sorted.end(v);) {
      sides.clear();
      const Index high = ends_of(m, *s).second;
      for (; s != sorted.end(v) && ends_of(m, *s).second == high; ++s)
        sides.push_back(side_of(m, rest, *s));
      use();
    }
  };
  const auto vertices = at(m.vertex_count);
  const unsigned threads = setup_threads(m.triangles.size());
  std::vector<Index> first(vertices + 1, 0);  // edge of each lower vertex
  for_each_index(threads, vertices, [&](std::size_t v) {
    Index high = -1;
    const Index* const end = sorted.end(static_cast<Index>(v));
    for (const Index* s = sorted.begin(static_cast<Index>(v)); s != end; ++s)
      if (const Index own = ends_of(m, *s).second; own != high) {
        ++first[v + 1];
        high = own;
      }
  });
  for (std::size_t v = 0; v < vertices; ++v) first[v + 1] += first[v];
  m.cloth_edge_count = first[at(m.cloth_vertex_count)];
  m.edges.resize(at(first.back()));
  m.cut.resize(at(m.cloth_edge_count));
  std::vector<double> edge_length(at(m.cloth_edge_count));
  on_threads(threads, [&](unsigned n) {
    std::vector<Side> sides;
    const auto begin = static_cast<Index>(vertices * n / threads);
    const auto end = static_cast<Index>(vertices * (n + 1) / threads);
    auto e = at(first[at(begin)]);
    for (Index v = begin; v < end; ++v)
      visit(v, sides, [&] {
        m.edges[e] = sides.front().edge;
        if (v < m.cloth_vertex_count) {
          m.cut[e] = is_cut(m, sides) ? 1 : 0;
          edge_length[e] = sides.front().length;
        }
        ++e;
      });
  });
  m.mean_edge = std::accumulate(edge_length.begin(), edge_length.end(), 0.0) / m.cloth_edge_count;
  if (std::find(m.cut.begin(), m.cut.end(), 1) == m.cut.end()) m.cut.clear();
  if (scene.bending != Bending::hinge) return;
  std::vector<Side> sides;
  for (Index v = 0; v < m.cloth_vertex_count; ++v)
    visit(v, sides, [&] { add_hinges(scene, m, sides); });
}

/// Pins and places of vertices that hold on to obstacles, with where they do.
using KnownAttachments = std::map<std::tuple<Index, double, double, double>, Attachment>;

std::tuple<Index, double, double, double> place_of(const Model::PinnedVertex& v) {
  return {v.pin, v.initial[0], v.initial[1], v.initial[2]};
}

KnownAttachments attachments_of(const Scene& scene, const Model* model) {
  KnownAttachments known;
  if (model == nullptr) return known;
  for (const Model::PinnedVertex& v : model->pinned)
    if (scene.pins[static_cast<std::size_t>(v.pin)].obstacle >= 0)
      known.emplace(place_of(v), v.attachment);
  return known;
}

/// Binds the pinned vertices whose pins follow an obstacle to its surface at time 0.
/// @param before has been bound to the same surfaces; null: none
void attach_pins(const Scene& scene, const Model* before, Model& m) {
  const KnownAttachments known = attachments_of(scene, before);
  const std::vector<Vec3<double>> placed(m.positions.begin() + m.cloth_vertex_count,
                                         m.positions.end());
  for (std::size_t p = 0; p < scene.pins.size(); ++p) {
    if (scene.pins[p].obstacle < 0) continue;
    std::vector<std::size_t> held;
    std::vector<Vec3<double>> points;
    for (std::size_t i = 0; i < m.pinned.size(); ++i) {
      if (m.pinned[i].pin != static_cast<Index>(p)) continue;
      if (const auto found = known.find(place_of(m.pinned[i])); found != known.end()) {
        m.pinned[i].attachment = found->second;
        continue;
      }
      held.push_back(i);
      points.push_back(m.pinned[i].initial);
    }
    if (held.empty()) continue;
    const auto o = static_cast<std::size_t>(scene.pins[p].obstacle);
    std::vector<Tri> surface = scene.obstacles[o].mesh.triangles;
    for (Tri& t : surface)
      for (Index& v : t.v) v += m.obstacle_offset[o];
    const std::vector<Attachment> found = attach(points, surface, placed);
    for (std::size_t i = 0; i < held.size(); ++i) m.pinned[held[i]].attachment = found[i];
  }
}

void add_pins(const Scene& scene, const Model* before, Model& m) {
  std::vector<std::uint8_t> taken(m.to_input.size(), 0);
  for (std::size_t p = 0; p < scene.pins.size(); ++p)
    for (std::size_t place = 0; place < scene.pins[p].vertices.size(); ++place) {
      const Index local = scene.pins[p].vertices[place];
      const Index input = m.input_offset[static_cast<std::size_t>(scene.pins[p].cloth)] + local;
      const Index v = m.to_internal[static_cast<std::size_t>(input)];
      if (taken[static_cast<std::size_t>(v)] != 0)
        continue;  // the first pin that names it holds it
      taken[static_cast<std::size_t>(v)] = 1;
      const Mesh& mesh = scene.cloths[static_cast<std::size_t>(scene.pins[p].cloth)].mesh;
      m.pinned.push_back({v, static_cast<Index>(p), mesh.positions[static_cast<std::size_t>(local)],
                          static_cast<Index>(place)});
    }
  attach_pins(scene, before, m);
}

/// Vertices that seams and glue tie to each other.
void add_ties(const Scene& scene, Model& m) {
  std::vector<SeamPair> pairs = seam_pairs(scene);
  for (const Handle& handle : scene.handles) {
    if (handle.shape != Handle::Shape::glue) continue;
    const Index first = m.input_offset[static_cast<std::size_t>(handle.cloth)];
    pairs.push_back({{first + handle.vertices[0], first + handle.vertices[1]}, 0});
  }
  for (SeamPair& pair : pairs)
    for (Index& v : pair.v) v = m.to_internal[static_cast<std::size_t>(v)];
  m.tied = grouped(m.to_input.size(), pairs);
}

/// Gives each vertex the least of what its inputs have in a model of the same meshes.
void take_start_thickness(const Scene& scene, const std::vector<double>& thickness,
                          const Model& from, Model& m) {
  if (thickness.empty()) return;
  m.start_thickness.assign(m.to_input.size(), contact_thickness(scene.contact));
  for (std::size_t i = 0; i < m.to_internal.size(); ++i) {
    double& own = m.start_thickness[static_cast<std::size_t>(m.to_internal[i])];
    own = std::min(own, thickness[static_cast<std::size_t>(from.to_internal[i])]);
  }
}

/// Sets Model::start_thickness, which the asynchronous method does not know. It does not depend on
/// what is welded: vertices that a run sews start apart, and not at their mean place.
void add_start_thickness(const Scene& scene, const Model* before, Model& m) {
  if (scene.method == "asynchronous") return;
  // Without remeshing, meshes of as many vertices are the same.
  if (before != nullptr && !remeshes(scene) && before->input_offset == m.input_offset)
    return take_start_thickness(scene, before->start_thickness, *before, m);
  if (m.to_input.size() == m.to_internal.size()) {
    m.start_thickness = start_thickness(scene, m);
    return;
  }
  Model apart;
  add_cloth_vertices(scene, joined_inputs(scene, {}), apart);
  const RestCorners rest = add_cloth_triangles(scene, apart);
  add_obstacles(scene, apart);
  add_edges_and_hinges(scene, rest, apart);
  add_ties(scene, apart);
  take_start_thickness(scene, start_thickness(scene, apart), apart, m);
}

Model::Whole whole_of(const Model& m) {
  double mass_sq = 0;
  for (const double mass : m.mass) mass_sq += mass * mass;
  return {m.cloth_vertex_count, std::accumulate(m.area.begin(), m.area.end(), 0.0),
          std::accumulate(m.mass.begin(), m.mass.end(), 0.0), std::sqrt(mass_sq)};
}

}  // namespace

Model make_model(const Scene& scene, const std::vector<unsigned char>& welded,
                 const Model* before) {
  if (before != nullptr)
    validate_total(scene);
  else
    validate(scene);
  Model m;
  add_cloth_vertices(scene, joined_inputs(scene, welded), m);
  RestCorners rest = add_cloth_triangles(scene, m);
  m.laws =
      before != nullptr ? before->laws : std::make_shared<const StretchLaws>(stretch_laws(scene));
  add_obstacles(scene, m);
  add_rest_positions(scene, m);
  add_edges_and_hinges(scene, rest, m);
  if (scene.bending == Bending::plate) m.rest_corners = std::move(rest);
  add_pins(scene, before, m);
  add_ties(scene, m);
  add_start_thickness(scene, before, m);
  m.seam_stiffness = seam_stiffness(scene);
  m.whole = whole_of(m);
  return m;
}

std::vector<unsigned char> held_triangles(const Model& model,
                                          const std::vector<unsigned char>& fixed) {
  std::vector<unsigned char> held;
  for (Index t = 0; t < model.cloth_triangle_count; ++t) {
    const Index* v = model.triangles[static_cast<std::size_t>(t)].v;
    held.push_back(std::all_of(
        v, v + 3, [&](Index corner) { return fixed[static_cast<std::size_t>(corner)] != 0; }));
  }
  return held;
}

PlateMatrix make_plate(const Scene& scene, const Model& model,
                       const std::vector<unsigned char>& held) {
  if (scene.bending != Bending::plate) return {};
  std::vector<Mat3<double>> rigidity;
  for (const Material& material : scene.materials) rigidity.push_back(bending_rigidity(material));
  std::vector<std::array<Vec3<double>, 3>> shapes(model.shaped.size());
  std::vector<PlateTriangle> triangles(model.rest_corners.size());
  for_each_index(setup_threads(triangles.size()), triangles.size(), [&](std::size_t t) {
    const auto material = static_cast<std::size_t>(model.material[t]);
    const Tri& source = model.input_corners[t];
    PlateTriangle triangle{model.triangles[t],
                           model.rest_corners[t],
                           &rigidity[material],
                           scene.materials[material].damping_stiffness,
                           held[t] != 0,
                           nullptr,
                           source};
    if (!model.shaped.empty() && model.shaped[t] != 0) {
      for (std::size_t j = 0; j < 3; ++j) shapes[t][j] = model.rest_positions[at(source.v[j])];
      triangle.shape = &shapes[t];
    }
    triangles[t] = triangle;
  });
  return make_plate_matrix(model.cloth_vertex_count, triangles);
}

bool obstacle_moves(const Obstacle& obstacle) {
  return obstacle.deformation || !obstacle.motion.empty();
}

bool pin_moves(const Pin& pin) {
  return pin.live || !pin.motion.empty();
}

VertexRun place_obstacles(const Scene& scene, const Model& model, double time,
                          std::vector<Vec3<double>>& out) {
  const bool all = out.size() != model.obstacle_points.size();
  if (all) out = model.obstacle_points;
  VertexRun run;
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    const Obstacle& obstacle = scene.obstacles[o];
    if (!all && !obstacle_moves(obstacle)) continue;
    const Index first = model.obstacle_offset[o];
    const Index last = model.obstacle_offset[o + 1];
    const auto begin = static_cast<std::size_t>(first);
    const auto end = static_cast<std::size_t>(last);
    const Transform transform =
        obstacle.motion.empty() ? obstacle.transform : transform_at(obstacle.motion, time);
    if (obstacle.deformation) {
      obstacle.deformation->positions(time, Span<Vec3<double>>(out.data() + begin, end - begin));
      for (std::size_t i = begin; i < end; ++i) out[i] = apply(transform, out[i]);
    } else {
      for (std::size_t i = begin; i < end; ++i) out[i] = apply(transform, model.obstacle_points[i]);
    }
    if (run.first == run.last) run.first = first;
    run.last = last;
  }
  return run;
}

bool pin_holds(const Pin& pin, double time) {
  return time < pin.release_time;
}

Vec3<double> pinned_position(const Scene& scene, const Model::PinnedVertex& pinned, double time,
                             const std::vector<Vec3<double>>& obstacles) {
  const Pin& pin = scene.pins[static_cast<std::size_t>(pinned.pin)];
  if (pin.obstacle >= 0) return attached_position(pinned.attachment, obstacles);
  if (pin.live)
    return pin.live->at(time, static_cast<std::size_t>(pinned.place)) - origin_of(scene);
  return pin.motion.empty()
             ? pinned.initial
             : apply_in_world(transform_at(pin.motion, time), pinned.initial, origin_of(scene));
}

}  // namespace weft
