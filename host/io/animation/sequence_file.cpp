#include "host/io/animation/sequence_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <system_error>

#include "host/base/file_operations.hpp"
#include "host/geometry/local_origin.hpp"
#include "host/input/counted.hpp"
#include "host/input/quantity.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "host/io/usd/surface_file.hpp"
#include "host/model/skinning.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

bool same_triangles(const std::vector<Tri>& a, const std::vector<Tri>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Tri& s, const Tri& t) { return std::equal(s.v, s.v + 3, t.v); });
}

void add_frame(SampledDeformation& deformation, double time, std::vector<Vec3<double>>& positions,
               const SequenceChoice& choice) {
  const Affine to_world = axes_to_world(choice.y_up, 1);
  for (Vec3<double>& x : positions) x = to_world(x);
  deformation.add_frame(time, Span<const Vec3<double>>(positions.data(), positions.size()));
}

/// @param frames how many there are to be
void refuse_size(const std::string& file, std::size_t vertices, double frames) {
  const double bytes = SampledDeformation::bytes_of(vertices, 1) * frames;
  if (bytes <= max_sequence_bytes) return;
  throw SceneError(
      file, "sequence",
      counted(static_cast<long long>(frames), "frame") + " of " + counted(vertices, "vertex") +
          ", " + std::to_string(static_cast<long long>(bytes / (1 << 20))) + " MiB",
      "up to " + std::to_string(static_cast<long long>(max_sequence_bytes / (1 << 20))) + " MiB");
}

/// In units of the file, which the obstacle may scale down.
constexpr double most_coordinate = 1e12;

void refuse_far(const std::string& file, int frame, const std::vector<Vec3<double>>& positions) {
  for (std::size_t v = 0; v < positions.size(); ++v)
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(positions[v][k]) <= most_coordinate))
        throw SceneError(file, "frame " + std::to_string(frame) + ": vertex " + std::to_string(v),
                         short_number(positions[v][k]), "coordinates from -1e12 to 1e12");
}

}  // namespace

SampledSurface read_mesh_sequence(const fs::path& pattern, const SequenceChoice& choice,
                                  const ReadableFolders& folders) {
  const NumberedName name(pattern.filename().string());
  if (!name.has_place())
    throw SceneError(pattern.string(), "files", "no place for a number",
                     "a name such as body_%04d.obj");
  const int last = choice.last.value_or(std::numeric_limits<int>::max() - 1);
  auto deformation = std::make_shared<SampledDeformation>(choice.interpolation, choice.playback);
  SampledSurface surface;
  for (int number = choice.first; number <= last; ++number) {
    const fs::path path = pattern.parent_path() / name.with(number);
    if (!choice.last && number > choice.first && !is_there(path)) break;
    folders.require(path, pattern.string(), "files");
    Mesh mesh = read_surface(path, Uv::ignore, folders);
    const auto frame = static_cast<double>(number - choice.first);
    if (number == choice.first) {
      surface.triangles = mesh.triangles;
      if (choice.last) refuse_size(pattern.string(), mesh.positions.size(), 1.0 + last - number);
    } else if (mesh.positions.size() != deformation->vertex_count() ||
               !same_triangles(mesh.triangles, surface.triangles)) {
      throw SceneError(path.string(), "mesh",
                       counted(mesh.positions.size(), "vertex") + " and " +
                           counted(mesh.triangles.size(), "triangle"),
                       "the same mesh in every frame, here with " +
                           counted(deformation->vertex_count(), "vertex") + " and the " +
                           counted(surface.triangles.size(), "triangle") + " of " +
                           name.with(choice.first));
    }
    refuse_size(pattern.string(), mesh.positions.size(), frame + 1);
    refuse_far(path.string(), number, mesh.positions);
    add_frame(*deformation, frame / choice.frame_rate, mesh.positions, choice);
  }
  surface.deformation = std::move(deformation);
  return surface;
}

SampledSurface read_usd_sequence(const fs::path& path, const SequenceChoice& choice) {
  const UsdFile file(path);
  if (file.has_skeleton() && file.times().size() == 1)
    throw SceneError(path.string(), "points", "moved by a skeleton",
                     "points at several time codes: have the program that writes the file bake the "
                     "motion into them");
  const auto count = static_cast<int>(file.times().size());
  const int last = choice.last.value_or(count - 1);
  if (choice.first > last || last >= count)
    throw SceneError(path.string(), "first, last",
                     std::to_string(choice.first) + " to " + std::to_string(last),
                     "time codes of the file, which has " + std::to_string(count));
  SequenceChoice as_it_is = choice;
  as_it_is.y_up = false;
  auto deformation = std::make_shared<SampledDeformation>(choice.interpolation, choice.playback);
  SampledSurface surface;
  const auto time_of = [&](int k) { return file.times()[static_cast<std::size_t>(k)]; };
  for (int k = choice.first; k <= last; ++k) {
    Mesh mesh = surface_at(file, time_of(k), Uv::ignore);
    if (k == choice.first) {
      surface.triangles = mesh.triangles;
      refuse_size(path.string(), mesh.positions.size(), 1.0 + last - k);
    } else if (mesh.positions.size() != deformation->vertex_count() ||
               !same_triangles(mesh.triangles, surface.triangles)) {
      throw SceneError(path.string(), "time code " + short_number(time_of(k)),
                       counted(mesh.positions.size(), "vertex") + " and " +
                           counted(mesh.triangles.size(), "triangle"),
                       "the same mesh at all time codes");
    }
    refuse_far(path.string(), k, mesh.positions);
    add_frame(*deformation, (time_of(k) - time_of(choice.first)) / choice.frame_rate,
              mesh.positions, as_it_is);
  }
  surface.deformation = std::move(deformation);
  return surface;
}

SampledSurface read_point_cache_sequence(const fs::path& mesh_path, const fs::path& points,
                                         const SequenceChoice& choice,
                                         const ReadableFolders& folders) {
  const Mesh mesh = read_surface(mesh_path, Uv::ignore, folders);
  const PointCache cache(points);
  if (is_there(cache_origin_file(points)))
    folders.require(cache_origin_file(points), points.string(), "origin");
  const Vec3<double> origin = read_cache_origin(points);
  if (!std::cmp_equal(cache.point_count(), mesh.positions.size()))
    throw SceneError(
        points.string(), "points", std::to_string(cache.point_count()),
        std::to_string(mesh.positions.size()) + ", the vertices of " + mesh_path.string());
  const int last = choice.last.value_or(cache.sample_count() - 1);
  if (choice.first > last || last >= cache.sample_count())
    throw SceneError(points.string(), "first, last",
                     std::to_string(choice.first) + " to " + std::to_string(last),
                     "samples of the file, which has " + std::to_string(cache.sample_count()));
  refuse_size(points.string(), mesh.positions.size(), 1.0 + last - choice.first);
  auto deformation = std::make_shared<SampledDeformation>(choice.interpolation, choice.playback);
  std::vector<Vec3<double>> positions(mesh.positions.size());
  for (int sample = choice.first; sample <= last; ++sample) {
    cache.read(sample, positions);
    move_origin(positions, origin, {0, 0, 0});
    refuse_far(points.string(), sample, positions);
    add_frame(*deformation,
              (sample - choice.first) * cache.header().sample_rate / choice.frame_rate, positions,
              choice);
  }
  return {std::move(deformation), mesh.triangles};
}

}  // namespace weft::io
