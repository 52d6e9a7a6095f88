#include "weft/kernels/assemble/contact_cache.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleContactCacheBody {
  template <class T>
  WEFT_HD void operator()(const AssembleContactCache<T>& a, Index i) const noexcept {
    assemble_contact_cache(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleContactCache<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.contacts.size()),
                  AssembleContactCacheBody{});
}

template void run(OnCuda, Queue&, const AssembleContactCache<float>&);
template void run(OnCuda, Queue&, const AssembleContactCache<double>&);

}  // namespace weft
