#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/base/atomic_file.hpp"
#include "host/scene/sewing.hpp"
#include "host/state/fingerprint.hpp"
#include "host/state/store.hpp"

namespace weft {

/// FNV-1a, 64 bits, over topology, positions and velocities in input order, and what contacts
/// leave to the next step.
template <class T>
std::uint64_t hash_state(const Model& model, const StateSnapshot<T>& state);

/// Writes a checkpoint: a header, then named chunks, each with its size and its checksum.
///   header  "WEFT" version(u32) chunks(u32)
///   chunk   name(16 bytes, zero padded) bytes(u64) FNV-1a of the bytes (u64), the bytes
/// Chunk "core" has time, step number and history length; "topology" a hash of the scene's meshes
/// and order; "scene" the Fingerprint, names and values each with a zero byte behind; "positions",
/// "velocities", "previous_x", "previous_v", "touched" the state in internal order at run
/// precision; "contacts" what contacts leave to the next step, "face_contacts" how many of them are
/// of faces. With seams, "sewing" has a byte a pair, and one more: refined. With an adaptive method
/// "adaptive" has the meshes as they are now. With driven obstacles "driven" has their state. Where
/// cloth may sleep, "sleep_pieces", "sleep_marks", "sleep_marks_2" and "sleep_causes" have
/// SleepState. Numbers are little-endian.
/// @param adaptive    bytes of that chunk; empty: none
/// @param fingerprint of the scene as it was given, not as it has been refined since
/// @throws SceneError if the file cannot be written; an older file of that name then stays
template <class T>
void write_checkpoint(const std::filesystem::path& file, const Scene& scene, const Model& model,
                      const StateSnapshot<T>& state, const Sewing& sewing,
                      const std::string& adaptive = {}, const Fingerprint& fingerprint = {},
                      Durability durability = Durability::fsync);

/// Whether a file is there and is a checkpoint, of whatever scene, that nothing has damaged.
bool whole_checkpoint(const std::filesystem::path& file);

/// Of the scene that a checkpoint was written from.
/// @throws SceneError as read_checkpoint
Fingerprint read_fingerprint(const std::filesystem::path& file);

/// Bytes of the chunk "adaptive".
/// @throws SceneError as read_checkpoint
std::string read_adaptive(const std::filesystem::path& file);

/// How far the checkpoint's scene had been sewn.
/// @param pairs number of seam_pairs of the scene as read
/// @throws SceneError as read_checkpoint
Sewing read_sewing(const std::filesystem::path& file, std::size_t pairs);

/// @param model as sewn as the checkpoint's
/// @param state in: arrays of the right sizes; out: the checkpoint's
/// @throws SceneError if the file is damaged or truncated, of another version, precision or scene;
///         `state` is then as it was
template <class T>
void read_checkpoint(const std::filesystem::path& file, const Scene& scene, const Model& model,
                     StateSnapshot<T>& state);

}  // namespace weft
