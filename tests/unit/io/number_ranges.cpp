#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "host/input/quantity.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/scene/scene_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

/// Every number of a scene, set to what no scene has: the reader refuses it by name, or the scene
/// can be simulated.
namespace weft::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Scenes that have every numeric key of the schema between them, each small and quick.
const std::vector<std::string>& bases() {
  static const std::vector<std::string> all{
      // settings
      R"({"triangles": 100, "gravity": [0, 0, -9.81], "jitter": {"amplitude": 0.001},
          "time": {"step": 0.01, "tolerance": 0.02, "frame_rate": 50, "frames": 2},
          "materials": {"m": {}}, "cloths": [{"grid": {"size": [1, 1]}, "material": "m"}],
          "contact": {"thickness": 0.001, "friction": 0.3, "compliance_distance": 0.1},
          "experimental": {"jitter.seed": 1, "solver.max_iterations": 2000, "contact.zone_rounds": 60, "contact.substep_bisections": 5,
                           "solver.partial_rows": 0, "solver.newton_tolerance": 1e-6},
          "solver": {"tolerance": 0.01, "newton_iterations": 1},
          "output": {"checkpoint_every": 5}})",
      // settings of methods
      R"({"time": {"step": 0.01, "frame_rate": 50, "frames": 2},
          "materials": {"m": {}},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m"}],
          "solver": {"newton_iterations": 2},
          "remeshing": {"size": [0.3, 0.6], "refine_angle": 0.3, "refine_compression": 0.005,
                        "refine_velocity": 0.5},
          "camera": {"resolution": [64, 48],
                     "keys": [{"time": 0, "position": [0, -3, 2], "look_at": [0, 0, 0],
                               "up": [0, 0, 1], "field_of_view": 40},
                              {"time": 1, "position": [1, -3, 2], "look_at": [0, 0, 0]}]},
          "experimental": {"method.implicit.sleep_window": 0.2,
                           "remeshing.aspect_min": 0.2, "remeshing.flip_threshold": 0.01,
                           "remeshing.energy_share": 0.002,
                           "method.asynchronous.stiffness": 1000, "method.asynchronous.restitution": 0,
                           "method.asynchronous.window": 0.003,
                           "method.asynchronous.smallest_step": 1e-9,
                           "method.asynchronous.layers": 1000,
                           "method.asynchronous.rollbacks": 1000,
                           "method.view.transfer_threshold": 0.1,
                           "method.view.compensation_power": 10,
                           "method.view.anticipation": 5, "method.view.pixel_min": 4,
                           "method.time_parallel.coarse_thickness": 1, "method.time_parallel.coarsening": 5,
                           "method.time_parallel.coarse_step": 0.02,
                           "method.time_parallel.blend_frames": 0,
                           "method.view.factor_back": 0.2, "method.view.margin": 0.4,
                           "method.time_parallel.coarse_newton_iterations": 2,
                           "method.time_parallel.boundary_tolerance": 2,
                           "method.time_parallel.ratio": 100,
                           "method.time_parallel.coarse_newton_tolerance": 0.1,
                           "method.time_parallel.coarse_tolerance": 0.01,
                           "method.time_parallel.recovery.factor": 10,
                           "method.time_parallel.recovery.iterations": -1,
                           "method.time_parallel.recovery.tolerance": 0.001},
          "method": {"implicit": {"sleep_distance": 0},
                     "view": {"factor_out": 0.01},
                     "time_parallel": {"slices": 0}}})",
      // materials
      R"({"materials": {"m": {"density": 0.2, "stretch_stiffness": 1000, "poisson_ratio": 0.3,
                              "bending_stiffness": 1e-5,
                              "damping": {"mass": 0.1, "stiffness": 0.001}}},
          "wind": {"density": 0, "velocity": [3, 0, 0], "drag": 0.1},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m"}]})",
      R"({"materials": {"m": {"orthotropic": {"stretch_stiffness": [900, 500],
                                              "poisson_ratio": 0.1, "shear_stiffness": 300},
                              "orthotropic_bending": {"stiffness": [1e-5, 2e-5],
                                                      "coupling": 1e-6, "twist": 5e-6},
                              "strain_limits": [0.9, 1.1]}},
          "wind": {"density": 1.2, "velocity": [3, 0, 0], "drag": 0.1},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "pressure": 5}]})",
      R"({"materials": {"m": {"measured": {"stretching": [
            [50, 10, 40, 20], [55, 0, 1, 2], [52, 1, 2, 3], [51, 3, 4, 5], [50, 1, 3, 4],
            [49, 2, 1, 1]]}}},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m"}]})",
      // cloths
      R"({"materials": {"m": {}},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "transform": {"translate": [0, 0, 3], "rotate": [10, 0, 0, 1], "scale": 1},
                      "velocity": [0, 0, 1], "angular_velocity": [0, 0, 1],
                      "copies": {"count": 2, "translate": [0, 0, 1], "rotate": [5, 0, 0, 1]}},
                     {"panel": {"outline": [[0, 0.5], [1, -0.4, 0.6]], "cells": [2, 2]},
                      "material": "m"}]})",
      R"({"materials": {"m": {}},
          "cloths": [{"disc": {"radius": 0.5, "inner_radius": 0.1, "cells": 2}, "material": "m"},
                     {"cylinder": {"radius": 0.3, "height": 0.5, "cells": [6, 2]},
                      "material": "m", "transform": {"translate": [0, 0, 3]}},
                     {"ribbon": {"width": 0.2, "path": [[0, 0, 5], [1, 0, 5], [2, 0.5, 5]],
                                 "across": [0, 0, 1], "cells": [6, 2]}, "material": "m"}]})",
      // obstacles
      R"({"materials": {"m": {}},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "transform": {"translate": [0, 0, 3]}}],
          "obstacles": [
            {"sphere": {"radius": 0.5, "subdivisions": 0}, "friction": 0.3,
             "transform": {"translate": [0, 0, 0], "rotate": [10, 0, 0, 1], "scale": 1}},
            {"box": {"size": [1, 1, 1], "cells": [1, 1, 1]},
             "motion": [{"time": 0, "translate": [0, 0, 0], "rotate": [0, 0, 0, 1], "scale": 1},
                        {"time": 1, "translate": [1, 0, 0]}]},
            {"plane": {"size": [4, 4], "cells": [1, 1]}}]})",
      R"({"materials": {"m": {}},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "transform": {"translate": [0, 0, 3]}}],
          "obstacles": [
            {"capsule": {"radius": 0.2, "length": 0.5, "subdivisions": 0}},
            {"revolution": {"profile": [[0.3, 0], [0.4, 0.5]], "edge": 0.3}}]})",
      R"({"method": {"type": "asynchronous"}, "materials": {"m": {}},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "transform": {"translate": [0, 0, 3]}}],
          "obstacles": [
            {"sphere": {"radius": 0.5, "subdivisions": 0},
             "driven": {"axis": [0, 0, 1], "inertia": 0.1, "torque": 1,
                        "start_time": 0, "end_time": 2}}]})",
      // bodies
      R"({"materials": {"m": {}},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "transform": {"translate": [0, 0, 30]}}],
          "obstacles": [
            {"sequence": {"files": "frame_%d.obj", "first": 0, "last": 1, "frame_rate": 25,
                          "start_time": 0, "speed": 1}},
            {"capture": {"file": "take.bvh", "radius": 0.05, "first": 0, "last": 2,
                         "start_time": 0, "speed": 1}, "units": "cm"},
            {"capture": {"file": "take.bvh", "height": 1.7, "radius": {"Hips": 0.05}}}]})",
      R"({"materials": {"m": {}},
          "cloths": [{"grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "transform": {"translate": [0, 0, 30]}}],
          "obstacles": [{"skinned": {"file":
            "/usr/share/assimp/models/glTF2/glTF-Sample-Models/AnimatedMorphCube-glTF/AnimatedMorphCube.gltf",
            "animation": 0, "start_time": 0, "speed": 1}}]})",
      // what holds cloth
      R"({"materials": {"m": {}},
          "cloths": [{"name": "c", "grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m"}],
          "pins": [{"cloth": "c", "vertices": [0, 1], "release_time": 1,
                    "motion": [{"time": 0, "translate": [0, 0, 0], "rotate": [0, 0, 0, 1]},
                               {"time": 1, "translate": [0, 0, 1], "scale": 1}]},
                   {"cloth": "c", "edge": {"name": "top", "from": 0, "to": 0.5}},
                   {"cloth": "c", "box": {"min": [0.4, -0.1, -1], "max": [2, 0.1, 1]}}]})",
      R"({"materials": {"m": {}},
          "cloths": [{"name": "c", "grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m"}],
          "handles": [{"cloth": "c", "vertices": [0], "stiffness": 100, "along": [0, 1, 0], "start_time": 0,
                       "end_time": 1, "fade_time": 0.1,
                       "motion": [{"time": 0, "translate": [0, 0, 0], "rotate": [0, 0, 0, 1]},
                                  {"time": 1, "translate": [0, 0, 1], "scale": 1}]},
                      {"cloth": "c", "glue": [2, 8]},
                      {"cloth": "c", "edge": {"name": "top", "from": 0, "to": 0.5}},
                      {"cloth": "c", "box": {"min": [0.4, -0.1, -1], "max": [2, 0.1, 1]},
                       "circle": {"circumference": 1, "direction": [1, 0], "center": [0, 0, 0],
                                  "axis0": [1, 0, 0], "axis1": [0, 1, 0]}}]})",
      R"({"materials": {"m": {}},
          "cloths": [{"name": "a", "grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m"},
                     {"name": "b", "grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "transform": {"translate": [1.2, 0, 0]}}],
          "refine": {"when": "sewn", "levels": 1},
          "seams": [{"cloths": ["a", "b"], "pairs": [[2, 0]], "stiffness": 1000, "start_time": 0,
                     "ramp_time": 0.5, "weld_distance": 0.001},
                    {"cloths": ["a", "b"], "chains": [[5, 8], [3, 6]]}]})",
      R"({"materials": {"m": {}},
          "cloths": [{"name": "a", "grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m"},
                     {"name": "b", "grid": {"size": [1, 1], "cells": [2, 2]}, "material": "m",
                      "transform": {"translate": [1.2, 0, 0]}}],
          "seams": [{"between": [{"cloth": "a", "vertices": [2]},
                                 {"cloth": "b", "box": {"min": [0.5, -0.7, -1],
                                                        "max": [0.8, -0.3, 1]}}]},
                    {"between": [{"cloth": "a", "edge": {"name": "right", "from": 0.4, "to": 1}},
                                 {"cloth": "b", "edge": {"name": "left", "from": 0.4,
                                                         "to": 1}}]}]})",
      // garments
      R"({"garments": [{"pattern": "bag.json", "edge": 0.1, "layer": 1,
                        "attach": [{"panel": "front", "edge": 2, "along": [0, 0, 1], "at": 0.3,
                                    "end_time": 0.5}]}]})",
  };
  return all;
}

/// Pointers to every number of a document.
void collect_numbers(const json& value, const json::json_pointer& at,
                     std::vector<json::json_pointer>& found) {
  if (value.is_number()) found.push_back(at);
  if (value.is_object())
    for (const auto& [key, entry] : value.items()) collect_numbers(entry, at / key, found);
  if (value.is_array())
    for (std::size_t k = 0; k < value.size(); ++k) collect_numbers(value[k], at / k, found);
}

/// The last key of a path that is no place in a list.
std::string key_of(json::json_pointer at) {
  const auto is_place = [](const std::string& token) {
    return token.find_first_not_of("0123456789") == std::string::npos;
  };
  while (is_place(at.back())) at.pop_back();
  return at.back();
}

/// Whether a message names the last key of a path, or one that it has to fit.
bool names(const std::string& refusal, const json::json_pointer& place) {
  for (const std::string& text :
       {key_of(place), std::string(" intersect"), std::string("seams"),
        std::string("orthotropic.poisson_ratio"), std::string("camera.keys[0].up"),
        std::string("time.step"), std::string("jitter.amplitude")})
    if (refusal.find(text) != std::string::npos) return true;
  return false;
}

/// A path with [] for places in lists; free names are *.
std::string pattern_of(json::json_pointer at) {
  std::vector<std::string> tokens;
  for (; !at.empty(); at.pop_back()) tokens.insert(tokens.begin(), at.back());
  std::string pattern;
  for (std::size_t k = 0; k < tokens.size(); ++k) {
    const bool place = tokens[k].find_first_not_of("0123456789") == std::string::npos;
    const bool free = k > 0 && (tokens[k - 1] == "materials" ||
                                (tokens[k - 1] == "radius" && tokens[k] == "Hips"));
    pattern += place ? "[]" : "." + (free ? "*" : tokens[k]);
  }
  return pattern;
}

class Schema {
 public:
  explicit Schema(json root) : root_(std::move(root)) {}

  /// Patterns of all numbers that a scene may have.
  std::set<std::string> numbers() {
    visit(root_, "");
    return found_;
  }

 private:
  void visit(const json& node, const std::string& at) {
    if (!node.is_object()) return;
    if (node.contains("$ref")) {
      const auto ref = node.at("$ref").get<std::string>();
      visit(root_.at(json::json_pointer(ref.substr(1))), at);
    }
    if (node.contains("type")) {
      const json& type = node.at("type");
      for (const char* number : {"number", "integer"})
        if (type == number || (type.is_array() && type.front() == number)) found_.insert(at);
    }
    // The one list of numbers that the schema gives by its values.
    if (node.contains("enum") && node.at("enum").front().is_number()) found_.insert(at);
    if (node.contains("properties"))
      for (const auto& [key, entry] : node.at("properties").items()) visit(entry, at + "." + key);
    if (node.contains("additionalProperties")) visit(node.at("additionalProperties"), at + ".*");
    if (node.contains("items")) visit(node.at("items"), at + "[]");
    for (const char* several : {"prefixItems", "oneOf", "anyOf"})
      if (node.contains(several))
        for (const json& entry : node.at(several))
          visit(entry, several == std::string("prefixItems") ? at + "[]" : at);
  }

  json root_;
  std::set<std::string> found_;
};

bool finite(const Frame& frame) {
  for (const auto* parts : {&frame.cloth_positions, &frame.obstacle_positions})
    for (const auto& positions : *parts)
      for (const auto& x : positions)
        for (int k = 0; k < 3; ++k)
          if (!std::isfinite(x[k])) return false;
  return true;
}

class NumberRangesTest : public DirectoryTest {
 protected:
  void SetUp() override {
    for (const auto& [name, z] : {std::pair("frame_0.obj", "0"), {"frame_1.obj", "1"}})
      put(name, std::string("v 0 0 ") + z + "\nv 1 0 " + z + "\nv 0 1 " + z + "\nf 1 2 3\n");
    put("bag.json", R"({"pattern": {"panels": {
      "front": {"translation": [0, 0, 10], "vertices": [[0, 0], [40, 0], [40, 30], [0, 30]],
                "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]},
                          {"endpoints": [3, 0]}]},
      "rear": {"translation": [0, 0, -10], "vertices": [[0, 0], [0, 30], [40, 30], [40, 0]],
               "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]},
                         {"endpoints": [3, 0]}]}},
      "stitches": [[{"panel": "front", "edge": 1}, {"panel": "rear", "edge": 2}]]}})");
    put("take.bvh", R"(HIERARCHY
ROOT Hips { OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine { OFFSET 0 40 0 CHANNELS 3 Zrotation Xrotation Yrotation
    End Site { OFFSET 0 60 0 } } }
MOTION
Frames: 3
Frame Time: 0.1
0 0 0 0 0 0  0 0 0
0 0 100 0 0 0  0 0 0
0 0 100 90 0 0  0 0 0
)");
  }

  /// @return why a scene is refused; empty: it can be simulated
  std::string outcome(const json& document) {
    ++tried_;
    try {
      Simulation simulation(read_scene(put("scene.json", document.dump())), parse_devices("cpu"));
      ++simulated_;
      const StepReport report = simulation.step();
      if (report.failure == Failure::none) {
        EXPECT_TRUE(finite(simulation.frame())) << document.dump();
      }
      return "";
    } catch (const SceneError& error) {
      return error.what();
    }
  }

  /// Sets numbers of every scene to each of the values, every `stride`-th pair from the `first` on.
  /// @param out_of_range the values are, so that refusals have to name the number; otherwise
  ///                     without the method asynchronous
  void sweep(const std::vector<json>& values, std::size_t stride, std::size_t first,
             bool out_of_range);

  std::size_t tried_ = 0;
  std::size_t simulated_ = 0;
};

struct Variant {
  const char* key;
  json value;
};

const std::vector<Variant>& variants() {
  static const std::vector<Variant> all{{"/precision", "float"},
                                        {"/precision", "double"},
                                        {"/method/type", "adaptive"},
                                        {"/method/type", "asynchronous"}};
  return all;
}

/// Counts of triangles are allowed up to what a large machine holds.
bool takes_long(const json::json_pointer& place, const json& value) {
  const std::string key = key_of(place);
  const double number = value.get<double>();
  return number >= 1e3 && number <= 1e8 &&
         (key == "triangles" || key == "cells" || key == "count" || key == "subdivisions");
}

void NumberRangesTest::sweep(const std::vector<json>& values, std::size_t stride, std::size_t first,
                             bool out_of_range) {
  std::size_t number = 0;
  for (const std::string& base : bases()) {
    const json document = json::parse(base);
    std::size_t applicable = 0;
    for (const Variant& variant : variants()) {
      if (variant.value == "asynchronous" && !out_of_range) continue;
      json plain = document;
      plain[json::json_pointer(variant.key)] = variant.value;
      if (!outcome(plain).empty()) continue;  // what one method cannot simulate, another can
      ++applicable;
      std::vector<json::json_pointer> places;
      collect_numbers(document, json::json_pointer(), places);
      for (const json::json_pointer& place : places)
        for (const json& value : values) {
          if (number++ % stride != first || takes_long(place, value)) continue;
          json changed = plain;
          changed[place] = value;
          const std::string refusal = outcome(changed);
          SCOPED_TRACE(place.to_string() + " = " + value.dump() + ", " + variant.value.dump());
          if (refusal.empty() || !out_of_range) continue;
          EXPECT_TRUE(names(refusal, place)) << refusal;
        }
    }
    EXPECT_TRUE(applicable > 0 || !out_of_range || base.find("/usr/share") != std::string::npos)
        << outcome(document);
  }
}

/// Chooses another part each day.
std::size_t day() {
  return static_cast<std::size_t>(std::time(nullptr) / 86400);
}

TEST_F(NumberRangesTest, ScenesHaveEveryNumberOfTheSchema) {
  std::ifstream file(repository_root() / "scenes" / "scene.schema.json");
  std::set<std::string> missing = Schema(json::parse(file)).numbers();
  EXPECT_GT(missing.size(), 150u);
  for (const std::string& base : bases()) {
    const json document = json::parse(base);
    std::vector<json::json_pointer> places;
    collect_numbers(document, json::json_pointer(), places);
    for (const json::json_pointer& place : places) missing.erase(pattern_of(place));
  }
  EXPECT_EQ(missing, std::set<std::string>{});
}

TEST_F(NumberRangesTest, NumbersOutOfRangeAreRefusedByNameOrSimulated) {
  sweep({0, -1, 1e-320, 1e-46, 1e-39, 1e38, 1e39, 1e300, 2147483648, 9007199254740993}, 5,
        day() % 5, true);
  EXPECT_GT(simulated_, 100u);
}

/// The ends of most ranges and what lies between. Without the method asynchronous, which takes
/// minutes for a thickness of several cells.
TEST_F(NumberRangesTest, SlowEndsOfRangesAreSimulated) {
  sweep({1e-15, 1e-9, 1e-6, 1e-3, 0.5, 0.99999, 1.00001, 1e3, 1e5, -1e5, 1e7, -1e7, 1e9, 1e12}, 20,
        day() % 20, false);
  EXPECT_GT(simulated_, 100u);
}

}  // namespace
}  // namespace weft::io
