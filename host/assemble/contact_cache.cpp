#include "weft/kernels/assemble/contact_cache.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleContactCache<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.contacts.size()),
                  [](const AssembleContactCache<T>& a, Index i) { assemble_contact_cache(a, i); });
}

template void run(OnHost, Queue&, const AssembleContactCache<float>&);
template void run(OnHost, Queue&, const AssembleContactCache<double>&);

}  // namespace weft
