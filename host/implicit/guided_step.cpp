// Steps and motions that follow another run.
#include <algorithm>
#include <utility>

#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/step.hpp"
#include "weft/error.hpp"

namespace weft {

template <class T>
void ImplicitStep<T>::track(std::shared_ptr<const Tracking> tracking) {
  const DeviceSet& devices = store_.devices();
  if (tracking && (devices.backend() != Backend::host || devices.size() != 1))
    throw DeviceError("tracking constraints are there for one rank of the host only; use cpu:1");
  system_.track(nullptr);
  tracked_.reset();
  tracking_ = std::move(tracking);
  if (!tracking_) return;
  tracked_ = std::make_unique<TrackedSystem>(store_.model(), *tracking_);
  system_.track(tracked_.get());
}

/// By how much contact has kept averages off their target. Rank 0 has been waited for.
template <class T>
void ImplicitStep<T>::report_tracking(StepReport& report) {
  Queue& queue = store_.devices()[0].compute();
  const double error = tracked_->error(download(queue, motion_.front().positions_t1));
  report.tracking_error = std::max(report.tracking_error, error);
}

template <class T>
bool ImplicitStep<T>::displace(const std::vector<Vec3<T>>& places, double time,
                               StepReport& report) {
  DeviceSet& devices = store_.devices();
  const double dt = store_.scene().time.step;
  const Attempt a{dt, dt, true, true, false};
  grant_zone_visits(zone_budget());
  for (int r = 0; r < devices.size(); ++r) {
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = devices[r].compute();
    queue.copy(m.positions_t1.data(), places.data(), places.size() * sizeof(Vec3<T>));
    queue.copy(m.velocities_t1.data(), store_.rank(r).velocities.data(),
               m.velocities_t1.size() * sizeof(Vec3<T>));
  }
  prescribe(time);
  set_base(a);
  search_.search(dt, true, report);
  const bool good = resolve_collisions(a, report);
  sync_ranks(devices);
  if (!good) return false;
  for (int r = 0; r < devices.size(); ++r)
    std::swap(store_.rank(r).positions, motion_[static_cast<std::size_t>(r)].positions_t1);
  store_.time = time;
  return true;
}

template void ImplicitStep<float>::track(std::shared_ptr<const Tracking>);
template void ImplicitStep<double>::track(std::shared_ptr<const Tracking>);
template void ImplicitStep<float>::report_tracking(StepReport&);
template void ImplicitStep<double>::report_tracking(StepReport&);
template bool ImplicitStep<float>::displace(const std::vector<Vec3<float>>&, double, StepReport&);
template bool ImplicitStep<double>::displace(const std::vector<Vec3<double>>&, double, StepReport&);

}  // namespace weft
