#include "host/scene/fabric/fabrics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include "host/base/file_bytes.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/scene/validate.hpp"
#include "tests/unit/io/directories.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

TEST(Fabrics, AreValidAndSortedByName) {
  const auto& all = fabrics();
  ASSERT_FALSE(all.empty());
  for (const Fabric& fabric : all) {
    EXPECT_NO_THROW(validate_material(fabric.material, "", fabric.name));
    EXPECT_EQ(find_fabric(fabric.name), &fabric);
    EXPECT_STRNE(fabric.source, "");
  }
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](const Fabric& a, const Fabric& b) {
    return std::string(a.name) < b.name;
  }));
  EXPECT_EQ(find_fabric("felt"), nullptr);
}

TEST(Fabrics, HaveTheUsualNames) {
  for (const char* name : {"silk", "cotton", "denim", "wool", "leather", "jersey", "paper"})
    EXPECT_NE(find_fabric(name), nullptr) << name;
  ASSERT_NE(find_fabric(default_fabric), nullptr);
  EXPECT_FALSE(find_fabric(default_fabric)->estimate);
}

/// Schema, README and table name the same.
TEST(Fabrics, AreAllDocumented) {
  const fs::path folder = repository_root() / "scenes";
  const std::string readme = read_file_bytes(folder / "README.md");
  const fs::path path = folder / "scene.schema.json";
  const auto schema = parse_json(read_file_bytes(path), path.string());
  const auto& names = schema.at("$defs").at("material").at("properties").at("fabric").at("enum");
  ASSERT_EQ(names.size(), fabrics().size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Fabric& f = fabrics()[i];
    EXPECT_EQ(names[i], f.name);
    const std::string kind = f.estimate ? "estimate" : "measured";
    EXPECT_NE(
        readme.find("| `" + std::string(f.name) + "` | " + f.description + " | " + kind + " |"),
        std::string::npos)
        << f.name;
    // The reasoning of an estimate stands below the table.
    if (f.estimate) {
      EXPECT_TRUE(std::string(f.source).starts_with("estimate: ")) << f.name;
      EXPECT_NE(readme.find("- `" + std::string(f.name) + "`: "), std::string::npos) << f.name;
    }
  }
}

/// The numbers against the tables that they are of, by the formulas beside them: to three digits.
TEST(Fabrics, FollowFromTheMeasurements) {
  const char* data = std::getenv("WEFT_TEST_DATA");
  const fs::path folder = data ? fs::path(data) / "arcsim" / "materials" : fs::path();
  if (!data || !fs::exists(folder)) GTEST_SKIP() << "WEFT_TEST_DATA holds no arcsim/materials";
  const std::map<std::string, std::string> files{
      {"blanket", "pink-ribbon-brown"},   {"cotton_polyester", "royal-target"},
      {"denim", "11oz-black-denim"},      {"interlock", "gray-interlock"},
      {"jersey", "gray-interlock"},       {"light_jacket", "tango-red-jet-set"},
      {"polyester", "white-dots-on-blk"}, {"ponte_roma", "camel-ponte-roma"},
      {"rib_knit", "ivory-rib-knit"},     {"sweatshirt", "navy-sparkle-sweat"},
      {"swimwear", "white-swim-solid"}};
  ASSERT_EQ(files.size(), std::count_if(fabrics().begin(), fabrics().end(),
                                        [](const Fabric& f) { return !f.estimate; }));
  for (const auto& [name, file] : files) {
    SCOPED_TRACE(name);
    const fs::path path = folder / (file + ".json");
    const auto table = parse_json(read_file_bytes(path), path.string());
    const auto s = [&](int i, int j) {
      return table.at("stretching")[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]
          .get<double>();
    };
    const auto b = [&](std::size_t i) { return table.at("bending")[i][0].get<double>(); };
    ASSERT_NE(find_fabric(name), nullptr);
    const Material& m = find_fabric(name)->material;
    const auto expect = [](double expected, double found) {
      EXPECT_NEAR(found / expected, 1, 5.1e-3);
    };
    const double c11 = s(0, 0) + s(1, 0), c22 = s(0, 2) + s(5, 2), c33 = s(0, 3) + s(3, 3);
    const double c12 = s(0, 1) + (s(1, 1) + s(5, 1)) / 2;
    EXPECT_EQ(table.at("density").get<double>(), m.density);
    expect(c11 - c12 * c12 / c22, m.orthotropic->warp);
    expect(c22 - c12 * c12 / c11, m.orthotropic->weft);
    expect(c12 / c22, m.orthotropic->poisson_ratio);
    expect(c33 / 2, m.orthotropic->shear);
    expect(b(2) / 4, m.orthotropic_bending->warp);
    expect(b(0) / 4, m.orthotropic_bending->weft);
    EXPECT_EQ(m.orthotropic_bending->coupling, 0);
    expect(b(1) / 4 - (b(0) + b(2)) / 16, m.orthotropic_bending->twist);
  }
}

}  // namespace
}  // namespace weft::io
