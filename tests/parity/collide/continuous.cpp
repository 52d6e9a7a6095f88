#include "weft/kernels/collide/continuous.hpp"
#include "host/exec/host_devices.hpp"

#include <set>

#include "tests/parity/collide/plain_contacts.hpp"

namespace weft::parity {
namespace {

constexpr double separation = 0.001, offset = 0.002;

/// Layers that move on a little from where they were predicted, with the separation bounds
/// of that, some of the pairs contacts.
template <class T>
struct ContinuousInput : Layers<T> {
  std::vector<Vec3<T>> predicted;
  std::vector<float> face_separation_bound, edge_separation_bound;
  std::vector<BoxOf<T>> boxes;
  std::vector<unsigned char> moved;
  std::set<Index> outside;  ///< vertices that leave their boxes

  /// @param escapes some vertices leave their boxes: what collides may then be left out
  explicit ContinuousInput(bool later_round, bool escapes = false) : Layers<T>(33) {
    Random& dice = this->random;
    for (std::size_t v = 0; v < this->vertex_count(); ++v) {
      const Vec3<T>& end = this->positions_t1[v];
      predicted.push_back(v % 3 == 0 ? end : end + dice.vector<T>(-0.002, 0.002));
      BoxOf<T> box{};
      for (int c = 0; c < 3; ++c) {
        box.lo[c] = std::min(this->positions_t0[v][c], end[c]) - T(0.003);
        box.hi[c] = std::max(this->positions_t0[v][c], end[c]) + T(0.003);
      }
      if (escapes && v % 50 == 7) {
        box.hi[v % 3] = end[static_cast<int>(v % 3)] - T(0.001);
        outside.insert(static_cast<Index>(v));
      }
      boxes.push_back(box);
    }
    if (later_round) moved = dice.marks(this->vertex_count(), 6);
    for (const Pair& p : this->face_pairs) face_separation_bound.push_back(separation_bound(p, 1));
    for (const Pair& p : this->edge_pairs) edge_separation_bound.push_back(separation_bound(p, 2));
    for (std::size_t n = 0; n < face_separation_bound.size(); n += 3)
      face_separation_bound[n] = separation_bound_of_contact;
    for (std::size_t n = 0; n < edge_separation_bound.size(); n += 3)
      edge_separation_bound[n] = separation_bound_of_contact;
  }

  void corners(const Pair& pair, int first, Index v[4]) const {
    if (first == 1) {
      v[0] = pair.a;
      std::copy_n(this->triangles[static_cast<std::size_t>(pair.b)].v, 3, v + 1);
    } else {
      std::copy_n(this->edges[static_cast<std::size_t>(pair.a)].v, 2, v);
      std::copy_n(this->edges[static_cast<std::size_t>(pair.b)].v, 2, v + 2);
    }
  }
  /// Distance now less what the predicted motion can take of it.
  float separation_bound(const Pair& pair, int first) const {
    Index v[4];
    corners(pair, first, v);
    Point x[4], u[4];
    for (int j = 0; j < 4; ++j) {
      const auto at = static_cast<std::size_t>(v[j]);
      x[j] = vec_cast<double>(this->positions_t0[at]);
      u[j] = vec_cast<double>(predicted[at]) - x[j];
    }
    return static_cast<float>(plain_closest(x, first).distance() - plain_closing(u, first) - 1e-5);
  }
};

/// The input in the memory of a device.
template <class T>
struct ContinuousOn : LayersOn<T> {
  Buffer<Vec3<T>> predicted;
  Buffer<float> face_separation_bound, edge_separation_bound, deviation;
  Buffer<BoxOf<T>> boxes;
  Buffer<unsigned char> moved;
  Buffer<Collision> collisions;
  Buffer<CollideCounts> counts;
  Buffer<std::uint32_t> scratch;

  ContinuousOn(Device& device, const ContinuousInput<T>& in, std::size_t capacity)
      : LayersOn<T>(device, in),
        predicted(upload(device, in.predicted)),
        face_separation_bound(upload(device, in.face_separation_bound)),
        edge_separation_bound(upload(device, in.edge_separation_bound)),
        deviation(device, in.vertex_count()),
        boxes(upload(device, in.boxes)),
        moved(upload(device, in.moved)),
        collisions(device, capacity),
        counts(device, 1),
        scratch(device, continuous_scratch_size(in.face_pairs.size(), in.edge_pairs.size())) {}

  CollideContinuous<T> args() const {
    CollideContinuous<T> a{};
    a.face_pairs = this->face_pairs.span();
    a.edge_pairs = this->edge_pairs.span();
    a.face_separation_bound = face_separation_bound.span();
    a.edge_separation_bound = edge_separation_bound.span();
    a.edges = this->edges.span();
    a.triangles = this->triangles.span();
    a.positions_t0 = this->positions_t0.span();
    a.positions_t1 = this->positions_t1.span();
    a.predicted = predicted.span();
    a.deviation = deviation.span();
    a.swept_aabb = boxes.span();
    a.moved = moved.span();
    a.vertex_end = static_cast<Index>(boxes.size());
    a.separation = separation;
    a.offset = offset;
    a.collisions = collisions.span();
    a.counts = counts.span();
    a.scratch = scratch.span();
    return a;
  }
  CollideCounts launch_and_count(Device& device, const CollideContinuous<T>& a,
                                 std::size_t face_count, std::size_t edge_count) const {
    CollideCounts own{};
    own.face_pairs = static_cast<Index>(face_count);
    own.edge_pairs = static_cast<Index>(edge_count);
    own.out_of_bounds = own.not_finite = own.missed = 1000;  // of a launch before
    device.compute().copy(counts.data(), &own, sizeof own);
    launch(device.compute(), a);
    device.compute().copy(&own, counts.data(), sizeof own);
    device.compute().sync();
    return own;
  }
};

struct FoundCollisions {
  std::vector<Collision> faces, edges;
  Index missed = 0, out_of_bounds = 0;

  Outputs outputs() const {
    std::vector<double> numbers{static_cast<double>(faces.size()),
                                static_cast<double>(edges.size()), double(missed),
                                double(out_of_bounds)};
    std::vector<double> weights, times, offsets;
    std::vector<Point> normals;
    for (const auto* list : {&faces, &edges})
      for (const Collision& c : *list) {
        for (int j = 0; j < 4; ++j) {
          numbers.push_back(c.v[j]);
          weights.push_back(c.w[j]);
        }
        times.push_back(c.toi);
        offsets.push_back(c.offset);
        normals.push_back(c.n);
      }
    return {{"numbers", numbers},
            {"weights", weights},
            {"times", times},
            {"offsets", offsets},
            output("normals", normals)};
  }
};

template <class T, bool later_round>
struct ContinuousCase {
  using Scalar = T;
  /// All is in double; weights of slivers and of nearly parallel edges lose some digits.
  static constexpr double tolerance = 1e-9;
  ContinuousInput<T> input{later_round};

  /// Parts are shares of both lists and of the vertices, as ranks have them.
  Outputs compute(Device& device, Index parts) const {
    const ContinuousOn<T> on(device, input, 20'000);
    FoundCollisions found;
    for (Index part = 0; part < parts; ++part) {
      const auto share = [&](std::size_t count, Index end) {
        return count * static_cast<std::size_t>(end) / static_cast<std::size_t>(parts);
      };
      CollideContinuous<T> a = on.args();
      const std::size_t face = share(a.face_pairs.size(), part);
      const std::size_t edge = share(a.edge_pairs.size(), part);
      const std::size_t faces = share(a.face_pairs.size(), part + 1) - face;
      const std::size_t edges = share(a.edge_pairs.size(), part + 1) - edge;
      a.face_pairs = a.face_pairs.subspan(face, faces);
      a.face_separation_bound = a.face_separation_bound.subspan(face, faces);
      a.edge_pairs = a.edge_pairs.subspan(edge, edges);
      a.edge_separation_bound = a.edge_separation_bound.subspan(edge, edges);
      a.vertex_begin = static_cast<Index>(share(input.vertex_count(), part));
      a.vertex_end = static_cast<Index>(share(input.vertex_count(), part + 1));
      const CollideCounts counts = on.launch_and_count(device, a, faces, edges);
      EXPECT_EQ(counts.not_finite, 0);
      EXPECT_GE(counts.ccd_tests, counts.collisions);
      EXPECT_LT(counts.ccd_tests, static_cast<Offset>(faces + edges) / 2) << "nothing is culled";
      const std::vector<Collision> all = download(on.collisions);
      found.faces.insert(found.faces.end(), all.begin(), all.begin() + counts.face_collisions);
      found.edges.insert(found.edges.end(), all.begin() + counts.face_collisions,
                         all.begin() + counts.collisions);
      found.missed += counts.missed;
      found.out_of_bounds += counts.out_of_bounds;
    }
    return found.outputs();
  }

  /// The certified test of every pair with a vertex that has moved, no matter what cheaper tests
  /// say of it: none of these may leave out a collision.
  Outputs reference() const {
    FoundCollisions found;
    found.out_of_bounds = static_cast<Index>(input.outside.size());
    for (const int first : {1, 2}) {
      const std::vector<Pair>& pairs = first == 1 ? input.face_pairs : input.edge_pairs;
      const std::vector<float>& separation_bound =
          first == 1 ? input.face_separation_bound : input.edge_separation_bound;
      for (std::size_t n = 0; n < pairs.size(); ++n) {
        Index v[4];
        input.corners(pairs[n], first, v);
        const auto has_moved = [&](Index i) {
          return input.moved.empty() || input.moved[static_cast<std::size_t>(i)] != 0;
        };
        if (std::none_of(v, v + 4, has_moved)) continue;
        Collision c;
        if (!collides(v, first, c)) continue;
        (first == 1 ? found.faces : found.edges).push_back(c);
        if (separation_bound[n] != separation_bound_of_contact) ++found.missed;
      }
    }
    EXPECT_GT(found.faces.size(), 20u);
    EXPECT_GT(found.edges.size(), 20u);
    EXPECT_GT(found.missed, 20);
    return found.outputs();
  }
  bool collides(const Index v[4], int first, Collision& c) const {
    Point from[4], to[4];
    for (int j = 0; j < 4; ++j) {
      from[j] = vec_cast<double>(input.positions_t0[static_cast<std::size_t>(v[j])]);
      to[j] = vec_cast<double>(input.positions_t1[static_cast<std::size_t>(v[j])]);
    }
    const double distance = plain_closest(from, first).distance();
    const double wanted = std::min(separation, distance / 2);
    const Impact<double> impact =
        first == 1 ? ccd_vertex_triangle(from, to, wanted) : ccd_edge_edge(from, to, wanted);
    // Looked at in many places, what it finds is there, and nothing that is there escapes it.
    for (int k = 0; k <= 64; ++k) {
      Point x[4];
      for (int j = 0; j < 4; ++j) x[j] = from[j] + (k / 64.0) * (to[j] - from[j]);
      const double gap = plain_closest(x, first).distance();
      EXPECT_TRUE(k >= 64 * impact.toi || gap > wanted * (1 - 1e-9))
          << "an impact is found too late";
    }
    if (!impact.hit) return false;
    EXPECT_NEAR(length(impact.at.difference), wanted, 2e-3 * wanted);
    c.n = (1 / length(impact.at.difference)) * impact.at.difference;
    std::copy_n(v, 4, c.v);
    std::copy_n(impact.at.w, 4, c.w);
    c.toi = impact.toi;
    c.offset = std::clamp(0.9 * distance, 0.05 * offset, offset);
    return true;
  }
};

using Cases = testing::Types<ContinuousCase<float, false>, ContinuousCase<double, false>,
                             ContinuousCase<float, true>, ContinuousCase<double, true>>;
INSTANTIATE_TYPED_TEST_SUITE_P(CollideContinuous, KernelParity, Cases);

/// Devices of both backends, as far as there are.
std::vector<DeviceSet> all_devices() {
  std::vector<DeviceSet> all;
  all.push_back(host_devices(1, {.poison = true}));
  std::string why;
  if (auto cuda = find_cuda({0}, why)) all.push_back(std::move(*cuda));
  return all;
}

TEST(CollideContinuousLists, TooShortTheyCountOnAndKeepToTheirEnds) {
  const ContinuousInput<double> input(false);
  for (DeviceSet& devices : all_devices()) {
    Device& device = devices[0];
    const ContinuousOn<double> on(device, input, 20'000);
    const std::size_t faces = input.face_pairs.size(), edges = input.edge_pairs.size();
    CollideContinuous<double> a = on.args();
    const CollideCounts whole = on.launch_and_count(device, a, faces, edges);
    const std::vector<Collision> all = download(on.collisions);
    device.compute().fill(on.collisions.data(), 0xAA, on.collisions.size() * sizeof(Collision));
    a.collisions = a.collisions.subspan(0, 37);
    // More pairs were found than there is room for.
    const CollideCounts counts = on.launch_and_count(device, a, faces + 1000, edges + 1000);
    EXPECT_EQ(counts.collisions, whole.collisions);
    EXPECT_EQ(counts.face_collisions, whole.face_collisions);
    EXPECT_EQ(counts.missed, whole.missed);
    EXPECT_EQ(counts.ccd_tests, whole.ccd_tests);
    const std::vector<Collision> some = download(on.collisions);
    for (std::size_t n = 0; n < 37; ++n) {
      for (int j = 0; j < 4; ++j) EXPECT_EQ(some[n].v[j], all[n].v[j]);
      EXPECT_EQ(some[n].toi, all[n].toi);
    }
    for (std::size_t n = 37; n < some.size(); ++n)
      ASSERT_EQ(some[n].v[0], static_cast<Index>(0xAAAAAAAA)) << n;
  }
}

TEST(CollideContinuousLists, NumbersThatAreNotFiniteAreCounted) {
  ContinuousInput<float> input(false, true);
  for (const std::size_t v : {3u, 500u, 1000u})
    input.positions_t1[v][1] = std::numeric_limits<float>::quiet_NaN();
  input.positions_t1[20][0] = std::numeric_limits<float>::infinity();
  for (const Index v : {3, 500, 1000, 20}) input.outside.insert(v);
  for (DeviceSet& devices : all_devices()) {
    const ContinuousOn<float> on(devices[0], input, 20'000);
    const CollideCounts counts = on.launch_and_count(devices[0], on.args(), 0, 0);
    EXPECT_EQ(counts.not_finite, 4);
    EXPECT_EQ(counts.out_of_bounds, static_cast<Index>(input.outside.size()));
    EXPECT_EQ(counts.collisions, 0);
    EXPECT_EQ(counts.missed, 0);
    EXPECT_EQ(counts.ccd_tests, 0);
  }
}

}  // namespace
}  // namespace weft::parity
