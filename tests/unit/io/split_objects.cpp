#include "host/io/mesh/split_objects.hpp"

#include <gtest/gtest.h>

#include <array>

#include "host/io/mesh/mesh_formats.hpp"

namespace weft::io {
namespace {

std::vector<NamedMesh> split(const std::string& bytes, Uv uv = Uv::where_all) {
  return split_objects({"cloth", parse_obj(bytes, "a.obj", uv)});
}

const std::string two =
    "o left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    "o right\nv 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nvt 5 0\nvt 6 0\nvt 6 1\nvt 5 1\nvt 7 7\n";

TEST(SplitObjects, GivesEachObjectItsPart) {
  const auto parts = split(two + "f 4/4 5/5 6/6\nf 4/4 6/6 7/7\n");
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].name, "left");
  EXPECT_EQ(parts[1].name, "right");
  EXPECT_EQ(parts[0].mesh.positions.size(), 3u);
  ASSERT_EQ(parts[1].mesh.positions.size(), 4u);
  EXPECT_EQ(parts[1].mesh.positions[2][0], 6);
  ASSERT_EQ(parts[1].mesh.triangles.size(), 2u);
  EXPECT_EQ(parts[1].mesh.triangles[1].v[0], 0);
  EXPECT_EQ(parts[1].mesh.triangles[1].v[1], 2);
  EXPECT_EQ(parts[1].mesh.triangles[1].v[2], 3);
  ASSERT_EQ(parts[1].mesh.material.size(), 4u);
  EXPECT_EQ(parts[1].mesh.material[2][1], 1);
  EXPECT_TRUE(parts[1].mesh.material_triangles.empty());
  EXPECT_TRUE(parts[1].mesh.group.empty());
}

TEST(SplitObjects, KeepsCornersThatMeetInASeam) {
  const auto parts = split(two + "f 4/4 5/5 6/6\nf 4/8 6/6 7/7\n");
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].mesh.material.size(), 3u);
  const Mesh& right = parts[1].mesh;
  ASSERT_EQ(right.material_triangles.size(), 2u);
  ASSERT_EQ(right.material.size(), 5u);
  EXPECT_EQ(right.material[static_cast<std::size_t>(right.material_triangles[1].v[0])][0], 7);
  EXPECT_EQ(right.material[static_cast<std::size_t>(right.material_triangles[0].v[0])][0], 5);
}

TEST(SplitObjects, LeavesTextureCoordinatesToTheObjectsThatHaveThem) {
  const std::string ball = "v 9 0 0\nv 8 0 0\nv 9 1 0\n";
  const std::string first = "o ball\n" + ball + "f 1 2 3\no cloth\n" + ball;
  const auto parts = split(first + "vt 0 0\nvt 1 0\nvt 0 1\nf 4/1 5/2 6/3\n", Uv::where_some);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_TRUE(parts[0].mesh.material.empty());
  EXPECT_TRUE(parts[0].mesh.material_triangles.empty());
  EXPECT_EQ(parts[1].mesh.material.size(), 3u);
  EXPECT_TRUE(parts[1].mesh.material_triangles.empty());
  // A mesh that cannot be taken apart.
  const auto whole =
      split(first + "vt 0 0\nvt 1 0\nvt 0 1\nf 1/1 5/2 6/3\nf 4 5 6\n", Uv::where_some);
  ASSERT_EQ(whole.size(), 1u);
  EXPECT_TRUE(whole[0].mesh.material.empty());
  EXPECT_TRUE(whole[0].mesh.material_triangles.empty());
}

TEST(SplitObjects, LeavesWholeWhatHangsTogether) {
  for (const char* face : {"f 3/3 5/5 6/6\nf 4/4 6/6 7/7\n", "f 4/4 5/5 6/6\n"}) {
    const auto parts = split(two + face);  // a vertex of both, a vertex of none
    ASSERT_EQ(parts.size(), 1u) << face;
    EXPECT_EQ(parts[0].name, "cloth");
    EXPECT_EQ(parts[0].mesh.positions.size(), 7u);
  }
  EXPECT_EQ(split("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").at(0).name, "cloth");
}

TEST(SplitObjects, NamesASingleObject) {
  EXPECT_EQ(split("o sheet\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").at(0).name, "sheet");
}

}  // namespace
}  // namespace weft::io
