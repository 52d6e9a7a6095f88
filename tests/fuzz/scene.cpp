#include "host/io/scene/scene_file.hpp"
#include "host/scene/validate.hpp"
#include "tests/fuzz/documents.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {

void scene(std::string_view input) {
  const auto document = small_document(input);
  if (!document) return;
  put_parts();
  const Inside inside;
  const auto path = put("input.json", document->dump());
  const auto read = accepted([&] { return io::read_scene_file(path); });
  if (!read) return;
  validate(read->scene);
  const auto again = put("again.json", read->resolved.dump());
  require(io::resolved_scene_json(again) == read->resolved,
          "the resolved scene resolves to another");
}

}  // namespace weft::fuzz
