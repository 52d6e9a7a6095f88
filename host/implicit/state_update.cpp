#include "host/implicit/state_update.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "weft/kernels/assemble/contact_cache.hpp"
#include "weft/kernels/respond/remember.hpp"

namespace weft {
namespace {

/// Times in which cloth would fall by half of the thickness that the mean load of a contact takes
/// to follow its force. Stiffness that follows the force at once makes stacks swing ever more.
constexpr double load_falls = 10;
/// Share of that way in a step if nothing has a weight.
constexpr double weightless_load_share = 0.05;

}  // namespace

template <class T>
StateUpdate<T>::StateUpdate(Store<T>& store, const std::vector<RankGeometry<T>>& geometry,
                            std::vector<RankMotion<T>>& motion,
                            const ContactDetection<T>& detection)
    : store_(store),
      geometry_(geometry),
      motion_(motion),
      detection_(detection),
      error_estimate_(store) {}

template <class T>
void StateUpdate<T>::cache_contacts(double dt) {
  const double gravity = length(store_.scene().gravity);
  const double load_time =
      load_falls * std::sqrt(contact_thickness(store_.scene().contact) / gravity);
  const double load_share = gravity > 0 ? std::min(1.0, dt / load_time) : weightless_load_share;
  for (int r = 0; r < store_.devices().size(); ++r) {
    const Span<const Contact<T>> contacts = detection_.contacts(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    m.contacts.grow(contacts.size());
    m.contacts.resize(contacts.size());
    m.face_contacts = detection_.face_contacts();
    Queue& queue = store_.devices()[r].compute();
    queue.fill(m.crushed.data(), 0, m.crushed.size());
    queue.fill(m.crushed_in_jam.data(), 0, m.crushed_in_jam.size());
    const auto cloth = static_cast<std::size_t>(store_.model().cloth_vertex_count);
    launch(queue,
           AssembleContactCache<T>{contacts, m.positions_t1.span(), store_.rank(r).positions.span(),
                                   static_cast<T>(load_share), m.contacts.span(),
                                   store_.rank(r).touched.span().subspan(0, cloth),
                                   m.crushed.span(), m.crushed_in_jam.span()});
  }
}

template <class T>
void StateUpdate<T>::remember_touched(Hardening hardening) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    const RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    launch(store_.devices()[r].compute(),
           RespondRemember{m.moved_in_attempt.span(), m.crushed.span(), m.crushed_in_jam.span(),
                           hardening, store_.rank(r).touched.span()});
  }
}

template <class T>
void StateUpdate<T>::accept(double dt) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    std::swap(state.previous_positions, state.positions);
    std::swap(state.positions, m.positions_t1);
    std::swap(state.previous_velocities, state.velocities);
    std::swap(state.velocities, m.velocities_t1);
    std::swap(state.contacts, m.contacts);
  }
  store_.face_contacts = motion_.front().face_contacts;
  store_.time += dt;
  store_.previous_step = dt;
  if (store_.scene().time.automatic) step_error_ += error_estimate_.measure(geometry_.front());
}

template class StateUpdate<float>;
template class StateUpdate<double>;

}  // namespace weft
