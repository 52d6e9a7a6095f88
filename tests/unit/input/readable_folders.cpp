#include "host/input/readable_folders.hpp"

#include <sys/stat.h>

#include <cstring>
#include <string>

#include "host/io/animation/sequence_file.hpp"
#include "host/io/animation/skinned_file.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

const std::string triangle_obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A triangle whose positions stand in another file.
std::string triangle_gltf(const std::string& uri) {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "body", "mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"uri": ")" +
         uri + R"(", "byteLength": 36}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 0]}],
    "animations": [{"channels": [], "samplers": []}]})";
}

std::string triangle_bytes() {
  const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::string bytes(sizeof positions, '\0');
  std::memcpy(bytes.data(), positions, sizeof positions);
  return bytes;
}

/// A folder "scene" with a scene, and a folder "other" beside it.
class ReadableFoldersTest : public DirectoryTest {
 protected:
  void SetUp() override {
    fs::create_directories(own_ / "below");
    fs::create_directories(other_);
    put("scene/below/mesh.obj", triangle_obj);
    put("other/mesh.obj", triangle_obj);
  }

  fs::path put_scene(const std::string& cloth, const std::string& more = "") const {
    return put("scene/scene.json", R"({"materials": {"cotton": {}}, "cloths": [{"mesh": ")" +
                                       cloth + R"(", "material": "cotton"}])" + more + "}");
  }

  template <class Call>
  static std::string refusal(const Call& call) {
    try {
      call();
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }

  const fs::path own_ = directory_ / "scene";
  const fs::path other_ = directory_ / "other";
  const std::string allowed_ = "; allowed: files below ";
};

TEST_F(ReadableFoldersTest, HoldWhatLiesBelowThem) {
  const ReadableFolders folders(own_ / "scene.json");
  EXPECT_TRUE(folders.contain(own_ / "below/mesh.obj"));
  EXPECT_TRUE(folders.contain(own_ / "below/none.obj"));
  EXPECT_TRUE(folders.contain(own_ / "below/../scene.json"));
  EXPECT_FALSE(folders.contain(other_ / "mesh.obj"));
  EXPECT_FALSE(folders.contain(own_ / "../other/mesh.obj"));
  EXPECT_FALSE(folders.contain(own_ / "../other/none.obj"));
  EXPECT_FALSE(folders.contain(directory_ / "scene_2/mesh.obj"));
  EXPECT_FALSE(folders.contain("/etc/passwd"));
  EXPECT_FALSE(folders.contain(own_ / std::string("below/mesh.obj\0.obj", 19)));
  EXPECT_TRUE(ReadableFolders(own_ / "scene.json", {other_.string()}).contain(other_ / "mesh.obj"));
}

TEST_F(ReadableFoldersTest, FollowSymbolicLinks) {
  fs::create_symlink(other_, own_ / "link");
  fs::create_symlink(other_ / "mesh.obj", own_ / "mesh.obj");
  fs::create_symlink(own_ / "below", own_ / "inside");
  fs::create_symlink("loop", own_ / "loop");
  const ReadableFolders folders(own_ / "scene.json");
  EXPECT_FALSE(folders.contain(own_ / "link/mesh.obj"));
  EXPECT_FALSE(folders.contain(own_ / "mesh.obj"));
  EXPECT_TRUE(folders.contain(own_ / "inside/mesh.obj"));
  EXPECT_FALSE(folders.contain(own_ / "loop/mesh.obj"));
  // A folder may be reached, or allowed, through a link.
  EXPECT_TRUE(ReadableFolders(own_ / "link/scene.json").contain(other_ / "mesh.obj"));
  EXPECT_TRUE(ReadableFolders(own_ / "x", {(own_ / "link").string()}).contain(other_ / "mesh.obj"));
}

TEST_F(ReadableFoldersTest, AllowedOnesMustBeThere) {
  EXPECT_EQ(refusal([&] { ReadableFolders(own_ / "x", {"/no/such/folder"}); }),
            "--allow-path: /no/such/folder; allowed: a folder that is there");
  EXPECT_NE(refusal([&] { ReadableFolders(own_ / "x", {(other_ / "mesh.obj").string()}); }), "");
}

TEST_F(ReadableFoldersTest, BoundWhatASceneNames) {
  EXPECT_EQ(read_scene(put_scene("below/mesh.obj")).cloths.size(), 1u);
  const fs::path real = fs::canonical(directory_);
  for (const std::string& mesh : {std::string("../other/mesh.obj"), (other_ / "mesh.obj").string(),
                                  std::string("below/../../other/mesh.obj")}) {
    const fs::path file = put_scene(mesh);
    EXPECT_EQ(refusal([&] { read_scene(file); }),
              file.string() + ": cloths[0].mesh: " + (other_ / "mesh.obj").string() + allowed_ +
                  (real / "scene").string() + "; --allow-path " + (real / "other").string() +
                  " allows another folder");
    EXPECT_EQ(read_scene(file, {}, {other_.string()}).cloths.size(), 1u);
  }
  fs::create_symlink(other_ / "mesh.obj", own_ / "link.obj");
  EXPECT_NE(refusal([&] { read_scene(put_scene("link.obj")); }).find(allowed_), std::string::npos);
}

TEST_F(ReadableFoldersTest, BoundEveryKindOfFile) {
  put("other/body_00.obj", triangle_obj);
  const struct {
    const char* field;
    const char* key;
  } cases[] = {
      {"cloths[0].rest", R"("rest": "../other/mesh.obj")"},
      {"obstacles[0].mesh", R"({"mesh": "../other/mesh.obj"})"},
      {"obstacles[0].sequence.files", R"({"sequence": {"files": "../other/body_%02d.obj"}})"},
      {"obstacles[0].sequence.points",
       R"({"sequence": {"mesh": "below/mesh.obj", "points": "../other/p.pc2"}})"},
      {"obstacles[0].sequence.mesh",
       R"({"sequence": {"mesh": "../other/mesh.obj", "points": "below/mesh.obj"}})"},
      {"obstacles[0].skinned.file", R"({"skinned": {"file": "../other/a.gltf"}})"},
      {"obstacles[0].capture.file", R"({"capture": {"file": "../other/a.bvh"}})"},
  };
  for (const auto& c : cases) {
    const bool cloth = std::string(c.field).starts_with("cloths");
    const fs::path file =
        cloth ? put_scene("below/mesh.obj\", " + std::string(c.key) + ", \"name\": \"a")
              : put_scene("below/mesh.obj", std::string(R"(, "obstacles": [)") + c.key + "]");
    const std::string found = refusal([&] { read_scene(file); });
    EXPECT_TRUE(found.starts_with(file.string() + ": " + c.field + ": ")) << c.field << found;
    EXPECT_NE(found.find(allowed_), std::string::npos) << c.field << found;
  }
}

TEST_F(ReadableFoldersTest, BoundEachFileOfASequence) {
  put("scene/body_0.obj", triangle_obj);
  fs::create_symlink(other_ / "mesh.obj", own_ / "body_1.obj");
  const std::string found = refusal([&] { read_mesh_sequence(own_ / "body_%d.obj", {}); });
  EXPECT_NE(found.find("files: " + (own_ / "body_1.obj").string() + allowed_), std::string::npos)
      << found;
  fs::remove(own_ / "body_1.obj");
  put("scene/body_1.obj", triangle_obj);
  EXPECT_EQ(read_mesh_sequence(own_ / "body_%d.obj", {}).deformation->frame_count(), 2u);
}

TEST_F(ReadableFoldersTest, BoundWhatAMeshNames) {
  put("scene/below/points.bin", triangle_bytes());
  put("other/points.bin", triangle_bytes());
  const fs::path good = put("scene/good.gltf", triangle_gltf("below/points.bin"));
  EXPECT_EQ(read_mesh(good).triangles.size(), 1u);
  std::vector<std::string> warnings;
  fs::create_symlink(other_ / "points.bin", own_ / "link.bin");
  for (const char* uri : {"../other/points.bin", "link.bin"}) {
    const fs::path bad = put("scene/bad.gltf", triangle_gltf(uri));
    const std::string found = refusal([&] { read_mesh(bad); });
    EXPECT_TRUE(found.starts_with(bad.string() + ": file that it names: ")) << found;
    EXPECT_NE(found.find(allowed_), std::string::npos) << found;
    EXPECT_EQ(refusal([&] { read_skinned(bad, {}, warnings); }), found);
    EXPECT_EQ(read_mesh(bad, Uv::ignore, ReadableFolders(bad, {other_.string()})).triangles.size(),
              1u);
  }
}

TEST_F(ReadableFoldersTest, PipesAreRefusedAndNeverWaitedFor) {
  ASSERT_EQ(::mkfifo((own_ / "pipe.bin").c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo((own_ / "pipe.obj").c_str(), 0600), 0);
  const fs::path mesh = put("scene/mesh.gltf", triangle_gltf("pipe.bin"));
  EXPECT_EQ(refusal([&] { read_mesh(mesh); }),
            (own_ / "pipe.bin").string() + ": cannot read: not a regular file");
  EXPECT_EQ(refusal([&] { read_scene(put_scene("pipe.obj")); }),
            (own_ / "pipe.obj").string() + ": cannot read: not a regular file");
  EXPECT_NE(refusal([&] { read_mesh("/dev/zero"); }), "");
}

TEST_F(ReadableFoldersTest, FilesLargerThanTheMemoryAreRefused) {
  const fs::path sparse = put("scene/below/mesh.obj", "");
  std::error_code error;
  fs::resize_file(sparse, std::uintmax_t{1} << 43, error);
  if (error) GTEST_SKIP() << "no sparse file of 8 TiB here: " << error.message();
  EXPECT_NE(refusal([&] { read_mesh(sparse); }).find("more than the memory"), std::string::npos);
}

TEST_F(ReadableFoldersTest, OfArcsimAreThoseOfItsLayout) {
  const std::string material = R"({"density": 0.1, "stretching": [[100, 20, 100, 80],
    [100, 20, 100, 80], [100, 20, 100, 80], [100, 20, 100, 80], [100, 20, 100, 80],
    [100, 20, 100, 80]], "bending": [[1, 1, 1, 1, 1], [1, 1, 1, 1, 1], [1, 1, 1, 1, 1]]})";
  fs::create_directories(directory_ / "conf");
  fs::create_directories(directory_ / "materials");
  put("materials/paper.json", material);
  const auto scene = [](const std::string& mesh, const std::string& data) {
    return R"({"frame_time": 0.04, "end_time": 1, "cloths": [{"mesh": ")" + mesh +
           R"(", "materials": [{"data": ")" + data + R"("}]}]})";
  };
  const std::string inside = scene("other/mesh.obj", "materials/paper.json");
  EXPECT_EQ(read_scene(put("conf/a.json", inside)).cloths.size(), 1u);
  // Only where the layout is ARCSim's does the folder above belong to the scene.
  EXPECT_NE(refusal([&] { read_scene(put("scene/a.json", inside)); }), "");
  EXPECT_EQ(read_scene(put("scene/a.json", inside), {}, {directory_.string()}).cloths.size(), 1u);
  fs::create_directory(own_ / "conf");
  put("scene/conf/mesh.obj", triangle_obj);
  put("scene/conf/paper.json", material);
  const auto found = [&](const std::string& mesh, const std::string& data) {
    return refusal([&] { read_scene(put("scene/conf/a.json", scene(mesh, data))); });
  };
  EXPECT_EQ(found("mesh.obj", "paper.json"), "");
  EXPECT_NE(found("../other/mesh.obj", "paper.json"), "");
  EXPECT_NE(found("../../other/mesh.obj", "paper.json").find("cloths[0].mesh: "),
            std::string::npos);
  EXPECT_NE(found("mesh.obj", "../../materials/paper.json").find("cloths[0].materials[0].data: "),
            std::string::npos);
}

}  // namespace
}  // namespace weft::io
