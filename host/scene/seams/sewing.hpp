#pragma once

#include <optional>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Two vertices that a seam joins, in input numbers over all cloths of the scene.
struct SeamPair {
  Index v[2];
  double weld_distance;  ///< [m] 0: never welded
};

/// Pairs of all seams, in the order of the scene.
std::vector<SeamPair> seam_pairs(const Scene& scene);

/// How far a scene has been sewn. It is all that a topology needs beside the scene as it was read.
struct Sewing {
  std::vector<unsigned char> welded;  ///< [seam_pairs of the scene as read] 1: one vertex
  bool refined = false;
  /// [as welded, or empty: none] 1: could not be welded since the last frame, because something was
  /// hit, and is not tried before the end of this one
  std::vector<unsigned char> refused;
  /// [seams of the scene as read] [s] since when all pairs are closed, see SeamState; none: some
  /// are open
  std::vector<std::optional<double>> closed_at;

  bool complete() const;  ///< there are pairs, and all of them are welded
  friend bool operator==(const Sewing&, const Sewing&) = default;
};

/// Pairs that are as close at the start as their seam welds.
Sewing sewing_at_start(const Scene& scene);

/// First input number of each cloth over all cloths, and how many there are. [cloths + 1]
std::vector<Index> input_offsets(const Scene& scene);

/// Which vertices are one: for each input number the lowest of those that it is one with.
/// @param welded [seam_pairs] as in Sewing; empty: none
std::vector<Index> joined_inputs(const Scene& scene, const std::vector<unsigned char>& welded);

/// Gives the first of those that are one vertex the mean of them all.
/// @param joined see joined_inputs()   @param values [inputs]
void average_joined(const std::vector<Index>& joined, std::vector<Vec3<double>>& values);

/// Makes groups of `count` numbers that `pairs` join, directly or by way of others.
/// @return [count] the lowest number of each one's group
std::vector<Index> grouped(std::size_t count, const std::vector<SeamPair>& pairs);

}  // namespace weft
