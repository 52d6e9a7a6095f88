#pragma once

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

namespace weft {

/// GPUs that slices take by turns: each the one that has fewest slices, so that no two slices
/// share a GPU while another one is free. Which GPU a slice gets changes none of its bits.
class GpuPool {
 public:
  GpuPool() = default;
  /// @param GPUs as the system numbers them
  explicit GpuPool(std::vector<int> gpus) : gpus_(std::move(gpus)), slices_(gpus_.size(), 0) {}

  /// A GPU, for as long as this lives.
  class Lease {
   public:
    /// @pre the pool has GPUs, and outlives this
    explicit Lease(GpuPool& pool) : pool_(pool) {
      const std::lock_guard<std::mutex> lock(pool_.mutex_);
      const auto least = std::min_element(pool_.slices_.begin(), pool_.slices_.end());
      place_ = static_cast<std::size_t>(least - pool_.slices_.begin());
      ++pool_.slices_[place_];
    }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    ~Lease() {
      const std::lock_guard<std::mutex> lock(pool_.mutex_);
      --pool_.slices_[place_];
    }
    int gpu() const { return pool_.gpus_[place_]; }

   private:
    GpuPool& pool_;
    std::size_t place_ = 0;
  };

 private:
  std::vector<int> gpus_;
  std::vector<int> slices_;  ///< [GPUs] that have it now
  std::mutex mutex_;
};

}  // namespace weft
