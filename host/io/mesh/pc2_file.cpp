#include "host/io/mesh/pc2_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/counted.hpp"
#include "host/input/quantity.hpp"
#include "weft/core/assert.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little);

constexpr char magic[12] = {'P', 'O', 'I', 'N', 'T', 'C', 'A', 'C', 'H', 'E', '2', '\0'};

/// As it stands at the start of a file.
struct RawHeader {
  char magic[12];
  std::int32_t version;
  std::int32_t point_count;
  float start_frame;
  float sample_rate;
  std::int32_t sample_count;
};
static_assert(sizeof(RawHeader) == 32);
constexpr std::uint64_t count_offset = offsetof(RawHeader, sample_count);
constexpr std::size_t point_bytes = 3 * sizeof(float);

std::uint64_t sample_offset(const PointCacheHeader& header, Index sample) {
  return sizeof(RawHeader) + static_cast<std::uint64_t>(sample) *
                                 static_cast<std::uint64_t>(header.point_count) * point_bytes;
}

std::string number_text(double value) {
  return std::isnan(value) ? "nan" : std::isinf(value) ? "inf" : std::to_string(value);
}

void check_values(const fs::path& path, const PointCacheHeader& header) {
  if (header.point_count < 1 || header.point_count > std::numeric_limits<Index>::max() / 3)
    throw SceneError(path.string(), "points", std::to_string(header.point_count), "1 to 715827882");
  if (header.sample_count < 0)
    throw SceneError(path.string(), "samples", std::to_string(header.sample_count), "0 or more");
  if (!std::isfinite(header.start_frame))
    throw SceneError(path.string(), "start frame", number_text(header.start_frame),
                     "a finite number");
  if (!std::isfinite(header.sample_rate) || !(header.sample_rate > 0))
    throw SceneError(path.string(), "sample rate", number_text(header.sample_rate),
                     "frames a sample, a finite number > 0");
}

PointCacheHeader read_header(const fs::path& path, int file) {
  RawHeader raw = {};
  const std::size_t size = read_at(path, file, 0, &raw, sizeof raw);
  if (size < sizeof raw || std::memcmp(raw.magic, magic, sizeof magic) != 0)
    throw SceneError(path.string(), "header", std::to_string(size) + " bytes of something else",
                     "the 32 bytes of a point cache, which start with POINTCACHE2");
  if (raw.version != 1)
    throw SceneError(path.string(), "version", std::to_string(raw.version), "1");
  PointCacheHeader header{raw.point_count, static_cast<double>(raw.start_frame),
                          static_cast<double>(raw.sample_rate), raw.sample_count};
  check_values(path, header);
  struct stat status = {};
  if (::fstat(file, &status) != 0) fail_on(path, "read");
  const auto bytes = static_cast<std::uint64_t>(status.st_size);
  const std::uint64_t present = (bytes - std::min<std::uint64_t>(bytes, sizeof raw)) /
                                (static_cast<std::uint64_t>(header.point_count) * point_bytes);
  if (static_cast<std::uint64_t>(header.sample_count) > present)
    throw SceneError(
        path.string(), "samples",
        std::to_string(header.sample_count) + " of " + counted(header.point_count, "point"),
        "at most " + std::to_string(present) + ", which is what the file holds");
  return header;
}

}  // namespace

// --------------------------------------------------------------------------------------- reading
fs::path cache_origin_file(const fs::path& cache) {
  return fs::path(cache).replace_extension(".origin.json");
}

void write_cache_origin(const fs::path& cache, const Vec3<double>& origin) {
  const fs::path file = cache_origin_file(cache);
  if (origin != Vec3<double>{0, 0, 0}) {
    const nlohmann::json json{{"origin", {origin[0], origin[1], origin[2]}}};
    return write_file_atomically(file, json.dump() + "\n");
  }
  remove_file(file);
}

Vec3<double> read_cache_origin(const fs::path& cache) {
  const fs::path file = cache_origin_file(cache);
  Vec3<double> origin{0, 0, 0};
  if (!is_there(file)) return origin;
  const auto refuse = [&] {
    throw SceneError(file.string(), "origin", "something else",
                     "[x, y, z], each " + quantity::coordinate.allowed());
  };
  const auto json = nlohmann::json::parse(read_file_bytes(file), nullptr, false);
  if (!json.is_object() || !json.contains("origin") || !json["origin"].is_array() ||
      json["origin"].size() != 3)
    refuse();
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& number = json["origin"][k];
    if (!number.is_number() || !quantity::coordinate.holds(number.get<double>())) refuse();
    origin[static_cast<int>(k)] = number.get<double>();
  }
  return origin;
}

PointCache::PointCache(const fs::path& path)
    : path_(path),
      file_(open_regular_file(path, O_RDONLY, "read")),
      header_(read_header(path, file_.number())) {}

void PointCache::read(Index sample, Span<Vec3<double>> out) const {
  WEFT_ASSERT(out.size() == static_cast<std::size_t>(header_.point_count));
  if (sample < 0 || sample >= header_.sample_count)
    throw SceneError(path_.string(), "sample", std::to_string(sample),
                     header_.sample_count == 0
                         ? "none, the file has no samples"
                         : "0 to " + std::to_string(header_.sample_count - 1));
  std::vector<float> raw(3 * out.size());
  const std::size_t size = raw.size() * sizeof(float);
  if (read_at(path_, file_.number(), sample_offset(header_, sample), raw.data(), size) != size)
    throw SceneError(path_.string(), "sample " + std::to_string(sample), "end of file",
                     counted(header_.point_count, "point"));
  for (std::size_t v = 0; v < out.size(); ++v)
    for (int k = 0; k < 3; ++k) {
      const float x = raw[3 * v + static_cast<std::size_t>(k)];
      if (!std::isfinite(x))
        throw SceneError(path_.string(),
                         "sample " + std::to_string(sample) + " point " + std::to_string(v),
                         std::isnan(x) ? "nan" : "inf", "a finite number");
      out[v][k] = static_cast<double>(x);
    }
}

std::vector<Vec3<double>> PointCache::read(Index sample) const {
  std::vector<Vec3<double>> positions(static_cast<std::size_t>(header_.point_count));
  read(sample, positions);
  return positions;
}

std::vector<std::vector<Vec3<double>>> PointCache::read_all() const {
  std::vector<std::vector<Vec3<double>>> samples;
  for (Index k = 0; k < header_.sample_count; ++k) samples.push_back(read(k));
  return samples;
}

// --------------------------------------------------------------------------------------- writing
PointCacheWriter::PointCacheWriter(const fs::path& path, const PointCacheHeader& header)
    : path_(path), header_(header) {
  header_.sample_count = 0;
  check_values(path, header_);
  file_ = open_regular_file(path, O_RDWR | O_CREAT, "open for writing");
  if (::ftruncate(file_.number(), 0) != 0) fail_on(path_, "write");
  RawHeader raw = {};
  std::memcpy(raw.magic, magic, sizeof magic);
  raw.version = 1;
  raw.point_count = header_.point_count;
  raw.start_frame = static_cast<float>(header_.start_frame);
  raw.sample_rate = static_cast<float>(header_.sample_rate);
  write_at(0, &raw, sizeof raw);
}

PointCacheWriter::PointCacheWriter(const fs::path& path, Index point_count, Index kept)
    : path_(path),
      file_(open_regular_file(path, O_RDWR, "open for writing")),
      header_(read_header(path, file_.number())) {
  if (header_.point_count != point_count)
    throw SceneError(path.string(), "points", std::to_string(header_.point_count),
                     std::to_string(point_count) + ", as the mesh has");
  if (kept < 0 || kept > header_.sample_count)
    throw SceneError(path.string(), "samples", std::to_string(header_.sample_count),
                     "at least " + std::to_string(kept) + ", to go on from there");
  header_.sample_count = kept;
  // The count first: it must never be larger than what is there.
  write_at(count_offset, &header_.sample_count, sizeof header_.sample_count);
  if (::ftruncate(file_.number(), static_cast<off_t>(sample_offset(header_, kept))) != 0)
    fail_on(path_, "write");
}

void PointCacheWriter::append(const std::vector<Vec3<double>>& positions) {
  if (positions.size() != static_cast<std::size_t>(header_.point_count))
    throw SceneError(path_.string(), "points", std::to_string(positions.size()),
                     std::to_string(header_.point_count) +
                         "; a point cache cannot change its topology, formats usda, obj and ply "
                         "can");
  sample_.resize(3 * positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v)
    for (int k = 0; k < 3; ++k)
      sample_[3 * v + static_cast<std::size_t>(k)] = static_cast<float>(positions[v][k]);
  write_at(sample_offset(header_, header_.sample_count), sample_.data(),
           sample_.size() * sizeof(float));
  ++header_.sample_count;
  write_at(count_offset, &header_.sample_count, sizeof header_.sample_count);
}

void PointCacheWriter::sync() const {
  if (::fsync(file_.number()) != 0) fail_on(path_, "fsync");
}

void PointCacheWriter::write_at(std::uint64_t offset, const void* bytes, std::size_t size) const {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t n = ::pwrite(file_.number(), static_cast<const char*>(bytes) + done, size - done,
                               static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_on(path_, "write");
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace weft::io
