#include "host/io/animation/mesh_sequence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/base/file_bytes.hpp"
#include "host/geometry/vertex_normals.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

using Sequences = DirectoryTest;

Mesh sheet() {
  return make_grid({1, 1}, {2, 2}, Diagonals::same);
}

void write_cache(const std::filesystem::path& path, Index points, int frames, double start = 0) {
  PointCacheWriter writer(path, PointCacheHeader{points, start, 1, 0});
  for (int f = 0; f < frames; ++f) {
    const std::vector<Vec3<double>> positions(static_cast<std::size_t>(points), {1.0 * f, 0, 0});
    writer.append(positions);
  }
}

// ------------------------------------------------------------------------------------------- names
TEST(NumberedName, PlacesForNumbers) {
  EXPECT_EQ(NumberedName("a_%05d.obj").with(12), "a_00012.obj");
  EXPECT_EQ(NumberedName("%d").with(123456), "123456");
  EXPECT_EQ(NumberedName("a_%02d.obj").with(123), "a_123.obj");
  EXPECT_FALSE(NumberedName("a.obj").has_place());
  EXPECT_EQ(NumberedName("a.obj").with(4), "a.obj");
  for (const char* bad :
       {"a_%s.obj", "a_%", "a_%05d_%d.obj", "a_%-5d.obj", "a_%3d.obj", "a_%99d.obj", "%n"})
    EXPECT_THROW(NumberedName{bad}, SceneError) << bad;
}

TEST(NumberedName, FindsNumbers) {
  const NumberedName name("a_%03d.obj");
  EXPECT_EQ(name.number_in("a_012.obj"), 12);
  EXPECT_EQ(name.number_in("a_1234.obj"), 1234);
  for (const char* other : {"a_12.obj", "a_.obj", "a_0x2.obj", "b_012.obj", "a_012.ply", "a_012",
                            "a_-12.obj", "a_99999999999999.obj", ""})
    EXPECT_EQ(name.number_in(other), -1) << other;
}

// ------------------------------------------------------------------------------------------
// opening
TEST_F(Sequences, NumberedFilesNeedNotStartAtZero) {
  for (const int k : {3, 5, 11}) {
    Mesh mesh = sheet();
    mesh.positions[0] = {1.0 * k, 0, 0};
    write_obj(directory_ / NumberedName("m%02d.obj").with(k), {{"m", mesh}});
  }
  put("m7.obj", "not of this pattern");
  const auto sequence = open_sequence(directory_ / "m%02d.obj");
  EXPECT_EQ(sequence->frames(), (std::vector<int>{3, 5, 11}));
  EXPECT_EQ(sequence->read(2).cloths[0].mesh.positions[0][0], 11);
  EXPECT_THROW(open_sequence(directory_ / "n%02d.obj"), SceneError);
}

TEST_F(Sequences, CachesOfARunThatWasKilled) {
  const auto frames = directory_ / "frames";
  std::filesystem::create_directories(frames);
  for (const char* name : {"cloth.a.obj", "cloth.b.obj", "obstacle.o.obj", "obstacle.still.obj"})
    write_obj(frames / name, {{"x", sheet()}});
  write_cache(frames / "cloth.a.pc2", 9, 3);
  write_cache(frames / "cloth.b.pc2", 9, 3);
  write_cache(frames / "obstacle.o.pc2", 9, 4);
  EXPECT_TRUE(has_frame_caches(frames));
  put("scene.json", R"({"time": {"frame_rate": 60}})");
  const auto sequence = open_sequence(directory_);
  EXPECT_EQ(sequence->frames(), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(sequence->frame_rate(), 60);
  const FrameMeshes meshes = sequence->read(2);
  ASSERT_EQ(meshes.cloths.size(), 2u);
  ASSERT_EQ(meshes.obstacles.size(), 2u);
  EXPECT_EQ(meshes.cloths[1].name, "b");
  EXPECT_EQ(meshes.cloths[1].mesh.positions[4][0], 2);
  EXPECT_EQ(meshes.obstacles[1].name, "still");
  EXPECT_EQ(meshes.obstacles[1].mesh.positions.size(), 9u);
  put("scene.json", "{");
  EXPECT_EQ(open_sequence(directory_)->frame_rate(), 25);
}

TEST_F(Sequences, RefusesCachesThatDoNotFit) {
  write_obj(directory_ / "a.obj", {{"x", sheet()}});
  EXPECT_THROW(open_sequence(directory_ / "a.pc2"), SceneError);
  write_cache(directory_ / "b.pc2", 9, 3);
  EXPECT_THROW(open_sequence(directory_ / "b.pc2"), SceneError) << "no topology";
  write_cache(directory_ / "a.pc2", 8, 3);
  EXPECT_THROW(open_sequence(directory_ / "a.pc2"), SceneError) << "another number of points";
  write_cache(directory_ / "a.pc2", 9, 0);
  EXPECT_THROW(open_sequence(directory_ / "a.pc2"), SceneError) << "no samples";
  write_cache(directory_ / "a.pc2", 9, 2, -1);
  EXPECT_THROW(open_sequence(directory_ / "a.pc2"), SceneError) << "a negative frame";
  write_cache(directory_ / "a.pc2", 9, 2, 4);
  EXPECT_EQ(open_sequence(directory_ / "a.pc2")->frames(), (std::vector<int>{4, 5}));
  EXPECT_THROW(open_sequence(directory_), SceneError) << "no frames of a run";
}

// ------------------------------------------------------------------------------ what is written
TEST(Joined, NumbersGoOn) {
  Mesh seam;
  seam.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  seam.triangles = {{{0, 1, 2}}};
  seam.material = {{0, 0}, {1, 0}, {0, 1}, {9, 9}};
  seam.material_triangles = {{{3, 1, 2}}};
  const Mesh all = joined({{"a", sheet()}, {"b", seam}});
  EXPECT_EQ(all.positions.size(), 12u);
  EXPECT_EQ(all.material.size(), 13u);
  ASSERT_EQ(all.material_triangles.size(), 9u);
  EXPECT_EQ(all.triangles[8].v[0], 9);
  EXPECT_EQ(all.material_triangles[8].v[0], 12);
  EXPECT_EQ(all.material_triangles[0].v[2], all.triangles[0].v[2]);
  Mesh bare = seam;
  bare.material.clear();
  bare.material_triangles.clear();
  EXPECT_TRUE(joined({{"a", sheet()}, {"b", bare}}).material.empty());
}

TEST(VertexNormals, MeansWeightedByArea) {
  // A large triangle in the xy plane and one of half its area in the xz plane.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -0.5}, {7, 7, 7}};
  mesh.triangles = {{{0, 1, 2}}, {{0, 3, 1}}};
  const auto normals = vertex_normals(mesh);
  const double c = 1 / std::sqrt(1.25);
  // (0, 0, 1) and (0, -0.5, 0)
  EXPECT_NEAR(normals[0][1], -0.5 * c, 1e-7);
  EXPECT_NEAR(normals[0][2], c, 1e-7);
  EXPECT_EQ(normals[2][2], 1);
  EXPECT_EQ(normals[3][1], -1);
  EXPECT_EQ(normals[4][2], 1) << "no triangle";
  for (auto& x : mesh.positions) x *= 1e-120;
  EXPECT_NEAR(vertex_normals(mesh)[0][2], c, 1e-7) << "the scale must not matter";
}

TEST(ObjText, NormalsAndSeams) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{{0, 1, 2}}};
  const auto text = [&](Normals normals) { return format_obj({{"", mesh}, {"b", mesh}}, normals); };
  EXPECT_NE(text(Normals::none).find("f 1 2 3\n"), std::string::npos);
  EXPECT_NE(text(Normals::vertex).find("vn 0 0 1\nf 1//1 2//2 3//3\n"), std::string::npos);
  mesh.material = {{0, 0}, {1, 0}, {0, 1}, {9, 9}};
  mesh.material_triangles = {{{3, 1, 2}}};
  EXPECT_NE(text(Normals::none).find("f 1/4 2/2 3/3\n"), std::string::npos);
  EXPECT_NE(text(Normals::vertex).find("f 4/8/4 5/6/5 6/7/6\n"), std::string::npos);
}

TEST_F(Sequences, NormalsInPlyChangeNothingElse) {
  write_ply(directory_ / "a.ply", {{"a", sheet()}}, Precision::double_precision, Normals::vertex);
  const Mesh mesh = read_mesh(directory_ / "a.ply");
  ASSERT_EQ(mesh.positions.size(), 9u);
  EXPECT_TRUE(mesh.positions[5] == sheet().positions[5]);
  EXPECT_TRUE(mesh.material[5] == sheet().material[5]);
  const std::string bytes = read_file_bytes(directory_ / "a.ply");
  EXPECT_NE(bytes.find("property float nz"), std::string::npos);
}

}  // namespace
}  // namespace weft::io
