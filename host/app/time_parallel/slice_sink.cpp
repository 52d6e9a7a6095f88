#include "host/app/time_parallel/slice_sink.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Meshes = std::vector<std::vector<Vec3<double>>>;

void put(std::string& bytes, const void* data, std::size_t size) {
  bytes.append(static_cast<const char*>(data), size);
}

template <class T>
void put(std::string& bytes, const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::uint64_t size = values.size();
  put(bytes, &size, sizeof size);
  put(bytes, values.data(), values.size() * sizeof(T));
}

void put(std::string& bytes, const Meshes& meshes) {
  const std::uint64_t count = meshes.size();
  put(bytes, &count, sizeof count);
  for (const auto& points : meshes) put(bytes, points);
}

/// Of the cloths, where a frame may have others than the next.
void put_meshes(std::string& bytes, const Scene& scene) {
  const std::uint64_t count = remeshes(scene) ? scene.cloths.size() : 0;
  put(bytes, &count, sizeof count);
  for (std::uint64_t c = 0; c < count; ++c) {
    const Mesh& mesh = scene.cloths[c].mesh;
    put(bytes, mesh.material);
    put(bytes, mesh.triangles);
    put(bytes, mesh.material_triangles);
  }
}

class Taker {
 public:
  explicit Taker(const fs::path& file) : file_(file.string()), bytes_(bytes_if_readable(file)) {}
  void take(void* to, std::size_t size) {
    if (size > bytes_.size() - at_) refuse();
    if (size == 0) return;  // nor need there be anywhere to copy to
    std::memcpy(to, bytes_.data() + at_, size);
    at_ += size;
  }
  template <class T>
  void take(std::vector<T>& values) {
    std::uint64_t size = 0;
    take(&size, sizeof size);
    if (size > (bytes_.size() - at_) / sizeof(T)) refuse();
    values.resize(size);
    take(values.data(), size * sizeof(T));
  }
  void take(Meshes& meshes) {
    std::uint64_t count = 0;
    take(&count, sizeof count);
    for (std::uint64_t i = 0; i < count; ++i) take(meshes.emplace_back());
  }

  bool at_end() const { return at_ == bytes_.size(); }
  [[noreturn]] void refuse() const {
    throw SceneError(file_, "frame", "damaged", "what the run wrote; run it without --resume");
  }

 private:
  std::string file_;
  std::string bytes_;
  std::size_t at_ = 0;
};

bool all_below(const std::vector<Tri>& triangles, std::size_t count) {
  return std::all_of(triangles.begin(), triangles.end(), [count](const Tri& t) {
    return std::all_of(t.v, t.v + 3,
                       [count](Index v) { return v >= 0 && static_cast<std::size_t>(v) < count; });
  });
}

/// Whether all indices of a mesh are in range.
bool whole(const Mesh& mesh) {
  const bool own = !mesh.material_triangles.empty();
  const std::vector<Tri>& material = own ? mesh.material_triangles : mesh.triangles;
  return material.size() == mesh.triangles.size() &&
         all_below(mesh.triangles, mesh.positions.size()) &&
         all_below(material, mesh.material.size());
}

}  // namespace

DiskSink::DiskSink(fs::path run, std::function<void()> frame)
    : run_(std::move(run)), frame_(std::move(frame)) {
  fs::create_directories(run_ / "frames");
}

fs::path DiskSink::steps(const fs::path& run, int slice) {
  return SliceFiles(run, slice).directory() / "steps.jsonl";
}

fs::path DiskSink::frame_file(const fs::path& run, int number) {
  return run / "frames" / fmt::format("frame_{:05}.bin", number);
}

StepLog& DiskSink::log(int slice) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return *logs_.at(slice);
}

void DiskSink::begin(int slice, std::int64_t done, const Energy&) {
  const fs::path file = steps(run_, slice);
  auto log = std::make_unique<StepLog>(file, read_steps(file, done, [](const StepLine&) {}));
  const std::lock_guard<std::mutex> lock(mutex_);
  logs_[slice] = std::move(log);
}

void DiskSink::step(int slice, const StepReport& report, const std::optional<Energy>& energy,
                    double wall) {
  log(slice).add({report, wall, energy});
  if (report.failure != Failure::none) log(slice).flush();
}

void DiskSink::frame(int slice, const Scene& scene, const Frame& frame) {
  std::string bytes;
  put(bytes, &frame.number, sizeof frame.number);
  put(bytes, &frame.time, sizeof frame.time);
  put(bytes, frame.cloth_positions);
  put(bytes, frame.obstacle_positions);
  put(bytes, frame.displaced_obstacle_positions);
  put_meshes(bytes, scene);
  write_file_atomically(frame_file(run_, frame.number), bytes, Durability::none);
  log(slice).flush();
  if (frame_) frame_();
}

void DiskSink::sync(int slice) {
  log(slice).flush();
  log(slice).sync();
}

ClothMeshes KeptFrame::cloth_meshes_in(const Scene& scene) const {
  return meshes.empty() ? cloth_meshes(scene) : cloth_meshes(meshes);
}

KeptFrame read_kept_frame(const fs::path& file) {
  Taker in(file);
  KeptFrame kept;
  Frame& frame = kept.frame;
  in.take(&frame.number, sizeof frame.number);
  in.take(&frame.time, sizeof frame.time);
  in.take(frame.cloth_positions);
  in.take(frame.obstacle_positions);
  in.take(frame.displaced_obstacle_positions);
  std::uint64_t count = 0;
  in.take(&count, sizeof count);
  if (count != 0 && count != frame.cloth_positions.size()) in.refuse();
  for (std::uint64_t c = 0; c < count; ++c) {
    Mesh& mesh = kept.meshes.emplace_back();
    mesh.positions = frame.cloth_positions[c];
    in.take(mesh.material);
    in.take(mesh.triangles);
    in.take(mesh.material_triangles);
    if (!whole(mesh)) in.refuse();
  }
  if (!in.at_end()) in.refuse();
  return kept;
}

}  // namespace weft::app
