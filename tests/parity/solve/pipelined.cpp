#include "weft/kernels/solve/pipelined.hpp"
#include "host/exec/host_devices.hpp"

#include <vector>

#include "tests/parity/solve/solve_rank.hpp"

namespace weft::parity {
namespace {

std::string describe(const Options& o) {
  return "partial sums of " + std::to_string(o.partial_rows) + " rows, preconditioner " +
         std::to_string(static_cast<int>(o.preconditioner)) + ", tolerance " +
         std::to_string(o.tolerance);
}

/// Both transports solve the same systems; the one that SolvePcg tests is the reference.
template <class T>
class SolvePipelinedTest : public testing::Test {
 protected:
  static constexpr double solver_tolerance = sizeof(T) == sizeof(float) ? 1e-5 : 1e-11;
  /// Out of rounding's reach: restarts, and the norm that rounding is checked by.
  static constexpr double too_tight = sizeof(T) == sizeof(float) ? 1e-9 : 1e-18;

  static std::vector<Options> cases() {
    std::vector<Options> all;
    for (const Index partial_rows : {1, 8, 32, 64, 256, 512, 1024, 2048})
      for (const auto preconditioner : {Preconditioner::block_jacobi, Preconditioner::multilevel})
        all.push_back({partial_rows, preconditioner, solver_tolerance});
    all.push_back({64, Preconditioner::multilevel, too_tight});
    all.push_back({64, Preconditioner::multilevel, solver_tolerance, 13});
    return all;
  }
  static Options pipelined(Options o) {
    o.transport = Transport::pipelined;
    return o;
  }
  SheetSystem system_{61, 43, 17};
};

using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SolvePipelinedTest, Scalars);

TYPED_TEST(SolvePipelinedTest, HostGivesThePeersBits) {
  for (const Options& options : this->cases()) {
    SCOPED_TRACE(describe(options));
    const auto peer = solve<TypeParam>(host_devices(1, {.poison = true}), this->system_, options);
    EXPECT_GT(peer.status.iterations, 0);
    // Handing work from thread to thread takes most of the time, and most of that with many ranks.
    const bool all = options.partial_rows == 64;
    for (const int ranks : all ? std::vector<int>{1, 2, 3, 5, 8} : std::vector<int>{3}) {
      SCOPED_TRACE(std::to_string(ranks) + " ranks");
      const auto found = solve<TypeParam>(host_devices(ranks, {.poison = true}), this->system_,
                                          this->pipelined(options));
      expect_same_bits(found.outputs(), peer.outputs());
      EXPECT_EQ(found.status.converged, peer.status.converged);
      EXPECT_EQ(found.status.finite, 1);
    }
  }
}

/// Every piece of work and every copy is late by a random time.
TYPED_TEST(SolvePipelinedTest, ShuffledTimingChangesNothing) {
  Options options{64, Preconditioner::multilevel, this->solver_tolerance};
  const auto peer = solve<TypeParam>(host_devices(1), this->system_, options);
  for (const std::uint64_t seed : {1u, 2u})
    expect_same_bits(solve<TypeParam>(host_devices(5, {.poison = true, .delay_seed = seed}),
                                      this->system_, this->pipelined(options))
                         .outputs(),
                     peer.outputs());
}

TYPED_TEST(SolvePipelinedTest, CudaGivesThePeersBits) {
  for (const Options& options : this->cases()) {
    SCOPED_TRACE(describe(options));
    std::optional<Outputs> peer;
    for (const std::vector<int>& gpus : gpu_lists()) {
      std::string why;
      const std::optional<DeviceSet> cuda = find_cuda(gpus, why);
      if (!cuda) GTEST_SKIP() << why;
      if (!peer) peer = solve<TypeParam>(*cuda, this->system_, options).outputs();
      const auto found = solve<TypeParam>(*cuda, this->system_, this->pipelined(options));
      expect_same_bits(found.outputs(), *peer);
      EXPECT_EQ(found.status.finite, 1);
    }
  }
}

/// Systems of which the blocks of a large GPU have several tiles each, in even and odd numbers of
/// turns; a few iterations.
TEST(SolvePipelinedLarge, CudaGivesThePeersBits) {
  std::string why;
  const std::optional<DeviceSet> one = find_cuda({0}, why);
  if (!one) GTEST_SKIP() << why;
  for (const Index up : {320, 600})
    for (const bool touching : {true, false}) {
      SheetSystem system(490, up, 23);
      if (!touching) system.part_contacts();
      for (Options options : {Options{512, Preconditioner::block_jacobi, 1e-9},
                              Options{1024, Preconditioner::multilevel, 1e-9}}) {
        SCOPED_TRACE(testing::Message() << up << ", " << touching << ", " << options.partial_rows);
        options.max_iterations = 3;
        const auto peer = solve<float>(*one, system, options);
        const auto host = solve<float>(host_devices(2), system, options);
        expect_close({output("x", peer.x)}, {output("x", host.x)}, 1e-4);
        expect_same_bits(solve<float>(*find_cuda({0, 0, 0}, why), system, options).outputs(),
                         peer.outputs());
        options.transport = Transport::pipelined;
        expect_same_bits(solve<float>(*one, system, options).outputs(), peer.outputs());
      }
    }
}

TYPED_TEST(SolvePipelinedTest, NotANumberEndsTheSolveOnBoth) {
  this->system_.rhs[100][1] = std::nan("");
  this->system_.fixed[100] = 0;
  const Options options = this->pipelined({64, Preconditioner::multilevel, this->solver_tolerance});
  EXPECT_EQ(solve<TypeParam>(host_devices(2), this->system_, options).status.finite, 0);
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  EXPECT_EQ(solve<TypeParam>(*cuda, this->system_, options).status.finite, 0);
}

/// Stage of every group of rows, by the plain definition and by both twins.
std::vector<unsigned char> stages_of(DeviceSet& devices, int rank, const SheetSystem& system,
                                     const std::vector<Index>& row_begin,
                                     const std::vector<unsigned char>& arrival) {
  const Options options{32};
  const auto n = static_cast<std::size_t>(rank);
  Device& device = devices[rank];
  SolveRank<float> own(device, system, options, row_begin[n], row_begin[n + 1], row_begin);
  const Buffer<unsigned char> arrivals = upload(device, arrival);
  const Buffer<unsigned char> stage = upload(
      device, std::vector<unsigned char>(
                  static_cast<std::size_t>(pipelined_groups(row_begin[n + 1] - row_begin[n])), 99));
  const Buffer<PipelinedState<float>> state(device, 1);
  SolvePipelined<float> args;
  args.solve.rank = rank;
  args.solve.row_begin = own.row_begin();
  args.part = own.part();
  args.arrival = arrivals.span();
  args.group_stage = stage.span();
  args.state = state.span();
  launch(device.compute(), args);
  device.compute().sync();
  const PipelinedState<float> cleared = download(state).front();
  EXPECT_FALSE(cleared.scalars.running);
  EXPECT_EQ(cleared.over, 0);
  return download(stage);
}

TEST(SolvePipelinedStages, AGroupWaitsForTheLastOfItsColumnsOnBoth) {
  const SheetSystem system(61, 120, 17);
  const std::vector<Index> row_begin{0, 640, 640, 5760, system.count};
  const std::vector<unsigned char> arrival{2, 3, 0, 1};
  std::vector<unsigned char> expected;
  for (Index first = row_begin[2]; first < row_begin[3]; first += pipelined_group_rows) {
    unsigned char last = 0;
    for (Index row = first; row < std::min(row_begin[3], first + pipelined_group_rows); ++row) {
      const auto look = [&](const auto& rows) {
        for (const auto& entry : rows[SheetSystem::at(row)])
          last = std::max(last, entry.first < row_begin[1]    ? arrival[0]
                                : entry.first >= row_begin[3] ? arrival[3]
                                                              : arrival[2]);
      };
      look(system.mesh);
      look(system.far);
      look(system.contact);
    }
    expected.push_back(last);
  }
  for (const int stage : {0, 1, 2})
    EXPECT_NE(std::count(expected.begin(), expected.end(), stage), 0) << stage;
  DeviceSet host = host_devices(4);
  EXPECT_EQ(stages_of(host, 2, system, row_begin, arrival), expected);
  std::string why;
  std::optional<DeviceSet> cuda = find_cuda({0, 0, 0, 0}, why);
  if (!cuda) GTEST_SKIP() << why;
  EXPECT_EQ(stages_of(*cuda, 2, system, row_begin, arrival), expected);
}

}  // namespace
}  // namespace weft::parity
