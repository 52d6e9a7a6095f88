// The threads of the asynchronous method: work is handed over and taken back without a gap.
#include "host/asynchronous/workers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/unit/asynchronous/scenes.hpp"

namespace weft {
namespace {

/// Every round reads what all threads wrote in the one before: a missed wait is a race.
TEST(Workers, RoundsFollowEachOther) {
  for (const int threads : {1, 2, 3, 8}) {
    Workers workers(threads);
    constexpr std::size_t count = 1000;
    std::vector<std::size_t> now(count), next(count);
    for (std::size_t i = 0; i < count; ++i) now[i] = i;
    const int rounds = 300;
    for (int r = 0; r < rounds; ++r) {
      workers.share(count, 1, [&](std::size_t a, std::size_t b) {
        for (std::size_t i = a; i < b; ++i) next[i] = now[(i + 1) % count] + 1;
      });
      now.swap(next);
    }
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(now[i], (i + rounds) % count + rounds);
  }
}

TEST(Workers, TurnsAreTakenOnce) {
  for (const int threads : {1, 2, 5}) {
    Workers workers(threads);
    for (const std::size_t count : {0u, 1u, 2u, 777u}) {
      std::vector<int> taken(count, 0);
      for (int r = 0; r < 50; ++r) workers.take_turns(count, [&](std::size_t i) { ++taken[i]; });
      for (const int times : taken) ASSERT_EQ(times, 50);
    }
  }
}

TEST(Workers, NoMoreThreadsThanGetEnough) {
  Workers workers(3);
  EXPECT_EQ(workers.parts_of(0, 10), 1);
  EXPECT_EQ(workers.parts_of(19, 10), 1);
  EXPECT_EQ(workers.parts_of(29, 10), 2);
  EXPECT_EQ(workers.parts_of(1000, 10), 3);
  for (int r = 0; r < 100; ++r)  // the third one sleeps, or not
    for (const std::size_t count : {19u, 29u, 1000u}) {
      std::vector<int> done(count, 0);
      std::atomic<int> runs{0};
      workers.share(count, 10, [&](std::size_t first, std::size_t last) {
        ++runs;
        for (std::size_t i = first; i < last; ++i) ++done[i];
      });
      EXPECT_EQ(runs, workers.parts_of(count, 10));
      EXPECT_EQ(std::count(done.begin(), done.end(), 1), static_cast<std::ptrdiff_t>(count));
    }
}

/// The first by number is what the caller gets, and the threads serve on.
TEST(Workers, ErrorsReachTheCaller) {
  Workers workers(4);
  for (int r = 0; r < 20; ++r) {
    try {
      workers.run(4, [](int n) {
        if (n == 1 || n == 3) throw std::runtime_error(std::to_string(n));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "1");
    }
  }
  int done[4] = {};
  workers.run(4, [&](int n) { done[n] = 1; });
  for (const int d : done) EXPECT_EQ(d, 1);
}

/// Forces, layers, broad and narrow phase of two sheets that are large enough to be shared out.
TEST(Workers, WindowsAreTheSameForAnyNumber) {
  Scene scene = test::asynchronous_scene();
  scene.contact.friction = 0.3;
  scene.contact.thickness = 0.003;
  scene.cloths.push_back(test::sheet(26, 0.0));
  scene.cloths.push_back(test::sheet(25, 0.0032));
  scene.cloths[1].velocity = {0.1, 0.05, -1};
  std::vector<Vec3<double>> expected;
  for (const int threads : {1, 2, 3}) {
    test::WindowRun run(scene, threads);
    ASSERT_TRUE(run.advance(0.001)) << run.total.failure_detail;
    EXPECT_GT(run.total.asynchronous.rollbacks, 0) << "the sheets never met";
    if (threads == 1) expected = run.positions;
    EXPECT_EQ(run.positions, expected) << threads;
  }
}

/// The next window begins while other threads look at the last one: states, ways and layers of both
/// must not meet, whether it goes on or is stopped.
TEST(Workers, OptimisticStartsAreTheSame) {
  Scene scene = test::asynchronous_scene();
  scene.contact.friction = 0.3;
  scene.contact.thickness = 0.003;
  scene.cloths.push_back(test::sheet(26, 0.0));
  scene.cloths.push_back(test::sheet(25, 0.0034));
  scene.cloths[1].velocity = {0.1, 0.05, -1};
  scene.asynchronous.window = 0.0002;
  std::vector<Vec3<double>> expected;
  for (const int threads : {1, 2, 3}) {
    test::WindowRun run(scene, threads);
    ASSERT_TRUE(run.advance(0.0012)) << run.total.failure_detail;
    EXPECT_GT(run.total.asynchronous.acting_pairs, 0) << "the sheets never met";
    if (threads == 1) expected = run.positions;
    EXPECT_EQ(run.positions, expected) << threads;
    EXPECT_EQ(run.total.asynchronous.ahead_accepted > 0, threads > 1);
    EXPECT_EQ(run.total.asynchronous.ahead_cancelled > 0, threads > 1);
  }
}

TEST(Workers, EndWithoutWork) {
  for (int r = 0; r < 50; ++r) Workers workers(4);
}

}  // namespace
}  // namespace weft
