#include "tests/support/zone_case.hpp"
#include "host/exec/host_devices.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

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
  device.compute().sync();
  return buffer;
}

template <class U>
std::vector<U> download(Device& device, const Buffer<U>& from) {
  std::vector<U> to(from.size());
  device.compute().copy(to.data(), from.data(), to.size() * sizeof(U));
  device.compute().sync();
  return to;
}

template <class T>
std::vector<Vec3<T>> positions_of(const std::vector<Vec3<double>>& x) {
  std::vector<Vec3<T>> result;
  for (const Vec3<double>& p : x) result.push_back(vec_cast<T>(p));
  return result;
}

/// @return what it leaves to the next round
template <class T>
std::vector<ZoneMultipliers> solve_share(Device& device, const ZoneRun<T>& run,
                                         const ZoneCase& zones, const ZoneShare& share,
                                         ZoneMotion motion, ZoneResult& result) {
  const auto collisions = upload(device, share.collisions);
  const auto begin = upload(device, share.zone_begin);
  const auto start = upload(device, positions_of<T>(zones.start));
  const auto end = upload(device, positions_of<T>(zones.end));
  const auto cloth = static_cast<Index>(zones.mass.size() - zones.obstacle_vertices);
  const auto mass = upload(device, std::vector<T>(zones.mass.begin(), zones.mass.begin() + cloth));
  const auto fixed =
      upload(device, std::vector<unsigned char>(zones.fixed.begin(), zones.fixed.begin() + cloth));
  const auto compliant = upload(device, zones.compliant);
  const auto multipliers = upload(device, share.multipliers);
  const Buffer<MovedVertex<T>> moved_d(device, 4 * share.collisions.size());
  const Buffer<ZoneOutcome> outcomes_d(device, share.zone_count());
  const Buffer<std::byte> scratch(device,
                                  zone_scratch_bytes(share.collisions.size(), share.zone_count()));
  run(device.compute(),
      RespondZones<T>{collisions.span(), begin.span(), start.span(), end.span(), mass.span(),
                      fixed.span(), cloth, motion, compliant.span(), multipliers.span(),
                      moved_d.span(), outcomes_d.span(), scratch.span()});
  const auto moved = download(device, moved_d);
  const auto outcomes = download(device, outcomes_d);
  for (std::size_t z = 0; z < share.zone_count(); ++z) {
    const ZoneOutcome o = outcomes[z];
    result.outcomes.push_back(o);
    result.passes += o.passes;
    result.solved = result.solved && o.solved != 0;
    for (Index k = 0; k < o.moved; ++k) {
      const MovedVertex<T>& m = moved[static_cast<std::size_t>(4 * share.zone_begin[z] + k)];
      result.moved.push_back({m.vertex, vec_cast<double>(m.position)});
    }
  }
  return download(device, multipliers);
}

}  // namespace

Index ZoneCase::add(const Vec3<double>& from, const Vec3<double>& to, double m, bool held) {
  start.push_back(from);
  end.push_back(to);
  mass.push_back(m);
  fixed.push_back(held ? 1 : 0);
  compliant.push_back(0);
  return static_cast<Index>(start.size() - 1);
}

Index ZoneCase::add(const ZoneCase& other) {
  const auto first = static_cast<Index>(start.size());
  for (std::size_t i = 0; i < other.start.size(); ++i) {
    add(other.start[i], other.end[i], other.mass[i], other.fixed[i] != 0);
    compliant.back() = other.compliant[i];
  }
  for (Collision c : other.collisions) {
    for (Index& v : c.v) v += first;
    collisions.push_back(c);
  }
  return first;
}

void join(ZoneList& list, const ZoneCase& zones, std::size_t count, std::size_t first_new, bool all,
          int ranks) {
  list.join(
      Span<const Collision>(zones.collisions.data(), count), first_new, all,
      [&](Index v) {
        const auto i = static_cast<std::size_t>(v);
        return zones.fixed[i] != 0 && zones.compliant[i] == 0;
      },
      ranks);
}

template <class T>
ZoneResult solve_listed_with(Device& device, const ZoneRun<T>& run, const ZoneCase& zones,
                             ZoneList& list, ZoneMotion motion) {
  ZoneResult result;
  result.rounds = 1;
  for (std::size_t r = 0; r < list.shares().size(); ++r)
    if (list.shares()[r].zone_count() > 0)
      list.keep(r, solve_share(device, run, zones, list.shares()[r], motion, result));
  result.passes_of_round = result.passes;
  std::sort(result.moved.begin(), result.moved.end(),
            [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
  result.end = zones.end;
  for (const auto& m : result.moved) result.end[static_cast<std::size_t>(m.vertex)] = m.position;
  return result;
}

template <class T>
ZoneResult solve_zones_with(Device& device, const ZoneRun<T>& run, const ZoneCase& zones,
                            ZoneMotion motion, int ranks, int rounds_max) {
  ZoneList list;
  ZoneResult result;
  do {
    join(list, zones, zones.collisions.size(), 0, false, ranks);
    ZoneResult round = solve_listed_with(device, run, zones, list, motion);
    round.rounds += result.rounds;
    round.passes += result.passes;
    round.passes_of_round = std::max(round.passes_of_round, result.passes_of_round);
    result = std::move(round);
  } while (!result.solved && result.rounds < rounds_max);
  return result;
}

template <class T>
ZoneResult solve_warm_with(Device& device, const ZoneRun<T>& run, const ZoneCase& zones,
                           std::size_t old, int ranks) {
  ZoneList list;
  join(list, zones, old, 0, false, ranks);
  solve_listed_with(device, run, zones, list);
  join(list, zones, zones.collisions.size(), old, false, ranks);
  return solve_listed_with(device, run, zones, list);
}

template ZoneResult solve_listed_with(Device&, const ZoneRun<float>&, const ZoneCase&, ZoneList&,
                                      ZoneMotion);
template ZoneResult solve_listed_with(Device&, const ZoneRun<double>&, const ZoneCase&, ZoneList&,
                                      ZoneMotion);
template ZoneResult solve_zones_with(Device&, const ZoneRun<float>&, const ZoneCase&, ZoneMotion,
                                     int, int);
template ZoneResult solve_zones_with(Device&, const ZoneRun<double>&, const ZoneCase&, ZoneMotion,
                                     int, int);
template ZoneResult solve_warm_with(Device&, const ZoneRun<float>&, const ZoneCase&, std::size_t,
                                    int);
template ZoneResult solve_warm_with(Device&, const ZoneRun<double>&, const ZoneCase&, std::size_t,
                                    int);

namespace {

const ZoneRun<double> kernel = [](Queue& queue, const RespondZones<double>& args) {
  launch(queue, args);
};

DeviceSet poisoned_host() {
  return host_devices(1, {true, 0});
}

}  // namespace

ZoneResult solve_listed(const ZoneCase& zones, ZoneList& list, ZoneMotion motion) {
  return solve_listed_with(poisoned_host()[0], kernel, zones, list, motion);
}

ZoneResult solve_zones(const ZoneCase& zones, ZoneMotion motion, int ranks, int rounds_max) {
  return solve_zones_with(poisoned_host()[0], kernel, zones, motion, ranks, rounds_max);
}

ZoneResult solve_warm(const ZoneCase& zones, std::size_t old, int ranks) {
  return solve_warm_with(poisoned_host()[0], kernel, zones, old, ranks);
}

void exclude_the_first(ZoneCase& zones) {
  Collision c = zones.collisions[0];
  c.n = -c.n;
  c.offset = 0.1;
  zones.collisions.push_back(c);
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

ZoneCase tangle(ZoneRandom& random, std::size_t count, std::size_t impacts, double mass_ratio) {
  ZoneCase zones;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3<double> from = random.vector(1);
    zones.add(from, from + random.vector(0.3), std::pow(mass_ratio, random.uniform(0, 1)));
  }
  while (zones.collisions.size() < impacts) {
    Collision c{};
    const double s = random.uniform(0, 1), t = random.uniform(0, 1);
    const double w[4] = {1 - s, s, -(1 - t), -t};
    for (int j = 0; j < 4; ++j) {
      c.w[j] = w[j];
      c.v[j] = static_cast<Index>(random.below(count));
    }
    bool distinct = true;
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < j; ++k) distinct = distinct && c.v[j] != c.v[k];
    if (!distinct) continue;
    c.n = random.vector(1);
    c.n *= 1 / length(c.n);
    if (gap(c, zones.start) < 0) c.n = -c.n;
    c.offset = 0.9 * gap(c, zones.start);
    if (c.offset > 1e-3 && gap(c, zones.end) < c.offset) zones.collisions.push_back(c);
  }
  return zones;
}

ZoneCase vice(double closing) {
  ZoneCase zones;
  zones.add({0, 0, 0}, {0, 0, 0}, 1);
  for (const double side : {1.0, -1.0}) {
    const Index first = zones.add({0, 0, side}, {0, 0, side * (1 - closing)}, 1, true);
    zones.add({1, 0, side}, {1, 0, side * (1 - closing)}, 1, true);
    zones.add({0, 1, side}, {0, 1, side * (1 - closing)}, 1, true);
    zones.collisions.push_back(
        {{0, first, first + 1, first + 2}, {1, -0.4, -0.3, -0.3}, {0, 0, -side}, 0.1, 0.5});
  }
  return zones;
}

ZoneCase chain(std::size_t count, double mass_ratio, bool redundant) {
  ZoneCase zones;
  ZoneRandom random(7);
  const double pitch = 1e-3;
  for (int j = 0; j < 3; ++j) {
    const Vec3<double> at{0.1 * j, 0.1 * (j % 2), 0};
    zones.add(at, at, 1, true);
  }
  for (std::size_t layer = 1; layer <= count; ++layer) {
    const double m = layer % 2 == 0 ? 1 : mass_ratio;
    for (int j = 0; j < 3; ++j) {
      const Vec3<double> from{0.1 * j, 0.1 * (j % 2), pitch * static_cast<double>(layer)};
      zones.add(from, from - Vec3<double>{0, 0, pitch * static_cast<double>(count)}, m);
    }
    const auto upper = static_cast<Index>(3 * layer), lower = upper - 3;
    const double tilt = random.uniform(-1e-6, 1e-6);
    Vec3<double> n{tilt, -tilt, 1};
    n *= 1 / length(n);
    for (Index j = 0; j < 3; ++j) {
      zones.collisions.push_back(
          {{upper + j, lower, lower + 1, lower + 2},
           {1, j == 0 ? -1.0 : -0.0, j == 1 ? -1.0 : -0.0, j == 2 ? -1.0 : -0.0},
           n,
           0.9 * pitch,
           0.5});
      if (!redundant) continue;
      Collision c = zones.collisions.back();
      c.n = Vec3<double>{-tilt, tilt, 1};
      c.n *= 1 / length(c.n);
      zones.collisions.push_back(c);
      c.w[1] -= 1e-7;
      c.w[2] += 1e-7;
      zones.collisions.push_back(c);
    }
  }
  return zones;
}

ZoneCase sheets(ZoneRandom& random, Index side, bool obstacle) {
  constexpr double cell = 0.01, pitch = 1e-3;
  ZoneCase zones;
  for (const bool upper : {true, false})
    for (Index j = 0; j < side; ++j)
      for (Index i = 0; i < side; ++i) {
        const double shift = !upper ? 0 : obstacle ? -0.3 : 0.3;
        const Vec3<double> from{cell * (i + shift), cell * (j + shift),
                                upper ? random.uniform(1, 1.1) * pitch : 0};
        const Vec3<double> by{random.uniform(-pitch, pitch), 0, random.uniform(2, 3) * pitch};
        const bool held = obstacle && !upper;
        zones.add(from, held ? from + Vec3<double>{0, 0, pitch} : from + (upper ? -1 : 1) * by,
                  random.uniform(1, 2), held);
      }
  if (obstacle) zones.obstacle_vertices = zones.start.size() / 2;
  for (Index j = 0; j + 1 < side; ++j)
    for (Index i = 0; i + 1 < side; ++i) {
      const Index upper = j * side + i, lower = side * side + upper;
      const Index vertex = obstacle ? lower : upper, face = obstacle ? upper : lower;
      Vec3<double> n{random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01), obstacle ? -1.0 : 1};
      n *= 1 / length(n);
      zones.collisions.push_back(
          {{vertex, face, face + 1, face + side}, {1, -0.4, -0.3, -0.3}, n, 0.5 * pitch, 0.5});
    }
  return zones;
}

ZoneCase tangles(ZoneRandom& random, int count) {
  ZoneCase all;
  const Index held = all.add({0, 0, 0}, {0, 0, 0}, 1, true);
  for (int g = 0; g < count; ++g)
    add_held(all, tangle(random, 12, 6 + static_cast<std::size_t>(g % 5), 100), held);
  return all;
}

void add_held(ZoneCase& all, const ZoneCase& one, Index held) {
  all.add(one);
  Collision c = all.collisions.back();
  c.v[3] = held;
  if (gap(c, all.start) < 0) c.n = -c.n;
  c.offset = std::max(1e-3, 0.9 * gap(c, all.start));
  all.collisions.push_back(c);
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

bool start_satisfies(const ZoneCase& zones) {
  return std::all_of(zones.collisions.begin(), zones.collisions.end(),
                     [&](const Collision& c) { return gap(c, zones.start) >= c.offset; });
}

bool same_bits(const ZoneResult& a, const ZoneResult& b) {
  return a.moved.size() == b.moved.size() &&
         std::equal(a.moved.begin(), a.moved.end(), b.moved.begin(),
                    [](const auto& x, const auto& y) {
                      return x.vertex == y.vertex &&
                             std::memcmp(&x.position, &y.position, sizeof x.position) == 0;
                    });
}

double worst_share(const ZoneCase& zones, const std::vector<Vec3<double>>& end) {
  double worst = 0;
  for (const Collision& c : zones.collisions)
    worst = std::max(worst, (c.offset - gap(c, end)) / c.offset);
  return worst;
}

}  // namespace weft::test
