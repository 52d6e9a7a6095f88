#include "weft/kernels/respond/remember.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

void run(OnHost, Queue& queue, const RespondRemember& args) {
  submit_for_each(queue, args, static_cast<Index>(args.touched.size()),
                  [](const RespondRemember& a, Index i) { respond_remember(a, i); });
}

}  // namespace weft
