#pragma once

#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/io/animation/mesh_sequence.hpp"
#include "tests/golden/process.hpp"

namespace weft::test {

/// Tests in which another program reads what `weft run` wrote, and writes down where the vertices
/// are: a line each with frame, name of the mesh, x, y, z.
class RoundTrip : public Process {
 protected:
  /// Positions by frame and name.
  using Positions = std::map<std::pair<int, std::string>, std::vector<Vec3<double>>>;

  static inline const std::vector<int> frames{0, 1, 3, 6};

  /// Runs a command; what it says goes to the file "log".
  /// @return its exit code, or -1
  int call(const std::string& command) const {
    const int status = std::system((command + " >'" + at("log").string() + "' 2>&1").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  static std::string frame_arguments() {
    std::string arguments;
    for (const int frame : frames) arguments += " " + std::to_string(frame);
    return arguments;
  }

  /// What the other program wrote into the file "positions".
  Positions found() const {
    Positions positions;
    std::ifstream stream(at("positions"));
    int frame = 0;
    std::string name;
    Vec3<double> x{};
    while (stream >> frame >> name >> x[0] >> x[1] >> x[2]) positions[{frame, name}].push_back(x);
    return positions;
  }

  /// Contents of the files of a run, as weft itself reads them.
  io::FrameMeshes expected(const std::string& run, int frame) const {
    return io::open_sequence(at(run))->read(static_cast<std::size_t>(frame));
  }

  /// In single precision, in which the files are written: nothing is rounded.
  static void expect_same(const std::vector<Vec3<double>>& other,
                          const std::vector<Vec3<double>>& weft) {
    ASSERT_EQ(other.size(), weft.size());
    for (std::size_t v = 0; v < weft.size(); ++v)
      for (int k = 0; k < 3; ++k)
        ASSERT_EQ(static_cast<float>(other[v][k]), static_cast<float>(weft[v][k]))
            << "vertex " << v;
  }
};

}  // namespace weft::test
