#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "host/io/animation/bvh_file.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/io/usd/usd_file.hpp"
#include "host/state/checkpoint.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

/// Files that are small, but would take their square in time or in memory: more than the seeds of
/// tests/fuzz can hold.
namespace weft::io {
namespace {

std::string repeated(const std::string& text, int count) {
  std::string result;
  for (int k = 0; k < count; ++k) result += text;
  return result;
}

TEST(HostileSizes, OfManyLabelsOfOneFaceTheLastCounts) {
  const int corners = 100'000;
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + repeated(" 1 2 3", corners / 3) + "\n" +
                           repeated("fl 1\nfl 2\n", corners) + "fl 7\nf 1 2 3\n";
  const Mesh mesh = parse_obj(text, "labels.obj", Uv::material);
  ASSERT_EQ(mesh.group.size(), mesh.triangles.size());
  const auto last = mesh.group.end() - 1;
  EXPECT_TRUE(std::all_of(mesh.group.begin(), last, [&](Index group) {
    return mesh.group_names[static_cast<std::size_t>(group)] == "label_7";
  }));
  EXPECT_EQ(mesh.group_names[static_cast<std::size_t>(*last)], "");
}

TEST(HostileSizes, ElementsOfAPlyFileAreLimited) {
  std::string text = "ply\nformat ascii 1.0\n";
  for (int k = 0; k < 100'000; ++k) text += "element " + std::to_string(k) + " 0\n";
  EXPECT_THROW(parse_ply(text, "elements.ply", Uv::material), SceneError);
}

TEST(HostileSizes, NamesOfJointsThatAllEndSitesRepeatAreLimited) {
  const std::string text =
      "HIERARCHY\nROOT " + std::string(500'000, 'n') + "\n{" + repeated("End Site{}", 90'000) + "}";
  EXPECT_THROW(parse_bvh(text, "names.bvh"), SceneError);
}

TEST(HostileSizes, PathsThatAllMeshesRepeatAreLimited) {
  const std::string text = "#usda 1.0\ndef \"" + std::string(500'000, 'n') + "\" {" +
                           repeated("def Mesh \"m\" {}\n", 50'000) + "}";
  EXPECT_THROW(parse_usd(text, "paths.usda"), SceneError);
}

TEST(HostileSizes, PatternsMayBeOfAnyLength) {
  const std::string tail(1 << 20, 'a');
  EXPECT_EQ(NumberedName("%03d" + tail).with(7), "007" + tail);
  EXPECT_EQ(NumberedName("%d" + tail).number_in("12" + tail), 12);
  for (const char* bad : {"%", "%%d", "%5d", "%00d", "%0d", "%s", "%d%d", "%0", "%02"})
    EXPECT_THROW(NumberedName(bad + tail), SceneError) << bad;
  EXPECT_THROW(NumberedName("%"), SceneError);
  EXPECT_THROW(NumberedName("%05"), SceneError);
}

TEST(HostileSizes, FolderIsNoCheckpoint) {
  EXPECT_THROW(read_sewing(std::filesystem::temp_directory_path(), 1, 1), SceneError);
}

/// [s] of the processor, that it takes to read a scene with so many materials and cloths.
double seconds_to_read(int count, const std::filesystem::path& path) {
  nlohmann::json scene;
  for (int k = 0; k < count; ++k) {
    scene["materials"]["m" + std::to_string(k)] = nlohmann::json::object();
    scene["cloths"].push_back({{"grid", {{"size", {1, 1}}, {"cells", {1, 1}}}},
                               {"transform", {{"translate", {0, 0, k}}}},
                               {"material", "m" + std::to_string(k)}});
  }
  std::ofstream(path) << scene.dump();
  const std::clock_t start = std::clock();
  EXPECT_EQ(read_scene(path).cloths.size(), static_cast<std::size_t>(count));
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

TEST(HostileSizes, ManyMaterialsAndClothsTakeLinearTime) {
  const ScratchFolder folder;
  const auto path = folder.path() / "scene.json";
  const double few = std::min(seconds_to_read(2'000, path), seconds_to_read(2'000, path));
  // Ten times as many; quadratic time would be a hundred times as long.
  EXPECT_LT(seconds_to_read(20'000, path), 30 * few);
}

}  // namespace
}  // namespace weft::io
