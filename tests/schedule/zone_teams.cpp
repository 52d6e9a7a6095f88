// Teams of threads solve impact zones as the lanes of a warp and the threads of a block do on a
// GPU: the same source, with barriers that ThreadSanitizer understands.
#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <cmath>
#include <thread>

#include "host/exec/host_devices.hpp"
#include "tests/support/zone_case.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/kernels/respond/zone/solver.hpp"

namespace weft {
namespace {

using test::solve_zones;
using test::ZoneCase;
using test::ZoneRandom;
using test::ZoneResult;

/// What the threads of a team share.
struct Table {
  explicit Table(Index threads) : barrier(threads), part(2 * static_cast<std::size_t>(threads)) {}
  std::barrier<> barrier;
  std::vector<double> part;
};

/// How a team sweeps.
enum class Sweeps { in_order, by_phases, at_once };

template <Sweeps sweeps>
class ThreadTeam {
 public:
  static constexpr bool alone = false;
  static constexpr bool in_order = sweeps == Sweeps::in_order;
  static constexpr bool at_once = sweeps == Sweeps::at_once;
  static constexpr Index lanes = 1;

  ThreadTeam(Table& table, Index rank, Index size) : table_(table), rank_(rank), size_(size) {}
  Index rank() const { return rank_; }
  Index size() const { return size_; }
  void sync() { table_.barrier.arrive_and_wait(); }
  double sum(double value) {
    const double* part = share(value);
    double sum = 0;
    for (Index r = 0; r < size_; ++r) sum += part[r];
    return sum;
  }
  double largest(double value) {
    const double* part = share(value);
    return *std::max_element(part, part + size_);
  }
  bool any(bool value) { return sum(value ? 1 : 0) > 0; }
  Index before(Index value, Index& total) {
    const double* part = share(value);
    double before = 0, all = 0;
    for (Index r = 0; r < size_; ++r) {
      if (r < rank_) before += part[r];
      all += part[r];
    }
    total = static_cast<Index>(all);
    return static_cast<Index>(before);
  }
  void sort(Offset* keys, Index count) { sort_bitonic(*this, keys, count); }

 private:
  const double* share(double value) {
    double* part = table_.part.data() + turn_ * size_;
    turn_ = 1 - turn_;
    part[rank_] = value;
    sync();
    return part;
  }

  Table& table_;
  Index rank_, size_;
  int turn_ = 0;
};

/// Solves zones one after the other with a team of threads.
template <Sweeps sweeps>
test::ZoneRun<double> team_of(Index threads) {
  return [threads](Queue&, const RespondZones<double>& args) {
    Table table(threads);
    std::vector<std::thread> team;
    for (Index rank = 0; rank < threads; ++rank)
      team.emplace_back([&, rank] {
        ThreadTeam<sweeps> member(table, rank, threads);
        ZoneSolver<double, ThreadTeam<sweeps>> solver(args, member);
        for (std::size_t z = 0; z < args.outcomes.size(); ++z) {
          const auto before = static_cast<std::size_t>(args.zone_begin[z]);
          solver.solve(static_cast<Index>(z), args.scratch.data() + zone_scratch_bytes(before, z));
        }
      });
    for (std::thread& thread : team) thread.join();
  };
}

template <Sweeps sweeps>
ZoneResult solve_by_team(const ZoneCase& zones, ZoneMotion motion, Index threads) {
  const DeviceSet devices = host_devices(1, {true, 0});
  return test::solve_zones_with<double>(devices[0], team_of<sweeps>(threads), zones, motion);
}

/// The second of two rounds, see solve_warm_with().
template <Sweeps sweeps>
ZoneResult solve_warm_by_team(const ZoneCase& zones, std::size_t old, Index threads) {
  const DeviceSet devices = host_devices(1, {true, 0});
  return test::solve_warm_with<double>(devices[0], team_of<sweeps>(threads), zones, old);
}

/// Root of the mean square of the differences, weighted with the masses [m].
double distance(const ZoneCase& zones, const ZoneResult& a, const ZoneResult& b) {
  double sum = 0, mass = 0;
  for (const auto& m : b.moved) {
    const auto i = static_cast<std::size_t>(m.vertex);
    sum += zones.mass[i] * length_sq(a.end[i] - b.end[i]);
    mass += zones.mass[i];
  }
  return std::sqrt(sum / mass);
}

void expect_same_outcomes(const ZoneResult& a, const ZoneResult& b) {
  ASSERT_EQ(a.outcomes.size(), b.outcomes.size());
  for (std::size_t z = 0; z < a.outcomes.size(); ++z) {
    EXPECT_EQ(a.outcomes[z].moved, b.outcomes[z].moved);
    EXPECT_EQ(a.outcomes[z].solved, b.outcomes[z].solved);
    EXPECT_EQ(a.outcomes[z].pinched, b.outcomes[z].pinched);
    EXPECT_EQ(a.outcomes[z].free, b.outcomes[z].free);
    EXPECT_EQ(a.outcomes[z].planes, b.outcomes[z].planes);
  }
}

/// Free, pinned, yielding, pinched and impossible zones of up to 40 collisions.
std::vector<ZoneCase> small_cases() {
  std::vector<ZoneCase> cases;
  ZoneRandom random(21);
  for (int n = 0; n < 6; ++n) {
    cases.push_back(test::random_impact(random, 1 + n % 2, 1e2));
    if (n >= 4) test::exclude_the_first(cases.back());
  }
  for (const std::size_t impacts : {5u, 17u, 30u, 40u}) {
    cases.push_back(test::tangle(random, impacts, impacts, 1e3));
    cases.push_back(cases.back());
    for (std::size_t i = 0; i < impacts; i += 6) {
      ZoneCase& zones = cases.back();
      zones.fixed[i] = 1;
      zones.compliant[i] = i % 4 == 0 ? 1 : 0;
      if (i % 4 != 0) zones.end[i] = zones.start[i];
    }
  }
  cases.push_back(test::vice(0.85));
  cases.push_back(test::vice(0.95));
  return cases;
}

TEST(ZoneTeams, InOrderATeamDoesWhatOneDoes) {
  for (const ZoneCase& zones : small_cases())
    for (const ZoneMotion motion : {ZoneMotion::impacts, ZoneMotion::planes, ZoneMotion::rigid}) {
      const ZoneResult one = solve_zones(zones, motion);
      const ZoneResult team = solve_by_team<Sweeps::in_order>(zones, motion, 3);
      expect_same_outcomes(one, team);
      EXPECT_EQ(one.passes, team.passes);
      ASSERT_EQ(one.moved.size(), team.moved.size());
      for (std::size_t i = 0; i < one.moved.size(); ++i) {
        EXPECT_EQ(one.moved[i].vertex, team.moved[i].vertex);
        // Sums in another order: far below what conjugate gradients leave.
        EXPECT_LE(length(one.moved[i].position - team.moved[i].position), 1e-9);
      }
    }
}

/// Few impacts are found by a second round, fewer than a tenth or one.
std::size_t old_ones(const ZoneCase& zones) {
  return zones.collisions.size() - zones.collisions.size() / 10 - 1;
}

TEST(ZoneTeams, InOrderATeamGoesOnAsOneDoes) {
  for (const ZoneCase& zones : small_cases()) {
    const ZoneResult one = test::solve_warm(zones, old_ones(zones));
    for (const Index threads : {1, 2, 3, 5}) {
      const ZoneResult team = solve_warm_by_team<Sweeps::in_order>(zones, old_ones(zones), threads);
      expect_same_outcomes(one, team);
      EXPECT_EQ(one.passes, team.passes);
      ASSERT_EQ(one.moved.size(), team.moved.size());
      for (std::size_t i = 0; i < one.moved.size(); ++i)
        EXPECT_LE(length(one.moved[i].position - team.moved[i].position), 1e-9);
    }
  }
}

/// Small ones, and such as take many sweeps.
std::vector<ZoneCase> hard_cases() {
  ZoneRandom random(22);
  std::vector<ZoneCase> cases = small_cases();
  cases.push_back(test::tangle(random, 150, 140, 1e2));
  cases.push_back(test::chain(25, 1e2, false));
  // A crowd around one vertex, more than there are phases.
  ZoneCase crowd;
  crowd.add({0, 0, 0}, {0, 0, 0.3}, 10);
  for (int k = 0; k < 90; ++k) {
    const Vec3<double> from{random.uniform(-1, 1), random.uniform(-1, 1), 0.1};
    for (int j = 0; j < 3; ++j) {
      const Vec3<double> at = from + Vec3<double>{0.01 * j, 0, 0};
      crowd.add(at, at, 1);
    }
    const Index first = 3 * k + 1;
    crowd.collisions.push_back(
        {{0, first, first + 1, first + 2}, {1, -0.3, -0.3, -0.4}, {0, 0, -1}, 0.01, 0.5});
  }
  cases.push_back(crowd);
  for (const bool obstacle : {false, true}) cases.push_back(test::sheets(random, 12, obstacle));
  return cases;
}

template <Sweeps sweeps>
void meets_the_same_constraints() {
  for (const ZoneCase& zones : hard_cases())
    for (const ZoneMotion motion : {ZoneMotion::impacts, ZoneMotion::planes}) {
      const ZoneResult one = solve_zones(zones, motion);
      const ZoneResult team = solve_by_team<sweeps>(zones, motion, 4);
      expect_same_outcomes(one, team);
      if (motion == ZoneMotion::impacts && one.solved && one.outcomes[0].planes == 0) {
        EXPECT_LE(test::worst_share(zones, team.end), 1 - zone_met_share + 1e-6);
      }
      double offset = 0;
      for (const Collision& c : zones.collisions) offset = std::max(offset, c.offset);
      if (one.solved) {
        EXPECT_LE(distance(zones, one, team), 0.2 * offset);
      }
      EXPECT_TRUE(test::same_bits(team, solve_by_team<sweeps>(zones, motion, 4)));
    }
}

/// A second round meets all constraints, in fewer passes over all cases than if it had found
/// everything at once.
template <Sweeps sweeps>
void goes_on_to_the_same_constraints() {
  int passes = 0, passes_at_once = 0;
  for (const ZoneCase& zones : hard_cases()) {
    const ZoneResult one = test::solve_warm(zones, old_ones(zones));
    const ZoneResult warm = solve_warm_by_team<sweeps>(zones, old_ones(zones), 4);
    expect_same_outcomes(one, warm);
    if (warm.solved && warm.outcomes[0].planes == 0) {
      EXPECT_LE(test::worst_share(zones, warm.end), 1 - zone_met_share + 1e-6);
    }
    double offset = 0;
    for (const Collision& c : zones.collisions) offset = std::max(offset, c.offset);
    if (one.solved) {
      EXPECT_LE(distance(zones, one, warm), 0.2 * offset);
    }
    passes += warm.passes;
    passes_at_once += solve_by_team<sweeps>(zones, ZoneMotion::impacts, 4).passes;
    EXPECT_TRUE(test::same_bits(warm, solve_warm_by_team<sweeps>(zones, old_ones(zones), 4)));
  }
  EXPECT_LT(passes, passes_at_once);
}

TEST(ZoneTeams, PhasesMeetTheSameConstraints) {
  meets_the_same_constraints<Sweeps::by_phases>();
  goes_on_to_the_same_constraints<Sweeps::by_phases>();
}

TEST(ZoneTeams, SweepsAtOnceMeetTheSameConstraints) {
  meets_the_same_constraints<Sweeps::at_once>();
  goes_on_to_the_same_constraints<Sweeps::at_once>();
}

}  // namespace
}  // namespace weft
