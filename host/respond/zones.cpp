#include "weft/kernels/respond/zones.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

#include "host/exec/host_device.hpp"
#include "weft/core/mat.hpp"

namespace weft {
namespace {

constexpr int sweeps_max = 400;
/// Sweeps after which a zone that is squeezed counts as one without a solution.
constexpr int squeezed_sweeps_max = 50;
/// A constraint counts as met once this share of its offset is restored; the continuous test asks
/// for less, so that a zone that has been solved stays solved.
constexpr double met_share = 0.8;
/// Mass of a prescribed vertex that yields, in units of the mean mass of its zone's free vertices.
constexpr double yielding_mass = 10;
/// What is prescribed squeezes a zone if distances within it change by more than this share of a
/// collision's offset: far above rounding, far below what cloth would notice.
constexpr double squeeze_share = 1e-3;
/// Most prescribed vertices of a zone that are looked at for that.
constexpr std::size_t squeeze_samples = 128;

template <class T>
class ZoneSolver {
 public:
  explicit ZoneSolver(const RespondZones<T>& args) : a_(args) {}

  void solve_all() {
    // Every pass that is not the last makes at least one more vertex yield.
    while (!pass()) {
    }
  }

 private:
  /// @return false if prescribed vertices have yielded: zones that share them are one zone then
  bool pass() {
    join();
    ZoneCounts counts{};
    bool yielded = false;
    std::vector<Index> zone;
    for (std::size_t i = 0; i < members_.size(); i += zone.size()) {
      const Index root = find(members_[i].first);
      zone.clear();
      bool fresh = false;
      for (std::size_t k = i; k < members_.size() && members_[k].first == root; ++k) {
        zone.push_back(members_[k].second);
        fresh = fresh || members_[k].second >= a_.first_new;
      }
      if (!fresh) continue;
      ++counts.zones;
      counts.largest = std::max(counts.largest, static_cast<Index>(zone.size()));
      collect(zone);
      const bool solved = a_.rigid ? move_rigidly() : move_apart(zone);
      if (!solved && squeezed(zone)) {
        yield();
        yielded = true;
      }
      if (yielded) continue;
      if (!solved) ++counts.unsolved;
      write(counts);
    }
    if (!yielded) a_.counts[0] = counts;
    return !yielded;
  }

  bool prescribed(Index v) const { return v >= a_.cloth_vertex_count || a_.fixed.data()[v] != 0; }
  bool heavy(Index v) const { return prescribed(v) && a_.yielding.data()[v] == 0; }

  /// Whether the zone's prescribed vertices that have not yielded move relative to each other.
  bool squeezed(const std::vector<Index>& zone) const {
    double offset = 0;
    for (const Index k : zone)
      offset = std::max(offset, a_.collisions[static_cast<std::size_t>(k)].offset);
    std::vector<std::size_t> held;
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      if (mass_inv_[i] == 0) held.push_back(i);
    const std::size_t stride = std::max<std::size_t>(1, held.size() / squeeze_samples);
    const auto before = [&](std::size_t i) {
      return vec_cast<double>(a_.positions_t0.data()[vertices_[i]]);
    };
    for (std::size_t i = 0; i < held.size(); i += stride)
      for (std::size_t j = i + stride; j < held.size(); j += stride)
        if (std::abs(length(x_[held[j]] - x_[held[i]]) -
                     length(before(held[j]) - before(held[i]))) > squeeze_share * offset)
          return true;
    return false;
  }

  void yield() {
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      if (mass_inv_[i] == 0) a_.yielding[static_cast<std::size_t>(vertices_[i])] = 1;
  }

  Index find(Index i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      Index& p = parent_[static_cast<std::size_t>(i)];
      p = parent_[static_cast<std::size_t>(p)];
      i = p;
    }
    return i;
  }

  /// Joins collisions that share a free vertex; members_ then lists (zone, collision) in order. A
  /// zone is named by its first collision.
  void join() {
    const auto n = static_cast<Index>(a_.collisions.size());
    parent_.resize(a_.collisions.size());
    std::iota(parent_.begin(), parent_.end(), 0);
    std::unordered_map<Index, Index> first_of_vertex;
    for (Index k = 0; k < n; ++k)
      for (const Index v : a_.collisions[static_cast<std::size_t>(k)].v) {
        if (heavy(v)) continue;
        const auto [place, inserted] = first_of_vertex.try_emplace(v, k);
        if (inserted) continue;
        const Index p = find(place->second);
        const Index q = find(k);
        parent_[static_cast<std::size_t>(std::max(p, q))] = std::min(p, q);
      }
    members_.clear();
    for (Index k = 0; k < n; ++k) members_.emplace_back(find(k), k);
    std::sort(members_.begin(), members_.end());
  }

  /// Local numbers and positions of the zone's vertices.
  void collect(const std::vector<Index>& zone) {
    vertices_.clear();
    for (const Index k : zone)
      for (const Index v : a_.collisions[static_cast<std::size_t>(k)].v) vertices_.push_back(v);
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    x_.resize(vertices_.size());
    mass_inv_.resize(vertices_.size());
    double mass = 0;
    int free = 0;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const Index v = vertices_[i];
      x_[i] = vec_cast<double>(a_.positions_free.data()[v]);
      mass_inv_[i] = prescribed(v) ? 0 : 1 / static_cast<double>(a_.mass.data()[v]);
      if (prescribed(v)) continue;
      mass += static_cast<double>(a_.mass.data()[v]);
      ++free;
    }
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      if (prescribed(vertices_[i]) && !heavy(vertices_[i]))
        mass_inv_[i] = free > 0 ? free / (yielding_mass * mass) : 1;
  }

  std::size_t local(Index v) const {
    return static_cast<std::size_t>(std::lower_bound(vertices_.begin(), vertices_.end(), v) -
                                    vertices_.begin());
  }

  bool move_apart(const std::vector<Index>& zone) {
    struct Constraint {
      std::size_t v[4];
      const Collision* c;
      double denominator;
      double multiplier;
    };
    std::vector<Constraint> constraints;
    bool solvable = true;
    for (const Index k : zone) {
      Constraint s{{}, &a_.collisions[static_cast<std::size_t>(k)], 0, 0};
      for (int j = 0; j < 4; ++j) {
        s.v[j] = local(s.c->v[j]);
        s.denominator += s.c->w[j] * s.c->w[j] * mass_inv_[s.v[j]];
      }
      if (s.denominator > 0)
        constraints.push_back(s);
      else
        solvable = false;
    }
    const int sweeps = squeezed(zone) ? squeezed_sweeps_max : sweeps_max;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      double worst = 0;
      for (Constraint& s : constraints) {
        double gap = 0;
        for (int j = 0; j < 4; ++j) gap += s.c->w[j] * dot(s.c->n, x_[s.v[j]]);
        worst = std::max(worst, (s.c->offset - gap) / s.c->offset);
        const double multiplier = std::max(0.0, s.multiplier + (s.c->offset - gap) / s.denominator);
        const double change = multiplier - s.multiplier;
        s.multiplier = multiplier;
        for (int j = 0; j < 4; ++j) x_[s.v[j]] += (s.c->w[j] * change * mass_inv_[s.v[j]]) * s.c->n;
      }
      if (worst <= 1 - met_share) return solvable;
    }
    return false;
  }

  /// Momentum of the free vertices, or the displacement of the prescribed ones if the zone has any.
  bool move_rigidly() {
    Vec3<double> prescribed{};
    int prescribed_count = 0;
    double mass = 0;
    Vec3<double> centre{};
    Vec3<double> shift{};
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const Vec3<double> x0 = vec_cast<double>(a_.positions_t0.data()[vertices_[i]]);
      const Vec3<double> u = x_[i] - x0;
      if (mass_inv_[i] == 0) {
        if (prescribed_count > 0 &&
            length(u - prescribed) > 1e-9 * (length(u) + length(prescribed)))
          return false;
        prescribed = u;
        ++prescribed_count;
        continue;
      }
      const double m = 1 / mass_inv_[i];
      mass += m;
      centre += m * x0;
      shift += m * u;
    }
    if (!(mass > 0)) return false;
    centre *= 1 / mass;
    shift *= 1 / mass;
    Vec3<double> spin{};
    if (prescribed_count > 0)
      shift = prescribed;
    else
      spin = rotation_of(centre, shift);
    const double angle = length(spin);
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (mass_inv_[i] == 0) continue;
      const Vec3<double> r = vec_cast<double>(a_.positions_t0.data()[vertices_[i]]) - centre;
      Vec3<double> turned = r;
      if (angle > 0) {
        const Vec3<double> axis = (1 / angle) * spin;
        turned = std::cos(angle) * r + std::sin(angle) * cross(axis, r) +
                 ((1 - std::cos(angle)) * dot(axis, r)) * axis;
      }
      x_[i] = centre + shift + turned;
    }
    return true;
  }

  /// Rotation vector over the step that keeps the zone's angular momentum about `centre`.
  Vec3<double> rotation_of(const Vec3<double>& centre, const Vec3<double>& shift) const {
    Vec3<double> momentum{};
    Mat3<double> inertia{};
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (mass_inv_[i] == 0) continue;
      const double m = 1 / mass_inv_[i];
      const Vec3<double> x0 = vec_cast<double>(a_.positions_t0.data()[vertices_[i]]);
      const Vec3<double> r = x0 - centre;
      momentum += m * cross(r, x_[i] - x0 - shift);
      inertia += m * (dot(r, r) * Mat3<double>::identity() - outer(r, r));
    }
    return inverse_symmetric(inertia) * momentum;
  }

  void write(ZoneCounts& counts) {
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      if (mass_inv_[i] != 0) {
        if (prescribed(vertices_[i])) ++counts.yielding;
        a_.moved[static_cast<std::size_t>(counts.moved++)] = {vertices_[i], vec_cast<T>(x_[i])};
      }
  }

  const RespondZones<T> a_;
  std::vector<Index> parent_;
  std::vector<std::pair<Index, Index>> members_;
  std::vector<Index> vertices_;
  std::vector<Vec3<double>> x_;
  std::vector<double> mass_inv_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const RespondZones<T>& args) {
  submit_host(queue, [args] { ZoneSolver<T>(args).solve_all(); });
}

template void run(OnHost, Queue&, const RespondZones<float>&);
template void run(OnHost, Queue&, const RespondZones<double>&);

}  // namespace weft
