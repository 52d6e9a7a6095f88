#include "host/simulation/sew.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "host/state/transfer.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// How far from the mean a place is that is tried after something was hit on the way to the one
/// before, over the distance of the vertices from the mean. A right angle needs 1.
constexpr std::array<double, 4> pushes = {0.5, 1, 2, 3};
/// How often places are moved, or pairs taken out, and the others tried again.
constexpr int rounds_max = 16;

/// Pairs of seams in internal numbers.
std::vector<SeamPair> internal_pairs(const Scene& scene, const Model& model) {
  std::vector<SeamPair> pairs = seam_pairs(scene);
  for (SeamPair& pair : pairs)
    for (Index& v : pair.v) v = model.to_internal[at(v)];
  return pairs;
}

/// Whether the collision is between primitives that will share a vertex.
bool joins(const Collision& c, const std::vector<Index>& group) {
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j)
      if (at(c.v[i]) < group.size() && at(c.v[j]) < group.size() &&
          group[at(c.v[i])] == group[at(c.v[j])])
        return true;
  return false;
}

/// Unit vector along which the vertex moves out of a collision.
Vec3<double> way_out(const Collision& c, std::size_t vertex) {
  for (int i = 0; i < 4; ++i)
    if (at(c.v[i]) == vertex) return c.w[i] < 0 ? -c.n : c.n;
  return {};
}

/// Tries to weld pairs, and moves or takes out those that run into something.
template <class T>
class WeldAttempt {
 public:
  /// @param least see weld_close_pairs()
  WeldAttempt(Store<T>& store, const Sewing& sewing, double least);

  bool any() const { return welded_ != sewing_.welded; }
  /// The state with the pairs that are to be welded at one place each.
  StateSnapshot<T> merged() const;
  Welding<T> welding(const StateSnapshot<T>& merged) const { return {welded_, refused(), merged}; }
  Welding<T> no_welding() const { return {sewing_.welded, tried_, std::nullopt}; }
  /// @return the cloth vertices that would move, and where to
  std::vector<MovedVertex<T>> moves(const StateSnapshot<T>& to) const;
  /// @return whether nothing is hit; otherwise what is hit is to be tried elsewhere, or not at all
  bool clear(const std::vector<Collision>& collisions);

 private:
  /// Of each group under its lowest vertex.
  struct Place {
    double radius = 0;       ///< [m] largest distance of its vertices from their mean
    bool fixed = false;      ///< something prescribes it
    std::size_t pushed = 0;  ///< times
    Vec3<double> shift{};    ///< [m] from the mean
    bool hit = false;
    Vec3<double> away{};  ///< from what is hit on the way to the mean, of any length
  };

  std::vector<unsigned char> refused() const;
  bool close(const SeamPair& pair) const;
  void group();
  void move_away(Index lowest);

  const Store<T>& store_;
  const Sewing& sewing_;
  const std::vector<SeamPair> pairs_;
  const std::vector<unsigned char> fixed_;
  StateSnapshot<T> state_;
  std::vector<unsigned char> welded_;
  std::vector<unsigned char> tried_;  ///< [pairs] refused before, or tried now
  std::vector<Index> group_;          ///< [cloth vertices] lowest vertex of the group
  std::vector<Place> places_;
};

template <class T>
WeldAttempt<T>::WeldAttempt(Store<T>& store, const Sewing& sewing, double least)
    : store_(store),
      sewing_(sewing),
      pairs_(internal_pairs(store.scene(), store.model())),
      fixed_(fixed_vertices(store.scene(), store.model(), store.time)),
      welded_(sewing.welded),
      tried_(sewing.refused) {
  tried_.resize(pairs_.size(), 0);
  // Most steps end here, and need no more of the state.
  state_.positions = download(store.devices()[0].compute(), store.rank(0).positions);
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < pairs_.size(); ++k)
    if (welded_[k] == 0 && tried_[k] == 0 && close(pairs_[k])) found.push_back(k);
  if (found.empty() ||
      static_cast<double>(found.size()) < least * static_cast<double>(pairs_.size()))
    return;
  places_.resize(store.model().to_input.size());
  for (const std::size_t k : found) welded_[k] = tried_[k] = 1;
  state_ = store.snapshot();
  group();
  const StateSnapshot<T> merged = merged_state(store_.model(), group_, fixed_, state_);
  for (std::size_t v = 0; v < group_.size(); ++v) {
    Place& place = places_[at(group_[v])];
    place.radius = std::max(place.radius,
                            static_cast<double>(length(merged.positions[v] - state_.positions[v])));
    place.fixed = place.fixed || fixed_[v] != 0;
  }
}

template <class T>
bool WeldAttempt<T>::close(const SeamPair& pair) const {
  const Vec3<T> gap = state_.positions[at(pair.v[1])] - state_.positions[at(pair.v[0])];
  return pair.weld_distance > 0 && static_cast<double>(length(gap)) <= pair.weld_distance;
}

template <class T>
std::vector<unsigned char> WeldAttempt<T>::refused() const {
  std::vector<unsigned char> refused = tried_;
  for (std::size_t k = 0; k < refused.size(); ++k)
    if (welded_[k] != 0) refused[k] = 0;
  return refused;
}

template <class T>
void WeldAttempt<T>::group() {
  std::vector<SeamPair> joined;
  for (std::size_t k = 0; k < pairs_.size(); ++k)
    if (welded_[k] != 0) joined.push_back(pairs_[k]);
  group_ = grouped(store_.model().to_input.size(), joined);
}

template <class T>
StateSnapshot<T> WeldAttempt<T>::merged() const {
  StateSnapshot<T> merged = merged_state(store_.model(), group_, fixed_, state_);
  for (std::size_t v = 0; v < group_.size(); ++v) {
    const Place& place = places_[at(group_[v])];
    if (place.pushed == 0) continue;
    for (std::vector<Vec3<T>>* positions : {&merged.positions, &merged.previous_positions})
      (*positions)[v] = vec_cast<T>(vec_cast<double>((*positions)[v]) + place.shift);
  }
  return merged;
}

template <class T>
std::vector<MovedVertex<T>> WeldAttempt<T>::moves(const StateSnapshot<T>& to) const {
  std::vector<MovedVertex<T>> moves;
  for (std::size_t v = 0; v < group_.size(); ++v)
    if (length_sq(to.positions[v] - state_.positions[v]) > T(0))
      moves.push_back({static_cast<Index>(v), to.positions[v]});
  return moves;
}

template <class T>
bool WeldAttempt<T>::clear(const std::vector<Collision>& collisions) {
  for (Place& place : places_) place.hit = false;
  // Of each vertex the first: later ones may be with the far side of a body, from within.
  std::vector<const Collision*> first(group_.size(), nullptr);
  bool clear = true;
  for (const Collision& c : collisions) {
    if (joins(c, group_)) continue;
    clear = false;
    for (const Index v : c.v) {
      if (at(v) >= group_.size()) continue;
      places_[at(group_[at(v)])].hit = true;
      if (first[at(v)] == nullptr || c.toi < first[at(v)]->toi) first[at(v)] = &c;
    }
  }
  if (clear) return true;
  // The direction stays: on the way to a place beside the mean, a vertex may hit an edge of the
  // body from any side.
  for (std::size_t v = 0; v < first.size(); ++v) {
    Place& place = places_[at(group_[v])];
    if (first[v] != nullptr && place.pushed == 0) place.away += way_out(*first[v], v);
  }
  for (std::size_t v = 0; v < places_.size(); ++v)
    if (places_[v].hit) move_away(static_cast<Index>(v));
  for (std::size_t k = 0; k < pairs_.size(); ++k)
    if (sewing_.welded[k] == 0 && places_[at(group_[at(pairs_[k].v[0])])].hit) welded_[k] = 0;
  group();
  return false;
}

/// Leaves `hit` as it is where there is no other place to try.
template <class T>
void WeldAttempt<T>::move_away(Index lowest) {
  Place& place = places_[at(lowest)];
  const double size = length(place.away);
  if (place.fixed || place.pushed == pushes.size() || !(size > 0)) {
    // Its vertices stay where they are, whatever else is hit.
    place.pushed = 0;
    place.radius = 0;
    return;
  }
  place.shift = (pushes[place.pushed] * place.radius / size) * place.away;
  ++place.pushed;
  place.hit = false;
}

}  // namespace

template <class T>
Welding<T> weld_close_pairs(Store<T>& store, ImplicitStep<T>& implicit, const Sewing& sewing,
                            double least, StepReport& report) {
  WeldAttempt<T> attempt(store, sewing, least);
  for (int round = 0; round < rounds_max && attempt.any(); ++round) {
    const StateSnapshot<T> merged = attempt.merged();
    const std::vector<MovedVertex<T>> moves = attempt.moves(merged);
    if (moves.empty() || attempt.clear(implicit.collisions_on_the_way(moves, report)))
      return attempt.welding(merged);
  }
  return attempt.no_welding();
}

template Welding<float> weld_close_pairs(Store<float>&, ImplicitStep<float>&, const Sewing&, double,
                                         StepReport&);
template Welding<double> weld_close_pairs(Store<double>&, ImplicitStep<double>&, const Sewing&,
                                          double, StepReport&);

}  // namespace weft
