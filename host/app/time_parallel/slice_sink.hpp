#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "host/app/run/step_log.hpp"
#include "host/time_parallel/material_frame.hpp"
#include "host/time_parallel/slice_run.hpp"

namespace weft::app {

/// Keeps what slices give on the disk: a steps.jsonl a slice, and a file a frame.
class DiskSink : public SliceSink {
 public:
  /// @param run   directory of the slices
  /// @param frame called after each frame that was kept
  explicit DiskSink(std::filesystem::path run, std::function<void()> frame = {});

  void begin(int slice, std::int64_t done, const Energy& energy) override;
  void step(int slice, const StepReport& report, const std::optional<Energy>& energy,
            double wall) override;
  void frame(int slice, const Scene& scene, const Frame& frame) override;
  void sync(int slice) override;

  static std::filesystem::path steps(const std::filesystem::path& run, int slice);
  static std::filesystem::path frame_file(const std::filesystem::path& run, int number);

 private:
  StepLog& log(int slice);

  std::filesystem::path run_;
  std::function<void()> frame_;
  std::mutex mutex_;  ///< of the map
  std::map<int, std::unique_ptr<StepLog>> logs_;
};

/// A frame as DiskSink::frame() keeps it.
struct KeptFrame {
  Frame frame;
  std::vector<Mesh> meshes;  ///< [cloths] of slices that remesh; empty: those of the scene

  /// @param scene whose meshes are meant where there are none
  ClothMeshes cloth_meshes_in(const Scene& scene) const;
};

/// @throws SceneError if it is damaged
KeptFrame read_kept_frame(const std::filesystem::path& file);

}  // namespace weft::app
