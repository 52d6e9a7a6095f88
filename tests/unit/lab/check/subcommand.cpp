// `weft check`, run as a program: exit codes, and what it prints and writes.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"

namespace weft::lab::test {
namespace {

namespace fs = std::filesystem;

const std::string clean_mesh =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\nf 4 5 6\n";
const std::string crossing_mesh =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.2 -1\nv 0.3 0.2 1\nv 0.2 0.3 1\nf 1 2 3\nf 4 5 6\n";
const std::string nan_mesh = "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n";
const std::string floor_below = "v -9 -9 -2\nv 9 -9 -2\nv 0 9 -2\nf 1 2 3\n";
const std::string floor_through = "v -9 -9 0.5\nv 9 -9 0.5\nv 0 9 0.75\nf 1 2 3\n";
const std::string floor_touching = "v -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\n";

class CheckSubcommand : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_ / "run" / "frames"); }

  std::string write(const std::string& name, const std::string& text) {
    const fs::path path = directory_ / name;
    std::ofstream(path) << text;
    return path.string();
  }
  std::string run_directory() const { return (directory_ / "run").string(); }

  /// Runs `weft check`.
  /// @return the exit code; out_ and err_ hold what was printed
  int check(const std::vector<std::string>& arguments) {
    const std::string out = (directory_ / "stdout").string();
    const std::string err = (directory_ / "stderr").string();
    std::string command = quoted(WEFT_PROGRAM) + " check";
    for (const auto& argument : arguments) command += " " + quoted(argument);
    const int status = std::system((command + " >" + quoted(out) + " 2>" + quoted(err)).c_str());
    out_ = text_of(out);
    err_ = text_of(err);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  static std::string quoted(const std::string& text) { return "'" + text + "'"; }

  static std::string text_of(const fs::path& path) {
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }

  const ScratchFolder folder_;
  const fs::path directory_ = folder_.path();
  std::string out_;
  std::string err_;
};

std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST_F(CheckSubcommand, CleanMesh) {
  EXPECT_EQ(check({write("a.obj", clean_mesh)}), 0);
  EXPECT_EQ(line_count(out_), 1u) << out_;
  EXPECT_EQ(err_, "");
}

TEST_F(CheckSubcommand, CrossingMesh) {
  const std::string path = write("a.obj", crossing_mesh);
  EXPECT_EQ(check({path}), 1);
  EXPECT_EQ(line_count(out_), 2u);
  EXPECT_EQ(out_.find(path), 0u) << out_;
  EXPECT_NE(out_.find("(0, 1)"), std::string::npos) << out_;
  EXPECT_EQ(check({path, "--no-self"}), 0);
  EXPECT_EQ(check({path, "--quiet"}), 1);
  EXPECT_EQ(out_ + err_, "");
}

TEST_F(CheckSubcommand, ObstacleOption) {
  const std::string cloth = write("a.obj", clean_mesh);
  EXPECT_EQ(check({cloth, "--obstacle", write("below.obj", floor_below)}), 0);
  EXPECT_EQ(check({cloth, "--obstacle", write("through.obj", floor_through)}), 0);
  EXPECT_EQ(check({cloth, "--obstacle", write("touching.obj", floor_touching)}), 1);
  EXPECT_NE(out_.find("1 cloth-obstacle intersection: (0, 0)"), std::string::npos) << out_;
  EXPECT_EQ(check({cloth, "--obstacle", (directory_ / "none.obj").string()}), 2);
}

TEST_F(CheckSubcommand, ObstacleMayHaveUvSeams) {
  const std::string seam =
      "v -9 -9 -2\nv 9 -9 -2\nv 0 9 -2\nv 0 9 -3\nvt 0 0\nvt 1 0\nvt 0 1\n"
      "vt 1 1\nf 1/1 2/2 3/3\nf 1/4 2/2 4/1\n";
  EXPECT_EQ(check({write("a.obj", clean_mesh), "--obstacle", write("seam.obj", seam)}), 0) << err_;
}

TEST_F(CheckSubcommand, LeavesClothAgainstClothOutWhereTheSceneDoes) {
  write("run/frames/cloth_00000.obj", crossing_mesh);
  const std::string run = (directory_ / "run").string();
  EXPECT_EQ(check({run}), 1);
  write("run/scene.json", R"({"contact": {"self": true}})");
  EXPECT_EQ(check({run}), 1);
  write("run/scene.json", R"({"contact": {"self": false}})");
  EXPECT_EQ(check({run}), 0) << out_;
  EXPECT_NE(out_.find("cloth against cloth was left out"), std::string::npos) << out_;
  write("run/frames/obstacle_00000.obj", floor_touching);
  EXPECT_EQ(check({run}), 1) << out_;
}

TEST_F(CheckSubcommand, EveryFrameOfARunAgainstItsOwnObstacle) {
  for (int i = 0; i < 12; ++i) {
    const std::string number = "000" + std::to_string(10 + i) + ".obj";
    write("run/frames/cloth_" + number, i == 7 ? crossing_mesh : clean_mesh);
    write("run/frames/obstacle_" + number, i == 3 ? floor_touching : floor_below);
  }
  write("run/frames/cloth_notes.obj", crossing_mesh);
  EXPECT_EQ(check({run_directory()}), 1);
  ASSERT_EQ(line_count(out_), 3u) << out_;
  const auto third = out_.find("cloth_00013.obj: 1 cloth-obstacle");
  const auto seventh = out_.find("cloth_00017.obj: 1 cloth-cloth");
  EXPECT_NE(third, std::string::npos) << out_;
  EXPECT_NE(seventh, std::string::npos) << out_;
  EXPECT_LT(third, seventh);
  EXPECT_NE(out_.find("12 frames checked: 10 clean, 2 with findings, 0 unreadable"),
            std::string::npos)
      << out_;
}

/// Three frames: clean; clean only against the displaced floor; intersecting both.
TEST_F(CheckSubcommand, DisplacedObstaclesGiveAThirdVerdict) {
  const std::string named = "o floor\n";
  for (const char* number : {"00000.obj", "00001.obj", "00002.obj"})
    write(std::string("run/frames/cloth_") + number, clean_mesh);
  write("run/frames/obstacle_00000.obj", named + floor_below);
  write("run/frames/obstacle_00001.obj", named + floor_touching);
  write("run/frames/obstacle_00002.obj", named + floor_touching);
  fs::create_directories(directory_ / "run" / "displaced");
  // The third corner is where it was, the others are 2 m lower.
  write("run/displaced/displaced_00001.obj",
        named + "v -9 -9 -2\nv 9 -9 -2\nv 0 9 -0.5\nf 1 2 3\n");
  EXPECT_EQ(check({run_directory()}), 1);
  EXPECT_NE(out_.find("cloth_00002.obj: 1 cloth-obstacle"), std::string::npos) << out_;
  EXPECT_NE(out_.find("3 frames checked: 1 clean, 1 clean only against displaced bodies, 1 with "
                      "findings, 0 unreadable; 1 intersection\n"),
            std::string::npos)
      << out_;
  write("run/displaced/displaced_00002.obj", named + floor_below);
  EXPECT_EQ(check({run_directory()}), 0) << out_;
  EXPECT_EQ(line_count(err_), 1u) << err_;
  EXPECT_NE(err_.find("cloth_00001.obj: clean only against floor where cloth displaced it, by 2 m; "
                      "1 more such frame"),
            std::string::npos)
      << err_;
  // Another obstacle was asked for.
  EXPECT_EQ(check({run_directory(), "--obstacle", write("touching.obj", floor_touching)}), 1);
  // Cloth that also intersects itself is not clean against anything.
  write("run/frames/cloth_00001.obj", crossing_mesh);
  EXPECT_EQ(check({run_directory()}), 1);
  EXPECT_NE(out_.find("cloth_00001.obj: 1 cloth-cloth"), std::string::npos) << out_;
  write("run/frames/cloth_00001.obj", clean_mesh);
  write("run/displaced/displaced_00001.obj", named +
                                                 "v -9 -9 -2\nv 9 -9 -2\nv 0 9 -2\nv 0 8 -3\n"
                                                 "f 1 2 3\nf 1 2 4\n");
  EXPECT_EQ(check({run_directory()}), 2) << "has other vertices";
  write("run/displaced/displaced_00001.obj", "v 0 0 banana\n");
  EXPECT_EQ(check({run_directory()}), 2) << "cannot be read";
}

TEST_F(CheckSubcommand, RunWithoutObstacles) {
  write("run/frames/cloth_00000.obj", clean_mesh);
  EXPECT_EQ(check({run_directory()}), 0);
}

TEST_F(CheckSubcommand, NoFramesIsAnError) {
  EXPECT_EQ(check({run_directory()}), 2);
  EXPECT_EQ(line_count(err_), 1u) << err_;
  EXPECT_EQ(check({directory_.string()}), 2);
  EXPECT_EQ(line_count(err_), 1u) << err_;
  EXPECT_EQ(check({}), 2);
  EXPECT_EQ(line_count(err_), 1u) << err_;
}

TEST_F(CheckSubcommand, MissingObstacleFrameIsAnError) {
  write("run/frames/cloth_00000.obj", clean_mesh);
  write("run/frames/cloth_00001.obj", clean_mesh);
  write("run/frames/obstacle_00000.obj", floor_below);
  EXPECT_EQ(check({run_directory()}), 2);
  EXPECT_NE(err_.find("cloth_00001.obj"), std::string::npos) << err_;
  EXPECT_EQ(check({run_directory(), "--obstacle", write("below.obj", floor_below)}), 0);
}

TEST_F(CheckSubcommand, UnreadableInput) {
  for (const char* missing : {"none.obj", "none"}) {
    EXPECT_EQ(check({(directory_ / missing).string()}), 2);
    EXPECT_EQ(line_count(err_), 1u) << err_;
    EXPECT_EQ(out_, "");
  }
  const std::string broken = write("broken.obj", "v 0 0 0\nv 1 0 banana\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(check({broken}), 2);
  // The rest is checked all the same.
  EXPECT_EQ(check({broken, write("a.obj", crossing_mesh)}), 2);
  EXPECT_NE(out_.find("(0, 1)"), std::string::npos) << out_;
}

TEST_F(CheckSubcommand, NanIsAFinding) {
  EXPECT_EQ(check({write("bad.obj", nan_mesh)}), 1) << err_;
  EXPECT_NE(out_.find("non-finite vert"), std::string::npos) << out_;
  EXPECT_EQ(check({write("inf.obj", "v 0 0 0\nv 1 0 -inf\nv 0 1 0\nf 1 2 3\n")}), 1) << err_;
  EXPECT_EQ(check({write("a.obj", clean_mesh), "--obstacle", write("bad.obj", nan_mesh)}), 1);
}

TEST_F(CheckSubcommand, JsonFile) {
  const std::string report = (directory_ / "report.json").string();
  const std::string bad = write("a.obj", crossing_mesh), good = write("b.obj", clean_mesh);
  EXPECT_EQ(check({bad, good, "--json", report}), 1);
  EXPECT_EQ(line_count(out_), 2u) << out_;
  const auto json = nlohmann::json::parse(std::ifstream(report));
  ASSERT_EQ(json["frames"].size(), 2u);
  EXPECT_EQ(json["frames"][0]["cloth"], bad);
  EXPECT_EQ(json["frames"][0]["verdict"]["cloth_cloth"]["pairs"][0], (std::vector{0, 1}));
  EXPECT_FALSE(json["frames"][0]["clean"]);
  EXPECT_TRUE(json["frames"][1]["clean"]);
  EXPECT_EQ(json["summary"]["bad"], 1);
  EXPECT_EQ(json["summary"]["intersections"], 1);
  EXPECT_EQ(check({good, "--json", (directory_ / "none" / "report.json").string()}), 2);
}

TEST_F(CheckSubcommand, JsonToStandardOutput) {
  write("run/frames/cloth_00000.obj", crossing_mesh);
  EXPECT_EQ(check({run_directory(), "--json"}), 1);
  EXPECT_EQ(nlohmann::json::parse(out_)["summary"]["bad"], 1);
  // The directory after --json is what to check, not where to write.
  EXPECT_EQ(check({"--json", run_directory()}), 1);
  EXPECT_EQ(nlohmann::json::parse(out_)["summary"]["frames"], 1);
}

TEST_F(CheckSubcommand, JsonNeverOverwritesAMesh) {
  const std::string a = write("a.obj", clean_mesh), b = write("b.obj", crossing_mesh);
  EXPECT_EQ(check({a, "--json", b}), 1);
  EXPECT_EQ(nlohmann::json::parse(out_)["summary"]["frames"], 2);
  EXPECT_EQ(text_of(b), crossing_mesh);
  EXPECT_EQ(check({a, "--json", "report.txt"}), 2);
}

}  // namespace
}  // namespace weft::lab::test
