// Impact zones: many small ones, of 1 to 4 collisions each, and a single large one, that keep their
// impacts or the planes of the start. Sheets have been pushed through each other.
#include "weft/kernels/respond/zones.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/support/kernel_bench.hpp"
#include "weft/exec/buffer.hpp"

namespace weft::bench {
namespace {

/// Vertices, what they run into, and the zones of that.
struct Zones {
  std::vector<Vec3<double>> start, end;
  std::vector<Collision> collisions;
  std::vector<Index> begin{0};

  Index add(const Vec3<double>& from, const Vec3<double>& by) {
    start.push_back(from);
    end.push_back(from + by);
    return static_cast<Index>(start.size() - 1);
  }
};

constexpr double cell = 0.01, pitch = 1e-3;

/// A number from -1 to 1, the same everywhere.
double noise(Index n) {
  const double x = std::sin(12.9898 * (n + 1)) * 43758.5453;
  return 2 * (x - std::floor(x)) - 1;
}

/// A zone of `across` x `up` faces, and as many vertices above that have been pushed through them.
void add_sheets(Zones& zones, Index across, Index up) {
  const auto first = static_cast<Index>(zones.start.size());
  const auto seed = static_cast<Index>(zones.collisions.size());
  for (Index j = 0; j <= up; ++j)
    for (Index i = 0; i <= across; ++i)
      zones.add({cell * i, cell * j, 0}, {0, 0, pitch * (2.5 + 0.5 * noise(seed + i + 3 * j))});
  for (Index j = 0; j < up; ++j)
    for (Index i = 0; i < across; ++i) {
      const auto n = static_cast<Index>(zones.collisions.size());
      const Index v = zones.add({cell * (i + 0.3), cell * (j + 0.3), pitch},
                                {pitch * noise(n), 0, pitch * (-2.5 + 0.5 * noise(n + 7))});
      const Index face = first + j * (across + 1) + i;
      Vec3<double> normal{0.01 * noise(2 * n), 0.01 * noise(2 * n + 1), 1};
      normal *= 1 / length(normal);
      zones.collisions.push_back({{v, face, face + 1, face + across + 1},
                                  {1, -0.4, -0.3, -0.3},
                                  normal,
                                  0.5 * pitch,
                                  0.5});
    }
  zones.begin.push_back(static_cast<Index>(zones.collisions.size()));
}

template <class U>
Buffer<U> upload(Device& device, const std::vector<U>& from) {
  Buffer<U> buffer(device, from.size());
  device.compute().copy(buffer.data(), from.data(), from.size() * sizeof(U));
  device.compute().sync();
  return buffer;
}

template <class T>
Buffer<Vec3<T>> upload_as(Device& device, const std::vector<Vec3<double>>& from) {
  std::vector<Vec3<T>> all;
  for (const Vec3<double>& x : from) all.push_back(vec_cast<T>(x));
  return upload(device, all);
}

template <class T>
Json measure(const Options& options, const Zones& zones, ZoneMotion motion) {
  const DeviceSet devices = parse_devices(options.device);
  Device& device = devices[0];
  const std::size_t vertices = zones.start.size(), count = zones.begin.size() - 1;
  const auto collisions = upload(device, zones.collisions);
  const auto begin = upload(device, zones.begin);
  const auto start = upload_as<T>(device, zones.start), end = upload_as<T>(device, zones.end);
  const auto mass = upload(device, std::vector<T>(vertices, T(1e-5)));
  const auto marks = upload(device, std::vector<unsigned char>(vertices, 0));
  const Buffer<ZoneMultipliers> multipliers(device, zones.collisions.size());
  const Buffer<MovedVertex<T>> moved(device, 4 * zones.collisions.size());
  const Buffer<ZoneOutcome> outcomes(device, count);
  const Buffer<std::byte> scratch(device, zone_scratch_bytes(zones.collisions.size(), count));
  const RespondZones<T> args{collisions.span(),
                             begin.span(),
                             start.span(),
                             end.span(),
                             mass.span(),
                             marks.span(),
                             static_cast<Index>(vertices),
                             motion,
                             marks.span(),
                             multipliers.span(),
                             moved.span(),
                             outcomes.span(),
                             scratch.span()};
  double seconds = std::numeric_limits<double>::infinity();
  for (int repeat = 0; repeat < (options.smoke ? 1 : 10); ++repeat) {
    device.compute().fill(multipliers.data(), 0, zones.collisions.size() * sizeof(ZoneMultipliers));
    device.compute().sync();
    seconds = std::min(seconds, shortest(1, [&] {
                         launch(device.compute(), args);
                         device.compute().sync();
                       }));
  }
  std::vector<ZoneOutcome> all(count);
  device.compute().copy(all.data(), outcomes.data(), count * sizeof(ZoneOutcome));
  device.compute().sync();
  double passes = 0, passes_max = 0, unsolved = 0;
  for (const ZoneOutcome& o : all) {
    passes += o.passes;
    passes_max = std::max(passes_max, static_cast<double>(o.passes));
    unsolved += o.solved == 0 ? 1 : 0;
  }
  Json result;
  result.add("zones", static_cast<double>(count));
  result.add("collisions", static_cast<double>(zones.collisions.size()));
  result.add("motion", motion == ZoneMotion::impacts ? "impacts" : "planes");
  result.add("precision", sizeof(T) == 4 ? "float" : "double");
  result.add("ms", 1e3 * seconds).add("us_per_zone", 1e6 * seconds / static_cast<double>(count));
  result.add("passes_mean", passes / static_cast<double>(count)).add("passes_max", passes_max);
  result.add("unsolved", unsolved);
  result.add("scratch_bytes", static_cast<double>(scratch.size()));
  std::cout << result.text() << std::endl;
  return result;
}

void measure_all(const Options& options) {
  Zones small, large;
  for (Index zone = 0; zone < (options.smoke ? 100 : 10'000); ++zone)
    add_sheets(small, 1 + zone % 2, 1 + zone / 2 % 2);
  add_sheets(large, options.smoke ? 10 : 50, options.smoke ? 10 : 40);
  Json results('[');
  for (const Zones* zones : {&small, &large})
    for (const ZoneMotion motion : {ZoneMotion::impacts, ZoneMotion::planes}) {
      results.add(measure<float>(options, *zones, motion));
      results.add(measure<double>(options, *zones, motion));
    }
  write(options, "zones", results);
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  return weft::bench::run(argc, argv, weft::bench::measure_all);
}
