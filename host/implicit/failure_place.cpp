// Where attempts fail, at the start of the attempt: the state that a failed step leaves.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/step.hpp"

namespace weft {

/// The point of the first primitive that meets the second one.
template <class T>
std::optional<Vec3<double>> ImplicitStep<T>::place_of(const Collision& collision) {
  Queue& master = store_.devices()[0].compute();
  Vec3<T> corners[2];
  for (Index j = 0; j < collision.first; ++j)
    master.copy(&corners[j], store_.rank(0).positions.data() + collision.v[j], sizeof corners[j]);
  master.sync();
  Vec3<double> place{0, 0, 0};
  double sum = 0;
  for (Index j = 0; j < collision.first; ++j) {
    place += std::abs(collision.w[j]) * vec_cast<double>(corners[j]);
    sum += std::abs(collision.w[j]);
  }
  if (!(sum > 0)) return vec_cast<double>(corners[0]);
  return place * (1 / sum);
}

/// The first vertex whose motion is not finite.
template <class T>
std::optional<Vec3<double>> ImplicitStep<T>::place_not_finite() {
  Queue& master = store_.devices()[0].compute();
  const std::vector<Vec3<T>> x0 = download(master, store_.rank(0).positions);
  const std::vector<Vec3<T>> x1 = download(master, motion_.front().positions_t1);
  const auto finite = [](const Vec3<T>& x) { return std::isfinite(dot(x, x)); };
  const auto bad = std::find_if_not(x1.begin(), x1.end(), finite);
  if (bad == x1.end()) return {};
  const Vec3<T>& start = x0[static_cast<std::size_t>(bad - x1.begin())];
  return finite(start) ? std::optional(vec_cast<double>(start)) : std::nullopt;
}

/// The first collision of the latest round with a prescribed vertex that pinches cloth. The order
/// of collisions does not depend on the number of ranks, that of zones does.
template <class T>
std::optional<Vec3<double>> ImplicitStep<T>::pinched_place(std::size_t first_new) {
  const std::vector<Index>& pinched = zones_.pinched();
  const auto pinches = [&](const Collision& c) {
    return std::find_first_of(c.v, c.v + 4, pinched.begin(), pinched.end()) != c.v + 4;
  };
  const auto first = collisions_.begin() + static_cast<std::ptrdiff_t>(first_new);
  const auto found = std::find_if(first, collisions_.end(), pinches);
  if (found == collisions_.end()) return {};
  return place_of(*found);
}

template std::optional<Vec3<double>> ImplicitStep<float>::place_of(const Collision&);
template std::optional<Vec3<double>> ImplicitStep<double>::place_of(const Collision&);
template std::optional<Vec3<double>> ImplicitStep<float>::place_not_finite();
template std::optional<Vec3<double>> ImplicitStep<double>::place_not_finite();
template std::optional<Vec3<double>> ImplicitStep<float>::pinched_place(std::size_t);
template std::optional<Vec3<double>> ImplicitStep<double>::pinched_place(std::size_t);

}  // namespace weft
