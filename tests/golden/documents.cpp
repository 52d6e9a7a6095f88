// What a newcomer copies out of README and scenes/README works as it stands there.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

/// The blocks of code in a document, from a heading on.
/// @param language as after the opening fence; empty: none
std::vector<std::string> code_blocks(const std::string& document, const std::string& heading,
                                     const std::string& language) {
  std::istringstream lines(text_of(fs::path(WEFT_SOURCE_DIR) / document));
  std::vector<std::string> blocks;
  bool reached = false, inside = false, wanted = false;
  for (std::string line; std::getline(lines, line);) {
    reached = reached || line == heading;
    if (!reached) continue;
    if (line.starts_with("```")) {
      inside = !inside;
      wanted = inside && line == "```" + language;
      if (wanted) blocks.emplace_back();
    } else if (wanted) {
      blocks.back() += line + "\n";
    }
  }
  return blocks;
}

/// A square sheet with texture coordinates from 0 to 1, as other programs write it.
std::string cloth_obj() {
  std::ostringstream out;
  constexpr int cells = 12;
  out << "o sheet\n";
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      out << "v " << 0.8 * i / cells - 0.4 << " " << 0.8 * j / cells - 0.4 << " 0.25\nvt "
          << 1.0 * i / cells << " " << 1.0 * j / cells << "\n";
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i + 1, b = a + cells + 1;
      out << "f " << a << "/" << a << " " << a + 1 << "/" << a + 1 << " " << b + 1 << "/" << b + 1
          << " " << b << "/" << b << "\n";
    }
  return out.str();
}

/// A box of quadrilaterals.
std::string body_obj() {
  return "v -.2 -.2 0\nv .2 -.2 0\nv .2 .2 0\nv -.2 .2 0\nv -.2 -.2 .2\nv .2 -.2 .2\nv .2 .2 .2\n"
         "v -.2 .2 .2\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
}

class Documents : public Process {
 protected:
  void SetUp() override {
    write("cloth.obj", cloth_obj());
    write("body.obj", body_obj());
  }
};

TEST_F(Documents, ReadmesOwnMeshRuns) {
  const auto scenes = code_blocks("README.md", "## Your own mesh", "json");
  ASSERT_GE(scenes.size(), 2u);
  write("mine.json", scenes.front());
  const auto commands = code_blocks("README.md", "## Your own mesh", "");
  ASSERT_FALSE(commands.empty());
  std::istringstream lines(commands.front());
  int run = 0;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> words;
    std::istringstream stream(line.substr(0, line.find('#')));
    for (std::string word; stream >> word;) words.push_back(word);
    ASSERT_EQ(words.at(0), "weft") << line;
    words.erase(words.begin());
    // Films need ffmpeg, which tests/golden/render.cpp is about.
    if (const auto film = std::find(words.begin(), words.end(), "--movie"); film != words.end())
      words.erase(film, film + 2);
    if (words.front() == "render")
      words.insert(words.end(), {"--size", "160x120", "--samples", "1"});
    if (words.front() == "run") words.emplace_back("--preview");  // as in a terminal
    const int code = weft(words);
    ++run;
    if (words.front() == "view" && err_.find("lacks three.js") != std::string::npos) continue;
    EXPECT_EQ(code, 0) << line << "\n" << out_ << err_;
    EXPECT_EQ(err_, "") << line;
  }
  EXPECT_EQ(run, 4);
  EXPECT_TRUE(fs::exists(at("out/mine/preview.png")));
  // The sheet lies on the box, and hangs down around it.
  const std::string frame = text_of(at("out/mine/frames/cloth_00050.obj"));
  std::istringstream vertices(frame);
  double lowest = 1, highest = -1, x = 0, y = 0, z = 0;
  for (std::string line; std::getline(vertices, line);) {
    std::istringstream row(line);
    std::string kind;
    if (row >> kind >> x >> y >> z && kind == "v") {
      lowest = std::min(lowest, z);
      highest = std::max(highest, z);
    }
  }
  EXPECT_NEAR(highest, 0.2, 0.02);
  EXPECT_LT(lowest, 0.15);
}

TEST_F(Documents, ScenesToCopyRun) {
  const auto scenes = code_blocks("scenes/README.md", "## Three scenes to copy", "json");
  ASSERT_GE(scenes.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = "scene_" + std::to_string(k);
    write(name + ".json", scenes[k]);
    EXPECT_EQ(weft({"run", name + ".json", "-o", name, "--no-preview"}), 0) << err_;
    EXPECT_EQ(err_, "") << name;
    EXPECT_EQ(weft({"check", name}), 0) << out_ << err_;
  }
  std::istringstream steps(text_of(at("scene_2/steps.jsonl")));
  std::string last;
  for (std::string line; std::getline(steps, line);) last = line;
  EXPECT_EQ(Json::parse(last).at("open_seam_pairs"), 0) << "the tube is not closed";
}

}  // namespace
}  // namespace weft::test
