// Keys of scenes and reports of version 0.1 that have other names, or are gone.
#include <string>
#include <utility>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class RenamedKeys : public Process {};

TEST_F(RenamedKeys, OldKeysOfScenesAreRefusedWithTheirNewNames) {
  const std::pair<const char*, const char*> keys[] = {
      {"contact.halvings", "substep_bisections"},
      {"contact.yielding_distance", "compliance_distance"},
      {"method.time_parallel.seam_tolerance", "boundary_tolerance"}};
  for (const auto& [was, is] : keys) {
    EXPECT_EQ(run("out", {"--set", std::string(was) + "=3"}), 2) << was;
    EXPECT_NE(err_.find(std::string(was) + ": "), std::string::npos) << err_;
    EXPECT_NE(err_.find("its new name, \"" + std::string(is) + "\""), std::string::npos) << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
  }
}

TEST_F(RenamedKeys, AKeyThatIsGoneIsRefusedWithAdvice) {
  const std::string refusal =
      "weft: small.json: contact.stiffness: no longer a key: remove it; contacts choose their "
      "stiffness themselves\n";
  EXPECT_EQ(run("out", {"--set", "contact.stiffness=30"}), 2);
  EXPECT_EQ(err_, refusal);
  Json scene = Json::parse(small_scene);
  scene["contact"]["stiffness"] = 30;
  write("small.json", scene.dump());
  EXPECT_EQ(run("out"), 2);
  EXPECT_EQ(err_, refusal);
  EXPECT_FALSE(fs::exists(at("out")));
}

TEST_F(RenamedKeys, ReportsSayWhichSchemaTheyFollow) {
  ASSERT_EQ(run("out", {"--frames", "1"}), 0) << err_;
  const Json document = report("out");
  EXPECT_EQ(document.at("schema_version"), 2);
  EXPECT_TRUE(document.at("contacts").contains("compliance_distance_max"));
  EXPECT_TRUE(document.at("contacts").contains("steps_at_fallback_level"));
}

}  // namespace
}  // namespace weft::test
