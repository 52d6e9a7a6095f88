#include "weft/kernels/assemble/active_set_update.hpp"

#include "host/exec/host_device.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

template <class T>
void active_set_update(const AssembleActiveSetUpdate<T>& a) {
  double sum = 0;
  for (Index i = 0; i < static_cast<Index>(a.contacts.size()); ++i) {
    const ActiveSetChange<T> change = assemble_active_set_update(a, i);
    sum += change.mismatch_sq;
    if (!a.mismatch_of_contact.empty()) a.mismatch_of_contact[at(i)] = change.mismatch_sq;
    if (a.early) continue;  // no forces yet
    for (int side = 0; side < 2; ++side) {
      const ComponentForces part = component_forces(a, i, side, change);
      if (part.component < 0) continue;
      for (int k = 0; k < component_sums; ++k)
        a.force_sum[at(component_sums * part.component + k)] += part.sum[k];
    }
  }
  a.mismatch_sq[0] = sum * static_cast<double>(a.h * a.h);
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const AssembleActiveSetUpdate<T>& args) {
  submit_host(queue, [args] { active_set_update(args); });
}

template void run(OnHost, Queue&, const AssembleActiveSetUpdate<float>&);
template void run(OnHost, Queue&, const AssembleActiveSetUpdate<double>&);

}  // namespace weft
