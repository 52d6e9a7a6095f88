#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/spool/frame_spool.hpp"
#include "host/io/usd/usd_placement.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// Writes an animated USD text file (.usda) from a spool: a Mesh per cloth under /World/cloths, one
/// per obstacle under /World/obstacles; metres, z up, time codes are frame numbers. Points,
/// normals, velocities and extents are time samples unless the mesh never moves; topology and
/// texture coordinates (primvars:st) only where they change. Groups are materials under
/// /World/materials; a mesh with several of them or several parts has a GeomSubset for each. An
/// origin of the spool is a translation of /World. Holds one mesh at a time. Written beside the
/// target, then renamed.
/// @throws SceneError if the spool has no frames or is damaged, or the file cannot be written
void write_usd(const std::filesystem::path& path, const SpoolReader& spool);

/// A file in memory that the system reads where it is looked at.
class MappedFile {
 public:
  /// @throws SceneError naming the file and the reason if it is missing, no regular file, or cannot
  ///         be read
  explicit MappedFile(const std::filesystem::path& path);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();
  std::string_view bytes() const { return {static_cast<const char*>(data_), size_}; }

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Text of a value at an instant.
struct UsdSample {
  double time = 0;  ///< time code
  std::string_view value;
};

/// Values of an attribute, in increasing time; one without time samples has a single entry.
struct UsdAttribute {
  bool timed = false;
  std::vector<UsdSample> samples;

  /// The value that holds at `time`: that of the last sample up to it, or of the first.
  /// @pre there is a sample
  std::string_view at(double time) const;
};

/// To which material and part faces belong.
struct UsdLabel {
  std::string
      material;       ///< weft:material, or the last part of the path that is bound; may be empty
  std::string part;   ///< weft:part, or the name of a subset of another program; may be empty
  std::string panel;  ///< weft:label, of a panel; may be empty
};

/// A GeomSubset of a mesh.
struct UsdSubset {
  UsdLabel label{};
  UsdAttribute indices;
};

/// A Mesh prim.
struct UsdMeshPrim {
  std::string path;  ///< "/World/cloths/shirt"
  std::string name;  ///< its weft:name if it has one, otherwise the last part of its path
  bool obstacle = false;
  bool left_handed = false;
  bool st_face_varying = false;
  /// By the transforms of the prim and of those around it; in units and axes of the file.
  UsdPlacement placement{};
  UsdAttribute points, counts, indices, st, st_indices, velocities;
  UsdLabel label{};                  ///< of all faces that are in no subset
  std::vector<UsdSubset> subsets{};  ///< of its faces
};

/// What a text file says about its frames as a whole.
struct UsdStage {
  double time_codes_per_second = 24;
  double meters_per_unit = 0.01;
  bool y_up = true;       ///< as USD has it unless the file says otherwise
  bool skeleton = false;  ///< bones move some of it, which nobody reads
  std::vector<UsdMeshPrim> meshes;
};

/// Finds the meshes of a USD text file; values are checked when they are read.
/// @param file for messages
/// @return its views look into `bytes`
/// @throws SceneError for what breaks the syntax, and for transforms of prims that change
UsdStage parse_usd(std::string_view bytes, const std::string& file);

/// Reads animated meshes from USD text files: what write_usd() writes, and files of other programs
/// as far as they are plain meshes without references, variants and transforms that change. Frames
/// are read when they are asked for. Safe to use from several threads at once.
class UsdFile {
 public:
  /// @throws SceneError if the file is missing or damaged, or has no mesh
  explicit UsdFile(const std::filesystem::path& path);

  double frame_rate() const { return stage_.time_codes_per_second; }  ///< [1/s]
  const std::vector<UsdMeshPrim>& meshes() const { return stage_.meshes; }
  bool has_skeleton() const { return stage_.skeleton; }  ///< of UsdSkel, which is passed over

  /// Time codes at which any mesh has points, increasing; at least one.
  const std::vector<double>& times() const { return times_; }

  /// [m] world place that the points of a mesh are relative to
  Vec3<double> origin(std::size_t mesh) const;

  /// A mesh as it is at a time code, in metres with z up, relative to origin(). Polygons become
  /// fans. Groups are materials, parts those of weft or the subsets of another program.
  /// @param mesh place among meshes()
  /// @throws SceneError naming prim and attribute for what is missing, not finite or out of range
  Mesh read(std::size_t mesh, double time, Uv uv = Uv::material) const;

  /// @return [vertices] [m/s] empty: the file has none
  /// @throws SceneError as read()
  std::vector<Vec3<double>> velocities(std::size_t mesh, double time) const;

 private:
  Vec3<double> in_metres(Vec3<double> x) const;

  std::string file_;
  std::unique_ptr<MappedFile> mapped_;
  UsdStage stage_;
  std::vector<double> times_;
};

}  // namespace weft::io
