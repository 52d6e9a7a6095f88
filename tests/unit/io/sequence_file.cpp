#include "host/io/animation/sequence_file.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

Mesh grown(double factor) {
  Mesh mesh = make_icosphere(1, 1);
  for (Vec3<double>& x : mesh.positions) x = x * factor + Vec3<double>{0, factor, 0};
  return mesh;
}

class SequenceTest : public DirectoryTest {
 protected:
  /// body_07 to body_09
  void put_objs() {
    for (int number = 7; number < 10; ++number)
      write_obj(directory_ / ("body_0" + std::to_string(number) + ".obj"),
                {{"body", grown(number - 6)}});
  }

  std::filesystem::path put_cache(std::int32_t points, float sample_rate,
                                  const std::vector<float>& numbers) {
    const auto samples = static_cast<std::int32_t>(numbers.size()) / (3 * points);
    std::string bytes("POINTCACHE2\0", 12);
    const auto add = [&](const auto& value) {
      char raw[4];
      std::memcpy(raw, &value, 4);
      bytes.append(raw, 4);
    };
    add(std::int32_t{1});
    add(points);
    add(5.0f);
    add(sample_rate);
    add(samples);
    for (const float x : numbers) add(x);
    return put("points.pc2", bytes);
  }

  std::string refusal(const SequenceChoice& choice) const {
    try {
      read_mesh_sequence(directory_ / "body_%02d.obj", choice);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(SequenceTest, HitsEveryFile) {
  put_objs();
  SequenceChoice choice;
  choice.first = 7;
  choice.frame_rate = 10;
  choice.playback.start_time = 2;
  const SampledSurface surface = read_mesh_sequence(directory_ / "body_%02d.obj", choice);
  EXPECT_EQ(surface.deformation->frame_count(), 3u);
  EXPECT_EQ(surface.triangles.size(), 80u);
  std::vector<Vec3<double>> out(surface.deformation->vertex_count());
  for (int f = 0; f < 3; ++f) {
    surface.deformation->positions(2 + f / 10.0, out);
    const Mesh expected = grown(f + 1);
    // Stored as floats: half a unit of the last place of a radius.
    const double bound = (f + 1) * 6e-8;
    for (std::size_t v = 0; v < out.size(); ++v)
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(out[v][k], expected.positions[v][k], bound) << "frame " << f;
  }
}

TEST_F(SequenceTest, LaterFramesMayNotLeaveTheWorld) {
  put_objs();
  Mesh far = grown(2);
  far.positions[5][1] = 1e30;
  write_obj(directory_ / "body_08.obj", {{"body", far}});
  SequenceChoice choice;
  choice.first = 7;
  EXPECT_NE(refusal(choice).find("body_08.obj: frame 8: vertex 5: 1e30"), std::string::npos)
      << refusal(choice);
}

TEST_F(SequenceTest, EndsWhereItIsToldTo) {
  put_objs();
  SequenceChoice choice;
  choice.first = 7;
  choice.last = 8;
  EXPECT_EQ(read_mesh_sequence(directory_ / "body_%02d.obj", choice).deformation->frame_count(),
            2u);
  choice.last = 10;
  EXPECT_NE(refusal(choice).find("body_10.obj"), std::string::npos);
  choice.first = 6;
  EXPECT_NE(refusal(choice).find("body_06.obj"), std::string::npos);
}

TEST_F(SequenceTest, RefusesAnotherMesh) {
  put_objs();
  write_obj(directory_ / "body_08.obj", {{"body", make_icosphere(1, 0)}});
  SequenceChoice choice;
  choice.first = 7;
  EXPECT_NE(refusal(choice).find("body_08.obj: mesh: 12 vertices"), std::string::npos)
      << refusal(choice);
  Mesh turned = grown(2);
  std::swap(turned.triangles[3], turned.triangles[4]);
  write_obj(directory_ / "body_08.obj", {{"body", turned}});
  EXPECT_NE(refusal(choice).find("body_08.obj"), std::string::npos);
  EXPECT_THROW(read_mesh_sequence(directory_ / "body.obj", choice), SceneError);
}

TEST_F(SequenceTest, RefusesWhatNoMemoryHolds) {
  put_objs();
  SequenceChoice choice;
  choice.first = 7;
  choice.last = 100'000'000;
  EXPECT_NE(refusal(choice).find("MiB"), std::string::npos) << refusal(choice);
}

TEST_F(SequenceTest, PointCacheIsExactAndTimed) {
  const auto mesh = put("body.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::vector<float> numbers{0, 0,    0, 1, 0,    0, 0, 1,    0,  //
                                   0, 0.1f, 0, 1, 0.1f, 0, 0, 1.1f, 0,  //
                                   0, 0.3f, 0, 1, 0.3f, 0, 0, 1.3f, 0};
  const auto points = put_cache(3, 2, numbers);
  SequenceChoice choice;
  choice.frame_rate = 20;  // a sample every two frames: every 0.1 s
  const SampledSurface surface = read_point_cache_sequence(mesh, points, choice);
  std::vector<Vec3<double>> out(3);
  for (std::size_t f = 0; f < 3; ++f) {
    surface.deformation->positions(static_cast<double>(f) * 2 / 20, out);
    for (std::size_t v = 0; v < 3; ++v)
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(out[v][k],
                  static_cast<double>(numbers[f * 9 + v * 3 + static_cast<std::size_t>(k)]));
  }
  choice.y_up = true;
  choice.first = 2;
  const SampledSurface turned = read_point_cache_sequence(mesh, points, choice);
  turned.deformation->positions(0, out);
  EXPECT_TRUE(out[2] == (Vec3<double>{0, 0, static_cast<double>(1.3f)}));
  choice.last = 3;
  EXPECT_THROW(read_point_cache_sequence(mesh, points, choice), SceneError);
}

TEST_F(SequenceTest, PointCacheMayHaveAnOrigin) {
  const auto mesh = put("body.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto points = put_cache(3, 1, {0, 0.1f, 0.7f, 1, 0, 0, 0, 1, 0});
  write_cache_origin(points, {0x1p20, 0, -0x1p18});
  const SampledSurface surface = read_point_cache_sequence(mesh, points, {});
  std::vector<Vec3<double>> out(3);
  surface.deformation->positions(0, out);
  EXPECT_EQ(out[0],
            (Vec3<double>{0x1p20, static_cast<double>(0.1f), static_cast<double>(0.7f) - 0x1p18}));
}

TEST_F(SequenceTest, PointCacheMustFitItsMesh) {
  const auto mesh = put("body.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto points = put_cache(2, 1, {0, 0, 0, 1, 0, 0});
  EXPECT_THROW(read_point_cache_sequence(mesh, points, {}), SceneError);
}

}  // namespace
}  // namespace weft::io
