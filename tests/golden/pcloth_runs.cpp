// The scenes that the runner of P-Cloth's benchmarks writes are ones that weft runs.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class PclothRuns : public Process {
 protected:
  /// Writes the scene of each benchmark, with few triangles, as NAME.json into directory_/scenes.
  int write_scenes() const {
    const std::string command = "cd '" + directory_.string() + "' && mkdir scenes && PYTHONPATH='" +
                                WEFT_SOURCE_DIR + "/benchmarks/support' '" + WEFT_PYTHON +
                                "' -B -c 'import json, pcloth_runs as p\n"
                                "for n in p.PAPER: json.dump(p.scene(n, 500, p.TAKE), "
                                "open(f\"scenes/{n}.json\", \"w\"))'";
    return std::system(command.c_str());
  }
};

TEST_F(PclothRuns, WriteScenesThatRun) {
  ASSERT_EQ(write_scenes(), 0);
  int garments = 0, ran = 0;
  for (const auto& entry : fs::directory_iterator(at("scenes"))) {
    const Json scene = Json::parse(text_of(entry.path()));
    const Json& obstacles = scene.value("obstacles", Json::array());
    const bool captured = !obstacles.empty() && obstacles[0].contains("capture");
    garments += captured ? 1 : 0;
    if (captured && !fs::exists(obstacles[0]["capture"]["file"].get<std::string>())) continue;
    EXPECT_EQ(weft({"run", entry.path(), "--no-preview", "--device", "cpu:1", "--frames", "1",
                    "--output", at(entry.path().stem().string())}),
              0)
        << entry.path() << ": " << err_;
    ++ran;
  }
  EXPECT_EQ(garments, 6);
  if (ran < 11) GTEST_SKIP() << "NOT TESTED: no Boxing_Toes.bvh; install assimp-testmodels";
}

}  // namespace
}  // namespace weft::test
