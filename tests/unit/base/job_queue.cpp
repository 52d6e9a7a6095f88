#include "host/base/job_queue.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace weft {
namespace {

TEST(JobQueue, DoesJobsInTheirOrderAndAllOfThemAtItsEnd) {
  std::vector<int> done;
  {
    JobQueue queue(2);
    for (int i = 0; i < 50; ++i) queue.add([&done, i] { done.push_back(i); });
    queue.wait();
    EXPECT_EQ(done.size(), 50u);
    queue.add([&done] { done.push_back(50); });
  }
  ASSERT_EQ(done.size(), 51u);
  for (int i = 0; i <= 50; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(JobQueue, HoldsNoMoreJobsThanItMay) {
  std::atomic<bool> go{false};
  std::atomic<int> begun{0};
  JobQueue queue(1);
  std::atomic<int> added{0};
  std::thread adds([&] {
    for (int i = 0; i < 4; ++i) {
      queue.add([&] {
        ++begun;
        go.wait(false);
      });
      ++added;
    }
  });
  while (begun == 0 || added < 2) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(added, 2);  // one being done, one waiting
  go = true;
  go.notify_all();
  adds.join();
  queue.wait();
  EXPECT_EQ(begun, 4);
}

TEST(JobQueue, AfterAnErrorDropsJobsAndSaysSo) {
  int later = 0;
  JobQueue queue(4);
  queue.add([] { throw std::runtime_error("disk is full"); });
  EXPECT_THROW(queue.wait(), std::runtime_error);
  EXPECT_THROW(queue.add([&] { ++later; }), std::runtime_error);
  EXPECT_THROW(queue.wait(), std::runtime_error);
  EXPECT_EQ(later, 0);
}

}  // namespace
}  // namespace weft
