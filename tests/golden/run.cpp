// `weft run`, run as a program: what it writes, its exit codes, the same bits for any number of
// devices, and what is left after it is killed.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/golden/process.hpp"
#include "weft/version.hpp"

namespace weft::test {
namespace {

std::set<std::string> keys(const Json& object) {
  std::set<std::string> names;
  for (const auto& [key, value] : object.items()) names.insert(key);
  return names;
}

using Names = std::set<std::string>;

// ------------------------------------------------------------------------------- what is written
using RunSubcommand = Process;

TEST_F(RunSubcommand, WritesItsDirectory) {
  ASSERT_EQ(weft({"run", "small.json", "--device", "cpu", "--preview", "--report", "copy.json"}), 0)
      << err_;
  EXPECT_EQ(err_, "");
  EXPECT_EQ(line_count(out_), 7) << out_;  // a line a frame and a last one
  const std::string dir = "out/small";
  for (int frame = 0; frame <= 6; ++frame) {
    const std::string number = "0000" + std::to_string(frame) + ".obj";
    const std::string cloth = text_of(at(dir) / "frames" / ("cloth_" + number));
    EXPECT_NE(cloth.find("o lower\n"), std::string::npos) << number;
    EXPECT_NE(cloth.find("o upper\n"), std::string::npos) << number;
  }
  EXPECT_TRUE(fs::exists(at(dir) / "frames" / "obstacle.obj")) << "it stands";
  EXPECT_FALSE(fs::exists(at(dir) / "frames" / "cloth_00007.obj"));
  for (const char* name :
       {"scene.json", "preview.png", "checkpoint_00004.weft", "checkpoint_00006.weft"})
    EXPECT_TRUE(fs::exists(at(dir) / name)) << name;
  EXPECT_FALSE(fs::exists(at(dir) / "checkpoint_00002.weft")) << "more than two are kept";
  EXPECT_EQ(text_of(at("copy.json")), text_of(at(dir) / "report.json"));
  EXPECT_NE(out_.find(hash(dir)), std::string::npos) << out_;
  EXPECT_EQ(weft({"check", dir}), 0) << out_ << err_;
}

/// [pixels] width and height in the header of a PNG file
std::pair<int, int> size_of_png(const fs::path& file) {
  const std::string bytes = text_of(file);
  const auto number = [&](std::size_t at) {
    int value = 0;
    for (std::size_t k = at; k < at + 4; ++k)
      value = 256 * value + static_cast<unsigned char>(bytes.at(k));
    return value;
  };
  return {number(16), number(20)};
}

/// Nobody sees a picture of a run whose output goes into a file, so it costs nothing.
TEST_F(RunSubcommand, DrawsAPreviewWhereOneIsAskedFor) {
  const std::vector<std::string> words{"run",      "small.json", "-o",         "a",
                                       "--frames", "1",          "--overwrite"};
  const auto with = [&](const std::string& more) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {more});
    return all;
  };
  ASSERT_EQ(weft(with("--preview")), 0) << err_;
  EXPECT_EQ(size_of_png(at("a/preview.png")), std::make_pair(480, 360));
  EXPECT_NE(out_.find("preview a/preview.png"), std::string::npos) << out_;
  ASSERT_EQ(weft(words), 0) << err_;
  EXPECT_FALSE(fs::exists(at("a/preview.png"))) << "no terminal";
  EXPECT_EQ(out_.find("preview"), std::string::npos) << out_;
  std::vector<std::string> both = with("--preview");
  both.emplace_back("--no-preview");
  EXPECT_EQ(weft(both), 2);
  // The camera of the scene keeps its shape.
  std::vector<std::string> tall = with("--preview");
  tall.insert(tall.end(), {"--set", "camera.resolution=[300,1200]"});
  ASSERT_EQ(weft(tall), 0) << err_;
  EXPECT_EQ(size_of_png(at("a/preview.png")), std::make_pair(120, 480));
}

/// `script` gives the program a terminal.
TEST_F(RunSubcommand, DrawsAPreviewInATerminal) {
  if (!fs::exists("/usr/bin/script")) GTEST_SKIP() << "no /usr/bin/script";
  const std::string command = std::string(WEFT_PROGRAM) + " run small.json -o a --frames 1";
  ASSERT_EQ(wait(start_words({"/usr/bin/script", "-qec", command, "/dev/null"})), 0) << out_;
  EXPECT_TRUE(fs::exists(at("a/preview.png")));
}

TEST_F(RunSubcommand, Report) {
  ASSERT_EQ(run("a", {"--device", "cpu:2"}), 0) << err_;
  const Json r = report("a");
  Names names{"scene", "method", "device", "precision", "build", "frames", "steps", "simulated_s"};
  names.merge(Names{"wall_s", "stages_ms", "vertex_count", "triangle_count", "solver", "contacts"});
  names.merge(Names{"schema_version", "self_certificate", "intersections", "intersections_checked",
                    "clean_against_displaced", "energy"});
  names.merge(Names{"peak_bytes", "state_hash", "balance"});
  EXPECT_EQ(keys(r), names);
  EXPECT_EQ(keys(r["balance"]), (Names{"rows_bytes", "box_tests", "pairs", "ccd_tests", "queries",
                                       "rebalances", "ms", "imbalance_before", "imbalance_after"}));
  for (const char* work : {"rows_bytes", "box_tests", "pairs", "queries"}) {
    EXPECT_GT(r["balance"][work]["even"], 0) << work;
    EXPECT_GE(r["balance"][work]["imbalance"], 1) << work;
    EXPECT_LE(r["balance"][work]["imbalance"], 2) << work;  // one of two did everything
  }
  EXPECT_EQ(keys(r["build"]), (Names{"commit", "dirty", "compiler", "cuda"}));
  EXPECT_EQ(keys(r["solver"]),
            (Names{"iterations_mean", "iterations_max", "residual_max", "transport"}));
  EXPECT_EQ(keys(r["contacts"]),
            (Names{"proximities_max", "impacts_total", "zones_max", "zone_rounds_max",
                   "zone_largest", "zone_passes_total", "zones_unsolved_total", "plane_zones_total",
                   "rigid_zones_total", "truncations_total", "compliance_distance_max", "retries",
                   "steps_at_fallback_level"}));
  EXPECT_EQ(r["contacts"]["steps_at_fallback_level"],
            (Json{{"whole", 48}, {"halved", 0}, {"rigid", 0}, {"truncated", 0}, {"failed", 0}}));
  EXPECT_EQ(keys(r["energy"]), (Names{"kinetic", "potential", "drift", "gain"}));
  EXPECT_EQ(r["energy"]["gain"], 0);
  EXPECT_EQ(keys(r["peak_bytes"]), (Names{"host", "device", "device_by_use"}));
  EXPECT_EQ(r["scene"], "small");
  EXPECT_EQ(r["method"], "implicit");
  EXPECT_EQ(r["device"], "cpu:2");
  EXPECT_EQ(r["precision"], "float");
  EXPECT_EQ(r["frames"], 6);
  EXPECT_EQ(r["steps"], 48);
  EXPECT_NEAR(r["simulated_s"].get<double>(), 0.24, 1e-12);
  EXPECT_EQ(r["vertex_count"], 13 * 13 + 7 * 7);
  EXPECT_EQ(r["triangle_count"], 2 * 12 * 12 + 2 * 6 * 6);
  EXPECT_EQ(r["intersections"], 0);
  EXPECT_EQ(r["intersections_checked"], "last frame");
  EXPECT_EQ(r["peak_bytes"]["device"].size(), 2u);
  // Buffers are all that a host holds, and hold for good: the parts add up to the whole.
  for (std::size_t rank = 0; rank < 2; ++rank) {
    std::size_t sum = 0;
    for (const auto& [name, bytes] : r["peak_bytes"]["device_by_use"][rank].items())
      sum += bytes.get<std::size_t>();
    EXPECT_GE(sum, r["peak_bytes"]["device"][rank].get<std::size_t>());
    EXPECT_GT(r["peak_bytes"]["device_by_use"][rank]["matrix"], 0);
  }
  EXPECT_GT(r["peak_bytes"]["host"], 1 << 20);
  EXPECT_GT(r["contacts"]["proximities_max"], 0);
  EXPECT_EQ(r["state_hash"].get<std::string>().size(), 16u);
}

TEST_F(RunSubcommand, StepsAgreeWithTheReport) {
  ASSERT_EQ(run("a"), 0) << err_;
  std::istringstream lines(text_of(at("a/steps.jsonl")));
  const Json r = report("a");
  std::int64_t number = 0, iterations = 0, solves = 0, impacts = 0, proximities = 0;
  int energies = 0;
  double wall = 0;
  for (std::string line; std::getline(lines, line);) {
    const Json step = Json::parse(line);
    EXPECT_EQ(step["number"], ++number);
    EXPECT_NEAR(step["time"].get<double>(), 0.005 * static_cast<double>(number), 1e-12);
    EXPECT_EQ(step["failure"], "none");
    iterations += step["iterations"].get<std::int64_t>();
    solves += step["solves"].get<std::int64_t>();
    impacts += step["impacts"].get<std::int64_t>();
    proximities = std::max(proximities, step["proximities"].get<std::int64_t>());
    wall += step["wall_s"].get<double>();
    energies += step.contains("energy");
  }
  EXPECT_EQ(number, 48);
  EXPECT_EQ(energies, 6);
  EXPECT_EQ(r["contacts"]["impacts_total"], impacts);
  EXPECT_EQ(r["contacts"]["proximities_max"], proximities);
  ASSERT_GT(solves, 0);
  EXPECT_DOUBLE_EQ(r["solver"]["iterations_mean"],
                   static_cast<double>(iterations) / static_cast<double>(solves));
  EXPECT_GE(r["wall_s"].get<double>(), wall);
}

TEST_F(RunSubcommand, ResolvedSceneGivesTheSameRun) {
  ASSERT_EQ(run("a", {"--set", "gravity=[0,0,-5]", "--precision", "double"}), 0) << err_;
  EXPECT_EQ(report("a")["precision"], "double");
  ASSERT_EQ(weft({"run", "a/scene.json", "-o", "b", "--no-preview"}), 0) << err_;
  EXPECT_EQ(hash("a"), hash("b"));
  ASSERT_EQ(run("c", {"--precision", "double"}), 0) << err_;
  EXPECT_NE(hash("a"), hash("c"));
}

TEST_F(RunSubcommand, FreshRunClearsWhatItWouldWriteAndNothingElse) {
  ASSERT_EQ(run("a"), 0) << err_;
  write("a/notes.txt", "mine");
  write("a/frames/cloth_best.obj", "mine");
  ASSERT_EQ(run("a", {"--frames", "2", "--set", "output.format=ply"}), 0) << err_;
  EXPECT_TRUE(fs::exists(at("a/notes.txt")));
  EXPECT_TRUE(fs::exists(at("a/frames/cloth_best.obj")));
  Names names;
  for (const auto& entry : fs::directory_iterator(at("a/frames")))
    names.insert(entry.path().filename().string());
  EXPECT_EQ(names, (Names{"cloth_best.obj", "cloth_00000.ply", "cloth_00001.ply", "cloth_00002.ply",
                          "obstacle.ply"}));
  EXPECT_FALSE(fs::exists(at("a/checkpoint_00006.weft")));
  EXPECT_EQ(line_count(text_of(at("a/steps.jsonl"))), 16);
}

TEST_F(RunSubcommand, BadInputLeavesTheDirectoryAlone) {
  ASSERT_EQ(run("a", {"--frames", "2"}), 0) << err_;
  const std::string before = text_of(at("a/report.json"));
  EXPECT_EQ(run("a", {"--set", "time.step=-1"}), 2);
  EXPECT_EQ(run("a", {"--resume", "none.weft"}), 2);
  EXPECT_EQ(text_of(at("a/report.json")), before);
  EXPECT_TRUE(fs::exists(at("a/frames/cloth_00002.obj")));
}

// -------------------------------------------------------------------------------------- exit codes
using ExitCodes = Process;

TEST_F(ExitCodes, BadInput) {
  write("broken.json", "{");
  write("file", "");
  const std::vector<std::vector<std::string>> commands{
      {},
      {"rum"},
      {"run"},
      {"run", "none.json"},
      {"run", "broken.json"},
      {"run", "small.json", "--no-such-option"},
      {"run", "small.json", "--frames", "0"},
      {"run", "small.json", "--frames", "many"},
      {"run", "small.json", "--method", "magic"},
      {"run", "small.json", "--precision", "half"},
      {"run", "small.json", "--device", "abacus"},
      {"run", "small.json", "--set", "no.such=1"},
      {"run", "small.json", "--set", "nonsense"},
      {"run", "small.json", "--resume", "latest"},
      {"run", "small.json", "-o", "file"},
  };
  for (const auto& command : commands) {
    EXPECT_EQ(weft(command), 2) << testing::PrintToString(command) << err_;
    EXPECT_EQ(line_count(err_), 1) << testing::PrintToString(command) << err_;
    EXPECT_EQ(err_.find("weft: "), 0u) << err_;
    EXPECT_EQ(out_, "") << testing::PrintToString(command);
  }
}

TEST_F(ExitCodes, MissingDevice) {
  const bool cuda = *build_info().cuda != '\0';
  EXPECT_EQ(run("a", {"--device", cuda ? "cuda:99" : "cuda"}), 3) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_FALSE(fs::exists(at("a")));
}

TEST_F(ExitCodes, SimulationFails) {
  // One iteration cannot reach this tolerance, however short the step.
  EXPECT_EQ(
      run("a", {"--experimental", "solver.max_iterations=1", "--set", "solver.tolerance=1e-6"}), 4)
      << out_ << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("not converged"), std::string::npos) << err_;
  EXPECT_TRUE(report("a").contains("failure"));
  Names names;
  for (const auto& entry : fs::directory_iterator(at("a"))) names.insert(entry.path().extension());
  EXPECT_TRUE(names.contains(".weft"));
}

TEST_F(ExitCodes, HelpVersionInfo) {
  EXPECT_EQ(weft({"--help"}), 0);
  EXPECT_EQ(weft({"run", "--help"}), 0);
  EXPECT_EQ(weft({"--version"}), 0);
  EXPECT_TRUE(out_.starts_with(std::string("weft ") + WEFT_VERSION + " (commit ")) << out_;
  EXPECT_EQ(weft({"info"}), 0);
  EXPECT_NE(out_.find(build_info().compiler), std::string::npos) << out_;
  EXPECT_NE(out_.find("CUDA"), std::string::npos) << out_;
  EXPECT_NE(out_.find("devices"), std::string::npos) << out_;
  EXPECT_EQ(weft({"info", "--fabrics"}), 0);
  EXPECT_NE(out_.find("denim: jeans"), std::string::npos) << out_;
  EXPECT_NE(out_.find("Wang, O'Brien and Ramamoorthi 2011"), std::string::npos) << out_;
}

// ------------------------------------------------------------------------------------- determinism
using Determinism = Process;

TEST_F(Determinism, SameBitsAgain) {
  ASSERT_EQ(run("a"), 0) << err_;
  ASSERT_EQ(run("b"), 0) << err_;
  EXPECT_EQ(hash("a"), hash("b"));
  EXPECT_EQ(text_of(at("a/frames/cloth_00006.obj")), text_of(at("b/frames/cloth_00006.obj")));
}

TEST_F(Determinism, SameBitsForAnyNumberOfDevices) {
  // Small partial sums, so that every rank has rows.
  const std::vector<std::string> more{"--experimental", "solver.partial_rows=16", "--device"};
  std::string first;
  for (const char* device : {"cpu:1", "cpu:2", "cpu:3", "cpu:8"}) {
    std::vector<std::string> arguments = more;
    arguments.emplace_back(device);
    ASSERT_EQ(run("a", arguments), 0) << err_;
    if (first.empty()) first = hash("a");
    EXPECT_EQ(hash("a"), first) << device;
    EXPECT_EQ(report("a")["solver"]["transport"], "peer");
    arguments.insert(arguments.end(), {"--experimental", "solver.transport=pipelined"});
    ASSERT_EQ(run("a", arguments), 0) << err_;
    EXPECT_EQ(hash("a"), first) << device << ", pipelined";
    EXPECT_EQ(report("a")["solver"]["transport"], "pipelined");
  }
}

// ------------------------------------------------------------------------------------- checkpoints
using Resume = Process;

TEST_F(Resume, FromTheMiddleGivesTheUninterruptedRun) {
  ASSERT_EQ(run("a"), 0) << err_;
  ASSERT_EQ(run("b"), 0) << err_;
  const Json whole = report("b");
  fs::remove(at("b/frames/cloth_00006.obj"));
  fs::remove(at("b/report.json"));
  ASSERT_EQ(run("b", {"--resume", "b/checkpoint_00004.weft"}), 0) << err_;
  EXPECT_EQ(err_, "");
  EXPECT_EQ(hash("b"), hash("a"));
  EXPECT_EQ(text_of(at("a/frames/cloth_00006.obj")), text_of(at("b/frames/cloth_00006.obj")));
  EXPECT_EQ(line_count(text_of(at("b/steps.jsonl"))), 48);
  const Json resumed = report("b");
  for (const char* key : {"solver", "contacts", "energy", "frames", "steps", "simulated_s"})
    EXPECT_EQ(resumed[key], whole[key]) << key;
}

// On one processor any number of ranks gives the same bits; on GPUs and processors it does not.
TEST_F(Resume, TakesTheDeviceOfTheRunBefore) {
  ASSERT_EQ(run("a", {"--frames", "4", "--device", "cpu:3"}), 0) << err_;
  EXPECT_EQ(Json::parse(text_of(at("a/scene.json")))["device"], "cpu:3");
  ASSERT_EQ(run("a", {"--resume", "latest"}), 0) << err_;
  EXPECT_EQ(report("a")["device"], "cpu:3");
  ASSERT_EQ(run("b", {"--resume", "a/checkpoint_00004.weft"}), 0) << err_;
  EXPECT_EQ(report("b")["device"], "cpu:3");
  EXPECT_EQ(Json::parse(text_of(at("b/scene.json")))["device"], "cpu:3");
  ASSERT_EQ(run("b", {"--resume", "a/checkpoint_00004.weft", "--device", "cpu:1", "--overwrite"}),
            0)
      << err_;
  EXPECT_EQ(report("b")["device"], "cpu:1");
  // The resolved scene, run again.
  ASSERT_EQ(weft({"run", "a/scene.json", "-o", "c", "--no-preview", "--frames", "1"}), 0) << err_;
  EXPECT_EQ(report("c")["device"], "cpu:3");
  EXPECT_FALSE(report("c").contains("device_choice"));
  ASSERT_EQ(weft({"run", "small.json", "-o", "c", "--no-preview", "--frames", "1", "--set",
                  "device=cpu:2", "--overwrite"}),
            0)
      << err_;
  EXPECT_EQ(report("c")["device"], "cpu:2");
}

TEST_F(Resume, IntoAnotherDirectory) {
  ASSERT_EQ(run("a"), 0) << err_;
  ASSERT_EQ(run("b", {"--resume", "a/checkpoint_00004.weft", "--device", "cpu:3"}), 0) << err_;
  EXPECT_EQ(hash("b"), hash("a"));
  EXPECT_EQ(report("b")["solver"], report("a")["solver"]);
  EXPECT_TRUE(fs::exists(at("a/frames/cloth_00006.obj")));
  EXPECT_FALSE(fs::exists(at("b/frames/cloth_00003.obj")));
  EXPECT_EQ(text_of(at("a/frames/cloth_00004.obj")), text_of(at("b/frames/cloth_00004.obj")));
}

TEST_F(Resume, DamagedCheckpointIsRefused) {
  ASSERT_EQ(run("a"), 0) << err_;
  const std::string good = text_of(at("a/checkpoint_00004.weft"));
  ASSERT_GT(good.size(), 100u);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{10}, good.size() / 2, good.size() - 1}) {
    write("bad.weft", good.substr(0, size));
    EXPECT_EQ(run("b", {"--resume", "bad.weft"}), 2) << size << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
  }
  for (std::size_t at_byte = 0; at_byte < good.size(); at_byte += good.size() / 7) {
    std::string bad = good;
    bad[at_byte] = static_cast<char>(bad[at_byte] ^ 4);
    write("bad.weft", bad);
    EXPECT_EQ(run("b", {"--resume", "bad.weft"}), 2) << at_byte << err_;
  }
  EXPECT_FALSE(fs::exists(at("b")));
}

TEST_F(Resume, CheckpointOfAnotherSceneIsRefused) {
  ASSERT_EQ(run("a", {"--frames", "2"}), 0) << err_;
  EXPECT_EQ(run("b", {"--resume", "a/checkpoint_00002.weft", "--set", "cloths.1.grid.cells=[7,7]"}),
            2)
      << err_;
}

TEST_F(Resume, LatestFallsBackToTheOneBefore) {
  ASSERT_EQ(run("a"), 0) << err_;
  const std::string expected = hash("a");
  const std::string newest = text_of(at("a/checkpoint_00006.weft"));
  write("a/checkpoint_00006.weft", newest.substr(0, newest.size() / 2));
  ASSERT_EQ(run("a", {"--resume", "latest"}), 0) << err_;
  EXPECT_NE(err_.find("checkpoint_00006.weft"), std::string::npos) << err_;
  EXPECT_NE(err_.find("resuming from a/checkpoint_00004.weft"), std::string::npos) << err_;
  EXPECT_EQ(hash("a"), expected);
}

TEST_F(Resume, MoreFramesThanBefore) {
  ASSERT_EQ(run("a"), 0) << err_;
  ASSERT_EQ(run("b", {"--frames", "3"}), 0) << err_;
  ASSERT_EQ(run("b", {"--resume", "latest"}), 0) << err_;
  EXPECT_EQ(hash("b"), hash("a"));
}

/// As the energy of earlier steps is read back, a run whose log says that it had less has gained
/// some.
class EnergyFromNothing : public Process {
 protected:
  void lessen(double joules) const {
    std::istringstream lines(text_of(at("a/steps.jsonl")));
    std::string planted;
    for (std::string text; std::getline(lines, text);) {
      Json line = Json::parse(text);
      if (line.contains("energy"))
        line["energy"]["kinetic"] = line["energy"]["kinetic"].get<double>() - joules;
      planted += line.dump() + "\n";
    }
    write("a/steps.jsonl", planted);
  }
  /// Goes on with a run.
  int resume_with_less(double joules, const std::string& frames = "6") {
    EXPECT_EQ(run("a", {"--frames", "4"}), 0) << err_;
    EXPECT_EQ(report("a")["energy"]["gain"], 0);
    lessen(joules);
    return run("a", {"--frames", frames, "--resume", "latest"});
  }
  /// The same if the small scene is changed so that something gives energy to the cloth. Without
  /// the fault the run is in order.
  void expect_noticed(const Json& changes);
};

TEST_F(EnergyFromNothing, IsSaidWhenItBeginsAndAtTheEnd) {
  EXPECT_EQ(resume_with_less(0.3, "5"), 0) << err_;
  EXPECT_EQ(line_count(err_), 2) << err_;
  EXPECT_NE(err_.find("weft: warning: cloth gains energy from nothing: 0."), std::string::npos)
      << err_;
  EXPECT_NEAR(report("a")["energy"]["gain"].get<double>(), 0.3, 0.03);
  EXPECT_NE(err_.find("\nweft: warning: cloth gained up to 0."), std::string::npos) << err_;
  EXPECT_NE(err_.find(" J from nothing, by 0.2 s: "), std::string::npos) << err_;
  EXPECT_NE(err_.find(" J at play\n"), std::string::npos) << err_;
}

TEST_F(EnergyFromNothing, EndsTheRunIfItLasts) {
  EXPECT_EQ(resume_with_less(0.3), 4);
  EXPECT_EQ(line_count(err_), 2) << err_;
  EXPECT_NE(err_.find("weft: simulation failed at 0.24 s (step 48): energy from nothing: 0."),
            std::string::npos)
      << err_;
  EXPECT_NE(err_.find("; checkpoint a/checkpoint_00004.weft"), std::string::npos) << err_;
  EXPECT_EQ(report("a")["frames"], 6);
  EXPECT_FALSE(fs::exists(at("a/checkpoint_00006.weft")));
}

TEST_F(EnergyFromNothing, EndsTheRunAtOnceIfThereIsMuch) {
  EXPECT_EQ(resume_with_less(1000), 4);
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_EQ(err_.find("weft: simulation failed at 0.2 s (step 40): energy from nothing: "), 0u)
      << err_;
  EXPECT_NE(err_.find("; checkpoint a/checkpoint_00004.weft"), std::string::npos) << err_;
  EXPECT_EQ(report("a")["frames"], 5);
  EXPECT_FALSE(fs::exists(at("a/checkpoint_00005.weft")));
}

void EnergyFromNothing::expect_noticed(const Json& changes) {
  Json scene = Json::parse(small_scene);
  scene.merge_patch(changes);
  write("small.json", scene.dump());
  ASSERT_EQ(run("a"), 0) << err_;
  EXPECT_EQ(err_, "");
  EXPECT_EQ(report("a")["energy"]["gain"], 0);
  double work = 0;
  std::istringstream lines(text_of(at("a/steps.jsonl")));
  for (std::string text; std::getline(lines, text);)
    work += Json::parse(text)["work"].get<double>();
  EXPECT_GT(work, 0.01);
  lessen(0.3);
  EXPECT_EQ(run("a", {"--resume", "a/checkpoint_00004.weft"}), 4);
  EXPECT_NE(err_.find("): energy from nothing: "), std::string::npos) << err_;
}

TEST_F(EnergyFromNothing, IsNoticedBesideMovingPins) {
  expect_noticed(Json::parse(R"({"pins": [{"cloth": "upper", "edge": "left", "motion": [
      {"time": 0}, {"time": 0.24, "translate": [0, 0, 0.2]}]}]})"));
}

TEST_F(EnergyFromNothing, IsNoticedBesideMovingBodies) {
  expect_noticed(Json::parse(R"({"obstacles": [
      {"name": "ball", "sphere": {"radius": 0.15, "subdivisions": 2}, "motion": [
        {"time": 0}, {"time": 0.24, "translate": [0, 0, 0.3]}]}]})"));
}

TEST_F(EnergyFromNothing, IsNoticedInWind) {
  expect_noticed(Json::parse(R"({"wind": {"density": 1.2, "velocity": [0, 3, 8]}})"));
}

TEST_F(EnergyFromNothing, IsNoticedUnderPressure) {
  Json cloths = Json::parse(small_scene)["cloths"];
  cloths[1]["pressure"] = 20;
  expect_noticed({{"cloths", cloths}});
}

TEST_F(EnergyFromNothing, IsNoticedBesideHandles) {
  expect_noticed(Json::parse(R"({"handles": [{"cloth": "upper", "edge": "left", "stiffness": 200,
      "motion": [{"time": 0}, {"time": 0.24, "translate": [0, 0, 0.2]}]}]})"));
}

TEST_F(EnergyFromNothing, IsNoticedBesideOpenSeams) {
  Json cloths = Json::parse(small_scene)["cloths"];
  cloths[0]["transform"] = {{"translate", {-0.4, 0, 0.4}}};
  cloths[1] = cloths[0];
  cloths[1]["name"] = "upper";
  cloths[1]["transform"] = {{"translate", {0.4, 0, 0.4}}};
  expect_noticed(
      {{"cloths", cloths},
       {"seams",
        {{{"between",
           {{{"cloth", "lower"}, {"edge", "right"}}, {{"cloth", "upper"}, {"edge", "left"}}}}}}}});
}

TEST_F(Resume, StoppedBySignal) {
  ASSERT_EQ(run("a", {"--frames", "20"}), 0) << err_;
  ASSERT_EQ(stopped(run_arguments("b", {"--frames", "20"}), at("b"), at("b/frames/cloth_00001.obj"),
                    SIGTERM),
            130)
      << out_ << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_LT(report("b")["steps"], 160);
  EXPECT_EQ(line_count(text_of(at("b/steps.jsonl"))), report("b")["steps"]);
  ASSERT_EQ(run("b", {"--frames", "20", "--resume", "latest"}), 0) << err_;
  EXPECT_EQ(err_, "");
  EXPECT_EQ(hash("b"), hash("a"));
}

class Kill : public Process {
 protected:
  /// Kills runs at random moments and goes on from the latest checkpoint, until one is done.
  void kill_and_resume(unsigned seed, int kills);
};

void Kill::kill_and_resume(unsigned seed, int kills) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const std::vector<std::string> more{"--set", "output.checkpoint_every=1"};
  ASSERT_EQ(run("whole", more), 0) << err_;
  const double whole = std::chrono::duration<double>(Clock::now() - begin).count();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> moment(0.05 * whole, 0.95 * whole);
  const auto arguments = [&] {
    std::vector<std::string> next = more;
    bool any = false;
    for (const auto& entry : fs::directory_iterator(directory_ / "killed"))
      any = any || entry.path().extension() == ".weft";
    if (any) next.insert(next.end(), {"--resume", "latest"});
    return run_arguments("killed", next);
  };
  fs::create_directories(at("killed"));
  int killed = 0;
  for (int k = 0; k < kills; ++k) {
    const pid_t child = start(arguments());
    std::this_thread::sleep_for(std::chrono::duration<double>(moment(random)));
    ::kill(child, SIGKILL);
    const int code = wait(child);
    ASSERT_TRUE(code == 0 || code == -SIGKILL) << code << err_;
    killed += code != 0;
    if (code == 0) fs::remove_all(at("killed")), fs::create_directories(at("killed"));
  }
  EXPECT_GT(killed, 0) << "no run was killed in its midst";
  ASSERT_EQ(weft(arguments()), 0) << err_;
  EXPECT_EQ(err_, "");
  EXPECT_EQ(hash("killed"), hash("whole"));
  for (const char* key : {"solver", "contacts", "frames", "steps"})
    EXPECT_EQ(report("killed")[key], report("whole")[key]) << key;
  EXPECT_EQ(line_count(text_of(at("killed/steps.jsonl"))), 48);
  for (int frame = 0; frame <= 6; ++frame) {
    const std::string name = "frames/cloth_0000" + std::to_string(frame) + ".obj";
    EXPECT_EQ(text_of(at("killed") / name), text_of(at("whole") / name)) << name;
  }
  for (const auto& entry : fs::recursive_directory_iterator(at("killed")))
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
}

TEST_F(Kill, ThreeTimes) {
  kill_and_resume(1, 3);
}

using SlowKill = Kill;
TEST_F(SlowKill, TenTimes) {
  for (unsigned seed = 2; seed < 5; ++seed) {
    fs::remove_all(at("killed"));
    kill_and_resume(seed, 10);
  }
}

}  // namespace
}  // namespace weft::test
