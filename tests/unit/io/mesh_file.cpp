#include "host/io/mesh/mesh_file.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "host/base/file_bytes.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

using MeshFile = DirectoryTest;
constexpr double max_double = std::numeric_limits<double>::max();

template <int N>
void expect_same(const std::vector<Vec<double, N>>& a, const std::vector<Vec<double, N>>& b) {
  ASSERT_EQ(a.size(), b.size());
  // As bytes: -0 is not 0 here.
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_EQ(std::memcmp(&a[i], &b[i], sizeof a[i]), 0) << "entry " << i;
}

void expect_same(const Mesh& a, const Mesh& b) {
  expect_same(a.positions, b.positions);
  expect_same(a.material, b.material);
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  for (std::size_t t = 0; t < a.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(a.triangles[t].v[k], b.triangles[t].v[k]);
}

/// A grid with coordinates of all sizes, which short decimals cannot hold.
Mesh wild_mesh(bool with_material) {
  Mesh mesh = make_grid({1, 1}, {6, 5}, Diagonals::alternating);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-300, 300);
  std::uniform_real_distribution<double> digit(-1, 1);
  for (auto& x : mesh.positions)
    for (int k = 0; k < 3; ++k) x[k] = digit(random) * std::pow(10.0, exponent(random));
  for (auto& u : mesh.material)
    for (int k = 0; k < 2; ++k) u[k] = digit(random);
  mesh.positions[0] = {-0.0, std::numeric_limits<double>::denorm_min(), max_double};
  mesh.positions[1] = {0.1, 1.0 / 3.0, static_cast<double>(0.1f)};
  if (!with_material) mesh.material.clear();
  return mesh;
}

/// Volatile, because GCC 12 at -O2 turns double -> float -> double on short vectors into nothing.
double as_float(double x) {
  const volatile float rounded = static_cast<float>(x);
  return static_cast<double>(rounded);
}

std::string obj_refusal(std::string_view bytes, Uv uv = Uv::material) {
  try {
    parse_obj(bytes, "a.obj", uv);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

std::string ply_refusal(std::string_view bytes) {
  try {
    parse_ply(bytes, "a.ply", Uv::material);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST_F(MeshFile, ObjRoundTripIsExact) {
  for (const bool with_material : {true, false}) {
    const Mesh mesh = wild_mesh(with_material);
    write_obj(directory_ / "a.obj", {{"cloth", mesh}});
    expect_same(read_mesh(directory_ / "a.obj"), mesh);
  }
}

TEST_F(MeshFile, PlyRoundTripIsExact) {
  for (const bool with_material : {true, false}) {
    const Mesh mesh = wild_mesh(with_material);
    write_ply(directory_ / "a.ply", {{"cloth", mesh}});
    expect_same(read_mesh(directory_ / "a.ply"), mesh);
  }
}

TEST_F(MeshFile, PlyInSinglePrecisionRoundsOnce) {
  const Mesh mesh = make_grid({1, 1}, {3, 3}, Diagonals::same);
  write_ply(directory_ / "a.ply", {{"cloth", mesh}}, Precision::single_precision);
  Mesh rounded = mesh;
  for (auto& x : rounded.positions)
    for (int k = 0; k < 3; ++k) x[k] = as_float(x[k]);
  for (auto& u : rounded.material)
    for (int k = 0; k < 2; ++k) u[k] = as_float(u[k]);
  expect_same(read_mesh(directory_ / "a.ply"), rounded);
}

TEST_F(MeshFile, SeveralMeshesBecomeOne) {
  const Mesh a = make_grid({1, 1}, {2, 1}, Diagonals::same);
  const Mesh b = make_grid({2, 1}, {1, 3}, Diagonals::same);
  Mesh both = a;
  both.positions.insert(both.positions.end(), b.positions.begin(), b.positions.end());
  both.material.insert(both.material.end(), b.material.begin(), b.material.end());
  for (Tri tri : b.triangles) {
    for (Index& v : tri.v) v += static_cast<Index>(a.positions.size());
    both.triangles.push_back(tri);
  }
  write_obj(directory_ / "a.obj", {{"left", a}, {"right", b}});
  write_ply(directory_ / "a.ply", {{"left", a}, {"right", b}});
  expect_same(read_mesh(directory_ / "a.obj"), both);
  expect_same(read_mesh(directory_ / "a.ply"), both);
  const std::string text = read_file_bytes(directory_ / "a.obj");
  EXPECT_EQ(text.find("o left\n"), 0u);
  EXPECT_NE(text.find("\no right\n"), std::string::npos);
}

TEST(Obj, ReadsWhatTheFormatAllows) {
  const Mesh mesh = parse_obj(
      "# a comment\r\nmtllib x.mtl\r\no thing\r\n"
      "v 0 0 0 1\r\nv +1 0 0\r\nv 1 1e0 0 0.5 0.5 0.5\nv 0\t1 0 # trailing\n\n"
      "vn 0 0 1\nvt 0 0 0\nvt 1 0\nvt 1 1\nvt 0 1\ns off\n"
      "f 1/1/1 2/2/1 3/3/1 4/4/1\n",
      "a.obj", Uv::material);
  ASSERT_EQ(mesh.positions.size(), 4u);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[1].v[0], 0);
  EXPECT_EQ(mesh.triangles[1].v[1], 2);
  EXPECT_EQ(mesh.triangles[1].v[2], 3);
  EXPECT_EQ(mesh.material[2][1], 1);
}

TEST(Obj, SplitsAClothsPolygonsWhereAnglesAreLargest) {
  const auto first = [](const std::string& bytes, Uv uv) {
    const Tri tri = parse_obj(bytes, "a.obj", uv).triangles.at(0);
    return std::array<Index, 3>{tri.v[0], tri.v[1], tri.v[2]};
  };
  using Corners = std::array<Index, 3>;
  // A kite: the fan of its first corner has slivers, that of its second has not.
  const std::string kite = "v -3 0 0\nv 0 -1 0\nv 3 0 0\nv 0 1 0\nf 1 2 3 4\n";
  EXPECT_EQ(first(kite, Uv::material), (Corners{1, 2, 3}));
  // Frames of a sequence must all be split alike.
  EXPECT_EQ(first(kite, Uv::ignore), (Corners{0, 1, 2}));
  // Both diagonals of a square are as good, so that a regular mesh stays one.
  EXPECT_EQ(first("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Uv::material),
            (Corners{0, 1, 2}));
  EXPECT_EQ(first("v 0 0 0\nv .1 0 0\nv .1 .1 0\nv 0 .1 0\nf 2 3 4 1\n", Uv::material),
            (Corners{1, 2, 3}));
  // An arrowhead: only the fan of its notch, or of its tip, does not turn a triangle over.
  const std::string arrow = "v -2 -1 0\nv 0 0 0\nv 2 -1 0\nv 0 3 0\nf 1 2 3 4\n";
  EXPECT_EQ(first(arrow, Uv::material), (Corners{1, 2, 3}));
  // Many corners are split without a search.
  std::string many;
  for (int k = 0; k < 1000; ++k)
    many += "v " + std::to_string(std::cos(0.00628 * k)) + " " +
            std::to_string(std::sin(0.00628 * k)) + " 0\n";
  many += "f";
  for (int k = 1; k <= 1000; ++k) many += " " + std::to_string(k);
  EXPECT_EQ(first(many + "\n", Uv::material), (Corners{0, 1, 2}));
}

TEST(Obj, CountsFromTheBack) {
  const Mesh mesh =
      parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2//4 -1\nv 5 5 5\n", "a.obj", Uv::material);
  EXPECT_EQ(mesh.triangles[0].v[0], 0);
  EXPECT_EQ(mesh.triangles[0].v[2], 2);
  EXPECT_TRUE(mesh.material.empty());
}

TEST(Obj, KeepsVertexOrderUnderForeignTextureOrder) {
  const Mesh mesh = parse_obj(
      "vt 9 9\nvt 0 1\nvt 1 0\nvt 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
      "f 1/4 2/3 3/2\n",
      "a.obj", Uv::material);
  EXPECT_EQ(mesh.material[0][0], 0);
  EXPECT_EQ(mesh.material[1][0], 1);
  EXPECT_EQ(mesh.material[2][1], 1);
}

TEST(Obj, SeamsGiveCornersOfTheirOwnUnlessUvAreIgnored) {
  const char* seam =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 3 3\n"
      "f 1/1 2/2 3/3\nf 1/5 3/3 4/4\n";
  const Mesh mesh = parse_obj(seam, "a.obj", Uv::material);
  ASSERT_EQ(mesh.material_triangles.size(), 2u);
  ASSERT_EQ(mesh.material.size(), 5u);
  EXPECT_EQ(mesh.triangles[1].v[0], 0);
  EXPECT_EQ(mesh.material_triangles[0].v[0], 0);
  EXPECT_EQ(mesh.material_triangles[1].v[0], 4);
  EXPECT_EQ(mesh.material[4][1], 3);
  // and back again
  const Mesh again = parse_obj(format_obj({{"", mesh}}), "b.obj", Uv::material);
  ASSERT_EQ(again.material_triangles.size(), 2u);
  EXPECT_EQ(again.material_triangles[1].v[0], 4);
  const Mesh ignored = parse_obj(seam, "a.obj", Uv::ignore);
  EXPECT_TRUE(ignored.material.empty());
  EXPECT_TRUE(ignored.material_triangles.empty());
}

TEST(Obj, MayBeginWithAByteOrderMark) {
  EXPECT_EQ(parse_obj("\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj", Uv::material)
                .positions.size(),
            3u);
}

TEST(Obj, TakesUvOfSomeFacesForNoneWhereThatWillDo) {
  const char* mixed =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1 3 4\n";
  const Mesh mesh = parse_obj(mixed, "a.obj", Uv::where_all);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_TRUE(mesh.material.empty());
  EXPECT_TRUE(mesh.material_triangles.empty());
  EXPECT_THROW(parse_obj(mixed, "a.obj", Uv::material), SceneError);
  Mesh some = parse_obj(mixed, "a.obj", Uv::where_some);
  EXPECT_EQ(some.material.size(), 3u);
  ASSERT_EQ(some.material_triangles.size(), 2u);
  EXPECT_EQ(some.material_triangles[0].v[2], 2);
  EXPECT_EQ(some.material_triangles[1].v[2], -1);
  drop_incomplete_material(some);
  EXPECT_TRUE(some.material.empty());
  EXPECT_TRUE(some.material_triangles.empty());
}

TEST(Obj, GroupsOfFaces) {
  const Mesh mesh = parse_obj(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\ng front\nf 1 3 4\nusemtl silk\n"
      "f 1 2 4\nfl 2\nf 2 3 4\n",
      "a.obj", Uv::material);
  ASSERT_EQ(mesh.group.size(), 4u);
  const auto name = [&](std::size_t t) {
    return mesh.group_names.at(static_cast<std::size_t>(mesh.group[t]));
  };
  EXPECT_EQ(name(0), "");
  EXPECT_EQ(name(1), "front");
  EXPECT_EQ(name(2), "label_2");
  EXPECT_EQ(name(3), "silk");
}

TEST(Obj, TwoNamesForOneTextureCoordinateAreNoSeam) {
  EXPECT_EQ(obj_refusal("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                        "vt 0 0\nf 1/1 2/2 3/3\nf 1/5 3/3 4/4\n"),
            "");
}

TEST(Obj, NamesLineAndValueOfWhatIsWrong) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::vector<std::array<std::string, 3>> cases{
      {"v 0 nan 0\n", "line 1: v[1]", "\"nan\""},
      {"v 0 0 inf\n", "line 1: v[2]", "\"inf\""},
      {"v 0 0 1e999\n", "line 1: v[2]", "\"1e999\""},
      {"v 0 0\n", "line 1: v", "0 0"},
      {"v 0 0 0x1\n", "line 1: v[2]", "\"0x1\""},
      {"vt 1\n", "line 1: vt", "1"},
      {triangle + "f 1 2 4\n", "line 4: f vertex", "\"4\""},
      {triangle + "f 1 2 0\n", "line 4: f vertex", "\"0\""},
      {triangle + "f 1 2 -4\n", "line 4: f vertex", "\"-4\""},
      {triangle + "f 1 2 99999999999999999999\n", "line 4: f vertex", "\"99999999999999999999\""},
      {triangle + "f 1/1 2 3\n", "line 4: f texture", "\"1\""},
      {triangle + "vt 0 0\nf 1/1 2 3\n", "line 5: f", "without texture"},
      {triangle + "f 1/ 2 3\n", "line 4: f texture", "\"\""},
      {triangle + "f 1 2\n", "line 4: f", "1 2"},
      {triangle + "face 1 2 3\n", "f", "line 4: keyword \"face\""},
      {triangle, "f", "no faces"},
      {"", "v", "no vertices"},
      {std::string("v 0 0 \0\x01\n", 10), "line 1: v[2]", "\"??\""},
  };
  for (const auto& [bytes, field, value] : cases) {
    const std::string message = obj_refusal(bytes);
    EXPECT_EQ(message.find("a.obj: " + field), 0u) << message;
    EXPECT_NE(message.find(value), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(Ply, ReadsTextWithForeignElements) {
  const Mesh mesh = parse_ply(
      "ply\r\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty uchar red\n"
      "property double y\nproperty double x\nproperty float z\nproperty float u\nproperty float v\n"
      "element edge 1\nproperty int a\nproperty list uchar float w\n"
      "element face 1\nproperty list uchar uint vertex_index\nproperty int flags\nend_header\n"
      "1 0 0 0 0 0\n2 0 1 0 1 0\n3 1 1 0 1 1\n4 1 0 0.5 0 1\n7 2 0.5 nan\n4 0 1 2 3 9",
      "a.ply", Uv::material);
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.positions[1][0], 1);
  EXPECT_EQ(mesh.positions[3][2], 0.5);
  EXPECT_EQ(mesh.material[3][1], 1);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[1].v[1], 2);
  EXPECT_EQ(mesh.triangles[1].v[2], 3);
}

TEST(Ply, ReadsBigEndian) {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty double y\n"
      "property short z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    std::array<char, sizeof value> raw;
    std::memcpy(raw.data(), &value, sizeof value);
    bytes.append(raw.rbegin(), raw.rend());
  };
  for (int k = 0; k < 3; ++k) {
    put(0.5f * static_cast<float>(k));
    put(-0.1 * k * k);
    put(static_cast<std::int16_t>(300 * k));
  }
  put(static_cast<unsigned char>(3));
  for (const std::int32_t corner : {2, 0, 1}) put(corner);
  const Mesh mesh = parse_ply(bytes, "a.ply", Uv::material);
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.positions[2][0], 1);
  EXPECT_EQ(mesh.positions[2][1], -0.1 * 2 * 2);
  EXPECT_EQ(mesh.positions[2][2], 600);
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.triangles[0].v[0], 2);
  EXPECT_EQ(mesh.triangles[0].v[2], 1);
}

TEST(Ply, NamesElementAndValueOfWhatIsWrong) {
  const std::string head = "ply\nformat ascii 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string good = "0 0 0\n1 0 0\n0 1 0\n";
  const std::vector<std::array<std::string, 3>> cases{
      {"", "header", "\"\""},
      {"plx\n", "header", "plx"},
      {"ply\nend_header\n", "header", "no format"},
      {"ply\nformat binary_mixed_endian 1.0\n", "header", "binary_mixed_endian"},
      {head + "element vertex -1\n", "header", "element vertex -1"},
      {head + "element vertex 4000000000\n" + xyz + face, "element \"vertex\"", "4000000000"},
      {head + "element vertex 100000000\n" + xyz + face, "element \"vertex\": ", "100000000 rows"},
      {head + "element vertex 18446744073709551615\n", "header", "18446744073709551615"},
      {head + "element vertex 3\nelement vertex 3\n", "header", "element vertex 3"},
      {head + "element thing 4000000000\nend_header\n", "element \"thing\"", "without properties"},
      {head + "property float x\n", "header", "property float x"},
      {head + "element vertex 3\nproperty half x\n", "header", "property half x"},
      {head + "element vertex 3\nproperty list float int x\n", "header", "list float"},
      {head + "element vertex 3\nproperty float x\nproperty float y\n" + face + good + "3 0 1 2\n",
       "element \"vertex\"", "no x, y, z"},
      {head + "element vertex 3\n" + xyz + "property float s\n" + face + good + good + "3 0 1 2\n",
       "element \"vertex\"", "one texture coordinate"},
      {head + "element vertex 3\n" + xyz + face + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
       "element \"vertex\" row 1 y", "nan"},
      {head + "element vertex 3\n" + xyz + face + "0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n",
       "element \"vertex\" row 1", "\"x\""},
      {head + "element vertex 3\n" + xyz + face + good + "3 0 1 3\n", "element \"face\"",
       "vertex 3 of triangle 0"},
      {head + "element vertex 3\n" + xyz + face + good + "3 0 1 -1\n", "element \"face\" row 0",
       "vertex -1"},
      {head + "element vertex 3\n" + xyz + face + good + "2 0 1\n", "element \"face\" row 0",
       "2 corners"},
      {head + "element vertex 3\n" + xyz + face + good + "255 0 1\n", "element \"face\" row 0",
       "length 255"},
      {head + "element vertex 3\n" + xyz + face + good + "1e300 0 1\n", "element \"face\" row 0",
       "length 1e+300"},
      {head + "element vertex 3\n" + xyz + face + good + "3 0 1 2 7\n", "end", "3 bytes"},
      {head + "element vertex 3\n" + xyz + "end_header\n" + good, "element \"face\"", "no faces"},
  };
  for (const auto& [bytes, field, value] : cases) {
    const std::string message = ply_refusal(bytes);
    EXPECT_EQ(message.find("a.ply: " + field), 0u) << message << "\n" << bytes;
    EXPECT_NE(message.find(value), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

/// Every shorter file is refused or, where only a last line feed or digits are gone, read.
TEST(Truncation, NeverCrashes) {
  const std::vector<NamedMesh> meshes{{"cloth", make_grid({1, 1}, {3, 2}, Diagonals::same)}};
  const std::string obj = format_obj(meshes);
  const std::string ply = format_ply(meshes, Precision::double_precision);
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  std::size_t obj_refused = 0;
  for (std::size_t n = 0; n < obj.size(); ++n)
    obj_refused += obj_refusal(std::string_view(obj).substr(0, n)).empty() ? 0 : 1;
  EXPECT_GT(obj_refused, obj.find("\nf "));
  for (std::size_t n = 0; n < ply.size(); ++n)
    EXPECT_NE(ply_refusal(std::string_view(ply).substr(0, n)), "") << n << " bytes";
  for (std::size_t n = 0; n + 1 < text.size(); ++n)
    EXPECT_NE(ply_refusal(std::string_view(text).substr(0, n)), "") << n << " bytes";
  EXPECT_EQ(ply_refusal(ply), "");
  EXPECT_EQ(ply_refusal(text), "");
}

/// Random damage ends in a mesh with indices in range, or in a SceneError.
TEST(Damage, NeverCrashes) {
  const std::vector<NamedMesh> meshes{{"cloth", make_grid({1, 1}, {3, 2}, Diagonals::same)}};
  std::mt19937 random(11);
  for (const std::string& good :
       {format_obj(meshes), format_ply(meshes, Precision::single_precision)}) {
    const bool is_obj = good[0] == 'o';
    for (int round = 0; round < 4000; ++round) {
      std::string bytes = good;
      for (unsigned k = 0; k <= random() % 3; ++k)
        bytes[random() % bytes.size()] = static_cast<char>(random());
      try {
        const Mesh mesh =
            is_obj ? parse_obj(bytes, "a", Uv::material) : parse_ply(bytes, "a", Uv::material);
        for (const Tri& tri : mesh.triangles)
          for (const Index v : tri.v)
            ASSERT_TRUE(v >= 0 && static_cast<std::size_t>(v) < mesh.positions.size());
      } catch (const SceneError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      }
    }
  }
}

TEST_F(MeshFile, AssimpJoinsTheCornersOfStl) {
  const std::string facet = " facet normal 0 0 1\n  outer loop\n";
  const auto path = put("a.stl", "solid a\n" + facet +
                                     "   vertex 0 0 0\n   vertex 1 0 0\n   vertex 1 1 0\n"
                                     "  endloop\n endfacet\n" +
                                     facet +
                                     "   vertex 0 0 0\n   vertex 1 1 0\n   vertex 0 1 0\n"
                                     "  endloop\n endfacet\nendsolid a\n");
  const Mesh mesh = read_mesh(path);
  EXPECT_EQ(mesh.positions.size(), 4u);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[0].v[2], mesh.triangles[1].v[1]);
  EXPECT_TRUE(mesh.material.empty());
}

TEST_F(MeshFile, RefusesWhatIsNoMeshFile) {
  EXPECT_THROW(read_mesh(directory_ / "none.obj"), SceneError);
  EXPECT_THROW(read_mesh(directory_), SceneError);
  EXPECT_THROW(read_mesh(put("a.txt", "text")), SceneError);
  EXPECT_THROW(read_mesh(put("a.stl", "solid")), SceneError);
  EXPECT_THROW(read_mesh(put("a.glb", "glTF")), SceneError);
  EXPECT_THROW(read_mesh(put("a", "text")), SceneError);
}

}  // namespace
}  // namespace weft::io
