// A vector of a sheet's rows to all GPUs, which each have a part of it: what a product has to wait
// for where nothing overlaps (P-Cloth eq. (6)). On the first 1, 2, 4, ... ranks of a device set.
//   queues  copies that the host issues, stage by stage, by the work queues (P-Cloth 3.1.2)
//   copies  the same in any order
//   nccl    ncclAllGather, where the build has found that library and no GPU has two ranks
// Parts are of one length, as in the paper.
#include <cuda_runtime.h>

#include <algorithm>
#include <functional>
#include <set>

#if defined(WEFT_NCCL)
#include <nccl.h>
#endif

#include "benchmarks/support/kernel_bench.hpp"
#include "cuda/exec/cuda_device.cuh"
#include "host/exec/device_text.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/parallel/work_queues.hpp"

namespace weft::bench {
namespace {

constexpr int chained = 20;
constexpr std::size_t row_bytes = 12;

/// A copy of the vector on each rank, of which it has its own part to begin with.
class Vectors {
 public:
  Vectors(DeviceSet& devices, std::size_t rows)
      : devices_(devices),
        part_((rows + static_cast<std::size_t>(ranks()) - 1) / static_cast<std::size_t>(ranks()) *
              row_bytes) {
    for (int r = 0; r < ranks(); ++r) {
      copies_.emplace_back(devices[r], part_ * static_cast<std::size_t>(ranks()));
      Queue& queue = devices[r].compute();
      queue.fill(copies_.back().data(), 0, copies_.back().size());
      queue.fill(at(r, r), mark(r), part_);
      queue.sync();
    }
  }
  int ranks() const { return devices_.size(); }
  DeviceSet& devices() const { return devices_; }
  std::size_t part() const { return part_; }
  /// Part `part` in the memory of rank `r`.
  unsigned char* at(int r, int part) const {
    return copies_[static_cast<std::size_t>(r)].data() + part_ * static_cast<std::size_t>(part);
  }
  /// @throws std::runtime_error unless all ranks have all parts
  void check() const {
    for (int r = 0; r < ranks(); ++r) {
      std::vector<unsigned char> all(part_ * static_cast<std::size_t>(ranks()));
      devices_[r].compute().copy(all.data(), at(r, 0), all.size());
      devices_[r].compute().sync();
      for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i] != mark(static_cast<int>(i / part_)))
          throw std::runtime_error("rank " + std::to_string(r) + " lacks a part");
    }
  }

 private:
  static unsigned char mark(int rank) { return static_cast<unsigned char>(rank + 1); }

  DeviceSet& devices_;
  std::size_t part_;  ///< [bytes]
  std::vector<Buffer<unsigned char>> copies_;
};

/// As PipelinedSolve has it, without products.
void by_queues(const Vectors& v) {
  DeviceSet& devices = v.devices();
  const std::vector<std::vector<Transfer>> queues = work_queues(v.ranks());
  for (std::size_t stage = 0; stage < queues.front().size(); ++stage) {
    std::vector<Event> done;
    for (int r = 0; r < v.ranks(); ++r) {
      const Transfer& t = queues[static_cast<std::size_t>(r)][stage];
      if (t.any()) devices[r].transfer().copy(v.at(r, t.vector), v.at(t.from, t.vector), v.part());
      done.push_back(devices[r].transfer().record());
    }
    for (int r = 1; r < v.ranks(); ++r)
      devices[0].transfer().wait(done[static_cast<std::size_t>(r)]);
    const Event all = devices[0].transfer().record();
    for (int r = 1; r < v.ranks(); ++r) devices[r].transfer().wait(all);
  }
}

void by_copies(const Vectors& v) {
  std::vector<GatherPiece> pieces;
  for (int r = 0; r < v.ranks(); ++r)
    pieces.push_back({v.part() * static_cast<std::size_t>(r), v.part()});
  all_gather(
      v.devices(), pieces, 1, [&](int r) { return v.at(r, r); }, [&](int r) { return v.at(r, 0); });
}

void sync(DeviceSet& devices) {
  for (int r = 0; r < devices.size(); ++r) {
    devices[r].compute().sync();
    devices[r].transfer().sync();
  }
}

void measure(const Vectors& v, const char* way, const std::function<void()>& exchange,
             Json& results) {
  exchange();
  sync(v.devices());
  v.check();
  const double seconds = shortest(5, [&] {
    for (int n = 0; n < chained; ++n) exchange();
    sync(v.devices());
  });
  Json result;
  result.add("ranks", v.ranks()).add("bytes_a_part", static_cast<double>(v.part()));
  result.add("way", way).add("exchange_us", 1e6 * seconds / chained);
  std::cout << result.text() << std::endl;
  results.add(result);
}

#if defined(WEFT_NCCL)
void check_nccl(ncclResult_t result, const char* api) {
  if (result != ncclSuccess)
    throw DeviceError(std::string(api) + ": " + ncclGetErrorString(result));
}

/// Communicators of the GPUs, given back whatever happens.
class Communicators {
 public:
  explicit Communicators(const std::vector<int>& gpus) : all_(gpus.size()) {
    check_nccl(ncclCommInitAll(all_.data(), static_cast<int>(gpus.size()), gpus.data()),
               "ncclCommInitAll");
  }
  Communicators(const Communicators&) = delete;
  Communicators& operator=(const Communicators&) = delete;
  ~Communicators() {
    for (ncclComm_t comm : all_) ncclCommDestroy(comm);
  }
  void gather(const Vectors& v) const {
    check_nccl(ncclGroupStart(), "ncclGroupStart");
    for (int r = 0; r < v.ranks(); ++r)
      check_nccl(ncclAllGather(v.at(r, r), v.at(r, 0), v.part(), ncclUint8,
                               all_[static_cast<std::size_t>(r)],
                               static_cast<CudaQueue&>(v.devices()[r].compute()).stream()),
                 "ncclAllGather");
    check_nccl(ncclGroupEnd(), "ncclGroupEnd");
  }

 private:
  std::vector<ncclComm_t> all_;
};
#endif

void measure_nccl([[maybe_unused]] const std::vector<int>& gpus, [[maybe_unused]] std::size_t rows,
                  [[maybe_unused]] Json& results) {
#if defined(WEFT_NCCL)
  if (std::set<int>(gpus.begin(), gpus.end()).size() < gpus.size()) return;
  DeviceSet devices = cuda_devices(gpus);
  const Communicators communicators(gpus);
  const Vectors v(devices, rows);
  measure(
      v, "nccl", [&] { communicators.gather(v); }, results);
#endif
}

void measure_all(const Options& options) {
  const DeviceText asked = read_device_text(options.device);
  if (asked.backend == Backend::host) {
    std::cout << "runs on CUDA alone; name GPUs with --device cuda:0,1\n";
    return;
  }
  Json results('[');
  for (const int vertices : options.vertices)
    for (std::size_t ranks = 2; ranks <= asked.gpus.size(); ranks *= 2) {
      const std::vector<int> gpus(asked.gpus.begin(),
                                  asked.gpus.begin() + static_cast<std::ptrdiff_t>(ranks));
      const auto rows = static_cast<std::size_t>(vertices);
      for (const bool staged : {true, false}) {
        DeviceSet devices = cuda_devices(gpus);
        const Vectors v(devices, rows);
        measure(
            v, staged ? "queues" : "copies", [&] { staged ? by_queues(v) : by_copies(v); },
            results);
      }
      measure_nccl(gpus, rows, results);
      write(options, "exchange", results);
    }
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  return weft::bench::run(argc, argv, weft::bench::measure_all);
}
