#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/base/file_descriptor.hpp"
#include "weft/core/span.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// What the header of a point cache says. Sample k is of frame start_frame + k * sample_rate.
struct PointCacheHeader {
  Index point_count = 0;
  double start_frame = 0;
  double sample_rate = 1;  ///< frames a sample, > 0
  Index sample_count = 0;
};

/// The format has no place for an origin, so a file beside the cache holds it: NAME.origin.json for
/// NAME.pc2, with the world place that cache and mesh are relative to, {"origin": [x, y, z]}. There
/// is none if that is (0, 0, 0).
std::filesystem::path cache_origin_file(const std::filesystem::path& cache);

/// Writes that file, or removes what an earlier run has left under its name.
/// @throws SceneError if it cannot be written
void write_cache_origin(const std::filesystem::path& cache, const Vec3<double>& origin);

/// @return [m] (0, 0, 0) if there is no such file
/// @throws SceneError if it holds something else
Vec3<double> read_cache_origin(const std::filesystem::path& cache);

/// Reads a point cache (.pc2): positions of one mesh over time, in single precision, little endian.
/// Samples are read on request. Bytes after the last sample that the header announces are ignored:
/// a writer that was killed leaves them. Safe to use from several threads at once.
class PointCache {
 public:
  /// @throws SceneError if the file is missing, no point cache, or shorter than its header says
  explicit PointCache(const std::filesystem::path& path);

  const PointCacheHeader& header() const { return header_; }
  Index point_count() const { return header_.point_count; }
  Index sample_count() const { return header_.sample_count; }
  const std::filesystem::path& path() const { return path_; }

  /// @param out [points] [m]
  /// @throws SceneError if there is no such sample, it cannot be read, or a number is not finite
  /// @pre out.size() is the point count
  void read(Index sample, Span<Vec3<double>> out) const;
  std::vector<Vec3<double>> read(Index sample) const;

  /// Every sample.
  /// @return [samples][points] [m]
  /// @throws SceneError like read()
  std::vector<std::vector<Vec3<double>>> read_all() const;

 private:
  std::filesystem::path path_;
  FileDescriptor file_;
  PointCacheHeader header_;
};

/// Writes a point cache, sample by sample. The number of samples in the header grows after the
/// sample is there, so that a file whose writer was killed is a valid, shorter one.
class PointCacheWriter {
 public:
  /// Makes a new file; one that is there is replaced.
  /// @param header its sample count is ignored
  /// @throws SceneError if the file cannot be written, or a value of the header is out of range
  PointCacheWriter(const std::filesystem::path& path, const PointCacheHeader& header);

  /// Goes on with a file that is there, after its first `kept` samples; later ones are cut off.
  /// @throws SceneError if it is no point cache of `point_count` points, or has fewer samples
  PointCacheWriter(const std::filesystem::path& path, Index point_count, Index kept);

  /// @param positions [points] [m]; rounded to single precision
  /// @throws SceneError if the number of points is another, or the sample cannot be written
  void append(const std::vector<Vec3<double>>& positions);

  /// Waits until all samples are on the disk.
  /// @throws SceneError if that fails
  void sync() const;

  const PointCacheHeader& header() const { return header_; }

 private:
  void write_at(std::uint64_t offset, const void* bytes, std::size_t size) const;

  std::filesystem::path path_;
  FileDescriptor file_;
  PointCacheHeader header_;
  std::vector<float> sample_;  ///< kept for its memory
};

}  // namespace weft::io
