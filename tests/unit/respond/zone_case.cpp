#include "tests/unit/respond/zone_case.hpp"

#include <algorithm>
#include <cmath>

#include "weft/elements/ccd.hpp"
#include "weft/elements/contact.hpp"
#include "weft/exec/buffer.hpp"

namespace weft::test {
namespace {

constexpr double thickness = 1e-3;

template <class U>
Buffer<U> upload(Device& device, const std::vector<U>& from) {
  Buffer<U> buffer(device, from.size());
  device.compute().copy(buffer.data(), from.data(), from.size() * sizeof(U));
  return buffer;
}

void solve_share(const ZoneCase& zones, const ZoneShare& share, ZoneMotion motion,
                 ZoneResult& result) {
  DeviceSet devices = host_devices(1, {true, 0});
  Device& device = devices[0];
  const auto collisions = upload(device, share.collisions);
  const auto begin = upload(device, share.zone_begin);
  const auto start = upload(device, zones.start), end = upload(device, zones.end);
  const auto mass = upload(device, zones.mass);
  const auto fixed = upload(device, zones.fixed), yielding = upload(device, zones.yielding);
  Buffer<MovedVertex<double>> moved(device, 4 * share.collisions.size());
  Buffer<ZoneOutcome> outcomes(device, share.zone_count());
  launch(device.compute(),
         RespondZones<double>{collisions.span(), begin.span(), start.span(), end.span(),
                              mass.span(), fixed.span(), static_cast<Index>(zones.mass.size()),
                              motion, yielding.span(), moved.span(), outcomes.span(), {}});
  device.compute().sync();
  for (std::size_t z = 0; z < share.zone_count(); ++z) {
    const ZoneOutcome o = outcomes.span()[z];
    result.outcomes.push_back(o);
    result.passes += o.passes;
    result.solved = result.solved && o.solved != 0;
    for (Index k = 0; k < o.moved; ++k)
      result.moved.push_back(moved.span()[static_cast<std::size_t>(4 * share.zone_begin[z] + k)]);
  }
}

}  // namespace

Index ZoneCase::add(const Vec3<double>& from, const Vec3<double>& to, double m, bool held) {
  start.push_back(from);
  end.push_back(to);
  mass.push_back(m);
  fixed.push_back(held ? 1 : 0);
  yielding.push_back(0);
  return static_cast<Index>(start.size() - 1);
}

ZoneResult solve_zones(const ZoneCase& zones, ZoneMotion motion, int ranks, std::size_t first_new) {
  ZoneList list;
  list.join(
      Span<const Collision>(zones.collisions.data(), zones.collisions.size()), first_new, false,
      [&](Index v) {
        const auto i = static_cast<std::size_t>(v);
        return zones.fixed[i] != 0 && zones.yielding[i] == 0;
      },
      ranks);
  ZoneResult result;
  for (const ZoneShare& share : list.shares())
    if (share.zone_count() > 0) solve_share(zones, share, motion, result);
  std::sort(result.moved.begin(), result.moved.end(),
            [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
  result.end = zones.end;
  for (const auto& m : result.moved) result.end[static_cast<std::size_t>(m.vertex)] = m.position;
  return result;
}

/// Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators" (SplitMix64).
double ZoneRandom::uniform(double low, double high) {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return low + (high - low) * static_cast<double>(z >> 11) * 0x1p-53;
}

Vec3<double> ZoneRandom::vector(double size) {
  Vec3<double> v{};
  for (int c = 0; c < 3; ++c) v[c] = uniform(-size, size);
  return v;
}

std::size_t ZoneRandom::below(std::size_t n) {
  return std::min(n - 1, static_cast<std::size_t>(uniform(0, static_cast<double>(n))));
}

ZoneCase random_impact(ZoneRandom& random, int kind, double mass_ratio) {
  while (true) {
    ZoneCase zones;
    for (int j = 0; j < 4; ++j) {
      const Vec3<double> from = random.vector(0.05);
      zones.add(from, from + random.vector(0.05),
                1e-5 * std::pow(mass_ratio, random.uniform(0, 1)));
    }
    const Vec3<double>* x0 = zones.start.data();
    const Vec3<double>* x1 = zones.end.data();
    const Proximity<double> at_start = kind == 1 ? vertex_triangle(x0) : edge_edge(x0);
    const double distance = std::sqrt(at_start.distance_sq);
    const double separation = std::min(0.1 * thickness, 0.5 * distance);
    const Impact impact =
        kind == 1 ? ccd_vertex_triangle(x0, x1, separation) : ccd_edge_edge(x0, x1, separation);
    if (!impact.hit || !(distance > 0)) continue;
    Collision c{};
    c.n = contact_normal(impact.at.difference, (1 / distance) * at_start.difference);
    for (int j = 0; j < 4; ++j) {
      c.v[j] = j;
      c.w[j] = impact.at.w[j];
    }
    c.offset = std::min(0.2 * thickness, 0.9 * distance);
    c.toi = impact.toi;
    c.first = kind;
    zones.collisions.push_back(c);
    return zones;
  }
}

Vec3<double> momentum(const ZoneCase& zones, const std::vector<Vec3<double>>& end) {
  Vec3<double> sum{};
  for (std::size_t i = 0; i < end.size(); ++i) sum += zones.mass[i] * (end[i] - zones.start[i]);
  return sum;
}

double momentum_size(const ZoneCase& zones, const std::vector<Vec3<double>>& end) {
  double sum = 0;
  for (std::size_t i = 0; i < end.size(); ++i)
    sum += zones.mass[i] * length(end[i] - zones.start[i]);
  return sum;
}

double kinetic(const ZoneCase& zones, const std::vector<Vec3<double>>& end) {
  double sum = 0;
  for (std::size_t i = 0; i < end.size(); ++i)
    sum += 0.5 * zones.mass[i] * length_sq(end[i] - zones.start[i]);
  return sum;
}

double gap(const Collision& c, const std::vector<Vec3<double>>& x) {
  double sum = 0;
  for (int j = 0; j < 4; ++j) sum += c.w[j] * dot(c.n, x[static_cast<std::size_t>(c.v[j])]);
  return sum;
}

double worst_share(const ZoneCase& zones, const std::vector<Vec3<double>>& end) {
  double worst = 0;
  for (const Collision& c : zones.collisions)
    worst = std::max(worst, (c.offset - gap(c, end)) / c.offset);
  return worst;
}

}  // namespace weft::test
