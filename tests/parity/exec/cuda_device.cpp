#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// The contract of Device and Queue, on host ranks and on ranks that share GPU 0.
class DeviceContract : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    if (GetParam() == Backend::host) {
      devices_.emplace(host_devices(2));
      return;
    }
    std::string why;
    devices_ = find_cuda({0, 0}, why);
    if (!devices_) GTEST_SKIP() << why;
  }
  Device& rank(int r) { return (*devices_)[r]; }

  std::optional<DeviceSet> devices_;
};

TEST_P(DeviceContract, NamesItsRanks) {
  EXPECT_EQ(devices_->size(), 2);
  EXPECT_EQ(devices_->backend(), GetParam());
  EXPECT_NE(rank(0).name().find("rank 0"), std::string::npos) << rank(0).name();
  EXPECT_NE(rank(1).name().find("rank 1"), std::string::npos) << rank(1).name();
}

TEST_P(DeviceContract, CopiesFromHostBetweenRanksAndBack) {
  Random random(11);
  const std::vector<double> sent = random.numbers<double>(100'003, -1, 1);
  const Buffer<double> first = upload(rank(0), sent);
  const Buffer<double> second(rank(1), sent.size());
  rank(1).transfer().copy(second.data(), first.data(), sent.size() * sizeof(double));
  rank(1).transfer().sync();
  EXPECT_EQ(download(second), sent);
}

TEST_P(DeviceContract, FillsBytes) {
  const Buffer<unsigned char> buffer = upload(rank(0), std::vector<unsigned char>(1000, 1));
  rank(0).compute().fill(buffer.data() + 10, 0xa5, 500);
  std::vector<unsigned char> expected(1000, 1);
  std::fill_n(expected.begin() + 10, 500, static_cast<unsigned char>(0xa5));
  EXPECT_EQ(download(buffer), expected);
}

TEST_P(DeviceContract, DoesNothingForNoBytes) {
  EXPECT_EQ(rank(0).allocate(0), nullptr);
  rank(0).compute().copy(nullptr, nullptr, 0);
  rank(0).compute().fill(nullptr, 1, 0);
  EXPECT_NO_THROW(rank(0).compute().sync());
}

TEST_P(DeviceContract, EventOrdersTwoQueues) {
  constexpr std::size_t size = std::size_t{64} << 20;
  const Buffer<unsigned char> from(rank(0), size), to(rank(1), 1);
  Queue& writer = rank(0).compute();
  Queue& reader = rank(1).transfer();
  // Long enough that a reader that does not wait comes too early.
  for (unsigned char value = 0; value <= 42; ++value) writer.fill(from.data(), value, size);
  const Event written = writer.record();
  reader.wait(written);
  reader.copy(to.data(), from.data() + size - 1, 1);
  const Event read = reader.record();
  rank(1).compute().wait(read);
  rank(1).compute().wait(Event());
  EXPECT_EQ(download(to), std::vector<unsigned char>{42});
  writer.sync();
}

/// Two queues that know nothing of each other, joined by the default stream.
TEST_P(DeviceContract, OrdersItsWorkWithAStreamOfTheProgram) {
  constexpr std::size_t size = std::size_t{64} << 20;
  const Buffer<unsigned char> from(rank(0), size), to(rank(0), 1);
  Queue& queue = rank(0).compute();
  void* const stream = nullptr;  // CUDA's default stream
  for (unsigned char value = 0; value <= 42; ++value) queue.fill(from.data(), value, size);
  queue.let_stream_wait(stream);
  // What comes after the stream comes after the fills.
  Queue& reader = rank(0).transfer();
  reader.wait_for_stream(stream);
  reader.copy(to.data(), from.data() + size - 1, 1);
  reader.sync();
  EXPECT_EQ(download(to), std::vector<unsigned char>{42});
  EXPECT_EQ(rank(0).gpu(), GetParam() == Backend::cuda ? 0 : -1);
}

TEST_P(DeviceContract, StampsTellTheOrderOfWork) {
  constexpr std::size_t size = std::size_t{16} << 20;
  const Buffer<unsigned char> buffer(rank(0), size);
  Queue& queue = rank(0).compute();
  const auto now = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  double times[2] = {-1, -1};
  const double before = now();
  queue.stamp(&times[0]);
  for (int i = 0; i < 20; ++i) queue.fill(buffer.data(), 3, size);
  queue.stamp(&times[1]);
  queue.sync();
  const double after = now();
  EXPECT_LT(times[0], times[1]);
  // Events count in half microseconds.
  EXPECT_LE(times[1] - times[0], after - before + 1e-6);
  double later = -1;
  queue.stamp(&later);
  queue.sync();
  EXPECT_LE(times[1], later);
}

TEST_P(DeviceContract, RemembersItsPeak) {
  EXPECT_EQ(rank(0).peak_bytes(), 0u);
  {
    const Buffer<char> one(rank(0), 3000), two(rank(0), 4000);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(one.data()) % 256, 0u);
  }
  const Buffer<char> three(rank(0), 5000);
  EXPECT_EQ(rank(0).peak_bytes(), 7000u);
  EXPECT_EQ(rank(1).peak_bytes(), 0u);
}

TEST_P(DeviceContract, CountsMemoryByWhatItIsFor) {
  const auto uses = [&] {
    std::map<std::string, std::pair<std::size_t, std::size_t>> found;
    for (const MemoryUse& use : rank(0).memory_use()) found[use.name] = {use.bytes, use.peak_bytes};
    return found;
  };
  using Found = decltype(uses());
  Buffer<int> without(rank(0), 10);
  Buffer<char> later;
  {
    MemoryName name("inner tube");
    later = Buffer<char>(rank(0));
    name.change("tyre");
    const Buffer<char> gone(rank(0), 300);
    EXPECT_EQ(uses(), (Found{{"other", {40, 40}}, {"tyre", {300, 300}}}));
  }
  // A buffer keeps its name where it grows, and wherever it is moved to.
  later.resize(100);
  later.resize(70);
  Buffer<char> moved = std::move(later);
  moved.resize(200);
  without.resize(20);
  EXPECT_EQ(uses(), (Found{{"inner tube", {200, 200}}, {"other", {80, 80}}, {"tyre", {0, 300}}}));
  EXPECT_TRUE(rank(1).memory_use().empty());
}

INSTANTIATE_TEST_SUITE_P(Backends, DeviceContract, testing::Values(Backend::host, Backend::cuda),
                         [](const testing::TestParamInfo<Backend>& param) {
                           return std::string(param.param == Backend::host ? "Host" : "Cuda");
                         });

TEST(CudaDevices, TooMuchMemoryIsADeviceErrorThatNamesRankAndBytes) {
  std::string why;
  const std::optional<DeviceSet> devices = find_cuda({0, 0}, why);
  if (!devices) GTEST_SKIP() << why;
  constexpr std::size_t bytes = std::size_t{1} << 45;
  try {
    (*devices)[1].allocate(bytes);
    FAIL() << "32 TiB were handed out";
  } catch (const DeviceError& error) {
    const std::string text = error.what();
    for (const char* part :
         {"out of memory", "rank 1", "35184372088832", "cudaMalloc", "cuda/exec/cuda_device.cu:"})
      EXPECT_NE(text.find(part), std::string::npos) << text << "\nlacks: " << part;
  }
  // The failure leaves the device as it was.
  EXPECT_EQ((*devices)[1].peak_bytes(), 0u);
  const std::vector<int> sent = {1, 2, 3};
  EXPECT_EQ(download(upload((*devices)[1], sent)), sent);
}

TEST(CudaDevices, MissingCardIsADeviceError) {
  EXPECT_THROW(cuda_devices({100'000}), DeviceError);
  EXPECT_THROW(cuda_devices({-1}), DeviceError);
  EXPECT_THROW(cuda_devices({}), DeviceError);
}

TEST(CudaDevices, MissingCardIsNamedWithItsRank) {
  std::string why;
  if (!find_cuda({0}, why)) GTEST_SKIP() << why;
  try {
    cuda_devices({0, 100'000});
    FAIL() << "a GPU that is not there";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("rank 1: CUDA GPU 100000"), std::string::npos)
        << error.what();
  }
}

TEST(DescribeDevices, SaysSomethingOfProcessorAndCards) {
  const std::vector<std::string> lines = describe_devices();
  ASSERT_GE(lines.size(), 2u);
  EXPECT_TRUE(lines[0].starts_with("cpu: ")) << lines[0];
  EXPECT_TRUE(lines[1].starts_with("cuda")) << lines[1];
  for (const std::string& line : lines) EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  std::string why;
  if (find_cuda({0}, why)) {
    EXPECT_NE(lines[1].find("TB/s"), std::string::npos) << lines[1];
  }
}

}  // namespace
}  // namespace weft::parity
