#include "host/io/pattern/body_guard.hpp"

#include <algorithm>
#include <utility>

#include "host/geometry/aabb.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "weft/core/at.hpp"

namespace weft::io {

BodyGuard::BodyGuard(const Mesh& body, std::vector<Tri> cloth, const std::vector<Vec3<double>>& x,
                     double clearance)
    : cloth_(std::move(cloth)), triangles_of_(x.size()), clearance_(clearance) {
  if (body.triangles.empty()) return;
  body_.emplace(body);
  for (std::size_t t = 0; t < cloth_.size(); ++t) {
    for (const Index v : cloth_[t].v) triangles_of_[at(v)].push_back(static_cast<Index>(t));
    free_.push_back(meets_body(cloth_[t], x) ? 0 : 1);
  }
}

bool BodyGuard::meets_body(const Tri& t, const std::vector<Vec3<double>>& x) const {
  bool meets = false;
  const Corners corners{x[at(t.v[0])], x[at(t.v[1])], x[at(t.v[2])]};
  // Cloth and body share no vertex.
  body_->visit_meeting(corners, [&](Index) { meets = true; });
  return meets;
}

/// May be true for triangles that are a little farther away than the clearance.
bool BodyGuard::comes_close(const Tri& t, const std::vector<Vec3<double>>& x) const {
  if (!(clearance_ > 0)) return meets_body(t, x);
  bool close = false;
  const Corners corners{x[at(t.v[0])], x[at(t.v[1])], x[at(t.v[2])]};
  Aabb box;
  for (const Vec3<double>& corner : corners)
    for (const double side : {-clearance_, clearance_})
      box.include(corner + Vec3<double>{side, side, side});
  auto visit = [&](Index other) {
    close = close || !plainly_apart(corners, body_->corners(other), clearance_);
  };
  body_->visit_boxes(box, visit);
  return close;
}

std::vector<unsigned char> BodyGuard::vertices_within() const {
  std::vector<unsigned char> within(triangles_of_.size(), 0);
  for (std::size_t t = 0; t < free_.size(); ++t)
    if (free_[t] == 0)
      for (const Index v : cloth_[t].v) within[at(v)] = 1;
  return within;
}

void BodyGuard::guard(const std::vector<Vec3<double>>& before, std::vector<Vec3<double>>& now) {
  if (!body_) return;
  const auto moves = [&](Index v) { return !(now[at(v)] == before[at(v)]); };
  std::vector<Index> waiting;
  for (std::size_t t = 0; t < cloth_.size(); ++t) waiting.push_back(static_cast<Index>(t));
  // A vertex is taken back once at most, so that this ends.
  while (!waiting.empty()) {
    std::vector<Index> next;
    for (const Index t : waiting) {
      const Tri& triangle = cloth_[at(t)];
      if (free_[at(t)] == 0 || std::none_of(triangle.v, triangle.v + 3, moves)) continue;
      if (!comes_close(triangle, now)) continue;
      for (const Index v : triangle.v) {
        if (!moves(v)) continue;
        now[at(v)] = before[at(v)];
        next.insert(next.end(), triangles_of_[at(v)].begin(), triangles_of_[at(v)].end());
      }
    }
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    waiting = std::move(next);
  }
  for (std::size_t t = 0; t < cloth_.size(); ++t)
    if (free_[t] == 0 && !meets_body(cloth_[t], now)) free_[t] = 1;
}

}  // namespace weft::io
