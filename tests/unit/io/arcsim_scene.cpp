#include "host/io/arcsim/arcsim_scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>

#include "host/io/arcsim/arcsim_material.hpp"
#include "host/io/arcsim/arcsim_motion.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/scene/fabric/measured.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

class ArcsimTest : public DirectoryTest {
 protected:
  void SetUp() override {
    DirectoryTest::SetUp();
    fs::create_directories(directory_ / "conf");
    put("square.obj",
        "v 0 0 0\nnl 1\nv 1 0 0\nv 1 1 0\nnl 1\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\ntl 1\n");
    put("paper.json",
        "// isotropic\n{\"density\": 0.1, \"stretching\": [[100, 20, 100, 80], [100, 20, 100, 80],"
        "[100, 20, 100, 80], [100, 20, 100, 80], [100, 20, 100, 80], [100, 20, 100, 80]],"
        "\"bending\": [[4, 4, 4, 4, 4], [4, 4, 4, 4, 4], [4, 4, 4, 4, 4]]}");
  }

  /// A scene in conf/, whose files stand one folder above.
  fs::path scene(const std::string& more, const std::string& cloth_more = "",
                 const std::string& materials = R"([{"data": "paper.json"}, {"data": "paper.json",
                                                    "thicken": 2}])") const {
    return put("conf/a.json", "// a comment\n{\"cloths\": [{\"mesh\": \"square.obj\"," +
                                  cloth_more + "\"materials\": " + materials + "}]" + more + "}");
  }
};

TEST_F(ArcsimTest, TimeWindHandlesAndMaterials) {
  const Scene scene = read_scene(this->scene(R"(, "frame_time": 0.04, "frame_steps": 8,
    "end_time": 2, "gravity": [0, 0, -9.8], "wind": {"velocity": [10, 0, 0]},
    "magic": {"repulsion_thickness": 5e-3, "handle_stiffness": 50},
    "motions": [[{"time": 0, "transform": {}}, {"time": 2, "transform": {"translate": [1, 0, 0]}}]],
    "handles": [{"nodes": [0], "end_time": 1}, {"label": 1, "motion": 0},
                {"type": "glue", "nodes": [1, 3]},
                {"nodes": [3], "start_time": 0.5}])",
                                             R"("velocity": {"angular": [0, 0, 2]},)"));
  EXPECT_NEAR(scene.time.step, 0.005, 1e-15);
  EXPECT_NEAR(scene.time.frame_rate, 25, 1e-12);
  EXPECT_EQ(scene.time.frames, 50);
  EXPECT_EQ(scene.wind.density, 1);
  EXPECT_EQ(scene.wind.velocity[0], 10);
  EXPECT_EQ(contact_thickness(scene.contact), 5e-3);
  EXPECT_EQ(scene.contact.friction, 0.6);
  EXPECT_EQ(scene.cloths.at(0).angular_velocity[2], 2);
  ASSERT_EQ(scene.pins.size(), 2u);
  EXPECT_EQ(scene.pins[0].vertices, std::vector<Index>{0});
  EXPECT_EQ(scene.pins[0].release_time, 1);
  EXPECT_EQ(scene.pins[1].vertices, std::vector<Index>{2});  // node 0 is pinned already
  EXPECT_EQ(scene.pins[1].motion.size(), 2u);
  ASSERT_EQ(scene.handles.size(), 3u);
  EXPECT_EQ(scene.handles[0].vertices, std::vector<Index>{0});
  EXPECT_EQ(scene.handles[1].shape, Handle::Shape::glue);
  EXPECT_EQ(scene.handles[2].start_time, 0.5);
  EXPECT_EQ(scene.handles[2].stiffness, 50);
  // the second face has label 1: twice as thick
  ASSERT_EQ(scene.cloths[0].triangle_material.size(), 2u);
  const auto density = [&](std::size_t t) {
    return scene.materials.at(static_cast<std::size_t>(scene.cloths[0].triangle_material[t]))
        .density;
  };
  EXPECT_NEAR(density(0), 0.1, 1e-15);
  EXPECT_NEAR(density(1), 0.2, 1e-15);
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
}

TEST_F(ArcsimTest, IsotropicFit) {
  bool averaged = true;
  const Material m = read_arcsim_material(directory_ / "paper.json", {2, 3, 5, 7, 0.25}, averaged);
  EXPECT_FALSE(averaged);
  EXPECT_FALSE(m.measured);
  EXPECT_NEAR(m.density, 0.1 * 2 * 7, 1e-12);
  EXPECT_NEAR(m.poisson_ratio, 0.2, 1e-12);
  EXPECT_NEAR(m.stretch_stiffness, 2 * 100 * (1 - 0.04) * 3 * 7, 1e-9);
  EXPECT_NEAR(m.bending_stiffness, 1.0 * 5 * 7, 1e-12);
  EXPECT_EQ(m.damping_stiffness, 0.25);
}

TEST_F(ArcsimTest, MeasuredTablesAreKept) {
  put("knit.json",
      "{\"density\": 0.1, \"stretching\": [[100, 20, 50, 80], [101, 20, 50, -80],"
      "[102, 20, 50, 80], [103, 20, 50, 80], [104, 20, 50, 80], [105, 20, 50, 80]],"
      "\"bending\": [[4, 4, 4, 4, 4], [4, 4, 4, 4, 4], [4, 4, 4, 4, 5]]}");
  const Scene scene = read_scene(this->scene(
      R"(, "frame_time": 0.04, "end_time": 2)", "",
      R"([{"data": "knit.json", "stretching_mult": 3, "thicken": 2}, {"data": "paper.json"}])"));
  ASSERT_EQ(scene.materials.size(), 2u);
  const Material& knit = scene.materials[scene.materials[0].name == "knit" ? 0 : 1];
  const Material& paper = scene.materials[scene.materials[0].name == "knit" ? 1 : 0];
  EXPECT_FALSE(paper.measured);
  EXPECT_GT(paper.stretch_stiffness, 100);
  ASSERT_TRUE(knit.measured);
  EXPECT_EQ(knit.measured->form, MeasuredStretch::Form::arcsim);
  EXPECT_EQ(knit.measured->rows[0], (std::array<double, 4>{600, 120, 300, 480}));
  EXPECT_EQ(knit.measured->rows[1], (std::array<double, 4>{606, 120, 300, -480}));
  EXPECT_NEAR(knit.bending_stiffness, 2, 1e-12);
  EXPECT_EQ(knit.poisson_ratio, 0);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("bending"), std::string::npos);
}

TEST_F(ArcsimTest, BendingOfThreadsThatDiffer) {
  put("twill.json",
      "{\"density\": 0.1, \"stretching\": [[100, 20, 100, 80], [100, 20, 100, 80],"
      "[100, 20, 100, 80], [100, 20, 100, 80], [100, 20, 100, 80], [100, 20, 100, 80]],"
      "\"bending\": [[4, 4, 4, 4, 4], [8, 8, 8, 8, 8], [16, 16, 16, 16, 16]]}");
  const Scene scene = read_scene(this->scene(
      R"(, "frame_time": 0.04, "end_time": 2)", "",
      R"([{"data": "twill.json", "bending_mult": 3, "thicken": 2, "strain_limits": [0.95, 1.05]},
          {"data": "paper.json", "strain_limits": [-1, 1.2]}])"));
  ASSERT_EQ(scene.materials.size(), 2u);
  const Material& twill = scene.materials[scene.materials[0].name == "twill" ? 0 : 1];
  const Material& paper = scene.materials[scene.materials[0].name == "twill" ? 1 : 0];
  ASSERT_TRUE(twill.orthotropic_bending);
  // A hinge along the warp bends the weft.
  EXPECT_NEAR(twill.orthotropic_bending->weft, 1 * 3 * 2, 1e-12);
  EXPECT_NEAR(twill.orthotropic_bending->warp, 4 * 3 * 2, 1e-12);
  EXPECT_EQ(twill.orthotropic_bending->coupling, 0);
  EXPECT_NEAR(twill.orthotropic_bending->twist, (2 - (1 + 4) / 4.0) * 3 * 2, 1e-12);
  EXPECT_FALSE(paper.orthotropic_bending);
  ASSERT_TRUE(twill.strain_limits && paper.strain_limits);
  EXPECT_EQ(twill.strain_limits->min, 0.95);
  EXPECT_EQ(twill.strain_limits->max, 1.05);
  EXPECT_EQ(paper.strain_limits->min, 0);
  EXPECT_TRUE(scene.warnings.empty());
}

/// How near an energy can come to the fabrics of ARCSim, as scenes/README.md says.
TEST_F(ArcsimTest, FitsOfBundledFabrics) {
  const char* data = std::getenv("WEFT_TEST_DATA");
  const fs::path folder = data ? fs::path(data) / "arcsim" / "materials" : fs::path();
  if (!data || !fs::exists(folder)) GTEST_SKIP() << "WEFT_TEST_DATA holds no arcsim/materials";
  const std::map<std::string, double> error{
      {"11oz-black-denim", 0.0082}, {"camel-ponte-roma", 0.151},   {"gray-interlock", 0.164},
      {"ivory-rib-knit", 0.221},    {"navy-sparkle-sweat", 0.245}, {"pink-ribbon-brown", 0.135},
      {"royal-target", 0.0076},     {"tango-red-jet-set", 0.182},  {"white-dots-on-blk", 0.0067},
      {"white-swim-solid", 0.247}};
  for (const auto& [name, most] : error) {
    bool averaged = false;
    const Material m = read_arcsim_material(folder / (name + ".json"), {}, averaged);
    ASSERT_TRUE(m.measured) << name;
    EXPECT_TRUE(averaged) << name;
    const double found = fit_measured(*m.measured).error;
    EXPECT_LE(found, most) << name;
    EXPECT_GE(found, 0.98 * most) << name;
  }
  for (const char* name : {"paper", "aluminium"}) {
    bool averaged = true;
    EXPECT_FALSE(
        read_arcsim_material(folder / (std::string(name) + ".json"), {}, averaged).measured);
    EXPECT_FALSE(averaged);
  }
}

TEST_F(ArcsimTest, LegacyTimeKeysAndWarnings) {
  const Scene scene = read_scene(this->scene(R"(, "timestep": 0.01, "save_frames": 4, "duration": 1,
    "morphs": [{"cloth": 0}], "fracture": true)",
                                             R"("remeshing": {"size": [0.1, 1]},)"));
  EXPECT_NEAR(scene.time.step, 0.01, 1e-15);
  EXPECT_EQ(scene.time.frames, 25);
  ASSERT_EQ(scene.warnings.size(), 2u);
  EXPECT_NE(scene.warnings[0].find("fracture"), std::string::npos);
  EXPECT_NE(scene.warnings[1].find("morphs"), std::string::npos);
}

TEST_F(ArcsimTest, RemeshingMakesTheSceneAdaptive) {
  const std::string block = R"("remeshing": {"size": [0.1, 1], "refine_angle": 0.4},)";
  const Scene scene = read_scene(this->scene(R"(, "frame_time": 0.04, "end_frame": 3)", block));
  EXPECT_EQ(scene.method, "adaptive");
  EXPECT_EQ(scene.adaptive.remeshing.size_min, 0.1);
  EXPECT_EQ(scene.adaptive.remeshing.size_max, 1);
  EXPECT_EQ(scene.adaptive.remeshing.refine_angle, 0.4);
  EXPECT_TRUE(std::isinf(scene.adaptive.remeshing.refine_velocity));
  EXPECT_EQ(scene.adaptive.remeshing.aspect_min, 0);
  const Scene off = read_scene(
      this->scene(R"(, "frame_time": 0.04, "end_frame": 3, "disable": ["remeshing"])", block));
  EXPECT_EQ(off.method, "implicit");
}

TEST_F(ArcsimTest, CriteriaOfTheFirstClothCountForAll) {
  const auto read = [this](const std::string& second) {
    return read_scene(put("conf/two.json", R"({"frame_time": 0.04, "end_frame": 3, "cloths": [
      {"mesh": "square.obj", "materials": [{"data": "paper.json"}, {"data": "paper.json"}],
       "remeshing": {"size": [0.1, 1], "refine_angle": 0.4, "aspect_min": 0.25}},
      {"mesh": "square.obj", "transform": {"translate": [0, 0, 1]},)" +
                                               second +
                                               R"("materials": [{"data": "paper.json"},
                                                                {"data": "paper.json"}]}]})"));
  };
  const auto warned = [](const Scene& scene, const char* text) {
    for (const std::string& warning : scene.warnings)
      if (warning.find(text) != std::string::npos) return true;
    return false;
  };
  const Scene same = read(R"("remeshing": {"size": [0.1, 1], "refine_angle": 0.4,
                                           "aspect_min": 0.25},)");
  EXPECT_FALSE(warned(same, "remeshing"));
  EXPECT_EQ(same.adaptive.remeshing.aspect_min, 0.25);
  const Scene other = read(R"("remeshing": {"size": [0.2, 1], "refine_angle": 0.3},)");
  EXPECT_TRUE(warned(other, "counts for all"));
  EXPECT_EQ(other.adaptive.remeshing.size_min, 0.1);
  EXPECT_TRUE(warned(read(""), "missing beside others"));
}

TEST_F(ArcsimTest, ResolvedAndConvertedScenesAreScenesOfWeft) {
  const fs::path path = scene(R"(, "frame_time": 0.04, "end_frame": 3,
    "obstacles": [{"mesh": "square.obj", "transform": {"translate": [0, 0, -1]}}])");
  const SceneFile first = read_scene_file(path);
  EXPECT_FALSE(is_arcsim_scene(first.resolved));
  EXPECT_EQ(read_scene_file(put("resolved.json", first.resolved.dump())).resolved, first.resolved);
  convert_arcsim(path, directory_ / "weft.json");
  const Scene converted = read_scene(directory_ / "weft.json");
  EXPECT_EQ(converted.time.frames, 3);
  EXPECT_EQ(converted.obstacles.at(0).friction, 0.3);
  EXPECT_THROW(convert_arcsim(directory_ / "weft.json", directory_ / "b.json"), SceneError);
}

TEST_F(ArcsimTest, MotionWithVelocities) {
  const Scene scene = read_scene(this->scene(R"(, "frame_time": 0.04, "end_time": 1, "motions": [[
      {"time": 0, "transform": {}}, {"time": 2, "transform": {"translate": [1, 0, 0]},
       "velocity": {"translate": [0, 0, 0]}}, {"time": 3, "transform": {"translate": [3, 0, 0]}}]],
    "obstacles": [{"mesh": "square.obj", "motion": 0,
                   "transform": {"translate": [0, 0, -1], "rotate": [180, 1, 0, 0]}}])"));
  const Motion& motion = scene.obstacles.at(0).motion;
  // at rest at the middle key, so it follows 3 s^2 - 2 s^3 before it
  for (const double t : {0.5, 1.0, 1.7}) {
    const double s = t / 2;
    EXPECT_NEAR(transform_at(motion, t).translate[0], 3 * s * s - 2 * s * s * s, 1e-3) << t;
  }
  const Vec3<double> corner = apply(transform_at(motion, 1), {0, 1, 0});
  EXPECT_NEAR(corner[1], -1, 1e-12);
  EXPECT_NEAR(corner[2], -1, 1e-12);
}

TEST_F(ArcsimTest, MotionCapture) {
  const fs::path path = put("a.mot",
                            "NumFrames: 2\nbody[0] position\n0 0 0\n1 0 0\n\nbody[0] "
                            "orientation\n1 0 0 0\n0.70710678118654757 0 0 0.70710678118654757\n");
  const auto motions = read_mot(path, 10, {{0, 0, 5}});
  ASSERT_EQ(motions.size(), 1u);
  ASSERT_EQ(motions[0].size(), 2u);
  EXPECT_EQ(motions[0][1].time, 0.1);
  const Vec3<double> x = apply(motions[0][1].transform, {1, 0, 0});
  EXPECT_NEAR(x[0], 1, 1e-12);
  EXPECT_NEAR(x[1], 1, 1e-12);
  EXPECT_NEAR(x[2], 5, 1e-12);
  EXPECT_THROW(read_mot(put("b.mot", "NumFrames: 99999999\nbody\n"), 10, {}), SceneError);
  EXPECT_THROW(read_mot(put("c.mot", "NumFrames: 1\nbody\n0 0 0\nbody\n0 0 0 0\n"), 10, {}),
               SceneError);
  EXPECT_THROW(read_mot(put("d.mot", "NumFrames: 1\nbody\n0 0\n"), 10, {}), SceneError);
}

TEST_F(ArcsimTest, RefusesInArcsimsOwnTerms) {
  const auto refusal = [&](const std::string& more) -> std::string {
    try {
      read_scene(scene(more));
      return "";
    } catch (const SceneError& error) {
      return error.what();
    }
  };
  const std::string time = R"(, "frame_time": 0.04, "end_time": 1)";
  EXPECT_NE(refusal(R"(, "frame_time": 0)").find("frame_time: "), std::string::npos);
  EXPECT_NE(refusal(time + R"(, "handles": [{"nodes": [4]}])").find("handles[0].nodes[0]: "),
            std::string::npos);
  EXPECT_NE(refusal(time + R"(, "handles": [{"label": 7}])").find("handles[0].label: "),
            std::string::npos);
  EXPECT_NE(refusal(time + R"(, "obstacles": [{"mesh": "no.obj"}])").find("obstacles[0].mesh: "),
            std::string::npos);
  EXPECT_NE(refusal(time + R"(, "obstacles": "no%s.obj")").find("obstacles: "), std::string::npos);
}

TEST_F(ArcsimTest, CirclesKeepTheirScaleAndTimes) {
  const Scene scene = read_scene(this->scene(R"(, "frame_time": 0.04, "end_time": 1,
    "magic": {"handle_stiffness": 1e6},
    "handles": [{"type": "circle", "label": 1, "circumference": 0.28, "u": [0, 1],
                 "center": [1, 2, 3], "axis0": [0, 0, 1], "axis1": [1, 0, 0],
                 "start_time": 0.1, "end_time": 0.5, "fade_time": 0.2}])"));
  ASSERT_EQ(scene.handles.size(), 1u);
  const Handle& handle = scene.handles[0];
  EXPECT_EQ(handle.shape, Handle::Shape::circle);
  EXPECT_EQ(handle.vertices, (std::vector<Index>{0, 2}));
  EXPECT_EQ(handle.circumference, 0.28);
  EXPECT_EQ(handle.direction[1], 1);
  EXPECT_EQ(handle.center[2], 3);
  // The axes stay directions: the radius comes from the circumference.
  EXPECT_EQ(handle.axis0[2], 1);
  EXPECT_EQ(handle.axis1[0], 1);
  EXPECT_EQ(handle.stiffness, 1e6);
  EXPECT_EQ(handle.start_time, 0.1);
  EXPECT_EQ(handle.end_time, 0.5);
  EXPECT_EQ(handle.fade_time, 0.2);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST_F(ArcsimTest, WarnsOnceOfEachKeyThatObstaclesAndMeshesDoNotGet) {
  put("ball.obj", "v 0 0 2\nv 1 0 2\nv 0 1 3\nf 1 2 3\n");
  put("square.obj",
      "v 0 0 0\nny 0 0 0\nnv 1 0 0\nv 1 0 0\nny 1 0 0.5\nv 1 1 0\nny 1 1 0.5\nv 0 1 0\n"
      "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
  const Scene scene = read_scene(this->scene(R"(, "frame_time": 0.04, "end_time": 1,
    "obstacles": [{"mesh": "ball.obj", "start_time": 0.5, "end_time": 2},
                  {"mesh": "ball.obj", "start_time": 0.5, "end_time": 3}])"));
  const auto lines = [&](const char* word) {
    std::ptrdiff_t count = 0;
    for (const std::string& line : scene.warnings) count += line.find(word) != std::string::npos;
    return count;
  };
  EXPECT_EQ(scene.warnings.size(), 4u);
  EXPECT_EQ(lines("obstacles[].start_time: "), 1);
  EXPECT_EQ(lines("obstacles[].end_time: "), 1);
  EXPECT_EQ(lines("(nv)"), 1);
  EXPECT_EQ(lines("(ny)"), 1);
}

TEST_F(ArcsimTest, BundledScenesLoad) {
  const char* data = std::getenv("WEFT_TEST_DATA");
  const fs::path folder = data ? fs::path(data) / "arcsim" / "conf" : fs::path();
  if (!data || !fs::exists(folder)) GTEST_SKIP() << "WEFT_TEST_DATA holds no arcsim/conf";
  for (const char* name : {"sphere", "flag", "cylinder", "square", "dress-blue"})
    EXPECT_NO_THROW(read_scene(folder / (std::string(name) + ".json"))) << name;
  EXPECT_EQ(read_scene(folder / "dress-blue.json").obstacles.size(), 16u);
  EXPECT_EQ(read_scene(folder / "flag.json").time.frames, 500);
}

}  // namespace
}  // namespace weft::io
