#include "host/io/scene/file_axes.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "host/io/usd/surface_file.hpp"

namespace weft::io {
namespace {

struct Unit {
  const char* name;
  double metres;
};
constexpr Unit units[] = {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};

}  // namespace

FileAxes read_file_axes(Fields& fields, const FileAxes& usual) {
  std::vector<std::string> names;
  for (const Unit& unit : units) names.emplace_back(unit.name);
  const auto fallback = std::find_if(std::begin(units), std::end(units),
                                     [&](const Unit& unit) { return unit.metres == usual.unit; });
  const std::size_t unit =
      fields.choice("units", names, static_cast<std::size_t>(fallback - std::begin(units)));
  return {units[unit].metres, fields.choice("up", {"z", "y"}, usual.y_up ? 1 : 0) == 1};
}

FileAxes read_axes_of(const std::filesystem::path& file, Fields& fields, const FileAxes& usual) {
  if (!is_usd_file(file)) return read_file_axes(fields, usual);
  for (const char* key : {"units", "up"})
    if (fields.has(key)) fields.refuse(key, "nothing beside a USD file, which says it itself");
  return {};
}

void to_scene_axes(const FileAxes& axes, Mesh& mesh) {
  for (Vec3<double>& x : mesh.positions) {
    if (axes.y_up) x = {x[0], -x[2], x[1]};
    x *= axes.unit;
  }
  for (Vec2<double>& u : mesh.material) u *= axes.unit;
}

}  // namespace weft::io
