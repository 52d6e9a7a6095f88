#include "host/io/animation/bvh_file.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/file_bytes.hpp"
#include "host/base/lower_case.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr std::size_t max_shown = 40;
constexpr std::size_t max_joints = 100000;
constexpr std::size_t max_name = 255;  // every end site of a joint has its name

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

/// As one line of printable characters.
std::string shown(std::string_view token) {
  return token.empty() ? "end of file" : quoted_start(token, max_shown);
}

/// Words of the file; a brace is a word of its own, and a colon parts words like a space.
class Words {
 public:
  Words(std::string_view bytes, const std::string& file) : rest_(bytes), file_(file) {}

  /// @return empty at the end of the file
  std::string_view next() {
    skip_space();
    std::size_t size = 0;
    if (!rest_.empty() && is_brace(rest_[0])) size = 1;
    if (size == 0)
      while (size < rest_.size() && !is_gap(rest_[size]) && !is_brace(rest_[size])) ++size;
    return take(size);
  }
  /// What is left of the line, up to a brace, without the spaces around it.
  std::string_view rest_of_line() {
    std::size_t size = 0;
    while (size < rest_.size() && rest_[size] != '\n' && rest_[size] != '\r' && rest_[size] != '{')
      ++size;
    std::string_view text = take(size);
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
  }
  std::size_t bytes_left() const { return rest_.size(); }

  [[noreturn]] void refuse(const std::string& field, std::string_view value,
                           const std::string& allowed) const {
    throw SceneError(file_, "line " + std::to_string(line_) + ": " + field, shown(value), allowed);
  }
  /// The next word must be this one, in any case.
  void expect(const std::string& word) {
    const std::string_view found = next();
    if (lower_case(found) != lower_case(word)) refuse(word, found, "\"" + word + "\" here");
  }
  double number(const std::string& field) {
    const std::string_view token = next();
    double value = 0;
    // Bounded, so that nothing that is made of them overflows.
    if (!parse_number(token, value) || !(std::fabs(value) <= 1e9))
      refuse(field, token, "a number from -1e9 to 1e9");
    return value;
  }
  std::size_t count(const std::string& field, std::size_t most) {
    const std::string_view token = next();
    long long value = 0;
    if (!parse_number(token, value) || value < 0 || std::cmp_greater(value, most))
      refuse(field, token, "an integer from 0 to " + std::to_string(most));
    return static_cast<std::size_t>(value);
  }

 private:
  static bool is_gap(char c) { return is_space(c) || c == ':'; }
  static bool is_brace(char c) { return c == '{' || c == '}'; }
  void skip_space() {
    std::size_t size = 0;
    while (size < rest_.size() && is_gap(rest_[size])) ++size;
    take(size);
  }
  std::string_view take(std::size_t size) {
    const std::string_view text = rest_.substr(0, size);
    line_ += static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
    rest_.remove_prefix(size);
    return text;
  }

  std::string_view rest_;
  const std::string& file_;
  std::size_t line_ = 1;
};

CaptureChannel channel_of(Words& words, std::string_view token) {
  const std::string word = lower_case(token);
  const bool rotation = word.size() == 9 && word.ends_with("rotation");
  const bool position = word.size() == 9 && word.ends_with("position");
  if ((rotation || position) && word[0] >= 'x' && word[0] <= 'z') return {rotation, word[0] - 'x'};
  words.refuse("CHANNELS", token,
               "Xposition, Yposition, Zposition, Xrotation, Yrotation, Zrotation");
}

void read_channels(Words& words, CaptureJoint& joint, Capture& capture) {
  if (joint.end_site || !joint.channels.empty())
    words.refuse("CHANNELS", "CHANNELS", "once a joint, and not in an End Site");
  joint.first_channel = capture.channel_count;
  for (std::size_t left = words.count("CHANNELS", 6); left > 0; --left) {
    const std::string_view token = words.next();
    const CaptureChannel channel = channel_of(words, token);
    for (const CaptureChannel& other : joint.channels)
      if (other.rotation == channel.rotation && other.axis == channel.axis)
        words.refuse("CHANNELS", token, "each channel once a joint");
    joint.channels.push_back(channel);
  }
  capture.channel_count += joint.channels.size();
}

/// Adds a joint whose keyword has been read, up to its opening brace.
void open_joint(Words& words, const std::string& keyword, std::vector<Index>& open,
                Capture& capture) {
  CaptureJoint joint;
  joint.parent = open.empty() ? -1 : open.back();
  joint.end_site = keyword == "end";
  const std::string_view name = words.rest_of_line();
  if (name.size() > max_name)
    words.refuse("JOINT", name, "a name of up to " + std::to_string(max_name) + " characters");
  joint.name = joint.end_site && joint.parent >= 0
                   ? capture.joints[static_cast<std::size_t>(joint.parent)].name
                   : std::string(name);
  words.expect("{");
  if (capture.joints.size() == max_joints)
    words.refuse("JOINT", name, "up to " + std::to_string(max_joints) + " joints");
  open.push_back(static_cast<Index>(capture.joints.size()));
  capture.joints.push_back(std::move(joint));
}

/// @pre HIERARCHY has been read
void read_hierarchy(Words& words, Capture& capture) {
  std::vector<Index> open;
  while (true) {
    const std::string_view token = words.next();
    const std::string keyword = lower_case(token);
    if (open.empty()) {
      if (keyword == "motion" && !capture.joints.empty()) return;
      if (keyword != "root") words.refuse("HIERARCHY", token, "ROOT, or MOTION after it");
      open_joint(words, keyword, open, capture);
      continue;
    }
    CaptureJoint& joint = capture.joints[static_cast<std::size_t>(open.back())];
    if (keyword == "}") {
      open.pop_back();
    } else if (keyword == "offset") {
      for (int k = 0; k < 3; ++k) joint.offset[k] = words.number("OFFSET");
    } else if (keyword == "channels") {
      read_channels(words, joint, capture);
    } else if ((keyword == "joint" || keyword == "end") && !joint.end_site) {
      open_joint(words, keyword, open, capture);
    } else {
      words.refuse("HIERARCHY", token,
                   joint.end_site ? "OFFSET or }" : "OFFSET, CHANNELS, JOINT, End Site or }");
    }
  }
}

/// @pre MOTION has been read
void read_motion(Words& words, Capture& capture) {
  words.expect("Frames");
  const std::size_t claimed = words.count("Frames", std::size_t{1} << 40);
  words.expect("Frame");
  words.expect("Time");
  capture.frame_time = words.number("Frame Time");
  if (!(capture.frame_time > 0)) words.refuse("Frame Time", "0 or less", "a number > 0");
  if (capture.channel_count == 0) words.refuse("CHANNELS", "none", "at least one channel");
  // A number takes a digit and a space.
  if (claimed == 0 || claimed > (words.bytes_left() + 1) / 2 / capture.channel_count)
    words.refuse("Frames", std::to_string(claimed),
                 "as many as the file holds, at least one, each with " +
                     std::to_string(capture.channel_count) + " numbers");
  capture.frame_count = claimed;
  capture.values.reserve(claimed * capture.channel_count);
  for (std::size_t k = 0; k < claimed * capture.channel_count; ++k)
    capture.values.push_back(words.number("frame " + std::to_string(k / capture.channel_count)));
}

}  // namespace

Capture parse_bvh(std::string_view bytes, const std::string& file) {
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);
  Words words(bytes, file);
  Capture capture;
  words.expect("HIERARCHY");
  read_hierarchy(words, capture);
  read_motion(words, capture);
  return capture;
}

Capture read_bvh(const std::filesystem::path& path) {
  return parse_bvh(read_file_bytes(path), path.string());
}

}  // namespace weft::io
