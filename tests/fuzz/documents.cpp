#include "tests/fuzz/documents.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include "host/io/json/json_fields.hpp"
#include "tests/fuzz/harness.hpp"

namespace weft::fuzz {
namespace {

using nlohmann::json;

constexpr std::size_t max_parts = 4;
constexpr double max_count = 8;

constexpr std::string_view cotton_json = R"({"density": 0.15,
"stretching": [[30, 10, 30, 20], [30, 10, 30, 20], [30, 10, 30, 20],
               [30, 10, 30, 20], [30, 10, 30, 20], [30, 10, 30, 20]],
"bending": [[1e-5, 1e-5, 1e-5, 1e-5, 1e-5], [1e-5, 1e-5, 1e-5, 1e-5, 1e-5],
            [1e-5, 1e-5, 1e-5, 1e-5, 1e-5]]})";

constexpr std::string_view walk_mot =
    "NumFrames: 2\nbody[0] position\n0 0 0\n0 0 1\nbody[0] rotation\n1 0 0 0\n0 1 0 0\n";

constexpr std::string_view walk_bvh =
    "HIERARCHY\nROOT hips\n{\nOFFSET 0 0 0\nCHANNELS 1 Yrotation\nEnd Site\n{\nOFFSET 0 2 0\n}\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.1\n0\n90\n";

constexpr std::string_view tube_json = R"({"pattern": {"panels": {
"front": {"translation": [0, 0, 20], "vertices": [[0, 0], [40, 0], [40, 30], [0, 30]],
 "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]},
"rear": {"translation": [0, 0, -20], "vertices": [[0, 0], [0, 30], [40, 30], [40, 0]],
 "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]}},
"stitches": [[{"panel": "front", "edge": 1}, {"panel": "rear", "edge": 2}]]}})";

/// Whether a text in the document could name a file elsewhere.
bool leaves_folder(const json& value) {
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    return text.find('/') != std::string::npos || text.find("..") != std::string::npos;
  }
  return value.is_structured() && std::any_of(value.begin(), value.end(),
                                              [](const json& part) { return leaves_folder(part); });
}

/// Numbers that are allowed but large become small ones; what is too large anyway stays.
void make_small(json& value, double most) {
  if (value.is_array())
    for (json& part : value) make_small(part, most);
  if (value.is_number() && value.get<double>() > most && value.get<double>() < 1e8) value = most;
}

void make_small_below(json& value) {
  if (value.is_array())
    for (json& part : value) make_small_below(part);
  if (!value.is_object()) return;
  for (auto& [key, part] : value.items()) {
    if (key == "cells" || key == "count") make_small(part, max_count);
    if (key == "subdivisions" || key == "levels") make_small(part, 2);
    if (key == "triangles") make_small(part, 200);
    if (key == "edge" && part.is_number() && part.get<double>() < 0.1) part = 0.1;
    if ((key == "cloths" || key == "obstacles" || key == "garments") && part.is_array() &&
        part.size() > max_parts)
      part.erase(part.begin() + max_parts, part.end());
    make_small_below(part);
  }
}

}  // namespace

std::optional<json> small_document(std::string_view input) {
  auto document = accepted([&] { return io::parse_json(input, "input.json"); });
  if (!document || leaves_folder(*document)) return {};
  make_small_below(*document);
  if (document->is_object() && !document->contains("triangles") &&
      !document->contains("timestep") && !document->contains("frame_time"))
    (*document)["triangles"] = 200;
  return document;
}

void put_parts() {
  static bool done = false;
  if (done) return;
  put("square.obj", square_obj);
  put("body_0.obj", square_obj);
  put("body_1.obj", square_obj);
  put("cotton.json", cotton_json);
  put("tube.json", tube_json);
  put("walk.mot", walk_mot);
  put("walk.bvh", walk_bvh);
  done = true;
}

}  // namespace weft::fuzz
