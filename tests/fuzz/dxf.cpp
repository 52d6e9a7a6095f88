#include <cmath>
#include <memory>
#include <optional>

#include "host/io/pattern/outline_file.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {

void require_panels(const io::OutlineFile& outlines) {
  const auto names = accepted([&] { return outlines.names(); });
  if (!names) return;
  for (std::size_t k = 0; k < names->size() && k < 20; ++k) {
    const auto panel = accepted([&] { return outlines.panel((*names)[k], "field"); });
    if (!panel) continue;
    require(panel->edges.size() >= 2 && panel->edges.size() == panel->vertices.size(),
            "a panel has other edges than corners");
    for (std::size_t e = 0; e < panel->edges.size(); ++e)
      require(panel->edges[e].from == static_cast<Index>(e) &&
                  panel->edges[e].to == static_cast<Index>((e + 1) % panel->edges.size()),
              "a panel is open");
    for (const Vec2<double>& p : panel->vertices)
      require(std::abs(p[0]) <= 400 && std::abs(p[1]) <= 400, "a vertex is far away");
  }
}

void dxf(std::string_view input) {
  for (const std::optional<double> unit : {std::optional<double>(), std::optional<double>(0.001)}) {
    const auto outlines = accepted([&] {
      return std::shared_ptr<io::OutlineFile>(io::parse_dxf_outlines(input, "input.dxf", unit));
    });
    if (outlines) require_panels(**outlines);
  }
}

}  // namespace weft::fuzz
