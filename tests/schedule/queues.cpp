#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

#include "host/exec/host_device.hpp"
#include "host/exec/host_devices.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "weft/core/vec.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

TEST(Queues, EventOrdersTwoQueues) {
  const DeviceSet devices = host_devices(2, {true, 7});
  Buffer<int> a(devices[0], 1);
  Buffer<int> b(devices[1], 1);
  for (int k = 0; k < 50; ++k) {
    submit_host(devices[0].compute(), [&, k] { a.data()[0] = k; });
    const Event written = devices[0].compute().record();
    devices[1].transfer().wait(written);
    devices[1].transfer().copy(b.data(), a.data(), sizeof(int));
    const Event copied = devices[1].transfer().record();
    devices[0].compute().wait(copied);
    devices[1].transfer().sync();
    EXPECT_EQ(k, b.data()[0]);
  }
  devices[0].compute().sync();
}

TEST(Queues, FreshMemoryIsNotANumber) {
  const DeviceSet devices = host_devices(1, {true, 0});
  const Buffer<double> buffer(devices[0], 3);
  for (const double x : buffer.span()) EXPECT_TRUE(std::isnan(x));
}

TEST(Queues, ErrorReachesSyncAndEventsStillPass) {
  const DeviceSet devices = host_devices(1);
  Queue& queue = devices[0].compute();
  bool ran = false;
  submit_host(queue, [] { throw DeviceError("lost"); });
  submit_host(queue, [&] { ran = true; });
  const Event after = queue.record();
  devices[0].transfer().wait(after);
  devices[0].transfer().sync();
  EXPECT_THROW(queue.sync(), DeviceError);
  EXPECT_FALSE(ran);
  queue.sync();
}

TEST(Queues, WorkThatWorkSubmitsComesAfterIt) {
  for (const int ranks : {1, 2}) {
    const DeviceSet devices = host_devices(ranks);
    Queue& queue = devices[0].compute();
    std::vector<int> order;
    submit_host(queue, [&] {
      submit_host(queue, [&] { order.push_back(2); });
      order.push_back(1);
    });
    queue.sync();
    EXPECT_EQ((std::vector<int>{1, 2}), order) << ranks;
  }
}

TEST(Queues, ALoneRankWorksOffWhatIsSubmittedWithoutAThread) {
  const DeviceSet devices = host_devices(1);
  std::thread::id who;
  submit_host(devices[0].compute(), [&] { who = std::this_thread::get_id(); });
  EXPECT_EQ(std::this_thread::get_id(), who);
  devices[0].compute().sync();
}

TEST(Queues, WhoeverWaitsForAnyRankWorksForRankZero) {
  const DeviceSet devices = host_devices(2);
  std::thread::id zero, one;
  submit_host(devices[0].compute(), [&] { zero = std::this_thread::get_id(); });
  devices[1].compute().wait(devices[0].compute().record());
  submit_host(devices[1].compute(), [&] { one = std::this_thread::get_id(); });
  devices[1].compute().sync();
  EXPECT_EQ(std::this_thread::get_id(), zero);
  EXPECT_NE(std::this_thread::get_id(), one);
}

TEST(Queues, TransfersOfARankNeedNoThreadOfTheirOwn) {
  DeviceSet devices = host_devices(2);
  std::thread::id compute, transfer;
  submit_host(devices[1].compute(), [&] { compute = std::this_thread::get_id(); });
  submit_host(devices[1].transfer(), [&] { transfer = std::this_thread::get_id(); });
  sync_ranks(devices);
  devices[1].transfer().sync();
  EXPECT_EQ(compute, transfer);
}

/// The main thread is busy with rank 0 or gone, and all that others wait for goes on.
TEST(Queues, SeveralThreadsMayWait) {
  const DeviceSet devices = host_devices(3);
  int value[3] = {};
  for (int k = 0; k < 200; ++k) {
    submit_host(devices[0].compute(), [&] { ++value[0]; });
    const Event first = devices[0].compute().record();
    for (int r = 1; r < 3; ++r) {
      devices[r].compute().wait(first);
      submit_host(devices[r].compute(), [&, r] { value[r] += value[0]; });
    }
    std::thread other([&] { devices[1].compute().sync(); });
    if (k % 2 == 0) devices[2].compute().sync();
    other.join();
    devices[2].compute().sync();
    devices[0].compute().sync();
  }
  EXPECT_EQ(200, value[0]);
  EXPECT_EQ(200 * 201 / 2, value[1]);
  EXPECT_EQ(200 * 201 / 2, value[2]);
}

TEST(Queues, ASyncOfARankThrowsErrorsOfItsOwnQueueOnly) {
  const DeviceSet devices = host_devices(2);
  bool ran = false, copied = false;
  submit_host(devices[0].compute(), [] { throw DeviceError("lost"); });
  submit_host(devices[0].compute(), [&] { ran = true; });
  submit_host(devices[0].transfer(), [&] { copied = true; });
  devices[1].compute().wait(devices[0].compute().record());
  devices[1].compute().sync();
  devices[0].transfer().sync();
  EXPECT_THROW(devices[0].compute().sync(), DeviceError);
  EXPECT_FALSE(ran);
  EXPECT_TRUE(copied);
  devices[0].compute().sync();
}

TEST(Queues, WorkThatNobodyWaitsForIsDoneBeforeTheDevicesAreGone) {
  for (const int ranks : {1, 2, 3}) {
    std::vector<int> done(static_cast<std::size_t>(ranks));
    {
      DeviceSet devices = host_devices(ranks);
      for (int k = 0; k < 10; ++k) {
        for (int r = 0; r < ranks; ++r)
          submit_host(devices[r].compute(), [&done, r] { ++done[static_cast<std::size_t>(r)]; });
        join_ranks(devices);
      }
    }
    EXPECT_EQ(std::vector<int>(static_cast<std::size_t>(ranks), 10), done);
  }
}

TEST(Queues, EveryRankGetsEveryRow) {
  for (const int ranks : {1, 2, 3, 5, 8}) {
    DeviceSet devices = host_devices(ranks, {true, 3});
    const Partition partition = make_partition(100, ranks, 8);
    std::vector<Buffer<Vec3<float>>> arrays;
    for (int r = 0; r < ranks; ++r) arrays.emplace_back(devices[r], 100);
    for (int r = 0; r < ranks; ++r)
      submit_host(devices[r].compute(), [&, r] {
        for (Index i = partition.row_begin[static_cast<std::size_t>(r)];
             i < partition.row_begin[static_cast<std::size_t>(r) + 1]; ++i)
          arrays[static_cast<std::size_t>(r)].data()[i] = {static_cast<float>(i), 1, 2};
      });
    all_gather_rows<Vec3<float>>(devices, partition,
                                 [&](int r) { return arrays[static_cast<std::size_t>(r)].span(); });
    sync_ranks(devices);
    for (const auto& array : arrays)
      for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(static_cast<float>(i), array.span()[i][0]);
  }
}

TEST(Partition, BoundariesAreMultiplesAndCoverAllRows) {
  for (const Index rows : {1, 7, 8, 1000, 12345})
    for (const int ranks : {1, 2, 3, 8, 64}) {
      const Partition p = make_partition(rows, ranks, 0);
      EXPECT_EQ(0, p.row_begin.front());
      EXPECT_EQ(rows, p.row_begin.back());
      EXPECT_EQ(make_partition(rows, 1, 0).partial_rows, p.partial_rows);
      for (std::size_t r = 0; r + 1 < p.row_begin.size(); ++r) {
        EXPECT_LE(p.row_begin[r], p.row_begin[r + 1]);
        EXPECT_TRUE(p.row_begin[r] == rows || p.row_begin[r] % p.partial_rows == 0);
      }
    }
}

TEST(Devices, TextsThatAreNoDevices) {
  for (const char* text : {"", "gpu", "cpu:", "cpu:0", "cpu:65", "cpu:x", "cuda:", "cuda:a"})
    EXPECT_THROW(parse_devices(text), SceneError) << text;
  EXPECT_EQ(3, parse_devices("cpu:3").size());
  EXPECT_THROW(host_devices(0), DeviceError);
}

}  // namespace
}  // namespace weft
