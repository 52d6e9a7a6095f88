// How the dual of a zone is climbed, pass by pass.
#include "weft/kernels/respond/zone/qp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>

#include "tests/support/zone_case.hpp"
#include "weft/kernels/respond/zone/alone.hpp"

namespace weft {
namespace {

using test::ZoneCase;

/// One worker that changes all multipliers at once, as it does in zones of more than
/// zone_block_collisions.
struct AtOnce : Alone {
  static constexpr bool at_once = true;
};

/// The programme of a zone that has the vertices of a case, by their numbers there.
class Qp {
 public:
  explicit Qp(const ZoneCase& zones)
      : zones_(zones),
        bytes_(zone_scratch_bytes(zones.collisions.size(), 1)),
        m_(ZoneMemory::cut_from(bytes_.data(), collisions())) {
    Index corner = 0;
    for (const Collision& c : zones.collisions)
      for (const Index v : c.v) {
        m_.corner[corner] = ZoneMemory::entry_of(v, corner);
        ++corner;
      }
    std::sort(m_.corner, m_.corner + corner);
    for (Index v = 0; v <= vertices(); ++v)
      m_.corner_begin[v] = static_cast<Index>(
          std::lower_bound(m_.corner, m_.corner + corner, ZoneMemory::entry_of(v, 0)) - m_.corner);
    for (std::size_t i = 0; i < zones.end.size(); ++i) {
      m_.x[i] = zones.end[i];
      m_.mass_inv[i] = zones.fixed[i] != 0 ? 0 : 1 / zones.mass[i];
    }
  }

  /// Climbs from nothing, by so many passes.
  /// @return the multipliers
  std::vector<double> solve(int passes) {
    AtOnce team;
    team.stop = stop_;
    ZoneQp<AtOnce> qp(team, m_, vertices(), collisions());
    qp.set([&](Index k, const auto& take) {
      const Collision& c = zones_.collisions[static_cast<std::size_t>(k)];
      take(c.v, c.w, c.n, c.offset, 0.0);
    });
    solved_ = qp.solve(passes, std::numeric_limits<double>::infinity(), false);
    std::vector<double> multipliers(zones_.collisions.size());
    qp.each_multiplier([&](Index k, Index, double multiplier) {
      multipliers[static_cast<std::size_t>(k)] = multiplier;
    });
    return multipliers;
  }

  /// Tells solve() to stop once `flag` is true.
  void stop_on(const std::atomic<bool>& flag) { stop_ = &flag; }

  /// Whether the latest solve() has met all constraints.
  bool solved() const { return solved_; }

  /// lambda . (offset - A x*) - 1/2 lambda . A M^-1 A^T lambda, from the collisions alone.
  double dual(const std::vector<double>& multipliers) const {
    std::vector<Vec3<double>> impulse(zones_.end.size());
    double sum = 0;
    for (std::size_t k = 0; k < multipliers.size(); ++k) {
      const Collision& c = zones_.collisions[k];
      sum += multipliers[k] * (c.offset - test::gap(c, zones_.end));
      for (int j = 0; j < 4; ++j)
        impulse[static_cast<std::size_t>(c.v[j])] += (multipliers[k] * c.w[j]) * c.n;
    }
    for (std::size_t i = 0; i < impulse.size(); ++i)
      sum -= 0.5 * m_.mass_inv[i] * length_sq(impulse[i]);
    return sum;
  }

 private:
  Index vertices() const { return static_cast<Index>(zones_.end.size()); }
  Index collisions() const { return static_cast<Index>(zones_.collisions.size()); }

  const ZoneCase& zones_;
  std::vector<std::byte> bytes_;
  ZoneMemory m_;
  bool solved_ = false;
  const std::atomic<bool>* stop_ = nullptr;
};

TEST(ZoneQp, StopsWhenItIsTold) {
  test::ZoneRandom random(43);
  const ZoneCase zones = test::tangle(random, 20, 40, 1);
  std::atomic<bool> stop{true};
  Qp qp(zones);
  qp.stop_on(stop);
  const std::vector<double> stopped = qp.solve(300);
  EXPECT_FALSE(qp.solved());
  EXPECT_EQ(stopped, std::vector<double>(zones.collisions.size(), 0.0));
  stop = false;
  EXPECT_NE(qp.solve(300), stopped);
}

/// Cloth that is knotted has more impacts than coordinates, most of which repeat others. Few of
/// them push, and the change of these is found at once.
TEST(ZoneQp, KnotsTakeFewPasses) {
  test::ZoneRandom random(47);
  for (int n = 0; n < 20; ++n) {
    SCOPED_TRACE(n);
    const ZoneCase zones = test::tangle(random, 20, 120, n % 2 == 0 ? 1 : 1e2);
    const test::ZoneResult result = test::solve_zones(zones);
    EXPECT_TRUE(result.solved);
    EXPECT_EQ(0, result.outcomes.at(0).planes);
    EXPECT_LE(result.passes, 300);
  }
}

/// Momentum overshoots again and again on the way to a solution. A sweep that has lowered the dual
/// is taken back, and leaves the multipliers to the bit as they were: that is how it is seen here.
TEST(ZoneQp, SweepsAtOnceTakeBackWhatLowersTheDual) {
  test::ZoneRandom random(41);
  for (int n = 0; n < 12; ++n) {
    SCOPED_TRACE(n);
    // Tolerances that take more than the first rise to meet.
    ZoneCase zones = test::tangle(random, 20, 85, n % 2 == 0 ? 1 : 1e2);
    for (Collision& c : zones.collisions) c.offset = 1e-6;
    Qp qp(zones);
    std::vector<double> before(zones.collisions.size(), 0.0);
    double dual_before = 0;
    int passes = 0, taken_back = 0;
    while (!qp.solved() && passes < 300) {
      const std::vector<double> now = qp.solve(++passes);
      const double dual = qp.dual(now);
      EXPECT_GE(dual, dual_before * (1 - 1e-12)) << "after " << passes << " passes";
      taken_back += now == before ? 1 : 0;
      before = now;
      dual_before = dual;
    }
    EXPECT_TRUE(qp.solved());
    EXPECT_GT(taken_back, 0);
  }
}

}  // namespace
}  // namespace weft
