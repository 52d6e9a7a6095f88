#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/garment_start.hpp"

/// A scene as the simulation uses it: all files are read, all defaults filled in. SI units, z up.
/// weft::io reads scenes from JSON; a program that embeds weft may fill the structs itself.
namespace weft {

/// Marks a scene and its copies, so that an Id of another scene is refused.
class SceneIdentity {
 public:
  SceneIdentity();
  std::uint64_t number() const { return number_; }

 private:
  std::uint64_t number_;
};

/// A part that Scene::add() or Scene::pin() has added. It belongs to that scene and its copies, and
/// counts as the number of the part in their lists: removing a part from a list gives the numbers
/// of those behind it to others. As the plain number that structs such as Cloth hold, it no longer
/// knows its scene.
template <class Part>
struct Id {
  Index index = -1;
  std::uint64_t scene = 0;  ///< SceneIdentity::number()

  operator Index() const { return index; }
};

/// Triangle mesh. Corners are counter-clockwise seen from the front.
struct Mesh {
  std::vector<Vec3<double>> positions;  ///< [m] world space
  std::vector<Vec2<double>> material;   ///< [m] material coordinates; empty: none
  std::vector<Tri> triangles;           ///< corners in `positions`
  /// [triangles] corners in `material`, for patterns whose panels meet in seams; empty: as
  /// `triangles`
  std::vector<Tri> material_triangles{};
  std::vector<Index> group{};              ///< [triangles] into group_names; empty: no groups
  std::vector<std::string> group_names{};  ///< names of face groups, as in the file
  /// [triangles] into part_names: parts by name where `group` tells materials apart; empty: as
  /// `group`
  std::vector<Index> part{};
  std::vector<std::string> part_names{};
  /// [part_names] what a sewing pattern calls the part of the body that a panel is for, such as
  /// "arm" or "leg"; empty: it says nothing
  std::vector<std::string> part_labels{};
  /// [triangles] into object_names: objects of the file where `group` says something else; empty:
  /// as `group`
  std::vector<Index> object{};
  std::vector<std::string> object_names{};
};

/// Placement: x -> rotate(scale * x) + translate.
struct Transform {
  Vec3<double> translate{0, 0, 0};      ///< [m]
  Vec3<double> rotation_axis{0, 0, 1};  ///< unit
  double rotation_angle = 0;            ///< [rad]
  double scale = 1;
};

/// How something goes from one key or frame to the next.
enum class Interpolation {
  linear,  ///< at constant velocity, which jumps there
  /// Cubic Hermite with Catmull-Rom slopes, each coordinate's slope limited so that it never leaves
  /// the interval between the two: velocities are continuous, and a coordinate that is the same in
  /// both stays so between them.
  cubic,
};

/// Placement at one time. A motion is a list of at least two of these in increasing time, between
/// which the placement is interpolated. Cubic slopes are zero at both ends. Before the first and
/// after the last key the placement is constant.
struct Keyframe {
  double time = 0;  ///< [s]
  Transform transform;
  Interpolation interpolation = Interpolation::cubic;  ///< to the next key
};
using Motion = std::vector<Keyframe>;

/// Resistance to stretching of a sheet whose warp and weft differ. Warp is the direction of the
/// first material coordinate, weft that of the second.
struct OrthotropicStretch {
  double warp = 1000;          ///< [N/m] Young's modulus times thickness, > 0
  double weft = 1000;          ///< [N/m] the same along the weft, > 0
  double poisson_ratio = 0.3;  ///< contraction along the weft over stretch along the warp
  double shear = 400;          ///< [N/m] shear modulus times thickness, > 0
};

/// Plate stiffness of a sheet whose warp and weft differ. With the curvatures k11 along the warp,
/// k22 along the weft and the twist k12, the energy per area is
///   warp / 2 k11^2 + weft / 2 k22^2 + coupling k11 k22 + 2 twist k12^2
struct OrthotropicBending {
  double warp = 1e-5;      ///< [N m] D11, >= 0
  double weft = 1e-5;      ///< [N m] D22, >= 0
  double coupling = 3e-6;  ///< [N m] D12; its square is at most warp weft
  double twist = 3.5e-6;   ///< [N m] D66, >= 0
};

/// Measured stretching: stress = 2 (c11, c12; c12, c22; c33) strain, with coefficients that depend
/// on the strain (Wang, O'Brien and Ramamoorthi 2011).
struct MeasuredStretch {
  enum class Form {
    energy,  ///< a convex energy fitted to the tables; recommended
    arcsim,  ///< the tables as ARCSim evaluates them, a stress without an energy
  };
  Form form = Form::energy;
  /// [N/m] c11, c12, c22, c33: at small strain; then at 1/6 of stretch along 0, 22.5, 45, 67.5 and
  /// 90 degrees from the warp. c11 and c22 of the first are > 0.
  std::array<std::array<double, 4>, 6> rows{};
};

/// Limits of the principal stretches. Near them the sheet stiffens, whatever its material law.
struct StrainLimits {
  double min = 0;                                        ///< [0, 1); 0: none
  double max = std::numeric_limits<double>::infinity();  ///< > 1
};

/// Thin sheet: isotropic, unless an optional member replaces the isotropic stiffness.
struct Material {
  std::string name;
  double density = 0.2;                             ///< [kg/m^2] mass per area, > 0
  double stretch_stiffness = 1000;                  ///< [N/m] Young's modulus times thickness, > 0
  double poisson_ratio = 0.3;                       ///< (-1, 0.5]
  double bending_stiffness = 1e-5;                  ///< [N m] plate stiffness, >= 0
  double damping_mass = 0;                          ///< [1/s] Rayleigh, force -a M v, >= 0
  double damping_stiffness = 0;                     ///< [s] Rayleigh, force -b K v, >= 0
  std::optional<OrthotropicStretch> orthotropic{};  ///< instead of stretch_stiffness
  std::optional<MeasuredStretch> measured{};        ///< instead of stretch_stiffness
  std::optional<OrthotropicBending> orthotropic_bending{};  ///< instead of bending_stiffness
  std::optional<StrainLimits> strain_limits{};
};

/// Resolution of an adaptive cloth (Narain, Samii and O'Brien 2012), with the names of ARCSim. An
/// edge is too long if the normal turns by more than refine_angle along it, if the velocity changes
/// by more than refine_velocity, or if it would buckle under the local compression, weighted by
/// refine_compression.
struct Remeshing {
  double size_min = 0;                ///< [m] >= 0; 0: both sizes come from the mesh
  double size_max = 0;                ///< [m] >= size_min
  double refine_angle = 0.3;          ///< [rad] > 0, infinity: not used
  double refine_compression = 0.005;  ///< [m] > 0, infinity: not used
  double refine_velocity = 0.5;       ///< [m/s] > 0, infinity: not used
  double aspect_min = 0.2;            ///< [0, 1) smallest aspect ratio of a triangle; 1: regular
};

/// Settings for all adaptive cloths.
struct AdaptiveSettings {
  Remeshing remeshing;           ///< of cloths that have none
  double flip_threshold = 0.01;  ///< flip an edge only if it improves by this much, >= 0
  /// Estimated energy that all flips and collapses of one remesh may add or remove, as a share of
  /// the largest kinetic energy at the end of a frame so far; >= 0, infinity: no limit.
  double energy_share = 0.002;
};

struct Cloth {
  std::string name{};
  Mesh mesh;           ///< initial world positions; material coordinates set the rest shape
  Index material = 0;  ///< into Scene::materials; if that is empty, "cotton_polyester"
  std::vector<Index> triangle_material{};  ///< [triangles] as `material`; empty: `material` for all
  /// [vertices] [m] the curved rest shape, which has no bending moments; empty: flat. Lengths at
  /// rest always come from the material coordinates.
  std::vector<Vec3<double>> rest_positions{};
  double pressure = 0;                     ///< [Pa] pushes along the triangles' normals
  Vec3<double> velocity{0, 0, 0};          ///< [m/s] initial
  Vec3<double> angular_velocity{0, 0, 0};  ///< [rad/s] initial, about `velocity_origin`
  Vec3<double> velocity_origin{0, 0, 0};   ///< [m]
  std::optional<Remeshing> remeshing{};    ///< instead of Scene::adaptive's
};

/// Shape of a surface over time: a skinned body, a motion capture, a sequence of meshes.
class Deformation {
 public:
  virtual ~Deformation() = default;

  /// Positions of the vertices at `time`, before the obstacle's transform or motion. Before the
  /// first and after the last known time, the shape is constant. Thread-safe.
  /// @param time [s]
  /// @param out  [vertices] [m]
  virtual void positions(double time, Span<Vec3<double>> out) const = 0;

  /// [s] Last known time. Until then, a run that waits for rest goes on.
  virtual double last_time() const { return 0; }

  /// Checksum of everything that positions() depends on. A checkpoint with another one is refused.
  virtual std::uint64_t checksum() const = 0;
};

/// An obstacle that turns about a fixed axis. Its angle is an unknown: a torque, contacts and
/// pinned cloth turn it.
struct DrivenBody {
  Vec3<double> origin{0, 0, 0};  ///< [m] a point of the axis
  Vec3<double> axis{0, 0, 1};    ///< unit
  double inertia = 0;            ///< [kg m^2] about the axis, > 0
  double torque = 0;             ///< [N m] about the axis, from start_time to end_time
  double start_time = 0;         ///< [s]
  double end_time = std::numeric_limits<double>::infinity();  ///< [s]
};

/// Surface with prescribed motion and infinite mass, or a driven body. Contact between obstacles,
/// and of an obstacle with itself, is ignored.
struct Obstacle {
  std::string name{};
  Mesh mesh;              ///< before `transform`; with a deformation: its shape at time 0
  Transform transform{};  ///< placement if there is no motion
  Motion motion{};        ///< replaces `transform`; empty: static
  std::shared_ptr<const Deformation> deformation{};  ///< of `mesh`; null: rigid
  /// Starts at `transform`. Not with a motion or a deformation; method asynchronous only.
  std::optional<DrivenBody> driven{};
  /// The program moves the vertices, see Simulation::move(). Starts at `transform`. Not with a
  /// motion, a deformation or a driven body.
  bool live = false;
  double friction = 0.3;  ///< Coulomb coefficient against cloth, >= 0
};

/// An obstacle whose vertices the program moves.
struct LiveObstacle : Obstacle {
  /// @param shape at the start, in world places
  explicit LiveObstacle(Mesh shape) {
    mesh = std::move(shape);
    live = true;
  }
};

class LiveShape;

/// Vertices held in place, or moved by a motion (applied to their initial positions) or by the
/// program, see Simulation::move().
struct Pin {
  Index cloth = 0;              ///< into Scene::cloths
  std::vector<Index> vertices;  ///< numbers within that cloth, in input order
  Motion motion;                ///< empty: held where they start
  /// Into Scene::obstacles: each vertex follows the part of that surface that is nearest to it at
  /// time 0. -1: none. Not together with `motion`.
  Index obstacle = -1;
  double release_time = std::numeric_limits<double>::infinity();  ///< [s]
  std::shared_ptr<const LiveShape> live{};  ///< made by the simulation once a program moves the pin
};

using MaterialId = Id<Material>;
using ClothId = Id<Cloth>;
using ObstacleId = Id<Obstacle>;
using PinId = Id<Pin>;

/// The vertices of the triangles in a group of a mesh.
struct VertexGroup {
  std::string name;  ///< in Mesh::group_names or Mesh::part_names
};
inline VertexGroup group(std::string name) {
  return {std::move(name)};
}

/// Springs that tie vertices to moving targets, for a limited time.
struct Handle {
  enum class Shape {
    points,  ///< to their own initial positions, moved by `motion`
    circle,  ///< to a circle, moved by `motion`, that the cloth is wound around
    glue,    ///< two vertices to each other
  };
  Shape shape = Shape::points;
  Index cloth = 0;              ///< into Scene::cloths
  std::vector<Index> vertices;  ///< numbers within that cloth, in input order
  Motion motion;                ///< empty: at rest
  Vec3<double> along{0, 0, 0};  ///< springs pull along it only, not of glue; 0: in all directions
  double stiffness = 1000;      ///< [N/m] per vertex, > 0
  double start_time = 0;        ///< [s]
  double end_time = std::numeric_limits<double>::infinity();  ///< [s]
  double fade_time = 0;          ///< [s] after end_time, over which the springs fade
  double circumference = 0;      ///< [m] circle: length of cloth once around, > 0
  Vec2<double> direction{1, 0};  ///< circle: direction in material space in which cloth winds
  Vec3<double> center{0, 0, 0};  ///< [m] circle
  /// circle: towards angles 0 and 90 degrees; its radius is circumference / 2 pi times their length
  Vec3<double> axis0{1, 0, 0}, axis1{0, 1, 0};
  /// Part of an obstacle's surface that carries the places and `along`: by the similarity that is
  /// nearest to the motion of these vertices.
  struct Carrier {
    Index obstacle = -1;              ///< into Scene::obstacles; -1: none
    std::vector<Index> vertices;      ///< numbers within its mesh, at least three
    std::vector<Vec3<double>> start;  ///< [vertices] [m] where they are at time 0
  };
  Carrier carrier{};  ///< not of glue
};

/// Two chains of vertices that are sewn together pair by pair (P-Cloth section 5.1). Zero-length
/// springs grow stiffer until a pair is close enough to become one vertex.
struct Seam {
  Index cloths[2] = {0, 0};        ///< into Scene::cloths
  std::vector<Index> vertices[2];  ///< of equal length; numbers within the cloth, in input order
  /// [N/m] per pair, > 0; empty: 1e5 N/m^2 times the length of seam that a pair stands for, and
  /// 1000 N/m for a pair without neighbours
  std::optional<double> stiffness{};
  double start_time = 0;   ///< [s]
  double ramp_time = 0.5;  ///< [s] until the stiffness is reached; it grows with time cubed
  /// [m] pairs closer than this become one vertex; 0: never; empty: as the contact thickness.
  std::optional<double> weld_distance{};
  bool may_stay_open = false;  ///< open pairs at the end are no failure; see SeamState
};

/// Uniform refinement: each triangle is split into four, `levels` times, on the rest shape.
struct Refinement {
  enum class When {
    never,
    sewn,  ///< once every pair of every seam is one vertex
  };
  When when = When::never;
  int levels = 1;  ///< each triangle becomes 4^levels, 1 to 6
};

/// Moving air.
struct Wind {
  double density = 0;              ///< [kg/m^3] of the air; 0: no wind stage
  Vec3<double> velocity{0, 0, 0};  ///< [m/s]
  double drag = 0;                 ///< tangential drag [kg/(m^2 s)], >= 0
};

/// Viewpoint at one time.
struct CameraKey {
  double time = 0;                 ///< [s]
  Vec3<double> position{0, 0, 0};  ///< [m]
  Vec3<double> look_at{0, 0, 0};   ///< [m]
  Vec3<double> up{0, 0, 1};
  double field_of_view = 0.7;  ///< [rad] vertical
  bool jump = false;           ///< a cut: no interpolation from the previous key
};

/// Without keys, the camera is placed automatically so that it shows the whole scene.
struct Camera {
  std::vector<CameraKey> keys;  ///< in increasing time; one: a camera at rest
  int width = 960;              ///< [pixels]
  int height = 720;             ///< [pixels]
};

/// How cloth out of view, too coarse to fold, resists compression.
enum class BucklingCompensation {
  none,  ///< resists compression fully
  full,  ///< does not resist compression at all
  area,  ///< larger triangles resist less
};

/// Settings of the method "view" (Koh, Narain and O'Brien 2015): cloth that the camera does not see
/// is coarser.
struct ViewSettings {
  double factor_back = 0.2;         ///< (0, 1] view factor of triangles that face away
  double factor_out = 0.01;         ///< (0, 1] of triangles out of view by more than the margin
  double margin = 0.4;              ///< [m] >= 0, over which the factor falls
  double anticipation = 5;          ///< [frames] 0 to 1000: future views that count; 0: none
  double transfer_threshold = 0.1;  ///< [0, 1] larger differences between neighbours are smoothed
  double pixel_min = 4;            ///< [pixels] >= 0, edges shorter than this are not split; 0: any
  bool two_sided = false;          ///< backs of cloths count as fronts
  bool occlusion = false;          ///< hidden cloth counts as out of view
  bool predict_obstacles = false;  ///< `anticipation` moves cloth with the nearest obstacle
  BucklingCompensation compensation = BucklingCompensation::area;
  double compensation_power = 10;  ///< >= 1
};

struct ContactSettings {
  bool self = true;  ///< cloth against cloth, itself included
  /// Skips the search for pairs of cloth with cloth in steps with a proof that none comes near.
  /// On the host, not with the method asynchronous. Changes no bits.
  bool self_certificate = true;
  bool untangle = false;  ///< resolve intersections at the start; false: refuse them
  /// [m] distance at which repulsion starts, > 0. Empty: 1 mm, or a quarter of the mean edge of
  /// finer cloths.
  std::optional<double> thickness{};
  double friction = 0.3;       ///< Coulomb coefficient, cloth against cloth, >= 0
  double stiffness = 10;       ///< repulsion in units of pair mass / time_step^2, > 0
  int zone_rounds = 60;        ///< rounds of CCD and impact zones per step before a retry
  int substep_bisections = 5;  ///< how often a failing step may be bisected
  /// [m] by which obstacles and pinned vertices may miss their targets if they pinch cloth. A step
  /// that needs more fails. 0: they never give way. Infinite: without limit. Empty: by two
  /// thicknesses, and only if nothing else helps.
  std::optional<double> compliance_distance{};
};

/// [m] thickness; 1 mm where it is empty and no Simulation has filled it in.
inline double contact_thickness(const ContactSettings& contact) {
  return contact.thickness.value_or(1e-3);
}

/// [m] by which obstacles and pinned vertices may miss their targets unless an obstacle says
/// otherwise: two thicknesses by default.
inline double compliance_distance(const ContactSettings& contact) {
  return contact.compliance_distance.value_or(2 * contact_thickness(contact));
}

/// Formula for the bending of cloth.
enum class Bending {
  hinge,  ///< angles between triangles (Grinspun et al. 2003); its stiffness depends on the mesh
  plate,  ///< quadratic plate energy that converges on any mesh, with Poisson's ratio
};

enum class Integrator { implicit_euler, bdf2 };
enum class Precision { single_precision, double_precision };

/// Preconditioner of conjugate gradients.
enum class Preconditioner {
  block_jacobi,
  multilevel,  ///< block Jacobi and two levels of aggregates that translate
};

/// How the ranks of a linear solve read each other's results. Changes no bits.
enum class Transport {
  automatic,  ///< peer, or pipelined if GPUs cannot access each other's memory
  peer,       ///< one kernel per GPU, which accesses the memory of the other GPUs
  pipelined,  ///< copies issued by the host, by work queues (P-Cloth section 3.1)
};

/// When ranks redistribute their work, by counted work. Changes no bits.
enum class Rebalance {
  when_it_pays,  ///< rows once imbalance has cost as much as moving them; pairs in each search
  never,         ///< rows by number, pairs by the contents of the grid cells
  every_step,    ///< rows before each step, at any cost
};

struct SolverSettings {
  /// True residual over the initial one, in two norms, see SolvePcg; (0, 1).
  double tolerance = 1e-2;
  int max_iterations = 2000;  ///< per linear solve, >= 1
  Preconditioner preconditioner = Preconditioner::multilevel;
  /// 1: linearly implicit, equation (3) of P-Cloth; more: Newton's method; 0: linearly implicit,
  /// and Newton's method for steps in which cloth stretches and turns too far for that
  int newton_iterations = 0;
  /// Newton stops earlier once the non-linear residual is below this share of the first.
  double newton_tolerance = 1e-6;
  bool line_search = true;  ///< of Newton's method
  /// Rows per reduction block of a dot product, a power of two; 0: from the row count. At most
  /// 1,024, with block_jacobi 512, in a linear solve.
  int partial_rows = 0;
  Transport transport = Transport::automatic;
  Rebalance rebalance = Rebalance::when_it_pays;
};

/// Settings of the method "implicit"; sleep exists on the host only. A component of cloth falls
/// asleep, together with everything that it touches, under two conditions. At its present velocity
/// and acceleration it would move less than `sleep_distance` until the end of the run, and nothing
/// is near. Steps skip it until something comes near or pulls at it.
struct ImplicitSettings {
  double sleep_distance = 0;  ///< [m] >= 0; 0: everything is simulated
  double sleep_window = 0.2;  ///< [s] > 0, time over which motion is measured
};

/// How the asynchronous method decides whether a candidate comes close.
enum class NarrowPhase {
  slabs,  ///< separating slabs in space and time, continuous detection where they fail
  ccd,    ///< continuous detection alone, for comparison
};

/// Settings of the method "asynchronous" (Ainsley et al. 2012). Penalty layer l = 1, 2, ... has the
/// thickness contact.thickness l^(-1/4) and the stiffness `stiffness` l^3. Neither windows nor the
/// narrow phase change results.
struct AsynchronousSettings {
  double window = 0.003;  ///< [s] > 0; windows are shortened so that steps are hit exactly
  NarrowPhase narrow = NarrowPhase::slabs;
  bool optimistic = true;       ///< begin a window on free threads while the last one is checked
  double stiffness = 1000;      ///< [N/m] of the first layer, > 0
  double restitution = 0;       ///< [0, 1] of the velocity of impacts
  int layers = 1000;            ///< maximum per pair; a run that needs more fails
  int rollbacks = 1000;         ///< maximum per window; a run that needs more fails
  double smallest_step = 1e-9;  ///< [s] > 0, of any force; a run that needs a shorter one fails
};

/// How a run is divided into slices of time (Liang & Lin 2018, section 4).
enum class TimeSchedule {
  uniform,   ///< slices of equal length
  balanced,  ///< later slices are shorter, so that all end together, for a given ratio
  adaptive,  ///< the same, for the ratio that is counted during the run
};

/// Settings of the method "time_parallel" (Liang & Lin 2018): a coarse run predicts the state at
/// the start of each slice of time, and the slices run in parallel.
struct TimeParallelSettings {
  std::string method = "implicit";  ///< of the slices: "implicit", "adaptive" or "view"
  TimeSchedule schedule = TimeSchedule::adaptive;
  int slices = 0;      ///< 0: one per worker
  double ratio = 100;  ///< cost of the fine run over the coarse run, for `balanced`, > 1
  /// Edge length of the coarse mesh over that of the fine mesh; if slices remesh, over the
  /// shortest edge that remeshing allows. > 1
  double coarsening = 5;
  /// Whether the coarse run remeshes; its smallest edges are `coarsening` times those of the fine
  /// one.
  bool coarse_adaptive = false;
  double coarse_step = 0.02;    ///< [s] >= TimeSettings::step
  double coarse_thickness = 1;  ///< contact thickness of the coarse run over the fine one, >= 1
  Integrator coarse_integrator = Integrator::implicit_euler;
  int coarse_newton_iterations = 2;  ///< SolverSettings::newton_iterations of the coarse run, >= 1
  double coarse_newton_tolerance = 0.1;  ///< the same for newton_tolerance, (0, 1)
  /// The same for SolverSettings::tolerance, unless the scene's is looser; (0, 1).
  double coarse_tolerance = 0.01;
  /// Iterations of recovery: this times sqrt(density / stiffness) / step; >= 0.
  double recovery_factor = 10;
  int recovery_iterations = -1;  ///< replaces that number; -1: use the formula
  /// Recovery ends once an iteration moves 99 % of the vertices by less than this times the size
  /// of the cloths.
  double recovery_tolerance = 1e-3;
  double boundary_tolerance = 2;  ///< jump at a slice boundary over largest change per frame, > 0
  int blend_frames = 0;  ///< frames after a slice boundary over which a larger jump is spread
};

/// When a run of `weft run` ends.
enum class RunUntil {
  frames,  ///< after TimeSettings::frames
  rest,    ///< once the cloth rests, see RestState, and after TimeSettings::frames at the latest
};

struct TimeSettings {
  double step = 0.005;     ///< [s] > 0; not in use if steps are automatic
  double frame_rate = 25;  ///< [1/s] > 0; steps are shortened so that frames are hit exactly
  int frames = 50;         ///< >= 1
  /// Each step is as long as its error allows, up to a frame.
  bool automatic = false;
  /// Error of an automatic step: root mean square over a component of cloth, in mean edges; > 0
  double tolerance = 0.02;
  RunUntil until = RunUntil::frames;
};

enum class FrameFormat { obj, ply, pc2, usda, glb };

/// Which frames a run leaves.
enum class FramesWritten {
  all,
  last,  ///< that of its end, whichever that is
};

struct OutputSettings {
  FrameFormat format = FrameFormat::obj;
  FramesWritten frames = FramesWritten::all;
  int checkpoint_every = 5;  ///< frames; 0: only at the end and on failure
};

struct Scene {
  std::string name;
  std::string file;                   ///< file that it was read from, for messages; may be empty
  Vec3<double> gravity{0, 0, -9.81};  ///< [m/s^2]
  TimeSettings time;
  std::vector<Material> materials;
  std::vector<Cloth> cloths;
  std::vector<Obstacle> obstacles;
  std::vector<Pin> pins;
  std::vector<Handle> handles;
  std::vector<Seam> seams;
  std::vector<GarmentStart> garment_starts;  ///< at most one for each cloth
  Refinement refinement;
  AdaptiveSettings adaptive;  ///< of the methods "adaptive" and "view"
  ViewSettings view;          ///< of the method "view"
  Bending bending = Bending::plate;
  Wind wind;
  Camera camera;
  ContactSettings contact;
  SolverSettings solver;
  OutputSettings output;
  std::string method = "implicit";
  ImplicitSettings implicit;           ///< of that method
  AsynchronousSettings asynchronous;   ///< of that method
  TimeParallelSettings time_parallel;  ///< of that method
  Integrator integrator = Integrator::implicit_euler;
  Precision precision = Precision::single_precision;
  std::vector<std::string> warnings;  ///< from the reader of the scene, one line each
  /// [m] world place of (0, 0, 0) in this scene. Empty: positions are world positions, and the
  /// simulation chooses an origin near the cloth if that is far from (0, 0, 0), so that distance
  /// costs no precision. Motions of pins and handles are about (0, 0, 0) of the world either way.
  std::optional<Vec3<double>> origin{};
  SceneIdentity identity{};

  /// Appends a part and names it, unless it has a name, by its number: "cloth 0".
  MaterialId add(Material material);
  ClothId add(Cloth cloth);
  ObstacleId add(Obstacle obstacle);
  PinId add(Pin pin);
  /// Pins vertices of a cloth where they start.
  /// @throws SceneError if `cloth` is not of this scene, or has no group of that name
  PinId pin(ClothId cloth, std::vector<Index> vertices);
  PinId pin(ClothId cloth, std::initializer_list<Index> vertices);
  PinId pin(ClothId cloth, const VertexGroup& group);
};

/// A fabric of the library, such as "denim", "silk" or "cotton". `weft info --fabrics` lists them
/// and says which numbers were measured, and which are estimates.
/// @throws SceneError that names all fabrics
Material fabric(const std::string& name);

/// Whether the scene's method changes meshes while it runs.
bool remeshes(const Scene& scene);

/// Whether the slices of a scene with the method "time_parallel" change meshes.
bool slices_remesh(const Scene& scene);

/// Placement at `time`, see Keyframe.
/// @pre motion has at least two keys in increasing time
Transform transform_at(const Motion& motion, double time);

/// rotate(scale * x) + translate
Vec3<double> apply(const Transform& transform, const Vec3<double>& x);

/// Checks everything that can be checked without simulating: ranges, finiteness, references between
/// parts, mesh topology (index range, degenerate and non-manifold parts).
/// @throws SceneError with file, field, value and what is allowed
void validate(const Scene& scene);

}  // namespace weft
