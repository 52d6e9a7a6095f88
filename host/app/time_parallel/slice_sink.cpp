#include "host/app/time_parallel/slice_sink.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "host/base/atomic_file.hpp"
#include "host/base/bytes.hpp"
#include "host/base/file_bytes.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

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
  Packer packer;
  packer.put(frame.number);
  packer.put(frame.time);
  packer.put(frame.cloth_positions);
  packer.put(frame.obstacle_positions);
  packer.put(frame.displaced_obstacle_positions);
  // Where a frame may have others than the next.
  const std::uint64_t meshes = remeshes(scene) ? scene.cloths.size() : 0;
  packer.put(meshes);
  for (std::uint64_t c = 0; c < meshes; ++c) {
    const Mesh& mesh = scene.cloths[c].mesh;
    packer.put(mesh.material);
    packer.put(mesh.triangles);
    packer.put(mesh.material_triangles);
  }
  write_file_atomically(frame_file(run_, frame.number), packer.bytes, Durability::none);
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
  const std::string bytes = bytes_if_readable(file);
  Unpacker in(bytes, file.string(), "frame", "what the run wrote; run it without --resume");
  KeptFrame kept;
  Frame& frame = kept.frame;
  in.get(frame.number);
  in.get(frame.time);
  in.get(frame.cloth_positions);
  in.get(frame.obstacle_positions);
  in.get(frame.displaced_obstacle_positions);
  std::uint64_t count = 0;
  in.get(count);
  if (count != 0 && count != frame.cloth_positions.size()) in.refuse("damaged");
  for (std::uint64_t c = 0; c < count; ++c) {
    Mesh& mesh = kept.meshes.emplace_back();
    mesh.positions = frame.cloth_positions[c];
    in.get(mesh.material);
    in.get(mesh.triangles);
    in.get(mesh.material_triangles);
    if (!whole(mesh)) in.refuse("damaged");
  }
  in.end();
  return kept;
}

}  // namespace weft::app
