#include "host/simulation/compression.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "host/model/material_rows.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Halvings of the way from the share before to the share wanted.
constexpr int halvings = 20;

double share_at(const std::vector<double>& shares, std::size_t triangle) {
  return shares.empty() ? 1 : shares[triangle];
}

using Corners = std::array<Index, 3>;

Corners sorted(const Index v[3]) {
  Corners corners{v[0], v[1], v[2]};
  std::sort(corners.begin(), corners.end());
  return corners;
}

/// Gives vertices that have none the least value of their neighbours', from what is known outwards.
void spread(const std::vector<Tri>& triangles, std::vector<double>& values, double none) {
  for (bool more = true; more;) {
    more = false;
    const std::vector<double> known = values;
    for (const Tri& t : triangles) {
      double least = none;
      for (const Index v : t.v) least = std::min(least, known[at(v)]);
      if (least == none) continue;
      for (const Index v : t.v)
        if (known[at(v)] == none && least < values[at(v)]) {
          values[at(v)] = least;
          more = true;
        }
    }
  }
}

}  // namespace

std::vector<double> carried_compression(const Model& from, const std::vector<double>& shares,
                                        const std::vector<Index>& input_before, const Model& to) {
  if (shares.empty()) return {};
  constexpr double none = 2;
  std::vector<std::pair<Corners, double>> known;
  std::vector<double> around(from.to_internal.size(), none);
  for (std::size_t t = 0; t < from.input_triangle.size(); ++t) {
    const double share = shares[at(from.input_triangle[t])];
    const Tri& corners = from.input_corners[t];
    known.emplace_back(sorted(corners.v), share);
    for (const Index v : corners.v) around[at(v)] = std::min(around[at(v)], share);
  }
  std::sort(known.begin(), known.end());
  std::vector<double> now;
  for (const Index old : input_before) now.push_back(old < 0 ? none : around[at(old)]);
  spread(to.input_corners, now, none);
  std::vector<double> result(to.input_triangle.size());
  for (std::size_t t = 0; t < result.size(); ++t) {
    const Index* v = to.input_corners[t].v;
    const Index old[3] = {input_before[at(v[0])], input_before[at(v[1])], input_before[at(v[2])]};
    const std::pair<Corners, double> wanted{sorted(old), 0};
    const auto found = std::lower_bound(known.begin(), known.end(), wanted);
    const double least = std::min({1.0, now[at(v[0])], now[at(v[1])], now[at(v[2])]});
    const bool stays = found != known.end() && found->first == wanted.first;
    result[at(to.input_triangle[t])] = stays ? found->second : least;
  }
  return result;
}

std::vector<double> limited_compression(const Model& model,
                                        const std::vector<Vec3<double>>& positions,
                                        const std::vector<double>& before,
                                        const std::vector<double>& wanted, double joules) {
  if (before == wanted) return wanted;
  const auto energy = [&](std::size_t t, double share) {
    const Index* v = model.triangles[t].v;
    const Vec3<double> x[3] = {positions[at(v[0])], positions[at(v[1])], positions[at(v[2])]};
    return stretching_energy(model.laws->rows, model.material[t], x, model.inv_rest[t],
                             model.area[t], share);
  };
  const std::size_t count = model.input_triangle.size();
  std::vector<double> result(count), gain(count);
  double area = 0;
  for (std::size_t t = 0; t < count; ++t) {
    const std::size_t input = at(model.input_triangle[t]);
    const double from = share_at(before, input), to = share_at(wanted, input);
    result[input] = to;
    gain[t] = from == to ? 0 : energy(t, to) - energy(t, from);
    if (gain[t] > 0) area += model.area[t];
  }
  for (std::size_t t = 0; t < count; ++t) {
    const double allowed = joules * model.area[t] / area;
    if (!(gain[t] > allowed)) continue;
    const std::size_t input = at(model.input_triangle[t]);
    double low = share_at(before, input), high = result[input];
    const double start = energy(t, low);
    for (int k = 0; k < halvings; ++k) {
      const double middle = low + (high - low) / 2;
      (energy(t, middle) - start > allowed ? high : low) = middle;
    }
    result[input] = low;
  }
  if (std::all_of(result.begin(), result.end(), [](double share) { return share == 1; })) return {};
  return result;
}

}  // namespace weft
