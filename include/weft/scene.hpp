#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

/// A scene as the simulation takes it: every file read, every default filled in. SI units, z up.
/// weft::io reads scenes from JSON; a program that embeds weft may fill the structs itself.
namespace weft {

/// Triangle mesh. Corners are counter-clockwise seen from the front.
struct Mesh {
  std::vector<Vec3<double>> positions;  ///< [m] world space
  std::vector<Vec2<double>> material;   ///< [m] material coordinates; empty: none
  std::vector<Tri> triangles;           ///< corners in `positions`
  /// [triangles] corners in `material`, for patterns whose pieces meet in seams; empty: as
  /// `triangles`
  std::vector<Tri> material_triangles{};
  std::vector<Index> group{};              ///< [triangles] into group_names; empty: no groups
  std::vector<std::string> group_names{};  ///< of faces, as the file calls them
};

/// Placement: x -> rotate(scale * x) + translate.
struct Transform {
  Vec3<double> translate{0, 0, 0};      ///< [m]
  Vec3<double> rotation_axis{0, 0, 1};  ///< unit
  double rotation_angle = 0;            ///< [rad]
  double scale = 1;
};

/// Placement at one instant. A motion is a list of these in increasing time, at least two;
/// between keys the placement is interpolated (cubic Hermite, Catmull-Rom slopes, zero slope at
/// both ends), outside it is held.
struct Keyframe {
  double time = 0;  ///< [s]
  Transform transform;
};
using Motion = std::vector<Keyframe>;

/// How a sheet resists stretching where its threads differ. Warp is the direction of the first
/// material coordinate, weft of the second.
struct OrthotropicStretch {
  double warp = 1000;          ///< [N/m] Young's modulus times thickness, > 0
  double weft = 1000;          ///< [N/m] likewise, > 0
  double poisson_ratio = 0.3;  ///< narrowing along the weft over stretch along the warp
  double shear = 400;          ///< [N/m] shear modulus times thickness, > 0
};

/// Plate stiffness where the threads differ: with the curvatures k11 along the warp, k22 along the
/// weft and the twist k12, the energy per area is
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
    energy,  ///< a convex energy fitted to the tables; what a run should take
    arcsim,  ///< the tables as ARCSim evaluates them, a stress without an energy
  };
  Form form = Form::energy;
  /// [N/m] c11, c12, c22, c33: at small strain; then at 1/6 of stretch along 0, 22.5, 45, 67.5 and
  /// 90 degrees from the warp. c11 and c22 of the first are > 0.
  std::array<std::array<double, 4>, 6> rows{};
};

/// How far a sheet may be stretched: near these principal stretches it stiffens, whatever its law.
struct StrainLimits {
  double min = 0;                                        ///< [0, 1); 0: none
  double max = std::numeric_limits<double>::infinity();  ///< > 1
};

/// Thin sheet: isotropic, or as the optional parts say.
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

/// How fine the mesh of an adaptive cloth is (Narain, Samii and O'Brien 2012). The names are those
/// of ARCSim. The longest edge that is allowed at a place is the one along which the normal turns
/// by refine_angle, or the velocity changes by refine_velocity, or which would just buckle under
/// the compression there, weighted by refine_compression.
struct Remeshing {
  double size_min = 0;                ///< [m] > 0; 0: from the mesh, with size_max
  double size_max = 0;                ///< [m] >= size_min
  double refine_angle = 0.3;          ///< [rad] > 0, infinity: curvature does not count
  double refine_compression = 0.005;  ///< [m] > 0, infinity likewise
  double refine_velocity = 0.5;       ///< [m/s] > 0, infinity likewise
  double aspect_min = 0.2;            ///< [0, 1) height over base that a triangle keeps; 1: regular
};

/// What goes for all adaptive cloths.
struct AdaptiveSettings {
  Remeshing remeshing;           ///< of cloths without settings of their own
  double flip_threshold = 0.01;  ///< how much better an edge must be the other way round, >= 0
  /// Energy that all flips and collapses of one remesh may add or take, by an estimate, as a share
  /// of the largest kinetic energy that the run has had; >= 0, infinity: any.
  double energy_share = 0.002;
};

struct Cloth {
  std::string name;
  Mesh mesh;           ///< initial world positions; material coordinates set the rest shape
  Index material = 0;  ///< into Scene::materials
  std::vector<Index> triangle_material;  ///< [triangles] likewise; empty: `material` for all
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

  /// Where the vertices are at `time`, before the obstacle's transform or motion; outside of what
  /// is known the nearest instant holds. Safe to call from several threads at once.
  /// @param time [s]
  /// @param out  [vertices] [m]
  virtual void positions(double time, Span<Vec3<double>> out) const = 0;

  /// Of all that positions() depends on: tells a checkpoint of another motion.
  virtual std::uint64_t checksum() const = 0;
};

/// What turns an obstacle about a fixed axis: its angle is an unknown, which a torque and what
/// touches or pulls it change.
struct DrivenBody {
  Vec3<double> origin{0, 0, 0};  ///< [m] a point of the axis
  Vec3<double> axis{0, 0, 1};    ///< unit
  double inertia = 0;            ///< [kg m^2] about the axis, > 0
  double torque = 0;             ///< [N m] about the axis, from start_time to end_time
  double start_time = 0;         ///< [s]
  double end_time = std::numeric_limits<double>::infinity();  ///< [s]
};

/// Surface with prescribed motion and infinite mass, or one that is driven. Self-contact of
/// obstacles is ignored.
struct Obstacle {
  std::string name;
  Mesh mesh;            ///< before `transform`; with a deformation: its shape at time 0
  Transform transform;  ///< where it stands if there is no motion
  Motion motion;        ///< replaces `transform`; empty: static
  std::shared_ptr<const Deformation> deformation;  ///< of `mesh`; null: rigid
  /// Turns from `transform` on, neither with a motion nor with a deformation; method asynchronous.
  std::optional<DrivenBody> driven{};
  double friction = 0.3;  ///< Coulomb coefficient against cloth, >= 0
};

/// Vertices held in place, or carried along by a motion (applied to their initial positions).
struct Pin {
  Index cloth = 0;              ///< into Scene::cloths
  std::vector<Index> vertices;  ///< numbers within that cloth, in input order
  Motion motion;                ///< empty: held where they start
  /// Into Scene::obstacles: each vertex is carried along by the part of that surface which it is
  /// nearest to at time 0. -1: none. Not together with `motion`.
  Index obstacle = -1;
  double release_time = std::numeric_limits<double>::infinity();  ///< [s]
};

/// Vertices tied by springs to where a motion takes them, for a while.
struct Handle {
  enum class Shape {
    points,  ///< to their own initial positions, carried along by `motion`
    circle,  ///< to a circle, carried along likewise, that the cloth is wound around
    glue,    ///< the two vertices to each other
  };
  Shape shape = Shape::points;
  Index cloth = 0;              ///< into Scene::cloths
  std::vector<Index> vertices;  ///< numbers within that cloth, in input order
  Motion motion;                ///< empty: at rest
  double stiffness = 1000;      ///< [N/m] a vertex, > 0
  double start_time = 0;        ///< [s]
  double end_time = std::numeric_limits<double>::infinity();  ///< [s]
  double fade_time = 0;          ///< [s] after end_time, over which the springs fade
  double circumference = 0;      ///< [m] circle: length of cloth once around, > 0
  Vec2<double> direction{1, 0};  ///< circle: in material space, along which it winds
  Vec3<double> center{0, 0, 0};  ///< [m] circle
  /// circle: towards angles 0 and 90 degrees; its radius is circumference / 2 pi times their length
  Vec3<double> axis0{1, 0, 0}, axis1{0, 1, 0};
};

/// Two chains of vertices that are sewn together, pair by pair (P-Cloth section 5.1): zero-length
/// springs whose stiffness grows, until the pairs are close enough to be one.
struct Seam {
  Index cloths[2] = {0, 0};        ///< into Scene::cloths
  std::vector<Index> vertices[2];  ///< as many in each, numbers within the cloth, in input order
  double stiffness = 1000;         ///< [N/m] a pair, > 0
  double start_time = 0;           ///< [s]
  double ramp_time = 0.5;          ///< [s] until the stiffness is reached; it grows with time cubed
  double weld_distance = 0;        ///< [m] pairs closer than this become one vertex; 0: never
};

/// When the cloths' triangles are split, one into four, on their rest shape.
struct Refinement {
  enum class When {
    never,
    sewn,  ///< once every pair of every seam is one vertex
  };
  When when = When::never;
  int levels = 1;  ///< 4^levels triangles for one, 1 to 6
};

/// Moving air.
struct Wind {
  double density = 0;              ///< [kg/m^3] of the air; 0: no wind stage
  Vec3<double> velocity{0, 0, 0};  ///< [m/s]
  double drag = 0;                 ///< tangential drag [kg/(m^2 s)], >= 0
};

/// Where pictures are taken from at one instant.
struct CameraKey {
  double time = 0;                 ///< [s]
  Vec3<double> position{0, 0, 0};  ///< [m]
  Vec3<double> look_at{0, 0, 0};   ///< [m]
  Vec3<double> up{0, 0, 1};
  double field_of_view = 0.7;  ///< [rad] vertical
  bool jump = false;           ///< a cut: not interpolated with the key before
};

/// Empty keys: the camera frames the scene by itself.
struct Camera {
  std::vector<CameraKey> keys;  ///< in increasing time; one: a camera at rest
  int width = 960;              ///< [pixels]
  int height = 720;             ///< [pixels]
};

/// How coarse cloth out of view yields to compression, in place of the folds that it cannot form.
enum class BucklingCompensation {
  none,
  full,  ///< does not resist compression at all
  area,  ///< the less, the larger the triangle
};

/// Of the method "view" (Koh, Narain and O'Brien 2015): what the camera does not see is coarser.
struct ViewSettings {
  double factor_back = 0.2;  ///< (0, 1] view factor of triangles that turn their back
  double factor_out = 0.01;  ///< (0, 1] of those that are farther out of view than the margin
  double margin = 0.4;       ///< [m] >= 0, over which the factor falls
  double anticipation = 5;   ///< [frames] 0 to 1000, how far ahead the camera is looked at; 0: no
  double transfer_threshold = 0.1;  ///< [0, 1] difference of neighbours' factors that is a jump
  double pixel_min = 4;            ///< [pixels] >= 0, edges shorter than this are not split; 0: any
  bool two_sided = false;          ///< the backs of cloths count as much as their fronts
  bool occlusion = false;          ///< cloth that is hidden is out of view
  bool predict_obstacles = false;  ///< anticipated cloth moves along with the nearest obstacle
  BucklingCompensation compensation = BucklingCompensation::area;
  double compensation_power = 10;  ///< >= 1
};

struct ContactSettings {
  bool self = true;  ///< cloth against cloth, itself included
  /// On the host, not with the method asynchronous: pairs of cloth with cloth are not looked for
  /// where it is proved that none comes near. Changes no bits.
  bool self_certificate = true;
  bool untangle = false;       ///< part cloth that intersects at the start, instead of refusing it
  double thickness = 1e-3;     ///< [m] distance at which repulsion starts, > 0
  double friction = 0.3;       ///< Coulomb coefficient, cloth against cloth, >= 0
  double stiffness = 10;       ///< repulsion in units of pair mass / time_step^2, > 0
  int zone_rounds = 60;        ///< rounds of CCD and impact zones a step before it is retried
  int substep_bisections = 5;  ///< how often a failing step may be halved
  /// [m] by which obstacles and pinned vertices that squeeze cloth between them may miss their
  /// places; a step that needs more fails. 0: they never yield.
  double compliance_distance = std::numeric_limits<double>::infinity();
};

/// Formula for the bending of cloth.
enum class Bending {
  hinge,  ///< angles between triangles (Grinspun et al. 2003); its stiffness depends on the mesh
  plate,  ///< quadratic plate energy that converges on any mesh, with Poisson's ratio
};

enum class Integrator { implicit_euler, bdf2 };
enum class Precision { single_precision, double_precision };

/// What conjugate gradients are preconditioned with.
enum class Preconditioner {
  block_jacobi,
  multilevel,         ///< with two levels of aggregates beside it
  multilevel_linear,  ///< with aggregates that turn and stretch, up to the whole cloth
  sparse_inverse,     ///< a factor of each row and its neighbours, beside one level of aggregates
};

/// How the ranks of a linear solve reach what others computed. Changes no bits.
enum class Transport {
  automatic,  ///< peer, or pipelined where GPUs cannot reach each other's memory
  peer,       ///< one kernel a GPU, which reaches the memory of the others
  pipelined,  ///< copies that the host issues, by work queues (P-Cloth section 3.1)
};

/// When ranks share their work out anew, by what it came to. Changes no bits.
enum class Rebalance {
  when_it_pays,  ///< rows once uneven shares have cost as much as that takes; pairs in each search
  never,         ///< rows by their number, pairs by what stands in cells
  every_step,    ///< rows before each step, whatever it costs
};

struct SolverSettings {
  double tolerance = 1e-2;    ///< true residual over the first, in two norms, see SolvePcg; (0, 1)
  int max_iterations = 2000;  ///< a linear solve, >= 1
  Preconditioner preconditioner = Preconditioner::multilevel;
  int newton_iterations = 1;  ///< 1: linearly implicit, equation (3) of P-Cloth
  /// Newton stops earlier once the non-linear residual is below this share of the first.
  double newton_tolerance = 1e-6;
  bool line_search = true;  ///< for newton_iterations > 1
  /// Rows per reduction block of a dot product, a power of two; 0: from the row count. At most
  /// 1,024, with block_jacobi 512, in a linear solve.
  int partial_rows = 0;
  Transport transport = Transport::automatic;
  Rebalance rebalance = Rebalance::when_it_pays;
};

/// Of the method "implicit". A component of cloth that has moved so little that it would not depart
/// by `sleep_distance` from where it is until the run's end, were it to go on so, and that nothing
/// comes near, is taken to rest, together with all that it touches, and left out until something
/// does come near or pulls at it. On the host only.
struct ImplicitSettings {
  double sleep_distance = 0;  ///< [m] >= 0; 0: everything is simulated
  double sleep_window = 0.2;  ///< [s] > 0 over which motion is measured
};

/// How the asynchronous method decides whether a pair that the broad phase left over comes close.
enum class NarrowPhase {
  slabs,  ///< separating slabs in space and time, continuous detection where they fail
  ccd,    ///< continuous detection alone, for comparison
};

/// Of the method "asynchronous" (Ainsley et al. 2012). Penalty layer l = 1, 2, ... is
/// contact.thickness l^(-1/4) thick and stiffness l^3 stiff. Neither windows nor the narrow phase
/// change results.
struct AsynchronousSettings {
  double window = 0.003;     ///< [s] > 0; windows are shortened so that steps are hit exactly
  bool tune_window = false;  ///< let the window follow the work that was counted
  NarrowPhase narrow = NarrowPhase::slabs;
  bool optimistic = true;       ///< begin windows on free threads while the last is looked at
  double stiffness = 1000;      ///< [N/m] of the first layer, > 0
  double restitution = 0;       ///< [0, 1] of the velocity of impacts
  int layers = 1000;            ///< of one pair, at most; more fail
  int rollbacks = 1000;         ///< of one window, at most; more fail
  double smallest_step = 1e-9;  ///< [s] > 0 of any force; shorter ones fail
};

/// How a run is cut into slices of time (Liang & Lin 2018, section 4).
enum class TimeSchedule {
  uniform,   ///< slices of one length
  balanced,  ///< a slice that can only begin later is shorter, for a given ratio of costs
  adaptive,  ///< the same, for the ratio of costs that is counted during the run
};

/// Of the method "time_parallel" (Liang & Lin 2018): a coarse run predicts where slices of time
/// begin, and these run side by side.
struct TimeParallelSettings {
  std::string method = "implicit";  ///< of the slices: "implicit", "adaptive" or "view"
  TimeSchedule schedule = TimeSchedule::adaptive;
  /// The ratio of `adaptive` comes from the clock in place of counted work: another run cuts
  /// elsewhere, unless it is given the partition that this one reports.
  bool by_clock = false;
  int slices = 0;      ///< 0: one for each worker
  double ratio = 100;  ///< cost of a step over that of the coarse run, for `balanced`, > 1
  /// Edges of the coarse mesh over those of the fine one, or over the shortest that slices make,
  /// > 1.
  double coarsening = 5;
  /// The coarse run remeshes too; its smallest edges are `coarsening` times those of the fine one.
  bool coarse_adaptive = false;
  double coarse_step = 0.02;    ///< [s] >= TimeSettings::step
  double coarse_thickness = 1;  ///< of contacts of the coarse run, over that of the fine one, >= 1
  Integrator coarse_integrator = Integrator::implicit_euler;
  int coarse_newton_iterations = 2;  ///< SolverSettings::newton_iterations of the coarse run, >= 1
  double coarse_newton_tolerance = 0.1;  ///< likewise, (0, 1)
  double coarse_tolerance = 0.01;        ///< likewise, where the scene's is not looser, (0, 1)
  double recovery_factor = 10;           ///< c0 in c0 sqrt(density / stiffness) / step, >= 0
  int recovery_iterations = -1;          ///< instead of that; -1: by the formula
  /// Recovery ends below this change of an iteration: of all but one vertex in a hundred, divided
  /// by the cloths' size.
  double recovery_tolerance = 1e-3;
  bool track_always = false;      ///< slices follow the coarse run too, not their recovery alone
  double boundary_tolerance = 2;  ///< jump at a seam over the largest change between frames, > 0
  int blend_frames = 0;           ///< after a seam, over which a jump beyond that is spread out
};

struct TimeSettings {
  double step = 0.005;     ///< [s] > 0
  double frame_rate = 25;  ///< [1/s] > 0; steps are shortened so that frames are hit exactly
  int frames = 50;         ///< >= 1
};

enum class FrameFormat { obj, ply, pc2, usda };

struct OutputSettings {
  FrameFormat format = FrameFormat::obj;
  int checkpoint_every = 5;  ///< frames; 0: only at the end and on failure
};

struct Scene {
  std::string name;
  std::string file;                   ///< where it was read, for messages; may be empty
  Vec3<double> gravity{0, 0, -9.81};  ///< [m/s^2]
  TimeSettings time;
  std::vector<Material> materials;
  std::vector<Cloth> cloths;
  std::vector<Obstacle> obstacles;
  std::vector<Pin> pins;
  std::vector<Handle> handles;
  std::vector<Seam> seams;
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
};

/// Whether the scene's method changes meshes while it runs.
bool remeshes(const Scene& scene);

/// Whether the slices of a scene with the method "time_parallel" do.
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
