#include "host/app/time_parallel/ordered_frames.hpp"

#include "host/app/time_parallel/slice_sink.hpp"
#include "host/base/file_operations.hpp"
#include "host/scene/origin.hpp"

namespace weft::app {

void OrderedFrames::go_on(const std::function<Frame(Frame)>& change) {
  const std::lock_guard<std::mutex> lock(mutex_);
  while (is_there(DiskSink::frame_file(run_, next_))) {
    KeptFrame kept = read_kept_frame(DiskSink::frame_file(run_, next_));
    kept.frame.origin = origin_of(scene_);
    if (change) kept.frame = change(std::move(kept.frame));
    writer_.write(frame_meshes(scene_, kept.frame, kept.cloth_meshes_in(scene_)), next_++);
  }
}

}  // namespace weft::app
