#include "host/io/pattern/svg_path.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <system_error>
#include <utility>

#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/pattern/outline_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Takes commands, numbers and flags off a text.
class SvgScanner {
 public:
  SvgScanner(std::string_view text, std::string where, std::string field)
      : text_(text), where_(std::move(where)), field_(std::move(field)) {}

  [[noreturn]] void refuse(const std::string& allowed) const {
    throw SceneError(
        where_, field_ + " at character " + std::to_string(at_),
        at_ >= text_.size() ? "the end" : "\"" + one_line(text_.substr(at_, 20)) + "\"", allowed);
  }

  void skip(bool commas = true) {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' ||
                                  text_[at_] == '\r' || (commas && text_[at_] == ',')))
      ++at_;
  }
  bool at_end() {
    skip();
    return at_ >= text_.size();
  }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  char take() { return text_[at_++]; }

  bool at_number() {
    skip();
    const char c = peek();
    return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.';
  }

  double number() {
    if (!at_number()) refuse("a number");
    const std::size_t begin = at_ + (peek() == '+' ? 1 : 0);
    double value = 0;
    const auto [stop, error] =
        std::from_chars(text_.data() + begin, text_.data() + text_.size(), value);
    // from_chars reads "-inf" and "-nan", too
    if (error != std::errc() || !std::isfinite(value)) refuse("a finite number");
    at_ = static_cast<std::size_t>(stop - text_.data());
    return value;
  }

  /// Flags of arcs may stand without anything between them.
  bool flag() {
    skip();
    if (peek() != '0' && peek() != '1') refuse("0 or 1");
    return take() == '1';
  }

  std::string word() {
    skip();
    const std::size_t begin = at_;
    while ((peek() >= 'a' && peek() <= 'z') || (peek() >= 'A' && peek() <= 'Z')) ++at_;
    return std::string(text_.substr(begin, at_ - begin));
  }

 private:
  std::string_view text_;
  std::string where_, field_;
  std::size_t at_ = 0;
};

double degrees(double angle) {
  return angle * std::numbers::pi / 180;
}

/// An elliptical arc as points, without its ends: SVG 1.1, F.6.
std::vector<Vec2<double>> arc_points(const Vec2<double>& from, const Vec2<double>& to, double rx,
                                     double ry, double angle, bool large, bool sweep) {
  rx = std::abs(rx), ry = std::abs(ry);
  if (rx == 0 || ry == 0) return {};
  const double c = std::cos(degrees(angle)), s = std::sin(degrees(angle));
  const Vec2<double> half = (from - to) * 0.5;
  const double x = c * half[0] + s * half[1], y = c * half[1] - s * half[0];
  const double stretch = x * x / (rx * rx) + y * y / (ry * ry);
  if (stretch > 1) rx *= std::sqrt(stretch), ry *= std::sqrt(stretch);
  const double a = rx * rx * y * y + ry * ry * x * x;
  const double root = a > 0 ? std::sqrt(std::max(0.0, rx * rx * ry * ry / a - 1)) : 0;
  const double side = large != sweep ? root : -root;
  const double cx = side * rx * y / ry, cy = -side * ry * x / rx;
  const double begin = std::atan2((y - cy) / ry, (x - cx) / rx);
  double turn = std::atan2((-y - cy) / ry, (-x - cx) / rx) - begin;
  if (sweep && turn < 0) turn += 2 * std::numbers::pi;
  if (!sweep && turn > 0) turn -= 2 * std::numbers::pi;
  std::vector<Vec2<double>> points;
  if (!std::isfinite(turn)) return points;
  const Vec2<double> centre = (from + to) * 0.5 + Vec2<double>{c * cx - s * cy, s * cx + c * cy};
  const int steps = static_cast<int>(std::ceil(std::abs(turn) * 36 / std::numbers::pi));
  for (int k = 1; k < steps; ++k) {
    const double t = begin + turn * k / steps;
    const double u = rx * std::cos(t), v = ry * std::sin(t);
    points.push_back(centre + Vec2<double>{c * u - s * v, s * u + c * v});
  }
  return points;
}

class SvgPathReader {
 public:
  SvgPathReader(std::string_view d, const std::string& where) : scanner_(d, where, "d") {}

  std::vector<SvgSubpath> read() {
    char command = '\0';
    while (!scanner_.at_end()) {
      if (!scanner_.at_number()) {
        command = scanner_.peek();
        if (std::string_view("MmLlHhVvCcSsQqTtAaZz").find(command) == std::string_view::npos)
          scanner_.refuse("one of M, L, H, V, C, S, Q, T, A and Z");
        if (subpaths_.empty() && command != 'M' && command != 'm')
          scanner_.refuse("M at the start");
        scanner_.take();
      } else if (command == '\0' || command == 'Z' || command == 'z') {
        scanner_.refuse("a command");
      }
      run(command);
      // Further pairs after M are lines.
      if (command == 'M') command = 'L';
      if (command == 'm') command = 'l';
    }
    for (SvgSubpath& path : subpaths_)
      if (!path.closed && path.segments.size() > 1)
        path.closed = path.segments.front().from == path.segments.back().to;
    std::erase_if(subpaths_, [](const SvgSubpath& path) { return path.segments.empty(); });
    return std::move(subpaths_);
  }

 private:
  void run(char command) {
    const bool relative = command >= 'a';
    const char kind = relative ? static_cast<char>(command - 'a' + 'A') : command;
    const Vec2<double> base = relative ? now_ : Vec2<double>{0, 0};
    const auto point = [&] {
      const double x = scanner_.number();
      return base + Vec2<double>{x, scanner_.number()};
    };
    std::optional<Vec2<double>> smooth;  // the control point that the next S or T mirrors
    switch (kind) {
      case 'M':
        now_ = start_ = point();
        subpaths_.emplace_back();
        break;
      case 'L':
        add(PatternEdge::Shape::line, {}, point());
        break;
      case 'H':
        add(PatternEdge::Shape::line, {}, {base[0] + scanner_.number(), now_[1]});
        break;
      case 'V':
        add(PatternEdge::Shape::line, {}, {now_[0], base[1] + scanner_.number()});
        break;
      case 'C':
      case 'S': {
        const bool reflects = last_ == 'C' && smooth_;
        const Vec2<double> a = kind == 'C' ? point() : reflects ? now_ * 2.0 - *smooth_ : now_;
        smooth = point();
        add(PatternEdge::Shape::bezier, {a, *smooth}, point());
        break;
      }
      case 'Q':
      case 'T': {
        const bool reflects = last_ == 'Q' && smooth_;
        smooth = kind == 'Q' ? point() : reflects ? now_ * 2.0 - *smooth_ : now_;
        add(PatternEdge::Shape::bezier, {*smooth}, point());
        break;
      }
      case 'A': {
        const double rx = scanner_.number(), ry = scanner_.number(), angle = scanner_.number();
        const bool large = scanner_.flag(), sweep = scanner_.flag();
        const Vec2<double> to = point();
        std::vector<Vec2<double>> points = arc_points(now_, to, rx, ry, angle, large, sweep);
        const auto shape = points.empty() ? PatternEdge::Shape::line : PatternEdge::Shape::polyline;
        add(shape, std::move(points), to);
        break;
      }
      default:  // Z
        if (now_ != start_) add(PatternEdge::Shape::line, {}, start_);
        subpaths_.back().closed = true;
        now_ = start_;
        break;
    }
    smooth_ = smooth;
    last_ = kind == 'S' ? 'C' : kind == 'T' ? 'Q' : kind;
  }

  void add(PatternEdge::Shape shape, std::vector<Vec2<double>> controls, const Vec2<double>& to) {
    // After Z the next command begins a subpath where the last one began.
    if (subpaths_.back().closed) subpaths_.emplace_back();
    if (++segments_ > most_outline_points)
      scanner_.refuse("up to " + std::to_string(most_outline_points) + " segments");
    subpaths_.back().segments.push_back({shape, now_, to, std::move(controls)});
    now_ = to;
  }

  SvgScanner scanner_;
  std::vector<SvgSubpath> subpaths_;
  std::size_t segments_ = 0;
  Vec2<double> now_{0, 0}, start_{0, 0};
  std::optional<Vec2<double>> smooth_;
  char last_ = '\0';
};

}  // namespace

SvgTransform SvgTransform::after(const SvgTransform& other) const {
  SvgTransform all;
  for (std::size_t column = 0; column < 3; ++column) {
    const double x = other.m[2 * column], y = other.m[2 * column + 1];
    const double shift = column == 2 ? 1 : 0;
    all.m[2 * column] = m[0] * x + m[2] * y + m[4] * shift;
    all.m[2 * column + 1] = m[1] * x + m[3] * y + m[5] * shift;
  }
  return all;
}

SvgTransform parse_svg_transform(std::string_view text, const std::string& where) {
  SvgScanner scanner(text, where, "transform");
  SvgTransform all;
  while (!scanner.at_end()) {
    const std::string kind = scanner.word();
    scanner.skip();
    if (kind.empty() || scanner.peek() != '(')
      scanner.refuse("matrix, translate, scale, rotate, skewX or skewY, with values in brackets");
    scanner.take();
    std::vector<double> v;
    while (scanner.at_number() && v.size() < 6) v.push_back(scanner.number());
    scanner.skip();
    if (scanner.peek() != ')') scanner.refuse("\")\" after up to 6 numbers");
    scanner.take();
    SvgTransform one;
    const std::size_t n = v.size();
    if (kind == "matrix" && n == 6) {
      std::copy(v.begin(), v.end(), one.m.begin());
    } else if (kind == "translate" && (n == 1 || n == 2)) {
      one.m = {1, 0, 0, 1, v[0], n == 2 ? v[1] : 0};
    } else if (kind == "scale" && (n == 1 || n == 2)) {
      one.m = {v[0], 0, 0, v[n - 1], 0, 0};
    } else if (kind == "rotate" && (n == 1 || n == 3)) {
      const double c = std::cos(degrees(v[0])), s = std::sin(degrees(v[0]));
      const Vec2<double> p = n == 3 ? Vec2<double>{v[1], v[2]} : Vec2<double>{0, 0};
      one.m = {c, s, -s, c, p[0] - c * p[0] + s * p[1], p[1] - s * p[0] - c * p[1]};
    } else if (kind == "skewX" && n == 1) {
      one.m = {1, 0, std::tan(degrees(v[0])), 1, 0, 0};
    } else if (kind == "skewY" && n == 1) {
      one.m = {1, std::tan(degrees(v[0])), 0, 1, 0, 0};
    } else {
      throw SceneError(
          where, "transform", one_line(kind) + " with " + counted(n, "number"),
          "matrix with 6, translate or scale with 1 or 2, rotate with 1 or 3, skewX or "
          "skewY with 1");
    }
    all = all.after(one);
  }
  return all;
}

std::vector<SvgSubpath> parse_svg_path(std::string_view d, const std::string& where) {
  return SvgPathReader(d, where).read();
}

std::vector<double> parse_svg_numbers(std::string_view text, const std::string& where,
                                      const std::string& field) {
  SvgScanner scanner(text, where, field);
  std::vector<double> numbers;
  while (!scanner.at_end()) {
    numbers.push_back(scanner.number());
    if (numbers.size() > 2 * most_outline_points)
      scanner.refuse("up to " + std::to_string(2 * most_outline_points) + " numbers");
  }
  return numbers;
}

}  // namespace weft::io
