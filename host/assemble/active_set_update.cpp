#include "weft/kernels/assemble/active_set_update.hpp"

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
void active_set_update(const AssembleActiveSetUpdate<T>& a) {
  double sum = 0;
  for (std::size_t n = 0; n < a.contacts.size(); ++n)
    sum += assemble_active_set_update(a, static_cast<Index>(n));
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
