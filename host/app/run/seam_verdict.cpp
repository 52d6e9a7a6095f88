#include "host/app/run/seam_verdict.hpp"

#include <fmt/format.h>

#include <cstddef>

namespace weft::app {
namespace {

/// Seams that a line names.
constexpr std::size_t named_max = 3;

}  // namespace

std::string open_seams_text(const std::vector<SeamState>& seams, bool due_only) {
  std::string text;
  std::size_t count = 0;
  for (std::size_t s = 0; s < seams.size(); ++s) {
    const SeamState& seam = seams[s];
    if (seam.open == 0 || (due_only && !seam.due)) continue;
    if (++count > named_max) continue;
    text += fmt::format(
        "{}seams[{}] (\"{}\" to \"{}\") has {} of {} pairs open, the largest gap is {:.4g} m",
        count > 1 ? "; " : "", s, seam.cloths[0], seam.cloths[1], seam.open, seam.pairs,
        seam.largest_gap);
  }
  if (count > named_max) text += fmt::format("; and {} more", count - named_max);
  return text;
}

nlohmann::ordered_json seams_json(const std::vector<SeamState>& seams) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (std::size_t s = 0; s < seams.size(); ++s) {
    const SeamState& seam = seams[s];
    json.push_back({{"seam", s},
                    {"cloths", seam.cloths},
                    {"pairs", seam.pairs},
                    {"open", seam.open},
                    {"largest_gap", seam.largest_gap},
                    {"closed_at", seam.closed_at ? nlohmann::ordered_json(*seam.closed_at)
                                                 : nlohmann::ordered_json(nullptr)}});
  }
  return json;
}

}  // namespace weft::app
