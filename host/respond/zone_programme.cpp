#include "host/respond/zone_programme.hpp"

#include <algorithm>
#include <cmath>

#include "weft/elements/contact.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft {
namespace {

/// Sweeps before conjugate gradients are tried: most zones are small and need fewer.
constexpr int sweeps_at_first = 30;
/// Most sweeps where conjugate gradients are of no use.
constexpr int sweeps_alone_max = 400;
/// Sweeps after that between two steps on a face, which find the next face.
constexpr int sweeps_between = 6;
/// Share of the tolerance down to which conjugate gradients bring the residual.
constexpr double face_accuracy = 0.1;
/// Curvature, over that of the diagonal alone, under which a direction counts as flat.
constexpr double flat = 1e-13;

}  // namespace

void ZoneProgramme::clear(const std::vector<double>& mass_inv) {
  mass_inv_ = mass_inv;
  constraints_.clear();
  u_.assign(mass_inv.size(), {});
  solvable_ = true;
  passes_ = 0;
  reach_ = 1;
}

void ZoneProgramme::add(const std::size_t v[4], const Collision& c,
                        const std::vector<Vec3<double>>& x_free) {
  Constraint k{{v[0], v[1], v[2], v[3]}, {c.w[0], c.w[1], c.w[2], c.w[3]}, c.n, 0, 0, 0, 0};
  Vec3<double> x[4];
  for (int j = 0; j < 4; ++j) {
    x[j] = x_free[v[j]];
    k.diagonal += c.w[j] * c.w[j] * mass_inv_[v[j]];
  }
  k.diagonal *= length_sq(c.n);
  k.wanted = c.offset - contact_gap(c.n, x, c.w);
  k.tolerance = (1 - zone_met_share) * c.offset;
  if (k.diagonal > 0)
    constraints_.push_back(k);
  else
    solvable_ = false;
}

double ZoneProgramme::gap(const Constraint& c, const std::vector<Vec3<double>>& u) const {
  double sum = 0;
  for (int j = 0; j < 4; ++j) sum += c.w[j] * dot(c.n, u[c.v[j]]);
  return sum;
}

void ZoneProgramme::push(const Constraint& c, double multiplier,
                         std::vector<Vec3<double>>& u) const {
  for (int j = 0; j < 4; ++j) u[c.v[j]] += (c.w[j] * multiplier * mass_inv_[c.v[j]]) * c.n;
}

/// Sets each multiplier in turn to what its own constraint asks, given the others.
/// @return whether every constraint was met when its turn came
bool ZoneProgramme::sweep(bool forwards) {
  bool all_met = true;
  for (std::size_t i = 0; i < constraints_.size(); ++i) {
    Constraint& c = constraints_[forwards ? i : constraints_.size() - 1 - i];
    const double missing = c.wanted - gap(c, u_);
    all_met = all_met && missing <= c.tolerance;
    const double multiplier = std::max(0.0, c.multiplier + missing / c.diagonal);
    push(c, multiplier - c.multiplier, u_);
    c.multiplier = multiplier;
  }
  ++passes_;
  return all_met;
}

/// Whether all constraints are met at once.
bool ZoneProgramme::met() {
  ++passes_;
  return std::all_of(constraints_.begin(), constraints_.end(),
                     [this](const Constraint& c) { return c.wanted - gap(c, u_) <= c.tolerance; });
}

bool ZoneProgramme::climb(int passes_max, double dual_max) {
  const auto movable = std::count_if(mass_inv_.begin(), mass_inv_.end(),
                                     [](double mass_inv) { return mass_inv > 0; });
  // More constraints than coordinates cannot all hold with equality.
  const bool faces = constraints_.size() <= 3 * static_cast<std::size_t>(movable);
  if (!faces) passes_max = std::min(passes_max, sweeps_alone_max);
  int sweeps = faces ? sweeps_at_first : sweeps_alone_max;
  while (passes_ < passes_max) {
    for (int k = 0; k < sweeps && passes_ < passes_max; ++k)
      if (sweep(k % 2 == 0) && met()) return solvable_;
    if (!faces || passes_ >= passes_max || dual_now() > dual_max) return false;
    if (step_ahead(passes_max)) {
      reach_ *= 2;
    } else {
      step_on_face(passes_max);
      reach_ = 1;
    }
    sweeps = sweeps_between;
  }
  return false;
}

/// The greatest residual of the face over its constraint's tolerance.
double ZoneProgramme::largest_share() const {
  double largest = 0;
  for (std::size_t i = 0; i < face_.size(); ++i)
    largest = std::max(largest, std::abs(residual_[i]) / constraints_[face_[i]].tolerance);
  return largest;
}

/// Conjugate gradients, preconditioned with the diagonal, for the change of the face's multipliers
/// that would meet their constraints exactly. Where they stop early - at the bound, or in a
/// direction without curvature, which redundant constraints have - the dual has risen all the same.
void ZoneProgramme::find_direction(int passes_max) {
  direction_.assign(face_.size(), 0);
  search_.assign(face_.size(), 0);
  residual_.resize(face_.size());
  product_.resize(face_.size());
  for (std::size_t i = 0; i < face_.size(); ++i) {
    const Constraint& c = constraints_[face_[i]];
    residual_[i] = c.wanted - gap(c, u_);
  }
  double before = 0;
  for (std::size_t step = 0; step < 2 * face_.size() && passes_ < passes_max; ++step, ++passes_) {
    if (largest_share() <= face_accuracy) return;
    double along = 0;
    for (std::size_t i = 0; i < face_.size(); ++i)
      along += residual_[i] * residual_[i] / constraints_[face_[i]].diagonal;
    scratch_.assign(mass_inv_.size(), {});
    double scale = 0;
    for (std::size_t i = 0; i < face_.size(); ++i) {
      const Constraint& c = constraints_[face_[i]];
      search_[i] = residual_[i] / c.diagonal + (step == 0 ? 0 : along / before) * search_[i];
      scale += search_[i] * search_[i] * c.diagonal;
      push(c, search_[i], scratch_);
    }
    double curvature = 0;
    for (std::size_t i = 0; i < face_.size(); ++i) {
      product_[i] = gap(constraints_[face_[i]], scratch_);
      curvature += search_[i] * product_[i];
    }
    if (!(curvature > flat * scale)) return;
    for (std::size_t i = 0; i < face_.size(); ++i) {
      direction_[i] += along / curvature * search_[i];
      residual_[i] -= along / curvature * product_[i];
    }
    before = along;
  }
}

/// The constraints whose multiplier is above zero, and those that `reach` links of shared vertices
/// join to them.
void ZoneProgramme::find_face(std::size_t reach) {
  on_face_.assign(constraints_.size(), 0);
  for (std::size_t i = 0; i < constraints_.size(); ++i)
    on_face_[i] = constraints_[i].multiplier > 0 ? 1 : 0;
  bool grows = true;
  for (std::size_t link = 0; link < reach && grows; ++link) {
    touched_.assign(mass_inv_.size(), 0);
    for (std::size_t i = 0; i < constraints_.size(); ++i)
      if (on_face_[i] != 0)
        for (const std::size_t v : constraints_[i].v) touched_[v] = 1;
    grows = false;
    for (std::size_t i = 0; i < constraints_.size(); ++i) {
      const auto touches = [this](std::size_t v) { return touched_[v] != 0 && mass_inv_[v] > 0; };
      if (on_face_[i] != 0 || std::none_of(constraints_[i].v, constraints_[i].v + 4, touches))
        continue;
      on_face_[i] = 1;
      grows = true;
    }
  }
  face_.clear();
  for (std::size_t i = 0; i < constraints_.size(); ++i)
    if (on_face_[i] != 0) face_.push_back(i);
}

/// A push travels along a chain of impacts by few links a sweep. A step on a face that takes in
/// what lies ahead of it, and drops what turns out to pull, gets there in a logarithm of them.
/// @return whether the dual has risen
bool ZoneProgramme::step_ahead(int passes_max) {
  const double before = dual_now();
  find_face(reach_);
  find_direction(passes_max);
  projected_.assign(constraints_.size(), 0);
  for (std::size_t i = 0; i < face_.size(); ++i)
    projected_[face_[i]] = std::max(0.0, constraints_[face_[i]].multiplier + direction_[i]);
  if (!(dual(projected_) > before)) return false;
  take(projected_);
  return true;
}

/// Goes to where the constraints of the face would all be met, or as far as the multipliers stay
/// above zero, or where those that do not are set to zero: whatever brings the dual highest.
void ZoneProgramme::step_on_face(int passes_max) {
  find_face(0);
  find_direction(passes_max);
  double share = 1;
  for (std::size_t i = 0; i < face_.size(); ++i)
    if (direction_[i] < 0)
      share = std::min(share, constraints_[face_[i]].multiplier / -direction_[i]);
  cut_.assign(constraints_.size(), 0);
  projected_.assign(constraints_.size(), 0);
  for (std::size_t i = 0; i < face_.size(); ++i) {
    const double multiplier = constraints_[face_[i]].multiplier;
    cut_[face_[i]] = std::max(0.0, multiplier + share * direction_[i]);
    projected_[face_[i]] = std::max(0.0, multiplier + direction_[i]);
  }
  take(share < 1 && dual(projected_) > dual(cut_) ? projected_ : cut_);
}

/// The dual at the multipliers as they stand.
double ZoneProgramme::dual_now() const {
  double sum = 0;
  for (const Constraint& c : constraints_) sum += c.multiplier * c.wanted;
  return sum - energy(u_);
}

/// 1/2 |u|^2 in the norm of the masses.
double ZoneProgramme::energy(const std::vector<Vec3<double>>& u) const {
  double sum = 0;
  for (std::size_t i = 0; i < mass_inv_.size(); ++i)
    if (mass_inv_[i] > 0) sum += 0.5 * length_sq(u[i]) / mass_inv_[i];
  return sum;
}

double ZoneProgramme::dual(const std::vector<double>& multipliers) {
  scratch_.assign(mass_inv_.size(), {});
  double sum = 0;
  for (std::size_t i = 0; i < constraints_.size(); ++i) {
    sum += multipliers[i] * constraints_[i].wanted;
    push(constraints_[i], multipliers[i], scratch_);
  }
  ++passes_;
  return sum - energy(scratch_);
}

void ZoneProgramme::take(const std::vector<double>& multipliers) {
  u_.assign(mass_inv_.size(), {});
  for (std::size_t i = 0; i < constraints_.size(); ++i) {
    constraints_[i].multiplier = multipliers[i];
    push(constraints_[i], multipliers[i], u_);
  }
}

}  // namespace weft
