// What is awake as a system of its own: its state out of that of the whole, and back into it.
#include <algorithm>
#include <iterator>

#include "host/exec/host_device.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/sleep/sleeping_step.hpp"
#include "weft/core/at.hpp"

namespace weft {
/// The steps of what is awake, rebuilt if that has changed.
template <class T>
void SleepingStep<T>::make_awake() {
  std::vector<unsigned char> left_out(component_count_);
  for (std::size_t p = 0; p < component_count_; ++p) left_out[p] = sleeps(p) ? 1 : 0;
  if (awake_ && left_out == left_out_) return;
  std::vector<unsigned char> kept;
  for (const Index p : component_of_) kept.push_back(left_out[at(p)] == 0 ? 1 : 0);
  awake_.reset();
  awake_ = std::make_unique<Awake>(store_, part_of(store_.model(), kept));
  left_out_ = std::move(left_out);
  awake_->store.restore(state_of_part(*awake_));
}

/// The state of a part out of that of the whole, but for the times. Contacts of what sleeps stay
/// with the part, to be put back with its own.
template <class T>
StateSnapshot<T> SleepingStep<T>::state_of_part(Awake& awake) const {
  const RankState<T>& whole = store_.rank(0);
  const ModelPart& part = awake.part;
  const Model& model = awake.store.model();
  StateSnapshot<T> s;
  for (const Index v : part.vertex) {
    s.positions.push_back(whole.positions.data()[v]);
    s.previous_positions.push_back(whole.previous_positions.data()[v]);
    s.touched.push_back(whole.touched.data()[v]);
  }
  for (Index v = 0; v < model.cloth_vertex_count; ++v) {
    s.velocities.push_back(whole.velocities.data()[part.vertex[at(v)]]);
    s.previous_velocities.push_back(whole.previous_velocities.data()[part.vertex[at(v)]]);
  }
  const auto number = [](const std::vector<Index>& numbers, Index of_whole) {
    const auto found = std::lower_bound(numbers.begin(), numbers.end(), of_whole);
    return found != numbers.end() && *found == of_whole
               ? static_cast<Index>(found - numbers.begin())
               : Index{-1};
  };
  for (std::size_t n = 0; n < whole.contacts.size(); ++n) {
    ContactMemory<T> c = whole.contacts.data()[n];
    const bool face = n < static_cast<std::size_t>(store_.face_contacts);
    const Pair in{number(face ? part.vertex : part.edge, c.pair.a),
                  number(face ? part.triangle : part.edge, c.pair.b)};
    const bool a_awake =
        in.a >= 0 && in.a < (face ? model.cloth_vertex_count : model.cloth_edge_count);
    const bool b_awake =
        in.b >= 0 && in.b < (face ? model.cloth_triangle_count : model.cloth_edge_count);
    if (in.a >= 0 && in.b >= 0) {
      c.pair = in;
      if (face) ++s.face_contacts;
      s.contacts.push_back(c);
    } else if (!a_awake && !b_awake) {
      (face ? awake.faces : awake.edges).push_back(c);
    }
  }
  return s;
}

/// A step in which all of the cloth sleeps: wake_approached() has seen where obstacles go.
template <class T>
void SleepingStep<T>::advance_obstacles(double dt) {
  awake_.reset();
  for (int r = 0; r < store_.devices().size(); ++r)
    submit_host(store_.devices()[r].compute(), [this, r] {
      RankState<T>& state = store_.rank(r);
      for (std::size_t i = 0; i < placed_.size(); ++i) {
        const std::size_t v = component_of_.size() + i;
        state.previous_positions.data()[v] = state.positions.data()[v];
        state.positions.data()[v] = vec_cast<T>(placed_[i]);
        state.touched.data()[v] = 0;
      }
    });
  sync_ranks(store_.devices());
  store_.time += dt;
  store_.previous_step = dt;
}

/// What a step of the part has come to, into the state of the whole.
template <class T>
void SleepingStep<T>::write_back() {
  const std::vector<Index>& vertex = awake_->part.vertex;
  const auto cloth = at(awake_->store.model().cloth_vertex_count);
  for (int r = 0; r < store_.devices().size(); ++r)
    submit_host(store_.devices()[r].compute(), [this, r, &vertex, cloth] {
      const RankState<T>& from = awake_->store.rank(r);
      RankState<T>& to = store_.rank(r);
      for (std::size_t i = 0; i < vertex.size(); ++i) {
        const Index v = vertex[i];
        to.positions.data()[v] = from.positions.data()[i];
        to.previous_positions.data()[v] = from.previous_positions.data()[i];
        to.touched.data()[v] = from.touched.data()[i];
        if (i >= cloth) continue;
        to.velocities.data()[v] = from.velocities.data()[i];
        to.previous_velocities.data()[v] = from.previous_velocities.data()[i];
      }
    });
  sync_ranks(store_.devices());
  write_contacts();
  store_.time = awake_->store.time;
  store_.previous_step = awake_->store.previous_step;
  store_.backoff = awake_->store.backoff;
}

/// Contacts of the part and of what sleeps, in the order of the whole's pairs: numbers of a part
/// ascend as those of the whole do.
template <class T>
void SleepingStep<T>::write_contacts() {
  const ModelPart& part = awake_->part;
  const Buffer<ContactMemory<T>>& own = awake_->store.rank(0).contacts;
  const auto faces = static_cast<std::size_t>(awake_->store.face_contacts);
  const auto earlier = [](const ContactMemory<T>& a, const ContactMemory<T>& b) {
    return a.pair.a != b.pair.a ? a.pair.a < b.pair.a : a.pair.b < b.pair.b;
  };
  std::vector<ContactMemory<T>> renumbered(own.data(), own.data() + own.size());
  for (std::size_t n = 0; n < renumbered.size(); ++n) {
    Pair& pair = renumbered[n].pair;
    pair = n < faces ? Pair{part.vertex[at(pair.a)], part.triangle[at(pair.b)]}
                     : Pair{part.edge[at(pair.a)], part.edge[at(pair.b)]};
  }
  const auto middle = renumbered.begin() + static_cast<std::ptrdiff_t>(faces);
  std::vector<ContactMemory<T>> all;
  std::merge(renumbered.begin(), middle, awake_->faces.begin(), awake_->faces.end(),
             std::back_inserter(all), earlier);
  store_.face_contacts = static_cast<std::int64_t>(all.size());
  std::merge(middle, renumbered.end(), awake_->edges.begin(), awake_->edges.end(),
             std::back_inserter(all), earlier);
  for (int r = 0; r < store_.devices().size(); ++r) {
    store_.rank(r).contacts.grow(all.size());
    upload(store_.devices()[r].compute(), store_.rank(r).contacts, all);
  }
}

template void SleepingStep<float>::make_awake();
template void SleepingStep<double>::make_awake();
template void SleepingStep<float>::advance_obstacles(double);
template void SleepingStep<double>::advance_obstacles(double);
template void SleepingStep<float>::write_back();
template void SleepingStep<double>::write_back();

}  // namespace weft
