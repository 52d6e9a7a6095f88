// The engine against closed forms of mechanics: the tests of weft_bench_physics, each at the
// parameters that the table in docs/validation.md shows, and each within its own tolerance. What is
// known to miss (benchmarks/physics/known_misses.cpp) has to miss.
#include <gtest/gtest.h>

#include <cctype>
#include <ostream>
#include <string>
#include <vector>

#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"

namespace weft::physics {
namespace {

struct Case {
  std::string test;
  std::vector<std::string> overrides;
  bool table = false;  ///< its reference stands in a file of WEFT_TEST_DATA
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.test;
  for (const std::string& text : c.overrides) *out << ' ' << text;
}

/// Letters, digits and underscores, as GoogleTest wants them.
std::string name_of(const ::testing::TestParamInfo<Case>& info) {
  std::string name = info.param.test;
  for (const std::string& text : info.param.overrides) name += "_" + text;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}

void check(const Case& c) {
  if (c.table && !has_tables()) GTEST_SKIP() << "WEFT_TEST_DATA names no folder of tables";
  const Test& test = find_test(c.test);
  const Parameters parameters(test.parameters, c.overrides);
  const Outcome outcome = test.run(parameters);
  ASSERT_TRUE(outcome.error && outcome.tolerance);
  ::testing::Test::RecordProperty("value", std::to_string(outcome.value));
  ::testing::Test::RecordProperty("error", std::to_string(*outcome.error));
  if (const char* reason = known_miss(test.name, parameters))
    EXPECT_GT(*outcome.error, *outcome.tolerance)
        << "passes now: take it out of known_misses.cpp; it says: " << reason;
  else
    EXPECT_LE(*outcome.error, *outcome.tolerance)
        << "value " << outcome.value << ", reference " << *outcome.reference;
}

class PhysicsTest : public ::testing::TestWithParam<Case> {};
class SlowPhysicsTest : public ::testing::TestWithParam<Case> {};

TEST_P(PhysicsTest, AgreesWithTheReference) {
  check(GetParam());
}

TEST_P(SlowPhysicsTest, AgreesWithTheReference) {
  check(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Integrator, PhysicsTest,
                         ::testing::Values(Case{"amplitude", {}},
                                           Case{"amplitude", {"integrator=bdf2"}},
                                           Case{"free_fall", {}},
                                           Case{"free_fall", {"integrator=bdf2"}},
                                           Case{"order", {}}, Case{"order", {"integrator=bdf2"}},
                                           Case{"flight_momentum", {}}, Case{"flight_energy", {}}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Membrane, PhysicsTest,
                         ::testing::Values(Case{"patch", {}}, Case{"patch", {"mesh=rotated"}},
                                           Case{"patch", {"mesh=irregular"}},
                                           Case{"patch", {"mesh=random"}},
                                           Case{"patch", {"mesh=aniso"}},
                                           Case{"membrane_modes", {}}, Case{"membrane_order", {}},
                                           Case{"hencky", {}, true}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Hanging, PhysicsTest,
                         ::testing::Values(Case{"hanging_sheet", {}},
                                           Case{"hanging_sheet", {"mode=2"}},
                                           Case{"hanging_strip", {}}, Case{"catenary", {}},
                                           Case{"folded_strip", {}}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Friction, PhysicsTest,
                         ::testing::Values(Case{"incline_slides", {}}, Case{"incline_holds", {}},
                                           Case{"stopping", {}}, Case{"capstan", {}},
                                           Case{"sliding_off", {}}, Case{"stick_slip", {}}),
                         name_of);

/// With the solver's default settings.
Case capstan_at(const char* step) {
  return {"capstan", {std::string("step=") + step, "newton=0", "tolerance=0.01", "time=1.6"}};
}

INSTANTIATE_TEST_SUITE_P(FrictionAtSteps, PhysicsTest,
                         ::testing::Values(capstan_at("0.0025"), capstan_at("0.01"),
                                           capstan_at("0.02")),
                         name_of);

INSTANTIATE_TEST_SUITE_P(
    Bending, PhysicsTest,
    ::testing::Values(Case{"half_cylinder", {}}, Case{"half_cylinder", {"mesh=rotated"}},
                      Case{"half_cylinder", {"mesh=irregular"}},
                      Case{"half_cylinder", {"mesh=random"}},
                      Case{"half_cylinder", {"mesh=random", "bending=hinge"}},
                      Case{"half_cylinder_membrane", {}}, Case{"flattened", {}},
                      Case{"flattened", {"mesh=irregular"}}, Case{"flattened", {"bending=hinge"}},
                      Case{"keeps_shape", {}}, Case{"keeps_shape", {"bending=hinge"}},
                      Case{"plate_modes", {}}, Case{"plate_modes", {"mode=2"}},
                      Case{"plate_modes", {"mode=3"}}, Case{"tip_load", {}, true},
                      Case{"euler_buckling", {}}, Case{"lateral_limit", {}},
                      Case{"lateral_limit", {"nu=0.35"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    Bending, SlowPhysicsTest,
    ::testing::Values(Case{"cantilever", {}, true}, Case{"cantilever", {"gamma=1"}, true},
                      Case{"cantilever", {"gamma=100"}, true}, Case{"roll_up", {}},
                      Case{"cusick_drape", {"fabric=silk"}},
                      Case{"cusick_drape", {"fabric=cotton"}},
                      Case{"cusick_drape", {"fabric=denim"}},
                      Case{"lateral_buckling", {"ratio=1", "nu=0.35"}},
                      Case{"lateral_buckling", {"mesh=irregular"}}, Case{"lateral_buckling", {}},
                      Case{"lateral_buckling", {"nu=0.35"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(Membrane, SlowPhysicsTest, ::testing::Values(Case{"mylar_balloon", {}}),
                         name_of);

}  // namespace
}  // namespace weft::physics
