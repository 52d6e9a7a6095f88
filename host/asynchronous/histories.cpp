#include "host/asynchronous/histories.hpp"

#include <algorithm>
#include <cmath>

namespace weft {
namespace {

/// Widens the deviation of a chord by a position at its share. Here `deviation` is the square.
[[gnu::always_inline]] inline void widen_by_deviation(Chord& chord, double share,
                                                      const Vec3<double>& x) {
  const Vec3<double> on_line = chord.from + (chord.to - chord.from) * share;
  chord.deviation = std::max(chord.deviation, length_sq(x - on_line));
}

}  // namespace

void Histories::reset(const VertexMotion& motion, std::size_t cloth_count, double time) {
  if (cloth_count != cloth_count_) frames_.clear();
  cloth_count_ = cloth_count;
  frame_count_ = 0;
  own_.resize(motion.x.size());
  for (std::vector<Breakpoint>& own : own_) own.clear();
  Vec3<double>* const at_start = add_all(time);
  for (std::size_t i = 0; i < cloth_count; ++i) at_start[i] = motion.position(i, time);
  starts_.clear();
  for (std::size_t i = cloth_count; i < own_.size(); ++i)
    starts_.push_back(motion.position(i, time));
}

Vec3<double>* Histories::add_all(double time) {
  const bool same = frame_count_ > 0 && !(time > times_[frame_count_ - 1]);
  if (!same) ++frame_count_;
  if (frames_.size() < frame_count_) {
    frames_.emplace_back(cloth_count_);
    times_.resize(frames_.size());
  }
  times_[frame_count_ - 1] = time;
  return frames_[frame_count_ - 1].data();
}

void Histories::finish(const VertexMotion& motion, double time) {
  Vec3<double>* const at_end = add_all(time);
  for (std::size_t i = 0; i < cloth_count_; ++i) at_end[i] = motion.position(i, time);
  ends_.clear();
  for (std::size_t i = cloth_count_; i < own_.size(); ++i)
    ends_.push_back(motion.position(i, time));
}

std::size_t Histories::bytes() const {
  const auto of = [](const auto& list, auto size) { return list.capacity() * size; };
  std::size_t sum = of(times_, sizeof(double)) + of(frames_, sizeof(frames_[0])) +
                    of(own_, sizeof(own_[0])) + of(starts_, sizeof(Vec3<double>)) +
                    of(ends_, sizeof(Vec3<double>));
  for (const auto& frame : frames_) sum += of(frame, sizeof(Vec3<double>));
  for (const auto& own : own_) sum += of(own, sizeof(Breakpoint));
  return sum;
}

std::size_t Histories::copy(std::size_t i, Breakpoint* to) const {
  Breakpoint* next = to;
  const std::vector<Breakpoint>& own = own_[i];
  if (i >= cloth_count_) {
    *next++ = {first_time(), starts_[i - cloth_count_]};
    next = std::copy(own.begin(), own.end(), next);
    *next++ = {last_time(), ends_[i - cloth_count_]};
    return static_cast<std::size_t>(next - to);
  }
  auto single = own.begin();
  for (std::size_t f = 0; f < frame_count_; ++f) {
    for (; single != own.end() && single->t < times_[f]; ++single) *next++ = *single;
    for (; single != own.end() && !(single->t > times_[f]); ++single) continue;
    *next++ = {times_[f], frames_[f][i]};
  }
  return static_cast<std::size_t>(next - to);
}

void Histories::include(std::size_t first, std::size_t last, Extent* extents) const {
  const std::size_t last_cloth = std::min(last, cloth_count_);
  for (std::size_t f = 0; f < frame_count_; ++f)
    for (std::size_t i = first; i < last_cloth; ++i) extents[i - first].include(frames_[f][i]);
  for (std::size_t i = first; i < last; ++i) {
    for (const Breakpoint& breakpoint : own_[i]) extents[i - first].include(breakpoint.x);
    if (i < cloth_count_) continue;
    extents[i - first].include(starts_[i - cloth_count_]);
    extents[i - first].include(ends_[i - cloth_count_]);
  }
}

void Histories::chords(std::size_t first, std::size_t last, Chord* chords) const {
  const std::size_t last_cloth = std::min(last, cloth_count_);
  for (std::size_t i = first; i < last; ++i)
    chords[i - first] = i < cloth_count_
                            ? Chord{frames_[0][i], frames_[frame_count_ - 1][i]}
                            : Chord{starts_[i - cloth_count_], ends_[i - cloth_count_]};
  const double span = last_time() - first_time();
  const auto share = [&](double time) { return span > 0 ? (time - first_time()) / span : 0; };
  // Straight pieces are farthest from a straight line at their ends.
  for (std::size_t f = 1; f + 1 < frame_count_; ++f)
    for (std::size_t i = first; i < last_cloth; ++i)
      widen_by_deviation(chords[i - first], share(times_[f]), frames_[f][i]);
  for (std::size_t i = first; i < last; ++i) {
    for (const Breakpoint& breakpoint : own_[i])
      widen_by_deviation(chords[i - first], share(breakpoint.t), breakpoint.x);
    chords[i - first].deviation = std::sqrt(chords[i - first].deviation);
  }
}

}  // namespace weft
