#include "host/implicit/contact/self_certificate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace weft {
namespace {

constexpr double gradient_rounding = 0x1p-45;
constexpr double distance_rounding = 64;
constexpr double thickness_share = 1.01;
constexpr double least_share = 0.01;
/// What a NaN is not below, nor anything that comes of an overflow.
constexpr double too_large = 1e100;
/// Pieces are compared all with all.
constexpr std::size_t components_max = 64;
/// So many triangles are looked at before asking whether it is in vain.
constexpr std::size_t chunk = 512;
/// Mean gradients that are compressed by more than this have no frame worth having.
constexpr double compression_max = 1e-3;

constexpr int width = 8;

double larger(double a, double b) {
  return a > b ? a : b;
}

/// Of the triangles of each lane so far.
struct Extremes {
  double least[width], change_sq[width] = {}, edge[width] = {}, motion[width] = {};
  double bad[width] = {};  ///< 1: something was not finite
  Extremes() { std::fill(least, least + width, std::numeric_limits<double>::infinity()); }
};

/// Triangles side by side, written so that compilers keep them in vector registers.
struct Simd {
  double e[2][3][width];     ///< [m] sides from corner 0
  double u[2][3][width];     ///< [m] their change
  double inverse[4][width];  ///< [1/m] as in DomainTriangle

  template <class T>
  void set(std::size_t k, const DomainTriangle& t, const Vec3<T>* x) {
    for (int c = 0; c < 3; ++c)
      for (int s = 0; s < 2; ++s)
        e[s][c][k] = static_cast<double>(x[t.v[s + 1]][c]) - static_cast<double>(x[t.v[0]][c]);
    for (int c = 0; c < 4; ++c) inverse[c][k] = t.inverse[c];
  }

  /// @param motion [m] raised to the largest component of corner 0's displacement; that of
  ///               the others differs by less than g times a side
  template <class T>
  void set(std::size_t k, const DomainTriangle& t, const Vec3<T>* x, const Vec3<T>* y,
           double& motion) {
    set(k, t, x);
    for (int c = 0; c < 3; ++c) {
      const double y0 = static_cast<double>(y[t.v[0]][c]);
      for (int s = 0; s < 2; ++s)
        u[s][c][k] = static_cast<double>(y[t.v[s + 1]][c]) - y0 - e[s][c][k];
      motion = larger(motion, std::fabs(y0 - static_cast<double>(x[t.v[0]][c])));
    }
  }

  /// The least eigenvalue of the symmetric part of A F.
  /// @param row [2] x Vec3, of A
  void add_least(const Vec3<double> row[2], Extremes& out) const {
    for (int k = 0; k < width; ++k) {
      double p[2][2];  // [side][row]
      for (int s = 0; s < 2; ++s)
        for (int r = 0; r < 2; ++r)
          p[s][r] = row[r][0] * e[s][0][k] + row[r][1] * e[s][1][k] + row[r][2] * e[s][2][k];
      const double b00 = p[0][0] * inverse[0][k] + p[1][0] * inverse[2][k];
      const double b01 = p[0][0] * inverse[1][k] + p[1][0] * inverse[3][k];
      const double b10 = p[0][1] * inverse[0][k] + p[1][1] * inverse[2][k];
      const double b11 = p[0][1] * inverse[1][k] + p[1][1] * inverse[3][k];
      const double half = 0.5 * (b00 - b11), off = 0.5 * (b01 + b10);
      const double value = 0.5 * (b00 + b11) - std::sqrt(half * half + off * off);
      out.least[k] = value < out.least[k] ? value : out.least[k];
      out.bad[k] = std::fabs(value) < too_large ? out.bad[k] : 1.0;
      for (int s = 0; s < 2; ++s)
        for (int c = 0; c < 3; ++c) out.edge[k] = larger(out.edge[k], std::fabs(e[s][c][k]));
    }
  }

  /// The square of the Frobenius norm of the gradient's change, no less than that of the norm.
  void add_change(Extremes& out) const {
    for (int k = 0; k < width; ++k) {
      double sum = 0;
      for (int c = 0; c < 3; ++c)
        for (int j = 0; j < 2; ++j) {
          const double entry = u[0][c][k] * inverse[j][k] + u[1][c][k] * inverse[2 + j][k];
          sum += entry * entry;
        }
      out.change_sq[k] = larger(sum, out.change_sq[k]);
      out.bad[k] = sum < too_large ? out.bad[k] : 1.0;
    }
  }
};

}  // namespace

template <class T>
SelfCertificate<T>::SelfCertificate(std::vector<PlanarDomain> domains, double thickness, int ranks)
    : domains_(std::move(domains)),
      thickness_(thickness),
      of_use_(!domains_.empty() && domains_.size() <= components_max),
      found_(static_cast<std::size_t>(ranks), std::vector<Found>(domains_.size())),
      frames_(static_cast<std::size_t>(ranks), std::vector<Frame>(domains_.size())),
      least_t0_(domains_.size()) {
  for (const PlanarDomain& d : domains_)
    of_use_ = of_use_ && thickness_share * thickness < d.least_gap;
}

/// The transpose of the rotation in the polar decomposition of the piece's mean gradient, which by
/// the divergence theorem is known from its sides.
template <class T>
typename SelfCertificate<T>::Frame SelfCertificate<T>::frame(const PlanarDomain& domain,
                                                             Span<const Vec3<T>> positions) const {
  const auto at = [&](Index v) { return vec_cast<double>(positions.data()[v]); };
  const Vec3<double> origin = at(domain.sides.front().v[0]);
  Vec3<double> mean[2]{};
  for (const DomainSide& side : domain.sides) {
    const Vec3<double> x = at(side.v[0]) + at(side.v[1]) - 2 * origin;
    for (int c = 0; c < 2; ++c) mean[c] += side.normal[c] * x;
  }
  const double a = dot(mean[0], mean[0]), b = dot(mean[0], mean[1]), d = dot(mean[1], mean[1]);
  const double root = std::sqrt(a * d - b * b);
  Frame f;
  f.good = root > compression_max * (a + d) && a + d < too_large;
  if (!f.good) return f;
  // mean * (mean^T mean)^(-1/2); the root of a 2x2 matrix G is (G + sqrt(det G)) / scale.
  const double scale = std::sqrt(a + d + 2 * root);
  const double share = (1 - 1e-9) / (scale * root);
  f.row[0] = share * ((d + root) * mean[0] - b * mean[1]);
  f.row[1] = share * ((a + root) * mean[1] - b * mean[0]);
  return f;
}

/// @tparam ToEnd looks at the gradient at the end alone; else at that at the start, and its change
template <class T>
template <bool ToEnd>
void SelfCertificate<T>::look_at(const PlanarDomain& domain, const Frame& frame,
                                 const Motion& motion, std::size_t begin, std::size_t end,
                                 Found& found) const {
  Simd lanes;
  Extremes all;
  for (std::size_t first = begin; first < end; first += width) {
    for (std::size_t k = 0; k < width; ++k) {
      const DomainTriangle& t = domain.triangles[std::min(first + k, end - 1)];
      if constexpr (ToEnd)
        lanes.set(k, t, motion.positions_t1.data());
      else
        lanes.set(k, t, motion.positions_t0.data(), motion.positions_t1.data(), all.motion[k]);
    }
    lanes.add_least(frame.row, all);
    if constexpr (!ToEnd) lanes.add_change(all);
  }
  for (int k = 0; k < width; ++k) {
    found.least = std::min(found.least, all.least[k]);
    found.change_sq = std::max(found.change_sq, all.change_sq[k]);
    found.edge = std::max(found.edge, all.edge[k]);
    found.motion = std::max(found.motion, all.motion[k]);
    found.finite = found.finite && all.bad[k] == 0;
  }
}

template <class T>
void SelfCertificate<T>::look_at_box(const PlanarDomain& domain, const Motion& motion,
                                     Found& found) const {
  const Span<const Vec3<T>> ends[2] = {motion.positions_t0, motion.positions_t1};
  for (int n = 0; n < 2; ++n) {
    found.low[n] = found.high[n] = vec_cast<double>(ends[n].data()[domain.vertices.front()]);
    for (const Index v : domain.vertices)
      for (int c = 0; c < 3; ++c) {
        const double at = static_cast<double>(ends[n].data()[v][c]);
        found.low[n][c] = std::min(found.low[n][c], at);
        found.high[n][c] = std::max(found.high[n][c], at);
      }
  }
}

/// A rank's share of all pieces.
template <class T>
void SelfCertificate<T>::look(int rank, const Motion& motion, bool to_end) {
  const std::size_t ranks = found_.size(), r = static_cast<std::size_t>(rank);
  for (std::size_t d = 0; d < domains_.size(); ++d) {
    const PlanarDomain& domain = domains_[d];
    Frame& at = frames_[r][d];
    if (!to_end) at = frame(domain, motion.positions_t0);
    Found& found = found_[r][d] = Found{};
    found.least = std::numeric_limits<double>::infinity();
    found.finite = at.good;
    if (domains_.size() > 1) look_at_box(domain, motion, found);
    const std::size_t count = domain.triangles.size();
    const std::size_t end = count * (r + 1) / ranks;
    // In vain once a triangle is turned too far: no certificate, whatever the others are.
    const double needed = thickness_share * thickness_ / domain.least_gap;
    for (std::size_t k = count * r / ranks; k < end && found.finite && found.least > needed;
         k += chunk) {
      if (to_end)
        look_at<true>(domain, at, motion, k, std::min(end, k + chunk), found);
      else
        look_at<false>(domain, at, motion, k, std::min(end, k + chunk), found);
    }
  }
}

/// What all ranks have found of a piece.
template <class T>
typename SelfCertificate<T>::Found SelfCertificate<T>::joined(std::size_t domain) const {
  Found all = found_.front()[domain];
  for (const std::vector<Found>& of_rank : found_) {
    const Found& found = of_rank[domain];
    all.least = std::min(all.least, found.least);
    all.change_sq = std::max(all.change_sq, found.change_sq);
    all.edge = std::max(all.edge, found.edge);
    all.motion = std::max(all.motion, found.motion);
    all.finite = all.finite && found.finite;
  }
  return all;
}

/// Whether along some axis each piece lies below or above each other one, at the start and at the
/// end.
template <class T>
bool SelfCertificate<T>::pieces_apart() const {
  const std::vector<Found>& all = found_.front();
  const double gap = thickness_share * thickness_;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      bool apart = false;
      for (int c = 0; c < 3; ++c)
        for (const auto& [a, b] : {std::pair(i, j), std::pair(j, i)})
          apart = apart || (all[a].low[0][c] - all[b].high[0][c] > gap &&
                            all[a].low[1][c] - all[b].high[1][c] > gap);
      if (!apart) return false;
    }
  return true;
}

template <class T>
bool SelfCertificate<T>::holds(const std::function<Motion(int)>& motion, const ForAll& for_all) {
  if (!of_use_) return false;
  for_all([&](int r) { look(r, motion(r), false); });
  constexpr double epsilon = static_cast<double>(std::numeric_limits<T>::epsilon());
  for (std::size_t d = 0; d < domains_.size(); ++d) {
    const Found found = joined(d);
    if (!found.finite) return false;
    const double rounding =
        gradient_rounding * (found.edge + found.motion) * domains_[d].largest_inverse;
    const double change = std::sqrt(found.change_sq) + rounding;
    const double least = found.least - rounding;
    const double needed =
        thickness_share * thickness_ + distance_rounding * epsilon * (found.edge + found.motion);
    if (!(least - change >= least_share && (least - change) * domains_[d].least_gap >= needed))
      return false;
    least_t0_[d] = least;
  }
  return pieces_apart();
}

template <class T>
bool SelfCertificate<T>::holds_to(const std::function<Motion(int)>& motion, const ForAll& for_all) {
  for_all([&](int r) { look(r, motion(r), true); });
  for (std::size_t d = 0; d < domains_.size(); ++d) {
    const Found found = joined(d);
    if (!found.finite) return false;
    const double least = std::min(
        least_t0_[d], found.least - gradient_rounding * found.edge * domains_[d].largest_inverse);
    if (!(least * domains_[d].least_gap >= thickness_share * thickness_ && least >= least_share))
      return false;
  }
  return pieces_apart();
}

template class SelfCertificate<float>;
template class SelfCertificate<double>;

}  // namespace weft
