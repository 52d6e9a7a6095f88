#include "host/state/checkpoint.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "host/base/checksum.hpp"
#include "host/base/file_bytes.hpp"
#include "host/input/quantity.hpp"
#include "host/input/safe_text.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/scene/origin.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

static_assert(std::endian::native == std::endian::little,
              "checkpoints are written as they lie in memory");

constexpr std::string_view magic = "WEFT";
/// Of the format. It changes with the minor version of weft, never with the patch version.
constexpr std::uint32_t version = 4;
constexpr std::size_t name_bytes = 16;
/// Stands for the closing time of an open seam.
constexpr double open_seam = -1;

struct Core {
  double time;
  double previous_step;
  std::int64_t step_number;
  std::int32_t scalar_bytes;
  std::int32_t integrator;
};

std::uint64_t hash_topology(const Model& model) {
  Checksum hash;
  hash.add(model.to_input);
  hash.add(model.triangles);
  hash.add(model.material_points);
  return hash.value();
}

/// Which weft wrote a format, for people who have a file and two programs.
std::string writer_of(std::uint32_t format) {
  const std::string number = std::to_string(format);
  if (format < 2) return number + ", of a weft before 0.1.0";
  if (format == 2) return number + ", of weft 0.1.0";
  if (format == 3) return number + ", of a build between weft 0.1.0 and 0.2.0";
  if (format == version) return number + ", of weft 0.2.x";
  return number + ", of a later weft";
}

class Writer {
 public:
  Writer() {
    bytes_ = magic;
    append(&version, sizeof version);
    append(&chunks_, sizeof chunks_);
  }
  void chunk(std::string_view name, const void* data, std::size_t bytes) {
    char padded[name_bytes] = {};
    std::memcpy(padded, name.data(), name.size());
    append(padded, name_bytes);
    const std::uint64_t size = bytes;
    append(&size, sizeof size);
    Checksum hash;
    hash.add(data, bytes);
    const std::uint64_t sum = hash.value();
    append(&sum, sizeof sum);
    append(data, bytes);
    ++chunks_;
  }
  template <class T>
  void chunk(std::string_view name, const std::vector<T>& values) {
    chunk(name, values.data(), values.size() * sizeof(T));
  }
  std::string bytes() && {
    std::memcpy(bytes_.data() + magic.size() + sizeof version, &chunks_, sizeof chunks_);
    return std::move(bytes_);
  }

 private:
  void append(const void* data, std::size_t bytes) {
    bytes_.append(static_cast<const char*>(data), bytes);
  }
  std::string bytes_;
  std::uint32_t chunks_ = 0;
};

template <class T>
void write_sleep(const SleepState<T>& sleep, Writer& out) {
  out.chunk("sleep_pieces", sleep.pieces);
  out.chunk("sleep_marks", sleep.marks[0]);
  out.chunk("sleep_marks_2", sleep.marks[1]);
  out.chunk("sleep_causes", &sleep.causes, sizeof sleep.causes);
}

/// What a run wrote in which components of cloth may sleep; nothing of another run.
template <class T>
SleepState<T> read_sleep(const CheckpointReader& in, std::size_t cloth_vertices,
                         std::int64_t step) {
  SleepState<T> sleep;
  if (!in.has("sleep_pieces")) return sleep;
  in.get_all("sleep_pieces", sleep.pieces);
  for (auto& mark : sleep.marks) mark.resize(cloth_vertices);
  in.get("sleep_marks", sleep.marks[0]);
  in.get("sleep_marks_2", sleep.marks[1]);
  in.get("sleep_causes", &sleep.causes, sizeof sleep.causes);
  for (const SleepComponent& p : sleep.pieces) {
    const bool known = p.excursion >= 0 && p.before >= 0;
    const bool finite = std::isfinite(p.jitter + p.drift + p.bend + p.spent);
    if (!known || !finite || p.jitter < 0 || p.drift < 0 || p.bend < 0 || p.spent < 0 ||
        p.since < -1 || p.since > step)
      in.refuse("sleep_pieces", "has values that cannot be",
                "lengths, and steps that have been taken");
  }
  for (const auto& mark : sleep.marks)
    for (const Vec3<T>& x : mark)
      if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
        in.refuse("sleep_marks", "has values that are not finite", "finite numbers");
  return sleep;
}

/// A checksum says that nothing was damaged, not that there ever was sense in it.
template <class T>
void check_values(const CheckpointReader& in, const TimeSettings& time,
                  const StateSnapshot<T>& state) {
  const auto not_negative = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!not_negative(state.time) || !not_negative(state.previous_step) || state.step_number < 0)
    in.refuse("core", "has a time that cannot be", "a finite time, no step or number below 0");
  const std::int64_t steps_max =
      std::numeric_limits<int>::max() * static_cast<std::int64_t>(most_frame_steps(time));
  if (state.step_number > steps_max)
    in.refuse("core", "has step " + std::to_string(state.step_number),
              "up to " + std::to_string(steps_max));
  if (time.automatic && !(state.time * time.frame_rate < std::numeric_limits<int>::max()))
    in.refuse("core", "has the time " + std::to_string(state.time), "that of a frame");
  if (!not_negative(state.next_step))
    in.refuse("next_step", "has a length that cannot be", "a finite time, not below 0");
  if (state.backoff.left < 0 || state.backoff.left > state.backoff.run ||
      state.backoff.run > Backoff::run_max || state.backoff.truncated < 0 ||
      state.backoff.stretched < 0 || state.backoff.stretched > Backoff::run_max)
    in.refuse("halved", "has numbers that cannot be",
              "0 to " + std::to_string(Backoff::run_max) +
                  ", none left beyond the run, no number below 0");
  const std::pair<const char*, const std::vector<Vec3<T>>*> arrays[] = {
      {"positions", &state.positions},
      {"velocities", &state.velocities},
      {"previous_x", &state.previous_positions},
      {"previous_v", &state.previous_velocities}};
  for (const auto& [name, values] : arrays)
    for (const Vec3<T>& x : *values)
      if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
        in.refuse(name, "has values that are not finite", "finite numbers");
  for (const double value : state.driven)
    if (!std::isfinite(value))
      in.refuse("driven", "has values that are not finite", "finite numbers");
  if (state.face_contacts < 0 ||
      static_cast<std::uint64_t>(state.face_contacts) > state.contacts.size())
    in.refuse("face_contacts", std::to_string(state.face_contacts),
              "0 to " + std::to_string(state.contacts.size()));
  for (const ContactMemory<T>& c : state.contacts)
    if (!std::isfinite(c.normal_force + c.load + c.sticking_force + dot(c.friction, c.friction) +
                       dot(c.n, c.n)))
      in.refuse("contacts", "has values that are not finite", "finite numbers");
}

}  // namespace

template <class T>
std::uint64_t hash_state(const Model& model, const StateSnapshot<T>& state) {
  Checksum hash;
  for (Index t = 0; t < model.cloth_triangle_count; ++t)
    for (const Index v : model.triangles[static_cast<std::size_t>(t)].v) {
      const Index input = model.to_input[static_cast<std::size_t>(v)];
      hash.add(&input, sizeof input);
    }
  for (const Index v : model.to_internal) {
    const Vec3<T>& x = state.positions[static_cast<std::size_t>(v)];
    const Vec3<T>& u = state.velocities[static_cast<std::size_t>(v)];
    hash.add(x.e, sizeof x.e);
    hash.add(u.e, sizeof u.e);
  }
  for (const ContactMemory<T>& c : state.contacts) {
    hash.add(&c.normal_force, sizeof c.normal_force);
    hash.add(&c.load, sizeof c.load);
    hash.add(c.friction.e, sizeof c.friction.e);
  }
  hash.add(state.driven);
  return hash.value();
}

template <class T>
std::string checkpoint_bytes(const Scene& scene, const Model& model, const StateSnapshot<T>& state,
                             const Sewing& sewing, const std::string& adaptive,
                             const std::string& live, const Fingerprint& fingerprint,
                             const QuietFrames& quiet) {
  const std::string scene_parts = fingerprint_bytes(fingerprint);
  Writer out;
  const Core core{state.time, state.previous_step, state.step_number, sizeof(T),
                  static_cast<std::int32_t>(scene.integrator)};
  const std::uint64_t topology = hash_topology(model);
  out.chunk("core", &core, sizeof core);
  out.chunk("topology", &topology, sizeof topology);
  out.chunk("scene", scene_parts.data(), scene_parts.size());
  out.chunk("positions", state.positions);
  out.chunk("velocities", state.velocities);
  out.chunk("previous_x", state.previous_positions);
  out.chunk("previous_v", state.previous_velocities);
  out.chunk("touched", state.touched);
  out.chunk("contacts", state.contacts);
  out.chunk("face_contacts", &state.face_contacts, sizeof state.face_contacts);
  if (!sewing.welded.empty()) {
    std::vector<unsigned char> bytes = sewing.welded;
    bytes.push_back(sewing.refined ? 1 : 0);
    out.chunk("sewing", bytes);
    std::vector<double> closed_at;
    for (const std::optional<double>& time : sewing.closed_at)
      closed_at.push_back(time.value_or(open_seam));
    out.chunk("closed_at", closed_at);
  }
  if (const Vec3<double> origin = origin_of(scene); origin != Vec3<double>{0, 0, 0})
    out.chunk("origin", origin.e, sizeof origin.e);
  if (!sewing.refused.empty()) out.chunk("seams_refused", sewing.refused);
  if (!state.driven.empty()) out.chunk("driven", state.driven);
  if (state.backoff != Backoff{}) out.chunk("halved", &state.backoff, sizeof state.backoff);
  if (!state.sleep.pieces.empty()) write_sleep(state.sleep, out);
  if (scene.time.automatic) out.chunk("next_step", &state.next_step, sizeof state.next_step);
  if (!adaptive.empty()) out.chunk("adaptive", adaptive.data(), adaptive.size());
  if (!live.empty()) out.chunk("live", live.data(), live.size());
  if (quiet.count > 0) {
    out.chunk("quiet_frames", &quiet.count, sizeof quiet.count);
    out.chunk("quiet_since", quiet.since);
  }
  return std::move(out).bytes();
}

template <class T>
void write_checkpoint(const std::filesystem::path& file, const Scene& scene, const Model& model,
                      const StateSnapshot<T>& state, const Sewing& sewing,
                      const std::string& adaptive, const Fingerprint& fingerprint,
                      Durability durability) {
  write_file_atomically(
      file, checkpoint_bytes(scene, model, state, sewing, adaptive, {}, fingerprint), durability);
}

CheckpointReader::CheckpointReader(const std::filesystem::path& file) : name_(file.string()) {
  bytes_ = read_file_bytes(file);
  read();
}

CheckpointReader::CheckpointReader(std::string bytes, std::string name)
    : name_(std::move(name)), bytes_(std::move(bytes)) {
  read();
}

void CheckpointReader::read() {
  if (!bytes_.starts_with(magic))
    refuse("header", "does not begin with WEFT", "a checkpoint of weft");
  std::uint32_t found_version = 0;
  std::uint32_t chunks = 0;
  position_ = magic.size();
  take(&found_version, sizeof found_version);
  if (found_version != version) refuse("version", writer_of(found_version), writer_of(version));
  take(&chunks, sizeof chunks);
  for (std::uint32_t c = 0; c < chunks; ++c) read_chunk();
  if (position_ != bytes_.size()) refuse("end", "has bytes after the last chunk", "nothing there");
}

std::string_view CheckpointReader::bytes_of(const std::string& chunk) const {
  const auto found = chunks_.find(chunk);
  if (found == chunks_.end()) refuse(chunk, "is missing", "all chunks");
  return found->second;
}

void CheckpointReader::get(const std::string& chunk, void* to, std::size_t bytes) const {
  const std::string_view found = bytes_of(chunk);
  if (found.size() != bytes)
    refuse(chunk, "has " + std::to_string(found.size()) + " bytes",
           std::to_string(bytes) + ", as this scene and its precision have");
  if (bytes > 0) std::memcpy(to, found.data(), bytes);
}

void CheckpointReader::refuse(const std::string& field, const std::string& value,
                              const std::string& allowed) const {
  throw SceneError(name_, "checkpoint " + field, value, allowed);
}

void CheckpointReader::take(void* to, std::size_t bytes) {
  if (bytes > bytes_.size() - position_) refuse("size", "is truncated", "a whole file");
  if (bytes > 0) std::memcpy(to, bytes_.data() + position_, bytes);
  position_ += bytes;
}

void CheckpointReader::read_chunk() {
  char name[name_bytes + 1] = {};
  std::uint64_t size = 0;
  std::uint64_t sum = 0;
  take(name, name_bytes);
  const std::string shown = "chunk " + quoted_start(name);
  if (std::any_of(name + std::strlen(name), name + name_bytes, [](char c) { return c != 0; }))
    refuse(shown, "has more behind its name", "zeros there");
  take(&size, sizeof size);
  take(&sum, sizeof sum);
  if (size > bytes_.size() - position_) refuse(shown, "is truncated", "a whole file");
  const std::string_view data = std::string_view(bytes_).substr(position_, size);
  position_ += size;
  Checksum hash;
  hash.add(data.data(), data.size());
  if (hash.value() != sum) refuse(shown, "has a wrong checksum", "an undamaged file");
  if (!chunks_.emplace(name, data).second) refuse(shown, "is given twice", "each chunk once");
}

bool whole_checkpoint(const std::filesystem::path& file) {
  try {
    CheckpointReader{file};
    return true;
  } catch (const SceneError&) {
    return false;
  }
}

Vec3<double> read_origin(const CheckpointReader& in) {
  Vec3<double> origin{0, 0, 0};
  if (!in.has("origin")) return origin;
  in.get("origin", origin.e, sizeof origin.e);
  for (int k = 0; k < 3; ++k)
    if (!quantity::coordinate.holds(origin[k]))
      in.refuse("origin", "has a value that cannot be", quantity::coordinate.allowed());
  return origin;
}

Sewing read_sewing(const CheckpointReader& in, std::size_t pairs, std::size_t seams) {
  if (pairs == 0) return {};
  std::vector<unsigned char> bytes(pairs + 1);
  in.get("sewing", bytes);
  if (std::any_of(bytes.begin(), bytes.end(), [](unsigned char b) { return b > 1; }))
    in.refuse("sewing", "has something else", "0 or 1 for each pair");
  Sewing sewing{{bytes.begin(), bytes.end() - 1}, bytes.back() != 0, {}, {}};
  if (in.has("seams_refused")) {
    sewing.refused.resize(pairs);
    in.get("seams_refused", sewing.refused);
  }
  std::vector<double> closed_at(seams);
  in.get("closed_at", closed_at);
  for (const double time : closed_at) {
    if (time != open_seam && !(std::isfinite(time) && time >= 0))
      in.refuse("closed_at", "has something else", "times >= 0, or -1 for an open seam");
    sewing.closed_at.push_back(time == open_seam ? std::nullopt : std::optional(time));
  }
  return sewing;
}

std::string read_adaptive(const CheckpointReader& in) {
  return std::string(in.bytes_of("adaptive"));
}

QuietFrames read_quiet_frames(const CheckpointReader& in) {
  QuietFrames quiet;
  if (!in.has("quiet_since")) return quiet;
  in.get("quiet_frames", &quiet.count, sizeof quiet.count);
  if (quiet.count < 0) in.refuse("quiet_frames", std::to_string(quiet.count), "0 or more");
  in.get_all("quiet_since", quiet.since);
  for (const Vec3<double>& x : quiet.since)
    if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
      in.refuse("quiet_since", "has values that are not finite", "finite numbers");
  return quiet;
}

std::string read_live(const CheckpointReader& in) {
  return in.has("live") ? std::string(in.bytes_of("live")) : std::string();
}

Fingerprint read_fingerprint(const CheckpointReader& in) {
  Fingerprint fingerprint;
  if (!fingerprint_from(std::string(in.bytes_of("scene")), fingerprint))
    in.refuse("scene", "is no list of names and values", "what weft has written");
  return fingerprint;
}

template <class T>
void read_checkpoint(const CheckpointReader& in, const Scene& scene, const Model& model,
                     StateSnapshot<T>& state) {
  Core core;
  std::uint64_t topology = 0;
  in.get("core", &core, sizeof core);
  in.get("topology", &topology, sizeof topology);
  if (core.scalar_bytes != static_cast<std::int32_t>(sizeof(T)))
    in.refuse("precision", core.scalar_bytes == 4 ? "float" : "double",
              sizeof(T) == 4 ? "float" : "double");
  if (core.integrator != static_cast<std::int32_t>(scene.integrator))
    in.refuse("integrator", "differs", "the integrator that it was written with");
  if (topology != hash_topology(model))
    in.refuse("topology", "belongs to another scene", "the scene that it was written from");
  StateSnapshot<T> loaded = state;
  loaded.time = core.time;
  loaded.previous_step = core.previous_step;
  loaded.step_number = core.step_number;
  in.get("positions", loaded.positions);
  in.get("velocities", loaded.velocities);
  in.get("previous_x", loaded.previous_positions);
  in.get("previous_v", loaded.previous_velocities);
  in.get("touched", loaded.touched);
  in.get_all("contacts", loaded.contacts);
  in.get("face_contacts", &loaded.face_contacts, sizeof loaded.face_contacts);
  if (!loaded.driven.empty()) in.get("driven", loaded.driven);
  loaded.backoff = {};
  if (in.has("halved")) in.get("halved", &loaded.backoff, sizeof loaded.backoff);
  loaded.sleep = {};
  if (scene.implicit.sleep_distance > 0)
    loaded.sleep = read_sleep<T>(in, loaded.velocities.size(), loaded.step_number);
  loaded.next_step = 0;
  if (scene.time.automatic && in.has("next_step"))
    in.get("next_step", &loaded.next_step, sizeof loaded.next_step);
  check_values(in, scene.time, loaded);
  state = std::move(loaded);
}

template std::uint64_t hash_state(const Model&, const StateSnapshot<float>&);
template std::uint64_t hash_state(const Model&, const StateSnapshot<double>&);
template std::string checkpoint_bytes(const Scene&, const Model&, const StateSnapshot<float>&,
                                      const Sewing&, const std::string&, const std::string&,
                                      const Fingerprint&, const QuietFrames&);
template std::string checkpoint_bytes(const Scene&, const Model&, const StateSnapshot<double>&,
                                      const Sewing&, const std::string&, const std::string&,
                                      const Fingerprint&, const QuietFrames&);
template void read_checkpoint(const CheckpointReader&, const Scene&, const Model&,
                              StateSnapshot<float>&);
template void read_checkpoint(const CheckpointReader&, const Scene&, const Model&,
                              StateSnapshot<double>&);

template void write_checkpoint(const std::filesystem::path&, const Scene&, const Model&,
                               const StateSnapshot<float>&, const Sewing&, const std::string&,
                               const Fingerprint&, Durability);
template void write_checkpoint(const std::filesystem::path&, const Scene&, const Model&,
                               const StateSnapshot<double>&, const Sewing&, const std::string&,
                               const Fingerprint&, Durability);

}  // namespace weft
