#include "host/io/mesh/pc2_file.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "host/base/file_bytes.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using Pc2File = DirectoryTest;
using Points = std::vector<Vec3<double>>;

/// Points that single precision holds exactly, other ones for each frame.
Points points_of(int frame, std::size_t count = 5) {
  Points points(count);
  for (std::size_t v = 0; v < count; ++v)
    points[v] = {0.25 * frame, static_cast<double>(v), -static_cast<double>(v) / 1024};
  return points;
}

void expect_same(const Points& a, const Points& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t v = 0; v < a.size(); ++v) EXPECT_TRUE(a[v] == b[v]) << "point " << v;
}

void write_frames(const std::filesystem::path& path, int count, double start = 0) {
  PointCacheWriter writer(path, PointCacheHeader{5, start, 1, 0});
  for (int f = 0; f < count; ++f) writer.append(points_of(f));
}

std::string refusal(const std::filesystem::path& path) {
  try {
    PointCache(path).read_all();
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST_F(Pc2File, RoundTripIsExact) {
  write_frames(directory_ / "a.pc2", 4, 7);
  const PointCache cache(directory_ / "a.pc2");
  EXPECT_EQ(cache.point_count(), 5);
  EXPECT_EQ(cache.sample_count(), 4);
  EXPECT_EQ(cache.header().start_frame, 7);
  EXPECT_EQ(cache.header().sample_rate, 1);
  for (int f = 3; f >= 0; --f) expect_same(cache.read(f), points_of(f));
  EXPECT_EQ(cache.read_all().size(), 4u);
}

/// Byte for byte what other programs read.
TEST_F(Pc2File, BytesOfTheFormat) {
  PointCacheWriter writer(directory_ / "a.pc2", PointCacheHeader{1, 2, 0.5, 0});
  const Points points{{1, -2, 0.5}};
  writer.append(points);
  const std::string bytes = read_file_bytes(directory_ / "a.pc2");
  ASSERT_EQ(bytes.size(), 44u);
  EXPECT_EQ(bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
  const auto word = [&](std::size_t at) {
    std::int32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  };
  EXPECT_EQ(word(12), 1);           // version
  EXPECT_EQ(word(16), 1);           // points
  EXPECT_EQ(word(20), 0x40000000);  // 2.0f
  EXPECT_EQ(word(24), 0x3f000000);  // 0.5f
  EXPECT_EQ(word(28), 1);           // samples
  EXPECT_EQ(word(32), 0x3f800000);
  EXPECT_EQ(word(36), static_cast<std::int32_t>(0xc0000000));
  EXPECT_EQ(word(40), 0x3f000000);
}

TEST_F(Pc2File, GoesOnAfterAFrame) {
  write_frames(directory_ / "a.pc2", 6);
  {
    PointCacheWriter writer(directory_ / "a.pc2", 5, 2);
    EXPECT_EQ(PointCache(directory_ / "a.pc2").sample_count(), 2);
    writer.append(points_of(40));
  }
  const PointCache cache(directory_ / "a.pc2");
  ASSERT_EQ(cache.sample_count(), 3);
  expect_same(cache.read(1), points_of(1));
  expect_same(cache.read(2), points_of(40));
  EXPECT_EQ(std::filesystem::file_size(directory_ / "a.pc2"), 32u + 3 * 60);
  EXPECT_THROW(PointCacheWriter(directory_ / "a.pc2", 5, 4), SceneError);
  EXPECT_THROW(PointCacheWriter(directory_ / "a.pc2", 6, 2), SceneError);
  EXPECT_EQ(PointCache(directory_ / "a.pc2").sample_count(), 3) << "a refusal must change nothing";
}

/// A writer that is killed leaves the count of before and a part of a sample, or a whole one.
TEST_F(Pc2File, IgnoresWhatAKilledWriterLeaves) {
  write_frames(directory_ / "a.pc2", 3);
  const std::string good = read_file_bytes(directory_ / "a.pc2");
  for (const std::size_t extra : {std::size_t{1}, std::size_t{59}, std::size_t{60}}) {
    const auto path = put("b.pc2", good + std::string(extra, '\x7f'));
    EXPECT_EQ(PointCache(path).sample_count(), 3);
    PointCacheWriter(path, 5, 3).append(points_of(3));
    expect_same(PointCache(path).read(3), points_of(3));
    EXPECT_EQ(std::filesystem::file_size(path), 32u + 4 * 60);
  }
}

TEST_F(Pc2File, EveryShorterFileIsRefused) {
  write_frames(directory_ / "a.pc2", 3);
  const std::string good = read_file_bytes(directory_ / "a.pc2");
  EXPECT_EQ(refusal(directory_ / "a.pc2"), "");
  for (std::size_t n = 0; n < good.size(); ++n)
    EXPECT_NE(refusal(put("b.pc2", std::string_view(good).substr(0, n))), "") << n << " bytes";
}

TEST_F(Pc2File, NamesWhatIsWrong) {
  write_frames(directory_ / "a.pc2", 3);
  const std::string good = read_file_bytes(directory_ / "a.pc2");
  const auto with = [&](std::size_t at, std::int32_t value) {
    std::string bytes = good;
    std::memcpy(bytes.data() + at, &value, 4);
    return refusal(put("b.pc2", bytes));
  };
  EXPECT_NE(with(0, 0).find("header"), std::string::npos);
  EXPECT_NE(with(12, 2).find("version: 2"), std::string::npos);
  EXPECT_NE(with(16, 0).find("points: 0"), std::string::npos);
  EXPECT_NE(with(16, -5).find("points: -5"), std::string::npos);
  EXPECT_NE(with(16, 2'000'000'000).find("points: 2000000000"), std::string::npos);
  EXPECT_NE(with(16, 700'000'000).find("samples: 3 of 700000000"), std::string::npos);
  EXPECT_NE(with(20, 0x7fc00000).find("start frame: nan"), std::string::npos);
  EXPECT_NE(with(24, 0).find("sample rate: 0"), std::string::npos);
  EXPECT_NE(with(28, -1).find("samples: -1"), std::string::npos);
  EXPECT_NE(with(28, 4).find("at most 3"), std::string::npos);
  EXPECT_NE(with(32 + 60 + 12, 0x7f800000).find("sample 1 point 1: inf"), std::string::npos);
  EXPECT_NE(refusal(directory_ / "none.pc2").find("none.pc2: cannot read"), std::string::npos);
  EXPECT_NE(refusal(directory_).find("not a regular file"), std::string::npos);
  EXPECT_THROW(PointCache(directory_ / "a.pc2").read(3), SceneError);
  EXPECT_THROW(PointCache(directory_ / "a.pc2").read(-1), SceneError);
}

TEST_F(Pc2File, OriginStandsBesideIt) {
  const auto cache = directory_ / "a.b.pc2";
  EXPECT_EQ(cache_origin_file(cache), directory_ / "a.b.origin.json");
  EXPECT_EQ(read_cache_origin(cache), (Vec3<double>{0, 0, 0}));
  const Vec3<double> origin{300000.1, -0x1p20, 1e-300};
  write_cache_origin(cache, origin);
  EXPECT_EQ(read_cache_origin(cache), origin);
  write_cache_origin(cache, {0, 0, 0});
  EXPECT_FALSE(std::filesystem::exists(cache_origin_file(cache)));
  for (const char* wrong :
       {"", "[]", "{}", "{\"origin\": 3}", "{\"origin\": [1, 2]}", "{\"origin\": [1, 2, \"3\"]}",
        "{\"origin\": [1, 2, 1e300]}", "{\"origin\": {\"a\": 1, \"b\": 2, \"c\": 3}}"}) {
    put("a.b.origin.json", wrong);
    EXPECT_THROW(read_cache_origin(cache), SceneError) << wrong;
  }
}

TEST_F(Pc2File, RefusesAnotherTopology) {
  PointCacheWriter writer(directory_ / "a.pc2", PointCacheHeader{5, 0, 1, 0});
  writer.append(points_of(0));
  EXPECT_THROW(writer.append(points_of(1, 6)), SceneError);
  EXPECT_EQ(PointCache(directory_ / "a.pc2").sample_count(), 1);
}

TEST_F(Pc2File, DamageNeverCrashes) {
  write_frames(directory_ / "a.pc2", 3);
  const std::string good = read_file_bytes(directory_ / "a.pc2");
  std::mt19937 random(3);
  for (int round = 0; round < 1000; ++round) {
    std::string bytes = good;
    for (unsigned k = 0; k <= random() % 3; ++k) bytes[random() % 40] = static_cast<char>(random());
    refusal(put("b.pc2", bytes));
  }
}

}  // namespace
}  // namespace weft::io
