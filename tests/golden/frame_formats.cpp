// Frames in every format: what `weft run` writes, whether another reader finds the same positions
// in it, what a kill and a resume leave, and `weft convert` from each to each.
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

using Names = std::set<std::string>;

std::string format_of(const std::string& format) {
  return "output.format=" + format;
}

Names names_in(const fs::path& directory) {
  Names names;
  for (const auto& entry : fs::directory_iterator(directory))
    names.insert(entry.path().filename().string());
  return names;
}

/// World positions of everything in a frame, cloths first.
std::vector<Vec3<double>> positions_of(const io::MeshSequence& sequence, std::size_t place) {
  const io::FrameMeshes meshes = io::in_world(sequence.read(place));
  std::vector<Vec3<double>> all = io::joined(meshes.cloths).positions;
  const Mesh obstacles = io::joined(meshes.obstacles);
  all.insert(all.end(), obstacles.positions.begin(), obstacles.positions.end());
  return all;
}

/// The largest difference of a coordinate between two animations; infinite if they do not have the
/// same frames and points.
double difference(const fs::path& a, const fs::path& b) {
  const auto first = io::open_sequence(a), second = io::open_sequence(b);
  if (first->frames() != second->frames()) return INFINITY;
  double largest = 0;
  for (std::size_t k = 0; k < first->frames().size(); ++k) {
    const auto x = positions_of(*first, k), y = positions_of(*second, k);
    if (x.size() != y.size()) return INFINITY;
    for (std::size_t v = 0; v < x.size(); ++v)
      for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(x[v][c] - y[v][c]));
  }
  return largest;
}

/// The cloths run in single precision; obstacles are rounded to it: half a unit in the last place
/// of a coordinate below 0.5.
constexpr double rounding = 0x1p-26;

class FrameFormats : public Process {
 protected:
  void SetUp() override {
    Process::SetUp();
    // An obstacle that moves and one that does not.
    Json scene = Json::parse(small_scene);
    scene["obstacles"][0]["motion"] = {{{"time", 0}}, {{"time", 1}, {"translate", {0, 0, 0.02}}}};
    scene["obstacles"].push_back({{"name", "floor"},
                                  {"plane", {{"size", {1, 1}}}},
                                  {"transform", {{"translate", {0, 0, -0.2}}}}});
    write("small.json", scene.dump());
  }
  int run_as(const std::string& output, const std::string& format,
             std::vector<std::string> more = {}) {
    more.insert(more.end(), {"--set", format_of(format)});
    return run(output, more);
  }
};

TEST_F(FrameFormats, AllHoldTheSamePositions) {
  ASSERT_EQ(run_as("obj", "obj"), 0) << err_;
  for (const char* format : {"ply", "pc2", "usda", "glb"}) {
    ASSERT_EQ(run_as(format, format), 0) << err_;
    EXPECT_EQ(hash(format), hash("obj"));
    EXPECT_LE(difference(at("obj"), at(format)), rounding) << format;
    EXPECT_EQ(weft({"check", format}), 0) << format << out_ << err_;
    EXPECT_NE(out_.find("7 frames checked: 7 clean"), std::string::npos) << format << out_;
  }
  EXPECT_EQ(names_in(at("usda/frames")), (Names{"animation.usda"}));
  EXPECT_EQ(names_in(at("glb/frames")), (Names{"animation.glb", "animation.glb.spool"}));
  EXPECT_EQ(names_in(at("pc2/frames")),
            (Names{"cloth.lower.obj", "cloth.lower.pc2", "cloth.upper.obj", "cloth.upper.pc2",
                   "obstacle.ball.obj", "obstacle.ball.pc2", "obstacle.floor.obj"}));
  EXPECT_EQ(io::PointCache(at("pc2/frames/cloth.lower.pc2")).sample_count(), 7);
}

TEST_F(FrameFormats, ObjHasUvAndNormals) {
  ASSERT_EQ(run_as("a", "obj", {"--frames", "1"}), 0) << err_;
  const std::string text = text_of(at("a/frames/cloth_00001.obj"));
  const auto count = [&](const std::string& line) {
    std::size_t n = 0;
    for (std::size_t p = text.find(line); p != std::string::npos; p = text.find(line, p + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("\nv "), 13u * 13 + 7 * 7);
  EXPECT_EQ(count("\nvt "), 13u * 13 + 7 * 7);
  EXPECT_EQ(count("\nvn "), 13u * 13 + 7 * 7);
  EXPECT_EQ(count("\nf "), 2u * 12 * 12 + 2 * 6 * 6);
  // A sheet that hangs freely and has hardly moved: its normals point up.
  EXPECT_NE(text.find("\nvn "), std::string::npos);
  EXPECT_NE(text.find("\nf 1/1/1 "), std::string::npos);
  EXPECT_NE(text_of(at("a/frames/obstacle_00001.obj")).find("//"), std::string::npos);
}

TEST_F(FrameFormats, FreshRunClearsEveryFormat) {
  for (const char* format : {"pc2", "usda", "glb", "obj"})
    ASSERT_EQ(run_as("a", format, {"--frames", "1"}), 0) << err_;
  EXPECT_EQ(names_in(at("a/frames")), (Names{"cloth_00000.obj", "cloth_00001.obj",
                                             "obstacle_00000.obj", "obstacle_00001.obj"}));
}

TEST_F(FrameFormats, ResumeGivesTheSameFiles) {
  for (const char* format : {"pc2", "usda", "glb"}) {
    ASSERT_EQ(run_as("whole", format), 0) << err_;
    ASSERT_EQ(run_as("a", format), 0) << err_;
    ASSERT_EQ(run_as("a", format, {"--resume", "a/checkpoint_00004.weft"}), 0) << err_;
    ASSERT_EQ(run_as("b", format, {"--frames", "3"}), 0) << err_;
    ASSERT_EQ(run_as("b", format, {"--resume", "latest"}), 0) << err_;
    for (const std::string& name : names_in(at("whole/frames")))
      for (const std::string directory : {"a", "b"})
        EXPECT_EQ(text_of(at(directory) / "frames" / name), text_of(at("whole/frames") / name))
            << directory << " " << name;
    EXPECT_EQ(names_in(at("a/frames")), names_in(at("whole/frames")));
  }
}

TEST_F(FrameFormats, IntoAnotherDirectoryStartsAtTheFrame) {
  for (const std::string format : {"pc2", "usda"}) {
    ASSERT_EQ(run_as("a", format), 0) << err_;
    ASSERT_EQ(run_as("b", format, {"--resume", "a/checkpoint_00004.weft", "--overwrite"}), 0)
        << err_;
    EXPECT_EQ(io::open_sequence(at("b"))->frames(), (std::vector<int>{4, 5, 6}));
    EXPECT_EQ(weft({"check", "b"}), 0) << out_ << err_;
  }
}

TEST_F(FrameFormats, KilledRunsCanBeReadAndGoneOnFrom) {
  for (const std::string format : {"pc2", "usda", "glb"}) {
    ASSERT_EQ(run_as("whole", format, {"--frames", "20"}), 0) << err_;
    const auto arguments = run_arguments("killed", {"--frames", "20", "--set", format_of(format),
                                                    "--set", "output.checkpoint_every=1"});
    ASSERT_EQ(stopped(arguments, at("killed"), at("killed/checkpoint_00002.weft"), SIGKILL),
              -SIGKILL);
    EXPECT_GE(io::open_sequence(at("killed"))->frames().size(), 3u);
    EXPECT_EQ(weft({"check", "killed"}), 0) << out_ << err_;
    EXPECT_EQ(weft({"convert", "killed", "so_far.usda"}), 0) << err_;
    // The file for other programs is whole at any moment and holds at least half of the frames.
    if (format == "usda") {
      EXPECT_GE(io::open_sequence(at("killed/frames/animation.usda"))->frames().size(), 2u);
      EXPECT_NE(text_of(at("killed/frames/animation.usda")).find("vector3f[] velocities"),
                std::string::npos);
    }
    if (format == "glb") {
      EXPECT_EQ(text_of(at("killed/frames/animation.glb")).substr(0, 4), "glTF");
    }
    ASSERT_EQ(run_as("killed", format, {"--frames", "20", "--resume", "latest"}), 0) << err_;
    EXPECT_EQ(names_in(at("killed/frames")), names_in(at("whole/frames")));
    for (const std::string& name : names_in(at("whole/frames")))
      EXPECT_EQ(text_of(at("killed/frames") / name), text_of(at("whole/frames") / name)) << name;
    fs::remove_all(at("killed"));
  }
}

TEST_F(FrameFormats, ObstaclesThatStandAreWrittenOnce) {
  Json scene = Json::parse(text_of(at("small.json")));
  scene["obstacles"][0].erase("motion");
  write("small.json", scene.dump());
  for (const std::string format : {"obj", "ply"}) {
    ASSERT_EQ(run_as("a", format, {"--frames", "3", "--overwrite"}), 0) << err_;
    EXPECT_EQ(names_in(at("a/frames")),
              (Names{"cloth_00000." + format, "cloth_00001." + format, "cloth_00002." + format,
                     "cloth_00003." + format, "obstacle." + format}));
    EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
    EXPECT_NE(out_.find("4 frames checked: 4 clean"), std::string::npos) << out_;
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_EQ(io::open_sequence(at("a"))->read(k).obstacles.size(), 1u) << k;
    ASSERT_EQ(run_as("a", format, {"--resume", "latest", "--frames", "5"}), 0) << err_;
    EXPECT_EQ(names_in(at("a/frames")).size(), 7u);
    ASSERT_EQ(weft({"convert", "a", "again.usda"}), 0) << err_;
    EXPECT_LE(difference(at("a"), at("again.usda")), rounding);
    fs::remove(at("again.usda"));
  }
  // The check must not pass for want of the obstacle: cloth is put into the ball.
  ASSERT_EQ(run_as("b", "obj", {"--frames", "1"}), 0) << err_;
  const Mesh ball = io::read_mesh(at("b/frames/obstacle.obj"), io::Uv::ignore);
  Mesh moved = ball;
  for (auto& x : moved.positions) x[2] += 0.01;
  io::write_obj(at("b/frames/cloth_00001.obj"), {{"cloth", moved}});
  EXPECT_EQ(weft({"check", "b"}), 1) << out_ << err_;
}

TEST_F(FrameFormats, CheckFindsWhatIsWrongInThem) {
  ASSERT_EQ(run_as("a", "pc2", {"--frames", "1"}), 0) << err_;
  const fs::path file = at("a/frames/cloth.upper.pc2");
  {
    const auto points = io::PointCache(at("a/frames/cloth.lower.pc2")).read(1);
    auto moved = io::PointCache(file).read(1);
    for (auto& x : moved) x[2] = points[0][2] - 0.01;  // the lower cloth hangs through it
    io::PointCacheWriter(file, static_cast<Index>(moved.size()), 1).append(moved);
  }
  EXPECT_EQ(weft({"check", "a"}), 1) << out_ << err_;
  std::string bytes = text_of(file);
  fs::resize_file(file, bytes.size() - 1);
  EXPECT_EQ(weft({"check", "a"}), 2) << out_;
  EXPECT_EQ(line_count(err_), 1) << err_;
}

// ------------------------------------------------------------------------------------------
// far from the origin
class FarFrames : public FrameFormats {
 protected:
  /// A scene whose coordinates are not rounded where `far.json` has it.
  void SetUp() override {
    FrameFormats::SetUp();
    Json scene = Json::parse(text_of(at("small.json")));
    scene["cloths"][0]["grid"] = {{"size", {0.5, 0.5}}, {"cells", {8, 8}}};
    scene["cloths"][0]["transform"] = {{"translate", {0, 0, 0.15625}}};
    scene["cloths"][1]["grid"] = {{"size", {0.25, 0.25}}, {"cells", {4, 4}}};
    scene["cloths"][1]["transform"] = {{"translate", {0.03125, 0, 0.1640625}}};
    write("small.json", scene.dump());
    for (const char* list : {"cloths", "obstacles"})
      for (Json& part : scene[list]) {
        if (!part.contains("motion"))
          move(part["transform"]);
        else
          for (Json& key : part["motion"]) move(key);
      }
    write("far.json", scene.dump());
  }
  static void move(Json& transform) {
    Json place = transform.value("translate", Json{0, 0, 0});
    place[0] = place[0].get<double>() + 0x1p20;
    place[1] = place[1].get<double>() - 0x1p18;
    transform["translate"] = place;
  }
  int run_far(const std::string& output, const std::string& format,
              const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = run_arguments(output, more);
    arguments[1] = "far.json";
    arguments.insert(arguments.end(), {"--set", format_of(format)});
    return weft(arguments);
  }
  /// Without the lines that say where a USD file puts the origin.
  static std::string without_transform(const std::string& text) {
    std::stringstream lines(text);
    std::string rest, line;
    while (std::getline(lines, line))
      if (line.find("xformOp") == std::string::npos)
        rest += line + "\n";
      else if (line.find("xformOpOrder") != std::string::npos)
        std::getline(lines, line);  // the blank one
    return rest;
  }
};

TEST_F(FarFrames, HaveTheSameBitsAndATransform) {
  ASSERT_EQ(run_as("obj", "obj"), 0) << err_;
  const Json origin{0x1p20, -0x1p18, 0.0};
  for (const std::string format : {"obj", "ply", "pc2", "usda"}) {
    ASSERT_EQ(run_as("near", format), 0) << err_;
    ASSERT_EQ(run_far(format, format), 0) << err_;
    EXPECT_EQ(hash(format), hash("near"));
    EXPECT_EQ(report(format).at("origin"), origin);
    EXPECT_FALSE(report("near").contains("origin"));
    EXPECT_EQ(weft({"check", format}), 0) << format << out_ << err_;
    EXPECT_NE(out_.find("7 frames checked: 7 clean"), std::string::npos) << format << out_;
    EXPECT_LE(difference(at("obj"), at(format)), rounding) << format;
    if (format == "obj" || format == "ply") continue;
    for (const std::string& name : names_in(at("near/frames"))) {
      const std::string far = text_of(at(format) / "frames" / name);
      EXPECT_TRUE((format == "usda" ? without_transform(far) : far) ==
                  text_of(at("near/frames") / name))
          << name;
    }
  }
  EXPECT_NE(text_of(at("usda/frames/animation.usda"))
                .find("double3 xformOp:translate = (1048576, -262144, 0)"),
            std::string::npos);
  for (const char* name : {"cloth.lower", "cloth.upper", "obstacle.ball", "obstacle.floor"})
    EXPECT_EQ(Json::parse(text_of(at("pc2/frames") / (name + std::string(".origin.json")))),
              Json({{"origin", origin}}));
  ASSERT_EQ(run_as("pc2", "obj", {"--frames", "1"}), 0) << err_;
  EXPECT_EQ(names_in(at("pc2/frames")).size(), 4u) << "a fresh run clears the files of origins";
}

TEST_F(FarFrames, ResumeGivesTheSameFiles) {
  for (const char* format : {"obj", "pc2", "usda"}) {
    ASSERT_EQ(run_far("whole", format), 0) << err_;
    ASSERT_EQ(run_far("a", format), 0) << err_;
    ASSERT_EQ(run_far("a", format, {"--resume", "a/checkpoint_00004.weft"}), 0) << err_;
    for (const std::string& name : names_in(at("whole/frames")))
      EXPECT_EQ(text_of(at("a/frames") / name), text_of(at("whole/frames") / name)) << name;
    EXPECT_EQ(hash("a"), hash("whole"));
  }
}

TEST_F(FarFrames, ConvertEachIntoEach) {
  ASSERT_EQ(run_far("run", "obj", {"--frames", "2"}), 0) << err_;
  for (const std::string name : {"a.usda", "a_%05d.obj", "a_%03d.ply"}) {
    ASSERT_EQ(weft({"convert", "run", name}), 0) << name << err_;
    EXPECT_LE(difference(at("run"), at(name)), rounding) << name;
    ASSERT_EQ(weft({"convert", name, "again.usda"}), 0) << name << err_;
    EXPECT_LE(difference(at("run"), at("again.usda")), rounding) << name;
  }
  ASSERT_EQ(weft({"convert", "run", "c.pc2", "--only", "cloths"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "c_lower.pc2", "c.usda"}), 0) << err_;
  EXPECT_EQ(weft({"convert", "c_lower.pc2", "new/folder/c.usda"}), 0) << err_;
  EXPECT_TRUE(fs::exists(at("new/folder/c.usda")));
  EXPECT_EQ(weft({"convert", "c_lower.pc2", "c.usda/c.usda"}), 2);
  EXPECT_NE(err_.find("OUT"), std::string::npos) << err_;
  EXPECT_EQ(difference(at("c_lower.pc2"), at("c.usda")), 0);
  EXPECT_GT(positions_of(*io::open_sequence(at("c_lower.pc2")), 0)[0][0], 0x1p19);
}

TEST_F(FarFrames, SlicesOfTimeHaveTheSameBits) {
  const std::vector<std::string> sliced{"--method", "time_parallel", "--set",
                                        "method.time_parallel.slices=2"};
  ASSERT_EQ(run("near", sliced), 0) << err_;
  ASSERT_EQ(run_far("far", "obj", sliced), 0) << err_;
  EXPECT_EQ(hash("far"), hash("near"));
  EXPECT_EQ(weft({"check", "far"}), 0) << out_ << err_;
}

// ------------------------------------------------------------------------------------------
// convert
using Convert = FrameFormats;

TEST_F(Convert, EachFormatIntoEach) {
  ASSERT_EQ(run_as("run", "obj", {"--frames", "2"}), 0) << err_;
  const std::vector<std::string> names{"a.usda", "a_%05d.obj", "a_%03d.ply"};
  for (const std::string& name : names) {
    ASSERT_EQ(weft({"convert", "run", name}), 0) << name << err_;
    EXPECT_EQ(out_ + err_, "");
    EXPECT_LE(difference(at("run"), at(name)), rounding) << name;
    for (const std::string& to : names) {
      const std::string again = "again_" + to;
      ASSERT_EQ(weft({"convert", name, again}), 0) << name << " " << to << err_;
      EXPECT_LE(difference(at("run"), at(again)), rounding) << name << " " << to;
    }
  }
  ASSERT_EQ(weft({"convert", "run", "c.pc2", "--only", "cloths"}), 0) << err_;
  for (const std::string cache : {"c_lower.pc2", "c_upper.pc2"}) {
    ASSERT_EQ(weft({"convert", cache, "c.usda"}), 0) << err_;
    EXPECT_EQ(difference(at(cache), at("c.usda")), 0);
    EXPECT_EQ(io::open_sequence(at(cache))->frames(), (std::vector<int>{0, 1, 2}));
  }
}

TEST_F(Convert, KeepsNamesAndFrameRate) {
  ASSERT_EQ(run_as("run", "usda", {"--frames", "2", "--set", "time.frame_rate=40"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "run", "a.pc2"}), 0) << err_;
  for (const char* name : {"lower", "upper", "ball", "floor"}) {
    EXPECT_TRUE(fs::exists(at("a_" + std::string(name) + ".pc2"))) << name;
    EXPECT_TRUE(fs::exists(at("a_" + std::string(name) + ".obj"))) << name;
  }
  ASSERT_EQ(weft({"convert", "run", "b.usda", "--only", "cloths"}), 0) << err_;
  const auto sequence = io::open_sequence(at("b.usda"));
  EXPECT_EQ(sequence->frame_rate(), 40);
  const io::FrameMeshes meshes = sequence->read(0);
  ASSERT_EQ(meshes.cloths.size(), 2u);
  EXPECT_EQ(meshes.cloths[1].name, "upper");
  EXPECT_EQ(meshes.cloths[1].mesh.material.size(), 49u);
  EXPECT_TRUE(meshes.obstacles.empty());
}

TEST_F(Convert, KeepsNamesOfTheObjectsInOneFile) {
  ASSERT_EQ(run_as("run", "obj", {"--frames", "1"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "run", "a.usda"}), 0) << err_;
  const io::FrameMeshes meshes = io::open_sequence(at("a.usda"))->read(1);
  ASSERT_EQ(meshes.cloths.size(), 2u);
  EXPECT_EQ(meshes.cloths[0].name, "lower");
  EXPECT_EQ(meshes.cloths[1].name, "upper");
  EXPECT_EQ(meshes.cloths[1].mesh.material.size(), 49u);
  ASSERT_EQ(meshes.obstacles.size(), 2u);
  EXPECT_EQ(meshes.obstacles[0].name, "ball");
  EXPECT_EQ(meshes.obstacles[1].name, "floor");
}

/// Bodies have no texture coordinates, cloths have some.
TEST_F(Convert, ReadsWhatItWritesOfClothsAndBodies) {
  ASSERT_EQ(run_as("run", "obj", {"--frames", "1"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "run", "a.obj", "--frame", "last"}), 0) << err_;
  EXPECT_EQ(weft({"check", "a.obj"}), 0) << out_ << err_;
  ASSERT_EQ(weft({"convert", "a.obj", "b.obj"}), 0) << err_;
  EXPECT_EQ(text_of(at("b.obj")), text_of(at("a.obj")));
}

TEST_F(Convert, ReplacesNoInput) {
  ASSERT_EQ(run_as("run", "obj", {"--frames", "1"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "run", "a.obj", "--frame", "1"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "run", "a.usda"}), 0) << err_;
  fs::create_hard_link(at("a.obj"), at("b.obj"));
  const std::string frame = text_of(at("run/frames/cloth_00001.obj"));
  for (const auto& [input, output] : std::vector<std::pair<std::string, std::string>>{
           {"a.obj", "a.obj"},
           {"a.obj", "./a.obj"},
           {"a.obj", "b.obj"},
           {"a.usda", "a.usda"},
           {"run", "run/frames/cloth_%05d.obj"},
           {"run/frames/cloth_%05d.obj", "run/frames/cloth_%05d.obj"},
           {"run/frames/cloth_%05d.obj", "run/frames/cloth_00001.obj"}}) {
    EXPECT_EQ(weft({"convert", input, output, "--frame", "last"}), 2) << input << output;
    EXPECT_NE(err_.find(": OUT: the input; allowed: another file"), std::string::npos) << err_;
  }
  EXPECT_EQ(text_of(at("run/frames/cloth_00001.obj")), frame);
  EXPECT_EQ(weft({"convert", "run", "run/frames/mine.obj", "--frame", "1"}), 0) << err_;
  EXPECT_EQ(weft({"convert", "run", "run/frames/mine.obj", "--frame", "1"}), 0) << err_;
}

TEST_F(Convert, SingleFrames) {
  ASSERT_EQ(run_as("run", "pc2", {"--frames", "4"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "run", "a.ply", "--frame", "3"}), 0) << err_;
  EXPECT_EQ(positions_of(*io::open_sequence(at("a.ply")), 0).size(),
            positions_of(*io::open_sequence(at("run")), 3).size());
  ASSERT_EQ(weft({"convert", "run", "a_%d.obj", "--frame", "3", "--frame", "1"}), 0) << err_;
  EXPECT_TRUE(fs::exists(at("a_1.obj")));
  EXPECT_FALSE(fs::exists(at("a_2.obj")));
  EXPECT_EQ(io::open_sequence(at("a_%d.obj"))->frames(), (std::vector<int>{1, 3}));
  ASSERT_EQ(weft({"convert", "a.ply", "b.obj"}), 0) << err_;
}

TEST_F(Convert, RunsToGlb) {
  ASSERT_EQ(run_as("run", "obj", {"--frames", "2"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "run", "a.glb"}), 0) << err_;
  EXPECT_EQ(out_ + err_, "");
  const std::string bytes = text_of(at("a.glb"));
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  for (const char* word :
       {"\"lower\"", "\"upper\"", "\"ball\"", "\"floor\"", "\"weights\"", "\"translation\""})
    EXPECT_NE(bytes.find(word), std::string::npos) << word;
  Json scene = Json::parse(text_of(at("small.json")));
  scene["method"] = {{"type", "adaptive"}};
  write("small.json", scene.dump());
  ASSERT_EQ(run_as("remeshed", "obj", {"--frames", "2"}), 0) << err_;
  EXPECT_EQ(weft({"convert", "remeshed", "b.glb"}), 2);
  EXPECT_NE(err_.find("triangles of lower"), std::string::npos) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_FALSE(fs::exists(at("b.glb")));
}

TEST_F(Convert, BadInput) {
  ASSERT_EQ(run_as("run", "obj", {"--frames", "2"}), 0) << err_;
  write("a.pc2", "POINTCACHE2");
  const std::vector<std::vector<std::string>> commands{
      {"convert"},
      {"convert", "run"},
      {"convert", "none", "a.obj"},
      {"convert", "none.usda", "a.obj"},
      {"convert", "none_%d.obj", "a.usda"},
      {"convert", "a.pc2", "a.usda"},
      {"convert", "run", "a.stl"},
      {"convert", "run", "a.obj"},
      {"convert", "run", "a_%s.obj"},
      {"convert", "run", "a.obj", "--frame", "3"},
      {"convert", "run", "a.obj", "--frame", "x"},
      {"convert", "run", "a.usda", "--only", "shoes"},
  };
  const Names before = names_in(directory_);
  for (const auto& command : commands) {
    EXPECT_EQ(weft(command), 2) << testing::PrintToString(command) << err_;
    EXPECT_EQ(line_count(err_), 1) << testing::PrintToString(command) << err_;
    EXPECT_EQ(out_, "") << testing::PrintToString(command);
  }
  EXPECT_EQ(names_in(directory_), before) << "something was written all the same";
}

}  // namespace
}  // namespace weft::test
