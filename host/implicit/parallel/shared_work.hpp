#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "weft/report.hpp"

namespace weft {

/// A piece of work that ranks did side by side.
/// @param work [ranks] what each did; not empty
inline SharedWork shared_work(const std::vector<double>& work) {
  return {*std::max_element(work.begin(), work.end()),
          std::accumulate(work.begin(), work.end(), 0.0) / static_cast<double>(work.size())};
}

}  // namespace weft
