#include "weft/kernels/respond/remember.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct RespondRememberBody {
  WEFT_HD void operator()(const RespondRemember& a, Index i) const noexcept {
    respond_remember(a, i);
  }
};

void run(OnCuda, Queue& queue, const RespondRemember& args) {
  launch_for_each(queue, args, static_cast<Index>(args.touched.size()), RespondRememberBody{});
}

}  // namespace weft
