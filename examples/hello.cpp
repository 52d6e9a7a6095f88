// A sheet of cotton falls onto a ball, and its last frame becomes hello.obj.
#include <cstdio>
#include <weft/io.hpp>
#include <weft/shapes.hpp>
#include <weft/weft.hpp>

int main() try {
  weft::Scene scene;
  const auto cotton = scene.add(weft::fabric("cotton_polyester"));
  weft::Mesh sheet = weft::make_grid({1, 1}, {40, 40});
  for (auto& x : sheet.positions) x[2] += 0.35;
  const auto cloth = scene.add(weft::Cloth{.name = "sheet", .mesh = sheet, .material = cotton});
  scene.add(weft::Obstacle{.name = "ball", .mesh = weft::make_icosphere(0.3, 3)});

  weft::Simulation simulation(scene, weft::auto_device());
  for (int frame = 0; frame < 25; ++frame)
    if (const auto result = simulation.advance(1.0 / 25); !result)
      return std::fprintf(stderr, "%s\n", result.message().c_str()), 4;

  sheet.positions = simulation.frame().cloth_positions[cloth];
  weft::save_mesh("hello.obj", sheet);
  std::printf("%.2f s: the middle lies at a height of %.3f m\n", simulation.time(),
              simulation.positions(cloth)[sheet.positions.size() / 2][2]);
} catch (const weft::SceneError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 2;
} catch (const weft::DeviceError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}
