#include "host/io/arcsim/arcsim_scene.hpp"

#include "tests/fuzz/documents.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {

void arcsim_scene(std::string_view input) {
  const auto document = small_document(input);
  if (!document || !document->is_object()) return;
  put_parts();
  const Inside inside;
  io::is_arcsim_scene(*document);
  const auto scene =
      accepted([&] { return io::weft_scene_of(*document, folder() / "input.json"); });
  require(!scene || scene->scene.is_object(), "no scene");
}

}  // namespace weft::fuzz
