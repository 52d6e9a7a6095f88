#include "host/state/store.hpp"

#include <utility>

#include "weft/core/at.hpp"

namespace weft {
namespace {

template <class T>
std::vector<RankState<T>> make_states(DeviceSet& devices) {
  std::vector<RankState<T>> states;
  for (int r = 0; r < devices.size(); ++r) {
    Device& device = devices[r];
    states.push_back({Buffer<Vec3<T>>(device), Buffer<Vec3<T>>(device), Buffer<Vec3<T>>(device),
                      Buffer<Vec3<T>>(device), Buffer<unsigned char>(device),
                      Buffer<ContactMemory<T>>(device), Buffer<Vec3<T>>(device)});
  }
  return states;
}

template <class T>
void copy_state(Queue& queue, const RankState<T>& from, RankState<T>& to) {
  const auto copy = [&queue](const auto& a, auto& b) {
    b.resize(a.size());
    queue.copy(b.data(), a.data(), a.size() * sizeof *a.data());
  };
  copy(from.positions, to.positions);
  copy(from.velocities, to.velocities);
  copy(from.previous_positions, to.previous_positions);
  copy(from.previous_velocities, to.previous_velocities);
  copy(from.touched, to.touched);
  copy(from.contacts, to.contacts);
}

}  // namespace

template <class T>
Store<T>::Store(const Scene& scene, DeviceSet& devices, const std::vector<unsigned char>& welded,
                const Store* before)
    : Store(scene, devices,
            make_model(scene, welded, before != nullptr ? &before->model_ : nullptr)) {
  if (before != nullptr) time = before->time;
}

template <class T>
Store<T>::Store(const Scene& scene, DeviceSet& devices, Model model)
    : scene_(&scene),
      devices_(&devices),
      model_(std::move(model)),
      partition_(make_partition(model_.cloth_vertex_count, devices.size(),
                                scene.solver.partial_rows,
                                devices.backend() == Backend::host ? host_slice : cuda_slice)) {
  {
    const MemoryName name("state");
    ranks_ = make_states<T>(devices);
  }
  StateSnapshot<T> start;
  const auto cloth = static_cast<std::ptrdiff_t>(model_.cloth_vertex_count);
  start.positions = cast_all<T>(model_.positions);
  start.velocities = cast_all<T>(model_.velocities);
  start.velocities.erase(start.velocities.begin() + cloth, start.velocities.end());
  start.previous_positions = start.positions;
  start.previous_velocities = start.velocities;
  start.touched.assign(start.positions.size(), 0);
  for (const Obstacle& obstacle : scene.obstacles)
    if (obstacle.driven) start.driven.insert(start.driven.end(), 3, 0.0);
  restore(start);
}

template <class T>
void Store<T>::keep() {
  kept_.time = time;
  kept_.previous_step = previous_step;
  kept_.step_number = step_number;
  kept_.backoff = backoff;
  kept_.face_contacts = face_contacts;
  if (kept_.ranks.empty()) {
    const MemoryName name("state");
    kept_.ranks = make_states<T>(*devices_);
  }
  for (int r = 0; r < devices_->size(); ++r)
    copy_state((*devices_)[r].compute(), ranks_[static_cast<std::size_t>(r)],
               kept_.ranks[static_cast<std::size_t>(r)]);
}

template <class T>
void Store<T>::go_back() {
  time = kept_.time;
  previous_step = kept_.previous_step;
  step_number = kept_.step_number;
  backoff = kept_.backoff;
  face_contacts = kept_.face_contacts;
  ++restores_;
  for (int r = 0; r < devices_->size(); ++r) {
    Queue& queue = (*devices_)[r].compute();
    copy_state(queue, kept_.ranks[static_cast<std::size_t>(r)],
               ranks_[static_cast<std::size_t>(r)]);
    queue.sync();
  }
}

template <class T>
std::shared_ptr<const PlateMatrix> Store<T>::plate(const std::vector<unsigned char>& fixed) {
  std::vector<unsigned char> held = held_triangles(model_, fixed);
  if (!plate_ || held != held_) {
    plate_ = std::make_shared<const PlateMatrix>(make_plate(*scene_, model_, held));
    held_ = std::move(held);
  }
  return plate_;
}

template <class T>
void Store<T>::share_rows(std::vector<Index> row_begin) {
  WEFT_ASSERT(row_begin.size() == partition_.row_begin.size());
  WEFT_ASSERT(row_begin.front() == 0 && row_begin.back() == partition_.row_count());
  partition_.row_begin = std::move(row_begin);
}

template <class T>
void Store<T>::set_compression(const std::vector<double>& by_input) {
  std::vector<double> compression;
  if (!by_input.empty())
    for (const Index t : model_.input_triangle)
      compression.push_back(by_input[static_cast<std::size_t>(t)]);
  if (compression == model_.compression) return;
  model_.compression = std::move(compression);
  ++compression_epoch_;
}

template <class T>
void Store<T>::apply_forces(const std::vector<Vec3<double>>& forces) {
  accelerations_.assign(forces.empty() ? 0 : at(model_.cloth_vertex_count), {});
  for (std::size_t input = 0; input < forces.size(); ++input) {
    const std::size_t v = at(model_.to_internal[input]);
    accelerations_[v] += (1 / model_.mass[v]) * forces[input];
  }
  for (int r = 0; r < devices_->size(); ++r)
    upload((*devices_)[r].compute(), ranks_[at(r)].accelerations, cast_all<T>(accelerations_));
}

template <class T>
StateSnapshot<T> Store<T>::snapshot() const {
  Queue& queue = (*devices_)[0].compute();
  const RankState<T>& rank = ranks_.front();
  return {time,
          previous_step,
          step_number,
          backoff,
          download(queue, rank.positions),
          download(queue, rank.velocities),
          download(queue, rank.previous_positions),
          download(queue, rank.previous_velocities),
          download(queue, rank.touched),
          download(queue, rank.contacts),
          face_contacts,
          driven,
          sleep,
          next_step};
}

template <class T>
void Store<T>::restore(const StateSnapshot<T>& s) {
  time = s.time;
  previous_step = s.previous_step;
  step_number = s.step_number;
  backoff = s.backoff;
  face_contacts = s.face_contacts;
  driven = s.driven;
  sleep = s.sleep;
  next_step = s.next_step;
  ++restores_;
  for (int r = 0; r < devices_->size(); ++r) {
    Queue& queue = (*devices_)[r].compute();
    RankState<T>& rank = ranks_[static_cast<std::size_t>(r)];
    upload(queue, rank.positions, s.positions);
    upload(queue, rank.velocities, s.velocities);
    upload(queue, rank.previous_positions, s.previous_positions);
    upload(queue, rank.previous_velocities, s.previous_velocities);
    upload(queue, rank.touched, s.touched);
    upload(queue, rank.contacts, s.contacts);
  }
}

template class Store<float>;
template class Store<double>;

}  // namespace weft
