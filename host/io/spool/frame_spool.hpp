#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "weft/scene.hpp"

/// Files that hold all frames of an attribute in one place cannot grow frame by frame: USD text and
/// glTF. Frames therefore go to a spool beside them, a binary file that is only ever appended to;
/// write_usd() and write_glb() turn it into what other programs read. A spool whose writer was
/// killed holds all frames up to the last whole one.
namespace weft::io {

/// Values as a spool has them.
template <int N>
std::vector<Vec<float, N>> in_single(const std::vector<Vec<double, N>>& values) {
  std::vector<Vec<float, N>> result;
  result.reserve(values.size());
  for (const auto& x : values) result.push_back(vec_cast<float>(x));
  return result;
}

/// Name and labels of a mesh, the same in all frames.
struct SpooledMesh {
  std::string name;
  bool obstacle = false;
  std::vector<std::string> group_names{};  ///< as in Mesh
  std::vector<std::string> part_names{};
  std::vector<std::string> part_labels{};  ///< as in Mesh
};

/// The meshes of a spool that begins with this frame.
std::vector<SpooledMesh> spooled_meshes(const FrameMeshes& first);

/// One mesh in one frame, as it stands in a spool.
struct SpoolBlock {
  std::uint64_t offset = 0;  ///< of the payload in the file
  std::uint64_t checksum = 0;
  Index points = 0;
  Index triangles = 0;  ///< this and the next two: 0 if the topology is that of the frame before
  Index material = 0;
  Index material_triangles = 0;
  bool grouped = false;             ///< triangles have groups
  bool parted = false;              ///< triangles have parts
  bool velocities = false;          ///< beside the points
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
  const std::vector<SpooledMesh>& meshes() const { return meshes_; }
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

  /// @return [vertices] [m/s] empty: not known
  /// @throws SceneError if the block is damaged
  std::vector<Vec3<double>> velocities(std::size_t frame, std::size_t mesh) const;

 private:
  void read_header();
  void read_index();
  std::string payload(const SpoolBlock& block) const;

  std::filesystem::path path_;
  FileDescriptor file_;
  std::uint64_t size_ = 0;  ///< [bytes] of the file
  double frame_rate_ = 0;
  Vec3<double> origin_{0, 0, 0};
  std::vector<SpooledMesh> meshes_;
  std::vector<int> frames_;
  std::vector<std::uint64_t> ends_;  ///< [frames + 1] ends_[0]: of the header
  std::vector<SpoolBlock> blocks_;   ///< [frames][meshes]
};

/// Writes a spool, frame by frame, in single precision, as the formats made of it have it.
class SpoolWriter {
 public:
  /// Makes a new spool; one that is there is replaced.
  /// @param origin [m] world place that the points are relative to
  /// @throws SceneError if it cannot be written
  SpoolWriter(const std::filesystem::path& path, double frame_rate, std::vector<SpooledMesh> meshes,
              const Vec3<double>& origin = {0, 0, 0});

  /// Goes on with a spool that is there after its last whole frame; those whose number is larger
  /// than `last_frame` are cut off.
  /// @throws SceneError if it is no spool, or cannot be written
  SpoolWriter(const std::filesystem::path& path, int last_frame);

  /// Meshes that do not change against the frame before take no room.
  /// @param frame  number, larger than that of the frame before
  /// @param meshes in the order that the spool was made with
  /// @param velocities [meshes][vertices] [m/s] of those for which they are known; may be shorter
  /// @throws SceneError if the number of meshes or the frame is another, or it cannot be written
  void append(int frame, const std::vector<const Mesh*>& meshes,
              const std::vector<std::vector<Vec3<double>>>& velocities = {});
  /// The same for the cloths, then the obstacles of a frame.
  void append(int frame, const FrameMeshes& meshes);

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
    std::vector<Index> group;
    std::vector<Index> part;
    std::vector<Vec3<float>> points;
    std::vector<Vec3<float>> velocities;
  };
  void add_block(std::string& bytes, int frame, std::size_t mesh, const Mesh& content,
                 const std::vector<Vec3<double>>& velocities);

  std::filesystem::path path_;
  FileDescriptor file_;
  std::vector<SpooledMesh> meshes_;
  std::vector<Last> last_;
  int last_frame_ = -1;
};

}  // namespace weft::io
