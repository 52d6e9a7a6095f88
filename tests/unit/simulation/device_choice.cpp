#include "host/simulation/device_choice.hpp"

#include <gmock/gmock.h>

#include <cstddef>
#include <string>
#include <vector>

#include "host/exec/device_text.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

using testing::DoubleNear;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Of a H200 in a machine with NVSwitch: 7.1 us for a copy of 4 KB that the host issues, 11 us for
/// one of 1 MB, and 4.03 TB/s within a GPU (benchmarks/results/latest/4x-nvidia-h200).
constexpr double h200_bandwidth = 4.03e12;
constexpr LinkFigures nvlink{true, 1e-6, 300e9, 7.1e-6, 1e6 / 3.9e-6};

/// GPUs that are all alike, and what has been asked of them.
class FakeMachine final : public MachineProbe {
 public:
  FakeMachine(int gpus, const LinkFigures& link) : gpus_(gpus), link_(link) {}
  int gpu_count() override { return gpus_; }
  std::string why_none() override { return gpus_ > 0 ? "" : "no GPU: none was put in"; }
  std::string name(int) override { return "H200"; }
  double bandwidth(int gpu) override {
    if (gpu == broken) throw DeviceError("measuring GPU " + std::to_string(gpu) + ": broken");
    ++bandwidths;
    return gpu == slow ? h200_bandwidth / 100 : h200_bandwidth;
  }
  LinkFigures link(int, int) override {
    ++links;
    return link_;
  }

  int broken = -1;
  int slow = -1;
  int bandwidths = 0;
  int links = 0;

 private:
  int gpus_;
  LinkFigures link_;
};

/// Of a sheet with half as many vertices as triangles. That is all that the choice looks at.
Scene sheet(double triangles) {
  Scene scene;
  scene.cloths.resize(1);
  scene.cloths.front().mesh.positions.resize(static_cast<std::size_t>(triangles / 2));
  return scene;
}

std::string chosen(const Scene& scene, int gpus, const LinkFigures& link = nvlink) {
  FakeMachine machine(gpus, link);
  return choose_devices(scene, machine).device;
}

LinkFigures without_peers() {
  LinkFigures link = nvlink;
  link.peer = false;
  link.load_latency = link.load_bandwidth = 0;
  return link;
}

TEST(DeviceChoice, ModelMeetsMeasuredIterations) {
  // Sheet of 996,872 triangles, block Jacobi, on an H200: pcg_344cffe of
  // benchmarks/journal/2026-11-one-h200.json.
  Scene scene = sheet(2 * 499'849);
  scene.solver.preconditioner = Preconditioner::block_jacobi;
  ProductLoad load = product_load(scene);
  load.contacts = false;
  EXPECT_THAT(1e6 * product_time(load, h200_bandwidth, 1, nvlink, Transport::peer),
              DoubleNear(89.9, 0.1 * 89.9));
  // Flat, on 1, 2 and 4 H200s, when padding was loaded as well:
  // benchmarks/results/latest/4x-nvidia-h200/scaling.json.
  load.bytes_a_row = 658;
  const std::vector<std::pair<int, double>> measured{{1, 106.825}, {2, 55.9954}, {4, 31.687}};
  for (const auto& [ranks, us] : measured)
    EXPECT_THAT(1e6 * product_time(load, h200_bandwidth, ranks, nvlink, Transport::peer),
                DoubleNear(us, 0.1 * us))
        << ranks;
}

TEST(DeviceChoice, ModelMeetsMeasuredSteps) {
  // Stages of a step on two H200s over those on one, commit ff53e928:
  // benchmarks/results/latest/2x-nvidia-h200/drape.json. The model is fitted to the first three.
  const struct {
    const char* name;
    double rows, one_ms, two_ms;
  } measured[] = {
      {"499", 250'000, 15.35, 12.48},        {"699", 490'000, 38.95, 25.18},
      {"dress_200", 101'136, 7.63, 8.28},    {"499_interlock", 250'000, 17.80, 14.43},
      {"funnel_200", 100'173, 14.54, 14.93}, {"dancer_skirt_200", 99'660, 7.81, 8.87},
      {"stack_200", 102'010, 10.12, 9.99},
  };
  for (const auto& m : measured) {
    const ProductLoad load = product_load(sheet(2 * m.rows));
    const double one = step_time(load, h200_bandwidth, 1, {}, Transport::peer);
    const double two = step_time(load, h200_bandwidth, 2, nvlink, Transport::peer);
    const double ratio = m.two_ms / m.one_ms;
    EXPECT_THAT(two / one, DoubleNear(ratio, 0.2 * ratio)) << m.name;
  }
}

TEST(DeviceChoice, ModelMeetsMeasuredGathering) {
  // All-gather by the work queues on 8 H200s, at any size: 450 us. Bandwidth without end leaves
  // only that, the sums, and the launches of kernels.
  const ProductLoad load = product_load(sheet(1e6));
  const double all = product_time(load, 1e30, 8, nvlink, Transport::pipelined);
  const double sums = 8 * 7 * nvlink.copy_latency;
  const double launches = 8 * 12 * nvlink.copy_latency / 2;
  const double barriers = product_time(load, 1e30, 1, {}, Transport::peer);
  EXPECT_THAT(1e6 * (all - sums - launches - barriers), DoubleNear(450, 0.15 * 450));
}

TEST(DeviceChoice, FewTrianglesStayOnOneCard) {
  for (const auto preconditioner : {Preconditioner::block_jacobi, Preconditioner::multilevel}) {
    Scene scene = sheet(130e3);
    scene.solver.preconditioner = preconditioner;
    EXPECT_EQ(chosen(scene, 8), "cuda:0");
    EXPECT_EQ(chosen(scene, 2), "cuda:0");
    EXPECT_EQ(chosen(scene, 8, without_peers()), "cuda:0");
  }
}

TEST(DeviceChoice, ManyTrianglesTakeAllCards) {
  EXPECT_EQ(chosen(sheet(4e6), 8), "cuda:0,1,2,3,4,5,6,7");
  EXPECT_EQ(chosen(sheet(4e6), 4), "cuda:0,1,2,3");
  EXPECT_EQ(chosen(sheet(4e6), 3), "cuda:0,1,2");
  EXPECT_EQ(chosen(sheet(4e6), 1), "cuda:0");
}

TEST(DeviceChoice, WithoutPeerAccessByTheWorkQueues) {
  // The host issues 56 copies an iteration for 8 GPUs, and as many for the sums.
  EXPECT_EQ(chosen(sheet(500e3), 8, without_peers()), "cuda:0");
  FakeMachine machine(8, without_peers());
  const DeviceChoice choice = choose_devices(sheet(19e6), machine);
  EXPECT_EQ(choice.device, "cuda:0,1,2,3");
  ASSERT_THAT(choice.estimates, SizeIs(4));
  EXPECT_EQ(choice.estimates[0].transport, "");
  for (std::size_t k = 1; k < 4; ++k) EXPECT_EQ(choice.estimates[k].transport, "pipelined");
  EXPECT_THAT(choice.reason, HasSubstr("8 GPUs would take "));
}

TEST(DeviceChoice, SlowLinksLeaveOneCard) {
  // Loads by way of a slow bus.
  EXPECT_EQ(chosen(sheet(4e6), 8, {true, 2e-6, 1e9, 10e-6, 1e9}), "cuda:0");
  // Late answers.
  EXPECT_EQ(chosen(sheet(1e6), 8, {true, 30e-6, 300e9, 10e-6, 300e9}), "cuda:0");
}

TEST(DeviceChoice, TheSlowestCardCounts) {
  FakeMachine machine(2, nvlink);
  machine.slow = 1;
  EXPECT_EQ(choose_devices(sheet(4e6), machine).device, "cuda:0");
}

TEST(DeviceChoice, CardsThatCannotPayAreLeftAlone) {
  FakeMachine machine(8, nvlink);
  const DeviceChoice choice = choose_devices(sheet(20e3), machine);
  EXPECT_EQ(choice.device, "cuda:0");
  EXPECT_EQ(machine.bandwidths, 1);
  EXPECT_EQ(machine.links, 0);
  EXPECT_THAT(choice.estimates, SizeIs(1));
  // 320 k: two GPUs might, four are not looked at.
  EXPECT_EQ(choose_devices(sheet(320e3), machine).device, "cuda:0");
  EXPECT_EQ(machine.bandwidths, 3);
  EXPECT_EQ(machine.links, 1);
}

TEST(DeviceChoice, AllLinksOfTheCardsAreMeasured) {
  FakeMachine machine(8, nvlink);
  const DeviceChoice choice = choose_devices(sheet(4e6), machine);
  EXPECT_EQ(machine.links, 28);
  EXPECT_THAT(choice.figures, SizeIs(8 + 28));
  EXPECT_EQ(choice.reason, "all GPUs");
  ASSERT_THAT(choice.estimates, SizeIs(4));
  for (std::size_t k = 1; k < 4; ++k)
    EXPECT_LT(choice.estimates[k].seconds, choice.estimates[k - 1].seconds);
}

TEST(DeviceChoice, RefinedLater) {
  Scene scene = sheet(100e3);
  EXPECT_EQ(chosen(scene, 2), "cuda:0");
  scene.refinement.when = Refinement::When::sewn;
  scene.refinement.levels = 3;
  EXPECT_EQ(chosen(scene, 2), "cuda:0,1");
}

TEST(DeviceChoice, OnTheCpuWithAReason) {
  FakeMachine none(0, nvlink);
  const DeviceChoice choice = choose_devices(sheet(4e6), none);
  EXPECT_EQ(choice.device, "cpu:" + std::to_string(usual_host_ranks()));
  EXPECT_EQ(choice.reason, "no GPU: none was put in");
  EXPECT_THAT(choice.estimates, IsEmpty());
  for (const char* method : {"asynchronous", "adaptive", "view", "time_parallel"}) {
    Scene scene = sheet(4e6);
    scene.method = method;
    FakeMachine machine(8, nvlink);
    const DeviceChoice cpu = choose_devices(scene, machine);
    EXPECT_EQ(cpu.device, choice.device) << method;
    EXPECT_THAT(cpu.reason, HasSubstr("CPU")) << method;
    EXPECT_EQ(machine.bandwidths, 0) << method;
  }
}

TEST(DeviceChoice, ClothThatMaySleepStaysOnTheCpu) {
  Scene scene = sheet(4e6);
  scene.implicit.sleep_distance = 1e-3;
  FakeMachine machine(8, nvlink);
  const DeviceChoice choice = choose_devices(scene, machine);
  EXPECT_THAT(choice.device, testing::StartsWith("cpu"));
  EXPECT_THAT(choice.reason, HasSubstr("sleep"));
}

TEST(DeviceChoice, TransportsThatDoNotWork) {
  Scene scene = sheet(16e6);
  scene.solver.transport = Transport::peer;
  FakeMachine machine(8, without_peers());
  EXPECT_EQ(choose_devices(scene, machine).device, "cuda:0");
  EXPECT_THAT(choose_devices(scene, machine).reason, HasSubstr("solver.transport"));
  // Asked for where GPUs do reach each other.
  scene.solver.transport = Transport::pipelined;
  FakeMachine peers(2, nvlink);
  EXPECT_EQ(choose_devices(scene, peers).estimates.back().transport, "pipelined");
}

TEST(DeviceChoice, ABrokenCardIsAnError) {
  FakeMachine machine(2, nvlink);
  machine.broken = 1;
  EXPECT_THROW(choose_devices(sheet(4e6), machine), DeviceError);
  // One that would not be used is not asked.
  EXPECT_EQ(choose_devices(sheet(20e3), machine).device, "cuda:0");
}

TEST(DeviceChoice, LookingGoesOnWithoutABrokenCard) {
  FakeMachine machine(2, nvlink);
  machine.broken = 1;
  const DeviceChoice choice = look_for_devices(sheet(4e6), machine);
  EXPECT_EQ(choice.device, "");
  EXPECT_EQ(choice.reason, "measuring GPU 1: broken");
  EXPECT_EQ(look_for_devices(sheet(20e3), machine).device, "cuda:0");
}

TEST(DeviceChoice, HalosAreNoLargerThanWhatOthersHave) {
  ProductLoad load = product_load(sheet(200));
  EXPECT_EQ(halo_rows(load, 1), 0);
  EXPECT_LE(halo_rows(load, 2), load.rows / 2);
  load.rows = 1e6;
  load.contacts = false;
  EXPECT_DOUBLE_EQ(halo_rows(load, 4), 8 * 500);
  load.contacts = true;
  EXPECT_DOUBLE_EQ(halo_rows(load, 4), 8 * 500 + 125'000);
}

TEST(DeviceChoice, LinksForPeople) {
  FakeMachine machine(3, nvlink);
  const std::vector<std::string> lines = describe_links(machine);
  ASSERT_THAT(lines, SizeIs(3));
  EXPECT_EQ(lines[0], "cuda:0 to cuda:1: loads 1.00 us, 300.0 GB/s; copies 7.1 us, 256.4 GB/s");
  FakeMachine one(1, nvlink);
  EXPECT_THAT(describe_links(one), IsEmpty());
}

TEST(DeviceText, ReadsAndWrites) {
  EXPECT_TRUE(read_device_text("auto").automatic);
  EXPECT_EQ(read_device_text("auto").text(), "auto");
  EXPECT_EQ(read_device_text("cpu").text(), "cpu:" + std::to_string(usual_host_ranks()));
  EXPECT_EQ(read_device_text("cpu:3").text(), "cpu:3");
  EXPECT_EQ(read_device_text("cuda").text(), "cuda:0");
  EXPECT_EQ(read_device_text("cuda:2,0,2").text(), "cuda:2,0,2");
  EXPECT_EQ(first_gpus_text(3), "cuda:0,1,2");
  for (const char* text : {"", "cpu:0", "cpu:65", "cpu:", "cuda:", "cuda:0,", "cuda:-1", "gpu"})
    EXPECT_THROW(read_device_text(text), SceneError) << text;
}

}  // namespace
}  // namespace weft
