#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

/// From a sewing pattern to a dressed body, as a user goes there.
namespace weft::test {
namespace {

class Garments : public Process {
 protected:
  static fs::path scenes() { return fs::path(WEFT_SOURCE_DIR) / "scenes"; }
  static std::string skirt() {
    return (scenes() / "patterns" / "skirt_specification.json").string();
  }

  static fs::path data_file(const std::string& name) {
    const char* data = std::getenv("WEFT_TEST_DATA");
    const fs::path file = fs::path(data != nullptr ? data : "") / "garments" / name;
    return data != nullptr && fs::exists(file) ? file : fs::path();
  }

  /// The dress form of scenes/skirt.json as a mesh file, with z up.
  std::string body() {
    EXPECT_EQ(weft({"run", (scenes() / "skirt.json").string(), "-o", "form", "--no-preview",
                    "--frames", "1", "--device", "cpu", "--set", "garments.0.edge=0.08"}),
              0)
        << err_;
    return at("form/frames/obstacle.obj").string();
  }

  /// A converted pattern, until it hangs.
  void drape(const std::string& pattern, const std::string& body, const std::string& edge) {
    ASSERT_EQ(weft({"convert", pattern, "scene.json", "--body", body, "--edge", edge}), 0) << err_;
    ASSERT_EQ(weft({"run", "scene.json", "-o", "out", "--no-preview", "--device", "cpu"}), 0)
        << err_;
    EXPECT_EQ(weft({"check", "out"}), 0) << out_ << err_;
    const Json done = report("out");
    EXPECT_EQ(done.at("intersections"), 0);
    for (const Json& seam : done.at("seams")) EXPECT_EQ(seam.at("open"), 0);
  }
};

TEST_F(Garments, ConvertedPatternRunsAsItIs) {
  const std::string form = body();
  fs::create_directory(at("new"));
  ASSERT_EQ(weft({"convert", skirt(), "new/skirt.json", "--body", form, "--edge", "0.04",
                  "--fabric", "denim"}),
            0)
      << err_;
  EXPECT_NE(err_.find("taken for m, with z up"), std::string::npos) << err_;
  EXPECT_TRUE(out_.starts_with("new/skirt.json: 4 panels, 8 stitches, ")) << out_;
  const std::string garment = text_of(at("new/skirt_garment.obj"));
  for (const char* line : {"\ng leg\n", "\nusemtl left_front\n", "\nusemtl right_back\n"})
    EXPECT_NE(garment.find(line), std::string::npos) << line;
  const Json scene = Json::parse(text_of(at("new/skirt.json")));
  EXPECT_EQ(scene.at("materials").at("cloth").at("fabric"), "denim");
  EXPECT_EQ(scene.at("cloths").at(0).at("name"), "skirt");
  ASSERT_EQ(weft({"run", "new/skirt.json", "-o", "out", "--no-preview", "--frames", "3", "--device",
                  "cpu"}),
            0)
      << err_;
  EXPECT_EQ(weft({"check", "out"}), 0) << out_;
  // The same again, to the bit.
  fs::create_directory(at("twice"));
  ASSERT_EQ(weft({"convert", skirt(), "twice/skirt.json", "--body", form, "--edge", "0.04",
                  "--fabric", "denim"}),
            0);
  for (const char* name : {"skirt.json", "skirt_garment.obj", "skirt_body.obj"})
    EXPECT_EQ(text_of(at("new") / name), text_of(at("twice") / name)) << name;
}

/// The block of a scene and the converted pattern are one code, so both start alike.
TEST_F(Garments, BlockOfASceneIsTheConvertedPattern) {
  const std::string form = body();
  ASSERT_EQ(weft({"convert", skirt(), "scene.json", "--body", form, "--edge", "0.04"}), 0) << err_;
  fs::copy_file(skirt(), at("pattern.json"));
  const Json block{
      {"up", "y"},
      {"materials", {{"cloth", {{"fabric", "cotton_polyester"}, {"damping", {{"mass", 4}}}}}}},
      {"garments",
       {{{"name", "skirt"},
         {"pattern", "pattern.json"},
         {"edge", 0.04},
         {"material", {{"*", "cloth"}}}}}},
      {"obstacles", {{{"name", "body"}, {"mesh", "scene_body.obj"}}}}};
  write("block.json", block.dump());
  for (const char* scene : {"scene", "block"})
    ASSERT_EQ(weft({"run", std::string(scene) + ".json", "-o", scene, "--no-preview", "--frames",
                    "1", "--device", "cpu"}),
              0)
        << err_;
  EXPECT_EQ(text_of(at("scene/frames/cloth_00001.obj")),
            text_of(at("block/frames/cloth_00001.obj")));
  EXPECT_EQ(hash("scene"), hash("block"));
}

TEST_F(Garments, WrongInputGetsOneLine) {
  const auto refused = [&](const std::vector<std::string>& words, const std::string& what) {
    EXPECT_EQ(weft(words), 2) << err_;
    EXPECT_NE(err_.find(what), std::string::npos) << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
  };
  refused({"convert", skirt(), "a.json", "--edge", "0"}, "--edge: 0 ");
  refused({"convert", skirt(), "a.json", "--edge", "nan"}, "--edge: nan ");
  refused({"convert", skirt(), "a.json", "--fabric", "tweed"}, "tweed");
  refused({"convert", skirt(), "a.json", "--body", "nobody.obj"}, "nobody.obj");
  refused({"convert", write("cut.json", text_of(skirt()).substr(0, 900)), "a.json"}, "cut.json");
  Json open = Json::parse(text_of(skirt()));
  open["pattern"]["panels"]["left_front"]["edges"].erase(2);
  refused({"convert", write("open.json", open.dump()), "a.json"},
          "pattern.panels.left_front.edges[2].endpoints: an outline that is open");
  refused({"convert", write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "a.ply", "--edge",
           "0.01"},
          "--edge: beside ");
  Json far = Json::parse(text_of(skirt()));
  far["pattern"]["panels"]["left_front"]["translation"][2] = 500;
  const std::string form = body();
  refused({"convert", write("far.json", far.dump()), "a.json", "--body", form},
          "far.json: pattern.panels.left_front: 4.");
  EXPECT_FALSE(fs::exists(at("a.json")));
  EXPECT_FALSE(fs::exists(at("a_garment.obj")));
  // A scene reads patterns only below its own folder.
  const Json outside{{"garments", {{{"pattern", skirt()}}}}};
  refused({"run", write("outside.json", outside.dump()), "-o", "out", "--no-preview"},
          "garments[0].pattern: ");
  write("scene.json", R"({"garments": [{"pattern": "small.json"}]})");
  refused({"run", "scene.json", "-o", "out", "--no-preview"}, "small.json: pattern: missing");
}

TEST_F(Garments, DressesAGivenBody) {
  const fs::path shirt = data_file("shirt_mean_specification.json");
  if (shirt.empty()) GTEST_SKIP() << "WEFT_TEST_DATA holds no garments/shirt_mean";
  drape(shirt.string(), data_file("f_smpl_average_A40.obj").string(), "0.03");
  EXPECT_EQ(weft({"check", "out", "--worn"}), 0) << out_ << err_;
  EXPECT_NE(out_.find("out: garment shirt_mean: worn\n"), std::string::npos) << out_;
}

TEST_F(Garments, SlowDressesAGivenBody) {
  for (const char* name : {"shirt_mean", "dress_pencil"}) {
    const fs::path pattern = data_file(std::string(name) + "_specification.json");
    if (pattern.empty()) GTEST_SKIP() << "WEFT_TEST_DATA holds no garments/" << name;
    for (const char* edge : {"0.015", "0.02"}) {
      fs::remove_all(at("out"));
      drape(pattern.string(), data_file("f_smpl_average_A40.obj").string(), edge);
    }
  }
}

}  // namespace
}  // namespace weft::test
