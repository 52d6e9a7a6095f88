// Bodies that cloth displaces: what the frames hold, which files are beside them, and what `weft
// check` says; and the picture of a run that may displace them no farther.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

constexpr std::size_t apart_vertices = 8;
constexpr std::size_t box_vertices = 66;  // a grid of 5 x 5 x 3 points, without the 9 inside

class DisplacedBodies : public Process {
 protected:
  void SetUp() override { write("press.json", press_scene); }

  int press(const std::string& output, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"run", "press.json", "-o", output, "--no-preview"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return weft(arguments);
  }
  /// Points of a file of obstacles in the order of the scene: apart, below, above.
  std::vector<Vec3<double>> points(const std::string& file) const {
    return io::read_mesh(at(file), io::Uv::ignore).positions;
  }
  Json check_json(const std::string& run) {
    weft({"check", run, "--json"});
    return Json::parse(out_);
  }
};

TEST_F(DisplacedBodies, FramesHoldThePrescribedPlacesAndCheckKnowsBoth) {
  ASSERT_EQ(press("a"), 0) << err_;
  const auto first = points("a/frames/obstacle_00000.obj");
  const auto last = points("a/frames/obstacle_00007.obj");
  const auto displaced = points("a/displaced/displaced_00007.obj");
  ASSERT_EQ(last.size(), apart_vertices + 2 * box_vertices);
  ASSERT_EQ(displaced.size(), last.size());
  // At 0.28 s of 0.4 s: the motion rises by 3 s^2 - 2 s^3 of its way.
  const double s = 0.7, way = 0.035 * (3 * s * s - 2 * s * s * s);
  double farthest = 0;
  for (std::size_t v = 0; v < last.size(); ++v) {
    const double side = v < apart_vertices ? 0 : v < apart_vertices + box_vertices ? 1 : -1;
    EXPECT_NEAR(last[v][2], first[v][2] + side * way, 1e-6) << v;
    const double distance = length(displaced[v] - last[v]);
    EXPECT_TRUE(v >= apart_vertices || distance == 0) << v;
    farthest = std::max(farthest, distance);
  }
  EXPECT_GT(farthest, 1e-3);
  // Frames without a displaced body have no such file, and no reader takes one for a frame.
  for (int frame = 0; frame < 8; ++frame)
    EXPECT_EQ(fs::exists(at("a/displaced/displaced_0000" + std::to_string(frame) + ".obj")),
              frame >= 6)
        << frame;
  const Json verdict = check_json("a");
  EXPECT_EQ(verdict["frames"].size(), 8);
  EXPECT_EQ(verdict["summary"]["clean_against_displaced"], 2);
  EXPECT_EQ(verdict["summary"]["bad"], 0);
  EXPECT_EQ(verdict["summary"]["intersections"], 0);
  const Json& frame = verdict["frames"][7];
  EXPECT_EQ(frame["clean"], false);
  EXPECT_EQ(frame["clean_against_displaced"], true);
  EXPECT_TRUE(frame["displaced_body"] == "below" || frame["displaced_body"] == "above");
  EXPECT_NEAR(frame["displaced_by_m"].get<double>(), farthest, 1e-12);
  EXPECT_GT(frame["verdict"]["cloth_obstacle"]["count"], 0) << "against the prescribed places";
  EXPECT_EQ(report("a")["intersections"], 0);
  EXPECT_EQ(report("a")["clean_against_displaced"], true);

  EXPECT_EQ(weft({"check", "a"}), 0) << out_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_EQ(err_.find("weft: warning: a/frames/cloth_00007.obj: clean only against "), 0u) << err_;
  EXPECT_NE(err_.find(" displaced it, by 0.0"), std::string::npos) << err_;
  EXPECT_NE(err_.find("1 more such frame\n"), std::string::npos) << err_;
  EXPECT_EQ(weft({"check", "a", "--quiet"}), 0);
  EXPECT_EQ(out_ + err_, "");
  ASSERT_EQ(weft({"convert", "a", "a.usda"}), 0) << err_;
  EXPECT_EQ(weft({"check", "a.usda"}), 1) << "holds the prescribed places alone";
  EXPECT_NE(out_.find("8 frames checked"), std::string::npos) << out_;

  // Cloth that meets the displaced bodies too is intersecting.
  fs::copy_file(at("a/frames/obstacle_00007.obj"), at("a/displaced/displaced_00007.obj"),
                fs::copy_options::overwrite_existing);
  EXPECT_EQ(weft({"check", "a"}), 1) << out_;
  fs::remove_all(at("a/displaced"));
  EXPECT_EQ(weft({"check", "a"}), 1) << out_;
  EXPECT_EQ(err_, "");
}

TEST_F(DisplacedBodies, AResumedRunKeepsThem) {
  ASSERT_EQ(press("a"), 0) << err_;
  ASSERT_EQ(press("b", {"--frames", "6"}), 0) << err_;
  // Something that an unfinished run has left: later than the checkpoint.
  fs::copy_file(at("a/displaced/displaced_00007.obj"), at("b/displaced/displaced_00009.obj"));
  ASSERT_EQ(press("b", {"--resume", "latest"}), 0) << err_;
  EXPECT_EQ(hash("b"), hash("a"));
  for (const char* file : {"displaced/displaced_00006.obj", "displaced/displaced_00007.obj",
                           "frames/obstacle_00007.obj", "frames/cloth_00007.obj"})
    EXPECT_EQ(text_of(at("b") / file), text_of(at("a") / file)) << file;
  EXPECT_FALSE(fs::exists(at("b/displaced/displaced_00009.obj")));
  ASSERT_EQ(press("b", {"--overwrite", "--frames", "1"}), 0) << err_;
  EXPECT_FALSE(fs::exists(at("b/displaced")));
}

TEST_F(DisplacedBodies, AllFormatsOfFrames) {
  for (const std::string format : {"ply", "pc2", "usda"}) {
    ASSERT_EQ(press(format, {"--set", "output.format=" + format}), 0) << err_;
    const Json verdict = check_json(format);
    EXPECT_EQ(verdict["summary"]["clean_against_displaced"], 2) << format;
    EXPECT_EQ(verdict["summary"]["bad"], 0) << format;
    const std::string body = verdict["frames"][7]["displaced_body"];
    EXPECT_TRUE(body == "below" || body == "above") << format << ": " << body;
  }
}

TEST_F(DisplacedBodies, SlicesOfTimeKeepThem) {
  ASSERT_EQ(press("a", {"--set", "method.type=time_parallel", "--set",
                        "method.time_parallel.slices=1", "--workers", "1"}),
            0)
      << err_;
  EXPECT_EQ(weft({"check", "a"}), 0) << out_;
  EXPECT_TRUE(fs::exists(at("a/displaced/displaced_00007.obj")));
}

TEST_F(DisplacedBodies, AFailureIsDrawn) {
  const std::vector<std::string> rigid{"--set", "contact.compliance_distance=0", "--set",
                                       "cloths.0.grid.cells=[4,4]"};
  ASSERT_EQ(press("a", rigid), 4) << out_ << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("; picture a/failure.png\n"), std::string::npos) << err_;
  const std::string picture = text_of(at("a/failure.png"));
  EXPECT_EQ(picture.substr(0, 8), "\x89PNG\r\n\x1a\n");
  const Json place = report("a")["failure_place"];
  // Where the boxes close on the sheet.
  EXPECT_LE(std::abs(place[0].get<double>()), 0.15);
  EXPECT_LE(std::abs(place[1].get<double>()), 0.15);
  EXPECT_LE(std::abs(place[2].get<double>()), 0.01);
  // A picture that cannot be drawn hides nothing, and an old one does not stay.
  fs::remove(at("a/failure.png"));
  fs::create_directories(at("a/failure.png/full"));
  std::vector<std::string> again{"--resume", "latest"};
  again.insert(again.end(), rigid.begin(), rigid.end());
  EXPECT_EQ(press("a", again), 4) << err_;
  ASSERT_EQ(line_count(err_), 2) << err_;
  EXPECT_EQ(err_.find("weft: warning: no picture of the failure: "), 0u) << err_;
  EXPECT_NE(err_.find("\nweft: simulation failed "), std::string::npos) << err_;
  EXPECT_EQ(err_.find("; picture"), std::string::npos) << err_;
  fs::remove_all(at("a/failure.png"));
  write("a/failure.png", picture);
  EXPECT_EQ(press("a", {"--resume", "latest", "--resume-changed", "--frames", "6", "--set",
                        "cloths.0.grid.cells=[4,4]"}),
            0)
      << err_;
  EXPECT_FALSE(fs::exists(at("a/failure.png")));
}

/// At the end the pins of one edge meet those of the other exactly: cloth keeps them apart by a
/// rounding error, which is no displacement.
TEST_F(DisplacedBodies, RoundingErrorsAreNone) {
  const std::string scene = WEFT_SOURCE_DIR "/tests/everyday/scenes/napkin_12.json";
  ASSERT_EQ(
      weft({"run", scene, "-o", "a", "--no-preview", "--set", "contact.compliance_distance=0"}), 0)
      << err_;
  EXPECT_EQ(report("a")["contacts"]["compliance_distance_max"], 0);
}

TEST_F(DisplacedBodies, AFailureWithoutAPlaceIsNotDrawn) {
  EXPECT_EQ(
      press("a", {"--experimental", "solver.max_iterations=1", "--set", "solver.tolerance=1e-6"}),
      4)
      << out_ << err_;
  EXPECT_EQ(err_.find("picture"), std::string::npos) << err_;
  EXPECT_FALSE(report("a").contains("failure_place"));
  EXPECT_FALSE(fs::exists(at("a/failure.png")));
}

}  // namespace
}  // namespace weft::test
