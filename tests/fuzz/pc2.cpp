#include "host/io/mesh/pc2_file.hpp"

#include <algorithm>
#include <cstddef>

#include "host/io/animation/mesh_sequence.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {
namespace {

using Samples = std::vector<std::vector<Vec3<double>>>;

void require_same_again(const io::PointCacheHeader& header, const Samples& samples) {
  const auto path = folder() / "again.pc2";
  io::PointCacheWriter writer(path, header);
  for (const auto& positions : samples) writer.append(positions);
  const io::PointCache again(path);
  require(again.point_count() == header.point_count &&
              again.sample_count() == header.sample_count &&
              again.header().start_frame == header.start_frame &&
              again.header().sample_rate == header.sample_rate && again.read_all() == samples,
          "the cache is another once it is written and read");
}

}  // namespace

void pc2(std::string_view input) {
  const auto path = put("input.pc2", input);
  accepted([&] {
    const io::PointCache cache(path);
    require_same_again(cache.header(), cache.read_all());
    return true;
  });
  put("input.obj", square_obj);
  accepted([&] {
    const auto sequence = io::open_sequence(path);
    for (std::size_t k = 0; k < sequence->frames().size(); ++k)
      for (const io::NamedMesh& named : sequence->read(k).cloths) require_whole(named.mesh);
    return true;
  });
}

}  // namespace weft::fuzz
