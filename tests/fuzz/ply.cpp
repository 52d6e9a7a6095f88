#include "host/io/mesh/mesh_formats.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {

void ply(std::string_view input) {
  accepted([&] { return io::parse_ply(input, "input.ply", io::Uv::ignore); });
  const auto mesh = accepted([&] { return io::parse_ply(input, "input.ply", io::Uv::material); });
  if (!mesh) return;
  require_whole(*mesh);
  const std::string bytes =
      io::format_ply({{"", *mesh}}, Precision::double_precision, io::Normals::vertex);
  require(same_mesh(*mesh, io::parse_ply(bytes, "again.ply", io::Uv::material)),
          "the mesh is another once it is written and read");
}

}  // namespace weft::fuzz
