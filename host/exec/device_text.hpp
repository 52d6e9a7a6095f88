#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "weft/exec/device.hpp"

namespace weft {

/// What a text such as "cuda:0,1" asks for.
struct DeviceText {
  bool automatic = false;  ///< "auto": whoever knows the scene decides
  Backend backend = Backend::host;
  int host_ranks = 0;     ///< 0: one a core
  std::vector<int> gpus;  ///< [ranks] with CUDA

  /// As written out in reports: "auto", "cpu:2" or "cuda:0,1".
  std::string text() const;
};

/// What may be asked for, for messages.
constexpr const char* device_texts = "auto, cpu, cpu:N (1 <= N <= 64), cuda, cuda:0,1";

/// Whether read_device_text() takes it.
bool is_device_text(std::string_view text);

/// @throws SceneError naming the field `device` if the text is none of "auto", "cpu", "cpu:N",
///         "cuda", "cuda:0,1"
DeviceText read_device_text(std::string_view text);

constexpr int max_host_ranks = 64;

/// A rank a core, up to as many as there may be.
int usual_host_ranks();

/// cuda:0,1,..,count - 1
std::string first_gpus_text(int count);

}  // namespace weft
