#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "weft/core/vec.hpp"

// Queries of continuous collision detection whose answer is known: read from files of records, or
// made. A record has 208 bytes, little-endian: u8 type (0 vertex-face, 1 edge-edge), u8 truth, u8
// number of the file that it is from, 5 bytes of padding, f64 time of impact (NaN if there is
// none), f64[8][3]: the four corners at time 0, then at time 1.

namespace weft::bench {

struct CcdQuery {
  bool edges;  ///< edge-edge (a0 a1 b0 b1) or vertex-face (v f0 f1 f2)
  bool truth;  ///< whether they touch at a time in [0, 1]
  int file;    ///< that it is from, as the data set numbers its files
  double toi;  ///< first time at which they touch; NaN if there is none
  Vec3<double> x_t0[4], x_t1[4];
};

inline constexpr std::size_t ccd_record_bytes = 208;

/// @param bytes [208]
inline CcdQuery parse_ccd_record(const char* bytes) {
  static_assert(std::endian::native == std::endian::little, "records are little-endian");
  CcdQuery q{};
  q.edges = bytes[0] != 0;
  q.truth = bytes[1] != 0;
  q.file = static_cast<unsigned char>(bytes[2]);
  double numbers[25];
  std::memcpy(numbers, bytes + 8, sizeof numbers);
  q.toi = numbers[0];
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t c = 0; c < 3; ++c) {
      q.x_t0[j][static_cast<int>(c)] = numbers[1 + 3 * j + c];
      q.x_t1[j][static_cast<int>(c)] = numbers[13 + 3 * j + c];
    }
  return q;
}

/// Primitives that shift without turning, to touch at a known time or to stay on two sides of a
/// plane: with small integers and powers of two all coordinates are exact, and so is the truth.
/// @param seed the same seed makes the same queries
inline std::vector<CcdQuery> make_ccd_queries(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto integer = [&](int lo, int hi) {
    return lo + static_cast<int>(engine() % static_cast<std::uint64_t>(hi - lo + 1));
  };
  const auto point = [&](int size) {
    const int x = integer(-size, size), y = integer(-size, size), z = integer(-size, size);
    return Vec3<double>{double(x), double(y), double(z)};
  };
  std::vector<CcdQuery> queries;
  while (queries.size() < count) {
    CcdQuery q{};
    q.edges = integer(0, 1) != 0;
    q.truth = integer(0, 1) != 0;
    // Weights of the touching points, in sixteenths.
    const int s = integer(1, 14), t = integer(1, 15 - s), b = integer(1, 15);
    Vec3<double> x[4];
    for (auto& corner : x) corner = point(1 << 10);
    const Vec3<double> on_second =
        q.edges ? x[2] * ((16 - b) / 16.0) + x[3] * (b / 16.0)
                : x[1] * ((16 - s - t) / 16.0) + x[2] * (s / 16.0) + x[3] * (t / 16.0);
    if (q.edges) {
      const Vec3<double> half = point(1 << 9);
      x[0] = on_second - half;
      x[1] = on_second + half;
    } else {
      x[0] = on_second;
    }
    const Vec3<double> n =
        q.edges ? cross(x[1] - x[0], x[3] - x[2]) : cross(x[2] - x[1], x[3] - x[1]);
    Vec3<double> v = point(1 << 9) * 64;
    if (dot(n, v) == 0) continue;
    const double at = integer(1, 63) / 64.0;
    if (q.truth) {
      q.toi = at;
    } else {
      // The whole motion stays on one side of the plane of z = 0, the rest below.
      q.toi = std::numeric_limits<double>::quiet_NaN();
      v[2] = 0;
    }
    const Vec3<double> common = point(1 << 9) * 64;
    for (int j = 0; j < 4; ++j) {
      const bool first = j < (q.edges ? 2 : 1);
      if (!q.truth) x[j][2] = (first ? 1 : -1) * (x[j][2] < 0 ? -x[j][2] : x[j][2]) + first;
      const Vec3<double> u = first ? common + v : common;
      q.x_t0[j] = x[j] - u * at;
      q.x_t1[j] = x[j] + u * (1 - at);
    }
    queries.push_back(q);
  }
  return queries;
}

}  // namespace weft::bench
