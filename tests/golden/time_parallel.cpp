// `weft run --method time_parallel`, run as a program: what it writes, one set of bits for every
// kind and number of workers, what is left when workers or the run are killed, and bad input.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "tests/golden/process.hpp"
#include "tests/golden/shipped_scenes.hpp"

namespace weft::test {
namespace {

/// `small.json` with meshes that can be made coarser.
class TimeParallelSubcommand : public Process {
 protected:
  void SetUp() override {
    Process::SetUp();
    Json scene = Json::parse(small_scene);
    scene["cloths"][0]["grid"]["cells"] = {20, 20};
    scene["cloths"][1]["grid"]["cells"] = {10, 10};
    scene["method"] = {{"type", "time_parallel"}};
    write("small.json", scene.dump());
  }

  /// Processes that the program has started.
  static std::vector<pid_t> children_of(pid_t program) {
    std::vector<pid_t> children;
    std::error_code error;
    for (const auto& task :
         fs::directory_iterator("/proc/" + std::to_string(program) + "/task", error)) {
      std::istringstream numbers(text_of(task.path() / "children"));
      for (pid_t child = 0; numbers >> child;) children.push_back(child);
    }
    return children;
  }
};

TEST_F(TimeParallelSubcommand, WritesItsDirectory) {
  ASSERT_EQ(run("a", {"--workers", "3"}), 0) << err_;
  EXPECT_EQ(err_, "");
  for (int frame = 0; frame <= 6; ++frame)
    EXPECT_TRUE(fs::exists(at("a/frames/cloth_0000" + std::to_string(frame) + ".obj"))) << frame;
  EXPECT_EQ(line_count(text_of(at("a/steps.jsonl"))), 48);
  const Json r = report("a");
  EXPECT_EQ(r.at("method"), "time_parallel");
  EXPECT_EQ(r.at("frames"), 6);
  EXPECT_EQ(r.at("steps"), 48);
  EXPECT_EQ(r.at("intersections"), 0);
  const Json& t = r.at("time_parallel");
  EXPECT_EQ(t.at("slices").size(), 3u);
  EXPECT_EQ(t.at("slice_boundaries").size(), 2u);
  EXPECT_EQ(t.at("workers"), 3);
  EXPECT_GT(t.at("speedup").at("by_counted_work").at("ratio"), 1);
  const Json p = Json::parse(text_of(at("a/partition.json")));
  EXPECT_EQ(p.at("steps"), 48);
  EXPECT_EQ(p.at("complete"), true);
  EXPECT_EQ(p.at("starts").size(), 3u);
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
}

/// Around one method of the slices.
class TimeParallelMethods : public TimeParallelSubcommand,
                            public testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    TimeParallelSubcommand::SetUp();
    Json scene = Json::parse(text_of(at("small.json")));
    scene["method"]["time_parallel"]["method"] = GetParam();
    write("small.json", scene.dump());
  }
};

TEST_P(TimeParallelMethods, SameBitsForEveryKindAndNumberOfWorkers) {
  ASSERT_EQ(run("a", {"--workers", "3"}), 0) << err_;
  const std::string frames = text_of(at("a/frames/cloth_00004.obj"));
  ASSERT_EQ(run("b", {"--workers", "1", "--partition", "a/partition.json"}), 0) << err_;
  ASSERT_EQ(run("c", {"--workers", "2", "--processes", "--partition", "a/partition.json"}), 0)
      << err_;
  ASSERT_EQ(run("d", {"--workers", "2", "--processes", "--set", "method.time_parallel.slices=3"}),
            0)
      << err_;
  for (const char* other : {"b", "c", "d"}) {
    EXPECT_EQ(hash(other), hash("a")) << other;
    EXPECT_TRUE(text_of(at(other) / "frames" / "cloth_00004.obj") == frames) << other;
    EXPECT_EQ(text_of(at(other) / "partition.json"), text_of(at("a/partition.json")));
  }
  EXPECT_EQ(report("c").at("time_parallel").at("worker_kind"), "process");
}

TEST_P(TimeParallelMethods, KilledWorkersAreReplaced) {
  ASSERT_EQ(run("whole", {"--set", "method.time_parallel.slices=3"}), 0) << err_;
  std::mt19937 random(5);
  const pid_t program = start(run_arguments(
      "killed", {"--workers", "3", "--processes", "--set", "method.time_parallel.slices=3"}));
  int killed = 0;
  int rest = 0;  // rounds before the next one
  for (int round = 0; round < 400 && killed < 6; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(40 + random() % 100));
    if (::kill(program, 0) != 0) break;
    const std::vector<pid_t> children = children_of(program);
    if (children.empty()) {
      // Not yet, or no more: the program may have ended. waitpid() does not take WNOWAIT.
      siginfo_t ended{};
      const int flags = WEXITED | WNOHANG | WNOWAIT;
      if (::waitid(P_PID, static_cast<id_t>(program), &ended, flags) != 0 || ended.si_pid != 0)
        break;
      continue;
    }
    // No more than a few: a slice that never gets to a checkpoint is given up.
    if (rest-- > 0 || ::kill(children[random() % children.size()], SIGKILL) != 0) continue;
    ++killed;
    rest = 2;
  }
  ASSERT_EQ(wait(program), 0) << err_;
  EXPECT_GT(killed, 0);
  EXPECT_EQ(hash("killed"), hash("whole"));
  EXPECT_EQ(line_count(text_of(at("killed/steps.jsonl"))), 48);
  for (int frame = 0; frame <= 6; ++frame) {
    const std::string name = "frames/cloth_0000" + std::to_string(frame) + ".obj";
    EXPECT_TRUE(text_of(at("killed") / name) == text_of(at("whole") / name)) << name;
  }
}

TEST_P(TimeParallelMethods, AKilledRunGoesOn) {
  const std::vector<std::string> slices{"--set", "method.time_parallel.slices=3", "--workers", "2"};
  ASSERT_EQ(run("whole", slices), 0) << err_;
  ASSERT_EQ(stopped(run_arguments("cut", slices), at("cut"),
                    at("cut/time_parallel/slices/00000/checkpoint.weft"), SIGKILL),
            -SIGKILL);
  std::vector<std::string> again = slices;
  again.insert(again.end(), {"--resume", "latest"});
  ASSERT_EQ(run("cut", again), 0) << err_;
  EXPECT_EQ(hash("cut"), hash("whole"));
  EXPECT_EQ(line_count(text_of(at("cut/steps.jsonl"))), 48);
  EXPECT_TRUE(text_of(at("cut/frames/cloth_00006.obj")) ==
              text_of(at("whole/frames/cloth_00006.obj")));
}

INSTANTIATE_TEST_SUITE_P(All, TimeParallelMethods, testing::Values("implicit", "adaptive"),
                         [](const auto& method) { return method.param; });

/// Scenes that come with weft, by slices that remesh, and an independent validator of their frames.
class TimeParallelScenes : public Process {
 protected:
  void run_clean(const std::string& scene, const std::vector<std::string>& settings,
                 int frames = 6);
  /// Of ARCSim; empty where there is none.
  static std::string arcsim_path(const std::string& name) {
    const char* data = std::getenv("WEFT_TEST_DATA");
    const fs::path path = fs::path(data ? data : "") / "arcsim" / "conf" / (name + ".json");
    return data && fs::exists(path) ? path.string() : std::string();
  }
};

void TimeParallelScenes::run_clean(const std::string& scene,
                                   const std::vector<std::string>& settings, int frames) {
  std::vector<std::string> arguments{"run",         scene,
                                     "-o",          "out",
                                     "--overwrite", "--no-preview",
                                     "--frames",    std::to_string(frames),
                                     "--method",    "time_parallel",
                                     "--workers",   "2",
                                     "--set",       "method.time_parallel.slices=3"};
  for (const std::string& setting : settings) {
    const bool key = !setting.starts_with("method.time_parallel.coarse_mesh");
    arguments.insert(arguments.end(), {key ? "--set" : "--experimental", setting});
  }
  ASSERT_EQ(weft(arguments), 0) << err_;
  const Json r = report("out");
  EXPECT_EQ(r.at("frames"), frames);
  EXPECT_EQ(r.at("intersections"), 0);
  EXPECT_EQ(r.at("time_parallel").at("slice_boundaries").size(), 2u);
  EXPECT_EQ(r.at("remeshing").at("remeshes"), frames);
  EXPECT_EQ(weft({"check", "out"}), 0) << out_ << err_;
  std::set<std::string> meshes;
  for (const auto& frame : fs::directory_iterator(at("out/frames"))) {
    std::istringstream lines(text_of(frame.path()));
    std::string triangles;
    for (std::string line; std::getline(lines, line);)
      if (line.rfind("f ", 0) == 0) triangles += line + '\n';
    meshes.insert(triangles);
  }
  EXPECT_GE(meshes.size(), 3u) << "meshes change from frame to frame";
}

TEST_F(TimeParallelScenes, DrapeByAdaptiveSlices) {
  run_clean(scene_path("drape"), {"method.time_parallel.method=adaptive", "triangles=2000"});
}

TEST_F(TimeParallelScenes, SwingByAdaptiveSlicesOfAnAdaptiveCoarseRun) {
  run_clean(scene_path("swing"),
            {"method.time_parallel.method=adaptive", "method.time_parallel.coarse_mesh=adaptive"});
}

TEST_F(TimeParallelScenes, DrapeByViewSlices) {
  run_clean(scene_path("drape"),
            {"method.time_parallel.method=view", "triangles=2000",
             R"(camera={"keys": [{"position": [0, -2, 1], "look_at": [0, 0, 0]}]})"});
}

/// A mesh of four triangles, far coarser than that of the coarse run.
TEST_F(TimeParallelScenes, SphereOfArcsim) {
  const std::string scene = arcsim_path("sphere");
  if (scene.empty()) GTEST_SKIP() << "WEFT_TEST_DATA holds no arcsim/conf/sphere.json";
  for (const char* coarse : {"uniform", "adaptive"})
    run_clean(scene, {"method.time_parallel.method=adaptive",
                      std::string("method.time_parallel.coarse_mesh=") + coarse});
}

/// Seams in material space that are none to sew, and a start far from rest.
TEST_F(TimeParallelScenes, SlowDressOfArcsim) {
  const std::string scene = arcsim_path("dress-blue");
  if (scene.empty()) GTEST_SKIP() << "WEFT_TEST_DATA holds no arcsim/conf/dress-blue.json";
  run_clean(scene, {"method.time_parallel.method=adaptive", "remeshing.size=[0.02, 0.2]"}, 12);
}

/// `mpirun -n RANKS weft run small.json ...`
class TimeParallelRanks : public TimeParallelSubcommand {
 protected:
  void SetUp() override {
    if (std::string(WEFT_MPIRUN).empty())
      GTEST_SKIP() << "NOT TESTED: MPI ranks need a build with WEFT_MPI, and mpirun";
    // As root and with more ranks than cores, as in containers: Open MPI 4, and 5 by PRRTE.
    for (const char* name : {"OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM",
                             "OMPI_MCA_rmaps_base_oversubscribe", "PRTE_ALLOW_RUN_AS_ROOT",
                             "PRTE_ALLOW_RUN_AS_ROOT_CONFIRM"})
      ::setenv(name, "1", 1);
    ::setenv("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe", 1);
    TimeParallelSubcommand::SetUp();
  }
  void expect_same_bits_as_threads();
  pid_t start_ranks(int ranks, const std::string& output,
                    const std::vector<std::string>& more) const {
    std::vector<std::string> words{WEFT_MPIRUN, "-n", std::to_string(ranks), WEFT_PROGRAM};
    const std::vector<std::string> arguments = run_arguments(output, more);
    words.insert(words.end(), arguments.begin(), arguments.end());
    return start_words(words);
  }
  const std::vector<std::string> slices_{"--set", "method.time_parallel.slices=3", "--set",
                                         "output.checkpoint_every=1"};
};

TEST_F(TimeParallelRanks, SameBitsAsThreads) {
  for (const std::string method : {"implicit", "adaptive"}) {
    Json scene = Json::parse(text_of(at("small.json")));
    scene["method"]["time_parallel"]["method"] = method;
    write("small.json", scene.dump());
    fs::remove_all(at("threads"));
    fs::remove_all(at("ranks"));
    expect_same_bits_as_threads();
  }
}

void TimeParallelRanks::expect_same_bits_as_threads() {
  std::vector<std::string> threads = slices_;
  threads.insert(threads.end(), {"--workers", "2"});
  ASSERT_EQ(run("threads", threads), 0) << err_;
  ASSERT_EQ(wait(start_ranks(3, "ranks", slices_)), 0) << err_;
  EXPECT_EQ(hash("ranks"), hash("threads"));
  EXPECT_EQ(report("ranks").at("time_parallel").at("worker_kind"), "rank");
  EXPECT_EQ(report("ranks").at("time_parallel").at("workers"), 3);
  EXPECT_EQ(text_of(at("ranks/partition.json")), text_of(at("threads/partition.json")));
  EXPECT_EQ(line_count(text_of(at("ranks/steps.jsonl"))), 48);
  for (int frame = 0; frame <= 6; ++frame) {
    const std::string name = "frames/cloth_0000" + std::to_string(frame) + ".obj";
    EXPECT_TRUE(text_of(at("ranks") / name) == text_of(at("threads") / name)) << name;
  }
}

/// Which ends the job. The same command, whatever the number of ranks, goes on with what is left.
TEST_F(TimeParallelRanks, AKilledRankLosesNothing) {
  ASSERT_EQ(run("whole", slices_), 0) << err_;
  int code = 0;
  for (int k = 0; k < 10 && code == 0; ++k) {  // a run may be over before a rank is killed
    fs::remove_all(at("killed"));
    const pid_t program = start_ranks(3, "killed", slices_);
    while (!fs::exists(at("killed/time_parallel/slices/00000/checkpoint.weft")) && runs(program))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::vector<pid_t> ranks = children_of(program);
    if (!ranks.empty()) ::kill(ranks.back(), SIGKILL);
    code = wait(program);
  }
  EXPECT_NE(code, 0);
  ASSERT_EQ(wait(start_ranks(2, "killed", slices_)), 0) << err_;
  EXPECT_EQ(hash("killed"), hash("whole"));
  EXPECT_EQ(line_count(text_of(at("killed/steps.jsonl"))), 48);
  EXPECT_TRUE(text_of(at("killed/frames/cloth_00006.obj")) ==
              text_of(at("whole/frames/cloth_00006.obj")));
}

TEST_F(TimeParallelRanks, OtherMethodsAreRefused) {
  EXPECT_EQ(wait(start_ranks(2, "bad", {"--method", "implicit"})), 2);
  EXPECT_NE(err_.find("2 processes with the method \"implicit\""), std::string::npos) << err_;
  EXPECT_EQ(wait(start_ranks(2, "bad", {"--processes"})), 2);
  EXPECT_NE(err_.find("--processes"), std::string::npos) << err_;
}

/// A run that was cut off keeps what it has decided: slices that are there do not begin elsewhere.
TEST_F(TimeParallelSubcommand, ARunThatWasCutOffRefusesAnotherPartition) {
  const std::vector<std::string> words{"--set", "method.time_parallel.slices=3", "--workers", "3"};
  ASSERT_EQ(stopped(run_arguments("cut", words), at("cut"),
                    at("cut/time_parallel/slices/00000/checkpoint.weft"), SIGKILL),
            -SIGKILL);
  write("other.json", R"({"steps": 48, "complete": true, "starts": [0, 2, 4]})");
  ASSERT_EQ(run("cut", {"--resume", "latest", "--partition", "other.json"}), 2);
}

/// Each of them would take the run for its own.
TEST_F(TimeParallelSubcommand, ProcessesThatAreNotCountedAreRefused) {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) ::unsetenv(name);
  ::setenv("PMIX_RANK", "1", 1);
  EXPECT_EQ(run("second", {}), 2);
  EXPECT_NE(err_.find("PMIX_RANK"), std::string::npos) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  ::unsetenv("PMIX_RANK");
}

TEST_F(TimeParallelSubcommand, BadInputIsOneLine) {
  write("other.json", R"({"steps": 10, "complete": true, "starts": [0, 5]})");
  write("none.json", "{");
  write("falling.json", R"({"steps": 48, "complete": true, "starts": [0, 20, 10]})");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--workers", "49"}, "48 steps"},
      {{"--workers", "0"}, "--workers"},
      {{"--partition", "other.json"}, "48 steps"},
      {{"--partition", "none.json"}, "partition"},
      {{"--partition", "falling.json"}, "10 after 20"},
      {{"--resume", "latest"}, "--resume"},
      {{"--resume", "some.weft"}, "--resume"},
      {{"--method", "implicit", "--workers", "2"}, "--workers"},
      {{"--set", "cloths.1.grid.cells=[1, 1]"}, "no coarser mesh can be made"},
      {{"--set", "method.time_parallel.method=asynchronous"}, "method.time_parallel.method"},
      {{"--set", "method.time_parallel.method=view"}, "camera.keys"},
  };
  for (const auto& [arguments, said] : cases) {
    EXPECT_EQ(run("bad", arguments), 2) << said;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find(said), std::string::npos) << err_;
  }
}

}  // namespace
}  // namespace weft::test
