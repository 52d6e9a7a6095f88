// ASTM D6673 (AAMA): a block per piece, layers by number, and texts such as "Piece Name: FRONT".
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "host/base/lower_case.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/pattern/outline_file.hpp"
#include "host/io/pattern/outline_points.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

enum Layer {
  boundary = 1,
  turn_points = 2,
  notches = 4,
  mirror_line = 6,
  grain_line = 7,
  sew_lines = 14
};

/// A row of points in the units of the file.
struct DxfPolyline {
  int layer = -1;
  bool closed = false;
  std::size_t line = 0;  ///< of the file
  std::vector<Vec2<double>> points;
};

/// A block, or the entities outside all blocks.
struct DxfPiece {
  std::string block;
  std::string name{};  ///< "Piece Name:"; empty: none
  std::size_t line = 0;
  std::vector<DxfPolyline> polylines{};
  std::vector<std::array<Vec2<double>, 2>> mirrors{}, grains{};
  std::vector<Vec2<double>> turns{}, notches{};
};

/// What a group code 0 begins, up to the next one.
struct DxfEntity {
  std::string type{};
  std::size_t line = 0;
  std::string layer{}, text{}, name{};
  int flags = 0;
  std::vector<double> x{}, y{};            ///< codes 10 and 20
  std::map<std::size_t, double> bulges{};  ///< code 42 by the point before
  double x1 = 0, y1 = 0;                   ///< codes 11 and 21
};

std::string trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin));
}

class DxfReader {
 public:
  DxfReader(std::string_view bytes, const std::string& file) : rest_(bytes), file_(file) {}

  void read() {
    if (rest_.starts_with("AutoCAD Binary DXF"))
      throw SceneError(file_, "format", "binary DXF", "DXF as text");
    int code = 0;
    std::string value;
    while (!ended_ && next(code, value)) {
      if (code == 0)
        begin_entity(value);
      else if (section_ == "HEADER")
        read_variable(code, value);
      else
        take(code, value);
    }
    if (!ended_) throw SceneError(file_, "EOF", "missing", "a whole file, which ends with 0, EOF");
  }

  std::vector<DxfPiece> pieces() && { return std::move(pieces_); }
  std::optional<double> unit() const { return text_unit_ ? text_unit_ : header_unit_; }

 private:
  [[noreturn]] void refuse(std::size_t line, const std::string& field, const std::string& value,
                           const std::string& allowed) const {
    throw SceneError(file_, "line " + std::to_string(line) + ": " + field,
                     "\"" + one_line(value.substr(0, 60)) + "\"", allowed);
  }

  std::string_view next_line() {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++line_;
    return line;
  }

  /// @return false at the end of the file
  bool next(int& code, std::string& value) {
    if (trimmed(rest_.substr(0, 16)).empty() && rest_.find_first_not_of(" \t\r\n") == rest_.npos)
      return false;
    const std::string number = trimmed(next_line());
    long long given = 0;
    if (!parse_number(std::string_view(number), given) || given < -5 || given > 1071)
      refuse(line_, "group code", number, "a whole number from -5 to 1071");
    if (rest_.empty())
      refuse(line_, "group code " + number, "end of file", "a value in the next line");
    code = static_cast<int>(given);
    value = trimmed(next_line());
    return true;
  }

  double number(const std::string& value, int code) const {
    double result = 0;
    if (!parse_number(std::string_view(value), result) || !std::isfinite(result))
      refuse(line_, "code " + std::to_string(code), value, "a finite number");
    return result;
  }

  void read_variable(int code, const std::string& value) {
    if (code == 9) variable_ = value;
    if (code != 70) return;
    const double given = number(value, code);
    if (variable_ == "$INSUNITS") {
      const std::map<double, double> units{{1, 0.0254}, {4, 0.001}, {5, 0.01}, {6, 1}};
      if (const auto found = units.find(given); found != units.end()) header_unit_ = found->second;
    } else if (variable_ == "$MEASUREMENT" && !header_unit_) {
      header_unit_ = given == 0 ? 0.0254 : 0.001;
    }
  }

  void take(int code, const std::string& value) {
    DxfEntity& e = entity_;
    if (e.type == "SECTION" && code == 2) section_ = value;
    const auto at_most = [&](std::size_t count) {
      if (count >= most_outline_points)
        refuse(e.line, e.type, std::to_string(count) + " points or more",
               "up to " + std::to_string(most_outline_points));
    };
    switch (code) {
      case 1:
        e.text = value;
        break;
      case 2:
        e.name = value;
        break;
      case 8:
        e.layer = value;
        break;
      case 10:
        at_most(e.x.size());
        e.x.push_back(number(value, code));
        break;
      case 20:
        at_most(e.y.size());
        e.y.push_back(number(value, code));
        break;
      case 11:
        e.x1 = number(value, code);
        break;
      case 21:
        e.y1 = number(value, code);
        break;
      case 42:
        if (const double bulge = number(value, code); bulge != 0 && !e.x.empty())
          e.bulges[e.x.size() - 1] = bulge;
        break;
      case 70:
        e.flags = static_cast<int>(std::clamp(number(value, code), 0.0, 1e6));
        break;
      default:
        break;
    }
  }

  void begin_entity(const std::string& type) {
    finish();
    entity_ = DxfEntity{};
    entity_.type = type;
    entity_.line = line_;
    if (type == "EOF") ended_ = true;
    if (type == "ENDSEC") section_.clear();
    if (type == "ENDBLK") in_block_ = false;
  }

  DxfPiece& piece() {
    if (in_block_) return pieces_.back();
    if (!loose_) {
      loose_ = pieces_.size();
      add_piece("panel");
    }
    return pieces_[*loose_];
  }

  void add_piece(const std::string& block) {
    if (pieces_.size() >= most_outline_panels)
      refuse(entity_.line, "blocks", "more than " + std::to_string(most_outline_panels), "fewer");
    pieces_.push_back({one_line(block)});
    pieces_.back().line = entity_.line;
  }

  int layer_of(const DxfEntity& e) const {
    long long number = -1;
    return parse_number(std::string_view(e.layer), number) && number >= 0 && number < 1000
               ? static_cast<int>(number)
               : -1;
  }

  /// Takes note of an entity that is whole.
  void finish() {
    DxfEntity& e = entity_;
    if (e.type == "BLOCK") {
      add_piece(e.name);
      in_block_ = true;
    }
    const bool content = section_ == "BLOCKS" || section_ == "ENTITIES";
    if (!content) return;
    if (e.type == "POLYLINE") {
      vertex_bulge_ = 0;
      open_ = DxfPolyline{layer_of(e), (e.flags & 1) != 0, e.line, {}};
    } else if (e.type == "VERTEX") {
      if (open_) add_vertices(e, *open_);
      vertex_bulge_ = e.bulges.empty() ? 0 : e.bulges.begin()->second;
    } else if (e.type == "SEQEND") {
      if (open_ && open_->closed && !open_->points.empty() && vertex_bulge_ != 0)
        add_arc(open_->points.back(), open_->points.front(), vertex_bulge_, open_->points);
      if (open_) add_polyline(std::move(*open_));
      open_.reset();
    } else if (e.type == "LWPOLYLINE") {
      DxfPolyline own{layer_of(e), (e.flags & 1) != 0, e.line, {}};
      add_vertices(e, own);
      add_polyline(std::move(own));
    } else if (e.type == "LINE") {
      add_line(e);
    } else if (e.type == "POINT") {
      add_point(e);
    } else if (e.type == "TEXT" || e.type == "MTEXT") {
      add_text(e.text);
    }
  }

  void need_points(const DxfEntity& e, std::size_t least) const {
    if (e.x.size() < least || e.x.size() != e.y.size())
      refuse(e.line, e.type,
             std::to_string(e.x.size()) + " x and " + std::to_string(e.y.size()) + " y",
             "codes 10 and 20 for each point");
  }

  void add_vertices(const DxfEntity& e, DxfPolyline& to) {
    need_points(e, 1);
    for (std::size_t k = 0; k < e.x.size(); ++k) {
      const Vec2<double> p{e.x[k], e.y[k]};
      const auto found = k == 0 ? e.bulges.end() : e.bulges.find(k - 1);
      double bulge = found == e.bulges.end() ? 0 : found->second;
      if (e.type == "VERTEX") bulge = to.points.empty() ? 0 : vertex_bulge_;
      if (bulge != 0) add_arc(to.points.back(), p, bulge, to.points);
      to.points.push_back(p);
      if (to.points.size() > most_outline_points)
        refuse(to.line, "polyline", std::to_string(to.points.size()) + " points or more",
               "up to " + std::to_string(most_outline_points));
    }
    if (e.type == "LWPOLYLINE" && to.closed)
      if (const auto last = e.bulges.find(e.x.size() - 1); last != e.bulges.end())
        add_arc(to.points.back(), to.points.front(), last->second, to.points);
  }

  /// Points between the ends of an arc, 5 degrees apart at most.
  /// @param bulge tangent of a quarter of its angle; > 0: counter-clockwise
  static void add_arc(const Vec2<double> from, const Vec2<double> to, double bulge,
                      std::vector<Vec2<double>>& points) {
    const double angle = 4 * std::atan(bulge);
    const Vec2<double> chord = to - from;
    const Vec2<double> across{-chord[1], chord[0]};
    const Vec2<double> centre = (from + to) * 0.5 + across * ((1 - bulge * bulge) / (4 * bulge));
    const Vec2<double> r = from - centre;
    const int steps = static_cast<int>(std::ceil(std::abs(angle) * 36 / std::numbers::pi));
    for (int k = 1; k < steps; ++k) {
      const double a = angle * k / steps;
      points.push_back(centre + Vec2<double>{r[0] * std::cos(a) - r[1] * std::sin(a),
                                             r[0] * std::sin(a) + r[1] * std::cos(a)});
    }
  }

  void add_polyline(DxfPolyline polyline) {
    if (polyline.layer == grain_line && polyline.points.size() > 1)
      piece().grains.push_back({polyline.points.front(), polyline.points.back()});
    if (polyline.layer == mirror_line && polyline.points.size() > 1)
      piece().mirrors.push_back({polyline.points.front(), polyline.points.back()});
    if (polyline.layer == boundary || polyline.layer == sew_lines)
      piece().polylines.push_back(std::move(polyline));
  }

  void add_line(const DxfEntity& e) {
    const int layer = layer_of(e);
    if (layer != mirror_line && layer != grain_line) return;
    need_points(e, 1);
    (layer == mirror_line ? piece().mirrors : piece().grains)
        .push_back({Vec2<double>{e.x[0], e.y[0]}, Vec2<double>{e.x1, e.y1}});
  }

  void add_point(const DxfEntity& e) {
    const int layer = layer_of(e);
    if (layer != turn_points && layer != notches) return;
    need_points(e, 1);
    (layer == turn_points ? piece().turns : piece().notches).push_back({e.x[0], e.y[0]});
  }

  void add_text(const std::string& text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos) return;
    const std::string key = lower_case(trimmed(text.substr(0, colon)));
    const std::string value = trimmed(text.substr(colon + 1));
    if (key == "piece name" && in_block_) piece().name = one_line(value);
    if (key == "units" && lower_case(value) == "metric") text_unit_ = 0.001;
    if (key == "units" && lower_case(value) == "english") text_unit_ = 0.0254;
  }

  std::string_view rest_;
  const std::string& file_;
  std::size_t line_ = 0;
  bool ended_ = false;
  std::string section_, variable_;
  DxfEntity entity_;
  bool in_block_ = false;
  std::optional<DxfPolyline> open_;
  double vertex_bulge_ = 0;  ///< of the vertex before
  std::optional<double> header_unit_, text_unit_;
  std::vector<DxfPiece> pieces_;
  std::optional<std::size_t> loose_;  ///< entities outside all blocks
};

class DxfOutlines final : public OutlineFile {
 public:
  DxfOutlines(std::vector<DxfPiece> pieces, double unit, std::string file)
      : unit_(unit), file_(std::move(file)) {
    for (DxfPiece& piece : pieces) {
      const bool any = std::any_of(piece.polylines.begin(), piece.polylines.end(),
                                   [](const DxfPolyline& p) { return p.layer == boundary; });
      if (any) pieces_.push_back(std::move(piece));
    }
    std::map<std::string, int> uses;
    for (const DxfPiece& piece : pieces_) ++uses[piece.name];
    std::set<std::string> taken;
    for (const DxfPiece& piece : pieces_) {
      // Sizes of one piece have one name, but blocks have their own.
      std::string name = piece.name.empty() || uses[piece.name] > 1 ? piece.block : piece.name;
      while (!taken.insert(name).second) name += "_2";
      names_.push_back(std::move(name));
    }
    if (pieces_.empty())
      throw SceneError(file_, "blocks", "no piece",
                       "blocks with an outline on layer 1, as in ASTM D6673");
  }

  std::vector<std::string> names() const override { return names_; }

  PatternPanel panel(const std::string& name, const std::string& field) const override {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end())
      throw SceneError(file_, field, "no piece of this name", "one of " + list());
    const DxfPiece& piece = pieces_[static_cast<std::size_t>(found - names_.begin())];
    PatternPanel panel;
    panel.name = name;
    take_outline(outline(piece), file_, place(piece), panel);
    for (const auto& grain : piece.grains)
      if (const Vec2<double> along = scaled(piece, grain[1]) - scaled(piece, grain[0]);
          length(along) > same_place)
        panel.grain = along;
    for (const Vec2<double>& notch : piece.notches) panel.notches.push_back(scaled(piece, notch));
    if (!piece.mirrors.empty()) unfold_notches(piece, panel);
    return panel;
  }

 private:
  std::string list() const {
    std::string text;
    for (std::size_t k = 0; k < names_.size() && k < 20; ++k)
      text += (k > 0 ? ", " : "") + one_line(names_[k]);
    return names_.size() > 20 ? text + ", ..." : text;
  }

  static std::string place(const DxfPiece& piece) {
    return "line " + std::to_string(piece.line) + ": block " + piece.block;
  }

  bool is_closed(const DxfPolyline& p) const {
    return p.closed ||
           (p.points.size() > 2 && length(p.points.front() - p.points.back()) * unit_ < same_place);
  }

  void unfold_notches(const DxfPiece& piece, PatternPanel& panel) const {
    const Vec2<double> on = scaled(piece, piece.mirrors[0][0]);
    const Vec2<double> line = scaled(piece, piece.mirrors[0][1]) - on;
    const Vec2<double> along = line * (1 / length(line));
    const std::vector<Vec2<double>> half = panel.notches;
    for (const Vec2<double>& notch : half)
      if (const Vec2<double> image = mirrored(notch, on, along); length(image - notch) > same_place)
        panel.notches.push_back(image);
  }

  /// A closed sew line, or else the boundary: cloth beyond the stitches is not sewn.
  const DxfPolyline& chosen(const DxfPiece& piece) const {
    const DxfPolyline* best = nullptr;
    for (const int layer : {static_cast<int>(sew_lines), static_cast<int>(boundary)})
      for (const DxfPolyline& p : piece.polylines)
        if (best == nullptr && p.layer == layer && is_closed(p)) best = &p;
    if (best == nullptr)
      throw SceneError(file_, place(piece), "an outline that is open",
                       "a polyline on layer 1 that is closed, or ends where it begins");
    return *best;
  }

  /// In metres.
  Vec2<double> scaled(const DxfPiece& piece, const Vec2<double>& p) const {
    for (int k = 0; k < 2; ++k)
      if (!(std::abs(p[k] * unit_) <= largest_outline_coordinate))
        throw SceneError(file_, place(piece), "a coordinate beyond 100 m", "a piece within 100 m");
    return p * unit_;
  }

  OutlinePoints outline(const DxfPiece& piece) const {
    OutlinePoints result;
    for (const Vec2<double>& p : chosen(piece).points) result.points.push_back(scaled(piece, p));
    result.corner.assign(result.points.size(), 0);
    drop_repeated(result);
    if (piece.turns.empty())
      find_corners(result);
    else
      take_turns(piece, result);
    if (!piece.mirrors.empty() &&
        !unfold(result, scaled(piece, piece.mirrors[0][0]), scaled(piece, piece.mirrors[0][1])))
      throw SceneError(file_, place(piece), "a mirror line beside the outline",
                       "a line on layer 6 along a straight side of the outline, from end to end");
    return result;
  }

  void take_turns(const DxfPiece& piece, OutlinePoints& outline) const {
    std::set<std::array<long long, 2>> cells;
    const auto cell = [](double x) { return std::llround(x / same_place); };
    const auto within = [](const Vec2<double>& p) {
      return std::abs(p[0]) <= largest_outline_coordinate &&
             std::abs(p[1]) <= largest_outline_coordinate;
    };
    for (const Vec2<double>& turn : piece.turns)
      if (const Vec2<double> p = turn * unit_; within(p))
        for (int i = -1; i <= 1; ++i)
          for (int j = -1; j <= 1; ++j) cells.insert({cell(p[0]) + i, cell(p[1]) + j});
    for (std::size_t k = 0; k < outline.points.size(); ++k)
      outline.corner[k] = cells.contains({cell(outline.points[k][0]), cell(outline.points[k][1])});
  }

  std::vector<DxfPiece> pieces_;
  std::vector<std::string> names_;  ///< [pieces]
  double unit_;
  std::string file_;
};

}  // namespace

std::unique_ptr<OutlineFile> parse_dxf_outlines(std::string_view bytes, const std::string& file,
                                                std::optional<double> unit) {
  DxfReader reader(bytes, file);
  reader.read();
  const std::optional<double> own = unit ? unit : reader.unit();
  if (!own)
    throw SceneError(file, "units", "missing",
                     "a text \"Units: METRIC\" or \"Units: ENGLISH\", $INSUNITS or $MEASUREMENT in "
                     "the header, or \"outlines_unit\" in the pattern");
  return std::make_unique<DxfOutlines>(std::move(reader).pieces(), *own, file);
}

}  // namespace weft::io
