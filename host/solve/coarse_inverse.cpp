#include "weft/kernels/solve/coarse_inverse.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"
#include "host/solve/coarse_matrix.hpp"

namespace weft {
namespace {

/// One domain of the level.
template <class T>
class CoarseInverseDomain {
 public:
  CoarseInverseDomain(const SolveCoarseInverse<T>& args, Index domain)
      : a_(args),
        domain_(domain),
        first_(domain * coarse_domain),
        count_(std::min(coarse_domain, args.levels.upper[args.level].aggregates - first_)),
        matrix_(coarse_dofs * count_, coarse_dofs * count_) {}

  void make() {
    matrix_.setZero();
    Index partials_each = 1;
    for (int k = 0; k < a_.level; ++k) partials_each *= coarse_domain;
    const Index begin = first_ * partials_each;
    const Index end = std::min(a_.levels.upper[0].aggregates, (first_ + count_) * partials_each);
    for (Index partial = begin; partial < end; ++partial)
      add_strip(partial, partial / partials_each - first_);
    if (a_.level > 0) add_diagonal();
    mirror(matrix_);
    leave_diagonal();
    const std::size_t place =
        static_cast<std::size_t>(domain_) * coarse_domain_dofs * coarse_domain_dofs;
    T* out = a_.levels.upper[a_.level].inverse.data() + place;
    std::fill(out, out + coarse_domain_dofs * coarse_domain_dofs, T(0));
    invert_coarse(matrix_, out, coarse_domain_dofs);
  }

 private:
  /// Adds a reduction block's strip to the rows of its aggregate, the n-th of the domain.
  void add_strip(Index partial, Index n) {
    const auto strips = static_cast<std::size_t>(a_.levels.upper_count);
    const double* strip = a_.strip.data() + (static_cast<std::size_t>(partial) * strips +
                                             static_cast<std::size_t>(a_.level)) *
                                                coarse_dofs * coarse_domain_dofs;
    for (Index j = 0; j < coarse_dofs * count_; ++j) {
      double sums[coarse_dofs];
      for (int i = 0; i < coarse_dofs; ++i) sums[i] = strip[i * coarse_domain_dofs + j];
      Index aggregate = partial;
      for (int k = 0; k < a_.level; ++k, aggregate /= coarse_domain) {
        double larger[coarse_dofs] = {};
        add_sums(a_.levels.upper[k].larger.data()[aggregate], sums, larger);
        std::copy(larger, larger + coarse_dofs, sums);
      }
      for (int i = 0; i < coarse_dofs; ++i) matrix_(coarse_dofs * n + i, j) += sums[i];
    }
  }

  void add_diagonal() {
    for (Index n = 0; n < count_; ++n) {
      const double* from =
          a_.diagonal.data() + static_cast<std::size_t>(first_ + n) * coarse_dofs * coarse_dofs;
      for (int i = 0; i < coarse_dofs; ++i)
        for (int j = 0; j < coarse_dofs; ++j)
          matrix_(coarse_dofs * n + i, coarse_dofs * n + j) += from[i * coarse_dofs + j];
    }
  }

  /// What the domain's matrix is on the aggregate of the next level.
  void leave_diagonal() const {
    if (a_.level + 1 == a_.levels.upper_count) return;
    double* out =
        a_.next_diagonal.data() + static_cast<std::size_t>(domain_) * coarse_dofs * coarse_dofs;
    std::fill(out, out + coarse_dofs * coarse_dofs, 0.0);
    const CoarseBasisStep<T>* larger = a_.levels.upper[a_.level].larger.data() + first_;
    const auto width = static_cast<std::size_t>(matrix_.cols());
    for (Index i = 0; i < count_; ++i)
      for (Index j = 0; j < count_; ++j)
        add_restricted(larger[i], larger[j],
                       matrix_.data() + coarse_dofs * (static_cast<std::size_t>(i) * width +
                                                       static_cast<std::size_t>(j)),
                       width, out, coarse_dofs);
  }

  const SolveCoarseInverse<T>& a_;
  Index domain_, first_, count_;
  CoarseMatrix matrix_;
};

template <class T>
void make_level(const SolveCoarseInverse<T>& a) {
  for (Index d = 0; d < a.levels.upper[a.level].domains(); ++d) CoarseInverseDomain<T>(a, d).make();
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolveCoarseInverse<T>& args) {
  submit_host(queue, [args] { make_level(args); });
}

template void run(OnHost, Queue&, const SolveCoarseInverse<float>&);
template void run(OnHost, Queue&, const SolveCoarseInverse<double>&);

}  // namespace weft
