// Cameras and sizes that the program must refuse, and what a run with a view leaves behind.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

/// The small scene by the method "view", with a camera beside it.
class ViewProgram : public Process {
 protected:
  void SetUp() override {
    Process::SetUp();
    Json scene = Json::parse(small_scene);
    scene["method"]["type"] = "view";
    scene["camera"]["keys"] = {{{"position", {0, -1, 0.5}}, {"look_at", {0, 0, 0.1}}}};
    write("view.json", scene.dump());
  }

  /// Runs with an override and expects one line of errors.
  void expect_refused(const std::string& override, const std::string& words) {
    EXPECT_EQ(weft({"run", "view.json", "-o", "out", "--no-preview", "--set", override}), 2)
        << override << '\n'
        << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find("view.json: " + words), std::string::npos) << err_;
    EXPECT_FALSE(fs::exists(at("out/frames"))) << override;
  }
};

TEST_F(ViewProgram, BadCamerasAndSizesGetOneLine) {
  expect_refused(R"(camera.keys=[{"position": [0, 0, 0.05], "look_at": [0, 1, 0]}])",
                 "camera.keys: inside obstacles[0] (ball) at 0 s");
  expect_refused("camera.keys.0.field_of_view=0", "camera.keys[0].field_of_view: 0");
  expect_refused("remeshing.size=[0.2, 0.1]", "remeshing.size: [0.2,0.1]");
  expect_refused(R"(camera.keys=[{"time": 0, "position": [0, -1, 0.5], "look_at": [0, 0, 0]},
                                 {"time": 0.1, "position": [0, -2, 0.5], "look_at": [0, 0, 0]}])",
                 "camera.keys: a track that ends at 0.1 s");
}

TEST_F(ViewProgram, FramesAreCleanAndTheReportTellsOfRemeshing) {
  for (const std::string method : {"view", "adaptive"}) {
    ASSERT_EQ(weft({"run", "view.json", "-o", method, "--no-preview", "--method", method}), 0)
        << err_;
    EXPECT_EQ(weft({"check", method}), 0) << out_ << err_;
    EXPECT_NE(text_of(at(method + "/steps.jsonl")).find("\"remesh\""), std::string::npos);
  }
}

}  // namespace
}  // namespace weft::test
