#include "host/geometry/outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "host/geometry/add_cell.hpp"
#include "weft/core/assert.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

/// Row of each height of the outline: spaced like the heights, as far as whole rows can be.
std::vector<Index> rows_of(const std::vector<PanelWidth>& outline, Index rows) {
  const auto gaps = static_cast<Index>(outline.size()) - 1;
  const double low = outline.front().height;
  const double high = outline.back().height;
  std::vector<Index> result{0};
  for (Index k = 1; k <= gaps; ++k) {
    const double share = (outline[static_cast<std::size_t>(k)].height - low) / (high - low);
    result.push_back(std::clamp(static_cast<Index>(std::lround(share * rows)), result.back() + 1,
                                rows - (gaps - k)));
  }
  return result;
}

struct ProfileSide {
  Vec2<double> from, to;
};

std::vector<ProfileSide> sides_of(const Revolution& shape) {
  std::vector<ProfileSide> sides;
  for (std::size_t i = 0; i + 1 < shape.profile.size(); ++i)
    sides.push_back({shape.profile[i], shape.profile[i + 1]});
  if (shape.closed) sides.push_back({shape.profile.back(), shape.profile.front()});
  return sides;
}

double pieces_of(const ProfileSide& side, double edge) {
  return std::max(1.0, std::round(length(side.to - side.from) / edge));
}

/// Points of the profile with those between them; of a closed one each once.
std::vector<Vec2<double>> fine_profile(const Revolution& shape, double edge) {
  std::vector<Vec2<double>> points{shape.profile.front()};
  for (const ProfileSide& side : sides_of(shape)) {
    const auto pieces = static_cast<Index>(pieces_of(side, edge));
    for (Index i = 1; i < pieces; ++i)
      points.push_back(side.from + (side.to - side.from) * (static_cast<double>(i) / pieces));
    points.push_back(side.to);
  }
  if (shape.closed) points.pop_back();
  return points;
}

/// Twice the area that a closed profile goes around, positive if it goes counter-clockwise with the
/// radius to the right and z up.
double winding_area(const std::vector<Vec2<double>>& profile) {
  double sum = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Vec2<double>& a = profile[i];
    const Vec2<double>& b = profile[(i + 1) % profile.size()];
    sum += a[0] * b[1] - b[0] * a[1];
  }
  return sum;
}

/// One ring of vertices, or a pole.
struct Ring {
  Index first;
  bool pole;
};

void add_band(const Ring& below, const Ring& above, Index around, bool mirrored,
              std::vector<Tri>& triangles) {
  for (Index i = 0; i < around; ++i) {
    const Index next = (i + 1) % around;
    if (below.pole)
      triangles.push_back({{below.first, above.first + next, above.first + i}});
    else if (above.pole)
      triangles.push_back({{below.first + i, below.first + next, above.first}});
    else
      add_cell(triangles,
               {below.first + i, below.first + next, above.first + next, above.first + i},
               mirrored != (i % 2 != 0));
  }
}

}  // namespace

Mesh make_panel(const std::vector<PanelWidth>& outline, const std::array<Index, 2>& cells) {
  const auto [nx, ny] = cells;
  WEFT_ASSERT(outline.size() >= 2 && nx >= 1);
  WEFT_ASSERT(ny + 1 >= static_cast<Index>(outline.size()));
  const std::vector<Index> rows = rows_of(outline, ny);
  Mesh mesh;
  std::size_t k = 0;
  for (Index j = 0; j <= ny; ++j) {
    if (k + 2 < outline.size() && j > rows[k + 1]) ++k;
    const PanelWidth& a = outline[k];
    const PanelWidth& b = outline[k + 1];
    const double share = static_cast<double>(j - rows[k]) / (rows[k + 1] - rows[k]);
    const auto between = [&](double p, double q) { return p * (1 - share) + q * share; };
    const double left = between(a.left, b.left);
    const double right = between(a.right, b.right);
    for (Index i = 0; i <= nx; ++i) {
      const double across = static_cast<double>(i) / nx;
      const Vec2<double> at{left * (1 - across) + right * across, between(a.height, b.height)};
      mesh.positions.push_back({at[0], at[1], 0});
      mesh.material.push_back(at);
    }
  }
  for (Index j = 0; j < ny; ++j)
    for (Index i = 0; i < nx; ++i)
      add_cell(mesh.triangles,
               {grid_vertex(nx, i, j), grid_vertex(nx, i + 1, j), grid_vertex(nx, i + 1, j + 1),
                grid_vertex(nx, i, j + 1)},
               (i + j) % 2 != 0);
  return mesh;
}

double panel_area(const std::vector<PanelWidth>& outline) {
  double area = 0;
  for (std::size_t k = 0; k + 1 < outline.size(); ++k)
    area += (outline[k + 1].height - outline[k].height) *
            (outline[k].right - outline[k].left + outline[k + 1].right - outline[k + 1].left) / 2;
  return area;
}

bool can_revolve(const Revolution& shape) {
  if (shape.profile.size() < (shape.closed ? 3u : 2u)) return false;
  for (std::size_t i = 0; i < shape.profile.size(); ++i) {
    const bool end = i == 0 || i + 1 == shape.profile.size();
    if (shape.profile[i][0] == 0 && (shape.closed || !end)) return false;
  }
  for (const ProfileSide& side : sides_of(shape)) {
    if (!(length(side.to - side.from) > 0)) return false;
    if (side.from[0] == 0 && side.to[0] == 0) return false;
  }
  return true;
}

double revolution_triangles(const Revolution& shape, Index around, double edge) {
  double sum = 0;
  for (const ProfileSide& side : sides_of(shape)) sum += 2.0 * around * pieces_of(side, edge);
  return sum;
}

Mesh make_revolution(const Revolution& shape, Index around, double edge) {
  WEFT_ASSERT(can_revolve(shape) && around >= 3 && edge > 0);
  std::vector<Vec2<double>> profile = fine_profile(shape, edge);
  // Counter-clockwise in this half plane has the front outwards, as upwards has.
  if (shape.closed && winding_area(profile) < 0) std::reverse(profile.begin(), profile.end());
  Mesh mesh;
  std::vector<Ring> rings;
  for (const Vec2<double>& p : profile) {
    rings.push_back({static_cast<Index>(mesh.positions.size()), p[0] == 0});
    if (rings.back().pole) {
      mesh.positions.push_back({0, 0, p[1]});
      continue;
    }
    for (Index i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      mesh.positions.push_back({p[0] * std::cos(angle), p[0] * std::sin(angle), p[1]});
    }
  }
  for (std::size_t j = 0; j + 1 < rings.size(); ++j)
    add_band(rings[j], rings[j + 1], around, j % 2 != 0, mesh.triangles);
  if (shape.closed)
    add_band(rings.back(), rings.front(), around, rings.size() % 2 == 0, mesh.triangles);
  return mesh;
}

}  // namespace weft
