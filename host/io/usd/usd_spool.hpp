#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "weft/scene.hpp"

/// A USD text file holds all frames of an attribute in one place, so it cannot grow frame by frame.
/// Frames therefore go to a spool beside it, a binary file that is only ever appended to, and
/// write_usd() turns that into the USD file when there is need of it. A spool whose writer was
/// killed holds all frames up to the last whole one.
namespace weft::io {

/// What a mesh is called in all frames.
struct UsdMesh {
  std::string name;
  bool obstacle = false;
};

/// One mesh in one frame, as it stands in a spool.
struct SpoolBlock {
  std::uint64_t offset = 0;  ///< of the payload in the file
  std::uint64_t checksum = 0;
  Index points = 0;
  Index triangles = 0;  ///< this and the next two: 0 if the topology is that of the frame before
  Index material = 0;
  Index material_triangles = 0;
  std::uint32_t topology_from = 0;  ///< frame, by its place, whose topology it has
  std::uint32_t points_from = 0;    ///< frame, by its place, whose points it has
};

/// Reads a spool; knows where every block is. Safe to use from several threads at once.
class SpoolReader {
 public:
  /// @throws SceneError if it is no spool; a part of a frame at its end is left out
  explicit SpoolReader(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  double frame_rate() const { return frame_rate_; }  ///< [1/s]
  const std::vector<UsdMesh>& meshes() const { return meshes_; }
  /// [m] world place that the points are relative to
  const Vec3<double>& origin() const { return origin_; }
  /// Numbers of the frames, increasing.
  const std::vector<int>& frames() const { return frames_; }
  /// [bytes] of the whole frames among the first `count`, from the start of the file
  std::uint64_t bytes_of(std::size_t count) const { return ends_[count]; }

  const SpoolBlock& block(std::size_t frame, std::size_t mesh) const {
    return blocks_[frame * meshes_.size() + mesh];
  }

  /// @param frame place among frames()
  /// @param mesh  place among meshes()
  /// @throws SceneError if the block is damaged
  Mesh read(std::size_t frame, std::size_t mesh) const;

 private:
  void read_header();
  void read_index();
  std::string payload(const SpoolBlock& block, std::uint64_t size) const;

  std::filesystem::path path_;
  FileDescriptor file_;
  std::uint64_t size_ = 0;  ///< [bytes] of the file
  double frame_rate_ = 0;
  Vec3<double> origin_{0, 0, 0};
  std::vector<UsdMesh> meshes_;
  std::vector<int> frames_;
  std::vector<std::uint64_t> ends_;  ///< [frames + 1] ends_[0]: of the header
  std::vector<SpoolBlock> blocks_;   ///< [frames][meshes]
};

/// Writes a spool, frame by frame, in single precision, as USD has it.
class SpoolWriter {
 public:
  /// Makes a new spool; one that is there is replaced.
  /// @param origin [m] world place that the points are relative to
  /// @throws SceneError if it cannot be written
  SpoolWriter(const std::filesystem::path& path, double frame_rate, std::vector<UsdMesh> meshes,
              const Vec3<double>& origin = {0, 0, 0});

  /// Goes on with a spool that is there after its last whole frame; those whose number is larger
  /// than `last_frame` are cut off.
  /// @throws SceneError if it is no spool, or cannot be written
  SpoolWriter(const std::filesystem::path& path, int last_frame);

  /// Meshes that do not change against the frame before take no room.
  /// @param frame  number, larger than that of the frame before
  /// @param meshes in the order that the spool was made with
  /// @throws SceneError if the number of meshes or the frame is another, or it cannot be written
  void append(int frame, const std::vector<const Mesh*>& meshes);

  /// Waits until all frames are on the disk.
  /// @throws SceneError if that fails
  void sync() const;

  int last_frame() const { return last_frame_; }  ///< -1: none

 private:
  /// What the frame before held of a mesh.
  struct Last {
    std::vector<Tri> triangles;
    std::vector<Tri> material_triangles;
    std::vector<Vec2<float>> material;
    std::vector<Vec3<float>> points;
  };
  void add_block(std::string& bytes, int frame, std::size_t mesh, const Mesh& content);

  std::filesystem::path path_;
  FileDescriptor file_;
  std::vector<UsdMesh> meshes_;
  std::vector<Last> last_;
  int last_frame_ = -1;
};

}  // namespace weft::io
