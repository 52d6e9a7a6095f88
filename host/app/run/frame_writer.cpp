#include "host/app/run/frame_writer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <utility>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/usd/usd_file.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

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
  if (scene_.output.format == FrameFormat::pc2) {
    for (const fs::path& file : directory_.caches()) {
      const io::PointCacheHeader header = io::PointCache(file).header();
      const Index kept = std::clamp(sample_of(header, frame) + 1, 0, header.sample_count);
      io::PointCacheWriter(file, header.point_count, kept);
    }
  }
  if (scene_.output.format != FrameFormat::usda) return;
  if (is_there(directory_.spool()))
    spool_ = std::make_unique<io::SpoolWriter>(directory_.spool(), frame);
  else if (is_there(directory_.animation()))
    import_animation(frame);
  std::error_code error;
  fs::remove(directory_.animation(), error);
  if (error)
    throw SceneError(directory_.animation().string() + ": cannot remove: " + error.message());
}

/// Makes a spool of the animation that a complete run left.
void FrameWriter::import_animation(int last_frame) {
  const io::UsdFile file(directory_.animation());
  std::vector<io::UsdMesh> about;
  for (const auto& prim : file.meshes()) about.push_back({prim.name, prim.obstacle});
  const fs::path unfinished = directory_.frames() / ".animation.usda.spool.tmp";
  {
    io::SpoolWriter writer(unfinished, file.frame_rate(), about, file.origin(0));
    for (const double time : file.times()) {
      if (time > last_frame) break;
      std::vector<Mesh> meshes;
      for (std::size_t m = 0; m < about.size(); ++m) {
        meshes.push_back(file.read(m, time));
        io::move_origin(meshes.back(), file.origin(m), file.origin(0));
      }
      std::vector<const Mesh*> list;
      for (const Mesh& mesh : meshes) list.push_back(&mesh);
      writer.append(static_cast<int>(std::lround(time)), list);
    }
    writer.sync();
  }
  std::error_code error;
  fs::rename(unfinished, directory_.spool(), error);
  if (error) throw SceneError(directory_.spool().string() + ": cannot write: " + error.message());
  spool_ = std::make_unique<io::SpoolWriter>(directory_.spool(), last_frame);
}

void FrameWriter::write(const FrameMeshes& meshes, int number) {
  // First: without it, cloth that rests on a displaced obstacle would be found to intersect.
  directory_.write_displaced(meshes, number);
  switch (scene_.output.format) {
    case FrameFormat::obj:
    case FrameFormat::ply:
      return directory_.write_frame(scene_, meshes, number);
    case FrameFormat::pc2:
      return write_caches(meshes, number);
    case FrameFormat::usda:
      return write_spool(meshes, number);
  }
}

bool FrameWriter::moves(bool obstacle, std::size_t number) const {
  if (!obstacle) return true;
  const Obstacle& o = scene_.obstacles[number];
  return !o.motion.empty() || o.deformation || o.driven;
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
      io::write_obj(topology, {mesh}, io::Normals::vertex);
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
  const auto all = all_of(meshes);
  if (!spool_) {
    std::vector<io::UsdMesh> about;
    for (std::size_t i = 0; i < all.size(); ++i)
      about.push_back({all[i]->name, i >= meshes.cloths.size()});
    spool_ = std::make_unique<io::SpoolWriter>(directory_.spool(), scene_.time.frame_rate, about,
                                               meshes.origin);
  } else if (spool_->last_frame() >= number) {
    spool_ = std::make_unique<io::SpoolWriter>(directory_.spool(), number - 1);
  }
  std::vector<const Mesh*> list;
  for (const io::NamedMesh* mesh : all) list.push_back(&mesh->mesh);
  spool_->append(number, list);
}

void FrameWriter::sync() const {
  for (const auto& cache : caches_)
    if (cache) cache->sync();
  if (spool_) spool_->sync();
}

void FrameWriter::finish(bool complete) {
  if (!spool_ || spool_->last_frame() < 0) return;
  io::write_usd(directory_.animation(), io::SpoolReader(directory_.spool()));
  if (!complete) return;
  spool_.reset();
  std::error_code error;
  fs::remove(directory_.spool(), error);
  if (error) throw SceneError(directory_.spool().string() + ": cannot remove: " + error.message());
}

}  // namespace weft::app
