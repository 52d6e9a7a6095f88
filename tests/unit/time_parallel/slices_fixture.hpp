#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host/base/scratch_folder.hpp"
#include "host/time_parallel/slice_run.hpp"
#include "host/time_parallel/slices.hpp"
#include "weft/devices.hpp"

namespace weft::test {

/// Runs in slices, each in a directory of a name.
class SlicesFixture : public ::testing::Test {
 protected:
  SliceOptions options(const std::string& name, int workers) const {
    SliceOptions o;
    o.run = directory_ / name;
    o.workers = workers;
    o.devices = [](int) { return host_devices(1); };
    return o;
  }
  static std::string bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// Checkpoints at the starts and ends of all slices, one after the other.
  std::string states(const std::string& name, int slices) const {
    std::string all;
    for (int j = 0; j < slices; ++j) {
      all += bytes(SliceFiles(directory_ / name, j).start());
      const std::string end = bytes(SliceFiles(directory_ / name, j).end());
      EXPECT_FALSE(end.empty()) << "slice " << j;
      all += end;
    }
    return all;
  }

  const ScratchFolder folder_;
  const std::filesystem::path directory_ = folder_.path();
};

}  // namespace weft::test
