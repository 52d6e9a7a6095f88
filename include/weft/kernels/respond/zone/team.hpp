#pragma once

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

// The workers that solve an impact zone together: one on the host (alone.hpp), the lanes of a warp,
// the threads of a block or those of all blocks of a launch on a GPU. A Team has
//   static constexpr bool alone           one worker: what depends on order goes in plain order
//   static constexpr bool in_order        sweeps as a worker that is alone would, however many
//                                         phases that takes
//   static constexpr bool at_once         sweeps change all multipliers at once: phases take longer
//   static constexpr Index lanes          workers that sum up what one vertex gets
//   Vec3<double> sum_of_lanes(Vec3)       over the workers of one vertex; if there is more than one
//   Index rank() const, size() const      this worker's number, and how many there are
//   void sync()                           writes before are visible to all workers after
//   double sum(double), largest(double)   over the workers, in an order that size() alone decides
//   bool any(bool)                        whether one says so
//   Index before(Index, Index& total)     sum over the workers of lower rank, and over all
//   void sort(Offset*, Index)             ascending; all keys differ
// All but rank() and size() are called by all workers at the same place, and what they return makes
// writes from before the call visible to all workers, as sync() does.

/// A function that both compilers compile, and that stays a function on a GPU: what calls what
/// here is deep, and written out in full would take minutes to compile.
#if defined(__CUDACC__)
#define WEFT_HD_CALL __host__ __device__ __noinline__
#else
#define WEFT_HD_CALL
#endif

namespace weft {

/// Calls body(i) for i = 0 to count - 1, each on one worker. What it writes is visible after it.
template <class Team, class Body>
WEFT_HD void for_each(Team& team, Index count, const Body& body) {
  for (Index i = team.rank(); i < count; i += team.size()) body(i);
  team.sync();
}

/// Sum of term(i) for i = 0 to count - 1, the same on all workers.
template <class Team, class Term>
WEFT_HD double sum_of(Team& team, Index count, const Term& term) {
  double sum = 0;
  for (Index i = team.rank(); i < count; i += team.size()) sum += term(i);
  return team.sum(sum);
}

/// The same for terms that are vectors.
template <class Team, class Term>
WEFT_HD Vec3<double> vector_sum_of(Team& team, Index count, const Term& term) {
  Vec3<double> sum{};
  for (Index i = team.rank(); i < count; i += team.size()) sum += term(i);
  for (int c = 0; c < 3; ++c) sum[c] = team.sum(sum[c]);
  return sum;
}

/// Calls put(i, sum) for i = 0 to count - 1 with the sum of what part(i, first, stride) has of it:
/// every stride-th term from the first on. What put writes is visible after it.
template <class Team, class Part, class Put>
WEFT_HD void gather_each(Team& team, Index count, const Part& part, const Put& put) {
  constexpr Index lanes = Team::lanes;
  const Index lane = team.rank() % lanes;
  for (Index i = team.rank() / lanes; i < count; i += team.size() / lanes) {
    Vec3<double> sum = part(i, lane, lanes);
    if constexpr (lanes > 1) sum = team.sum_of_lanes(sum);
    if (lane == 0) put(i, sum);
  }
  team.sync();
}

/// Largest term(i), at least 0, for i = 0 to count - 1.
template <class Team, class Term>
WEFT_HD double largest_of(Team& team, Index count, const Term& term) {
  double largest = 0;
  for (Index i = team.rank(); i < count; i += team.size()) {
    const double value = term(i);
    if (largest < value) largest = value;
  }
  return team.largest(largest);
}

/// Least term(i), at most `bound`, for i = 0 to count - 1.
template <class Team, class Term>
WEFT_HD double least_of(Team& team, Index count, double bound, const Term& term) {
  double least = bound;
  for (Index i = team.rank(); i < count; i += team.size()) {
    const double value = term(i);
    if (value < least) least = value;
  }
  return -team.largest(-least);
}

/// Whether test(i) holds for some i = 0 to count - 1.
template <class Team, class Test>
WEFT_HD bool any_of(Team& team, Index count, const Test& test) {
  bool found = false;
  for (Index i = team.rank(); i < count && !found; i += team.size()) found = test(i);
  return team.any(found);
}

/// Calls body(i) for i = 0 to count - 1, each on one worker. What it writes is visible after it.
/// @return whether one of the calls said so
template <class Team, class Body>
WEFT_HD bool any_of_each(Team& team, Index count, const Body& body) {
  bool found = false;
  for (Index i = team.rank(); i < count; i += team.size()) found = body(i) || found;
  return team.any(found);
}

/// The worker's share of 0 to count - 1 where what it does depends on what comes before.
struct Run {
  Index begin, end;
};
template <class Team>
WEFT_HD Run run_of(const Team& team, Index count) {
  const Index length = (count + team.size() - 1) / team.size();
  const Index begin = count < team.rank() * length ? count : team.rank() * length;
  return {begin, count - begin < length ? count : begin + length};
}

/// Lists in `out`, ascending, for which of 0 to count - 1 test(i) holds.
/// @return how many
template <class Team, class Test>
WEFT_HD Index list_where(Team& team, Index count, const Test& test, Index* out) {
  const Run run = run_of(team, count);
  Index found = 0;
  for (Index i = run.begin; i < run.end; ++i) found += test(i) ? 1 : 0;
  Index total;
  Index place = team.before(found, total);
  for (Index i = run.begin; i < run.end; ++i)
    if (test(i)) out[place++] = i;
  team.sync();
  return total;
}

/// Sorts by a bitonic network (Batcher 1968), in the form whose merges begin with a reflection: all
/// exchanges put the lesser key first, so that no power of two is asked for.
/// @param keys [count] visible to all workers
template <class Team>
WEFT_HD_CALL void sort_bitonic(Team& team, Offset* keys, Index count) {
  for (Offset width = 2; width / 2 < count; width *= 2)
    for (Offset step = width / 2; step > 0; step /= 2) {
      // Pairs of a merge that starts: i and its mirror image; after that: i and i + step.
      const bool mirrored = step == width / 2;
      for (Offset n = team.rank(); n < count; n += team.size()) {
        const Offset inside = n & (step - 1);
        const Offset first = 2 * (n - inside) + inside;
        const Offset second = first + (mirrored ? 2 * (step - inside) - 1 : step);
        if (second >= count || keys[first] <= keys[second]) continue;
        const Offset lesser = keys[second];
        keys[second] = keys[first];
        keys[first] = lesser;
      }
      team.sync();
    }
}

}  // namespace weft
