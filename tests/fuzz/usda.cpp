#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/usd/usd_file.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {
namespace {

constexpr std::size_t max_frames = 4;  // every frame reads its text again

/// Whether single precision, which USD has, holds it.
bool fits(const Mesh& mesh) {
  return std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Vec3<double>& x) {
    return length(x) < static_cast<double>(std::numeric_limits<float>::max());
  });
}

Mesh in_single(Mesh mesh) {
  for (Vec3<double>& x : mesh.positions) x = vec_cast<double>(vec_cast<float>(x));
  return mesh;
}

/// Through a spool into another file, and back.
void require_same_again(const Mesh& mesh) {
  const auto spool = folder() / "again.usda.spool";
  const auto path = folder() / "again.usda";
  io::SpoolWriter(spool, 25, {{"mesh", false}}).append(3, {&mesh});
  io::write_usd(path, io::SpoolReader(spool));
  const io::UsdFile again(path);
  require(again.meshes().size() == 1 && again.frame_rate() == 25,
          "the file is another once it is written and read");
  require(same_mesh(in_single(mesh), again.read(0, again.times()[0])),
          "the mesh is another once it is written and read");
}

}  // namespace

void usda(std::string_view input) {
  const auto path = put("input.usda", input);
  accepted([&] {
    const auto sequence = io::open_sequence(path);
    for (std::size_t k = 0; k < std::min(max_frames, sequence->frames().size()); ++k) {
      const io::FrameMeshes frame = sequence->read(k);
      for (const auto* meshes : {&frame.cloths, &frame.obstacles})
        for (const io::NamedMesh& named : *meshes) {
          require_whole(named.mesh);
          if (k == 0 && fits(named.mesh)) require_same_again(named.mesh);
        }
    }
    return true;
  });
}

}  // namespace weft::fuzz
