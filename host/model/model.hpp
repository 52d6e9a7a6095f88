#pragma once

#include <array>
#include <memory>
#include <vector>

#include "host/geometry/attachment.hpp"
#include "host/model/plate.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/scene.hpp"

namespace weft {

struct StretchLaws;

/// What a scene comes to once it is taken apart: everything that does not change while it runs, in
/// the internal vertex order (cloth along a Morton curve, then obstacle). Double precision; ranks
/// take their own copies in the precision of the run.
struct Model {
  Index cloth_vertex_count = 0;
  Index vertex_count = 0;          ///< cloth and obstacle
  std::vector<Index> to_input;     ///< [cloth vertices] internal -> input number, the lowest
  std::vector<Index> to_internal;  ///< [inputs] input -> internal number; welded ones share theirs
  std::vector<Index> cloth_of_vertex;  ///< [cloth vertices]
  std::vector<Index> input_offset;     ///< [cloths + 1] first input number of each cloth

  std::vector<Vec3<double>> positions;        ///< [vertices] [m] at time 0
  std::vector<Vec3<double>> velocities;       ///< [vertices] [m/s] at time 0, obstacle: zero
  std::vector<Vec2<double>> material_points;  ///< [cloth vertices] [m] rest coordinates
  std::vector<double> mass;                   ///< [cloth vertices] [kg]
  std::vector<double> damping_mass;           ///< [cloth vertices] [1/s]

  std::vector<Tri> triangles;  ///< faces: cloth, then obstacle
  Index cloth_triangle_count = 0;
  std::vector<Mat2<double>> inv_rest;  ///< [cloth triangles] [1/m]
  std::vector<double> area;            ///< [cloth triangles] [m^2]
  std::vector<Index> material;         ///< [cloth triangles]
  std::vector<double> pressure;        ///< [cloth triangles] [Pa]; empty: none anywhere
  std::vector<Index> input_triangle;   ///< [cloth triangles] number over all cloths, as given
  /// [cloth triangles] share of a compression that the material sees, see Store::set_compression();
  /// empty: all of it everywhere
  std::vector<double> compression;
  /// Of the scene's materials; never null in a model that make_model() has made.
  std::shared_ptr<const StretchLaws> laws;

  std::vector<Edge> edges;  ///< cloth, then obstacle
  Index cloth_edge_count = 0;
  /// [cloth edges] 1: material_points of its ends are not its rest length apart, as where panels
  /// meet; empty: no edge is cut
  std::vector<unsigned char> cut;

  std::vector<Tri> input_corners;  ///< [cloth triangles] input numbers, also of welded vertices
  /// [inputs] [m] shape without bending moments, of cloths that have one; empty: none has
  std::vector<Vec3<double>> rest_positions;
  std::vector<unsigned char> shaped;  ///< [cloth triangles] 1: has such a shape; empty: none has
  /// [cloth triangles] [m] corners in material space; none where bending goes by hinges
  std::vector<std::array<Vec2<double>, 3>> rest_corners;

  std::vector<Hinge> hinges;             ///< none where bending goes by plates
  std::vector<double> hinge_stiffness;   ///< [N m] c in W = c (theta - rest)^2
  std::vector<double> hinge_rest_angle;  ///< [rad]
  std::vector<double> hinge_damping;     ///< [s]

  std::vector<Index> obstacle_of_vertex;      ///< [vertices - cloth vertices]
  std::vector<Vec3<double>> obstacle_points;  ///< same, before their transform
  std::vector<Index> obstacle_offset;         ///< [obstacles + 1] first of each in obstacle_points

  /// A vertex whose position is prescribed, with the pin that does it.
  struct PinnedVertex {
    Index vertex;
    Index pin;
    Vec3<double> initial;
    Index place = 0;          ///< in Pin::vertices
    Attachment attachment{};  ///< of a pin to an obstacle; corners count from the first of those
  };
  std::vector<PinnedVertex> pinned;

  /// [cloth vertices] lowest number of those that seams and glue tie together; alone: its own
  std::vector<Index> tied;

  /// [cloth vertices] [m] contact thickness of cloth that starts nearer to something than the
  /// scene's; empty: none does
  std::vector<double> start_thickness;

  std::vector<double> seam_stiffness;  ///< [seam_pairs] [N/m] see seam_stiffness()

  double mean_edge = 0;  ///< [m] of the cloth at rest

  /// What is small is so against all of the scene's cloth: a part of a model has that of the whole.
  struct Whole {
    Index vertices = 0;      ///< of cloth
    double area = 0;         ///< [m^2] at rest
    double mass = 0;         ///< [kg]
    double mass_2_norm = 0;  ///< [kg] root of the sum of its vertices' squared masses
  };
  Whole whole;
};

/// @param welded [seam_pairs] 1 for pairs of seams that are one vertex; empty: none
/// @param before an earlier model of the scene, from which sewing, refinement or remeshing has only
///               changed meshes: its material laws and the places where pins hold on to obstacles
///               are taken over, and the scene is not checked again; null: there is none
/// @throws SceneError if `scene` is not valid
Model make_model(const Scene& scene, const std::vector<unsigned char>& welded = {},
                 const Model* before = nullptr);

/// The cloth's triangles whose corners are all held: these cannot bend.
/// @param fixed [>= cloth vertices] 1: its position is prescribed
/// @return      [cloth triangles] 1 or 0
std::vector<unsigned char> held_triangles(const Model& model,
                                          const std::vector<unsigned char>& fixed);

/// Bending as a plate, over cloth vertices; empty where it goes by hinges.
/// @param held [cloth triangles] see held_triangles()
PlateMatrix make_plate(const Scene& scene, const Model& model,
                       const std::vector<unsigned char>& held);

/// True if the obstacle is not always in one place and of one shape.
bool obstacle_moves(const Obstacle& obstacle);
/// Whether a pin moves by its own motion or the program's, not with an obstacle.
bool pin_moves(const Pin& pin);

/// Run of obstacle vertices, counted from 0 at the first; empty if first == last.
struct VertexRun {
  Index first = 0;
  Index last = 0;
};

/// Positions of obstacle vertices at `time`. Obstacles that never move are only computed if `out`
/// does not have its size yet.
/// @param out [vertices - cloth vertices] [m] empty, or as an earlier call for `model` left it
/// @return    the shortest run that holds all vertices that were computed
VertexRun place_obstacles(const Scene& scene, const Model& model, double time,
                          std::vector<Vec3<double>>& out);

/// True while the pin holds its vertices.
bool pin_holds(const Pin& pin, double time);

/// Where a pinned vertex is held at `time`.
/// @param obstacles [m] as place_obstacles() puts them at `time`
/// @return          [m]
Vec3<double> pinned_position(const Scene& scene, const Model::PinnedVertex& pinned, double time,
                             const std::vector<Vec3<double>>& obstacles);

}  // namespace weft
