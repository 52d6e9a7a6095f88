// Two panels in front of and behind a body are sewn along their sides into a skirt, whose upper
// edge is held; the last frame becomes garment.obj.
#include <cstdio>
#include <weft/io.hpp>
#include <weft/shapes.hpp>
#include <weft/weft.hpp>

namespace {

constexpr weft::Index columns = 20, rows = 24;
constexpr double width = 0.5, height = 0.6;

/// A panel that stands upright, its front outwards.
/// @param y [m] where it stands
weft::Mesh panel(double y) {
  weft::Mesh mesh = weft::make_grid({width, height}, {columns, rows});
  const double side = y < 0 ? 1 : -1;
  for (auto& x : mesh.positions) x = {side * x[0], y, x[1]};
  return mesh;
}

}  // namespace

int main() try {
  weft::Scene scene;
  scene.time.step = 0.01;
  const auto knit = scene.add(weft::fabric("interlock"));
  scene.add(weft::Obstacle{.name = "body", .mesh = weft::make_capsule(0.1, 0.6, 6)});
  const auto front =
      scene.add(weft::Cloth{.name = "front", .mesh = panel(-0.13), .material = knit});
  const auto back = scene.add(weft::Cloth{.name = "back", .mesh = panel(0.13), .material = knit});
  for (const bool left : {true, false}) {
    weft::Seam seam{.cloths = {front, back}, .weld_distance = 0.002};
    for (weft::Index row = 0; row <= rows; ++row) {
      const weft::Index first = row * (columns + 1), last = first + columns;
      seam.vertices[0].push_back(left ? first : last);
      seam.vertices[1].push_back(left ? last : first);
    }
    scene.seams.push_back(seam);
  }
  for (const auto part : {front, back}) scene.pin(part, {rows * (columns + 1) + columns / 2});

  weft::Simulation simulation(scene, weft::auto_device());
  for (int frame = 0; frame < 40; ++frame)
    if (const auto result = simulation.advance(1.0 / 25); !result)
      return std::fprintf(stderr, "%s\n", result.message().c_str()), 4;
  for (const weft::SeamState& seam : simulation.seams())
    std::printf("%zu of %zu pairs open\n", static_cast<std::size_t>(seam.open),
                static_cast<std::size_t>(seam.pairs));

  weft::Mesh skirt;
  const weft::Frame frame = simulation.frame();
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const auto offset = static_cast<weft::Index>(skirt.positions.size());
    for (weft::Tri triangle : scene.cloths[c].mesh.triangles) {
      for (weft::Index& v : triangle.v) v += offset;
      skirt.triangles.push_back(triangle);
    }
    const auto& places = frame.cloth_positions[c];
    skirt.positions.insert(skirt.positions.end(), places.begin(), places.end());
  }
  weft::save_mesh("garment.obj", skirt);
} catch (const weft::SceneError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 2;
} catch (const weft::DeviceError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}
