#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/base/atomic_file.hpp"
#include "host/scene/sewing.hpp"
#include "host/state/fingerprint.hpp"
#include "host/state/store.hpp"

namespace weft {

/// FNV-1a, 64 bits, over topology, positions and velocities in input order, the contact cache, and
/// the state of driven obstacles.
template <class T>
std::uint64_t hash_state(const Model& model, const StateSnapshot<T>& state);

/// Writes a checkpoint: a header, then named chunks, each with its size and its checksum.
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
/// @param adaptive    bytes of that chunk; empty: none
/// @param fingerprint of the scene as it was read, before refinement and remeshing
/// @throws SceneError if the file cannot be written; an older file then stays unchanged
template <class T>
void write_checkpoint(const std::filesystem::path& file, const Scene& scene, const Model& model,
                      const StateSnapshot<T>& state, const Sewing& sewing,
                      const std::string& adaptive = {}, const Fingerprint& fingerprint = {},
                      Durability durability = Durability::fsync);

/// Whether a file exists and is an undamaged checkpoint, of any scene.
bool whole_checkpoint(const std::filesystem::path& file);

/// Fingerprint of the scene that a checkpoint was written from.
/// @throws SceneError as read_checkpoint
Fingerprint read_fingerprint(const std::filesystem::path& file);

/// Bytes of the chunk "adaptive".
/// @throws SceneError as read_checkpoint
std::string read_adaptive(const std::filesystem::path& file);

/// [m] World place that the positions of a checkpoint are relative to.
/// @throws SceneError as read_checkpoint
Vec3<double> read_origin(const std::filesystem::path& file);

/// How far the checkpoint's scene had been sewn.
/// @param pairs number of seam_pairs of the scene as read
/// @param seams number of its seams
/// @throws SceneError as read_checkpoint
Sewing read_sewing(const std::filesystem::path& file, std::size_t pairs, std::size_t seams);

/// Reads the state from a checkpoint.
/// @param model with the same welded pairs as the model of the checkpoint
/// @param state in: arrays of the right sizes; out: the state of the checkpoint
/// @throws SceneError if the file is damaged or truncated, or of another version, precision or
///         scene; `state` then does not change
template <class T>
void read_checkpoint(const std::filesystem::path& file, const Scene& scene, const Model& model,
                     StateSnapshot<T>& state);

}  // namespace weft
