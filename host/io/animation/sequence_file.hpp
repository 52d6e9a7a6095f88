#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/input/readable_folders.hpp"
#include "host/model/deformation.hpp"

/// Surfaces that somebody else has computed, frame by frame: numbered mesh files, or a mesh and a
/// point cache.
namespace weft::io {

struct SequenceChoice {
  int first = 0;            ///< number of the first file, or sample of the cache, counted from 0
  std::optional<int> last;  ///< included; nothing: as far as there are any without a gap
  double frame_rate = 25;   ///< [1/s]
  bool y_up = false;        ///< of the files; false: z up
  Interpolation interpolation = Interpolation::cubic;
  Playback playback;
};

struct SampledSurface {
  std::shared_ptr<const SampledDeformation> deformation;
  std::vector<Tri> triangles;
};

/// Most memory that the frames of one sequence may take.
inline constexpr double max_sequence_bytes = 8.0 * 1024 * 1024 * 1024;

/// Reads the files that a pattern names, all with the same triangles.
/// @param pattern path whose last part holds %d or %0Nd, such as body_%04d.obj
/// @param folders that all of them must lie below
/// @throws SceneError for a file that is missing or broken, or whose mesh is not that of the first;
///         if the frames take more than max_sequence_bytes
SampledSurface read_mesh_sequence(const std::filesystem::path& pattern,
                                  const SequenceChoice& choice, const ReadableFolders& folders);
/// The same; they lie below the folder of the pattern.
inline SampledSurface read_mesh_sequence(const std::filesystem::path& pattern,
                                         const SequenceChoice& choice) {
  return read_mesh_sequence(pattern, choice, ReadableFolders(pattern));
}

/// Reads an animated USD text file (.usda), whose axes and units are its own. `first` and `last`
/// are numbers of time codes at which it has points.
/// @param choice its frame rate counts, not that of the file
/// @throws SceneError as above
SampledSurface read_usd_sequence(const std::filesystem::path& path, const SequenceChoice& choice);

/// Reads a mesh for its triangles and a point cache (.pc2) for its positions. The first sample that
/// is read is at the start of the clip, whatever start frame the cache names; others follow in
/// steps of its sample rate.
/// @param folders of the files that the mesh names
/// @throws SceneError as above, and if the cache has another number of points
SampledSurface read_point_cache_sequence(const std::filesystem::path& mesh,
                                         const std::filesystem::path& points,
                                         const SequenceChoice& choice,
                                         const ReadableFolders& folders);
/// The same; files that the mesh names lie below its own folder.
inline SampledSurface read_point_cache_sequence(const std::filesystem::path& mesh,
                                                const std::filesystem::path& points,
                                                const SequenceChoice& choice) {
  return read_point_cache_sequence(mesh, points, choice, ReadableFolders(mesh));
}

}  // namespace weft::io
