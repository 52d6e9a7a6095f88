// Fills a scene by hand, lets weft check and step it, and prints what weft it is.
#include <cstring>
#include <iostream>

#include "weft/error.hpp"
#include "weft/scene.hpp"
#include "weft/simulation.hpp"
#include "weft/version.hpp"

namespace {

/// One square metre of cloth, two triangles, held at one corner.
weft::Scene square_scene() {
  weft::Scene scene;
  scene.name = "square";

  weft::Material cotton;
  cotton.name = "cotton";
  scene.materials.push_back(cotton);

  weft::Cloth cloth;
  cloth.name = "square";
  cloth.mesh.positions = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  cloth.mesh.material = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  cloth.mesh.triangles = {weft::Tri{{0, 1, 2}}, weft::Tri{{0, 2, 3}}};
  scene.cloths.push_back(cloth);

  weft::Pin pin;
  pin.vertices = {0};
  scene.pins.push_back(pin);
  return scene;
}

}  // namespace

int main() {
  try {
    weft::Scene scene = square_scene();
    weft::validate(scene);

    weft::Simulation simulation(scene, weft::host_devices(2));
    if (simulation.step().failure != weft::Failure::none ||
        !(simulation.frame().cloth_positions[0][2][2] < 1)) {
      std::cerr << "the free corner does not fall\n";
      return 1;
    }

    scene.materials[0].density = -1;
    try {
      weft::validate(scene);
      std::cerr << "a negative density passed the check\n";
      return 1;
    } catch (const weft::SceneError&) {
    }

    const weft::BuildInfo& info = weft::build_info();
    if (std::strcmp(info.version, WEFT_VERSION) != 0) {
      std::cerr << "headers " << WEFT_VERSION << ", library " << info.version << "\n";
      return 1;
    }
    std::cout << "weft " << info.version << " (" << info.commit << (info.dirty ? ", dirty" : "")
              << "), " << info.compiler << ", " << info.build_type << "\n";
  } catch (const weft::SceneError& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
