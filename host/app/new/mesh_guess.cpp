#include "host/app/new/mesh_guess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace weft::app {
namespace {

std::string box_text(const Aabb& box) {
  const Vec3<double> s = box.size();
  return fmt::format("{:.3g} x {:.3g} x {:.3g}", s[0], s[1], s[2]);
}

}  // namespace

Guess guess_units(const Aabb& cloth, const std::optional<Aabb>& body) {
  constexpr double largest_in_metres = 10;
  constexpr double largest_in_centimetres = 400;
  const Aabb& known = body ? *body : cloth;
  const double size = known.longest_side();
  const char* unit = size <= largest_in_metres ? "m" : size <= largest_in_centimetres ? "cm" : "mm";
  const double metres = unit[0] == 'c' ? 0.01 : unit == std::string("mm") ? 0.001 : 1;
  constexpr double largest_ratio = 40;  // of a body and a handkerchief
  const double other = cloth.longest_side();
  const bool differ = other * largest_ratio < size || size * largest_ratio < other;
  return {unit,
          fmt::format("guessed: the {} is {} units large, and {:.3g} m is a likely size{}",
                      body ? "body" : "cloth", box_text(known), metres * size,
                      differ ? fmt::format("; the cloth is {}, perhaps in another unit, which "
                                           "its \"units\" can say",
                                           box_text(cloth))
                             : "")};
}

Guess guess_up(const Aabb& cloth, const std::optional<Aabb>& body, const std::string& extension) {
  constexpr double clearly = 1.3;
  if (body) {
    const Vec3<double> s = body->size();
    if (s[1] > clearly * std::max(s[0], s[2])) return {"y", "guessed: the body is tallest along y"};
    if (s[2] > clearly * std::max(s[0], s[1])) return {"z", "guessed: the body is tallest along z"};
    const Vec3<double> from_body = cloth.center() - body->center();
    const double y = from_body[1], z = from_body[2];
    if (y > clearly * std::abs(z) && y > 0.05 * body->longest_side())
      return {"y", "guessed: the cloth starts above the body along y"};
    if (z > clearly * std::abs(y) && z > 0.05 * body->longest_side())
      return {"z", "guessed: the cloth starts above the body along z"};
  }
  const Vec3<double> s = cloth.size();
  constexpr double flat = 0.2;
  if (s[1] < flat * std::min(s[0], s[2])) return {"y", "guessed: the cloth lies flat if y is up"};
  if (s[2] < flat * std::min(s[0], s[1])) return {"z", "guessed: the cloth lies flat if z is up"};
  constexpr std::array y_up{".obj", ".fbx", ".gltf", ".glb", ".usd", ".usda"};
  if (std::find(y_up.begin(), y_up.end(), extension) != y_up.end())
    return {"y", fmt::format("guessed: most {} files have y up", extension)};
  return {"z", fmt::format("guessed: most {} files have z up", extension)};
}

}  // namespace weft::app
