#include "benchmarks/physics/statics.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "benchmarks/physics/sheets.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::physics {
namespace {

void step_once(Simulation& simulation) {
  const StepReport report = simulation.step();
  if (report.failure != Failure::none)
    throw SimulationError(fmt::format("step {}: {}: {}", report.number, describe(report.failure),
                                      report.failure_detail));
}

}  // namespace

Scene make_scene(Mesh mesh, const Material& material, double step) {
  Scene scene;
  scene.name = "physics";
  scene.gravity = {0, 0, 0};
  scene.precision = Precision::double_precision;
  scene.time.step = step;
  scene.time.frame_rate = 1 / step;
  scene.contact.self = false;
  scene.solver.tolerance = 1e-9;
  scene.solver.max_iterations = 200000;
  scene.solver.newton_iterations = 30;
  scene.solver.newton_tolerance = 1e-8;
  scene.materials = {material};
  scene.cloths.push_back({"sheet", std::move(mesh), 0, {}, {}, {}, {}});
  return scene;
}

Simulation start(Scene scene) {
  return Simulation(std::move(scene), host_devices(1));
}

std::vector<Parameter> bending_parameter() {
  return {{"bending", "plate", "plate or hinge"}};
}

Bending bending_of(const Parameters& parameters) {
  return parameters.one_of("bending", {"plate", "hinge"}) == "plate" ? Bending::plate
                                                                     : Bending::hinge;
}

void advance(Simulation& simulation, int steps) {
  for (int n = 0; n < steps; ++n) step_once(simulation);
}

void settle(Simulation& simulation, double tolerance, int steps_max) {
  auto before = positions(simulation);
  double moved = 0;
  for (int n = 0; n < steps_max; ++n) {
    step_once(simulation);
    auto after = positions(simulation);
    moved = 0;
    for (std::size_t v = 0; v < after.size(); ++v)
      moved = std::max(moved, length(after[v] - before[v]));
    if (moved <= tolerance) return;
    before = std::move(after);
  }
  throw SimulationError(
      fmt::format("not at rest after {} steps: the last moved by {} m", steps_max, moved));
}

void pin(Scene& scene, std::vector<Index> vertices) {
  Pin pin;
  pin.vertices = std::move(vertices);
  scene.pins.push_back(std::move(pin));
}

void add_dead_load(Scene& scene, const std::vector<Index>& vertices,
                   const std::vector<double>& weights, const Vec3<double>& force, double reach) {
  const double size = length(force);
  if (!(size > 0)) return;
  const double far = 1e7 * reach;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    if (!(weights[k] > 0)) continue;
    Handle handle;
    handle.vertices = {vertices[k]};
    handle.stiffness = weights[k] * size / far;
    Transform there;
    there.translate = (far / size) * force;
    handle.motion = {{0, there}, {1, there}};
    scene.handles.push_back(std::move(handle));
  }
}

std::vector<double> line_shares(const Mesh& mesh, const std::vector<Index>& vertices) {
  std::vector<std::pair<double, std::size_t>> along;
  for (std::size_t k = 0; k < vertices.size(); ++k)
    along.emplace_back(mesh.material[at(vertices[k])][1], k);
  std::sort(along.begin(), along.end());
  std::vector<double> shares(vertices.size());
  const double whole = along.back().first - along.front().first;
  for (std::size_t n = 0; n + 1 < along.size(); ++n)
    for (const std::size_t end : {n, n + 1})
      shares[along[end].second] += (along[n + 1].first - along[n].first) / (2 * whole);
  return shares;
}

std::vector<Vec3<double>> positions(const Simulation& simulation) {
  return simulation.frame().cloth_positions.front();
}

Vec3<double> mean_place(const Simulation& simulation, const std::vector<Index>& vertices) {
  const auto x = positions(simulation);
  Vec3<double> sum{};
  for (const Index v : vertices) sum += x[at(v)];
  return (1.0 / static_cast<double>(vertices.size())) * sum;
}

namespace {

/// The inverse iteration behind vibration_squares().
class Iteration {
 public:
  Iteration(const Scene& scene, const Vibration& vibration)
      : scene_(scene), vibration_(vibration), mesh_(scene.cloths.front().mesh) {
    scene_.time.step = vibration.step;
    scene_.time.frame_rate = 1 / vibration.step;
    const auto areas = vertex_areas(mesh_);
    mass_ =
        Eigen::Map<const Eigen::VectorXd>(areas.data(), static_cast<Eigen::Index>(areas.size()));
    free_ = Eigen::VectorXd::Ones(mass_.size());
    for (const Pin& pin : scene.pins)
      for (const Index v : pin.vertices) free_[v] = 0;
    at_rest_ = after_step(Eigen::VectorXd::Zero(mass_.size()));
  }

  /// One step from each column of u.
  Eigen::MatrixXd apply(const Eigen::MatrixXd& u) const {
    Eigen::MatrixXd out(u.rows(), u.cols());
    for (Eigen::Index k = 0; k < u.cols(); ++k) {
      const double scale = vibration_.amplitude / u.col(k).cwiseAbs().maxCoeff();
      out.col(k) = (after_step(scale * u.col(k)) - at_rest_) / scale;
    }
    return out;
  }

  /// Polynomials of the material coordinates of rising degree, zero where vertices are pinned.
  Eigen::MatrixXd initial_guess(int columns) const {
    Eigen::MatrixXd u(mass_.size(), columns);
    Vec2<double> low = mesh_.material.front();
    Vec2<double> high = low;
    for (const auto& p : mesh_.material)
      for (int a = 0; a < 2; ++a) {
        low[a] = std::min(low[a], p[a]);
        high[a] = std::max(high[a], p[a]);
      }
    for (int k = 0, degree = 0; k < columns; ++degree)
      for (int py = 0; py <= degree && k < columns; ++py, ++k)
        for (Eigen::Index v = 0; v < u.rows(); ++v) {
          const auto& p = mesh_.material[static_cast<std::size_t>(v)];
          const double x = (p[0] - low[0]) / (high[0] - low[0]);
          const double y = 2 * (p[1] - low[1]) / (high[1] - low[1]) - 1;
          u(v, k) = free_[v] * std::pow(2 * x - 1, degree - py) * std::pow(y, py);
        }
    return u;
  }

  const Eigen::VectorXd& mass() const { return mass_; }

 private:
  Eigen::VectorXd after_step(const Eigen::VectorXd& u) const {
    Scene scene = scene_;
    auto& x = scene.cloths.front().mesh.positions;
    for (std::size_t v = 0; v < x.size(); ++v)
      x[v] += u[static_cast<Eigen::Index>(v)] * vibration_.direction;
    Simulation simulation = start(std::move(scene));
    step_once(simulation);
    const auto ends = positions(simulation);
    Eigen::VectorXd out(u.size());
    for (std::size_t v = 0; v < ends.size(); ++v)
      out[static_cast<Eigen::Index>(v)] = dot(ends[v] - mesh_.positions[v], vibration_.direction);
    return out.cwiseProduct(free_);
  }

  Scene scene_;
  Vibration vibration_;
  Mesh mesh_;
  Eigen::VectorXd mass_;
  Eigen::VectorXd free_;  ///< 1, or 0 where a vertex is pinned
  Eigen::VectorXd at_rest_;
};

}  // namespace

std::vector<double> vibration_squares(const Scene& scene, const Vibration& vibration) {
  const Iteration iteration(scene, vibration);
  const int columns = vibration.modes + (vibration.modes > 1 ? 3 : 1);
  Eigen::MatrixXd u = iteration.initial_guess(columns);
  Eigen::VectorXd shares;
  for (int round = 0; round < vibration.rounds; ++round) {
    const Eigen::MatrixXd au = iteration.apply(u);
    const Eigen::MatrixXd mu = iteration.mass().asDiagonal() * u;
    Eigen::MatrixXd stiff = mu.transpose() * au;
    stiff = (0.5 * (stiff + stiff.transpose())).eval();
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(stiff,
                                                                          mu.transpose() * u);
    if (eigen.info() != Eigen::Success)
      throw SimulationError("the modes of vibration have become linearly dependent");
    const Eigen::VectorXd before = shares;
    shares = eigen.eigenvalues().reverse().head(vibration.modes);
    u = au * eigen.eigenvectors().rowwise().reverse();
    if (round > 1 && ((shares - before).array() / (1 - shares.array())).abs().maxCoeff() < 1e-7)
      break;
  }
  std::vector<double> squares;
  for (const double share : shares)
    squares.push_back((1 / share - 1) / (vibration.step * vibration.step));
  return squares;
}

bool has_tables() {
  return std::getenv("WEFT_TEST_DATA") != nullptr;
}

double table_value(const std::string& file, const std::string& column, double first) {
  const char* folder = std::getenv("WEFT_TEST_DATA");
  if (folder == nullptr)
    throw SceneError("", "WEFT_TEST_DATA", "an empty environment",
                     "the folder that holds physics/" + file);
  const std::string path = std::string(folder) + "/physics/" + file;
  std::ifstream stream(path);
  if (!stream) throw SceneError(path, "file", "what cannot be opened", "a readable file");
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    if (names.empty()) {
      names = cells;
      continue;
    }
    rows.emplace_back();
    for (const std::string& cell : cells) rows.back().push_back(std::strtod(cell.c_str(), nullptr));
  }
  const auto name = std::find(names.begin(), names.end(), column);
  if (name == names.end()) throw SceneError(path, "column", column, "a column of the table");
  const auto c = static_cast<std::size_t>(name - names.begin());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].size() != names.size()) throw SceneError(path, "row", "a short row", "whole rows");
    if (std::abs(rows[r][0] - first) <= 1e-9 * (1 + std::abs(first))) return rows[r][c];
    if (r == 0 || rows[r][0] < first || rows[r - 1][0] > first) continue;
    const double share = std::log(first / rows[r - 1][0]) / std::log(rows[r][0] / rows[r - 1][0]);
    return rows[r - 1][c] * std::pow(rows[r][c] / rows[r - 1][c], share);
  }
  throw SceneError(path, names[0], fmt::format("{}", first), "a value within the table");
}

}  // namespace weft::physics
