#include "host/io/usd/usd_file.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "host/base/file_bytes.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

using UsdFileTest = DirectoryTest;
using Spool = DirectoryTest;

/// Volatile, because GCC 12 at -O2 turns double -> float -> double on short vectors into nothing.
double as_float(double x) {
  const volatile float rounded = static_cast<float>(x);
  return static_cast<double>(rounded);
}

template <int N>
void expect_rounded(const std::vector<Vec<double, N>>& read,
                    const std::vector<Vec<double, N>>& written) {
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i)
    for (int k = 0; k < N; ++k) EXPECT_EQ(read[i][k], as_float(written[i][k])) << "entry " << i;
}

void expect_same(const std::vector<Tri>& a, const std::vector<Tri>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t t = 0; t < a.size(); ++t)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(a[t].v[k], b[t].v[k]) << "triangle " << t;
}

void expect_rounded(const Mesh& read, const Mesh& written) {
  expect_rounded(read.positions, written.positions);
  expect_rounded(read.material, written.material);
  expect_same(read.triangles, written.triangles);
  expect_same(read.material_triangles, written.material_triangles);
}

/// A sheet that bends more from frame to frame.
Mesh sheet(int frame, int cells = 3) {
  Mesh mesh = make_grid({1, 1}, {cells, 2}, Diagonals::alternating);
  for (auto& x : mesh.positions) x[2] = 0.1 * frame * x[0] * x[0] + 1.0 / 3;
  return mesh;
}

Mesh ball() {
  Mesh mesh = sheet(1, 2);
  mesh.material.clear();
  return mesh;
}

/// Two triangles whose common edge is a seam in material space.
Mesh seamed() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
  mesh.material = {{0, 0}, {1, 0}, {1, 1}, {5, 0}, {6, 1}, {5, 1}};
  mesh.material_triangles = {{{0, 1, 2}}, {{3, 4, 5}}};
  return mesh;
}

void write_two(const std::filesystem::path& spool, int frames) {
  SpoolWriter writer(spool, 30, {{"my-shirt", false}, {"2 \"balls\"", true}});
  const Mesh obstacle = ball();
  for (int f = 0; f < frames; ++f) {
    const Mesh cloth = sheet(f);
    writer.append(f, {&cloth, &obstacle});
  }
}

std::string refusal(std::string_view bytes) {
  try {
    const UsdStage stage = parse_usd(bytes, "a.usda");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

// ----------------------------------------------------------------------------------------- spools
TEST_F(Spool, HoldsWhatWasWritten) {
  write_two(directory_ / "a.spool", 4);
  const SpoolReader reader(directory_ / "a.spool");
  EXPECT_EQ(reader.frame_rate(), 30);
  EXPECT_EQ(reader.frames(), (std::vector<int>{0, 1, 2, 3}));
  ASSERT_EQ(reader.meshes().size(), 2u);
  EXPECT_EQ(reader.meshes()[1].name, "2 \"balls\"");
  EXPECT_TRUE(reader.meshes()[1].obstacle);
  for (std::size_t f = 0; f < 4; ++f) {
    expect_rounded(reader.read(f, 0), sheet(static_cast<int>(f)));
    expect_rounded(reader.read(f, 1), ball());
  }
  EXPECT_EQ(reader.block(3, 0).topology_from, 0u) << "the same topology was written again";
  EXPECT_EQ(reader.block(3, 1).points_from, 0u) << "points that did not move were written again";
}

TEST_F(Spool, KilledAtAnyByteKeepsTheWholeFrames) {
  write_two(directory_ / "a.spool", 3);
  const std::string good = read_file_bytes(directory_ / "a.spool");
  const SpoolReader whole(directory_ / "a.spool");
  for (std::size_t n = whole.bytes_of(0); n < good.size(); ++n) {
    const auto path = put("b.spool", std::string_view(good).substr(0, n));
    const SpoolReader reader(path);
    const std::size_t expected = n >= whole.bytes_of(2) ? 2 : n >= whole.bytes_of(1) ? 1 : 0;
    ASSERT_EQ(reader.frames().size(), expected) << n << " bytes";
  }
  // Gone on with, it becomes the file that was never interrupted.
  const auto path = put("b.spool", std::string_view(good).substr(0, whole.bytes_of(2) + 77));
  SpoolWriter writer(path, 100);
  EXPECT_EQ(writer.last_frame(), 1);
  const Mesh cloth = sheet(2), obstacle = ball();
  writer.append(2, {&cloth, &obstacle});
  EXPECT_EQ(read_file_bytes(path), good);
}

TEST_F(Spool, CutsOffLaterFrames) {
  write_two(directory_ / "a.spool", 6);
  SpoolWriter writer(directory_ / "a.spool", 2);
  const Mesh cloth = sheet(50), obstacle = ball();
  EXPECT_THROW(writer.append(2, {&cloth, &obstacle}), SceneError);
  EXPECT_THROW(writer.append(3, {&cloth}), SceneError);
  writer.append(3, {&cloth, &obstacle});
  const SpoolReader reader(directory_ / "a.spool");
  ASSERT_EQ(reader.frames().size(), 4u);
  expect_rounded(reader.read(3, 0), sheet(50));
}

TEST_F(Spool, DamageIsRefused) {
  write_two(directory_ / "a.spool", 2);
  const std::string good = read_file_bytes(directory_ / "a.spool");
  std::mt19937 random(5);
  int unnoticed = 0;
  for (int round = 0; round < 2000; ++round) {
    std::string bytes = good;
    const std::size_t at = random() % bytes.size();
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
    const auto path = put("b.spool", bytes);
    try {
      const SpoolReader reader(path);
      bool same = reader.frames().size() == 2 && reader.meshes().size() == 2;
      for (std::size_t f = 0; f < reader.frames().size(); ++f)
        for (std::size_t m = 0; m < reader.meshes().size(); ++m) {
          const Mesh mesh = reader.read(f, m);
          for (const Tri& t : mesh.triangles)
            for (const Index v : t.v) ASSERT_LT(static_cast<std::size_t>(v), mesh.positions.size());
        }
      unnoticed += same ? 1 : 0;
    } catch (const SceneError&) {
    }
  }
  // Names, frame rate and unused bytes bear no checksum; they are a few dozen of thousands.
  EXPECT_LT(unnoticed, 200);
}

// ------------------------------------------------------------------------------------- round trips
TEST_F(UsdFileTest, RoundTripIsExactInSinglePrecision) {
  write_two(directory_ / "a.spool", 4);
  write_usd(directory_ / "a.usda", SpoolReader(directory_ / "a.spool"));
  const UsdFile file(directory_ / "a.usda");
  EXPECT_EQ(file.frame_rate(), 30);
  EXPECT_EQ(file.times(), (std::vector<double>{0, 1, 2, 3}));
  ASSERT_EQ(file.meshes().size(), 2u);
  EXPECT_EQ(file.meshes()[0].path, "/World/cloths/my_shirt");
  EXPECT_EQ(file.meshes()[0].name, "my-shirt");
  EXPECT_EQ(file.meshes()[1].path, "/World/obstacles/_2__balls_");
  EXPECT_EQ(file.meshes()[1].name, "2 \"balls\"");
  EXPECT_FALSE(file.meshes()[0].obstacle);
  EXPECT_TRUE(file.meshes()[1].obstacle);
  EXPECT_TRUE(file.meshes()[0].points.timed);
  EXPECT_FALSE(file.meshes()[0].indices.timed) << "topology that never changes";
  EXPECT_FALSE(file.meshes()[1].points.timed) << "an obstacle that never moves";
  for (int f = 0; f < 4; ++f) {
    expect_rounded(file.read(0, f), sheet(f));
    expect_rounded(file.read(1, f), ball());
  }
}

TEST_F(UsdFileTest, SaysWhatOtherProgramsAskFor) {
  write_two(directory_ / "a.spool", 3);
  write_usd(directory_ / "a.usda", SpoolReader(directory_ / "a.spool"));
  const std::string text = read_file_bytes(directory_ / "a.usda");
  EXPECT_EQ(text.find("#usda 1.0\n"), 0u);
  for (const char* line :
       {"defaultPrim = \"World\"", "upAxis = \"Z\"", "metersPerUnit = 1\n", "startTimeCode = 0\n",
        "endTimeCode = 2\n", "timeCodesPerSecond = 30\n", "def Xform \"World\"",
        "def Mesh \"my_shirt\"", "uniform token subdivisionScheme = \"none\"",
        "point3f[] points.timeSamples = {", "normal3f[] normals.timeSamples = {",
        "float3[] extent.timeSamples = {", "texCoord2f[] primvars:st = [",
        "interpolation = \"vertex\"", "int[] faceVertexCounts = [3, 3,"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
}

TEST_F(UsdFileTest, TopologyMayChange) {
  const std::vector<int> cells{3, 3, 5, 5, 2};
  {
    SpoolWriter writer(directory_ / "a.spool", 25, {{"cloth", false}});
    for (int f = 0; f < 5; ++f) {
      const Mesh mesh = sheet(f, cells[static_cast<std::size_t>(f)]);
      writer.append(f, {&mesh});
    }
  }
  write_usd(directory_ / "a.usda", SpoolReader(directory_ / "a.spool"));
  const UsdFile file(directory_ / "a.usda");
  for (int f = 0; f < 5; ++f)
    expect_rounded(file.read(0, f), sheet(f, cells[static_cast<std::size_t>(f)]));
  const auto times = [](const UsdAttribute& attribute) {
    std::vector<double> result;
    for (const UsdSample& sample : attribute.samples) result.push_back(sample.time);
    return result;
  };
  EXPECT_EQ(times(file.meshes()[0].indices), (std::vector<double>{0, 2, 4}));
  // Said again before a change, for readers that blend.
  EXPECT_EQ(times(file.meshes()[0].st), (std::vector<double>{0, 1, 2, 3, 4}));
}

TEST_F(UsdFileTest, SeamsInMaterialSpace) {
  {
    SpoolWriter writer(directory_ / "a.spool", 25, {{"cloth", false}});
    const Mesh mesh = seamed();
    writer.append(0, {&mesh});
  }
  write_usd(directory_ / "a.usda", SpoolReader(directory_ / "a.spool"));
  const UsdFile file(directory_ / "a.usda");
  expect_rounded(file.read(0, 0), seamed());
  EXPECT_TRUE(file.read(0, 0, Uv::ignore).material.empty());
  EXPECT_NE(read_file_bytes(directory_ / "a.usda").find("interpolation = \"faceVarying\""),
            std::string::npos);
}

// ---------------------------------------------------------------------------- files of other hands
TEST_F(UsdFileTest, ReadsWhatOthersWrite) {
  const auto path = put("a.usda", R"(#usda 1.0
(
    "a comment"
    customLayerData = { string maker = "x) ] }" }
    subLayers = [@./b.usda@]
    timeCodesPerSecond = 50
)
over "nothing" { float size = 3 }
def Xform "root" ( kind = "component"
   prepend apiSchemas = ["A", "B"] ) {
    # a square and a triangle
    def Mesh "flat" {
        uniform token orientation = "leftHanded"
        int[] faceVertexCounts = [4, 3]
        int[] faceVertexIndices = [0, 1, 2, 3, 0, 1, 3,]
        rel material:binding = </mats/a>
        point3f[] points.timeSamples = { 1: [(0,0,0),(100,0,0),(100,100,0),(0,100,0)],
            2.5: [(0, 0, 100), (100, 0, 0), (100, 100, 0), (0, 100, 0)] }
        color3f[] primvars:displayColor = [(1, 0, 0)] (interpolation = "constant")
        dictionary d = { int a = 1; string b = 'it''s' }
    }
}
)");
  const UsdFile file(path);
  EXPECT_EQ(file.frame_rate(), 50);
  EXPECT_EQ(file.times(), (std::vector<double>{1, 2.5}));
  const Mesh mesh = file.read(0, 2.5);
  ASSERT_EQ(mesh.positions.size(), 4u);
  // y up and centimetres unless the file says otherwise
  EXPECT_EQ(mesh.positions[0][1], -1);
  EXPECT_EQ(mesh.positions[2][2], 1);
  expect_same(mesh.triangles, {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 3, 1}}});
  EXPECT_EQ(file.read(0, 2).positions[0][1], 0) << "the earlier sample holds";
}

TEST_F(UsdFileTest, ReadsTranslations) {
  const std::string square =
      "point3f[] points = [(0,0,0),(1,0,0),(1,1,0)]\nint[] faceVertexCounts = [3]\n"
      "int[] faceVertexIndices = [0,1,2]\n";
  const std::string order = "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n";
  const UsdFile file(put("a.usda", "#usda 1.0\n(metersPerUnit = 0.5)\ndef Xform \"w\" {\n" + order +
                                       "def Mesh \"m\" {\n" + square +
                                       "double3 xformOp:translate = (2, 4, 6)\n" + order +
                                       "}\ndef Mesh \"n\" {\n" + square +
                                       "double3 xformOp:translate = (9, 9, 9)\n}\n"
                                       "double3 xformOp:translate = (100, 0, 1e6)\n}\n"));
  // Half metres, y up. What xformOpOrder does not name does not count.
  EXPECT_EQ(file.origin(0), (Vec3<double>{51, -500003, 2}));
  EXPECT_EQ(file.origin(1), (Vec3<double>{50, -500000, 0}));
  EXPECT_EQ(file.read(0, 0).positions[1], (Vec3<double>{0.5, 0, 0}));
}

TEST_F(UsdFileTest, OriginComesBack) {
  const Vec3<double> origin{300000.1, -0x1p20, 0};
  const Mesh mesh = seamed();
  {
    SpoolWriter writer(directory_ / "a.spool", 25, {{"cloth", false}}, origin);
    writer.append(0, {&mesh});
  }
  Mesh moved = mesh;
  moved.positions[0][2] += 1;
  SpoolWriter(directory_ / "a.spool", 0).append(1, {&moved});
  EXPECT_EQ(SpoolReader(directory_ / "a.spool").origin(), origin);
  write_usd(directory_ / "a.usda", SpoolReader(directory_ / "a.spool"));
  const UsdFile file(directory_ / "a.usda");
  EXPECT_EQ(file.origin(0), origin);
  EXPECT_EQ(file.times().size(), 2u);
  expect_rounded(file.read(0, 0), mesh);
}

TEST_F(UsdFileTest, VelocitiesAreTheStatesOrDifferences) {
  const Mesh first = sheet(0), second = sheet(1), third = sheet(3);
  const std::vector<std::vector<Vec3<double>>> known{
      std::vector<Vec3<double>>(first.positions.size(), {1, 2, 3})};
  {
    SpoolWriter writer(directory_ / "a.spool", 10, {{"cloth", false}, {"body", true}});
    writer.append(0, {&first, &first}, known);
    writer.append(1, {&second, &second}, known);
    writer.append(2, {&third, &third}, known);
  }
  const SpoolReader spool(directory_ / "a.spool");
  EXPECT_EQ(spool.velocities(1, 0), known[0]);
  EXPECT_TRUE(spool.velocities(1, 1).empty());
  write_usd(directory_ / "a.usda", spool);
  const UsdFile file(directory_ / "a.usda");
  EXPECT_EQ(file.velocities(0, 2), known[0]);
  const std::size_t corner = first.positions.size() - 1;
  const double x2 = 0.1 * first.positions[corner][0] * first.positions[corner][0];
  // 10 frames per second; one-sided at the ends.
  EXPECT_NEAR(file.velocities(1, 0)[corner][2], 10 * x2, 1e-6);
  EXPECT_NEAR(file.velocities(1, 1)[corner][2], 15 * x2, 1e-6);
  EXPECT_NEAR(file.velocities(1, 2)[corner][2], 20 * x2, 1e-6);
  SpoolWriter(directory_ / "a.spool", 1).append(2, {&third, &third}, known);
  EXPECT_EQ(SpoolReader(directory_ / "a.spool").velocities(2, 0), known[0]);
}

TEST_F(UsdFileTest, MaterialsAndPartsComeBackAsSubsets) {
  Mesh mesh = sheet(0);
  mesh.group.assign(mesh.triangles.size(), 0);
  mesh.part.assign(mesh.triangles.size(), 1);
  mesh.group[2] = 1;
  mesh.part[3] = 0;
  const std::vector<std::string> materials{"denim", "silk 2"}, parts{"sleeve", "front"};
  const Mesh plain = ball();
  {
    SpoolWriter writer(directory_ / "a.spool", 25,
                       {{"shirt", false, materials, parts}, {"ball", true}});
    writer.append(0, {&mesh, &plain});
  }
  write_usd(directory_ / "a.usda", SpoolReader(directory_ / "a.spool"));
  const std::string text = read_file_bytes(directory_ / "a.usda");
  for (const char* line :
       {"def Scope \"materials\"", "def Material \"silk_2\"",
        "uniform token info:id = \"UsdPreviewSurface\"",
        "rel material:binding = </World/materials/silk_2>", "def GeomSubset \"sleeve\"",
        "int[] indices = [3]\n", "uniform token familyName = \"materialBind\"",
        "prepend apiSchemas = [\"MaterialBindingAPI\"]"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
  const UsdFile file(directory_ / "a.usda");
  const Mesh again = file.read(0, 0);
  ASSERT_EQ(again.group.size(), mesh.group.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto name = [&](const std::vector<std::string>& names, Index i) {
      return names[static_cast<std::size_t>(i)];
    };
    EXPECT_EQ(name(again.group_names, again.group[t]), name(materials, mesh.group[t])) << t;
    EXPECT_EQ(name(again.part_names, again.part[t]), name(parts, mesh.part[t])) << t;
  }
  EXPECT_TRUE(file.read(1, 0).group.empty());
}

TEST_F(UsdFileTest, ReadsPlacementsAndSubsetsOfOthers) {
  const UsdFile file(put("a.usda", R"(#usda 1.0
( metersPerUnit = 1
  upAxis = "Z" )
def Xform "shirt" {
    matrix4d xformOp:transform = ( (0, 2, 0, 0), (-2, 0, 0, 0), (0, 0, 2, 0), (10, 20, 30, 1) )
    uniform token[] xformOpOrder = ["xformOp:transform"]
    def Mesh "mesh" {
        float3 xformOp:rotateXYZ = (90, 0, 90)
        float3 xformOp:scale = (1, 1, -1)
        double3 xformOp:translate = (1, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
        int[] faceVertexCounts = [4, 3]
        int[] faceVertexIndices = [0, 1, 2, 3, 0, 1, 3]
        point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,0,1)]
        def GeomSubset "cuff" {
            uniform token elementType = "face"
            int[] indices = [1]
            rel material:binding = </mats/denim>
        }
    }
}
)"));
  const Mesh mesh = file.read(0, 0);
  const auto at = [&](std::size_t v) { return mesh.positions[v] + file.origin(0); };
  // (0, 0, 1): mirrored to (0, 0, -1), about x to (0, 1, 0), about z to (-1, 0, 0), moved to
  // (0, 0, 0), then twice as large and a quarter turn about z.
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(at(3)[k], (Vec3<double>{10, 20, 30}[k]), 1e-12) << k;
    // (1, 0, 0) goes to (0, 1, 0), to (1, 1, 0), to (-2, 2, 0).
    EXPECT_NEAR(at(1)[k], (Vec3<double>{8, 22, 30}[k]), 1e-12) << k;
  }
  expect_same(mesh.triangles, {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 3, 1}}});
  EXPECT_EQ(mesh.group, (std::vector<Index>{0, 0, 1}));
  EXPECT_EQ(mesh.group_names, (std::vector<std::string>{"", "denim"}));
  EXPECT_EQ(mesh.part_names, (std::vector<std::string>{"", "cuff"}));
}

TEST(Usd, NamesLineAndValueOfWhatIsWrong) {
  const std::string head = "#usda 1.0\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "header"},
      {"#usda 2.0\n", "header"},
      {head + "(\n", "line 3: end of file"},
      {head + "(\n metersPerUnit = 0\n)", "metersPerUnit: \"0\""},
      {head + "(\n timeCodesPerSecond = nan\n)", "timeCodesPerSecond"},
      {head + "mesh \"a\" {}", "def, over or class"},
      {head + "def Mesh a {}", "line 2"},
      {head + "def Mesh \"a {", "closing quote"},
      {head + "def Mesh \"a\" {\n point3f[] points = [(0,\n}", "line 4"},
      {head + "def Mesh \"a\" {\n point3f[] points = [(0,0,0]", "a value"},
      {head + "def Mesh \"a\" {\n double3 xformOp:shear = (1, 2, 3)\n}", "/a.xformOp:shear"},
      {head + "def Mesh \"a\" {\n matrix4d xformOp:transform = ((1, 0, 0, 1), (0, 1, 0, 0), "
              "(0, 0, 1, 0), (0, 0, 0, 1))\n}",
       "/a.xformOp:transform"},
      {head + "def Mesh \"a\" {\n double3 xformOp:translate.timeSamples = {0: (1, 2, 3), "
              "1: (1, 2, 4)}\n}",
       "/a: a transform"},
      {head + "def Mesh \"a\" {\n double3 xformOp:translate = (1, 2)\n}", "/a.xformOp:translate"},
      {head + "def Mesh \"a\" {\n double3 xformOp:translate = (1, nan, 2)\n}",
       "/a.xformOp:translate"},
      {head + "def Mesh \"a\" {\n uniform token[] xformOpOrder = [\"xformOp:rotateX\"]\n}",
       "/a: a transform (xformOpOrder)"},
      {head + "def Mesh \"a\" ( references = @b.usd@ ) {}", "/a: references"},
      {head + "def Mesh \"a\" {\n variantSet \"v\" = {}}", "/a: variantSet"},
      {head + "def Mesh \"a\" {\n point3f[] points.timeSamples = {1: [], 1: []}\n}",
       "increasing order"},
  };
  for (const auto& [bytes, part] : cases) {
    const std::string message = refusal(bytes);
    EXPECT_EQ(message.find("a.usda: "), 0u) << bytes;
    EXPECT_NE(message.find(part), std::string::npos) << message << "\n" << bytes;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  std::string deep = head;
  for (int k = 0; k < 100000; ++k) deep += "def X \"a\" {";
  EXPECT_NE(refusal(deep).find("within each other"), std::string::npos);
  EXPECT_NE(refusal(head + "def X \"a\" { int a = " + std::string(100000, '[')).find("brackets"),
            std::string::npos);
}

TEST_F(UsdFileTest, NamesAttributeAndValueOfWhatIsWrong) {
  const std::string square = "point3f[] points = [(0,0,0),(1,0,0),(1,1,0)]\n";
  const std::string one = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0,1,2]\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {one, "/m.points: nothing"},
      {square, "/m.faceVertexCounts: nothing"},
      {"point3f[] points = [(0,0,nan)]\n" + one, "/m.points[0]: nan"},
      {"point3f[] points = [(0,0,1e300)]\n" + one, "/m.points[0]: inf"},
      {"point3f[] points = [(0,0)]\n" + one, "/m.points"},
      {"point3f[] points = 3\n" + one, "/m.points"},
      {"point3f[] points = [(0,x,0)]\n" + one, "/m.points"},
      {square + "int[] faceVertexCounts = [2]\nint[] faceVertexIndices = [0,1]\n", "2 corners"},
      {square + "int[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0,1,2]\n", "3 corners"},
      {square + "int[] faceVertexCounts = []\nint[] faceVertexIndices = []\n", "no faces"},
      {square + "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0,1,3]\n",
       "faceVertexIndices: 3"},
      {square + "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0,1,-1]\n",
       "faceVertexIndices[2]"},
      {square + one + "texCoord2f[] primvars:st = [(0,0)] (interpolation = \"vertex\")\n",
       "/m.primvars:st: 1 values"},
      {square + one +
           "texCoord2f[] primvars:st = [(0,0)] (interpolation = \"faceVarying\")\n"
           "int[] primvars:st:indices = [0,0,1]\n",
       "/m.primvars:st:indices: 1"},
  };
  for (const auto& [body, part] : cases) {
    const auto path = put("a.usda", "#usda 1.0\ndef Mesh \"m\" {\n" + body + "}\n");
    std::string message;
    try {
      UsdFile(path).read(0, 0);
    } catch (const SceneError& error) {
      message = error.what();
    }
    EXPECT_NE(message.find(part), std::string::npos) << message << "\n" << body;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_THROW(UsdFile(put("a.usda", "#usda 1.0\n")), SceneError);
  EXPECT_THROW(UsdFile(directory_ / "none.usda"), SceneError);
  EXPECT_THROW(UsdFile{directory_}, SceneError);
}

TEST_F(UsdFileTest, TruncatedAndDamagedFilesNeverCrash) {
  write_two(directory_ / "a.spool", 2);
  write_usd(directory_ / "a.usda", SpoolReader(directory_ / "a.spool"));
  const std::string good = read_file_bytes(directory_ / "a.usda");
  EXPECT_EQ(refusal(good), "");
  for (std::size_t n = 0; n + 2 < good.size(); ++n)
    if (refusal(std::string_view(good).substr(0, n)).empty()) {
      // Cut between two statements, before the first prim: a file without meshes.
      EXPECT_LE(n, good.find("def Xform")) << n << " bytes";
      EXPECT_THROW(UsdFile(put("b.usda", std::string_view(good).substr(0, n))), SceneError);
    }
  std::mt19937 random(9);
  for (int round = 0; round < 1000; ++round) {
    std::string bytes = good;
    for (unsigned k = 0; k <= random() % 4; ++k)
      bytes[random() % bytes.size()] = "[](){}\"'#<@,:=0x\0\n"[random() % 18];
    try {
      const UsdFile file(put("b.usda", bytes));
      for (std::size_t m = 0; m < file.meshes().size(); ++m) {
        const Mesh mesh = file.read(m, file.times().back());
        for (const Tri& t : mesh.triangles)
          for (const Index v : t.v) ASSERT_LT(static_cast<std::size_t>(v), mesh.positions.size());
      }
    } catch (const SceneError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace weft::io
