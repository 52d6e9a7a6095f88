#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>
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
  void drape(const std::string& pattern, const std::string& body, const std::string& edge,
             const std::string& start = "auto") {
    ASSERT_EQ(weft({"convert", pattern, "scene.json", "--body", body, "--edge", edge}), 0) << err_;
    ASSERT_EQ(weft({"run", "scene.json", "-o", "out", "--no-preview", "--device", "cpu", "--set",
                    "garments.0.start=" + start}),
              0)
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
  const Json scene = Json::parse(text_of(at("new/skirt.json")));
  EXPECT_EQ(scene.at("materials").at("cloth").at("fabric"), "denim");
  EXPECT_EQ(scene.at("garments").at(0).at("name"), "skirt");
  EXPECT_EQ(scene.at("garments").at(0).at("pattern"), "skirt_skirt.json");
  EXPECT_EQ(Json::parse(text_of(at("new/skirt_skirt.json"))), Json::parse(text_of(skirt())));
  ASSERT_EQ(weft({"run", "new/skirt.json", "-o", "out", "--no-preview", "--frames", "3", "--device",
                  "cpu"}),
            0)
      << err_;
  EXPECT_EQ(weft({"check", "out"}), 0) << out_;
  const std::string frame = text_of(at("out/frames/cloth_00003.obj"));
  for (const char* line : {"\n# panel left_front leg\n", "\ng left_front\n", "\ng right_back\n"})
    EXPECT_NE(frame.find(line), std::string::npos) << line;
  const Json garments = report("out").at("garments");
  EXPECT_EQ(garments, Json::parse(R"([{"garment": "skirt", "start": "welded", "reason": null}])"));
  // The same again, to the bit.
  fs::create_directory(at("twice"));
  ASSERT_EQ(weft({"convert", skirt(), "twice/skirt.json", "--body", form, "--edge", "0.04",
                  "--fabric", "denim"}),
            0);
  for (const char* name : {"skirt.json", "skirt_skirt.json", "skirt_body.obj"})
    EXPECT_EQ(text_of(at("new") / name), text_of(at("twice") / name)) << name;
}

/// In the order of the arguments, each over those before.
TEST_F(Garments, SeveralPatternsBecomeLayers) {
  const std::string form = body();
  ASSERT_EQ(weft({"convert", skirt(), skirt(), "pair.json", "--body", form, "--edge", "0.05"}), 0)
      << err_;
  EXPECT_TRUE(out_.starts_with("pair.json: 8 panels, 16 stitches, ")) << out_;
  const Json garments = Json::parse(text_of(at("pair.json"))).at("garments");
  ASSERT_EQ(garments.size(), 2u);
  EXPECT_EQ(garments.at(0).at("name"), "skirt");
  EXPECT_EQ(garments.at(1).at("name"), "skirt_2");
  EXPECT_EQ(garments.at(0).at("layer"), 0);
  EXPECT_EQ(garments.at(1).at("layer"), 1);
  ASSERT_EQ(
      weft({"run", "pair.json", "-o", "out", "--no-preview", "--frames", "2", "--device", "cpu"}),
      0)
      << err_;
  EXPECT_EQ(weft({"check", "out"}), 0) << out_;
  EXPECT_EQ(report("out").at("garments").size(), 2u);
}

TEST_F(Garments, CopiesTheDrawingOfAPattern) {
  fs::create_directory(at("new"));
  write("tube.svg", R"(<svg width="400mm" height="300mm" viewBox="0 0 400 300">)"
                    R"(<path id="front" d="M 0 0 H 300 V 300 H 0 Z"/></svg>)");
  const Json pattern = Json::parse(R"({"pattern": {"outlines": "tube.svg",
      "panels": {"front": {"translation": [0, 100, 30], "rotation": [0, 0, 0]}},
      "stitches": []}, "properties": {"units_in_meter": 100}})");
  ASSERT_EQ(weft({"convert", write("tube.json", pattern.dump()), "new/scene.json"}), 0) << err_;
  const Json copy = Json::parse(text_of(at("new/scene_tube.json")));
  EXPECT_EQ(copy.at("pattern").at("outlines"), "scene_tube_outlines.svg");
  EXPECT_EQ(text_of(at("new/scene_tube_outlines.svg")), text_of(at("tube.svg")));
  ASSERT_EQ(weft({"run", "new/scene.json", "-o", "out", "--no-preview", "--frames", "1", "--device",
                  "cpu"}),
            0)
      << err_;
}

/// Without a body, a skirt whose waist is held hangs from it, until it is let go.
TEST_F(Garments, AttachedEdgesStayAtTheirHeight) {
  fs::copy_file(skirt(), at("pattern.json"));
  const auto lowest = [&](const std::string& attach, const std::string& out) {
    write("scene.json",
          R"({"time": {"step": 0.005, "frame_rate": 25, "frames": 20},
              "garments": [{"name": "skirt", "pattern": "pattern.json", "edge": 0.05, "attach": )" +
              attach + "}]}");
    EXPECT_EQ(weft({"run", "scene.json", "-o", out, "--no-preview", "--device", "cpu"}), 0) << err_;
    double least = 1e9;
    std::istringstream lines(text_of(at(out) / "frames" / "cloth_00020.obj"));
    for (std::string line; std::getline(lines, line);) {
      double x = 0, y = 0, z = 0;
      if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3) least = std::min(least, z);
    }
    return least;
  };
  // The hem starts at 0.54 m; 0.8 s of free fall are 3.1 m, and 0.6 s are 1.8 m.
  EXPECT_LT(lowest("[]", "free"), -2.3);
  EXPECT_EQ(out_.find("attached edges"), std::string::npos) << out_;
  EXPECT_GT(lowest(R"([{"label": "lower_interface"}])", "held"), 0.4);
  EXPECT_NE(out_.find("attached edges of \"skirt\" bear "), std::string::npos) << out_;
  const double released = lowest(R"([{"label": "lower_interface", "end_time": 0.2}])", "released");
  EXPECT_LT(released, -0.9);
  EXPECT_GT(released, -1.6);
}

TEST_F(Garments, WrongInputGetsOneLine) {
  const auto refused = [&](const std::vector<std::string>& words, const std::string& what) {
    EXPECT_EQ(weft(words), 2) << err_;
    EXPECT_NE(err_.find(what), std::string::npos) << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
  };
  refused({"convert", skirt(), "a.json", "--edge", "0"}, "--edge: 0;");
  refused({"convert", skirt(), "a.json", "--edge", "nan"}, "--edge: nan;");
  refused({"convert", skirt(), "a.json", "--fabric", "tweed"}, "weft: --fabric: \"tweed\"");
  refused({"convert", skirt(), "a.json", "--edge", "1e-5"}, "weft: --edge: 1e-5 m");
  refused({"convert", skirt(), "a.json", "--edge", "1.7"},
          "weft: --edge: 1.7 m; allowed: a length in metres");
  const Json inner = Json::parse(text_of(skirt())).at("pattern");
  refused({"convert", write("inner.json", inner.dump()), "a.json"},
          "inner.json: panels: outside of \"pattern\"");
  refused({"convert", write("other.json", R"({"panel": 1})"), "a.json", "--body", "b.obj"},
          "other.json: pattern: missing");
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
  EXPECT_FALSE(fs::exists(at("a_skirt.json")));
  refused({"convert", form, form, "a.ply"}, "IN: 2 files;");
  // Attachments name what the pattern has.
  const auto attached = [&](const char* entry) {
    fs::copy_file(skirt(), at("own.json"), fs::copy_options::overwrite_existing);
    return write("attached.json",
                 R"({"garments": [{"pattern": "own.json", "edge": 0.1, "attach": [)" +
                     std::string(entry) + "]}]}");
  };
  const std::pair<const char*, const char*> wrong[] = {
      {R"({"panel": "left", "edge": 0})", "garments[0].attach[0].panel: \"left\";"},
      {R"({"panel": "left_front", "edge": 9})", "garments[0].attach[0].edge: 9;"},
      {R"({"label": "waist"})", "garments[0].attach[0].label: \"waist\";"},
      {R"({"label": "waist", "edge": 1})", "garments[0].attach[0].edge: 1;"},
      {R"({"panel": "left_front", "edge": 1, "along": [0, 0, 0]})",
       "garments[0].attach[0].along: "},
      {R"({"panel": "left_front", "edge": 1, "end_time": 0})",
       "garments[0].attach[0].end_time: 0;"},
      {R"({"edge": 1})", "garments[0].attach[0]"}};
  for (const auto& [entry, what] : wrong)
    refused({"run", attached(entry), "-o", "out", "--no-preview"}, what);
  const auto made_of = [&](const char* entry) {
    return write("made.json",
                 R"({"garments": [{"pattern": "own.json", )" + std::string(entry) + "}]}");
  };
  const std::pair<const char*, const char*> odd[] = {
      {R"("edge": 1e-5)", "made.json: garments[0].edge: 1e-5 m"},
      {R"("fabric": {"collar": "silk", "*": "wool"})", "garments[0].fabric.collar: unknown key;"},
      {R"("fabric": {"left_front": "silk"})", "garments[0].fabric.left_back: missing;"}};
  for (const auto& [entry, what] : odd)
    refused({"run", made_of(entry), "-o", "out", "--no-preview"}, what);
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

/// Under the arms, springs leave pairs open by some millimetres: there four panels meet.
TEST_F(Garments, SpringsDressAGivenBody) {
  const fs::path shirt = data_file("shirt_mean_specification.json");
  if (shirt.empty()) GTEST_SKIP() << "WEFT_TEST_DATA holds no garments/shirt_mean";
  drape(shirt.string(), data_file("f_smpl_average_A40.obj").string(), "0.03", "springs");
  EXPECT_EQ(weft({"check", "out", "--worn"}), 0) << out_ << err_;
}

/// The waist of this dress stands at the hips, where it would be too tight.
TEST_F(Garments, HoldsAWaistAtTheBodysWaist) {
  const fs::path dress = data_file("dress_pencil_specification.json");
  if (dress.empty()) GTEST_SKIP() << "WEFT_TEST_DATA holds no garments/dress_pencil";
  drape(dress.string(), data_file("f_smpl_average_A40.obj").string(), "0.04");
  const Json scene = Json::parse(text_of(at("scene.json")));
  const Json held = scene.at("garments").at(0).at("attach");
  ASSERT_EQ(held.size(), 1u);
  EXPECT_EQ(held.at(0).at("label"), "lower_interface");
  EXPECT_NEAR(held.at(0).at("at").get<double>(), 1.07, 0.03);
  EXPECT_EQ(weft({"check", "out", "--worn"}), 0) << out_ << err_;
}

/// A waist near the body's is held where it is, unless a bodice goes on above it; one far from it
/// is held at the body's. Panels alone decide: nothing is simulated.
TEST_F(Garments, LetsGoAWaistThatABodiceHolds) {
  const std::string script = (fs::path(WEFT_SOURCE_DIR) / "tests/garments/mannequin.py").string();
  ASSERT_EQ(wait(start_words({WEFT_PYTHON, "-B", script, "body.obj", "--cell", "0.05"})), 0)
      << err_;
  const auto held = [&](double height, double bodice) {
    Json panels;
    for (const double z : {-25.0, 25.0}) {
      const auto add = [&](const std::string& name, double low, double high, const char* label) {
        const Json path = {{-25, low}, {25, low}, {25, high}, {-25, high}};
        Json edges;
        for (int k = 0; k < 4; ++k) edges.push_back({{"endpoints", {k, (k + 1) % 4}}});
        if (label != nullptr) edges.at(2)["label"] = label;
        panels[name + (z < 0 ? "_b" : "_f")] = {
            {"vertices", path}, {"edges", edges}, {"translation", {0, 0, z}}};
      };
      add("skirt", height - 40, height, "lower_interface");
      if (bodice > 0) add("bodice", height, height + bodice, nullptr);
    }
    const Json pattern = {{"pattern", {{"panels", panels}, {"stitches", Json::array()}}},
                          {"properties", {{"units_in_meter", 100}}}};
    EXPECT_EQ(weft({"convert", write("dress.json", pattern.dump()), "scene.json", "--body",
                    "body.obj", "--edge", "0.05"}),
              0)
        << err_;
    const Json garment = Json::parse(text_of(at("scene.json"))).at("garments").at(0);
    return garment.value("attach", Json());
  };
  const Json high = held(130, 0);
  ASSERT_EQ(high.size(), 1u) << high;
  const double waist = 100 * high.at(0).at("at").get<double>();  // [cm] of the body
  EXPECT_GT(waist, 85);
  EXPECT_LT(waist, 115);
  const Json in_place = Json::parse(R"([{"label": "lower_interface"}])");
  EXPECT_EQ(held(waist, 0), in_place);
  EXPECT_EQ(held(waist, 10), in_place);  // a waistband: less than 0.1 heights
  EXPECT_EQ(held(waist, 30), Json());
  const Json low = held(waist - 15, 45);
  ASSERT_EQ(low.size(), 1u) << low;
  EXPECT_NEAR(low.at(0).at("at").get<double>(), waist / 100, 1e-9);
}

/// Boxes are as wide as people with their arms out, so their size alone does not say what is up.
TEST_F(Garments, PatternsTellWhetherTheBodyStands) {
  const auto box = [&](const std::string& name, const std::string& low, const std::string& high) {
    std::string text;
    std::stringstream lows(low), highs(high);
    std::string a[3], b[3];
    for (int k = 0; k < 3; ++k) lows >> a[k], highs >> b[k];
    for (int v = 0; v < 8; ++v)
      text +=
          "v " + (v & 1 ? b : a)[0] + " " + (v & 2 ? b : a)[1] + " " + (v & 4 ? b : a)[2] + "\n";
    write(name, text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
  };
  Json pattern = Json::parse(R"({"pattern": {"panels": {
      "front": {"translation": [0, 0, 25], "vertices": [[-30, 60], [30, 60], [30, 140], [-30, 140]],
        "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]},
                  {"endpoints": [3, 0]}]}}}, "properties": {"units_in_meter": 100}})");
  Json& panels = pattern["pattern"]["panels"];
  panels["back"] = panels["front"];
  panels["back"]["translation"] = {0, 0, -25};
  panels["back"]["vertices"] = {{-30, 60}, {-30, 140}, {30, 140}, {30, 60}};
  const auto side = [](const char* panel, int edge) -> Json {
    return {{"panel", panel}, {"edge", edge}};
  };
  pattern["pattern"]["stitches"] = {{side("front", 1), side("back", 2)},
                                    {side("front", 3), side("back", 0)}};
  const auto converted = [&](const std::string& body) {
    write("tunic.json", pattern.dump());
    const int code =
        weft({"convert", "tunic.json", "scene.json", "--body", body, "--edge", "0.05"});
    return std::to_string(code) + " " + err_;
  };
  box("y.obj", "-0.7 0 -0.15", "0.7 1.7 0.15");
  EXPECT_EQ(converted("y.obj"), "0 ");
  const std::string standing = text_of(at("scene_body.obj"));
  box("z.obj", "-0.7 -0.15 0", "0.7 0.15 1.7");
  EXPECT_EQ(converted("z.obj"), "0 weft: warning: z.obj: taken for m, with z up\n");
  const auto corner = [](const std::string& text) { return text.find("\nv 0.7 1.7 0.15\n"); };
  EXPECT_NE(corner(standing), std::string::npos) << standing;
  EXPECT_NE(corner(text_of(at("scene_body.obj"))), std::string::npos);
  box("lying.obj", "0 -0.7 -0.15", "1.7 0.7 0.15");
  EXPECT_EQ(converted("lying.obj"),
            "0 weft: warning: tunic.json: the panels do not stand around the body of lying.obj; "
            "check that the body stands, its up axis, and the units of both\n");
  pattern["properties"]["units_in_meter"] = 1000;
  EXPECT_TRUE(converted("y.obj").starts_with(
      "2 weft: tunic.json: properties.units_in_meter: 1000, which makes a garment of 0.08 m"))
      << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  pattern["properties"]["units_in_meter"] = 100;
  pattern["pattern"]["stiches"] = pattern["pattern"]["stitches"];
  pattern["pattern"].erase("stitches");
  EXPECT_EQ(converted("y.obj"),
            "0 weft: warning: pattern.stiches: not read, so nothing is sewn; did you mean "
            "\"stitches\"?\n");
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
