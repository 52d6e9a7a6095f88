// A curtain hangs by its upper edge; the program pushes a ball through it, lets one half of the
// edge go, and takes the last half second back to try it with wind.
#include <cstdio>
#include <vector>
#include <weft/shapes.hpp>
#include <weft/weft.hpp>

namespace {

constexpr double frame = 1.0 / 25;

/// Lets the ball come along the y axis for some frames.
/// @return whether nothing failed
bool push(weft::Simulation& simulation, weft::ObstacleId ball, const weft::Mesh& shape,
          int frames) {
  for (int f = 0; f < frames; ++f) {
    std::vector<weft::Vec3d> places = shape.positions;
    for (auto& x : places) x[1] += simulation.time() + frame;  // 1 m/s
    simulation.move(ball, places);
    if (const auto result = simulation.advance(frame); !result)
      return std::fprintf(stderr, "%s\n", result.message().c_str()), false;
  }
  return true;
}

}  // namespace

int main() try {
  weft::Scene scene;
  const auto polyester = scene.add(weft::fabric("polyester"));
  weft::Mesh curtain = weft::make_grid({0.8, 0.8}, {32, 32});
  for (auto& x : curtain.positions) x = {x[0], 0, x[1]};
  const auto cloth =
      scene.add(weft::Cloth{.name = "curtain", .mesh = curtain, .material = polyester});
  std::vector<weft::Index> left, right;
  for (weft::Index i = 0; i <= 32; ++i) (i < 16 ? left : right).push_back(32 * 33 + i);
  scene.pin(cloth, left);
  const auto released = scene.pin(cloth, right);
  weft::Mesh shape = weft::make_icosphere(0.15, 3);
  for (auto& x : shape.positions) x[1] -= 0.4;
  const auto ball = scene.add(weft::LiveObstacle(shape));

  weft::Simulation simulation(scene, weft::auto_device());
  if (!push(simulation, ball, shape, 10)) return 4;
  simulation.release(released);
  const auto state = simulation.state();
  const std::size_t corner = 32 * 33 + 32;
  for (const double wind : {0.0, -4.0}) {
    simulation.restore(state);
    simulation.set_wind({1.2, {0, wind, 0}, 0});
    if (!push(simulation, ball, shape, 12)) return 4;
    const weft::Vec3f x = simulation.positions(cloth)[corner];
    std::printf("wind of %2.0f m/s: the corner is at (%.2f, %.2f, %.2f)\n", wind, x[0], x[1], x[2]);
  }
} catch (const weft::SceneError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 2;
} catch (const weft::DeviceError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}
