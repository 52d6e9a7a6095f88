// A cape of some 2,000 vertices on a body of some 10,000, at 60 frames a second: the program moves
// the body and the pins in every frame, and gives the cloth what time is left.
// usage: game_loop [SECONDS]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>
#include <weft/shapes.hpp>
#include <weft/weft.hpp>

namespace {

using Places = std::vector<weft::Vec3<double>>;

/// Turns places about the vertical axis, to and fro, and lets them nod.
Places swayed(const Places& places, double time) {
  const double angle = 0.6 * std::sin(2 * time), nod = 0.02 * std::sin(5 * time);
  const double c = std::cos(angle), s = std::sin(angle);
  Places moved;
  for (const auto& x : places)
    moved.push_back({c * x[0] - s * x[1], s * x[0] + c * x[1], x[2] + nod});
  return moved;
}

}  // namespace

int main(int argc, char** argv) try {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 3;
  constexpr double tick = 1.0 / 60;

  weft::Scene scene;
  scene.time.step = tick;
  scene.time.frame_rate = 60;
  const auto cotton = scene.add(weft::fabric("cotton_polyester"));
  const Places body_places = weft::make_icosphere(0.3, 5).positions;
  const auto body = scene.add(weft::LiveObstacle(weft::make_icosphere(0.3, 5)));
  weft::Mesh cape = weft::make_grid({0.5, 0.7}, {36, 54});
  for (auto& x : cape.positions) x = {x[0], -0.32, x[1] - 0.1};
  const auto cloth = scene.add(weft::Cloth{.name = "cape", .mesh = cape, .material = cotton});
  std::vector<weft::Index> top;
  for (weft::Index i = 0; i <= 36; i += 4) top.push_back(54 * 37 + i);
  Places top_places;
  for (const auto v : top) top_places.push_back(cape.positions[static_cast<std::size_t>(v)]);
  const auto collar = scene.pin(cloth, top);

  weft::Simulation simulation(scene, weft::host_devices(2));
  std::vector<double> milliseconds;
  while (simulation.time() < seconds - tick / 2) {
    const auto start = std::chrono::steady_clock::now();
    const double next = simulation.time() + tick;
    simulation.move(body, swayed(body_places, next));
    simulation.move(collar, swayed(top_places, next));
    const auto result = simulation.advance(tick, {.budget = std::chrono::milliseconds(14)});
    if (!result) return std::fprintf(stderr, "%s\n", result.message().c_str()), 4;
    const auto vertices = simulation.positions(cloth);  // for a renderer
    (void)vertices;
    milliseconds.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  std::printf(
      "%zu vertices of cloth on %zu of a body: %zu frames of %.1f ms, median %.1f ms, 95 %% below "
      "%.1f ms\n",
      cape.positions.size(), body_places.size(), milliseconds.size(), 1000 * tick,
      milliseconds[milliseconds.size() / 2], milliseconds[milliseconds.size() * 95 / 100]);
} catch (const weft::SceneError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 2;
} catch (const weft::DeviceError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}
