#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "host/base/scratch_folder.hpp"
#include "host/implicit/contact/swept_mesh.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "tests/unit/collide/brute_force.hpp"
#include "weft/devices.hpp"

namespace weft {
namespace {

namespace fs = std::filesystem;

struct FramePair {
  const char* name;
  const char* from;
  const char* to;
  std::int64_t face_pairs, edge_pairs;  ///< by independent brute force
};

/// Frames of published simulations.
class Frames : public testing::TestWithParam<FramePair> {
 protected:
  void SetUp() override {
    const char* data = std::getenv("WEFT_TEST_DATA");
    source_ = fs::path(data ? data : "") / "ccd" / "frames";
    if (!data || !fs::exists(source_ / (std::string(GetParam().from) + ".ply.xz")))
      GTEST_SKIP() << "WEFT_TEST_DATA holds no ccd/frames";
  }

  Mesh read(const char* frame) const {
    const fs::path plain = scratch_ / (std::string(frame) + ".ply");
    const std::string command = "xz -dc '" + (source_ / (std::string(frame) + ".ply.xz")).string() +
                                "' > '" + plain.string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return io::read_mesh(plain, io::Uv::ignore);
  }
  SweptMesh mesh() const {
    const Mesh from = read(GetParam().from);
    return make_swept_mesh(from.positions, read(GetParam().to).positions, from.triangles);
  }

 private:
  fs::path source_;
  const ScratchFolder scratch_;
};

TEST_P(Frames, ExactInDoubleAndNothingLessInFloat) {
  const SweptMesh swept = mesh();
  DeviceSet devices = host_devices(2);
  SweptSearch<double> exact(devices, swept, 0);
  exact.run();
  EXPECT_EQ(exact.face_pair_count(), GetParam().face_pairs);
  EXPECT_EQ(exact.edge_pair_count(), GetParam().edge_pairs);
  SweptSearch<float> rounded(devices, swept, 0);
  rounded.run();
  const auto expect_includes = [](const test::Pairs& all, const test::Pairs& some) {
    EXPECT_TRUE(std::includes(all.begin(), all.end(), some.begin(), some.end()));
    EXPECT_LT(static_cast<double>(all.size()), 1.01 * static_cast<double>(some.size()));
  };
  expect_includes(test::numbers_of(rounded.face_pairs()), test::numbers_of(exact.face_pairs()));
  expect_includes(test::numbers_of(rounded.edge_pairs()), test::numbers_of(exact.edge_pairs()));
}

INSTANTIATE_TEST_SUITE_P(
    Published, Frames,
    testing::Values(FramePair{"cloth_ball", "cloth_ball92", "cloth_ball93", 1655541, 5197332},
                    FramePair{"armadillo", "326", "327", 2031902, 5068080},
                    FramePair{"cloth_funnel", "227", "228", 7319, 33770}),
    [](const testing::TestParamInfo<FramePair>& frames) { return frames.param.name; });

}  // namespace
}  // namespace weft
