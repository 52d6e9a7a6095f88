#include "host/view/occlusion.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace weft {
namespace {

constexpr int most_columns = 512;
/// Share of its depth by which a point must lie behind what hides it.
constexpr double tolerance = 0.005;
/// Points of a triangle are looked at every so many cells, up to a number along an edge.
constexpr double spacing = 4;
constexpr int most_points = 16;

struct Seen {
  Vec3<double> x[3];
};

Seen seen_by(const ViewCamera& camera, const Tri& t, const std::vector<Vec3<double>>& positions) {
  Seen s;
  for (int j = 0; j < 3; ++j) s.x[j] = camera.seen(positions[at(t.v[j])]);
  return s;
}

}  // namespace

DepthPicture::DepthPicture(const ViewCamera& camera)
    : camera_(camera), columns_(std::min(camera.width(), most_columns)) {
  cells_ = static_cast<double>(columns_) / camera.width();
  rows_ = std::max(1, static_cast<int>(std::ceil(cells_ * camera.height())));
  depth_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);
}

DepthPicture::Corner DepthPicture::corner(const Vec3<double>& seen) const {
  const Vec2<double> p = camera_.pixel(seen);
  return {cells_ * p[0], cells_ * p[1], 1 / seen[2]};
}

void DepthPicture::draw(const Vec3<double> seen[3]) {
  std::vector<Corner> polygon;
  for (int j = 0; j < 3; ++j) {
    const Vec3<double>&p = seen[j], &q = seen[(j + 1) % 3];
    const double a = p[2] - camera_.near(), b = q[2] - camera_.near();
    if (a >= 0) polygon.push_back(corner(p));
    if ((a > 0 && b < 0) || (a < 0 && b > 0))
      polygon.push_back(corner(p + (a / (a - b)) * (q - p)));
  }
  for (std::size_t k = 2; k < polygon.size(); ++k) fill(polygon[0], polygon[k - 1], polygon[k]);
}

/// Cells whose centres lie within.
void DepthPicture::fill(const Corner& a, const Corner& b, const Corner& c) {
  const double det = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (det == 0 || !std::isfinite(det)) return;
  const auto first = [](double low, double high, int count) {
    return static_cast<int>(std::clamp(std::ceil(std::min(low, high) - 0.5), 0.0, 1.0 * count));
  };
  const int row0 = first(std::min(a.y, b.y), c.y, rows_);
  const int column0 = first(std::min(a.x, b.x), c.x, columns_);
  const double bottom = std::max({a.y, b.y, c.y}), right = std::max({a.x, b.x, c.x});
  for (int row = row0; row < rows_ && row + 0.5 <= bottom; ++row)
    for (int column = column0; column < columns_ && column + 0.5 <= right; ++column) {
      const double x = column + 0.5 - a.x, y = row + 0.5 - a.y;
      const double wb = (x * (c.y - a.y) - y * (c.x - a.x)) / det;
      const double wc = (y * (b.x - a.x) - x * (b.y - a.y)) / det;
      if (wb < 0 || wc < 0 || wb + wc > 1) continue;
      double& cell = depth_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                            static_cast<std::size_t>(column)];
      cell = std::max(cell, a.near + wb * (b.near - a.near) + wc * (c.near - a.near));
    }
}

bool DepthPicture::hides(const Vec3<double>& seen) const {
  if (!(seen[2] > camera_.near())) return false;
  const Corner p = corner(seen);
  if (!(p.x >= 0 && p.x < columns_ && p.y >= 0 && p.y < rows_)) return false;
  const int column = static_cast<int>(p.x), row = static_cast<int>(p.y);
  double farthest = 1 / camera_.near();
  for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r)
    for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c)
      farthest = std::min(farthest,
                          depth_[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) +
                                 static_cast<std::size_t>(c)]);
  return p.near < (1 - tolerance) * farthest;
}

std::vector<unsigned char> hidden_triangles(const ViewCamera& camera, const ViewSurface& surface,
                                            const ViewPlaces& places) {
  DepthPicture picture(camera);
  for (const Tri& t : surface.obstacles) picture.draw(seen_by(camera, t, places.obstacles).x);
  for (const Tri& t : surface.triangles) picture.draw(seen_by(camera, t, places.cloth).x);
  const double cells = static_cast<double>(std::min(camera.width(), most_columns)) / camera.width();
  std::vector<unsigned char> hidden(surface.triangles.size(), 0);
  for (std::size_t t = 0; t < hidden.size(); ++t) {
    const Seen s = seen_by(camera, surface.triangles[t], places.cloth);
    if (!(std::min({s.x[0][2], s.x[1][2], s.x[2][2]}) > camera.near())) continue;
    double longest = 0;
    for (int j = 0; j < 3; ++j)
      longest = std::max(longest, length(camera.pixel(s.x[j]) - camera.pixel(s.x[(j + 1) % 3])));
    const int n = static_cast<int>(
        std::clamp(std::ceil(cells * longest / spacing), 2.0, static_cast<double>(most_points)));
    bool all = true;
    for (int i = 0; all && i <= n; ++i)
      for (int j = 0; all && i + j <= n; ++j)
        all = picture.hides((static_cast<double>(n - i - j) / n) * s.x[0] +
                            (static_cast<double>(i) / n) * s.x[1] +
                            (static_cast<double>(j) / n) * s.x[2]);
    hidden[t] = all ? 1 : 0;
  }
  return hidden;
}

}  // namespace weft
