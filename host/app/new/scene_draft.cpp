#include "host/app/new/scene_draft.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "host/input/safe_text.hpp"
#include "weft/version.hpp"

namespace weft::app {
namespace {

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string vector_text(const Vec3<double>& v) {
  return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", v[0] + 0.0, v[1] + 0.0, v[2] + 0.0);
}

/// Lines of one object or list, with commas between its values and none after the last.
class Block {
 public:
  Block(std::string open, char close) : open_(std::move(open)), close_(close) {}

  void comment(const std::string& text) {
    if (!text.empty()) pending_.push_back("// " + one_line(text));
  }
  void value(const std::string& key, const std::string& text) {
    entries_.push_back({std::move(pending_), {quoted(key) + ": " + text}});
    pending_.clear();
  }
  void block(const Block& inner) {
    entries_.push_back({std::move(pending_), inner.lines()});
    pending_.clear();
  }

  std::vector<std::string> lines() const {
    std::vector<std::string> all{open_};
    for (std::size_t e = 0; e < entries_.size(); ++e) {
      for (const std::string& line : entries_[e].comments) all.push_back("  " + line);
      for (const std::string& line : entries_[e].lines) all.push_back("  " + line);
      if (e + 1 < entries_.size()) all.back() += ',';
    }
    all.emplace_back(1, close_);
    return all;
  }

 private:
  struct Entry {
    std::vector<std::string> comments, lines;
  };
  std::string open_;
  char close_;
  std::vector<std::string> pending_;
  std::vector<Entry> entries_;
};

/// "key": [ one object ]
Block list_of(const std::string& key, const Block& object) {
  Block list(quoted(key) + ": [", ']');
  list.block(object);
  return list;
}

Block time_of(const SceneDraft& d) {
  Block time("\"time\": {", '}');
  time.comment("s; frames are hit exactly");
  time.value("step", "0.005");
  time.value("frame_rate", "25");
  time.comment(d.frames_reason);
  time.value("frames", std::to_string(d.frames));
  return time;
}

Block cloth_of(const SceneDraft& d) {
  Block cloth("{", '}');
  cloth.value("name", "\"cloth\"");
  cloth.comment(d.cloth_facts);
  cloth.value("mesh", quoted(d.cloth_file));
  if (d.textured) {
    cloth.comment("the texture coordinates are the flat pattern, scaled to the size of the mesh");
    cloth.value("uv", "\"fit\"");
  }
  if (!d.repaired.empty()) {
    cloth.comment("the mesh is refused without: " + d.repaired);
    cloth.value("repair", "true");
  }
  cloth.comment(d.fabric_facts);
  cloth.comment("others: weft info --fabrics; own numbers: \"materials\" in scenes/README.md");
  cloth.value("fabric", quoted(d.fabric));
  return cloth;
}

Block body_of(const SceneDraft& d) {
  Block body("{", '}');
  body.value("name", "\"body\"");
  body.value("mesh", quoted(d.body_file));
  if (d.repair_body) body.value("repair", "true");
  body.comment("Coulomb's coefficient against the cloth");
  body.value("friction", "0.3");
  return body;
}

Block floor_of(const SceneDraft& d) {
  Block floor("{", '}');
  floor.value("name", "\"floor\"");
  floor.comment("there is no body, so the cloth falls onto a floor");
  floor.value("plane", fmt::format("{{\"size\": [{0:.4g}, {0:.4g}]}}", 4 * d.cloth_size));
  floor.value("transform", "{\"translate\": " +
                               vector_text({d.cloth_centre[0], d.cloth_centre[1], *d.floor}) + "}");
  return floor;
}

Block pin_of(const SceneDraft& d) {
  Block pin("{", '}');
  pin.value("cloth", "\"cloth\"");
  pin.comment("m, z up: the vertices that start in this box, the upper rim, are held");
  pin.value("box", "{\"min\": " + vector_text(*d.pin_low) +
                       ", \"max\": " + vector_text(*d.pin_high) + "}");
  return pin;
}

Block contact_of(const SceneDraft& d) {
  Block contact("\"contact\": {", '}');
  if (d.thickness) {
    contact.comment(d.thickness_reason);
    contact.value("thickness", fmt::format("{:.3g}", *d.thickness));
  }
  if (!d.body_file.empty()) {
    contact.comment("moves cloth out of the body, and out of itself, before the first step");
    contact.value("untangle", "true");
  }
  return contact;
}

Block camera_of(const CameraKey& key) {
  Block camera("\"camera\": {", '}');
  camera.comment("m, z up; of pictures only. More keys with a \"time\" make it move");
  Block view("{", '}');
  view.value("position", vector_text(key.position));
  view.value("look_at", vector_text(key.look_at));
  view.value("field_of_view", fmt::format("{:.4g}", key.field_of_view * 180 / std::numbers::pi));
  camera.block(list_of("keys", view));
  return camera;
}

}  // namespace

std::string draft_text(const SceneDraft& d, Comments comments) {
  Block scene("{", '}');
  scene.value("name", quoted(d.name));
  scene.comment("of the coordinates in the mesh files. " + d.units.reason);
  scene.value("units", quoted(d.units.value));
  scene.comment("axis of the mesh files that points up. " + d.up.reason);
  scene.value("up", quoted(d.up.value));
  scene.block(time_of(d));
  scene.block(list_of("cloths", cloth_of(d)));
  if (!d.body_file.empty()) scene.block(list_of("obstacles", body_of(d)));
  if (d.floor) scene.block(list_of("obstacles", floor_of(d)));
  if (d.pin_low) scene.block(list_of("pins", pin_of(d)));
  if (d.thickness || !d.body_file.empty()) scene.block(contact_of(d));
  if (d.camera) scene.block(camera_of(*d.camera));

  std::string text;
  if (comments == Comments::lines)
    text = fmt::format(
        "// Written by weft {}: {}\n"
        "// JSON with // comments, which weft reads; for programs that take plain JSON only, write "
        "it with --no-comments.\n"
        "// scenes/README.md lists all keys. Numbers here are SI units, and z is up.\n",
        WEFT_VERSION, one_line(d.command));
  for (const std::string& line : scene.lines())
    if (comments == Comments::lines || line.find_first_not_of(' ') == std::string::npos ||
        line.compare(line.find_first_not_of(' '), 2, "//") != 0)
      text += line + "\n";
  return text;
}

}  // namespace weft::app
