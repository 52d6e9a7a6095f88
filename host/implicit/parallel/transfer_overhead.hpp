#pragma once

#include <vector>

namespace weft {

/// Times of one rank's product with a vector that is spread over n ranks, in the order in which its
/// sub-vectors are multiplied; the own one is first (P-Cloth section 3.1.1).
struct ProductTimes {
  std::vector<double> compute;   ///< [n]     [s] C_i: the columns of sub-vector i times it
  std::vector<double> transfer;  ///< [n - 1] [s] T_i: receiving sub-vector i, from the second on
};

// All of these give S_i [s]: when the product with sub-vector i is done, by i; the last one is the
// time of the whole product.

/// All transfers, then all products.
///   S_i = sum_{j=1..i} T_j + sum_{j=0..i} C_j
/// @pre transfer.size() + 1 == compute.size()
/// @cite P-Cloth eq. (6)
std::vector<double> gathered_times(const ProductTimes& times);

/// Products while later sub-vectors are under way.
///   S_0 = C_0,  S_i = max(S_{i-1}, sum_{j=1..i} T_j) + C_i
/// @pre transfer.size() + 1 == compute.size()
/// @cite P-Cloth eq. (7)
std::vector<double> pipelined_times(const ProductTimes& times);

}  // namespace weft
