#include "host/simulation/sew.hpp"

#include "host/state/transfer.hpp"

namespace weft {
namespace {

/// How often pairs that run into something are taken out and the others tried again.
constexpr int rounds_max = 8;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

/// Pairs of seams in internal numbers.
std::vector<SeamPair> internal_pairs(const Scene& scene, const Model& model) {
  std::vector<SeamPair> pairs = seam_pairs(scene);
  for (SeamPair& pair : pairs)
    for (Index& v : pair.v) v = model.to_internal[at(v)];
  return pairs;
}

std::vector<Index> groups_of(const Model& model, const std::vector<SeamPair>& pairs,
                             const std::vector<unsigned char>& welded) {
  std::vector<SeamPair> joined;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (welded[k] != 0) joined.push_back(pairs[k]);
  return grouped(model.to_input.size(), joined);
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

template <class T>
std::vector<MovedVertex<T>> moves_between(const StateSnapshot<T>& from,
                                          const StateSnapshot<T>& to) {
  std::vector<MovedVertex<T>> moves;
  for (std::size_t v = 0; v < to.velocities.size(); ++v)
    if (length_sq(to.positions[v] - from.positions[v]) > T(0))
      moves.push_back({static_cast<Index>(v), to.positions[v]});
  return moves;
}

}  // namespace

template <class T>
StateSnapshot<T> welded_state(Store<T>& store, const std::vector<unsigned char>& welded) {
  const Model& model = store.model();
  const auto group = groups_of(model, internal_pairs(store.scene(), model), welded);
  return merged_state(model, group, fixed_vertices(store.scene(), model, store.time),
                      store.snapshot());
}

template <class T>
std::vector<unsigned char> weldable_pairs(Store<T>& store, ImplicitStep<T>& implicit,
                                          const Sewing& sewing) {
  const Model& model = store.model();
  const std::vector<SeamPair> pairs = internal_pairs(store.scene(), model);
  const StateSnapshot<T> state = store.snapshot();
  std::vector<unsigned char> welded = sewing.welded;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Vec3<T> gap = state.positions[at(pairs[k].v[1])] - state.positions[at(pairs[k].v[0])];
    if (pairs[k].weld_distance > 0 && static_cast<double>(length(gap)) <= pairs[k].weld_distance)
      welded[k] = 1;
  }
  for (int round = 0; round < rounds_max && welded != sewing.welded; ++round) {
    const std::vector<Index> group = groups_of(model, pairs, welded);
    const auto moves = moves_between(state, welded_state(store, welded));
    bool clear = true;
    std::vector<unsigned char> hit(group.size(), 0);
    if (!moves.empty())
      for (const Collision& c : implicit.collisions_on_the_way(moves)) {
        if (joins(c, group)) continue;
        clear = false;
        for (const Index v : c.v)
          if (at(v) < group.size()) hit[at(group[at(v)])] = 1;
      }
    if (clear) return welded;
    for (std::size_t k = 0; k < pairs.size(); ++k)
      if (sewing.welded[k] == 0 && welded[k] != 0)
        welded[k] = hit[at(group[at(pairs[k].v[0])])] == 0;
  }
  return sewing.welded;
}

template std::vector<unsigned char> weldable_pairs(Store<float>&, ImplicitStep<float>&,
                                                   const Sewing&);
template std::vector<unsigned char> weldable_pairs(Store<double>&, ImplicitStep<double>&,
                                                   const Sewing&);
template StateSnapshot<float> welded_state(Store<float>&, const std::vector<unsigned char>&);
template StateSnapshot<double> welded_state(Store<double>&, const std::vector<unsigned char>&);

}  // namespace weft
