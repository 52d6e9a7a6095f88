#include "weft/kernels/solve/coarse_inverse.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"
#include "host/solve/coarse_matrix.hpp"

namespace weft {
namespace {

/// One domain of the level.
template <class T>
class UpperDomain {
 public:
  UpperDomain(const SolveUpper<T>& args, Index domain)
      : a_(args),
        domain_(domain),
        first_(domain * mode_domain),
        count_(std::min(mode_domain, args.levels.upper[args.level].aggregates - first_)),
        matrix_(mode_numbers * count_, mode_numbers * count_) {}

  void make() {
    matrix_.setZero();
    Index partials_each = 1;
    for (int k = 0; k < a_.level; ++k) partials_each *= mode_domain;
    const Index begin = first_ * partials_each;
    const Index end = std::min(a_.levels.upper[0].aggregates, (first_ + count_) * partials_each);
    for (Index partial = begin; partial < end; ++partial)
      add_strip(partial, partial / partials_each - first_);
    if (a_.level > 0) add_diagonal();
    mirror(matrix_);
    leave_diagonal();
    const std::size_t place = static_cast<std::size_t>(domain_) * mode_size * mode_size;
    T* out = a_.levels.upper[a_.level].inverse.data() + place;
    std::fill(out, out + mode_size * mode_size, T(0));
    invert_modes(matrix_, out, mode_size);
  }

 private:
  /// Adds a partial sum's strip to the rows of its aggregate, the n-th of the domain.
  void add_strip(Index partial, Index n) {
    const auto strips = static_cast<std::size_t>(a_.levels.upper_count);
    const double* strip = a_.strip.data() + (static_cast<std::size_t>(partial) * strips +
                                             static_cast<std::size_t>(a_.level)) *
                                                mode_numbers * mode_size;
    for (Index j = 0; j < mode_numbers * count_; ++j) {
      double sums[mode_numbers];
      for (int i = 0; i < mode_numbers; ++i) sums[i] = strip[i * mode_size + j];
      Index aggregate = partial;
      for (int k = 0; k < a_.level; ++k, aggregate /= mode_domain) {
        double larger[mode_numbers] = {};
        add_sums(a_.levels.upper[k].larger.data()[aggregate], sums, larger);
        std::copy(larger, larger + mode_numbers, sums);
      }
      for (int i = 0; i < mode_numbers; ++i) matrix_(mode_numbers * n + i, j) += sums[i];
    }
  }

  void add_diagonal() {
    for (Index n = 0; n < count_; ++n) {
      const double* from =
          a_.diagonal.data() + static_cast<std::size_t>(first_ + n) * mode_numbers * mode_numbers;
      for (int i = 0; i < mode_numbers; ++i)
        for (int j = 0; j < mode_numbers; ++j)
          matrix_(mode_numbers * n + i, mode_numbers * n + j) += from[i * mode_numbers + j];
    }
  }

  /// What the domain's matrix is on the aggregate of the next level.
  void leave_diagonal() const {
    if (a_.level + 1 == a_.levels.upper_count) return;
    double* out =
        a_.next_diagonal.data() + static_cast<std::size_t>(domain_) * mode_numbers * mode_numbers;
    std::fill(out, out + mode_numbers * mode_numbers, 0.0);
    const ModeStep<T>* larger = a_.levels.upper[a_.level].larger.data() + first_;
    const auto width = static_cast<std::size_t>(matrix_.cols());
    for (Index i = 0; i < count_; ++i)
      for (Index j = 0; j < count_; ++j)
        add_restricted(larger[i], larger[j],
                       matrix_.data() + mode_numbers * (static_cast<std::size_t>(i) * width +
                                                        static_cast<std::size_t>(j)),
                       width, out, mode_numbers);
  }

  const SolveUpper<T>& a_;
  Index domain_, first_, count_;
  ModeMatrix matrix_;
};

template <class T>
void make_level(const SolveUpper<T>& a) {
  for (Index d = 0; d < a.levels.upper[a.level].domains(); ++d) UpperDomain<T>(a, d).make();
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolveUpper<T>& args) {
  submit_host(queue, [args] { make_level(args); });
}

template void run(OnHost, Queue&, const SolveUpper<float>&);
template void run(OnHost, Queue&, const SolveUpper<double>&);

}  // namespace weft
