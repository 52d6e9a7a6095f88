#include "weft/kernels/assemble/contact_cache.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleRemember<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.contacts.size()),
                  [](const AssembleRemember<T>& a, Index i) { assemble_remember(a, i); });
}

template void run(OnHost, Queue&, const AssembleRemember<float>&);
template void run(OnHost, Queue&, const AssembleRemember<double>&);

}  // namespace weft
