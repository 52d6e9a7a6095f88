#include "weft/kernels/assemble/reweigh.hpp"

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
void reweigh(const AssembleReweigh<T>& a) {
  double sum = 0;
  for (std::size_t n = 0; n < a.contacts.size(); ++n) {
    Contact<T>& c = a.contacts[n];
    const ContactMotion<T> m = contact_motion(c, a.positions, a.positions_t0);
    ContactWeights<T> right = contact_weights(c, m);
    const double normal = (right.push - c.push) * (c.thickness - m.gap);
    const double tangential =
        length(friction_force(right.drag, m.displacement) -
               friction_force({c.drag, c.drag_limit, c.slide}, m.displacement));
    double weights = 0;
    for (int j = 0; j < 4; ++j)
      if (c.v[j] < a.cloth_vertex_count) weights += static_cast<double>(c.w[j] * c.w[j]);
    sum += weights * (normal * normal + tangential * tangential);
    // As a secant the force falls with the displacement, and is gone where that ends.
    if (a.last) right.drag = {right.drag.stiffness, T(0), Vec3<T>{}};
    c.push = right.push;
    c.drag = right.drag.stiffness;
    c.drag_limit = right.drag.limit;
    c.slide = right.drag.slide;
  }
  a.mismatch_sq[0] = sum * static_cast<double>(a.h * a.h);
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const AssembleReweigh<T>& args) {
  submit_host(queue, [args] { reweigh(args); });
}

template void run(OnHost, Queue&, const AssembleReweigh<float>&);
template void run(OnHost, Queue&, const AssembleReweigh<double>&);

}  // namespace weft
