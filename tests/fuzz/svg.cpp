#include <memory>

#include "host/io/pattern/outline_file.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {

void svg(std::string_view input) {
  const auto outlines = accepted([&] {
    return std::shared_ptr<io::OutlineFile>(io::parse_svg_outlines(input, "input.svg", {}));
  });
  if (outlines) require_panels(**outlines);
}

}  // namespace weft::fuzz
