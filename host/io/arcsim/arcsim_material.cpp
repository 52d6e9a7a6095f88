#include "host/io/arcsim/arcsim_material.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "host/base/file_bytes.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/scene/fabric/rigidity.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

template <std::size_t Rows, std::size_t Columns>
using Table = std::array<std::array<double, Columns>, Rows>;

template <std::size_t Rows, std::size_t Columns>
Table<Rows, Columns> read_table(const nlohmann::json& root, const std::string& key,
                                const std::string& file) {
  const std::string allowed =
      std::to_string(Rows) + " rows of " + std::to_string(Columns) + " finite numbers";
  const auto found = root.find(key);
  if (found == root.end()) throw SceneError(file, key, "missing", allowed);
  const auto refuse = [&] { throw SceneError(file, key, short_text(*found), allowed); };
  if (!found->is_array() || found->size() != Rows) refuse();
  Table<Rows, Columns> table{};
  for (std::size_t i = 0; i < Rows; ++i) {
    const nlohmann::json& row = (*found)[i];
    if (!row.is_array() || row.size() != Columns) refuse();
    for (std::size_t j = 0; j < Columns; ++j) {
      if (!row[j].is_number() || !std::isfinite(row[j].get<double>())) refuse();
      table[i][j] = row[j].get<double>();
    }
  }
  return table;
}

}  // namespace

Material read_arcsim_material(const std::filesystem::path& path, const ArcsimFactors& factors,
                              bool& averaged) {
  const std::string file = path.string();
  const nlohmann::json root = parse_json(read_file_bytes(path), file);
  nlohmann::json scratch;
  Fields fields(root, scratch, file, "", {});
  const auto stretching = read_table<6, 4>(root, "stretching", file);
  const auto bending = read_table<3, 5>(root, "bending", file);

  Material material;
  material.name = path.stem().string();
  material.density = fields.positive("density") * factors.density * factors.thicken;
  const double along = (stretching[0][0] + stretching[0][2]) / 2;
  if (!(along > 0))
    throw SceneError(file, "stretching", "a mean of " + short_text(along) + " along the threads",
                     "a mean of c11 and c22 in the first row > 0");
  material.poisson_ratio = std::clamp(stretching[0][1] / along, -0.9, 0.49);
  material.stretch_stiffness = 2 * along * (1 - material.poisson_ratio * material.poisson_ratio) *
                               factors.stretching * factors.thicken;
  const double mean = (bending[0][0] + bending[1][0] + bending[2][0]) / 3;
  if (!(mean >= 0))
    throw SceneError(file, "bending", "a mean of " + short_text(mean) + " in the first column",
                     "a mean >= 0");
  const double bending_scale = factors.bending * factors.thicken / 4;
  material.bending_stiffness = mean * bending_scale;
  if (bending[0][0] != bending[1][0] || bending[0][0] != bending[2][0]) {
    const auto row = [&](std::size_t i) { return std::max(bending[i][0], 0.0) * bending_scale; };
    material.orthotropic_bending = directional_bending(row(2), row(0), row(1));
  }
  material.damping_stiffness = factors.damping;

  // An isotropic sheet has c11 = c22, c33 = c11 - c12, and rows that are all the same.
  const auto& first = stretching[0];
  bool measured = first[0] != first[2] || first[3] != first[0] - first[1];
  for (const auto& row : stretching) measured = measured || row != first;
  if (measured) {
    material.measured = MeasuredStretch{MeasuredStretch::Form::arcsim, stretching};
    for (auto& row : material.measured->rows)
      for (double& c : row) c *= factors.stretching * factors.thicken;
    material.poisson_ratio = 0;  // now of bending alone, whose table has no coupling
  }
  averaged = false;
  for (const auto& row : bending)
    for (const double b : row) averaged = averaged || b != row[0];
  return material;
}

}  // namespace weft::io
