// What dressed garments are written as: panels in the frames of every format, one welded mesh with
// its seams, and the way from outlines to a garment.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "tests/golden/process.hpp"
#include "weft/io.hpp"

namespace weft::test {
namespace {

using Names = std::vector<std::string>;

class GarmentOutputs : public Process {
 protected:
  static fs::path scenes() { return fs::path(WEFT_SOURCE_DIR) / "scenes"; }

  /// The skirt around its dress form, coarse and short.
  void dress(const std::string& output, const std::string& format, const std::string& scene) {
    ASSERT_EQ(weft({"run", scene, "-o", output, "--no-preview", "--frames", "1", "--device", "cpu",
                    "--set", "garments.0.edge=0.08", "--set", "output.format=" + format}),
              0)
        << err_;
  }
  std::string shipped() const { return (scenes() / "skirt.json").string(); }

  /// The same, of a pattern without labels.
  std::string unlabelled() {
    fs::create_directories(at("patterns"));
    Json pattern = Json::parse(text_of(scenes() / "patterns" / "skirt_specification.json"));
    for (auto& panel : pattern.at("pattern").at("panels")) panel.erase("label");
    write("patterns/skirt_specification.json", pattern.dump());
    return write("plain.json", text_of(scenes() / "skirt.json"));
  }

  /// Names of the panels that `check --worn` finds in frames which nothing stands beside.
  Names worn_panels(const std::string& run) {
    fs::remove_all(at("alone"));
    fs::create_directories(at("alone"));
    fs::copy(at(run) / "frames", at("alone/frames"));
    weft({"check", "alone", "--worn", "--sewn", "--json"});
    const Json worn = Json::parse(out_).at("worn");
    EXPECT_EQ(worn.size(), 1u) << out_;
    EXPECT_EQ(worn.at(0).at("garment"), "skirt") << run;
    Names names;
    for (const Json& panel : worn.at(0).at("panels")) names.push_back(panel.at("name"));
    return names;
  }
};

const Names four{"left_back", "left_front", "right_back", "right_front"};

/// glTF as it is read from a run is the spool beside it.
TEST_F(GarmentOutputs, PanelsAreKnownFromFramesAlone) {
  const std::string plain = unlabelled();
  for (const char* format : {"obj", "ply", "pc2", "usda", "glb"}) {
    dress(format, format, plain);
    EXPECT_EQ(worn_panels(format), four) << format;
    for (const char* file : {"w.obj", "w.ply"}) {
      ASSERT_EQ(weft({"convert", "alone", file, "--frame", "1", "--weld", "--only", "cloths"}), 0)
          << err_;
      EXPECT_EQ(load_frame(at(file), 0).at(0).mesh.part_names, four) << format << " " << file;
    }
    fs::remove_all(at(format));
  }
}

TEST_F(GarmentOutputs, FramesKeepLabelsBesidePanels) {
  for (const char* format : {"obj", "ply", "pc2", "usda", "glb"}) {
    dress(format, format, shipped());
    EXPECT_EQ(worn_panels(format), Names{"leg"}) << format;
    const std::vector<FrameMesh> frame = load_frame(at(format), 1);
    ASSERT_EQ(frame.size(), 2u) << format;
    EXPECT_EQ(frame[0].name, "skirt") << format;
    EXPECT_FALSE(frame[0].obstacle);
    EXPECT_TRUE(frame[1].obstacle);
    const Mesh& mesh = frame[0].mesh;
    EXPECT_EQ(mesh.part_names, four) << format;
    EXPECT_EQ(mesh.part_labels, (Names{"leg", "leg", "leg", "leg"})) << format;
    EXPECT_EQ(mesh.part.size(), mesh.triangles.size()) << format;
    EXPECT_EQ(mesh.material.size(), mesh.positions.size()) << format;
    fs::remove_all(at(format));
  }
}

TEST_F(GarmentOutputs, BodyThatStandsIsWrittenOnce) {
  const auto names = [&](const char* format) {
    dress(format, format, shipped());
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(at(format) / "frames"))
      found.insert(entry.path().filename().string());
    return found;
  };
  using Files = std::set<std::string>;
  EXPECT_EQ(names("obj"), (Files{"cloth_00000.obj", "cloth_00001.obj", "obstacle.obj"}));
  EXPECT_EQ(names("ply"), (Files{"cloth_00000.ply", "cloth_00001.ply", "obstacle.ply"}));
  EXPECT_EQ(names("pc2"), (Files{"cloth.skirt.obj", "cloth.skirt.pc2", "obstacle.form.obj"}));
}

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t p = text.find(what); p != std::string::npos; p = text.find(what, p + 1)) ++n;
  return n;
}

/// The chunk of a .glb that is JSON.
Json json_of_glb(const std::string& bytes) {
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  return Json::parse(bytes.substr(20, length));
}

TEST_F(GarmentOutputs, WeldMakesOneMeshOfAGarment) {
  dress("run", "obj", shipped());
  const Mesh before = load_frame(at("run"), 1).at(0).mesh;
  for (const char* file : {"w.obj", "w.ply", "w.glb"})
    ASSERT_EQ(weft({"convert", "run", file, "--frame", "last", "--weld"}), 0) << err_;
  const Mesh obj = io::read_mesh(at("w.obj"), io::Uv::where_all);
  const Mesh ply = io::read_mesh(at("w.ply"), io::Uv::ignore);
  EXPECT_EQ(obj.object_names, (Names{"skirt", "form"}));
  EXPECT_EQ(ply.object_names, obj.object_names);
  EXPECT_EQ(ply.positions, obj.positions);
  EXPECT_EQ(ply.part, obj.part);
  Names panels = obj.part_names;
  EXPECT_EQ(panels, (Names{"left_back", "left_front", "right_back", "right_front", "form"}));
  // Each triangle is at the place where it was, and no two vertices of the garment are at one.
  std::set<std::array<double, 3>> places;
  std::set<Index> used;
  for (std::size_t t = 0; t < before.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index v = obj.triangles[t].v[k];
      const Vec3<double>& x = obj.positions[static_cast<std::size_t>(v)];
      EXPECT_EQ(x, before.positions[static_cast<std::size_t>(before.triangles[t].v[k])]);
      const bool fresh = used.insert(v).second;
      EXPECT_EQ(places.insert({x[0], x[1], x[2]}).second, fresh) << v;
    }
  EXPECT_LT(used.size(), before.positions.size());
  // A tube with four darts, which are closed: it has two boundaries, so that V - E + F is 0.
  const std::size_t faces = before.triangles.size();
  std::set<std::array<Index, 2>> edges;
  for (std::size_t t = 0; t < faces; ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = obj.triangles[t].v[k], b = obj.triangles[t].v[(k + 1) % 3];
      edges.insert({std::min(a, b), std::max(a, b)});
    }
  EXPECT_EQ(used.size() + faces, edges.size());
  // Seam edges are edges of the mesh, as many in each format.
  std::istringstream lines(text_of(at("w.obj")));
  std::size_t seams = 0;
  for (std::string line; std::getline(lines, line);) {
    Index a = 0, b = 0;
    if (std::sscanf(line.c_str(), "l %d %d", &a, &b) != 2) continue;
    ++seams;
    EXPECT_TRUE(edges.contains({std::min(a, b) - 1, std::max(a, b) - 1})) << line;
  }
  EXPECT_GT(seams, 8u);
  EXPECT_EQ(count_of(text_of(at("w.ply")), "\nelement edge " + std::to_string(seams) + "\n"), 1u);
  const Json glb = json_of_glb(text_of(at("w.glb")));
  const Json& primitives = glb.at("meshes").at(0).at("primitives");
  ASSERT_EQ(primitives.size(), 5u);
  for (std::size_t p = 0; p < 4; ++p)
    EXPECT_EQ(primitives[p].at("extras"), (Json{{"panel", four[p]}, {"label", "leg"}}));
  EXPECT_EQ(primitives[4].at("mode"), 1);
  const std::size_t indices = primitives[4].at("indices");
  EXPECT_EQ(glb.at("accessors").at(indices).at("count"), 2 * seams);
}

TEST_F(GarmentOutputs, WeldedFramesAreASequence) {
  dress("run", "usda", shipped());
  ASSERT_EQ(weft({"convert", "run", "w_%d.obj", "--weld"}), 0) << err_;
  const Mesh first = io::read_mesh(at("w_0.obj"), io::Uv::where_all);
  const Mesh last = io::read_mesh(at("w_1.obj"), io::Uv::where_all);
  EXPECT_EQ(first.positions.size(), last.positions.size());
  ASSERT_EQ(weft({"convert", "w_%d.obj", "again.glb"}), 0) << err_;
  EXPECT_EQ(json_of_glb(text_of(at("again.glb"))).at("meshes").size(), 2u);
  EXPECT_EQ(weft({"convert", "run", "x.obj", "--frame", "first"}), 2);
  EXPECT_NE(err_.find("--frame: first; allowed: the number of a frame, or last"), std::string::npos)
      << err_;
  EXPECT_EQ(weft({"convert", "run", "x.obj", "--frame", "7"}), 2);
  EXPECT_NE(err_.find("--frame: 7; allowed: one of the 2 frames from 0 to 1"), std::string::npos)
      << err_;
}

/// Two panels from a drawing, sewn around a ball.
TEST_F(GarmentOutputs, OutlinesBecomeAGarment) {
  write("tube.svg",
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="700mm" viewBox="0 0 700 300">)"
        R"(<path id="front" d="M0 0h300q10 100 0 200h-300q-10-100 0-200z"/>)"
        R"(<path id="back" d="M350 0h300q-10 100 0 200h-300q10-100 0-200z"/></svg>)");
  ASSERT_EQ(weft({"convert", "tube.svg", "tube.json"}), 0) << err_;
  EXPECT_NE(out_.find("front: 4 edges\n  0: (-15.0, 10.0) to (15.0, 10.0) cm, 30.0 cm long\n"),
            std::string::npos)
      << out_;
  EXPECT_EQ(weft({"convert", "tube.svg", "tube.json"}), 2);
  EXPECT_NE(err_.find("OUT: a file that is there; allowed: "), std::string::npos) << err_;
  Json pattern = Json::parse(text_of(at("tube.json")));
  auto& panels = pattern.at("pattern").at("panels");
  panels.at("front").at("translation") = {0, 0, 12};
  panels.at("back").at("translation") = {0, 0, -12};
  panels.at("back").at("rotation") = {0, 180, 0};
  const auto side = [](const char* panel, int edge) {
    return Json{{"panel", panel}, {"edge", edge}};
  };
  pattern.at("pattern").at("stitches") = {{side("front", 1), side("back", 3)},
                                          {side("front", 3), side("back", 1)}};
  write("tube.json", pattern.dump());
  write("scene.json", R"({"garments": [{"name": "tube", "pattern": "tube.json", "edge": 0.04}],
                          "gravity": [0, 0, -1], "time": {"frames": 2},
                          "obstacles": [{"name": "body", "sphere": {"radius": 0.08}}]})");
  ASSERT_EQ(weft({"run", "scene.json", "-o", "out", "--no-preview", "--device", "cpu"}), 0) << err_;
  EXPECT_EQ(weft({"check", "out"}), 0) << out_;
  for (const Json& seam : report("out").at("seams")) EXPECT_EQ(seam.at("open"), 0);
  EXPECT_EQ(load_frame(at("out"), 2).at(0).mesh.part_names, (Names{"back", "front"}));
  ASSERT_EQ(weft({"convert", "tube.json", "dressed.json"}), 0) << err_;
  EXPECT_EQ(weft({"convert", "tube.svg", "other.json", "--edge", "0.01"}), 2);
  EXPECT_NE(err_.find("--edge: beside tube.svg"), std::string::npos) << err_;
  // An outline is read only below the folder of its pattern.
  fs::create_directory(at("inner"));
  fs::copy_file(at("tube.json"), at("inner/tube.json"));
  pattern.at("pattern").at("outlines") = "../tube.svg";
  write("inner/tube.json", pattern.dump());
  EXPECT_EQ(weft({"convert", "inner/tube.json", "no.json"}), 2);
  EXPECT_NE(err_.find("pattern.outlines"), std::string::npos) << err_;
}

}  // namespace
}  // namespace weft::test
