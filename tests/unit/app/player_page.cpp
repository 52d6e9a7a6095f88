// The page of the player: its parts, its size, and that nothing in it is more than data. Linked
// with the program's own objects, see tests/CMakeLists.txt.
#include "host/app/view/player_page.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace weft::app {
namespace {

using Json = nlohmann::json;

const PageShell shell{"<head>", "<tail>"};

/// A square sheet of 2 * cells * cells triangles, lifted and bent with time.
io::NamedMesh sheet(int cells, double time, const std::string& name = "sheet") {
  io::NamedMesh named{name, {}};
  const auto at = [&](int i, int j) { return static_cast<Index>(i * (cells + 1) + j); };
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      const double x = static_cast<double>(i) / cells, y = static_cast<double>(j) / cells;
      named.mesh.positions.push_back({x, y, time + 0.1 * std::sin(9 * x + 7 * time) * y});
    }
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      named.mesh.triangles.push_back({{at(i, j), at(i + 1, j), at(i, j + 1)}});
      named.mesh.triangles.push_back({{at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}});
    }
  return named;
}

/// A frame with one cloth and one obstacle at rest, and values that change.
PlayerFrame frame_of(int number, int cells, const std::string& name = "sheet") {
  PlayerFrame frame;
  frame.number = number;
  frame.time = number / 25.0;
  frame.meshes.cloths = {sheet(cells, frame.time, name)};
  frame.meshes.obstacles = {sheet(2, -1, "floor")};
  const std::size_t corners = 3 * frame.meshes.cloths[0].mesh.triangles.size();
  frame.strain.emplace_back();
  for (std::size_t c = 0; c < corners; ++c)
    frame.strain[0].push_back(
        static_cast<float>((c / 3 * 7 + static_cast<std::size_t>(number)) % 100));
  frame.contact.emplace_back();
  for (std::size_t c = 0; c < corners; ++c)
    frame.contact[0].push_back(
        static_cast<float>(frame.meshes.cloths[0].mesh.triangles[c / 3].v[c % 3] % 3 + number % 2));
  return frame;
}

PlayerRanges ranges_of(const std::vector<PlayerFrame>& frames) {
  PlayerRanges ranges;
  ranges.strain = 100;
  ranges.contact = 4;
  for (const PlayerFrame& frame : frames) {
    for (const auto& cloth : frame.meshes.cloths)
      ranges.cloths.include(aabb_of(cloth.mesh.positions));
    for (const auto& body : frame.meshes.obstacles)
      ranges.obstacles.include(aabb_of(body.mesh.positions));
    ranges.obstacles.include(aabb_of(frame.displaced));
    if (!frame.displaced.empty()) ranges.compliance = 0.5;
  }
  return ranges;
}

PlayerRun run_of(const std::vector<PlayerFrame>& frames) {
  PlayerRun run(Json::object(), ranges_of(frames));
  for (const PlayerFrame& frame : frames) run.add(frame);
  return run;
}

std::string between(const std::string& text, const std::string& before, const std::string& after) {
  const std::size_t from = text.find(before);
  if (from == std::string::npos) return {};
  const std::size_t start = from + before.size();
  return text.substr(start, text.find(after, start) - start);
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t number = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++number;
  return number;
}

TEST(PlayerRun, StoresOnceWhatDoesNotChange) {
  const PlayerRun run = run_of({frame_of(0, 3), frame_of(1, 3), frame_of(2, 3)});
  const Json json = run.json();
  ASSERT_EQ(json.at("frames").size(), 3u);
  EXPECT_EQ(json.at("topologies").size(), 1u);
  EXPECT_EQ(json.at("frames")[0].at("obstacles"), json.at("frames")[2].at("obstacles"));
  EXPECT_NE(json.at("frames")[0].at("cloth"), json.at("frames")[1].at("cloth"));
  EXPECT_EQ(json.at("frames")[2].at("displaced"), -1);
  // Triangles of both, the obstacle, and of each frame the cloth, its strain and its contact.
  EXPECT_EQ(run.blobs().size(), 3u + 3 * 3);
  EXPECT_EQ(run.blobs()[json.at("frames")[1].at("cloth").get<std::size_t>()].size(),
            16u * 6 * 4 / 3);
}

TEST(PlayerRun, TopologyMayChange) {
  const Json json = run_of({frame_of(0, 3), frame_of(1, 4), frame_of(2, 4)}).json();
  ASSERT_EQ(json.at("topologies").size(), 2u);
  EXPECT_EQ(json.at("topologies")[0].at("cloths")[0].at("triangles"), 18);
  EXPECT_EQ(json.at("topologies")[1].at("cloths")[0].at("triangles"), 32);
  EXPECT_EQ(json.at("frames")[0].at("topology"), 0);
  EXPECT_EQ(json.at("frames")[2].at("topology"), 1);
  EXPECT_EQ(json.at("topologies")[0].at("obstacle_triangles"),
            json.at("topologies")[1].at("obstacle_triangles"));
}

TEST(PlayerRun, DisplacedObstaclesHaveLevels) {
  PlayerFrame frame = frame_of(1, 2);
  for (Vec3<double> p : frame.meshes.obstacles[0].mesh.positions)
    frame.displaced.push_back(p + Vec3<double>{0, 0, 0.25});
  const PlayerRun run = run_of({frame_of(0, 2), frame});
  const Json json = run.json();
  EXPECT_EQ(json.at("frames")[0].at("compliance"), -1);
  const auto levels = json.at("frames")[1].at("compliance").get<std::size_t>();
  EXPECT_EQ(run.blobs().at(levels), base64(std::string(9, '\x7f')));  // 0.25 m of 0.5 m
  EXPECT_NE(json.at("frames")[1].at("displaced"), json.at("frames")[1].at("obstacles"));
}

TEST(PlayerRun, WithoutRangesEachFrameHasItsBoxes) {
  PlayerRanges ranges;
  ranges.strain = 100;
  PlayerRun run({{"steps", Json::array()}}, ranges);
  EXPECT_TRUE(run.empty());
  run.add(frame_of(0, 3));
  run.add(frame_of(25, 3));
  const Json json = run.json();
  const auto top = [](const Json& box) { return box.at(1).at(2).get<double>(); };
  EXPECT_LT(top(json.at("frames")[0].at("cloth_box")), 0.2);
  EXPECT_GT(top(json.at("frames")[1].at("cloth_box")), 0.9);
  EXPECT_EQ(top(json.at("cloth_box")), top(json.at("frames")[1].at("cloth_box")));
  EXPECT_EQ(json.at("cloth_box")[0], json.at("frames")[0].at("cloth_box")[0]);
  EXPECT_FALSE(run_of({frame_of(0, 3)}).json().at("frames")[0].contains("cloth_box"));
}

TEST(PlayerRun, NewsAreWhatAPageLacks) {
  PlayerRun run({{"steps", Json::array()}}, {});
  run.add(frame_of(0, 3));
  const std::size_t blobs = run.blobs().size();
  run.add_step({1, 0.5});
  run.add(frame_of(1, 3));
  run.add_step({2, 1.0});
  const Json news = run.news(1, 1, blobs, 1);
  ASSERT_EQ(news.at("frames").size(), 1u);
  EXPECT_EQ(news.at("frames")[0].at("number"), 1);
  EXPECT_EQ(news.at("topologies").size(), 0u);
  ASSERT_EQ(news.at("blobs").size(), 1u);
  EXPECT_EQ(news.at("frames")[0].at("cloth"), blobs);
  EXPECT_EQ(news.at("steps"), Json::parse("[[2, 1.0]]"));
  EXPECT_EQ(run.news(9, 9, 99, 9).at("frames").size(), 0u);
  EXPECT_EQ(run.news(0, 0, 0, 0).at("blobs").size(), run.blobs().size());
}

TEST(PlayerPage, OnlyALivePageAsksItsServer) {
  const PageShell strict{"<meta content=\"default-src 'none'; script-src 'x'\">", "<tail>"};
  const PlayerRun run = run_of({frame_of(0, 2)});
  EXPECT_EQ(player_page(strict, {run}).find("connect-src"), std::string::npos);
  const std::string page = live_page(strict, run);
  EXPECT_TRUE(page.starts_with(
      "<meta content=\"default-src 'none'; connect-src 'self'; script-src 'x'\">"));
  EXPECT_NE(page.find("\"live\":true"), std::string::npos);
}

TEST(PlayerPage, HoldsTheDataBetweenHeadAndTail) {
  const std::vector<PlayerRun> runs{run_of({frame_of(0, 2), frame_of(1, 2)}),
                                    run_of({frame_of(0, 2)})};
  const std::string page = player_page(shell, runs);
  EXPECT_TRUE(page.starts_with("<head>"));
  EXPECT_TRUE(page.ends_with("<tail>"));
  const Json data =
      Json::parse(between(page, "<script type=\"application/json\" id=\"data\">", "</script>"));
  ASSERT_EQ(data.at("runs").size(), 2u);
  EXPECT_EQ(data.at("colours").size(), 255u);
  EXPECT_EQ(between(page, "id=\"run0blob4\">", "</script>"), runs[0].blobs().at(4));
  EXPECT_EQ(count(page, "<script type=\"text/plain\""),
            runs[0].blobs().size() + runs[1].blobs().size());
}

TEST(PlayerPage, NamesStayData) {
  const std::string name = "</script><script>alert(1)</script><!--";
  const std::string page = player_page(shell, {run_of({frame_of(0, 2, name)})});
  EXPECT_EQ(page.find("<script>"), std::string::npos);
  EXPECT_EQ(page.find("<!--"), std::string::npos);
  EXPECT_EQ(count(page, "<script"), count(page, "</script>"));
  const Json data = Json::parse(between(page, "id=\"data\">", "</script>"));
  EXPECT_EQ(data.at("runs")[0].at("topologies")[0].at("cloths")[0].at("name"), name);
}

/// 200 frames of 20,000 triangles with all colours; the tail stands for three.js.
TEST(PlayerPage, LongRunsFitIn40Megabytes) {
  const std::vector<PlayerFrame> ends{frame_of(0, 100), frame_of(199, 100)};
  PlayerRanges ranges = ranges_of(ends);
  ranges.cloths.include(aabb_of({{0, 0, -1}, {1, 1, 9}}));
  PlayerRun run(Json::object(), ranges);
  for (int number = 0; number < 200; ++number) run.add(frame_of(number, 100));
  const std::string three(900'000, ' ');
  const std::string page = player_page({"", three}, {run});
  EXPECT_LT(page.size(), 40'000'000u);
  EXPECT_GT(page.size(), 200u * 10201 * 6);  // positions at least
  RecordProperty("bytes", std::to_string(page.size()));
}

}  // namespace
}  // namespace weft::app
