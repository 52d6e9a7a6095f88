#pragma once

#include <vector>

namespace weft {

/// What a rank receives in one stage: the sub-vector of rank `vector`, copied from rank `from`.
struct Transfer {
  int from = -1;  ///< -1: nothing in this stage
  int vector = -1;

  bool any() const { return from >= 0; }
};

/// What each rank receives, stage by stage, until it has the sub-vectors of all ranks: P-Cloth
/// section 3.1.2. Ranks are the leaves of a binary tree of switches. Both halves of a switch's
/// ranks first go by the queues of their own switch; then each rank takes the vector of its
/// counterpart in the other half, so that one half has all of the other's vectors; then both halves
/// go by their own queues again, with the other half's vectors. Numbers of ranks that are no powers
/// of two: the queues of the next one, without the vectors of ranks that are not there; where such
/// a rank is the source, the owner of the vector takes its place. Whoever has to send something in
/// a stage received it in an earlier one, or owns it.
/// @param ranks > 0
/// @return      [ranks][stages], the same number of stages for all
std::vector<std::vector<Transfer>> work_queues(int ranks);

/// In which stage, from 1, a rank receives the sub-vector of each rank; 0: its own.
/// @param queue of `rank`
/// @return      [ranks]
std::vector<unsigned char> arrival_stages(const std::vector<Transfer>& queue, int rank, int ranks);

}  // namespace weft
