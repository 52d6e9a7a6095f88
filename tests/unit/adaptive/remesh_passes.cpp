// Remeshing again and again, on meshes of several kinds: what must hold after every pass.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "host/lab/check/validator.hpp"
#include "tests/unit/adaptive/remesh_scenes.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

/// A smooth random field of three numbers over the plane.
struct Waves {
  Vec3<double> amplitude[4];
  Vec2<double> wave[4];
  double phase[4];

  Waves(std::mt19937_64& random, double size, double longest) {
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int k = 0; k < 4; ++k) {
      amplitude[k] = size * Vec3<double>{unit(random), unit(random), unit(random)};
      wave[k] = (8 / longest) * Vec2<double>{unit(random), unit(random)};
      phase[k] = 4 * unit(random);
    }
  }
  Vec3<double> operator()(const Vec2<double>& u) const {
    Vec3<double> sum{0, 0, 0};
    for (int k = 0; k < 4; ++k) sum += std::sin(dot(wave[k], u) + phase[k]) * amplitude[k];
    return sum;
  }
};

struct Sample {
  Scene scene;
  bool tube = false;  ///< its start is a tube about the z axis
};

Mesh irregular_mesh() {
  Mesh mesh = make_disc(0.5, 7);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-0.02, 0.02);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (length(mesh.material[v]) > 0.45) continue;
    mesh.material[v] += Vec2<double>{unit(random), unit(random)};
    mesh.positions[v] = {mesh.material[v][0], mesh.material[v][1], 0};
  }
  return mesh;
}

/// A tube whose pattern has a seam within the cloth.
Mesh tube_mesh() {
  const Index n = 12, rows = 8;
  Mesh grid = make_grid({1, 0.6}, {n, rows}, Diagonals::alternating);
  Mesh mesh;
  mesh.material = grid.material;
  mesh.material_triangles = grid.triangles;
  std::vector<Index> number;
  for (const Vec2<double>& u : grid.material) {
    const double angle = 2 * 3.14159265358979323846 * (u[0] + 0.5);
    if (u[0] == 0.5) {  // one with the first of its row
      number.push_back(number[number.size() - static_cast<std::size_t>(n)]);
      continue;
    }
    number.push_back(static_cast<Index>(mesh.positions.size()));
    mesh.positions.push_back({0.16 * std::cos(angle), 0.16 * std::sin(angle), u[1]});
  }
  for (const Tri& t : grid.triangles)
    mesh.triangles.push_back(
        {{number[static_cast<std::size_t>(t.v[0])], number[static_cast<std::size_t>(t.v[1])],
          number[static_cast<std::size_t>(t.v[2])]}});
  return mesh;
}

Sample sample(int kind) {
  if (kind == 0) return {scene_of({irregular_mesh()})};
  if (kind == 1) return {scene_of({make_grid({1, 0.4}, {24, 3}, Diagonals::same)})};
  if (kind == 2) return {scene_of({tube_mesh()}), true};
  // Two panels whose edges are sewn to each other.
  Sample two{scene_of({make_grid({0.5, 0.5}, {6, 6}, Diagonals::alternating),
                       make_grid({0.5, 0.5}, {6, 6}, Diagonals::alternating)})};
  for (Vec3<double>& x : two.scene.cloths[1].mesh.positions) x[0] += 0.6;
  Seam seam;
  seam.cloths[1] = 1;
  for (Index j = 0; j <= 6; ++j) {
    seam.vertices[0].push_back(grid_vertex(6, 6, j));
    seam.vertices[1].push_back(grid_vertex(6, 0, j));
  }
  two.scene.seams.push_back(seam);
  return two;
}

struct Sums {
  double mass = 0, scale = 0;
  Vec3<double> momentum{0, 0, 0};
};

Sums sums_of(const Scene& scene, const InputState& state) {
  Sums sums;
  std::size_t first = 0;
  for (const Cloth& cloth : scene.cloths) {
    const Mesh& mesh = cloth.mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Tri& c =
          mesh.material_triangles.empty() ? mesh.triangles[t] : mesh.material_triangles[t];
      const auto u = [&](int j) { return mesh.material[static_cast<std::size_t>(c.v[j])]; };
      const Vec2<double> a = u(1) - u(0), b = u(2) - u(0);
      const double mass = 0.2 * (a[0] * b[1] - a[1] * b[0]) / 2;
      sums.mass += mass;
      for (const Index v : mesh.triangles[t].v) {
        const Vec3<double>& w = state.velocities[first + static_cast<std::size_t>(v)];
        sums.momentum += mass / 3 * w;
        sums.scale += mass / 3 * length(w);
      }
    }
    first += mesh.positions.size();
  }
  return sums;
}

Remeshing random_settings(std::mt19937_64& random) {
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  Remeshing s;
  s.size_min = between(0.03, 0.08);
  s.size_max = s.size_min * between(1, 8);
  s.refine_angle = between(0.1, 1);
  s.refine_velocity = between(0.2, 2);
  s.aspect_min = between(0.05, 0.4);
  return s;
}

/// Passes over one kind of mesh, each with another shape, motion and sizing.
void check_random_passes(int kind, int passes) {
  std::mt19937_64 random(static_cast<std::uint64_t>(100 + kind));
  Sample s = sample(kind);
  std::vector<unsigned char> kept = named_inputs(s.scene);
  const double mass = sums_of(s.scene, state_at_start(s.scene)).mass;
  std::int64_t done = 0;
  for (int pass = 0; pass < passes; ++pass) {
    const Waves shape(random, s.tube ? 0.01 : 0.04, 1), motion(random, 0.5, 1);
    InputState state = state_at_start(s.scene);
    for (std::size_t i = 0; i < state.positions.size(); ++i) {
      Vec3<double>& x = state.positions[i];
      const Vec2<double> u{x[0] + 0.3 * x[2], x[1]};
      state.velocities[i] = motion(u);
      // A graph over the plane, and a tube of any width, cannot run into themselves.
      if (s.tube)
        x += (shape(u)[2] / std::hypot(x[0], x[1])) * Vec3<double>{x[0], x[1], 0};
      else
        x[2] += shape(u)[2];
    }
    s.scene.adaptive.remeshing = random_settings(random);
    const Sums before = sums_of(s.scene, state);
    const InputState given = state;
    const SceneRemesh result = remeshed(s.scene, std::move(state), {}, kept);
    if (!result.changed()) continue;
    done += result.counts.splits + result.counts.flips + result.counts.collapses;
    kept = result.kept;
    ASSERT_NO_THROW(validate(s.scene)) << "pass " << pass;
    const Sums after = sums_of(s.scene, result.state);
    ASSERT_NEAR(after.mass, mass, 1e-12 * mass) << "pass " << pass;
    ASSERT_LE(length(after.momentum - before.momentum), 1e-12 * before.scale) << "pass " << pass;
    std::size_t first = 0;
    for (const Cloth& cloth : s.scene.cloths) {
      Mesh mesh = cloth.mesh;
      std::copy_n(result.state.positions.begin() + static_cast<std::ptrdiff_t>(first),
                  mesh.positions.size(), mesh.positions.begin());
      first += mesh.positions.size();
      const lab::FrameVerdict verdict = lab::validate(mesh, nullptr);
      ASSERT_TRUE(verdict.clean()) << "pass " << pass;
    }
  }
  EXPECT_GT(done, 10 * passes);
}

class RemeshPasses : public testing::TestWithParam<int> {};

TEST_P(RemeshPasses, KeepWhatTheyPromise) {
  check_random_passes(GetParam(), 25);
}

TEST_P(RemeshPasses, SlowKeepWhatTheyPromiseAThousandTimes) {
  check_random_passes(GetParam(), 1000);
}

std::string name_of_mesh(const testing::TestParamInfo<int>& mesh) {
  const char* const names[] = {"Irregular", "Anisotropic", "Seamed", "Sewn"};
  return names[mesh.param];
}

INSTANTIATE_TEST_SUITE_P(Meshes, RemeshPasses, testing::Range(0, 4), name_of_mesh);

}  // namespace
}  // namespace weft::test
