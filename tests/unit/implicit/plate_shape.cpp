#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

#include "host/implicit/linear/mesh_rows.hpp"
#include "host/implicit/linear/rest_shape_rows.hpp"
#include "host/model/model.hpp"
#include "host/scene/seams/sewing.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/elements/hinge.hpp"
#include "weft/kernels/assemble/plate.hpp"
#include "weft/kernels/assemble/rest_shape_forces.hpp"
#include "weft/kernels/assemble/rest_shape_rows.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

// Forces of plates, as the kernels make them, against differences of the energy.

namespace weft {
namespace {

using Points = std::vector<Vec3<double>>;

double random_number(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11) * 0x1p-52 - 1;
}

/// A jittered sheet that is rolled up at rest about an axis askew to its threads.
Scene rolled_sheet() {
  Scene s;
  s.precision = Precision::double_precision;
  s.gravity = {0, 0, 0};
  s.contact.self = false;
  s.materials.push_back(test::cotton());
  s.materials[0].bending_stiffness = 1e-2;
  s.materials[0].orthotropic_bending = OrthotropicBending{1e-2, 4e-3, 2e-3, 3e-3};
  s.cloths.push_back(test::sheet(5, 0));
  Mesh& mesh = s.cloths[0].mesh;
  std::mt19937_64 engine(7);
  for (auto& u : mesh.material)
    for (int c = 0; c < 2; ++c) u[c] += 0.015 * random_number(engine);
  for (const auto& u : mesh.material) {
    const double r = 0.15;
    const double along = 0.8 * u[0] + 0.6 * u[1];
    const double across = -0.6 * u[0] + 0.8 * u[1];
    s.cloths[0].rest_positions.push_back(
        {r * std::sin(along / r), across, r * std::cos(along / r)});
  }
  return s;
}

struct Sheet {
  /// @param held how many of the triangles, the first ones, are
  explicit Sheet(const Scene& scene, std::size_t held = 0)
      : model(make_model(scene, std::vector<unsigned char>(seam_pairs(scene).size(), 1))) {
    std::vector<unsigned char> flags(model.area.size(), 0);
    std::fill(flags.begin(), flags.begin() + static_cast<std::ptrdiff_t>(held), 1);
    plate = make_plate(scene, model, flags);
  }
  Model model;
  PlateMatrix plate;
};

/// The rest shape in internal order.
Points rest_of(const Model& model) {
  Points rest;
  for (const Index input : model.to_input)
    rest.push_back(model.rest_positions[static_cast<std::size_t>(input)]);
  return rest;
}

/// Minus the force of the kernels on each vertex.
Points gradient(const Sheet& sheet, const Points& x) {
  const Partition partition = make_partition(sheet.model.cloth_vertex_count, 1, 0);
  const MeshRows mesh = make_mesh_rows(sheet.model, partition, 0);
  const PlateRows rows = make_plate_rows(sheet.plate, mesh, partition, 0);
  const RestShapeRows shape = make_rest_shape_rows(sheet.plate.shape, partition, 0);
  std::vector<double> mesh_value(9 * mesh.column.size());
  std::vector<Mat3<double>> diagonal(x.size());
  std::vector<double> off_pattern_value(rows.off_pattern_column.size());
  Points rhs(x.size(), Vec3<double>{});
  Points axes(3 * shape.corners.size());
  Points corner_force(axes.size());
  const auto count = static_cast<Index>(x.size());
  const AssemblePlate<double> a{0,
                                count,
                                partition.slice,
                                rows.in_pattern_offset,
                                rows.in_pattern_place,
                                rows.in_pattern_column,
                                rows.in_pattern_stiffness,
                                rows.in_pattern_damping,
                                rows.off_pattern_slice_offset,
                                rows.off_pattern_column,
                                rows.off_pattern_stiffness,
                                rows.off_pattern_damping,
                                x,
                                {},
                                1,
                                mesh_value,
                                diagonal,
                                off_pattern_value,
                                rhs};
  const AssembleRestShapeForces<double> turns{shape.corners, shape.inv_rest, shape.offset,
                                              shape.vertex,  shape.force,    x,
                                              axes,          corner_force};
  const AssembleRestShapeRows<double> gather{count,        shape.entry_offset,
                                             shape.entry,  shape.entry_triangle,
                                             shape.force,  shape.corner_offset,
                                             shape.corner, axes,
                                             corner_force, 1,
                                             rhs};
  for (std::size_t t = 0; t < shape.corners.size(); ++t) turns(static_cast<Index>(t));
  for (Index i = 0; i < count; ++i) {
    a(i);
    if (!shape.corners.empty()) gather(i);
  }
  for (auto& f : rhs) f = -f;
  return rhs;
}

void expect_gradient(const Sheet& sheet, const Points& at, double step) {
  const Points g = gradient(sheet, at);
  double size = 0;
  Vec3<double> force{};
  Vec3<double> torque{};
  for (std::size_t v = 0; v < at.size(); ++v) {
    size = std::max(size, length(g[v]));
    force += g[v];
    torque += cross(at[v] - at[0], g[v]);
  }
  EXPECT_LT(length(force), 1e-12 * size * static_cast<double>(at.size()));
  EXPECT_LT(length(torque), 1e-12 * size * static_cast<double>(at.size()));
  Points x = at;
  for (std::size_t v = 0; v < x.size(); ++v)
    for (int c = 0; c < 3; ++c) {
      const double middle = x[v][c];
      x[v][c] = middle + step;
      const double up = plate_energy(sheet.plate, x);
      x[v][c] = middle - step;
      const double down = plate_energy(sheet.plate, x);
      x[v][c] = middle;
      EXPECT_NEAR((up - down) / (2 * step), g[v][c], 1e-5 * size) << "vertex " << v;
    }
}

/// Rotated and moved.
Points moved(const Points& x) {
  Points out;
  const Transform there{{3, -2, 5}, {0.6, 0, 0.8}, 2.1, 1};
  for (const auto& p : x) out.push_back(apply(there, p));
  return out;
}

TEST(PlateShape, RestsInItsShapeHoweverThatIsMoved) {
  const Sheet sheet{rolled_sheet()};
  ASSERT_EQ(sheet.model.area.size(), sheet.plate.shape.corners.size());
  ASSERT_GT(sheet.plate.shape.energy, 1e-3);
  Points flat;
  for (const auto& u : sheet.model.material_points) flat.push_back({u[0], u[1], 0});
  double size = 0;
  for (const auto& g : gradient(sheet, flat)) size = std::max(size, length(g));
  for (const Points& x : {rest_of(sheet.model), moved(rest_of(sheet.model))}) {
    EXPECT_NEAR(0, plate_energy(sheet.plate, x), 1e-12 * sheet.plate.shape.energy);
    for (const auto& g : gradient(sheet, x)) EXPECT_LT(length(g), 1e-11 * size);
  }
}

TEST(PlateShape, TheShapeIsALeastOfTheEnergy) {
  const Sheet sheet{rolled_sheet()};
  std::mt19937_64 engine(8);
  for (const double amount : {1e-5, 1e-3, 0.05})
    for (int n = 0; n < 20; ++n) {
      Points x = rest_of(sheet.model);
      for (auto& p : x)
        for (int c = 0; c < 3; ++c) p[c] += amount * random_number(engine);
      EXPECT_GT(plate_energy(sheet.plate, x), 0) << amount;
    }
}

TEST(PlateShape, ForcesAreTheGradientOfTheEnergy) {
  const Sheet sheet{rolled_sheet()};
  std::mt19937_64 engine(9);
  Points flat;
  for (const auto& u : sheet.model.material_points) flat.push_back({u[0], u[1], 0});
  Points crumpled = flat;
  for (auto& p : crumpled)
    for (int c = 0; c < 3; ++c) p[c] += 0.03 * random_number(engine);
  Points folded = flat;  // onto itself
  for (auto& p : folded) p = {std::abs(p[0]), p[1], 1e-4 * random_number(engine)};
  Points inside_out = rest_of(sheet.model);
  for (auto& p : inside_out) p[2] = -p[2];
  for (const Points& x : {flat, moved(flat), crumpled, folded, inside_out})
    expect_gradient(sheet, x, 1e-7);
  Points thin = crumpled;  // slivers
  for (auto& p : thin) p[1] *= 1e-3;
  expect_gradient(sheet, thin, 1e-9);
  expect_gradient(Sheet{rolled_sheet(), 8}, crumpled, 1e-7);
}

/// Flat at rest: the same configurations, and the matrix is the derivative of the forces exactly.
TEST(PlateShape, OfNoCurvatureForcesAreTheGradientToo) {
  Scene scene = rolled_sheet();
  scene.cloths[0].rest_positions.clear();
  const Sheet sheet{scene};
  std::mt19937_64 engine(10);
  Points flat;
  for (const auto& u : sheet.model.material_points) flat.push_back({u[0], u[1], 0});
  Points crumpled = flat, folded = flat, line = flat, point = flat;
  for (auto& p : crumpled)
    for (int c = 0; c < 3; ++c) p[c] += 0.03 * random_number(engine);
  for (auto& p : folded) p = {std::abs(p[0]), p[1], 0};
  for (auto& p : line) p = {p[0] + 0.2 * p[1] * p[1], 0, 0};
  for (auto& p : point) p = {1e-3 * p[0] * p[0], 0, 1e-3 * p[1] * p[1]};
  for (const Points& x : {moved(crumpled), crumpled, folded, line, point})
    expect_gradient(sheet, x, 1e-5);
  for (const auto& g : gradient(sheet, moved(flat))) EXPECT_LT(length(g), 1e-12);
}

/// An arc of 6 x 4 cells about the y axis, in a frame of its own.
/// @param angle [rad] between its facets
Cloth arc(double angle) {
  constexpr int columns = 6, rows = 4;
  constexpr double cell = 0.05;
  Cloth cloth;
  Vec3<double> x{};
  for (int j = 0; j <= rows; ++j, x = {0, x[1] + cell, 0})
    for (int i = 0; i <= columns; ++i) {
      cloth.mesh.positions.push_back(x);
      cloth.mesh.material.push_back({i * cell, j * cell});
      x += cell * Vec3<double>{std::cos(i * angle), 0, std::sin(i * angle)};
      if (i == columns) x = {0, j * cell, 0};
    }
  for (Index j = 0; j < rows; ++j)
    for (Index i = 0; i < columns; ++i) {
      const Index a = j * (columns + 1) + i;
      cloth.mesh.triangles.push_back({{a, a + 1, a + columns + 2}});
      cloth.mesh.triangles.push_back({{a, a + columns + 2, a + columns + 1}});
    }
  return cloth;
}

/// Two arcs that are sewn together, where the seam is flat and each has its own shape.
/// @param angles [rad] between their facets; 0: flat at rest, without a shape of its own
Scene sewn_arcs(const std::array<double, 2>& angles) {
  Scene s = rolled_sheet();
  s.cloths.clear();
  for (const double angle : angles) s.cloths.push_back(arc(angle));
  for (std::size_t k = 0; k < 2; ++k)
    if (angles[k] != 0) s.cloths[k].rest_positions = moved(s.cloths[k].mesh.positions);
  const Transform second{s.cloths[0].mesh.positions[6], {0, 1, 0}, -5 * angles[0], 1};
  for (auto& x : s.cloths[1].mesh.positions) x = apply(second, x);
  Seam seam;
  seam.cloths[1] = 1;
  for (Index j = 0; j <= 4; ++j) {
    seam.vertices[0].push_back(7 * j + 6);
    seam.vertices[1].push_back(7 * j);
  }
  seam.weld_distance = 1e-3;
  s.seams.push_back(seam);
  return s;
}

TEST(PlateShape, SeamsOfShapesAreFlatAtRest) {
  for (const std::array<double, 2> angles :
       {std::array{0.2, 0.2}, {0.2, -0.3}, {0.2, 0.0}, {0.0, 0.2}}) {
    const Sheet sheet{sewn_arcs(angles)};
    const Points& x = sheet.model.positions;
    ASSERT_EQ(sheet.model.cloth_vertex_count, 65);
    Points flat;
    for (std::size_t v = 0; v < x.size(); ++v) {
      const Vec2<double>& u = sheet.model.material_points[v];
      flat.push_back({u[0] + (sheet.model.cloth_of_vertex[v] == 1 ? 0.3 : 0), u[1], 0});
    }
    const double energy = plate_energy(sheet.plate, flat);
    ASSERT_GT(energy, 1e-3);
    EXPECT_NEAR(plate_energy(sheet.plate, x), 0, 1e-12 * energy);
    double size = 0;
    for (const auto& g : gradient(sheet, flat)) size = std::max(size, length(g));
    for (const auto& g : gradient(sheet, moved(x))) EXPECT_LT(length(g), 1e-11 * size);
    std::mt19937_64 engine(11);
    Points crumpled = flat;
    for (auto& p : crumpled)
      for (int c = 0; c < 3; ++c) p[c] += 0.02 * random_number(engine);
    expect_gradient(sheet, crumpled, 1e-7);
  }
}

TEST(PlateShape, HingesOfSeamsAreFlatAtRest) {
  Scene scene = sewn_arcs({0.2, -0.3});
  scene.bending = Bending::hinge;
  const Model model = make_model(scene, {1, 1, 1, 1, 1});
  int flat = 0, curved = 0;
  for (std::size_t h = 0; h < model.hinges.size(); ++h) {
    Vec3<double> x[4];
    for (int i = 0; i < 4; ++i)
      x[i] = model.positions[static_cast<std::size_t>(model.hinges[h].v[i])];
    EXPECT_NEAR(hinge_angle(x), model.hinge_rest_angle[h], 1e-12);
    ++(std::abs(model.hinge_rest_angle[h]) < 1e-12 ? flat : curved);
  }
  // Diagonals and the four edges of the seam, and five lines of four edges in either piece.
  EXPECT_EQ(curved, 40);
  EXPECT_EQ(flat, 24 + 24 + 4 + 2 * 6 * 3);
}

/// The matrix leaves out how the rest shape's forces turn: at rest it is stiffer than the exact
/// Hessian in some directions, and softer in others. Newton's method converges with it where the
/// exact one is below twice the matrix. What is beyond that is less than D / r^2, against motions
/// that stretch the sheet, whose resistance to stretching is hundreds of times that.
TEST(PlateShape, MatrixIsMoreThanHalfOfTheHessianAtRest) {
  const Sheet sheet{rolled_sheet()};
  const Points rest = moved(rest_of(sheet.model));
  const auto n = static_cast<Eigen::Index>(3 * rest.size());
  Eigen::MatrixXd exact(n, n), matrix = Eigen::MatrixXd::Zero(n, n);
  const double step = 1e-6;
  for (Eigen::Index column = 0; column < n; ++column) {
    Points side[2] = {rest, rest};
    const auto v = static_cast<std::size_t>(column / 3);
    const int c = static_cast<int>(column % 3);
    side[0][v][c] -= step;
    side[1][v][c] += step;
    const Points less = gradient(sheet, side[0]), more = gradient(sheet, side[1]);
    for (Eigen::Index row = 0; row < n; ++row) {
      const auto w = static_cast<std::size_t>(row / 3);
      const int d = static_cast<int>(row % 3);
      exact(row, column) = (more[w][d] - less[w][d]) / (2 * step);
    }
  }
  const PlateMatrix& plate = sheet.plate;
  for (std::size_t row = 0; row + 1 < plate.row_offset.size(); ++row)
    for (Offset e = plate.row_offset[row]; e < plate.row_offset[row + 1]; ++e)
      for (int c = 0; c < 3; ++c)
        matrix(3 * static_cast<Eigen::Index>(row) + c,
               3 * plate.column[static_cast<std::size_t>(e)] + c) =
            plate.stiffness[static_cast<std::size_t>(e)];
  const double size = matrix.cwiseAbs().maxCoeff();
  EXPECT_LT((exact - exact.transpose()).cwiseAbs().maxCoeff(), 1e-6 * size);
  const auto least = [](const Eigen::MatrixXd& m) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>((m + m.transpose()) / 2)
        .eigenvalues()
        .minCoeff();
  };
  EXPECT_GT(least(exact), -1e-6 * size);
  EXPECT_GT(least(matrix), -1e-12 * size);
  EXPECT_GT(least(2 * matrix - exact), -1e-2 / (0.15 * 0.15));
}

TEST(PlateShape, FlatAtRestIsTheSameMatrix) {
  Scene s = rolled_sheet();
  const Sheet curved(s);
  s.cloths[0].rest_positions.clear();
  const Sheet flat(s);
  EXPECT_TRUE(flat.plate.shape.corners.empty());
  EXPECT_EQ(flat.plate.stiffness, curved.plate.stiffness);
  EXPECT_EQ(flat.plate.column, curved.plate.column);
}

/// Half cylinders at rest of facets that are isometric to the pattern.
Scene half_cylinder(Bending bending, int cells) {
  Scene s = rolled_sheet();
  s.bending = bending;
  s.materials[0].orthotropic_bending.reset();
  s.materials[0].bending_stiffness = 1e-2;
  s.materials[0].poisson_ratio = 0;
  s.cloths[0].mesh = make_grid({1, 0.25}, {cells, cells / 4}, Diagonals::same);
  Cloth& cloth = s.cloths[0];
  const double turn = std::numbers::pi / cells;
  const double r = 0.5 / cells / std::sin(turn / 2);
  cloth.rest_positions.clear();
  for (const auto& u : cloth.mesh.material) {
    const double angle = u[0] * cells * turn;
    cloth.rest_positions.push_back({r * std::sin(angle), u[1], r * std::cos(angle)});
  }
  return s;
}

class CurvedAtRest : public testing::TestWithParam<Bending> {};

TEST_P(CurvedAtRest, FlattenedItStoresItsCurvature) {
  const Scene s = half_cylinder(GetParam(), 64);
  const double radius = 1 / std::numbers::pi;
  const Simulation simulation(s, host_devices(1));
  EXPECT_NEAR(1, simulation.energy().elastic / (1e-2 / 2 * 0.25 / (radius * radius)), 0.02);
}

TEST_P(CurvedAtRest, AtRestItStaysThatWay) {
  Scene s = half_cylinder(GetParam(), 16);
  s.cloths[0].mesh.positions = moved(s.cloths[0].rest_positions);
  Simulation simulation(s, host_devices(2));
  EXPECT_NEAR(0, simulation.energy().elastic, 1e-12);
  for (int k = 0; k < 50; ++k) ASSERT_EQ(Failure::none, simulation.step().failure);
  const Points now = simulation.frame().cloth_positions[0];
  for (std::size_t v = 0; v < now.size(); ++v)
    EXPECT_LT(length(now[v] - s.cloths[0].mesh.positions[v]), 1e-9);
}

TEST_P(CurvedAtRest, HeldAtOneEndItStaysThatWayToo) {
  Scene s = half_cylinder(GetParam(), 16);
  s.cloths[0].mesh.positions = moved(s.cloths[0].rest_positions);
  Pin pin;
  for (std::size_t v = 0; v < s.cloths[0].mesh.material.size(); ++v)
    if (s.cloths[0].mesh.material[v][0] < -0.43) pin.vertices.push_back(static_cast<Index>(v));
  pin.release_time = 0.1;
  s.pins = {pin};
  Simulation simulation(s, host_devices(1));
  EXPECT_NEAR(0, simulation.energy().elastic, 1e-12);
  for (int k = 0; k < 40; ++k) ASSERT_EQ(Failure::none, simulation.step().failure);
  const Points now = simulation.frame().cloth_positions[0];
  for (std::size_t v = 0; v < now.size(); ++v)
    EXPECT_LT(length(now[v] - s.cloths[0].mesh.positions[v]), 1e-9);
}

TEST_P(CurvedAtRest, LetGoItRollsUp) {
  Scene s = half_cylinder(GetParam(), 16);
  s.materials[0].damping_mass = 5;
  s.time.step = 0.01;
  Simulation simulation(s, host_devices(1));
  const double start = simulation.energy().elastic;
  for (int k = 0; k < 300; ++k) ASSERT_EQ(Failure::none, simulation.step().failure);
  EXPECT_LT(simulation.energy().elastic, 1e-3 * start);
}

INSTANTIATE_TEST_SUITE_P(Bending, CurvedAtRest, testing::Values(Bending::plate, Bending::hinge));

TEST(PlateShape, OrthotropicFlattenedSheetsStoreWhatTheirThreadsSay) {
  for (const bool along_warp : {true, false}) {
    Scene s = half_cylinder(Bending::plate, 64);
    s.materials[0].orthotropic_bending = OrthotropicBending{1e-2, 3e-3, 1e-3, 2e-3};
    if (!along_warp) {
      for (auto& u : s.cloths[0].mesh.material) u = {-u[1], u[0]};
    }
    const double radius = 1 / std::numbers::pi;
    const Simulation simulation(s, host_devices(1));
    EXPECT_NEAR(
        1,
        simulation.energy().elastic / ((along_warp ? 1e-2 : 3e-3) / 2 * 0.25 / (radius * radius)),
        0.02);
  }
}

/// From one curvature to another: D/2 (k1 - k0)^2, in the same direction and in the other.
TEST(PlateShape, CurvatureCountsFromThatAtRest) {
  const Sheet sheet{half_cylinder(Bending::plate, 64)};
  const double rest = std::numbers::pi;
  for (const double curvature : {2 * rest, 0.5 * rest, -rest}) {
    Points x;
    for (const auto& u : sheet.model.material_points)
      x.push_back(
          {std::sin(curvature * u[0]) / curvature, u[1], std::cos(curvature * u[0]) / curvature});
    const double change = curvature - rest;
    EXPECT_NEAR(1, plate_energy(sheet.plate, x) / (1e-2 / 2 * 0.25 * change * change), 0.02);
  }
}

}  // namespace
}  // namespace weft
