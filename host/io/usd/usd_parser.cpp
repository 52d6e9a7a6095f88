#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/usd/usd_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr int max_depth = 64;  // of prims, and of brackets in a value
constexpr std::size_t max_path = 1000;

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ';';
}
bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == ':' || c == '.' || c == '+' || c == '-';
}

/// Text without its quotes, or as it is.
std::string unquoted(std::string_view text) {
  const std::size_t quotes = text.size() >= 6 && text.substr(0, 3) == "\"\"\"" ? 3 : 1;
  if (text.size() < 2 * quotes || (text[0] != '"' && text[0] != '\'')) return std::string(text);
  std::string result;
  const std::string_view inner = text.substr(quotes, text.size() - 2 * quotes);
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (inner[i] == '\\' && i + 1 < inner.size()) ++i;
    result += inner[i];
  }
  return result;
}

/// unquoted(), as names go into messages and files.
std::string name_of(std::string_view text) {
  return one_line(unquoted(text));
}

class UsdParser {
 public:
  UsdParser(std::string_view bytes, const std::string& file) : all_(bytes), file_(file) {}

  UsdStage parse() {
    constexpr std::string_view first = "#usda 1.0";
    if (all_.substr(0, first.size()) != first)
      throw SceneError(file_, "header", shown(all_.substr(0, 20)),
                       "\"#usda 1.0\" as the first line");
    at_ = std::min(all_.find('\n'), all_.size());
    skip_space();
    if (peek() == '(')
      read_metadata([&](std::string_view key, std::string_view value) { stage(key, value); });
    for (skip_space(); at_ < all_.size(); skip_space()) read_statement("", 0);
    return std::move(stage_);
  }

 private:
  // ---------------------------------------------------------------------------------- characters
  static std::string shown(std::string_view text) { return quoted_start(text, 40); }
  [[noreturn]] void refuse(const std::string& allowed) const {
    const auto line =
        1 + std::count(all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    throw SceneError(file_, "line " + std::to_string(line),
                     at_ < all_.size() ? shown(all_.substr(at_, 20)) : "end of file", allowed);
  }
  char peek() const { return at_ < all_.size() ? all_[at_] : '\0'; }

  void skip_space() {
    while (at_ < all_.size()) {
      if (is_space(all_[at_]))
        ++at_;
      else if (all_[at_] == '#')
        at_ = std::min(all_.find('\n', at_), all_.size());
      else
        return;
    }
  }
  void expect(char c) {
    skip_space();
    if (peek() != c) refuse(std::string("\"") + c + "\"");
    ++at_;
  }
  /// Letters, digits and what names and numbers have between them; may be empty.
  std::string_view word() {
    skip_space();
    const std::size_t begin = at_;
    while (at_ < all_.size() && is_word(all_[at_])) ++at_;
    return all_.substr(begin, at_ - begin);
  }
  std::string_view need_word(const char* what) {
    const std::string_view result = word();
    if (result.empty()) refuse(what);
    return result;
  }

  void skip_until(std::string_view end) {
    const std::size_t found = all_.find(end, at_);
    if (found == std::string_view::npos) {
      at_ = all_.size();
      refuse(shown(end));
    }
    at_ = found + end.size();
  }
  void skip_string() {
    const char quote = all_[at_];
    if (all_.substr(at_, 3) == std::string(3, quote)) {
      at_ += 3;
      return skip_until(std::string(3, quote));
    }
    for (++at_; at_ < all_.size() && all_[at_] != quote; ++at_)
      if (all_[at_] == '\\') ++at_;
    at_ = std::min(at_, all_.size());
    if (peek() != quote) refuse("a closing quote");
    ++at_;
  }

  /// Passes one value of any kind.
  std::string_view value() {
    skip_space();
    const std::size_t begin = at_;
    std::string open;  // brackets that wait for their end
    do {
      skip_space();
      const char c = peek();
      if (c == '[' || c == '(' || c == '{') {
        open += c == '[' ? ']' : c == '(' ? ')' : '}';
        if (open.size() > max_depth) refuse("fewer brackets within each other");
        ++at_;
      } else if (!open.empty() && c == open.back()) {
        open.pop_back();
        ++at_;
      } else if (c == '"' || c == '\'') {
        skip_string();
      } else if (c == '@' || c == '<') {
        ++at_;
        skip_until(c == '@' ? "@" : ">");
      } else if (is_word(c)) {
        while (is_word(peek())) ++at_;
      } else if (!open.empty() && (c == ',' || c == '=')) {
        ++at_;
      } else {
        refuse("a value");
      }
    } while (!open.empty());
    return all_.substr(begin, at_ - begin);
  }

  // ---------------------------------------------------------------------------------- statements
  /// "(" key = value ... ")"; calls on_entry(key, value).
  template <class OnEntry>
  void read_metadata(OnEntry&& on_entry) {
    expect('(');
    for (skip_space(); peek() != ')'; skip_space()) {
      if (peek() == '"' || peek() == '\'') {  // a comment as text
        skip_string();
        continue;
      }
      std::string_view key = need_word("a name or \")\"");
      for (std::string_view next = word(); !next.empty(); next = word()) key = next;  // prepend ...
      expect('=');
      on_entry(key, value());
      skip_space();
      if (peek() == ',') ++at_;
    }
    ++at_;
  }

  void stage(std::string_view key, std::string_view value) {
    if (key == "upAxis") stage_.y_up = unquoted(value) != "Z";
    const bool rate = key == "timeCodesPerSecond";
    if (!rate && key != "metersPerUnit") return;
    double number = 0;
    if (!parse_number(value, number) || !std::isfinite(number) || !(number > 0))
      throw SceneError(file_, std::string(key), shown(value), "a finite number > 0");
    (rate ? stage_.time_codes_per_second : stage_.meters_per_unit) = number;
  }

  /// A prim, or a property of the prim at `path`.
  void read_statement(const std::string& path, int depth) {
    skip_space();
    std::string_view first = need_word("a prim or a property");
    if (first == "def" || first == "over" || first == "class") return read_prim(first, path, depth);
    if (depth == 0) refuse("def, over or class");
    if (first == "variantSet")
      throw SceneError(file_, path, "variantSet", "prims without variants");
    if (first == "reorder") {
      word();
      expect('=');
      value();
      return;
    }
    read_property(first, path);
  }

  void read_prim(std::string_view specifier, const std::string& parent, int depth) {
    if (depth >= max_depth) refuse("fewer prims within each other");
    skip_space();
    std::string_view type;
    if (peek() != '"' && peek() != '\'') type = need_word("a type or a name in quotes");
    skip_space();
    if (peek() != '"' && peek() != '\'') refuse("a name in quotes");
    const std::size_t begin = at_;
    skip_string();
    const std::string name = name_of(all_.substr(begin, at_ - begin));
    const std::string path = parent + "/" + name;
    // Every mesh keeps its path, so that long ones would add up.
    if (path.size() > max_path)
      refuse("names of up to " + std::to_string(max_path) + " characters with those around them");
    skip_space();
    if (peek() == '(')
      read_metadata([&](std::string_view key, std::string_view) {
        if (key == "references" || key == "payload" || key == "inherits" || key == "variants")
          throw SceneError(file_, path, std::string(key), "prims that stand in this file whole");
      });
    const bool is_mesh = type == "Mesh" && specifier == "def";
    stage_.skeleton = stage_.skeleton || type == "Skeleton" || type == "SkelRoot";
    UsdMeshPrim mesh;
    mesh.path = path;
    mesh.name = name;
    mesh.obstacle = path.find("/obstacles/") != std::string::npos;
    UsdMeshPrim* outer = std::exchange(mesh_, is_mesh ? &mesh : nullptr);
    const bool is_subset = type == "GeomSubset" && specifier == "def" && outer != nullptr;
    UsdSubset subset;
    UsdSubset* outer_subset = std::exchange(subset_, is_subset ? &subset : nullptr);
    const bool outer_labelled = std::exchange(labelled_, false);
    UsdTransform around = std::exchange(transform_, {});
    const std::size_t first_inside = stage_.meshes.size();
    expect('{');
    for (skip_space(); peek() != '}'; skip_space()) read_statement(path, depth + 1);
    ++at_;
    mesh_ = outer;
    subset_ = outer_subset;
    if (is_subset && !labelled_) subset.label.part = name;
    labelled_ = outer_labelled;
    if (is_subset) outer->subsets.push_back(std::move(subset));
    if (is_mesh) stage_.meshes.push_back(std::move(mesh));
    UsdPlacement placement;
    if (!transform_.placement(placement)) refuse_transform(path, "xformOpOrder");
    for (std::size_t m = first_inside; m < stage_.meshes.size(); ++m) {
      UsdPlacement& inner = stage_.meshes[m].placement;
      inner = composed(placement, inner);
    }
    transform_ = std::move(around);
  }

  /// [custom] [uniform] [prepend ...] type name [.timeSamples] [= value] [(metadata)]
  void read_property(std::string_view first, const std::string& path) {
    for (const std::string_view keyword : {"custom", "prepend", "append", "add", "delete",
                                           "reorder", "varying", "uniform", "config"})
      if (first == keyword) first = need_word("a type");
    const bool relationship = first == "rel";
    skip_space();
    if (peek() == '[') {
      ++at_;
      expect(']');
    }
    std::string_view name = need_word("the name of a property");
    constexpr std::string_view timed = ".timeSamples";
    constexpr std::string_view connect = ".connect";
    const bool samples = name.ends_with(timed);
    if (samples) name.remove_suffix(timed.size());
    skip_space();
    if (name == "xformOpOrder" || name.starts_with("xformOp:")) {
      if (peek() != '=') return;  // declared without a value
      ++at_;
      return read_transform(path, name, samples ? value_that_stays(path, name) : value());
    }
    UsdAttribute* attribute =
        relationship || name.ends_with(connect) ? nullptr : attribute_of(name);
    if (peek() == '=') {
      ++at_;
      if (samples)
        read_samples(attribute);
      else
        note_value(name, attribute, value());
    }
    skip_space();
    if (peek() == '(')
      read_metadata([&](std::string_view key, std::string_view text) {
        if (mesh_ && name == "primvars:st" && key == "interpolation")
          mesh_->st_face_varying = unquoted(text) == "faceVarying";
      });
  }

  [[noreturn]] void refuse_transform(const std::string& path, std::string_view name) const {
    throw SceneError(file_, path, "a transform (" + std::string(name.substr(0, 60)) + ")",
                     "operations that are there, the same at all times");
  }

  /// The value of time samples that are all the same.
  std::string_view value_that_stays(const std::string& path, std::string_view name) {
    UsdAttribute samples;
    read_samples(&samples);
    for (const UsdSample& sample : samples.samples)
      if (sample.value != samples.samples.front().value) refuse_transform(path, name);
    return samples.samples.empty() ? std::string_view() : samples.samples.front().value;
  }

  void read_transform(const std::string& path, std::string_view name, std::string_view text) {
    if (!(name == "xformOpOrder" ? transform_.set_order(text) : transform_.set(name, text)))
      throw SceneError(file_, path + "." + std::string(name.substr(0, 60)), shown(text),
                       "translate, scale, rotate, orient or transform with numbers from -1e12 to "
                       "1e12");
  }

  UsdAttribute* attribute_of(std::string_view name) const {
    if (subset_) return name == "indices" ? &subset_->indices : nullptr;
    if (!mesh_) return nullptr;
    if (name == "velocities") return &mesh_->velocities;
    if (name == "points") return &mesh_->points;
    if (name == "faceVertexCounts") return &mesh_->counts;
    if (name == "faceVertexIndices") return &mesh_->indices;
    if (name == "primvars:st") return &mesh_->st;
    if (name == "primvars:st:indices") return &mesh_->st_indices;
    return nullptr;
  }

  void note_value(std::string_view name, UsdAttribute* attribute, std::string_view text) {
    if (attribute && !attribute->timed) attribute->samples = {{0, text}};
    if (mesh_ || subset_) note_label(name, text, subset_ ? subset_->label : mesh_->label);
    if (!mesh_) return;
    if (name == "weft:name") mesh_->name = name_of(text);
    if (name == "orientation") mesh_->left_handed = unquoted(text) == "leftHanded";
  }

  void note_label(std::string_view name, std::string_view text, UsdLabel& label) {
    if (name == "weft:part") label.part = name_of(text);
    if (name == "weft:label") label.panel = name_of(text);
    if (name == "weft:material") {
      label.material = name_of(text);
      labelled_ = true;
    }
    if (name != "material:binding" || labelled_) return;
    const std::size_t end = text.find('>');
    const std::size_t begin = text.substr(0, end).find_last_of("/<");
    if (end != std::string_view::npos && begin != std::string_view::npos)
      label.material = one_line(text.substr(begin + 1, end - begin - 1));
  }

  /// "{" time : value, ... "}"
  void read_samples(UsdAttribute* attribute) {
    std::vector<UsdSample> samples;
    expect('{');
    for (skip_space(); peek() != '}'; skip_space()) {
      double time = 0;
      // A word may hold colons, and a time is followed by one.
      skip_space();
      const std::size_t begin = at_;
      while (at_ < all_.size() && is_word(all_[at_]) && all_[at_] != ':') ++at_;
      if (!parse_number(all_.substr(begin, at_ - begin), time) || !std::isfinite(time) ||
          (!samples.empty() && !(time > samples.back().time))) {
        at_ = begin;
        refuse("time codes in increasing order");
      }
      expect(':');
      samples.push_back({time, value()});
      skip_space();
      if (peek() == ',') ++at_;
    }
    ++at_;
    if (!attribute || samples.empty()) return;
    attribute->timed = true;
    attribute->samples = std::move(samples);
  }

  std::string_view all_;
  const std::string& file_;
  std::size_t at_ = 0;
  UsdStage stage_;
  UsdMeshPrim* mesh_ = nullptr;  ///< whose properties are being read
  UsdSubset* subset_ = nullptr;  ///< the same
  bool labelled_ = false;        ///< weft:material says what the prim is made of
  /// Of the prim that is being read. Properties may stand after the prims inside.
  UsdTransform transform_;
};

}  // namespace

UsdStage parse_usd(std::string_view bytes, const std::string& file) {
  return UsdParser(bytes, file).parse();
}

}  // namespace weft::io
