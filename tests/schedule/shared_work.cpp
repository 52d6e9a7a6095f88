// Work on the host that ranks share out, since they read each other's memory.
#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "host/exec/host_devices.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/exec/launch_observer.hpp"
#include "weft/kernels/assemble/active_set_update.hpp"
#include "weft/kernels/collide/boxes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// Counts the contacts that all updates of the active set go over.
class UpdatedContacts final : public LaunchObserver {
 public:
  void before(Queue&) override {}
  void after(Queue&, const std::type_info& kernel, const void* args) override {
    if (kernel != typeid(AssembleActiveSetUpdate<float>)) return;
    ++launches;
    contacts += static_cast<const AssembleActiveSetUpdate<float>*>(args)->contacts.size();
  }

  std::size_t launches = 0;
  std::size_t contacts = 0;
};

/// Which parts of which lists all launches of a set of ranks make.
class MadeBoxes final : public LaunchObserver {
 public:
  void before(Queue&) override {}
  void after(Queue&, const std::type_info& kernel, const void* args) override {
    if (kernel != typeid(CollideBoxes<float>)) return;
    const auto& boxes = *static_cast<const CollideBoxes<float>*>(args);
    parts.insert({boxes.part, boxes.parts});
    lists.insert(boxes.lists[cloth_faces].clusters.data());
  }

  std::set<std::pair<int, int>> parts;
  std::set<const void*> lists;
};

TEST(SharedWork, EachBoxIsMadeByOneRank) {
  for (const int ranks : {1, 3}) {
    MadeBoxes made;
    LaunchObserver::current = &made;
    Simulation simulation(test::sheet_on_sphere(Precision::single_precision), host_devices(ranks));
    EXPECT_EQ(simulation.step().failure, Failure::none);
    LaunchObserver::current = nullptr;
    std::set<std::pair<int, int>> all;
    for (int r = 0; r < ranks; ++r) all.insert({r, ranks});
    EXPECT_EQ(all, made.parts);
    EXPECT_EQ(1u, made.lists.size());
  }
}

TEST(SharedWork, EachContactIsUpdatedByOneRank) {
  UpdatedContacts counted[3];
  for (const int ranks : {1, 2, 3}) {
    UpdatedContacts& own = counted[ranks - 1];
    LaunchObserver::current = &own;
    Simulation simulation(test::sheet_on_sphere(Precision::single_precision), host_devices(ranks));
    for (int k = 0; k < 8; ++k) EXPECT_EQ(simulation.step().failure, Failure::none);
    LaunchObserver::current = nullptr;
  }
  EXPECT_GT(counted[0].contacts, 0u);
  for (const std::size_t n : {1u, 2u}) {
    EXPECT_EQ(counted[0].contacts, counted[n].contacts);
    EXPECT_EQ((n + 1) * counted[0].launches, counted[n].launches);
  }
}

}  // namespace
}  // namespace weft
