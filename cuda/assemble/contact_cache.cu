#include "weft/kernels/assemble/contact_cache.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleRememberBody {
  template <class T>
  WEFT_HD void operator()(const AssembleRemember<T>& a, Index i) const noexcept {
    assemble_remember(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleRemember<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.contacts.size()), AssembleRememberBody{});
}

template void run(OnCuda, Queue&, const AssembleRemember<float>&);
template void run(OnCuda, Queue&, const AssembleRemember<double>&);

}  // namespace weft
