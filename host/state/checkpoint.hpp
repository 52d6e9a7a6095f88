#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/atomic_file.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/state/fingerprint.hpp"
#include "host/state/quiet_frames.hpp"
#include "host/state/store.hpp"

namespace weft {

/// FNV-1a, 64 bits, over topology, positions and velocities in input order, the contact cache, and
/// the state of driven obstacles.
template <class T>
std::uint64_t hash_state(const Model& model, const StateSnapshot<T>& state);

/// The bytes of a checkpoint: a header, then named chunks, each with its size and its checksum.
///   header  "WEFT" version(u32) chunks(u32)
///   chunk   name(16 bytes, zero padded) bytes(u64) FNV-1a of the bytes (u64), the bytes
/// Numbers are little-endian. The chunks are:
/// - "core": time, length of the last step, step number, bytes per number, integrator
/// - "topology": a hash of the scene's meshes and of the internal order
/// - "scene": the Fingerprint; each name and each value ends with a zero byte
/// - "positions", "velocities", "previous_x", "previous_v", "touched": the state in internal order
///   at run precision
/// - "contacts": the contact cache; "face_contacts": how many of its entries are of faces
/// - "sewing", with seams: one byte per pair, then one byte that says whether the scene is refined
/// - "closed_at", with seams: one time per seam, -1 for an open one
/// - "seams_refused", if seams are open: one byte per pair, see Sewing
/// - "adaptive", with an adaptive method: the current meshes
/// - "driven", with driven obstacles: their state
/// - "halved", after a step that did not converge: Backoff
/// - "origin", unless it is (0, 0, 0): the world place that positions are relative to
/// - "sleep_pieces", "sleep_marks", "sleep_marks_2", "sleep_causes", if cloth may sleep: SleepState
/// - "next_step", with steps of automatic length: the length that the next one may have
/// - "live", if the program has set anything while the simulation ran: that
/// - "quiet_frames" and "quiet_since", unless there are none: see QuietFrames
/// @param adaptive    bytes of that chunk; empty: none
/// @param live        the same
/// @param fingerprint of the scene as it was read, before refinement and remeshing
template <class T>
std::string checkpoint_bytes(const Scene& scene, const Model& model, const StateSnapshot<T>& state,
                             const Sewing& sewing, const std::string& adaptive = {},
                             const std::string& live = {}, const Fingerprint& fingerprint = {},
                             const QuietFrames& quiet = {});

/// Writes such bytes to a file.
/// @throws SceneError if it cannot be written; an older file then stays unchanged
template <class T>
void write_checkpoint(const std::filesystem::path& file, const Scene& scene, const Model& model,
                      const StateSnapshot<T>& state, const Sewing& sewing,
                      const std::string& adaptive = {}, const Fingerprint& fingerprint = {},
                      Durability durability = Durability::fsync);

/// The chunks of a checkpoint, whole and undamaged.
class CheckpointReader {
 public:
  /// @throws SceneError if the file is missing, damaged, truncated or of another version
  CheckpointReader(const std::filesystem::path& file);
  /// @param bytes what checkpoint_bytes() has made
  /// @param name  of them, for messages
  CheckpointReader(std::string bytes, std::string name);
  CheckpointReader(const CheckpointReader&) = delete;
  CheckpointReader& operator=(const CheckpointReader&) = delete;

  const std::string& name() const { return name_; }
  bool has(const std::string& chunk) const { return chunks_.contains(chunk); }
  /// Bytes of a chunk of any size. @throws SceneError if there is none; so do the next
  std::string_view bytes_of(const std::string& chunk) const;
  template <class T>
  void get_all(const std::string& chunk, std::vector<T>& to) const;
  /// Copies a chunk of exactly the given size.
  void get(const std::string& chunk, void* to, std::size_t bytes) const;
  template <class T>
  void get(const std::string& chunk, std::vector<T>& to) const {
    get(chunk, to.data(), to.size() * sizeof(T));
  }
  [[noreturn]] void refuse(const std::string& field, const std::string& value,
                           const std::string& allowed) const;

 private:
  void read();
  void take(void* to, std::size_t bytes);
  void read_chunk();

  std::string name_;
  std::string bytes_;
  std::size_t position_ = 0;
  std::map<std::string, std::string_view> chunks_;
};

template <class T>
void CheckpointReader::get_all(const std::string& chunk, std::vector<T>& to) const {
  const std::string_view bytes = bytes_of(chunk);
  if (bytes.size() % sizeof(T) != 0)
    refuse(chunk, "has " + std::to_string(bytes.size()) + " bytes",
           "a multiple of " + std::to_string(sizeof(T)));
  to.resize(bytes.size() / sizeof(T));
  if (!to.empty()) std::memcpy(to.data(), bytes.data(), bytes.size());
}

/// Whether a file exists and is an undamaged checkpoint, of any scene.
bool whole_checkpoint(const std::filesystem::path& file);

/// Fingerprint of the scene that a checkpoint was written from.
/// @throws SceneError if the checkpoint makes no sense
Fingerprint read_fingerprint(const CheckpointReader& in);

/// Bytes of the chunk "adaptive".
/// @throws SceneError if the checkpoint makes no sense
std::string read_adaptive(const CheckpointReader& in);

/// Bytes of the chunk "live"; empty: there is none.
std::string read_live(const CheckpointReader& in);

/// @return no frames if the checkpoint holds none
/// @throws SceneError if the checkpoint makes no sense
QuietFrames read_quiet_frames(const CheckpointReader& in);

/// [m] World place that the positions of a checkpoint are relative to.
/// @throws SceneError if the checkpoint makes no sense
Vec3<double> read_origin(const CheckpointReader& in);

/// How far the checkpoint's scene had been sewn.
/// @param pairs number of seam_pairs of the scene as read
/// @param seams number of its seams
/// @throws SceneError if the checkpoint makes no sense
Sewing read_sewing(const CheckpointReader& in, std::size_t pairs, std::size_t seams);

/// Reads the state from a checkpoint.
/// @param model with the same welded pairs as the model of the checkpoint
/// @param state in: arrays of the right sizes; out: the state of the checkpoint
/// @throws SceneError if it is of another precision or scene; `state` then does not change
template <class T>
void read_checkpoint(const CheckpointReader& in, const Scene& scene, const Model& model,
                     StateSnapshot<T>& state);

}  // namespace weft
