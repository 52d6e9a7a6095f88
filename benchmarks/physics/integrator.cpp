// The time integrator does what it says, on a single triangle that moves as a whole.
#include <cmath>
#include <complex>
#include <numbers>

#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"

namespace weft::physics {
namespace {

using Complex = std::complex<double>;

constexpr double corner_mass = 0.001;  // [kg]

std::vector<Parameter> integrator_parameter() {
  return {{"integrator", "implicit_euler", "implicit_euler or bdf2"}};
}

Integrator integrator_of(const Parameters& p) {
  return p.one_of("integrator", {"implicit_euler", "bdf2"}) == "bdf2" ? Integrator::bdf2
                                                                      : Integrator::implicit_euler;
}

/// A triangle of 0.06 kg/m^2 and 0.05 m^2.
Scene triangle(double step, Integrator integrator) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0.5, 0, 0}, {0, 0.2, 0}};
  mesh.material = {{0, 0}, {0.5, 0}, {0, 0.2}};
  mesh.triangles = {{{0, 1, 2}}};
  Material material;
  material.density = 3 * corner_mass / 0.05;
  Scene scene = make_scene(std::move(mesh), material, step);
  scene.solver.tolerance = 1e-13;
  scene.integrator = integrator;
  return scene;
}

/// The same on springs of angular frequency w, thrown upwards at 1 m/s.
Scene oscillator(double w, double step, Integrator integrator) {
  Scene scene = triangle(step, integrator);
  scene.cloths[0].velocity = {0, 0, 1};
  Handle handle;
  handle.vertices = {0, 1, 2};
  handle.stiffness = corner_mass * w * w;
  scene.handles = {handle};
  return scene;
}

/// v + i w x, which the exact motion turns by i w t and leaves at its length.
Complex phasor(const Simulation& simulation, double w) {
  const Frame frame = simulation.frame();
  return {frame.cloth_velocities[0][0][2], w * frame.cloth_positions[0][0][2]};
}

/// Amplitude a step loses, against the root of the formula's characteristic polynomial.
Outcome amplitude(const Parameters& p) {
  const double wh = p.positive("wh");
  const int steps = p.count("steps");
  const Integrator integrator = integrator_of(p);
  Simulation simulation = start(oscillator(wh / 0.01, 0.01, integrator));
  // BDF2 has a second root, which is that of a start in which no history was there.
  advance(simulation, 30);
  const double before = std::abs(phasor(simulation, wh / 0.01));
  advance(simulation, steps);
  const double after = std::abs(phasor(simulation, wh / 0.01));
  const Complex z(0, wh);
  const Complex root = integrator == Integrator::bdf2
                           ? (2.0 + std::sqrt(1.0 + 2.0 * z)) / (3.0 - 2.0 * z)
                           : 1.0 / (1.0 - z);
  return relative(std::pow(after / before, 1.0 / steps), std::abs(root), 0.01);
}

/// Distance fallen from rest.
Outcome free_fall(const Parameters& p) {
  const double h = p.positive("step");
  const int steps = p.count("steps");
  const double g = p.positive("gravity");
  const Integrator integrator = integrator_of(p);
  Scene scene = triangle(h, integrator);
  scene.gravity = {0, 0, -g};
  Simulation simulation = start(std::move(scene));
  advance(simulation, steps);
  const double t = h * steps;
  double expected = g * t * (t + h) / 2;
  if (integrator == Integrator::bdf2) {
    // v' = g, x' = v, the first step by implicit Euler.
    double v[2] = {0, g * h};
    double x[2] = {0, g * h * h};
    for (int n = 1; n < steps; ++n) {
      const double v_next = (4 * v[1] - v[0] + 2 * h * g) / 3;
      const double x_next = (4 * x[1] - x[0] + 2 * h * v_next) / 3;
      v[0] = v[1];
      x[0] = x[1];
      v[1] = v_next;
      x[1] = x_next;
    }
    expected = x[1];
  }
  return relative(-positions(simulation)[0][2], expected, 1e-10);
}

/// Order with which the error of an oscillation falls as the step is halved.
Outcome order(const Parameters& p) {
  const int steps = p.count("steps");
  const double time = p.positive("time");
  const Integrator integrator = integrator_of(p);
  double error[2];
  for (int fine = 0; fine < 2; ++fine) {
    const int count = steps << fine;
    Simulation simulation = start(oscillator(1, time / count, integrator));
    advance(simulation, count);
    error[fine] = std::abs(phasor(simulation, 1) - std::polar(1.0, time));
  }
  Outcome outcome =
      relative(std::log2(error[0] / error[1]), integrator == Integrator::bdf2 ? 2 : 1, 0.01);
  outcome.more = {{"error", error[0]}, {"error_half_step", error[1]}};
  return outcome;
}

}  // namespace

std::vector<Test> integrator_tests() {
  return {{"amplitude", "amplitude factor of a step; (1 + w^2 h^2)^(-1/2), or the root of BDF2",
           integrator_parameter() +
               std::vector<Parameter>{{"wh", "0.5", "angular frequency times step, > 0"},
                                      {"steps", "100", "measured over"}},
           amplitude},
          {"free_fall", "distance [m]; g t (t + h) / 2, or the recurrence of BDF2",
           integrator_parameter() + std::vector<Parameter>{{"step", "0.01", "[s]"},
                                                           {"steps", "50", "from rest"},
                                                           {"gravity", "9.81", "[m/s^2]"}},
           free_fall},
          {"order", "observed order on a harmonic oscillator of 1 rad/s; 1, or 2 for BDF2",
           integrator_parameter() +
               std::vector<Parameter>{{"steps", "200", "and twice as many"}, {"time", "2", "[s]"}},
           order}};
}

}  // namespace weft::physics
