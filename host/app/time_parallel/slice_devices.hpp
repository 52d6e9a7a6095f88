#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/exec/device_text.hpp"
#include "host/time_parallel/gpu_pool.hpp"
#include "host/time_parallel/slices.hpp"
#include "weft/devices.hpp"

namespace weft::app {

/// What `--device` says of the slices: each has ranks of its own, or a GPU.
class SliceDevices {
 public:
  explicit SliceDevices(const std::string& asked) : asked_(asked) {
    if (asked == "auto" || asked == "cpu") asked_ = "cpu:1";
    const DeviceSet devices = parse_devices(asked_);
    cuda_ = devices.backend() == Backend::cuda;
    count_ = devices.size();
    if (!cuda_) return;
    std::vector<int> gpus = read_device_text(asked_).gpus;
    gpu_count_ = static_cast<int>(gpus.size());
    gpus_.emplace(std::move(gpus));
  }

  /// Calls work with the devices of one slice, as text for parse_devices(), that are its while it
  /// lasts.
  SliceOutcome with_some(const std::function<SliceOutcome(const std::string& device)>& work) {
    if (!cuda_) return work(asked_);
    const GpuPool::Lease lease(*gpus_);
    return work(fmt::format("cuda:{}", lease.gpu()));
  }
  /// One a core, or one a GPU and one for the coarse run.
  int usual_workers() const {
    if (cuda_) return gpu_count_ + 1;
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / count_);
  }
  const std::string& text() const { return asked_; }

 private:
  std::string asked_;
  bool cuda_ = false;
  int count_ = 1;
  int gpu_count_ = 0;
  std::optional<GpuPool> gpus_;
};

}  // namespace weft::app
