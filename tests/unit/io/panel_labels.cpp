// Panels of garments in meshes: what OBJ and PLY say of them, and one mesh of several panels.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/mesh/split_objects.hpp"
#include "host/io/mesh/welded_mesh.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Two squares side by side, sewn along x = 1: vertices 2 and 3 of the first are at the places of 4
/// and 5, the first of the second. Texture coordinates have gaps, as those of panels do.
Mesh two_panels() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0},
                    {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 1, 0}};
  for (int panel = 0; panel < 2; ++panel)
    for (const Vec2<double> p : {Vec2<double>{0, 0}, {0, 1}, {1, 0}, {1, 1}})
      mesh.material.push_back({p[0] + 0.25 * panel, p[1] + 3 * panel});
  mesh.triangles = {{{0, 2, 1}}, {{1, 2, 3}}, {{4, 6, 5}}, {{5, 6, 7}}};
  mesh.part = {0, 0, 1, 1};
  mesh.part_names = {"left front", "back"};
  mesh.part_labels = {"leg", ""};
  mesh.group = {0, 0, 0, 0};
  mesh.group_names = {"cotton"};
  return mesh;
}

Mesh tetrahedron() {
  Mesh mesh;
  mesh.positions = {{0, 0, 5}, {1, 0, 5}, {0, 1, 5}, {0, 0, 6}};
  mesh.triangles = {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}};
  return mesh;
}

std::vector<NamedMesh> dressed() {
  return {{"skirt", two_panels()}, {"body", tetrahedron()}};
}

void expect_dressed(const Mesh& mesh, const std::string& first_panel) {
  EXPECT_EQ(mesh.part_names, (std::vector<std::string>{first_panel, "back", "body"}));
  EXPECT_EQ(mesh.part_labels, (std::vector<std::string>{"leg", "", ""}));
  EXPECT_EQ(mesh.part, (std::vector<Index>{0, 0, 1, 1, 2, 2, 2, 2}));
  EXPECT_EQ(mesh.group_names, mesh.part_names);
  EXPECT_EQ(mesh.object_names, (std::vector<std::string>{"skirt", "body"}));
  EXPECT_EQ(mesh.object, (std::vector<Index>{0, 0, 0, 0, 1, 1, 1, 1}));
  const std::vector<NamedMesh> objects = split_objects({"all", mesh});
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].name, "skirt");
  EXPECT_EQ(objects[1].name, "body");
  EXPECT_EQ(objects[0].mesh.positions.size(), 8u);
  EXPECT_EQ(objects[0].mesh.part, (std::vector<Index>{0, 0, 1, 1}));
  EXPECT_EQ(objects[0].mesh.part_labels[0], "leg");
  EXPECT_EQ(objects[1].mesh.positions[3][2], 6);
}

TEST(PanelLabels, SurviveObj) {
  const std::string text = format_obj(dressed(), Normals::none, Groups::panels);
  EXPECT_NE(text.find("\n# panel left_front leg\ng left_front\nf "), std::string::npos) << text;
  EXPECT_EQ(text.find("usemtl"), std::string::npos);
  expect_dressed(parse_obj(text, "f.obj", Uv::ignore), "left_front");
}

TEST(PanelLabels, SurvivePly) {
  const std::string bytes = format_ply(dressed(), Precision::double_precision);
  EXPECT_NE(bytes.find("\ncomment panel 0 left front\ncomment label 0 leg\n"), std::string::npos);
  expect_dressed(parse_ply(bytes, "f.ply", Uv::ignore), "left front");
}

TEST(PanelLabels, ObjectsOfPlyHaveNamesWithoutPanels) {
  const std::vector<NamedMesh> meshes{{"a sheet", tetrahedron()}, {"ball", tetrahedron()}};
  const Mesh mesh =
      parse_ply(format_ply(meshes, Precision::single_precision), "f.ply", Uv::material);
  EXPECT_EQ(mesh.group_names, (std::vector<std::string>{"a sheet", "ball"}));
  EXPECT_TRUE(mesh.object.empty());
  EXPECT_TRUE(mesh.part.empty());
}

TEST(PanelLabels, PlyOfOthersWithSuchPropertiesStaysAsItIs) {
  const Mesh mesh = parse_ply(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nproperty int panel\nproperty "
      "float "
      "object\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 7 0.5\n",
      "f.ply", Uv::material);
  EXPECT_TRUE(mesh.group.empty());
  EXPECT_TRUE(mesh.part.empty());
}

/// A scene does not carry the only name of a mesh file into frames.
TEST(PanelLabels, OneGroupSaysNoMoreThanItsObject) {
  Mesh mesh = tetrahedron();
  mesh.part = {0, 0, 0, 0};
  mesh.part_names = {"Plane.001"};
  const std::vector<NamedMesh> one{{"sheet", mesh}}, two{{"sheet", mesh}, {"skirt", two_panels()}};
  EXPECT_EQ(format_obj(one, Normals::none, Groups::panels).find("Plane"), std::string::npos);
  EXPECT_EQ(format_ply(one, Precision::double_precision).find("panel"), std::string::npos);
  const Mesh read = parse_ply(format_ply(two, Precision::double_precision), "f.ply", Uv::ignore);
  EXPECT_EQ(read.group_names, (std::vector<std::string>{"sheet", "left front", "back"}));
  const Mesh text = parse_obj(format_obj(two, Normals::none, Groups::panels), "f.obj", Uv::ignore);
  EXPECT_EQ(text.group_names, (std::vector<std::string>{"sheet", "left_front", "back"}));
}

/// Numbers without a name, and numbers that are none.
TEST(PanelLabels, PlyPassesOverWhatItCannotName) {
  const auto read = [](const std::string& comments, const std::string& panel) {
    return parse_ply(
        "ply\nformat ascii 1.0\n" + comments +
            "element vertex 3\nproperty float x\nproperty float y\nproperty float "
            "z\nelement face 1\nproperty list uchar int vertex_indices\nproperty float "
            "panel\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 " +
            panel + "\n",
        "f.ply", Uv::material);
  };
  for (const char* panel : {"-1", "9", "0.5", "1e30", "-1e30", "nan"})
    EXPECT_EQ(read("comment panel 0 front\n", panel).group_names, (std::vector<std::string>{""}))
        << panel;
  for (const char* comment : {"comment panel x front\n", "comment panel -1 front\n",
                              "comment panel 0\n", "comment panel 99999999999 front\n"})
    EXPECT_TRUE(read(comment, "0").group_names.empty()) << comment;
}

TEST(PanelLabels, TextureCoordinatesOfCornersSurvivePly) {
  Mesh mesh = two_panels();
  const std::vector<Vec2<double>> before = mesh.material;
  const WeldedMesh sewn = [&] {
    Weld weld;
    weld.add(mesh.positions);
    return welded(mesh, weld.numbers());
  }();
  const std::string bytes = format_ply({{"skirt", sewn.mesh}}, Precision::double_precision);
  const Mesh read = parse_ply(bytes, "f.ply", Uv::material);
  ASSERT_EQ(read.material_triangles.size(), 4u);
  EXPECT_EQ(read.positions.size(), 6u);
  for (std::size_t t = 0; t < 4; ++t)
    for (int k = 0; k < 3; ++k) {
      const Vec2<double> uv =
          read.material[static_cast<std::size_t>(read.material_triangles[t].v[k])];
      const auto corner = static_cast<std::size_t>(mesh.triangles[t].v[k]);
      EXPECT_EQ(uv, before[corner]) << t << " " << k;  // exact in single precision
    }
  // One pair per vertex stays one pair per vertex.
  Mesh one = tetrahedron();
  one.material = {{0, 0}, {1, 0}, {0, 1}, {0.5, 0.5}};
  const std::string both =
      format_ply({{"skirt", sewn.mesh}, {"scarf", one}}, Precision::double_precision);
  EXPECT_NE(both.find("texcoord"), std::string::npos);
  EXPECT_EQ(parse_ply(both, "f.ply", Uv::where_all).material.size(), 8u + 4u);
}

TEST(PanelLabels, BrokenTextureCoordinatesOfCornersGetOneLine) {
  const auto read = [](const std::string& row, Uv uv) {
    return parse_ply(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_indices\nproperty list uchar "
        "float "
        "texcoord\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 " +
            row + "\n",
        "f.ply", uv);
  };
  EXPECT_EQ(read("6 0 0 1 0 0 1", Uv::material).material.size(), 3u);
  for (const char* row : {"4 0 0 1 0", "0", "6 0 0 1 0 0 nan", "6 0 0 1 0 0 inf"}) {
    EXPECT_THROW(read(row, Uv::material), SceneError) << row;
    EXPECT_NO_THROW(read(row, Uv::ignore)) << row;
  }
  EXPECT_TRUE(read("4 0 0 1 0", Uv::where_all).material.empty());
}

TEST(WeldedMesh, IsOneMeshWithSeamEdges) {
  const Mesh mesh = two_panels();
  Weld weld;
  weld.add(mesh.positions);
  EXPECT_EQ(weld.numbers(), (std::vector<Index>{0, 1, 2, 3, 2, 3, 4, 5}));
  const WeldedMesh sewn = welded(mesh, weld.numbers());
  EXPECT_EQ(sewn.mesh.positions.size(), 6u);
  EXPECT_EQ(sewn.seam_edges, (std::vector<std::array<Index, 2>>{{2, 3}}));
  EXPECT_EQ(sewn.mesh.material.size(), 8u);
  EXPECT_EQ(sewn.mesh.material_triangles.size(), 4u);
  EXPECT_EQ(sewn.mesh.part, mesh.part);
  // In a frame in which one end is apart, that end stays apart, and no edge is sewn.
  std::vector<Vec3<double>> open = mesh.positions;
  open[5][2] = 0.1;
  weld.add(open);
  const WeldedMesh half = welded(mesh, weld.numbers());
  EXPECT_EQ(half.mesh.positions.size(), 7u);
  EXPECT_TRUE(half.seam_edges.empty());
}

TEST(WeldedMesh, OfOnePanelIsThatPanel) {
  Mesh mesh = tetrahedron();
  mesh.material = {{0, 0}, {1, 0}, {0, 1}, {0.5, 0.5}};
  Weld weld;
  weld.add(mesh.positions);
  const WeldedMesh sewn = welded(mesh, weld.numbers());
  EXPECT_EQ(sewn.mesh.positions, mesh.positions);
  EXPECT_TRUE(sewn.mesh.material_triangles.empty());
  EXPECT_TRUE(sewn.seam_edges.empty());
}

TEST(WeldedMesh, SeamEdgesAreWritten) {
  const Mesh mesh = two_panels();
  Weld weld;
  weld.add(mesh.positions);
  const WeldedMesh sewn = welded(mesh, weld.numbers());
  const std::vector<NamedMesh> meshes{{"ball", tetrahedron()}, {"skirt", sewn.mesh}};
  const SeamEdges seams{{}, sewn.seam_edges};
  const std::string obj = format_obj(meshes, Normals::none, Groups::panels, seams);
  EXPECT_NE(obj.find("\nl 7 8\n"), std::string::npos) << obj;  // counted from 1, after the ball's 4
  EXPECT_NO_THROW(parse_obj(obj, "f.obj", Uv::where_all));
  const std::string ply = format_ply(meshes, Precision::single_precision, Normals::none, seams);
  EXPECT_NE(ply.find("\nelement edge 1\n"), std::string::npos);
  const std::int32_t ends[2] = {6, 7};
  EXPECT_TRUE(ply.ends_with(std::string(reinterpret_cast<const char*>(ends), sizeof ends)));
  EXPECT_NO_THROW(parse_ply(ply, "f.ply", Uv::where_all));
}

}  // namespace
}  // namespace weft::io
