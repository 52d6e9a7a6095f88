// Shares of compression over remeshes, and how fast they may rise.
#include "host/simulation/compression.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "host/model/material_rows.hpp"
#include "weft/core/at.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

Scene sheet_scene(int cells) {
  Scene scene;
  scene.materials.emplace_back();
  Cloth sheet;
  sheet.mesh = make_grid({1, 1}, {cells, cells}, Diagonals::same);
  scene.cloths.push_back(std::move(sheet));
  return scene;
}

TEST(CarriedCompression, StaysWithTrianglesAndSpreadsToNewOnes) {
  const Scene before = sheet_scene(3);
  const Model from = make_model(before);
  const std::size_t count = before.cloths[0].mesh.triangles.size();
  std::vector<double> shares(count, 0.5);
  shares.back() = 0.1;
  std::vector<Index> same;
  for (Index v = 0; v < 16; ++v) same.push_back(v);
  EXPECT_TRUE(carried_compression(from, {}, same, from).empty());
  EXPECT_EQ(carried_compression(from, shares, same, from), shares);

  // The first triangle gets a vertex in its middle.
  Scene after = before;
  Mesh& mesh = after.cloths[0].mesh;
  const Tri split = mesh.triangles[0];
  const auto middle = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back((1.0 / 3) *
                           (mesh.positions[at(split.v[0])] + mesh.positions[at(split.v[1])] +
                            mesh.positions[at(split.v[2])]));
  mesh.material.push_back((1.0 / 3) *
                          (mesh.material[at(split.v[0])] + mesh.material[at(split.v[1])] +
                           mesh.material[at(split.v[2])]));
  mesh.triangles[0] = {{split.v[0], split.v[1], middle}};
  mesh.triangles.push_back({{split.v[1], split.v[2], middle}});
  mesh.triangles.push_back({{split.v[2], split.v[0], middle}});
  shares[0] = 0.2;
  std::vector<double> expected = shares;
  expected.insert(expected.end(), {0.2, 0.2});
  std::vector<Index> with_new = same;
  with_new.push_back(-1);
  EXPECT_EQ(carried_compression(from, shares, with_new, make_model(after)), expected);

  // Nothing but new vertices says nothing.
  const std::vector<Index> all_new(16, -1);
  EXPECT_EQ(carried_compression(from, shares, all_new, from), std::vector<double>(count, 1));
}

TEST(LimitedCompression, GivesEachTriangleItsShareOfTheEnergy) {
  const Scene scene = sheet_scene(2);
  const Model model = make_model(scene);
  std::vector<Vec3<double>> positions;
  for (const Index input : model.to_input) {
    Vec3<double> x = scene.cloths[0].mesh.positions[at(input)];
    if (x[0] > 0) x[0] *= 0.8;
    positions.push_back(x);
  }
  const std::size_t count = model.input_triangle.size();
  const auto energy = [&](const std::vector<double>& shares) {
    double sum = 0;
    for (std::size_t t = 0; t < count; ++t) {
      const Index* v = model.triangles[t].v;
      const Vec3<double> x[3] = {positions[at(v[0])], positions[at(v[1])], positions[at(v[2])]};
      sum += stretching_energy(model.laws->rows, model.material[t], x, model.inv_rest[t],
                               model.area[t],
                               shares.empty() ? 1 : shares[at(model.input_triangle[t])]);
    }
    return sum;
  };
  const std::vector<double> none(count, 0);
  const double whole = energy({});
  ASSERT_GT(whole, 0);
  EXPECT_TRUE(limited_compression(model, positions, none, {}, whole).empty());
  EXPECT_EQ(limited_compression(model, positions, {}, none, 0), none) << "falls are free";
  const std::vector<double> half = limited_compression(model, positions, none, {}, whole / 2);
  EXPECT_NEAR(energy(half), whole / 2, 1e-4 * whole);
  for (std::size_t t = 0; t < count; ++t) {
    const Index input = model.input_triangle[t];
    double right = 0;
    for (const Index v : scene.cloths[0].mesh.triangles[at(input)].v)
      right += scene.cloths[0].mesh.positions[at(v)][0];
    if (right > 0)
      EXPECT_LT(half[at(input)], 0.9);
    else
      EXPECT_EQ(half[at(input)], 1) << "not compressed";
  }
}

}  // namespace
}  // namespace weft::test
