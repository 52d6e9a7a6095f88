#include "host/implicit/tracking/tracking.hpp"

#include "weft/core/at.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace weft {
namespace {

using Sparse = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

/// A row that the others imply, up to this share of what it is made of, adds nothing but rounding.
constexpr double pivot_min = 1e-10;

std::size_t at(Offset i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

TrackedSystem::TrackedSystem(const Model& model, const Tracking& tracking)
    : model_(model), tracking_(tracking) {}

void TrackedSystem::aim(double time, const std::vector<unsigned char>& fixed) {
  const auto cloth = static_cast<std::ptrdiff_t>(model_.cloth_vertex_count);
  std::vector<unsigned char> counts;
  for (const double from : tracking_.free_from) counts.push_back(time >= from ? 1 : 0);
  if (counts != counts_ || offset_.empty() ||
      !std::equal(fixed.begin(), fixed.begin() + cloth, fixed_.begin(), fixed_.end())) {
    counts_ = counts;
    fixed_.assign(fixed.begin(), fixed.begin() + cloth);
    choose_rows(time, fixed);
    while (!factorise()) {
    }
  }
  const std::vector<Vec3<double>> by_input = tracking_.target(time);
  std::vector<Vec3<double>> places(at(model_.cloth_vertex_count));
  for (std::size_t v = 0; v < places.size(); ++v) places[v] = by_input[at(model_.to_input[v])];
  aim_.clear();
  for (std::size_t i = 0; i + 1 < offset_.size(); ++i) aim_.push_back(sum_of(i, places));
}

/// Rows in internal numbers, without those of pinned places.
void TrackedSystem::choose_rows(double time, const std::vector<unsigned char>& fixed) {
  offset_ = {0};
  vertex_.clear();
  weight_.clear();
  total_.clear();
  mass_inv_.assign(model_.mass.size(), 0);
  for (std::size_t v = 0; v < mass_inv_.size(); ++v)
    if (fixed[v] == 0) mass_inv_[v] = 1 / model_.mass[v];
  for (std::size_t i = 0; i + 1 < tracking_.offset.size(); ++i) {
    if (time < tracking_.free_from[i]) continue;
    double total = 0, prescribed = 0;
    for (auto e = at(tracking_.offset[i]); e < at(tracking_.offset[i + 1]); ++e) {
      total += tracking_.weight[e];
      if (fixed[at(model_.to_internal[at(tracking_.input[e])])] != 0)
        prescribed += tracking_.weight[e];
    }
    if (!(prescribed <= tracked_prescribed_max * total) || !(total > 0)) continue;
    for (auto e = at(tracking_.offset[i]); e < at(tracking_.offset[i + 1]); ++e) {
      vertex_.push_back(model_.to_internal[at(tracking_.input[e])]);
      weight_.push_back(tracking_.weight[e]);
    }
    offset_.push_back(static_cast<Offset>(vertex_.size()));
    total_.push_back(total);
  }
}

/// Factors S = C M^-1 C^T over free vertices.
/// @return false if it drops a row that the others imply, and is to be called again
bool TrackedSystem::factorise() {
  const auto count = static_cast<int>(offset_.size()) - 1;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < count; ++i)
    for (auto e = at(offset_[at(i)]); e < at(offset_[at(i + 1)]); ++e)
      if (const double inverse = mass_inv_[at(vertex_[e])]; inverse > 0)
        entries.emplace_back(i, vertex_[e], weight_[e] * std::sqrt(inverse));
  Sparse c(count, static_cast<int>(mass_inv_.size()));
  c.setFromTriplets(entries.begin(), entries.end());
  const Sparse s = c * Sparse(c.transpose());
  const Eigen::SimplicialLDLT<Sparse> ldlt(s);
  const Eigen::VectorXd d = ldlt.vectorD();
  order_.assign(at(count), 0);
  for (int i = 0; i < count; ++i) order_[at(ldlt.permutationP().indices()[i])] = i;
  for (int n = 0; n < count; ++n) {
    const Index row = order_[at(n)];
    if (d[n] > pivot_min * s.coeff(row, row)) continue;
    const auto first = static_cast<std::ptrdiff_t>(offset_[at(row)]);
    const auto last = static_cast<std::ptrdiff_t>(offset_[at(row) + 1]);
    vertex_.erase(vertex_.begin() + first, vertex_.begin() + last);
    weight_.erase(weight_.begin() + first, weight_.begin() + last);
    total_.erase(total_.begin() + row);
    for (auto i = at(row) + 1; i < offset_.size(); ++i)
      offset_[i] -= static_cast<Offset>(last - first);
    offset_.erase(offset_.begin() + row + 1);
    return false;
  }
  column_ = {0};
  factor_row_.clear();
  factor_.clear();
  pivot_.assign(d.data(), d.data() + count);
  const Sparse lower = ldlt.matrixL();
  for (int k = 0; k < count; ++k) {
    for (Sparse::InnerIterator it(lower, k); it; ++it) {
      if (it.row() <= k) continue;
      factor_row_.push_back(static_cast<Index>(it.row()));
      factor_.push_back(it.value());
    }
    column_.push_back(static_cast<Offset>(factor_.size()));
  }
  scratch_.assign(2 * at(count), {});
  return true;
}

template <class T>
Vec3<double> TrackedSystem::sum_of(std::size_t row, const std::vector<Vec3<T>>& x) const {
  Vec3<double> sum{};
  for (auto e = at(offset_[row]); e < at(offset_[row + 1]); ++e)
    sum += weight_[e] * vec_cast<double>(x[at(vertex_[e])]);
  return sum;
}

template <class T>
TrackedRows TrackedSystem::rows(const std::vector<Vec3<T>>& base, const std::vector<Vec3<T>>& v,
                                double h) {
  wanted_.clear();
  for (std::size_t i = 0; i < aim_.size(); ++i) {
    wanted_.push_back((1 / h) * (aim_[i] - sum_of(i, base)));
    if (!v.empty()) wanted_.back() -= sum_of(i, v);
  }
  return {static_cast<Index>(aim_.size()),
          offset_,
          vertex_,
          weight_,
          mass_inv_,
          order_,
          column_,
          factor_row_,
          factor_,
          pivot_,
          wanted_,
          scratch_};
}

template <class T>
double TrackedSystem::error(const std::vector<Vec3<T>>& positions) const {
  double most = 0;
  for (std::size_t i = 0; i < aim_.size(); ++i)
    most = std::max(most, length(sum_of(i, positions) - aim_[i]) / total_[i]);
  return most;
}

template TrackedRows TrackedSystem::rows(const std::vector<Vec3<float>>&,
                                         const std::vector<Vec3<float>>&, double);
template TrackedRows TrackedSystem::rows(const std::vector<Vec3<double>>&,
                                         const std::vector<Vec3<double>>&, double);
template double TrackedSystem::error(const std::vector<Vec3<float>>&) const;
template double TrackedSystem::error(const std::vector<Vec3<double>>&) const;

}  // namespace weft
