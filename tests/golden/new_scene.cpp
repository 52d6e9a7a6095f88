#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

/// `weft new`: from mesh files to a scene that runs.
namespace weft::test {
namespace {

class NewScene : public Process {
 protected:
  /// A square sheet with y up, in the units of the file.
  void write_sheet(const std::string& name, double size, double height, int cells = 8) const {
    std::ostringstream obj;
    for (int j = 0; j <= cells; ++j)
      for (int i = 0; i <= cells; ++i)
        obj << "v " << size * (1.0 * i / cells - 0.5) << " " << height << " "
            << size * (1.0 * j / cells - 0.5) << "\n";
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        const int a = j * (cells + 1) + i + 1, b = a + cells + 1;
        obj << "f " << a << " " << b << " " << a + 1 << "\nf " << a + 1 << " " << b << " " << b + 1
            << "\n";
      }
    write(name, obj.str());
  }

  void write_ball(const std::string& name, double radius) const {
    constexpr int rings = 10, sectors = 16;
    std::ostringstream obj;
    obj << "v 0 " << radius << " 0\n";
    for (int i = 1; i < rings; ++i)
      for (int j = 0; j < sectors; ++j) {
        const double t = std::numbers::pi * i / rings, p = 2 * std::numbers::pi * j / sectors;
        obj << "v " << radius * std::sin(t) * std::cos(p) << " " << radius * std::cos(t) << " "
            << radius * std::sin(t) * std::sin(p) << "\n";
      }
    obj << "v 0 " << -radius << " 0\n";
    const auto at = [](int i, int j) { return 2 + (i - 1) * sectors + j % sectors; };
    for (int j = 0; j < sectors; ++j) {
      obj << "f 1 " << at(1, j + 1) << " " << at(1, j) << "\n";
      for (int i = 1; i + 1 < rings; ++i)
        obj << "f " << at(i, j) << " " << at(i, j + 1) << " " << at(i + 1, j + 1) << " "
            << at(i + 1, j) << "\n";
      obj << "f " << at(rings - 1, j) << " " << at(rings - 1, j + 1) << " "
          << 2 + (rings - 1) * sectors << "\n";
    }
    write(name, obj.str());
  }

  static Json scene_of(const std::string& text) { return Json::parse(text, nullptr, true, true); }
};

/// The files are in centimetres, with y up.
TEST_F(NewScene, RunsAsItIsWritten) {
  write_sheet("cloth.obj", 60, 26);
  write_ball("body.obj", 20);
  ASSERT_EQ(weft({"new", "cloth.obj", "body.obj"}), 0) << err_;
  EXPECT_EQ(err_, "");
  EXPECT_NE(out_.find("weft run scene.json\n"), std::string::npos) << out_;
  const std::string text = text_of(at("scene.json"));
  const Json scene = scene_of(text);
  EXPECT_EQ(scene.at("units"), "cm");
  EXPECT_EQ(scene.at("up"), "y");
  EXPECT_EQ(scene.at("cloths")[0].at("fabric"), "cotton_polyester");
  EXPECT_EQ(scene.at("contact").at("thickness"), 0.001);
  EXPECT_EQ(scene.at("camera").at("keys").size(), 1u);
  EXPECT_GE(scene.at("time").at("frames"), 50);
  for (const char* reason :
       {"// of the coordinates in the mesh files. guessed: the body is 40 x 40",
        "guessed: the cloth starts above the body along y", "edges of 75 to",
        "the cloth falls 0.06 m"})
    EXPECT_NE(text.find(reason), std::string::npos) << reason;

  ASSERT_EQ(weft({"run", "scene.json", "--frames", "15"}), 0) << err_;
  EXPECT_EQ(err_, "");
  EXPECT_EQ(weft({"check", "out/cloth"}), 0) << out_;
  // The sheet of 0.6 m has met the ball, whose top is at 0.2 m.
  std::istringstream frame(text_of(at("out/cloth/frames/cloth_00015.obj")));
  double highest = -1, x = 0, y = 0, z = 0;
  for (std::string line; std::getline(frame, line);) {
    std::istringstream row(line);
    std::string kind;
    if (row >> kind >> x >> y >> z && kind == "v") highest = std::max(highest, z);
  }
  EXPECT_GT(highest, 0.15);
  EXPECT_LT(highest, 0.25);
}

TEST_F(NewScene, ReplacesNothing) {
  write_sheet("cloth.obj", 60, 26);
  write("scene.json", "mine");
  EXPECT_EQ(weft({"new", "cloth.obj"}), 2);
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("scene.json (is there already)"), std::string::npos) << err_;
  EXPECT_EQ(text_of(at("scene.json")), "mine");
  EXPECT_EQ(weft({"new", "cloth.obj", "-o", "none/scene.json"}), 2);
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_EQ(weft({"new", "missing.obj", "-o", "other.json"}), 2);
  EXPECT_EQ(weft({"new", "cloth.obj", "-o", "other.obj"}), 2);
  EXPECT_NE(err_.find("a file name that ends in .json"), std::string::npos) << err_;
  EXPECT_EQ(weft({"new", "cloth.obj", "-o", "other.json", "--fabric", "felt"}), 2);
  EXPECT_NE(err_.find("silk"), std::string::npos) << err_;
  EXPECT_EQ(weft({"new", "cloth.obj", "-o", "other.json", "--fabric", "demin"}), 2);
  EXPECT_NE(err_.find("; did you mean \"denim\"?"), std::string::npos) << err_;
  EXPECT_FALSE(fs::exists(at("other.json")));
}

TEST_F(NewScene, PlainJsonHasNoComments) {
  write_sheet("cloth.obj", 0.6, 1);
  ASSERT_EQ(weft({"new", "cloth.obj", "-o", "plain.json", "--no-comments", "--fabric", "silk",
                  "--units", "cm", "--up", "y"}),
            0)
      << err_;
  const Json scene = Json::parse(text_of(at("plain.json")));  // refuses comments
  EXPECT_EQ(scene.at("units"), "cm");
  EXPECT_EQ(scene.at("cloths")[0].at("fabric"), "silk");
  // A sheet of 6 mm has cells of 0.75 mm.
  EXPECT_NEAR(scene.at("contact").at("thickness").get<double>(), 0.75e-3 / 4, 1e-6);
}

/// Without a body, flat cloth gets a floor and upright cloth is held at its rim.
TEST_F(NewScene, ClothAloneIsHeldUp) {
  write_sheet("flat.obj", 1, 0);
  ASSERT_EQ(weft({"new", "flat.obj", "-o", "flat.json"}), 0) << err_;
  EXPECT_EQ(scene_of(text_of(at("flat.json"))).at("obstacles")[0].at("name"), "floor");
  ASSERT_EQ(weft({"run", "flat.json", "--frames", "1"}), 0) << err_;
  ASSERT_EQ(weft({"new", "flat.obj", "-o", "curtain.json", "--up", "z"}), 0) << err_;
  const Json curtain = scene_of(text_of(at("curtain.json")));
  EXPECT_FALSE(curtain.contains("obstacles"));
  ASSERT_EQ(curtain.at("pins").size(), 1u);
  ASSERT_EQ(weft({"run", "curtain.json", "--frames", "1"}), 0) << err_;
}

TEST_F(NewScene, SaysWhichFolderARunNeeds) {
  write_sheet("cloth.obj", 1, 0);
  fs::create_directory(at("sub"));
  ASSERT_EQ(weft({"new", "cloth.obj", "-o", "sub/scene.json"}), 0) << err_;
  EXPECT_NE(out_.find("weft run sub/scene.json --allow-path .\n"), std::string::npos) << out_;
  EXPECT_EQ(weft({"run", "sub/scene.json", "--allow-path", ".", "--frames", "1"}), 0) << err_;
}

/// Two triangles have one place, which cloth cannot have; repair drops one.
TEST_F(NewScene, RepairsWhatWouldBeRefused) {
  write_sheet("cloth.obj", 1, 0);
  write("cloth.obj", text_of(at("cloth.obj")) + "f 1 10 2\n");
  ASSERT_EQ(weft({"new", "cloth.obj"}), 0) << err_;
  EXPECT_EQ(scene_of(text_of(at("scene.json"))).at("cloths")[0].at("repair"), true);
  EXPECT_EQ(weft({"run", "scene.json", "--frames", "1"}), 0) << err_;
}

}  // namespace
}  // namespace weft::test
