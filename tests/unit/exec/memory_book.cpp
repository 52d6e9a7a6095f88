#include "weft/exec/memory_book.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "host/exec/host_device.hpp"
#include "tests/support/replaced_new.hpp"
#include "weft/devices.hpp"
#include "weft/exec/buffer.hpp"

namespace {

thread_local bool out_of_memory = false;  // of the processor, not of the device

}  // namespace

bool allocation_fails() {
  return out_of_memory;
}

namespace weft {
namespace {

/// A device whose memory outlasts the processor's.
class SpareDevice final : public Device {
 public:
  Backend backend() const noexcept override { return Backend::host; }
  std::string name() const override { return "spare"; }
  Queue& compute() noexcept override { std::abort(); }
  Queue& transfer() noexcept override { std::abort(); }
  bool reaches_peers() const noexcept override { return true; }
  void* allocate(std::size_t bytes) override {
    void* memory = std::malloc(bytes);
    held += bytes;
    out_of_memory = fails;
    return memory;
  }
  void release(void* memory, std::size_t bytes) noexcept override {
    std::free(memory);
    held -= bytes;
  }
  std::size_t peak_bytes() const noexcept override { return held; }
  std::int64_t allocation_count() const noexcept override { return 0; }

  std::size_t held = 0;
  bool fails = false;  ///< booking what is allocated next
};

std::size_t bytes_of(const std::vector<MemoryUse>& uses, const std::string& name) {
  for (const MemoryUse& use : uses)
    if (use.name == name) return use.bytes;
  return 0;
}

TEST(MemoryBook, CountsByName) {
  MemoryBook book;
  book.add("pairs", 10);
  book.add("boxes", 3);
  book.add("pairs", 5);
  book.remove("pairs", 12);
  EXPECT_EQ(bytes_of(book.uses(), "pairs"), 3u);
  EXPECT_EQ(bytes_of(book.uses(), "boxes"), 3u);
  EXPECT_EQ(book.uses()[1].peak_bytes, 15u);
}

// What was never booked is not taken from another name's bytes.
TEST(MemoryBook, RemovesNothingFromOtherNames) {
  MemoryBook book;
  book.add("pairs", 10);
  book.remove("boxes", 4);   // would stand before it
  book.remove("tables", 4);  // would stand after it
  EXPECT_EQ(bytes_of(book.uses(), "pairs"), 10u);
}

TEST(MemoryBook, BufferThatCannotBeBookedHoldsNothing) {
  SpareDevice device;
  {
    const MemoryName pairs("pairs");
    const Buffer<int> kept(device, 100);
    const MemoryName boxes("boxes");
    Buffer<int> lost(device);
    device.fails = true;
    EXPECT_THROW(lost.resize(50), std::bad_alloc);
    device.fails = out_of_memory = false;
    EXPECT_EQ(lost.size(), 0u);
    EXPECT_EQ(lost.data(), nullptr);
    EXPECT_EQ(device.held, 100 * sizeof(int));
    const Buffer<int> other(device, 10);  // of the same name
    lost = Buffer<int>(device);
    EXPECT_EQ(bytes_of(device.memory().uses(), "boxes"), 10 * sizeof(int));
    EXPECT_EQ(bytes_of(device.memory().uses(), "pairs"), 100 * sizeof(int));
  }
  EXPECT_EQ(device.held, 0u);
}

/// Work for which there is no memory is not waited for, by any kind of rank.
TEST(HostWork, IsNotWaitedForIfThereIsNoMemoryForIt) {
  for (const int ranks : {1, 2}) {
    DeviceSet devices = host_devices(ranks);
    Queue& queue = devices[ranks - 1].compute();
    std::atomic<int> ran{0};
    int submitted = 0, refused = 0;
    for (int k = 0; k < 1000; ++k) {
      out_of_memory = true;
      try {
        submit_host(queue, [&ran] { ++ran; });
        ++submitted;
      } catch (const std::bad_alloc&) {
        ++refused;
      }
      out_of_memory = false;
    }
    queue.sync();
    EXPECT_EQ(ran, submitted);
    EXPECT_GT(refused, 0) << ranks;
  }
}

}  // namespace
}  // namespace weft
