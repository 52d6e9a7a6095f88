#include "host/io/arcsim/arcsim_material.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {

void material(std::string_view input) {
  const auto path = put("material.json", input);
  bool averaged = false;
  accepted([&] { return io::read_arcsim_material(path, {}, averaged); });
}

}  // namespace weft::fuzz
