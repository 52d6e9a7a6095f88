#include "host/scene/live_shape.hpp"

#include "weft/core/assert.hpp"

namespace weft {

void LiveShape::move(Span<const Vec3<double>> places) {
  WEFT_ASSERT(places.size() == size());
  state_.next.assign(places.begin(), places.end());
  state_.moved = true;
}

void LiveShape::begin_frame(double start, double end) {
  state_.from = state_.to;
  if (!state_.next.empty()) state_.to.swap(state_.next);
  state_.next.clear();
  state_.start = start;
  state_.end = end;
}

Vec3<double> LiveShape::at(double time, std::size_t vertex) const {
  const Vec3<double>& from = state_.from[vertex];
  const Vec3<double>& to = state_.to[vertex];
  if (!(time < state_.end)) return to;
  if (!(time > state_.start)) return from;
  return from + (to - from) * ((time - state_.start) / (state_.end - state_.start));
}

void LiveShape::positions(double time, Span<Vec3<double>> out) const {
  WEFT_ASSERT(out.size() == size());
  for (std::size_t v = 0; v < out.size(); ++v) out[v] = at(time, v);
}

}  // namespace weft
