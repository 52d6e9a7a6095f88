// `weft render`, run as a program: how many pictures, of which size, which arguments are refused,
// and what becomes of a film with and without ffmpeg.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class RenderSubcommand : public Process {
 protected:
  void SetUp() override {
    Process::SetUp();
    ASSERT_EQ(run("run", {"--frames", "3"}), 0) << err_;
  }
  void TearDown() override {
    ::setenv("PATH", path_.c_str(), 1);
    Process::TearDown();
  }

  /// Small and fast, unless `more` says otherwise.
  int render(const std::vector<std::string>& more, const std::string& input = "run") {
    std::vector<std::string> arguments{"render", input};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto add = [&](const std::string& option, const std::string& value) {
      if (std::find(more.begin(), more.end(), option) == more.end())
        arguments.insert(arguments.end(), {option, value});
    };
    add("--size", "64x48");
    add("--samples", "1");
    return weft(arguments);
  }

  std::set<std::string> pictures(const std::string& directory) const {
    std::set<std::string> names;
    if (fs::exists(at(directory)))
      for (const auto& entry : fs::directory_iterator(at(directory)))
        names.insert(entry.path().filename().string());
    return names;
  }

  /// Width and height from the header of a PNG.
  std::pair<int, int> size_of(const std::string& file) const {
    const std::string bytes = text_of(at(file));
    if (bytes.size() < 24) return {0, 0};
    const auto number = [&](std::size_t at) {
      int value = 0;
      for (std::size_t k = 0; k < 4; ++k)
        value = value * 256 + static_cast<unsigned char>(bytes[at + k]);
      return value;
    };
    return {number(16), number(20)};
  }

  void expect_refused(const std::vector<std::string>& more, const std::string& field) {
    EXPECT_EQ(render(more), 2) << field;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find(field), std::string::npos) << err_;
    EXPECT_EQ(pictures("run/pictures").size(), 0u) << field;
  }

  /// A program of the name ffmpeg, the only one in PATH but for what is in /bin and /usr/bin.
  void pretend_ffmpeg(const std::string& script) {
    fs::create_directories(at("programs"));
    const std::string file = write("programs/ffmpeg", "#!/bin/sh\n" + script);
    fs::permissions(file, fs::perms::owner_all);
    ::setenv("PATH", (at("programs").string() + ":/usr/bin:/bin").c_str(), 1);
  }

  const std::string path_ = std::getenv("PATH") != nullptr ? std::getenv("PATH") : "";
};

TEST_F(RenderSubcommand, MakesAPictureOfEachFrame) {
  ASSERT_EQ(render({}), 0) << err_;
  EXPECT_EQ(err_, "");
  EXPECT_EQ(pictures("run/pictures"),
            (std::set<std::string>{"00000.png", "00001.png", "00002.png", "00003.png"}));
  EXPECT_EQ(size_of("run/pictures/00002.png"), (std::pair{64, 48}));
  EXPECT_EQ(line_count(out_), 5) << out_;  // a line a picture and a last one
  EXPECT_NE(text_of(at("run/pictures/00000.png")), text_of(at("run/pictures/00003.png")));
}

TEST_F(RenderSubcommand, PartsOfAMotionLookAsInTheWhole) {
  ASSERT_EQ(render({}), 0) << err_;
  ASSERT_EQ(render({"--frames", "1:3:2", "-o", "some"}), 0) << err_;
  EXPECT_EQ(pictures("some"), (std::set<std::string>{"00001.png", "00003.png"}));
  EXPECT_EQ(text_of(at("some/00003.png")), text_of(at("run/pictures/00003.png")));
  ASSERT_EQ(render({"--frames", "2", "-o", "one"}), 0) << err_;
  EXPECT_EQ(pictures("one"), (std::set<std::string>{"00002.png"}));
  ASSERT_EQ(render({"--frames", "2:", "-o", "rest"}), 0) << err_;
  EXPECT_EQ(pictures("rest"), (std::set<std::string>{"00002.png", "00003.png"}));
  ASSERT_EQ(render({"--frames", "last", "-o", "end"}), 0) << err_;
  EXPECT_EQ(pictures("end"), (std::set<std::string>{"00003.png"}));
}

TEST_F(RenderSubcommand, ColoursAndEdgesChangeThePicture) {
  std::set<std::string> seen;
  const std::vector<std::vector<std::string>> looks{{},
                                                    {"--edges", "--size", "320x240"},
                                                    {"--color", "strain"},
                                                    {"--color", "height"},
                                                    {"--color", "contact"},
                                                    {"--color", "height", "--range", "-1:1"},
                                                    {"--azimuth", "30"}};
  for (auto look : looks) {
    look.insert(look.end(), {"--frames", "3", "-o", "look", "--overwrite"});
    ASSERT_EQ(render(look), 0) << err_;
    EXPECT_TRUE(seen.insert(text_of(at("look/00003.png"))).second) << look[0];
  }
}

TEST_F(RenderSubcommand, ColourScalesAreThoseOfTheFramesShown) {
  for (const std::string color : {"height", "strain"}) {
    ASSERT_EQ(render({"--color", color, "-o", color}), 0) << err_;
    ASSERT_EQ(render({"--color", color, "--frames", "1", "-o", color + "_one"}), 0) << err_;
    EXPECT_NE(text_of(at(color + "/00001.png")), text_of(at(color + "_one/00001.png")));
  }
}

TEST_F(RenderSubcommand, SceneCameraDecidesUnlessItIsLeftOut) {
  ASSERT_EQ(run("filmed", {"--frames", "1", "--set",
                           R"(camera={"resolution": [40, 30], "keys": [)"
                           R"({"position": [2, 0, 1], "look_at": [0, 0, 0]}]})"}),
            0)
      << err_;
  ASSERT_EQ(weft({"render", "filmed", "--samples", "1"}), 0) << err_;
  EXPECT_EQ(size_of("filmed/pictures/00001.png"), (std::pair{40, 30}));
  ASSERT_EQ(weft({"render", "filmed", "--samples", "1", "--camera", "auto", "-o", "auto"}), 0);
  EXPECT_NE(text_of(at("filmed/pictures/00001.png")), text_of(at("auto/00001.png")));
  EXPECT_EQ(weft({"render", "filmed", "--samples", "1", "--azimuth", "3"}), 2);
}

TEST_F(RenderSubcommand, ViewFactorsTheFrustumAndAnotherRun) {
  ASSERT_EQ(run("filmed", {"--method", "view", "--frames", "2", "--set",
                           R"(camera.keys=[{"position": [2, 0, 1], "look_at": [0.3, 0, 0]}])"}),
            0)
      << err_;
  std::set<std::string> seen;
  const std::vector<std::vector<std::string>> looks{{},
                                                    {"--edges"},
                                                    {"--color", "view"},
                                                    {"--camera", "outside"},
                                                    {"--camera", "auto"},
                                                    {"--camera", "outside", "--color", "view"}};
  for (auto look : looks) {
    look.insert(look.end(), {"--frames", "2", "-o", "look", "--size", "160x120", "--overwrite"});
    ASSERT_EQ(render(look, "filmed"), 0) << err_;
    EXPECT_EQ(size_of("look/00002.png"), (std::pair{160, 120}));
    EXPECT_TRUE(seen.insert(text_of(at("look/00002.png"))).second)
        << (look[0].empty() ? "plain" : look[0]);
  }
  ASSERT_EQ(render({"--beside", at("run").string(), "-o", "both"}, "filmed"), 0) << err_;
  EXPECT_EQ(size_of("both/00002.png"), (std::pair{64 + 4 + 64, 48}));
  // Without a camera there is no view to tell of, nor a frame that the other run does not have.
  expect_refused({"--color", "view"}, "--color: view");
  expect_refused({"--camera", "outside"}, "--camera: outside");
  expect_refused({"--beside", at("filmed").string()}, "--beside: ");
}

TEST_F(RenderSubcommand, RefusesBadArguments) {
  expect_refused({"--frames", "7"}, "--frames: 7");
  expect_refused({"--frames", "3:1"}, "--frames: 3:1");
  expect_refused({"--frames", "0:3:0"}, "--frames: 0:3:0");
  expect_refused({"--frames", "some"}, "--frames: some");
  expect_refused({"--size", "64"}, "--size: 64");
  expect_refused({"--size", "0x10"}, "--size: 0x10");
  expect_refused({"--size", "64x99999"}, "--size: 64x99999");
  expect_refused({"--samples", "0"}, "--samples: 0");
  expect_refused({"--color", "heat"}, "--color");
  expect_refused({"--color", "height", "--range", "2:1"}, "--range: 2:1");
  expect_refused({"--range", "1:2"}, "--range: 1:2");
  expect_refused({"--camera", "scene"}, "--camera: scene");
  expect_refused({"--azimuth", "999"}, "--azimuth");
  EXPECT_EQ(render({}, "nothing_here"), 2);
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_EQ(render({"-o", "small.json"}), 2);
  EXPECT_EQ(weft({"render"}), 2);
}

TEST_F(RenderSubcommand, DamagedFrameIsNamed) {
  write("run/frames/cloth_00002.obj", "v 0 0 zero\n");
  EXPECT_EQ(render({}), 2);
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("cloth_00002.obj"), std::string::npos) << err_;
}

TEST_F(RenderSubcommand, RunWithoutItsSceneIsStillShown) {
  fs::remove(at("run/scene.json"));
  EXPECT_EQ(render({"--frames", "3"}), 0) << err_;
  EXPECT_EQ(render({"--color", "contact"}), 2);
  EXPECT_NE(err_.find("thickness"), std::string::npos) << err_;
}

TEST_F(RenderSubcommand, FilmWithoutFfmpegIsRefusedBeforeAnyPicture) {
  ::setenv("PATH", at("").c_str(), 1);
  expect_refused({"--movie", "film.mp4"}, "--movie: film.mp4 without the program ffmpeg");
  EXPECT_FALSE(fs::exists(at("film.mp4")));
  expect_refused({"--movie", "none/film.mp4"}, "--movie: none/film.mp4: No such file");
  for (const auto& entry : fs::directory_iterator(directory_))
    EXPECT_EQ(entry.path().filename().string().find("film"), std::string::npos) << entry.path();
}

TEST_F(RenderSubcommand, EarlierPicturesAreKeptUnlessOverwritten) {
  ASSERT_EQ(render({}), 0) << err_;
  write("run/pictures/notes.txt", "mine");
  const std::string before = text_of(at("run/pictures/00003.png"));
  EXPECT_EQ(render({"--frames", "1", "--azimuth", "30"}), 2);
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("--overwrite"), std::string::npos) << err_;
  EXPECT_EQ(text_of(at("run/pictures/00003.png")), before);
  // What cannot be drawn replaces nothing.
  EXPECT_EQ(render({"--overwrite", "--frames", "9"}), 2);
  EXPECT_EQ(pictures("run/pictures").size(), 5u);
  ASSERT_EQ(render({"--frames", "1", "--azimuth", "30", "--overwrite"}), 0) << err_;
  EXPECT_EQ(out_.substr(out_.rfind('\n', out_.size() - 2) + 1), "1 picture in run/pictures\n");
  EXPECT_EQ(pictures("run/pictures"), (std::set<std::string>{"00001.png", "notes.txt"}));
}

TEST_F(RenderSubcommand, FilmGetsAllPicturesAtTheRatesOfTheRun) {
  // The film is then the command and the number of bytes that came in.
  pretend_ffmpeg("for last; do :; done\n{ echo \"$@\"; wc -c; } > \"$last\"\n");
  ASSERT_EQ(render({"--movie", "film.mp4", "--frames", "0:2:2"}), 0) << err_;
  const std::string film = text_of(at("film.mp4"));
  EXPECT_NE(film.find("-video_size 64x48"), std::string::npos) << film;
  EXPECT_NE(film.find("-framerate 12.5 "), std::string::npos) << film;
  EXPECT_NE(film.find("yuv420p"), std::string::npos) << film;
  EXPECT_NE(film.find("libx264"), std::string::npos) << film;
  EXPECT_NE(film.find("\n" + std::to_string(2 * 64 * 48 * 3) + "\n"), std::string::npos) << film;
}

TEST_F(RenderSubcommand, FilmThatFailsIsAnErrorAndLeavesNothing) {
  for (const char* script : {"cat > /dev/null; echo 'no such encoder' >&2; exit 1\n",
                             "echo 'no such encoder' >&2; exit 1\n"}) {
    pretend_ffmpeg(script);
    EXPECT_EQ(render({"--movie", "film.mp4", "--size", "640x480", "--overwrite"}), 2) << script;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find("no such encoder"), std::string::npos) << err_;
    for (const auto& entry : fs::directory_iterator(directory_))
      EXPECT_EQ(entry.path().filename().string().find("film"), std::string::npos) << entry.path();
  }
  EXPECT_EQ(render({"--movie", "film.avi", "--overwrite"}), 2);
  EXPECT_NE(err_.find("film.avi"), std::string::npos) << err_;
}

TEST_F(RenderSubcommand, FfmpegMakesAFilm) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "there is no program ffmpeg";
  ASSERT_EQ(render({"--movie", "film.mp4", "--size", "65x49"}), 0) << err_;
  const std::string film = text_of(at("film.mp4"));
  EXPECT_EQ(film.substr(4, 4), "ftyp");
  EXPECT_NE(film.find("avc1"), std::string::npos) << "H.264";
}

}  // namespace
}  // namespace weft::test
