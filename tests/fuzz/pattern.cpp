#include <algorithm>
#include <cmath>

#include "host/geometry/mesh_check.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/pattern/garment.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"
#include "weft/shapes.hpp"

namespace weft::fuzz {
namespace {

/// [m] An edge length with which a pattern of any size has a few hundred triangles.
double coarse_edge(const io::SewingPattern& pattern) {
  double largest = 0;
  for (const io::PatternPanel& panel : pattern.panels)
    for (const Vec2<double>& p : panel.vertices)
      largest = std::max({largest, std::abs(p[0]), std::abs(p[1])});
  return std::max(largest, 1e-6) / 6;
}

}  // namespace

void pattern(std::string_view input) {
  const auto document = accepted([&] { return io::parse_json(input, "input.json"); });
  if (!document || !io::is_sewing_pattern(*document)) return;
  const auto read = accepted([&] { return io::read_sewing_pattern(*document, "input.json"); });
  if (!read || read->panels.size() > 20) return;
  const double edge = coarse_edge(*read);
  auto garment = accepted([&] { return io::make_garment(*read, edge); });
  if (!garment) return;
  require_whole(garment->mesh);
  for (const io::GarmentSeam& seam : garment->seams)
    for (const auto& pair : seam.pairs)
      for (const Index v : pair)
        require(v >= 0 && static_cast<std::size_t>(v) < garment->mesh.positions.size(),
                "a seam names a vertex that is not there");
  io::relax_start(*garment, edge, make_icosphere(0.1, 1));
  require_whole(garment->mesh);
  accepted([&] {
    check_mesh(garment->mesh, {"input.json", "mesh", ""}, true);
    return true;
  });
}

}  // namespace weft::fuzz
