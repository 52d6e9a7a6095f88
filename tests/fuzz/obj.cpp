#include "host/geometry/mesh_check.hpp"
#include "host/geometry/mesh_repair.hpp"
#include "host/io/arcsim/arcsim_obj.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {

void obj(std::string_view input) {
  accepted([&] { return io::read_arcsim_extras(put("input.obj", input)); });
  accepted([&] { return io::parse_obj(input, "input.obj", io::Uv::ignore); });
  const auto loose = accepted([&] { return io::parse_obj(input, "input.obj", io::Uv::where_all); });
  if (loose) require_whole(*loose);
  const auto mesh = accepted([&] { return io::parse_obj(input, "input.obj", io::Uv::material); });
  if (!mesh) return;
  require_whole(*mesh);
  const std::string text = io::format_obj({{"", *mesh}}, io::Normals::vertex);
  require(same_mesh(*mesh, io::parse_obj(text, "again.obj", io::Uv::material)),
          "the mesh is another once it is written and read");
  Mesh repaired = *mesh;
  repair_mesh(repaired);
  accepted([&] {
    check_mesh(repaired, {"input.obj", "mesh", ""}, false);
    return true;
  });
}

}  // namespace weft::fuzz
