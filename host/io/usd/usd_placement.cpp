#include "host/io/usd/usd_placement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "host/io/mesh/mesh_formats.hpp"

namespace weft::io {
namespace {

constexpr double most = 1e12;                 // of any number, in units of the file
constexpr std::size_t most_operations = 256;  // of a prim
constexpr std::string_view prefix = "xformOp:";
constexpr std::string_view inverse = "!invert!";

/// The numbers of a value, whatever its brackets.
/// @return whether there are exactly `count` of them, each of a size that can be used
bool parse_numbers(std::string_view text, std::size_t count, double* numbers) {
  constexpr std::string_view between = "()[], \t\r\n";
  std::size_t found = 0;
  for (std::size_t at = text.find_first_not_of(between); at != std::string_view::npos;
       at = text.find_first_not_of(between, at)) {
    const std::size_t end = std::min(text.find_first_of(between, at), text.size());
    if (found == count || !parse_number(text.substr(at, end - at), numbers[found]) ||
        !(std::abs(numbers[found]) <= most))
      return false;
    ++found;
    at = end;
  }
  return found == count;
}

/// @param axis 0, 1, 2: x, y, z
UsdPlacement rotation(int axis, double degrees) {
  const double angle = degrees * (std::numbers::pi / 180);
  const int j = (axis + 1) % 3;
  const int k = (axis + 2) % 3;
  UsdPlacement result;
  result.linear[j][j] = result.linear[k][k] = std::cos(angle);
  result.linear[k][j] = std::sin(angle);
  result.linear[j][k] = -std::sin(angle);
  return result;
}

/// @param q w, x, y, z of any length but zero
bool set_rotation(const double* q, UsdPlacement& result) {
  const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(square > 0)) return false;
  const double s = 2 / square;
  const double w = q[0];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    const double a = q[1 + i], b = q[1 + j], c = q[1 + k];
    result.linear[i][i] = 1 - s * (b * b + c * c);
    result.linear[i][j] = s * (a * b - w * c);
    result.linear[i][k] = s * (a * c + w * b);
  }
  return true;
}

/// @param kind "translate", "rotateXYZ" and so on
bool parse_operation(std::string_view kind, std::string_view text, UsdPlacement& result) {
  double n[16] = {};
  if (kind == "translate") {
    if (!parse_numbers(text, 3, n)) return false;
    result.translate = {n[0], n[1], n[2]};
    return true;
  }
  if (kind == "scale") {
    if (!parse_numbers(text, 3, n)) return false;
    for (int k = 0; k < 3; ++k) result.linear[k][k] = n[k];
    return true;
  }
  if (kind == "orient") return parse_numbers(text, 4, n) && set_rotation(n, result);
  if (kind == "transform") {
    if (!parse_numbers(text, 16, n)) return false;
    // Points are rows there.
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) result.linear[i][j] = n[4 * j + i];
    result.translate = {n[12], n[13], n[14]};
    return n[3] == 0 && n[7] == 0 && n[11] == 0 && n[15] == 1;
  }
  constexpr std::string_view rotate = "rotate";
  if (!kind.starts_with(rotate)) return false;
  const std::string_view axes = kind.substr(rotate.size());
  if ((axes.size() != 1 && axes.size() != 3) || !parse_numbers(text, axes.size(), n)) return false;
  // The first letter turns first. The angles stand in the order x, y, z whatever the letters.
  for (const char letter : axes) {
    if (letter < 'X' || letter > 'Z') return false;
    const int axis = letter - 'X';
    result = composed(rotation(axis, axes.size() == 1 ? n[0] : n[axis]), result);
  }
  return true;
}

}  // namespace

Vec3<double> UsdPlacement::turned(const Vec3<double>& x) const {
  Vec3<double> y{};
  for (int i = 0; i < 3; ++i)
    y[i] = linear[i][0] * x[0] + linear[i][1] * x[1] + linear[i][2] * x[2];
  return y;
}

bool UsdPlacement::only_translates() const {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (linear[i][j] != (i == j ? 1 : 0)) return false;
  return true;
}

bool UsdPlacement::mirrors() const {
  const auto column = [&](int j) { return Vec3<double>{linear[0][j], linear[1][j], linear[2][j]}; };
  return dot(cross(column(0), column(1)), column(2)) < 0;
}

UsdPlacement composed(const UsdPlacement& outer, const UsdPlacement& inner) {
  UsdPlacement result;
  result.translate = outer.only_translates() ? inner.translate : outer.turned(inner.translate);
  result.translate += outer.translate;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += outer.linear[i][k] * inner.linear[k][j];
      result.linear[i][j] = sum;
    }
  return result;
}

bool UsdTransform::set(std::string_view name, std::string_view text) {
  if (!name.starts_with(prefix) || operations_.size() >= most_operations) return false;
  const std::string_view kind = name.substr(prefix.size());
  UsdPlacement placement;
  // "translate:pivot" is another translation.
  if (!parse_operation(kind.substr(0, std::min(kind.find(':'), kind.size())), text, placement))
    return false;
  operations_[std::string(name)] = placement;
  return true;
}

bool UsdTransform::set_order(std::string_view text) {
  order_.clear();
  std::string_view rest = text;
  for (std::size_t quote = rest.find('"'); quote != std::string_view::npos;
       quote = rest.find('"')) {
    const std::size_t end = rest.find('"', quote + 1);
    if (end == std::string_view::npos || order_.size() >= most_operations) return false;
    order_.emplace_back(rest.substr(quote + 1, end - quote - 1));
    rest.remove_prefix(end + 1);
  }
  return true;
}

bool UsdTransform::placement(UsdPlacement& placement) const {
  placement = {};
  for (const std::string& entry : order_) {
    const bool inverted = entry.starts_with(inverse);
    const auto found =
        operations_.find(std::string_view(entry).substr(inverted ? inverse.size() : 0));
    if (found == operations_.end()) return false;
    UsdPlacement operation = found->second;
    if (inverted) {  // pivots; nothing else is inverted in practice
      if (!operation.only_translates()) return false;
      operation.translate *= -1.0;
    }
    placement = composed(placement, operation);
  }
  return std::all_of(placement.translate.e, placement.translate.e + 3,
                     [](double x) { return std::abs(x) <= most; });
}

}  // namespace weft::io
