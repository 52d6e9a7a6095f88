#include <algorithm>
#include <cstddef>
#include <cstring>

#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/gltf/glb_file.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/spool/frame_spool.hpp"
#include "host/io/usd/usd_file.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {
namespace {

constexpr std::size_t max_frames = 8;

void read(const std::filesystem::path& path) {
  accepted([&] {
    const auto sequence = io::open_sequence(path);
    for (std::size_t k = 0; k < std::min(max_frames, sequence->frames().size()); ++k) {
      const io::FrameMeshes frame = sequence->read(k);
      for (const auto* meshes : {&frame.cloths, &frame.obstacles})
        for (const io::NamedMesh& named : *meshes) require_whole(named.mesh);
      io::format_obj(frame.cloths);
      io::format_ply(frame.cloths, Precision::single_precision, io::Normals::vertex);
    }
    return true;
  });
}

/// Gives each block the checksum of its contents, as far as the file can be walked.
std::string with_checksums(const std::filesystem::path& path, std::string bytes) {
  accepted([&] {
    const io::SpoolReader reader(path);
    const auto& frames = reader.frames();
    for (std::size_t k = 0; k < frames.size(); ++k)
      for (std::size_t m = 0; m < reader.meshes().size(); ++m) {
        const io::SpoolBlock& block = reader.block(k, m);
        // The next block's payload begins after its own head of 40 bytes.
        const std::size_t end = m + 1 < reader.meshes().size() ? reader.block(k, m + 1).offset - 40
                                                               : reader.bytes_of(k + 1);
        const std::uint64_t sum =
            checksum_of(std::string_view(bytes).substr(block.offset, end - block.offset));
        std::memcpy(bytes.data() + block.offset - sizeof sum, &sum, sizeof sum);
      }
    return true;
  });
  return bytes;
}

}  // namespace

void spool(std::string_view input) {
  const auto path = put("input.usda.spool", input);
  read(path);
  put("input.usda.spool", with_checksums(path, std::string(input)));
  read(path);
  accepted([&] {
    io::write_usd(folder() / "again.usda", io::SpoolReader(path));
    return true;
  });
  accepted([&] {
    io::write_glb(folder() / "again.glb", io::SpoolReader(path));
    return true;
  });
  accepted([&] {
    io::SpoolWriter writer(path, 2);
    io::SpoolReader again(path);
    require(again.frames().empty() || again.frames().back() <= 2, "frames that were cut off");
    return true;
  });
}

}  // namespace weft::fuzz
