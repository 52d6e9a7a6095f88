// Scenes and meshes of strangers: nothing that stands in them runs, decides where files go, or
// reads other files.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

/// What a shell, gnuplot, HTML, a spreadsheet or a terminal would act upon.
const std::string evil_name =
    "x\\n!touch PWNED\\n#'\\\"`touch PWNED`$(touch PWNED)@a\\u001b[31m</script><!--\\\\";

std::string falling_scene(const std::string& name) {
  return R"({"name": ")" + name + R"(",
    "time": {"step": 0.01, "frame_rate": 25, "frames": 2}, "device": "cpu",
    "materials": {"cotton": {"density": 0.15, "stretch_stiffness": 50}},
    "cloths": [{"name": "sheet", "grid": {"size": [0.4, 0.4], "cells": [4, 4]},
                "material": "cotton"}]})";
}

/// Two triangles that do not touch, as two objects.
const std::string two_pieces =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv 2 0 0\nv 3 0 0\nv 2 1 0\nf 4 5 6\n";

class UntrustedFiles : public Process {
 protected:
  /// A scene in the folder "scene" whose mesh lies beside that folder.
  std::string write_scene_elsewhere(const std::string& more = "") {
    fs::create_directories(at("scene"));
    fs::create_directories(at("other"));
    write("other/mesh.obj", two_pieces);
    return write("scene/scene.json", R"({"name": "mesh", "device": "cpu",
      "time": {"step": 0.02, "frame_rate": 25, "frames": 2},
      "materials": {"cotton": {"density": 0.15, "stretch_stiffness": 50}},
      "camera": {"resolution": [40, 30],
                 "keys": [{"position": [2, 0, 4], "look_at": [1, 0, 0]}]},
      "cloths": [{"name": "sheet", "mesh": "../other/mesh.obj", "material": "cotton"}])" +
                                         more + "}");
  }

  std::size_t entries_beside(const fs::path& folder) const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
  }

  void expect_nothing_ran() const {
    for (const auto& entry : fs::recursive_directory_iterator(directory_))
      EXPECT_NE(entry.path().filename(), "PWNED") << entry.path();
  }

  void expect_refused(const std::vector<std::string>& arguments) {
    EXPECT_EQ(weft(arguments), 2) << arguments[0];
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find("cloths[0].mesh: "), std::string::npos) << err_;
    EXPECT_NE(err_.find("files below " + fs::canonical(at("scene")).string() + "; --allow-path " +
                        fs::canonical(at("other")).string() + " allows"),
              std::string::npos)
        << err_;
  }
};

TEST_F(UntrustedFiles, NamesOfScenesStayBelowOut) {
  fs::create_directories(at("deep/folder"));
  const std::size_t before = entries_beside(directory_);
  for (const std::string& name :
       {std::string("../../escaped"), at("absolute").string(), std::string(".."), std::string(""),
        std::string(".hidden"), std::string("-rf")}) {
    const std::string scene = write("deep/folder/scene.json", falling_scene(name));
    fs::remove_all(at("out"));
    ASSERT_EQ(weft({"run", scene, "--no-preview", "--frames", "1"}), 0) << name << err_;
    ASSERT_EQ(entries_beside(at("out")), 1u) << name;
    const fs::path made = fs::directory_iterator(at("out"))->path();
    EXPECT_TRUE(fs::exists(made / "report.json")) << name;
    EXPECT_EQ(made.filename().string()[0], '_') << made;
    EXPECT_EQ(entries_beside(directory_), before + 3) << name;  // out, stdout and stderr
  }
  const std::string scene = write("deep/folder/scene.json", falling_scene("a b-c_d.e"));
  ASSERT_EQ(weft({"run", scene, "--no-preview", "--frames", "1"}), 0) << err_;
  EXPECT_TRUE(fs::exists(at("out/a b-c_d.e/report.json")));
}

TEST_F(UntrustedFiles, NameOfASceneRunsNothingInAChart) {
  const std::string scene = write("evil.json", falling_scene(evil_name));
  const bool gnuplot = std::system("command -v gnuplot >/dev/null 2>&1") == 0;
  const int code = weft({"chart", scene, "-o", "charts", "--quick", "--runs", "1",
                         "--reference-steps", "2", "--device", "cpu:1"});
  ASSERT_EQ(code, gnuplot ? 0 : 2) << err_;
  expect_nothing_ran();
  for (const std::string& text : {out_, err_})
    EXPECT_EQ(text.find('\x1b'), std::string::npos) << text;
  ASSERT_EQ(entries_beside(at("charts")), 1u);
  const fs::path folder = fs::directory_iterator(at("charts"))->path();
  EXPECT_EQ(text_of(folder / "chart.gp").find("\n!"), std::string::npos);
  const std::string page = text_of(folder / "chart.html");
  EXPECT_EQ(page.find("</script>"), page.rfind("</script>"));
  EXPECT_EQ(page.find("<!--"), std::string::npos);
  if (!gnuplot) return;
  const std::string svg = text_of(folder / "chart.svg");
  EXPECT_NE(svg.find("!touch PWNED"), std::string::npos) << "the title is shown";
  EXPECT_EQ(svg.find("</script>"), svg.rfind("</script>"));
}

/// A chart in which each text is `text`.
Json chart_of(const std::string& text) {
  const Json point{{"series", text},       {"label", text},        {"method", text},
                   {"device", text},       {"overrides", {text}},  {"command", text},
                   {"commit", text},       {"state_hash", text},   {"failure", ""},
                   {"seconds", {1.0}},     {"error", 0.01},        {"statistics", nullptr},
                   {"hausdorff", nullptr}, {"curvature", nullptr}, {"stretch", nullptr},
                   {"drift", nullptr},     {"intersections", 0}};
  return {{"scene", text},   {"about", text},    {"reference_floor", 0.001},
          {"machine", text}, {"finished", text}, {"points", {point}}};
}

TEST_F(UntrustedFiles, ChartOfAStrangerRunsNothing) {
  fs::create_directories(at("made"));
  const std::string evil = Json::parse("\"" + evil_name + "\"");
  for (const std::string& text :
       {evil, std::string("=cmd|' /C calc'!A0"), std::string("' ; system \"touch PWNED\" ; '"),
        std::string("`touch PWNED`"), std::string("@PWNED"), std::string("a\0!touch PWNED", 15)}) {
    write("made/chart.json", chart_of(text).dump());
    const bool gnuplot = std::system("command -v gnuplot >/dev/null 2>&1") == 0;
    EXPECT_EQ(weft({"chart", "--draw", "made"}), gnuplot ? 0 : 2) << err_;
    expect_nothing_ran();
    const std::string csv = text_of(at("made/chart.csv"));
    EXPECT_EQ(line_count(csv), 2) << csv;
    EXPECT_EQ(csv.find("\n\"="), std::string::npos) << csv;
    EXPECT_EQ(csv.find(",\"="), std::string::npos) << csv;
    const std::string page = text_of(at("made/chart.html"));
    EXPECT_EQ(page.find("</script>"), page.rfind("</script>"));
    EXPECT_EQ(page.find("<!--"), std::string::npos);
    weft({"chart", "--check", "made"});
    EXPECT_EQ((out_ + err_).find('\x1b'), std::string::npos);
  }
  ASSERT_EQ(::mkfifo(at("made/pipe").c_str(), 0600), 0);
  fs::rename(at("made/pipe"), at("made/chart.json"));
  EXPECT_EQ(weft({"chart", "--draw", "made"}), 2);
  EXPECT_EQ(line_count(err_), 1) << err_;
}

TEST_F(UntrustedFiles, MeshElsewhereNeedsAllowPath) {
  const std::string scene = write_scene_elsewhere();
  const std::string other = at("other").string();
  expect_refused({"run", scene});
  expect_refused({"run", scene, "--need", "intersections=0"});
  expect_refused({"plan", scene, "--probe", "0"});
  expect_refused({"chart", scene});
  EXPECT_FALSE(fs::exists(at("out")));
  EXPECT_EQ(weft({"run", scene, "-o", "run", "--no-preview", "--allow-path", other}), 0) << err_;
  EXPECT_EQ(weft({"plan", scene, "--probe", "0", "--allow-path", other}), 0) << err_;
  EXPECT_NE(out_.find("--allow-path"), std::string::npos) << "the command that it proposes";
  EXPECT_EQ(weft({"run", scene, "-o", "needed", "--no-preview", "--need", "intersections=0",
                  "--allow-path", other}),
            0)
      << err_;
  EXPECT_EQ(weft({"run", scene, "--allow-path", "none"}), 2);
  EXPECT_NE(err_.find("--allow-path: none"), std::string::npos) << err_;
  // The resolved scene of the run names the mesh by its place.
  EXPECT_EQ(weft({"run", "run/scene.json", "-o", "again", "--no-preview"}), 2);
  EXPECT_NE(err_.find("--allow-path " + fs::canonical(other).string()), std::string::npos) << err_;
  EXPECT_EQ(weft({"run", "run/scene.json", "-o", "again", "--no-preview", "--allow-path", other}),
            0)
      << err_;
  EXPECT_EQ(hash("run"), hash("again"));
}

TEST_F(UntrustedFiles, ProcessesOfSlicesGetTheFolders) {
  const std::string scene = write_scene_elsewhere();
  std::string grid;
  constexpr int n = 10;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x)
      grid += "v " + std::to_string(0.05 * x) + " " + std::to_string(0.05 * y) + " 0\n";
  for (int y = 0; y < n; ++y)
    for (int x = 1; x <= n; ++x) {
      const int a = y * (n + 1) + x, b = a + n + 1;
      grid += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(b + 1) +
              " " + std::to_string(b) + "\n";
    }
  write("other/mesh.obj", grid);
  ASSERT_EQ(weft({"run", scene, "-o", "sliced", "--no-preview", "--method", "time_parallel",
                  "--processes", "--workers", "2", "--allow-path", at("other").string()}),
            0)
      << err_;
  EXPECT_TRUE(fs::exists(at("sliced/report.json")));
}

TEST_F(UntrustedFiles, ChartOfAMeshElsewhere) {
  const std::string scene = write_scene_elsewhere();
  weft({"chart", scene, "-o", "charts", "--quick", "--runs", "1", "--reference-steps", "2",
        "--allow-path", at("other").string()});
  const Json chart = Json::parse(text_of(at("charts/mesh/chart.json")));
  EXPECT_EQ(chart.at("points").at(0).at("failure"), "");
  EXPECT_NE(chart.at("points").at(0).at("command").get<std::string>().find("--allow-path"),
            std::string::npos);
}

TEST_F(UntrustedFiles, RunsWithMeshesElsewhereAreShownAndChecked) {
  const std::string scene = write_scene_elsewhere();
  const std::string other = at("other").string();
  for (const std::string& format : {std::string("obj"), std::string("ply")}) {
    ASSERT_EQ(weft({"run", scene, "-o", format, "--no-preview", "--allow-path", other, "--set",
                    "output.format=" + format}),
              0)
        << err_;
    EXPECT_EQ(weft({"check", format}), 0) << err_ << out_;
    ASSERT_EQ(
        weft({"render", format, "--samples", "1", "-o", format + "_known", "--allow-path", other}),
        0)
        << err_;
    EXPECT_EQ(err_, "");
    // Without the mesh the scene still tells the camera, and frames tell the cloths.
    ASSERT_EQ(weft({"render", format, "--samples", "1"}), 0) << err_;
    EXPECT_EQ(err_, "");
    EXPECT_EQ(text_of(at(format + "_known/00001.png")),
              text_of(at(format + "/pictures/00001.png")));
  }
  // Frames that do not.
  for (const auto& entry : fs::directory_iterator(at("ply/frames"))) {
    std::string bytes = text_of(entry.path());
    for (std::size_t p = bytes.find("comment object"); p != std::string::npos;
         p = bytes.find("comment object"))
      bytes.replace(p, 14, "comment nobody");
    std::ofstream(entry.path(), std::ios::binary) << bytes;
  }
  fs::remove_all(at("ply/pictures"));
  ASSERT_EQ(weft({"render", "ply", "--samples", "1"}), 0) << err_;
  EXPECT_NE(err_.find("weft: warning: each connected piece"), std::string::npos) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_EQ(text_of(at("ply/pictures/00001.png")).substr(16, 8),
            text_of(at("ply_known/00001.png")).substr(16, 8))
      << "the scene's resolution";
}

TEST_F(UntrustedFiles, PipesDoNotHang) {
  fs::create_directories(at("scene"));
  ASSERT_EQ(::mkfifo(at("scene/pipe.obj").c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo(at("scene/scene.json").c_str(), 0600), 0);
  write("scene/a.json", R"({"materials": {"cotton": {}},
    "cloths": [{"mesh": "pipe.obj", "material": "cotton"}]})");
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"run", "scene/a.json"},
                                                    {"run", "scene/scene.json"},
                                                    {"check", "scene/pipe.obj"},
                                                    {"check", "scene"},
                                                    {"render", "scene"},
                                                    {"convert", "scene/pipe.obj", "a.ply"},
                                                    {"plan", "scene/a.json"}}) {
    EXPECT_EQ(weft(arguments), 2) << arguments[0] << " " << arguments[1];
    EXPECT_EQ(line_count(err_), 1) << err_;
  }
}

TEST_F(UntrustedFiles, MessagesAreOneLineWithoutControlCharacters) {
  write("evil.obj", "o a\x1b[31m\nv 0 0 \x1b[2J\n");
  EXPECT_EQ(weft({"check", "evil.obj"}), 2);
  EXPECT_EQ(err_.find('\x1b'), std::string::npos) << err_;
  EXPECT_EQ(weft({"run", "none\x1b[31m\n.json"}), 2);
  EXPECT_EQ(err_.find('\x1b'), std::string::npos) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
}

TEST_F(UntrustedFiles, NamesOfObjectsDecideNothing) {
  write("in.obj",
        "o ../../up\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        "o .._.._up\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 4 5 6\n"
        "o a\x1b[31m\\\nv 0 0 2\nv 1 0 2\nv 0 1 2\nf 7 8 9\n");
  fs::create_directories(at("to"));
  ASSERT_EQ(weft({"convert", "in.obj", "to/out.pc2"}), 0) << err_;
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(at("to")))
    if (entry.path().extension() == ".pc2") files.push_back(entry.path().filename().string());
  std::sort(files.begin(), files.end());
  EXPECT_EQ(files, (std::vector<std::string>{"out__._.._up.pc2", "out__._.._up_2.pc2",
                                             "out_a__31m_.pc2"}));
  ASSERT_EQ(weft({"convert", "in.obj", "to/out.usda"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "to/out.usda", "to/again.obj"}), 0) << err_;
  for (const char* name : {"to/out.usda", "to/again.obj"})
    EXPECT_EQ(text_of(at(name)).find('\x1b'), std::string::npos) << name;
  EXPECT_EQ(text_of(at("to/again.obj")).find("\\\n"), std::string::npos);
}

}  // namespace
}  // namespace weft::test
