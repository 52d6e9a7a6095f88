#include "host/app/view/player_page.hpp"

#include <fmt/format.h>

#include <cstddef>

#include "host/input/safe_text.hpp"
#include "host/render/picture_colour.hpp"

namespace weft::app {
namespace {

using Json = nlohmann::ordered_json;

/// The colour map of pictures: an sRGB colour per level.
Json colour_map() {
  Json list = Json::array();
  for (int level = 0; level < no_level; ++level) {
    const auto c =
        io::bytes_of(io::colour_of(static_cast<float>(level) / static_cast<float>(no_level - 1)));
    list.push_back({c[0], c[1], c[2]});
  }
  return list;
}

/// @param live whether the page asks for more
std::string page_of(const PageShell& shell, const std::vector<const PlayerRun*>& runs, bool live) {
  Json data{{"live", live}, {"colours", colour_map()}, {"runs", Json::array()}};
  std::size_t size = shell.head.size() + shell.tail.size();
  for (const PlayerRun* run : runs) {
    data["runs"].push_back(run->json());
    size += run->size();
  }
  // A browser runs no script of a type that it does not know.
  std::string page;
  page.reserve(size + size / 8);
  page += shell.head;
  page += "<script type=\"application/json\" id=\"data\">";
  page += script_json(data.dump(-1, ' ', false, Json::error_handler_t::replace));
  page += "</script>\n";
  for (std::size_t r = 0; r < runs.size(); ++r)
    for (std::size_t b = 0; b < runs[r]->blobs().size(); ++b) {
      page += fmt::format("<script type=\"text/plain\" id=\"run{}blob{}\">", r, b);
      page += runs[r]->blobs()[b];
      page += "</script>\n";
    }
  page += shell.tail;
  return page;
}

}  // namespace

std::string player_page(const PageShell& shell, const std::vector<PlayerRun>& runs) {
  std::vector<const PlayerRun*> list;
  for (const PlayerRun& run : runs) list.push_back(&run);
  return page_of(shell, list, false);
}

std::string live_page(const PageShell& shell, const PlayerRun& run) {
  std::string page = page_of(shell, {&run}, true);
  const std::string policy = "default-src 'none';";
  if (const std::size_t at = page.find(policy); at != std::string::npos && at < shell.head.size())
    page.insert(at + policy.size(), " connect-src 'self';");
  return page;
}

}  // namespace weft::app
