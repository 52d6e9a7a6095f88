#pragma once

#include <filesystem>
#include <functional>
#include <mutex>

#include "host/app/run/frame_writer.hpp"

namespace weft::app {

/// Writes kept frames in the scene's format, in order, as soon as there are all before. Threads may
/// share it.
class OrderedFrames {
 public:
  /// @param directory,scene must outlive this
  OrderedFrames(const RunDirectory& directory, const Scene& scene, std::filesystem::path run)
      : scene_(scene), run_(std::move(run)), writer_(directory, scene) {}

  /// @param change what is done to a frame before it is written
  void go_on(const std::function<Frame(Frame)>& change = {});
  void finish(bool complete) { writer_.finish(complete); }
  int count() const { return next_; }

 private:
  const Scene& scene_;
  std::filesystem::path run_;
  FrameWriter writer_;
  std::mutex mutex_;
  int next_ = 0;
};

}  // namespace weft::app
