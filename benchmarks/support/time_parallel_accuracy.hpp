#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "benchmarks/support/averaged_states.hpp"
#include "benchmarks/support/time_parallel_json.hpp"
#include "benchmarks/support/time_parallel_runs.hpp"
#include "host/base/scratch_folder.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

/// How near to the serial run slices start.
namespace weft::bench {

/// A folder that goes with the object.
struct Folder {
  ScratchFolder scratch;
  std::filesystem::path path = scratch.path();
  /// Empty, beside the states of earlier ones.
  std::filesystem::path fresh(const std::string& name) const {
    std::filesystem::remove_all(path / name);
    std::filesystem::create_directories(path / name);
    return path / name;
  }
};

/// Starts of slices, before and after recovery, against the serial run (Table 4): on the meshes of
/// the starts, to which the serial run's states are brought where slices remesh.
class Accuracy {
 public:
  Accuracy(const Level& level, const Folder& folder)
      : level_(level),
        folder_(folder),
        fine_(level.scene->fine()),
        reader_(fine_, host_devices(1)) {}

  /// @param twin state of a serial run from a start next to it; null: none
  Json at(std::int64_t coarse_step, const KeptState* twin) {
    const std::int64_t step = fine_step(coarse_step);
    const auto found = level_.fine->kept.find(step);
    if (found == level_.fine->kept.end()) return nullptr;
    const KeptState& wanted = found->second;
    Json json{{"step", step}, {"time_s", wanted.frame.time}};
    const std::filesystem::path coarse = folder_.path / "coarse";
    json["before"] = start(coarse, step, 0, wanted);
    json["after"] = start(coarse, step, -1, wanted);
    const auto before = level_.fine->kept.find(fine_step(coarse_step - 1));
    if (before != level_.fine->kept.end() && meshes_stay()) {
      const std::filesystem::path ideal = folder_.fresh("averages");
      const AveragedStates averages(fine_, level_.scene->coarse());
      averages.write(before->second.frame, ideal, coarse_step - 1);
      averages.write(wanted.frame, ideal, coarse_step);
      json["before_from_averages"] = start(ideal, step, 0, wanted);
      json["after_from_averages"] = start(ideal, step, -1, wanted);
    }
    if (twin != nullptr) {
      Scene scene = fine_;
      for (std::size_t c = 0; c < scene.cloths.size(); ++c) scene.cloths[c].mesh = wanted.meshes[c];
      json["twin"] = difference_json(scene, wanted.frame, twin->on(scene));
    }
    return json;
  }

  std::int64_t fine_step(std::int64_t coarse_step) const {
    return std::llround(static_cast<double>(coarse_step) * level_.steps_per_coarse);
  }

 private:
  /// Averages are of one mesh over another.
  bool meshes_stay() const { return !slices_remesh(fine_) && !fine_.time_parallel.coarse_adaptive; }

  Json start(const std::filesystem::path& states, std::int64_t step, int iterations,
             const KeptState& wanted) {
    Scene scene = fine_;
    if (iterations >= 0) scene.time_parallel.recovery_iterations = iterations;
    const std::filesystem::path file = folder_.path / "start.weft";
    try {
      const SliceStart s = write_slice_start(scene, level_.scene->coarse(), step, states, file,
                                             [](double) { return true; });
      reader_.resume(file, SceneChanges::allow);
      Json json = difference_json(reader_.scene(), wanted.on(reader_.scene()), reader_.frame());
      json["iterations"] = s.iterations;
      json["change"] = s.change;
      if (!s.note.empty()) json["note"] = s.note;
      return json;
    } catch (const SimulationError& error) {
      return {{"refused", error.what()}};
    }
  }

  const Level& level_;
  const Folder& folder_;
  const Scene& fine_;
  Simulation reader_;
};

}  // namespace weft::bench
