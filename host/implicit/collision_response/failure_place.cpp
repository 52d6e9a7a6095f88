#include "host/implicit/collision_response/failure_place.hpp"

#include <algorithm>
#include <cmath>

#include "host/implicit/parallel/exchange.hpp"

namespace weft {

template <class T>
std::optional<Vec3<double>> place_of(Store<T>& store, const Collision& collision) {
  Queue& master = store.devices()[0].compute();
  Vec3<T> corners[2];
  for (Index j = 0; j < collision.first; ++j)
    master.copy(&corners[j], store.rank(0).positions.data() + collision.v[j], sizeof corners[j]);
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

template <class T>
std::optional<Vec3<double>> place_not_finite(Store<T>& store, const RankMotion<T>& motion) {
  Queue& master = store.devices()[0].compute();
  const std::vector<Vec3<T>> x0 = download(master, store.rank(0).positions);
  const std::vector<Vec3<T>> x1 = download(master, motion.positions_t1);
  const auto finite = [](const Vec3<T>& x) { return std::isfinite(dot(x, x)); };
  const auto bad = std::find_if_not(x1.begin(), x1.end(), finite);
  if (bad == x1.end()) return {};
  const Vec3<T>& start = x0[static_cast<std::size_t>(bad - x1.begin())];
  return finite(start) ? std::optional(vec_cast<double>(start)) : std::nullopt;
}

template <class T>
std::optional<Vec3<double>> pinched_place(Store<T>& store, const std::vector<Collision>& collisions,
                                          std::size_t first, const std::vector<Index>& pinched) {
  const auto pinches = [&](const Collision& c) {
    return std::find_first_of(c.v, c.v + 4, pinched.begin(), pinched.end()) != c.v + 4;
  };
  const auto found = std::find_if(collisions.begin() + static_cast<std::ptrdiff_t>(first),
                                  collisions.end(), pinches);
  if (found == collisions.end()) return {};
  return place_of(store, *found);
}

template std::optional<Vec3<double>> place_of(Store<float>&, const Collision&);
template std::optional<Vec3<double>> place_of(Store<double>&, const Collision&);
template std::optional<Vec3<double>> place_not_finite(Store<float>&, const RankMotion<float>&);
template std::optional<Vec3<double>> place_not_finite(Store<double>&, const RankMotion<double>&);
template std::optional<Vec3<double>> pinched_place(Store<float>&, const std::vector<Collision>&,
                                                   std::size_t, const std::vector<Index>&);
template std::optional<Vec3<double>> pinched_place(Store<double>&, const std::vector<Collision>&,
                                                   std::size_t, const std::vector<Index>&);

}  // namespace weft
