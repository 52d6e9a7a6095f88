#include "weft/kernels/respond/zones.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "host/exec/host_device.hpp"
#include "host/respond/zone_programme.hpp"
#include "weft/core/mat.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

/// Mass of a prescribed vertex that yields, in units of the mean mass of its zone's free vertices.
constexpr double yielding_mass = 10;
/// What is prescribed squeezes a zone if distances within it change by more than this share of a
/// collision's offset: far above rounding, far below what cloth would notice.
constexpr double squeeze_share = 1e-3;
/// Most prescribed vertices of a zone that are looked at for that.
constexpr std::size_t squeeze_samples = 128;
/// Share of the distance at the start that planes keep at least.
constexpr double plane_share = 0.9;
/// Prescribed displacements that differ by more than this share of them are no rigid motion.
constexpr double same_displacement = 1e-9;

template <class T>
class ZoneSolver {
 public:
  explicit ZoneSolver(const RespondZones<T>& args) : a_(args) {}

  void solve(std::size_t number) {
    const auto begin = static_cast<std::size_t>(a_.zone_begin[number]);
    const auto end = static_cast<std::size_t>(a_.zone_begin[number + 1]);
    zone_ = a_.collisions.subspan(begin, end - begin);
    collect();
    ZoneOutcome outcome;
    outcome.squeezed = squeezed() ? 1 : 0;
    outcome.free = is_free() ? 1 : 0;
    const bool solved = move(outcome);
    outcome.solved = solved ? 1 : 0;
    // A zone that cannot move as a body stays as the rounds before have left it.
    const bool write = solved || a_.motion != ZoneMotion::rigid;
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      if (write && mass_inv_[i] != 0)
        a_.moved[4 * begin + static_cast<std::size_t>(outcome.moved++)] = {vertices_[i],
                                                                           vec_cast<T>(x_[i])};
    a_.outcomes[number] = outcome;
  }

 private:
  bool prescribed(Index v) const { return v >= a_.cloth_vertex_count || a_.fixed.data()[v] != 0; }
  bool heavy(Index v) const { return prescribed(v) && a_.yielding.data()[v] == 0; }

  /// Local numbers, positions and masses of the zone's vertices.
  void collect() {
    vertices_.clear();
    for (const Collision& c : zone_)
      for (const Index v : c.v) vertices_.push_back(v);
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

  /// Whether the zone's prescribed vertices that do not yield move relative to each other.
  bool squeezed() const {
    double offset = 0;
    for (const Collision& c : zone_) offset = std::max(offset, c.offset);
    std::vector<std::size_t> held;
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      if (mass_inv_[i] == 0) held.push_back(i);
    const std::size_t stride = std::max<std::size_t>(1, held.size() / squeeze_samples);
    for (std::size_t i = 0; i < held.size(); i += stride)
      for (std::size_t j = i + stride; j < held.size(); j += stride)
        if (std::abs(length(x_[held[j]] - x_[held[i]]) - length(start(held[j]) - start(held[i]))) >
            squeeze_share * offset)
          return true;
    return false;
  }

  Vec3<double> start(std::size_t i) const {
    return vec_cast<double>(a_.positions_t0.data()[vertices_[i]]);
  }

  /// Whether nothing in the zone is prescribed.
  bool is_free() const {
    return std::none_of(vertices_.begin(), vertices_.end(),
                        [this](Index v) { return prescribed(v); });
  }

  bool move(ZoneOutcome& outcome) {
    if (a_.motion == ZoneMotion::rigid) return move_rigidly();
    const bool solved = move_apart(a_.motion == ZoneMotion::planes, outcome);
    if (solved || a_.motion == ZoneMotion::planes || outcome.free == 0) return solved;
    const std::vector<Vec3<double>> nearly = x_;
    if (move_apart(true, outcome)) return true;
    x_ = nearly;
    outcome.planes = 0;
    return false;
  }

  /// @param planes keep the planes of the start, see ZoneMotion
  bool move_apart(bool planes, ZoneOutcome& outcome) {
    for (std::size_t i = 0; i < x_.size(); ++i)
      x_[i] = vec_cast<double>(a_.positions_free.data()[vertices_[i]]);
    programme_.clear(mass_inv_);
    for (std::size_t k = 0; k < zone_.size(); ++k) {
      if (!planes)
        add(zone_[k]);
      else if (k == 0 || !same_pair(zone_[k - 1], zone_[k]))
        add_plane(zone_[k]);
    }
    const bool solved =
        programme_.climb(outcome.squeezed != 0 ? squeezed_passes_max : zone_passes_max,
                         planes ? std::numeric_limits<double>::infinity() : energy_max());
    outcome.passes += programme_.passes();
    outcome.planes = planes ? 1 : 0;
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += programme_.displacements()[i];
    return solved;
  }

  void add(const Collision& c) {
    std::size_t v[4];
    for (int j = 0; j < 4; ++j)
      v[j] = static_cast<std::size_t>(std::lower_bound(vertices_.begin(), vertices_.end(), c.v[j]) -
                                      vertices_.begin());
    programme_.add(v, c, x_);
  }

  static bool same_pair(const Collision& a, const Collision& b) {
    return a.first == b.first && std::equal(a.v, a.v + 4, b.v);
  }

  /// Every vertex of the first primitive from every one of the second, along the shortest distance
  /// at the start.
  void add_plane(const Collision& c) {
    Vec3<double> x[4];
    for (int j = 0; j < 4; ++j) x[j] = vec_cast<double>(a_.positions_t0.data()[c.v[j]]);
    const Proximity<double> at = c.first == 1 ? vertex_triangle(x) : edge_edge(x);
    const double distance = std::sqrt(at.distance_sq);
    Collision pair = c;
    if (distance > 0) {
      pair.n = (1 / distance) * at.difference;
      pair.offset = std::min(c.offset, plane_share * distance);
    }
    if (std::all_of(c.v, c.v + 4, [this](Index v) { return heavy(v); })) add(pair);  // unsolvable
    for (int i = 0; i < c.first; ++i)
      for (int j = c.first; j < 4; ++j) {
        std::fill(pair.w, pair.w + 4, 0.0);
        pair.w[i] = 1;
        pair.w[j] = -1;
        // What no part of can move is as it is.
        if (heavy(c.v[i]) && heavy(c.v[j])) continue;
        add(pair);
      }
  }

  /// What the dual cannot exceed if the start satisfies the constraints, and on top what it takes
  /// to bring layers back to their offsets that have come closer than those. Of no use where
  /// something prescribed does work.
  double energy_max() const {
    double energy = 0;
    double mass = 0;
    double offset = 0;
    for (const Collision& c : zone_) offset = std::max(offset, c.offset);
    if (!is_free()) return std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      energy += 0.5 * length_sq(x_[i] - start(i)) / mass_inv_[i];
      mass += 1 / mass_inv_[i];
    }
    return energy + 0.5 * mass * offset * offset;
  }

  /// Momentum of the free vertices, or the displacement of the prescribed ones if the zone has any.
  bool move_rigidly() {
    Vec3<double> prescribed_shift{};
    bool held = false;
    double mass = 0;
    Vec3<double> centre{};
    Vec3<double> shift{};
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const Vec3<double> u = x_[i] - start(i);
      if (mass_inv_[i] == 0) {
        if (held && length(u - prescribed_shift) >
                        same_displacement * (length(u) + length(prescribed_shift)))
          return false;
        prescribed_shift = u;
        held = true;
        continue;
      }
      const double m = 1 / mass_inv_[i];
      mass += m;
      centre += m * start(i);
      shift += m * u;
    }
    if (!(mass > 0)) return false;
    centre *= 1 / mass;
    shift *= 1 / mass;
    turn(centre, held ? prescribed_shift : shift,
         held ? Vec3<double>{} : rotation_of(centre, shift));
    return true;
  }

  /// Turns the zone as it started about `centre` and moves it by `shift`.
  void turn(const Vec3<double>& centre, const Vec3<double>& shift, const Vec3<double>& spin) {
    const double angle = length(spin);
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (mass_inv_[i] == 0) continue;
      const Vec3<double> r = start(i) - centre;
      Vec3<double> turned = r;
      if (angle > 0) {
        const Vec3<double> axis = (1 / angle) * spin;
        turned = std::cos(angle) * r + std::sin(angle) * cross(axis, r) +
                 ((1 - std::cos(angle)) * dot(axis, r)) * axis;
      }
      x_[i] = centre + shift + turned;
    }
  }

  /// Rotation vector over the step that keeps the zone's angular momentum about `centre`.
  Vec3<double> rotation_of(const Vec3<double>& centre, const Vec3<double>& shift) const {
    Vec3<double> momentum{};
    Mat3<double> inertia{};
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (mass_inv_[i] == 0) continue;
      const double m = 1 / mass_inv_[i];
      const Vec3<double> r = start(i) - centre;
      momentum += m * cross(r, x_[i] - start(i) - shift);
      inertia += m * (dot(r, r) * Mat3<double>::identity() - outer(r, r));
    }
    return inverse_symmetric(inertia) * momentum;
  }

  const RespondZones<T> a_;
  Span<const Collision> zone_;
  std::vector<Index> vertices_;
  std::vector<Vec3<double>> x_;
  std::vector<double> mass_inv_;
  ZoneProgramme programme_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const RespondZones<T>& args) {
  submit_host(queue, [args] {
    ZoneSolver<T> solver(args);
    for (std::size_t z = 0; z < args.outcomes.size(); ++z) solver.solve(z);
  });
}

template void run(OnHost, Queue&, const RespondZones<float>&);
template void run(OnHost, Queue&, const RespondZones<double>&);

}  // namespace weft
