#include "host/app/run/frame_writer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <utility>

#include "host/base/file_operations.hpp"
#include "host/io/gltf/glb_file.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/usd/usd_file.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

/// Number of a frame as a place in a cache that starts at another frame.
Index sample_of(const io::PointCacheHeader& header, int frame) {
  return static_cast<Index>(std::lround((frame - header.start_frame) / header.sample_rate));
}

std::vector<const io::NamedMesh*> all_of(const FrameMeshes& meshes) {
  std::vector<const io::NamedMesh*> all;
  for (const auto& mesh : meshes.cloths) all.push_back(&mesh);
  for (const auto& mesh : meshes.obstacles) all.push_back(&mesh);
  return all;
}

}  // namespace

void FrameWriter::keep_until(int frame) {
  if (only_last()) return directory_.clear_frames();
  if (scene_.output.format == FrameFormat::pc2) {
    for (const fs::path& file : directory_.caches()) {
      const io::PointCacheHeader header = io::PointCache(file).header();
      const Index kept = std::clamp(sample_of(header, frame) + 1, 0, header.sample_count);
      io::PointCacheWriter(file, header.point_count, kept);
    }
  }
  const FrameFormat format = scene_.output.format;
  if (format != FrameFormat::usda && format != FrameFormat::glb) return;
  const fs::path animation = directory_.animation(format);
  const fs::path spool = directory_.spool(format);
  if (is_there(spool))
    spool_ = std::make_unique<io::SpoolWriter>(spool, frame);
  else if (is_there(animation) && format == FrameFormat::usda)
    import_animation(frame);
  else if (is_there(animation))
    throw SceneError(spool.string(), "--resume", "no such file",
                     "the spool beside animation.glb, from which the run goes on");
  remove_file(animation);
}

/// Makes a spool of the animation that a complete run left.
void FrameWriter::import_animation(int last_frame) {
  const fs::path animation = directory_.animation(FrameFormat::usda);
  const fs::path spool = directory_.spool(FrameFormat::usda);
  const io::UsdFile file(animation);
  const auto& prims = file.meshes();
  std::vector<io::SpooledMesh> about;
  for (std::size_t m = 0; m < prims.size(); ++m) {
    Mesh first = file.read(m, file.times().front());
    about.push_back({prims[m].name, prims[m].obstacle, std::move(first.group_names),
                     std::move(first.part_names), std::move(first.part_labels)});
  }
  const fs::path unfinished = directory_.frames() / ".animation.usda.spool.tmp";
  {
    io::SpoolWriter writer(unfinished, file.frame_rate(), about, file.origin(0));
    for (const double time : file.times()) {
      if (time > last_frame) break;
      std::vector<Mesh> meshes;
      std::vector<std::vector<Vec3<double>>> velocities(about.size());
      for (std::size_t m = 0; m < about.size(); ++m) {
        meshes.push_back(file.read(m, time));
        io::move_origin(meshes.back(), file.origin(m), file.origin(0));
        // Those of obstacles are differences, which the next frame changes.
        if (!about[m].obstacle) velocities[m] = file.velocities(m, time);
      }
      std::vector<const Mesh*> list;
      for (const Mesh& mesh : meshes) list.push_back(&mesh);
      writer.append(static_cast<int>(std::lround(time)), list, velocities);
    }
    writer.sync();
  }
  rename_file(unfinished, spool);
  spool_ = std::make_unique<io::SpoolWriter>(spool, last_frame);
}

void FrameWriter::write(const FrameMeshes& meshes, int number) {
  if (!only_last()) return write_now(meshes, number);
  last_ = meshes;
  last_number_ = number;
}

void FrameWriter::write_now(const FrameMeshes& meshes, int number) {
  // First: without it, cloth that rests on a displaced obstacle would be found to intersect.
  directory_.write_displaced(meshes, number);
  switch (scene_.output.format) {
    case FrameFormat::obj:
    case FrameFormat::ply:
      return write_files(meshes, number);
    case FrameFormat::pc2:
      return write_caches(meshes, number);
    case FrameFormat::usda:
    case FrameFormat::glb:
      write_spool(meshes, number);
      return show_so_far();
  }
}

void FrameWriter::write_files(const FrameMeshes& meshes, int number) {
  bool any_moves = false;
  for (std::size_t o = 0; o < scene_.obstacles.size(); ++o) any_moves = any_moves || moves(true, o);
  using Obstacles = RunDirectory::Obstacles;
  directory_.write_frame(scene_, meshes, number,
                         any_moves               ? Obstacles::of_this_frame
                         : with_still_obstacles_ ? Obstacles::none
                                                 : Obstacles::of_all_frames);
  with_still_obstacles_ = true;
}

bool FrameWriter::moves(bool obstacle, std::size_t number) const {
  if (!obstacle) return true;
  const Obstacle& o = scene_.obstacles[number];
  return !o.motion.empty() || o.deformation || o.driven || o.live;
}

void FrameWriter::write_caches(const FrameMeshes& meshes, int number) {
  const auto all = all_of(meshes);
  caches_.resize(all.size());
  // Obstacles first: a cloth frame without its obstacle could not be checked.
  for (std::size_t i = all.size(); i-- > 0;) {
    const bool obstacle = i >= meshes.cloths.size();
    const io::NamedMesh& mesh = *all[i];
    const fs::path topology = directory_.cached_mesh(mesh.name, obstacle);
    const fs::path file = directory_.cache(mesh.name, obstacle);
    auto& cache = caches_[i];
    const bool with_points = moves(obstacle, obstacle ? i - meshes.cloths.size() : i);
    if (!is_there(topology)) {
      io::write_cache_origin(file, meshes.origin);
      io::write_obj(topology, {mesh}, io::Normals::vertex, io::Groups::panels);
    }
    if (!with_points) continue;
    const auto points = static_cast<Index>(mesh.mesh.positions.size());
    if (!cache && is_there(file)) {
      const io::PointCacheHeader header = io::PointCache(file).header();
      cache = std::make_unique<io::PointCacheWriter>(file, points, sample_of(header, number));
    } else if (!cache) {
      io::PointCacheHeader header;
      header.point_count = points;
      header.start_frame = number;
      cache = std::make_unique<io::PointCacheWriter>(file, header);
    } else if (const Index sample = sample_of(cache->header(), number);
               sample != cache->header().sample_count) {
      cache = std::make_unique<io::PointCacheWriter>(file, points, sample);
    }
    cache->append(mesh.mesh.positions);
  }
}

void FrameWriter::write_spool(const FrameMeshes& meshes, int number) {
  const fs::path spool = directory_.spool(scene_.output.format);
  if (!spool_)
    spool_ = std::make_unique<io::SpoolWriter>(spool, scene_.time.frame_rate,
                                               io::spooled_meshes(meshes), meshes.origin);
  else if (spool_->last_frame() >= number)
    spool_ = std::make_unique<io::SpoolWriter>(spool, number - 1);
  spool_->append(number, meshes);
}

/// The file holds all frames, so that each writes it again: as often as this takes little time of
/// the run, and whenever the number of frames has doubled.
void FrameWriter::show_so_far() {
  using std::chrono::steady_clock;
  constexpr int share = 20;  // of the time since the start
  const auto now = steady_clock::now();
  if (!std::has_single_bit(++shown_) && share * writing_ > now - start_) return;
  write_animation();
  writing_ += steady_clock::now() - now;
}

void FrameWriter::write_animation() const {
  const FrameFormat format = scene_.output.format;
  const io::SpoolReader spool(directory_.spool(format));
  if (format == FrameFormat::glb)
    io::write_glb(directory_.animation(format), spool);
  else
    io::write_usd(directory_.animation(format), spool);
}

void FrameWriter::sync() const {
  for (const auto& cache : caches_)
    if (cache) cache->sync();
  if (spool_) spool_->sync();
}

void FrameWriter::finish(bool complete) {
  if (last_) write_now(*last_, last_number_);
  last_.reset();
  if (!spool_ || spool_->last_frame() < 0) return;
  write_animation();
  // weft itself reads the spool of a .glb.
  if (!complete || scene_.output.format != FrameFormat::usda) return;
  spool_.reset();
  remove_file(directory_.spool(FrameFormat::usda));
}

}  // namespace weft::app
