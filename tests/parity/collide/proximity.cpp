#include "weft/kernels/collide/proximity.hpp"

#include <cstring>
#include <random>

#include "host/exec/host_devices.hpp"
#include "host/implicit/contact/swept_mesh.hpp"
#include "tests/parity/collide/plain_contacts.hpp"

namespace weft::parity {
namespace {

/// Some of the cloth has started nearer than the thickness and some edges are cut, or everything
/// hardly moves.
enum class Kind { plain, thin, still };

/// What goes into CollideProximity beside the layers.
template <class T>
struct ProximityInput : Layers<T> {
  static constexpr double stiffness = 20, step = 0.0078125, fall = 0.0003;
  std::vector<T> mass, friction;
  std::vector<T> start_thickness;  ///< empty: that of the scene everywhere
  std::vector<unsigned char> fixed, touched, cut;
  std::vector<Index> tied;
  std::vector<ContactMemory<T>> face_memory, edge_memory;

  explicit ProximityInput(Kind kind = Kind::plain) : Layers<T>(31) {
    Random& dice = this->random;
    const auto cloth_vertices = static_cast<std::size_t>(this->cloth);
    mass = dice.numbers<T>(cloth_vertices, 0.001, 0.002);
    fixed = dice.marks(cloth_vertices, 5);
    friction = dice.numbers<T>(this->vertex_count(), 0, 0.6);
    for (Index v = 0; v < this->cloth; ++v) tied.push_back(v % 7 == 0 ? v % (this->cloth / 2) : v);
    face_memory = memories(this->face_pairs);
    edge_memory = memories(this->edge_pairs);
    for (Index v = 0; v < this->cloth; ++v)
      touched.push_back(static_cast<unsigned char>(v % 4 == 0 ? 128 + v % 57 : v % 3));
    if (kind == Kind::still)
      for (std::size_t v = 0; v < this->positions_t0.size(); ++v) {
        const Vec3<T>& x = this->positions_t0[v];
        this->positions_t1[v] = x + T(0.02) * (this->positions_t1[v] - x);
      }
    if (kind != Kind::thin) return;
    const T whole = static_cast<T>(Layers<T>::thickness);
    start_thickness = dice.numbers<T>(cloth_vertices, whole / 4, whole);
    for (std::size_t v = 0; v < cloth_vertices; v += 3) start_thickness[v] = whole;
    cut = dice.marks(this->edges.size(), 4);
  }
  /// Of some of the pairs, and of others with the same vertex or first edge.
  std::vector<ContactMemory<T>> memories(const std::vector<Pair>& pairs) {
    Random& dice = this->random;
    std::vector<ContactMemory<T>> all;
    for (std::size_t n = 0; n < pairs.size(); n += 2) {
      Vec3<T> normal = dice.vector<T>(-0.5, 0.5);
      normal[2] = n % 8 < 4 ? T(1) : T(-1);
      normal *= T(1) / length(normal);
      const Vec3<T> force = dice.vector<T>(-1, 1);
      all.push_back({{pairs[n].a, n % 6 == 0 ? pairs[n].b + 100'000 : pairs[n].b},
                     n % 10 == 0 ? T(0) : dice.uniform<T>(0, n % 4 == 0 ? 0.1 : 5),
                     dice.uniform<T>(0, n % 12 < 6 ? 0.5 : 5),
                     dice.uniform<T>(0, 2),
                     tangential(force, normal),
                     normal});
    }
    return all;
  }
};

/// The input in the memory of a device.
template <class T>
struct ProximityOn : LayersOn<T> {
  Buffer<T> mass, friction, start_thickness;
  Buffer<unsigned char> fixed, touched, cut;
  Buffer<Index> tied;
  Buffer<ContactMemory<T>> face_memory, edge_memory;
  Buffer<float> face_separation_bound, edge_separation_bound;
  Buffer<Contact<T>> contacts;
  Buffer<CollideCounts> counts;
  Buffer<std::uint32_t> scratch;

  ProximityOn(Device& device, const ProximityInput<T>& in, std::size_t capacity)
      : LayersOn<T>(device, in),
        mass(upload(device, in.mass)),
        friction(upload(device, in.friction)),
        start_thickness(upload(device, in.start_thickness)),
        fixed(upload(device, in.fixed)),
        touched(upload(device, in.touched)),
        cut(upload(device, in.cut)),
        tied(upload(device, in.tied)),
        face_memory(upload(device, in.face_memory)),
        edge_memory(upload(device, in.edge_memory)),
        face_separation_bound(device, in.face_pairs.size()),
        edge_separation_bound(device, in.edge_pairs.size()),
        contacts(device, capacity),
        counts(device, 1),
        scratch(device, proximity_scratch_size(in.face_pairs.size(), in.edge_pairs.size())) {}

  CollideProximity<T> args(Index cloth) const {
    CollideProximity<T> a{};
    a.face_pairs = this->face_pairs.span();
    a.edge_pairs = this->edge_pairs.span();
    a.surface = this->surface();
    a.triangles = this->triangles.span();
    a.positions_t0 = this->positions_t0.span();
    a.positions_t1 = this->positions_t1.span();
    a.mass = mass.span();
    a.fixed = fixed.span();
    a.material_points = this->material.span();
    a.cloth_of_vertex = this->cloth_of_vertex.span();
    a.tied = tied.span();
    a.friction_of_vertex = friction.span();
    a.cloth_vertex_count = cloth;
    a.thickness = static_cast<T>(Layers<T>::thickness);
    a.stiffness = static_cast<T>(ProximityInput<T>::stiffness);
    a.step = static_cast<T>(ProximityInput<T>::step);
    a.face_memory = face_memory.span();
    a.edge_memory = edge_memory.span();
    a.face_separation_bound = face_separation_bound.span();
    a.edge_separation_bound = edge_separation_bound.span();
    a.contacts = contacts.span();
    a.counts = counts.span();
    a.scratch = scratch.span();
    a.start_thickness = start_thickness.span();
    a.fall = static_cast<T>(ProximityInput<T>::fall);
    a.gravity = T(10);
    a.touched = touched.span();
    a.cut = cut.span();
    return a;
  }
  CollideCounts launch_and_count(Device& device, const CollideProximity<T>& a,
                                 std::size_t face_count, std::size_t edge_count,
                                 Index out_of_bounds = 0) const {
    CollideCounts own{};
    own.out_of_bounds = out_of_bounds;
    own.face_pairs = static_cast<Index>(face_count);
    own.edge_pairs = static_cast<Index>(edge_count);
    device.compute().copy(counts.data(), &own, sizeof own);
    launch(device.compute(), a);
    device.compute().copy(&own, counts.data(), sizeof own);
    device.compute().sync();
    return own;
  }
};

template <class T>
struct FoundContacts {
  std::vector<Contact<T>> faces, edges;
  std::vector<double> separation_bound;

  /// Directions are as good as the gap is long: below 1 mm they count for less.
  static T trust(const Contact<T>& c, const auto& positions) {
    Point gap{};
    for (int j = 0; j < 4; ++j)
      gap += double{c.w[j]} * vec_cast<double>(positions[static_cast<std::size_t>(c.v[j])]);
    return static_cast<T>(std::min(1.0, length(gap) / 0.001));
  }

  /// @param positions [m] at the start
  template <class Precision>
  Outputs outputs(const auto& positions) const {
    std::vector<double> numbers{static_cast<double>(faces.size()),
                                static_cast<double>(edges.size())};
    std::vector<double> weights, stiffness, lengths, loads, yields, drag, marks, bounds;
    std::vector<Vec3<T>> normals, anchors, slides;
    for (const auto* list : {&faces, &edges})
      for (const Contact<T>& c : *list) {
        numbers.insert(numbers.end(), {double(c.pair.a), double(c.pair.b)});
        for (int j = 0; j < 4; ++j) {
          numbers.push_back(c.v[j]);
          weights.push_back(double{c.w[j]});
        }
        stiffness.insert(stiffness.end(), {double{c.stiffness}, double{c.hold}, double{c.push}});
        drag.insert(drag.end(), {double{c.drag}, double{c.drag_limit}});
        lengths.insert(lengths.end(), {double{c.thickness}, double{c.reach}, double{c.friction}});
        yields.push_back(std::isinf(c.yield) ? 0 : double{c.yield});
        loads.push_back(double{c.load});
        normals.push_back(trust(c, positions) * c.n);
        anchors.push_back(trust(c, positions) * c.anchor);
        slides.push_back(trust(c, positions) * c.slide);
      }
    for (const double s : separation_bound) {
      marks.push_back(std::isinf(s) ? 1 : 0);
      bounds.push_back(std::isinf(s) ? 0 : s);
    }
    Outputs all{{"numbers", numbers},    {"weights", weights},      {"stiffness", stiffness},
                {"drag", drag},          {"lengths", lengths},      {"mean load", loads},
                {"yield", yields},       output("normal", normals), output("anchor", anchors),
                output("slide", slides), {"marks", marks}};
    // Stored in float: in double it has a test of its own.
    if (std::is_same_v<Precision, float>) all.push_back({"separation bound", bounds});
    return all;
  }
};

/// @tparam Hold contacts start from their last normal forces
template <class T, bool Hold, Kind Layout = Kind::plain>
struct ProximityCase {
  using Scalar = T;
  /// A computed difference of closest points is off by some ten epsilon of the edges' lengths
  /// (elements/distance.hpp), so its direction by that over the gap: edges of 0.1 m, gaps of 1 mm.
  /// In double it is the normal equations of the reference that are off, by the square of the
  /// slant.
  static constexpr double tolerance =
      std::is_same_v<T, float> ? 1000 * double{std::numeric_limits<T>::epsilon()} : 1e-11;
  ProximityInput<T> input{Layout};

  /// Parts are shares of both lists, as ranks have them.
  Outputs compute(Device& device, Index parts) const {
    const ProximityOn<T> on(device, input, 20'000);
    FoundContacts<T> found;
    for (Index part = 0; part < parts; ++part) {
      const auto share = [&](std::size_t count, Index end) {
        return count * static_cast<std::size_t>(end) / static_cast<std::size_t>(parts);
      };
      CollideProximity<T> a = on.args(input.cloth);
      a.hold_normal_forces = Hold;
      const std::size_t face = share(a.face_pairs.size(), part);
      const std::size_t edge = share(a.edge_pairs.size(), part);
      const std::size_t faces = share(a.face_pairs.size(), part + 1) - face;
      const std::size_t edges = share(a.edge_pairs.size(), part + 1) - edge;
      a.face_pairs = a.face_pairs.subspan(face, faces);
      a.face_separation_bound = a.face_separation_bound.subspan(face, faces);
      a.edge_pairs = a.edge_pairs.subspan(edge, edges);
      a.edge_separation_bound = a.edge_separation_bound.subspan(edge, edges);
      const CollideCounts counts = on.launch_and_count(device, a, faces, edges);
      const std::vector<Contact<T>> all = download(on.contacts);
      found.faces.insert(found.faces.end(), all.begin(), all.begin() + counts.face_contacts);
      found.edges.insert(found.edges.end(), all.begin() + counts.face_contacts,
                         all.begin() + counts.contacts);
    }
    for (const auto* separation_bound : {&on.face_separation_bound, &on.edge_separation_bound})
      for (const float s : download(*separation_bound)) found.separation_bound.push_back(double{s});
    return found.template outputs<T>(input.positions_t0);
  }

  /// Pair by pair, by the test's own formulas.
  Outputs reference() const {
    const DeviceSet devices = host_devices(1);
    const ProximityOn<T> on(devices[0], input, 1);
    CollideProximity<T> args = on.args(input.cloth);
    args.hold_normal_forces = Hold;
    const PlainContacts<T> plain(args);
    FoundContacts<double> found;
    for (const int first : {1, 2})
      for (const Pair& pair : first == 1 ? input.face_pairs : input.edge_pairs) {
        const auto verdict = plain.judge(pair, first);
        found.separation_bound.push_back(verdict.known ? double{separation_bound_of_contact}
                                                       : verdict.separation_bound);
        if (verdict.contact) (first == 1 ? found.faces : found.edges).push_back(*verdict.contact);
      }
    EXPECT_GT(found.faces.size(), 100u);
    EXPECT_GT(found.edges.size(), 100u);
    return found.template outputs<T>(input.positions_t0);
  }
};

using Cases = testing::Types<
    ProximityCase<float, false>, ProximityCase<double, false>, ProximityCase<float, true>,
    ProximityCase<double, true>, ProximityCase<float, false, Kind::thin>,
    ProximityCase<double, false, Kind::thin>, ProximityCase<float, false, Kind::still>,
    ProximityCase<double, false, Kind::still>>;
INSTANTIATE_TYPED_TEST_SUITE_P(CollideProximity, KernelParity, Cases);

/// Devices of both backends, as far as there are.
std::vector<DeviceSet> all_devices() {
  std::vector<DeviceSet> all;
  all.push_back(host_devices(1, {.poison = true}));
  std::string why;
  if (auto cuda = find_cuda({0}, why)) all.push_back(std::move(*cuda));
  return all;
}

/// More pairs were found than there is room for, or a vertex has left its box.
TEST(CollideProximityLists, OfPairsThatAreNotAllThereAreNoContacts) {
  const ProximityInput<double> input;
  for (DeviceSet& devices : all_devices()) {
    Device& device = devices[0];
    const ProximityOn<double> on(device, input, 20'000);
    const std::size_t faces = input.face_pairs.size(), edges = input.edge_pairs.size();
    const CollideProximity<double> a = on.args(input.cloth);
    const CollideCounts whole = on.launch_and_count(device, a, faces, edges);
    EXPECT_GT(whole.contacts, whole.face_contacts);
    for (const int out_of_bounds : {0, 1}) {
      const std::size_t more = out_of_bounds == 0 ? 1 : 0;
      for (const std::size_t more_faces : {std::size_t{0}, more}) {
        const CollideCounts none = on.launch_and_count(device, a, faces + more_faces,
                                                       edges + more - more_faces, out_of_bounds);
        EXPECT_EQ(none.contacts, 0);
        EXPECT_EQ(none.face_contacts, 0);
        EXPECT_EQ(none.face_pairs, static_cast<Index>(faces + more_faces));
      }
    }
  }
}

TEST(CollideProximityLists, TooShortTheyCountOnAndKeepToTheirEnds) {
  const ProximityInput<double> input;
  for (DeviceSet& devices : all_devices()) {
    Device& device = devices[0];
    const ProximityOn<double> on(device, input, 20'000);
    const std::size_t faces = input.face_pairs.size(), edges = input.edge_pairs.size();
    CollideProximity<double> a = on.args(input.cloth);
    const CollideCounts whole = on.launch_and_count(device, a, faces, edges);
    const std::vector<Contact<double>> all = download(on.contacts);
    device.compute().fill(on.contacts.data(), 0xAA, on.contacts.size() * sizeof(Contact<double>));
    a.contacts = a.contacts.subspan(0, 37);
    const CollideCounts counts = on.launch_and_count(device, a, faces, edges);
    EXPECT_EQ(counts.contacts, whole.contacts);
    EXPECT_EQ(counts.face_contacts, whole.face_contacts);
    EXPECT_EQ(counts.face_pairs, static_cast<Index>(faces));
    const std::vector<Contact<double>> some = download(on.contacts);
    for (std::size_t n = 0; n < 37; ++n) {
      EXPECT_EQ(some[n].pair.a, all[n].pair.a);
      EXPECT_EQ(some[n].pair.b, all[n].pair.b);
      EXPECT_EQ(some[n].stiffness, all[n].stiffness);
    }
    for (std::size_t n = 37; n < some.size(); ++n)
      ASSERT_EQ(some[n].v[0], static_cast<Index>(0xAAAAAAAA)) << n;
  }
}

TEST(CollideProximityLists, NoPairsNoContacts) {
  const ProximityInput<float> input;
  for (DeviceSet& devices : all_devices()) {
    const ProximityOn<float> on(devices[0], input, 10);
    const CollideCounts counts = on.launch_and_count(devices[0], on.args(input.cloth), 0, 0);
    EXPECT_EQ(counts.contacts, 0);
    EXPECT_EQ(counts.face_contacts, 0);
  }
}

/// Material points that fall together, as on panels that share their coordinates, say nothing of
/// how stiff a contact would have to be.
TEST(CollideProximityLists, WhatIsTogetherAtRestDoesNotRepel) {
  for (const double apart : {0.0, 1e-5}) {
    SCOPED_TRACE(apart);
    ProximityInput<double> input;
    for (Vec2<double>& m : input.material) m *= apart;
    for (DeviceSet& devices : all_devices()) {
      const ProximityOn<double> on(devices[0], input, 20'000);
      const CollideCounts counts = on.launch_and_count(
          devices[0], on.args(input.cloth), input.face_pairs.size(), input.edge_pairs.size());
      ASSERT_GT(counts.contacts, 100);
      const std::vector<Contact<double>> all = download(on.contacts);
      for (auto c = all.begin(); c != all.begin() + counts.contacts; ++c) {
        EXPECT_TRUE(std::isfinite(c->stiffness) && std::isfinite(c->drag_limit));
        EXPECT_GE(std::max(c->v[0], c->v[3]), input.cloth) << "cloth on cloth";
      }
    }
  }
}

TEST(CollideProximitySeparationBound, InDoubleIsThatOfPlainFormulas) {
  const ProximityInput<double> input;
  const DeviceSet host = host_devices(1);
  const ProximityOn<double> there(host[0], input, 1);
  const PlainContacts<double> plain(there.args(input.cloth));
  for (DeviceSet& devices : all_devices()) {
    const ProximityOn<double> on(devices[0], input, 20'000);
    on.launch_and_count(devices[0], on.args(input.cloth), input.face_pairs.size(),
                        input.edge_pairs.size());
    const std::vector<float> separation_bound = download(on.edge_separation_bound);
    for (std::size_t n = 0; n < separation_bound.size(); ++n) {
      const auto verdict = plain.judge(input.edge_pairs[n], 2);
      ASSERT_EQ(separation_bound[n] == separation_bound_of_contact, verdict.known) << "pair " << n;
      ASSERT_TRUE(verdict.known ||
                  std::abs(double{separation_bound[n]} - verdict.separation_bound) < 1e-8)
          << "pair " << n;
    }
  }
}

/// Gap of face pair n after a share of the motion. [m]
template <class T>
double face_pair_gap(const ProximityInput<T>& in, std::size_t n, double share) {
  const Tri& face = in.triangles[static_cast<std::size_t>(in.face_pairs[n].b)];
  const Index v[4] = {in.face_pairs[n].a, face.v[0], face.v[1], face.v[2]};
  Point x[4];
  for (int j = 0; j < 4; ++j) {
    const auto at = static_cast<std::size_t>(v[j]);
    const Point from = vec_cast<double>(in.positions_t0[at]);
    x[j] = from + share * (vec_cast<double>(in.positions_t1[at]) - from);
  }
  return plain_closest(x, 1).distance();
}

/// The gap never falls below the separation bound on the way, looked at in many places.
TEST(CollideProximitySeparationBound, IsALowerBoundOfTheGap) {
  const ProximityInput<float> input;
  for (DeviceSet& devices : all_devices()) {
    const ProximityOn<float> on(devices[0], input, 20'000);
    on.launch_and_count(devices[0], on.args(input.cloth), input.face_pairs.size(),
                        input.edge_pairs.size());
    const std::vector<float> separation_bound = download(on.face_separation_bound);
    std::size_t positive = 0;
    for (std::size_t n = 0; n < separation_bound.size(); ++n) {
      positive += separation_bound[n] > 0 ? 1 : 0;
      for (int k = 0; k <= 16; ++k)
        ASSERT_LE(double{separation_bound[n]}, face_pair_gap(input, n, k / 16.0)) << "pair " << n;
    }
    EXPECT_GT(positive, separation_bound.size() / 10);
  }
}

/// Pairs of the host with the distances known from earlier steps.
template <class T>
struct KnownDistancesOn {
  const ProximityOn<T> on;
  Buffer<float> faces, edges, closed;
  Buffer<Vec3<T>> measured;
  Buffer<PrimitiveMotion<T>> motions;
  CollideProximity<T> args;

  KnownDistancesOn(Device& device, const ProximityInput<T>& in)
      : on(device, in, 20'000),
        faces(device, in.face_pairs.size()),
        edges(device, in.edge_pairs.size()),
        closed(device, 1),
        measured(device, in.positions_t0.size()),
        motions(device, in.positions_t0.size() + in.edges.size() + in.triangles.size()),
        args(on.args(in.cloth)) {
    args.known = {faces.span(),  edges.span(),   measured.span(),
                  closed.span(), motions.span(), false};
  }
  CollideCounts step(Device& device, const ProximityInput<T>& in) {
    const CollideCounts counts =
        on.launch_and_count(device, args, in.face_pairs.size(), in.edge_pairs.size());
    args.known.hold = true;
    ++args.known.turn;
    return counts;
  }
};

template <class T>
class CollideProximityKnown : public ::testing::Test {};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(CollideProximityKnown, Precisions);

/// A pair that is skipped for its known distance is no contact, and its separation bound is a lower
/// bound of the gap.
TYPED_TEST(CollideProximityKnown, PassesOverNoContact) {
  using T = TypeParam;
  ProximityInput<T> input;
  const DeviceSet host = host_devices(1);
  Device& device = host[0];
  KnownDistancesOn<T> known(device, input);
  const ProximityOn<T> fresh(device, input, 20'000);
  std::size_t passed_over = 0, far = 0;
  for (int step = 0; step < 5; ++step) {
    const std::vector<float> before(known.faces.data(), known.faces.data() + known.faces.size());
    for (const ProximityOn<T>* on : {&known.on, &fresh}) {
      std::copy(input.positions_t0.begin(), input.positions_t0.end(), on->positions_t0.data());
      std::copy(input.positions_t1.begin(), input.positions_t1.end(), on->positions_t1.data());
    }
    const CollideCounts found = known.step(device, input);
    const CollideCounts all = fresh.launch_and_count(
        device, fresh.args(input.cloth), input.face_pairs.size(), input.edge_pairs.size());
    ASSERT_GT(all.contacts, 100);
    ASSERT_EQ(found.contacts, all.contacts);
    ASSERT_EQ(found.face_contacts, all.face_contacts);
    EXPECT_EQ(std::memcmp(known.on.contacts.data(), fresh.contacts.data(),
                          static_cast<std::size_t>(all.contacts) * sizeof(Contact<T>)),
              0);
    for (std::size_t n = 0; n < input.face_pairs.size(); ++n) {
      const float bound = known.on.face_separation_bound.data()[n];
      const float measured = fresh.face_separation_bound.data()[n];
      ASSERT_EQ(bound == separation_bound_of_contact, measured == separation_bound_of_contact);
      if (bound == measured) continue;
      ++passed_over;
      far += known.faces.data()[n] == before[n] ? 1 : 0;
      for (int k = 0; k <= 8; ++k)
        ASSERT_LE(double{bound}, face_pair_gap(input, n, k / 8.0)) << "pair " << n;
    }
    // The layers move on by a twentieth of their last motion, and each vertex is jittered.
    std::mt19937 random(static_cast<unsigned>(step));
    std::uniform_real_distribution<double> jitter(-1e-5, 1e-5);
    for (std::size_t v = 0; v < input.positions_t0.size(); ++v) {
      const Vec3<T> by = T(0.05) * (input.positions_t1[v] - input.positions_t0[v]);
      input.positions_t0[v] += by;
      for (int c = 0; c < 3; ++c) input.positions_t0[v][c] += static_cast<T>(jitter(random));
      input.positions_t1[v] = input.positions_t0[v] + T(step % 2 == 0 ? 1 : 20) * by;
    }
    // A single vertex decides what any two primitives close.
    if (step == 2) input.positions_t1[0][0] += T(1);
  }
  EXPECT_GT(passed_over, input.face_pairs.size() / 4);
  // By what any two primitives close, and by what these two do.
  EXPECT_GT(far, passed_over / 4);
  EXPECT_LT(far, passed_over * 9 / 10);
}

/// Known distances also fall if each step moves the pair by less than their last digit, or by less
/// than that of all that has been closed before.
TEST(CollideProximityKnownDistance, FallsByMotionBelowItsLastDigit) {
  for (const float way_before : {0.0f, 3.0f}) {
    const DeviceSet host = host_devices(1);
    Device& device = host[0];
    std::vector<Vec3<float>> x{{0.25f, 0.25f, 1.0f / 64}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    Buffer<Vec3<float>> positions(device, 4), measured(device, 4);
    const Buffer<Pair> pairs = upload(device, std::vector<Pair>{{0, 0}});
    const Buffer<Tri> triangles = upload(device, std::vector<Tri>{{{1, 2, 3}}});
    Buffer<float> bound(device, 1), known(device, 1), closed(device, 1);
    Buffer<PrimitiveMotion<float>> motions(device, 5);
    Buffer<CollideCounts> counts(device, 1);
    CollideProximity<float> a{};
    a.face_pairs = pairs.span();
    a.triangles = triangles.span();
    a.positions_t0 = a.positions_t1 = positions.span();
    a.face_separation_bound = bound.span();
    a.counts = counts.span();
    a.thickness = 1e-3f;
    a.cloth_vertex_count = 1;
    a.known = {known.span(), {}, measured.span(), closed.span(), motions.span(), false};
    const auto step_once = [&] {
      std::copy(x.begin(), x.end(), positions.data());
      counts.data()[0] = {};
      counts.data()[0].face_pairs = 1;
      launch(device.compute(), a);
      device.compute().sync();
      a.known.hold = true;
    };
    for (const float by : {0.0f, way_before, -way_before}) {
      for (std::size_t v = 1; v < 4; ++v) x[v][0] += by;
      step_once();
    }
    const float least = (x[0][2] + way_before) * std::numeric_limits<float>::epsilon() / 8;
    for (int step = 0; step < 20'000; ++step) {
      x[2][2] = x[1][2] = x[3][2] += least;
      step_once();
      ASSERT_LE(double{known.data()[0]} - double{closed.data()[0]},
                double{x[0][2]} - double{x[1][2]})
          << step;
    }
    if (way_before == 0) {
      EXPECT_GT(known.data()[0] - closed.data()[0], 0.01f);
    }
  }
}

/// Layers that are carried off together by most of an edge's length; the upper cloth slides on the
/// others, past pairs that it would meet if it went on as the first glance at them has it.
ProximityInput<float> carried_layers() {
  ProximityInput<float> in;
  for (std::size_t v = 0; v < in.vertex_count(); ++v) {
    const auto vertex = static_cast<Index>(v);
    in.positions_t1[v] += Vec3<float>{0.05f, -0.03f, -0.06f};
    if (vertex >= in.cloth / 2 && vertex < in.cloth) in.positions_t1[v] += {-0.06f, 0.04f, -0.01f};
  }
  return in;
}

/// Which pairs are contacts is up to the geometry: whatever lists them, with whatever margins, and
/// whether it splits the motion or not.
TEST(CollideProximityContacts, AreThoseOfAnySearch) {
  ProximityInput<float> in = carried_layers();
  SweptMesh mesh;
  for (const Vec3<float>& x : in.positions_t0) mesh.positions_t0.push_back(vec_cast<double>(x));
  for (const Vec3<float>& x : in.positions_t1) mesh.positions_t1.push_back(vec_cast<double>(x));
  mesh.triangles = in.triangles;
  mesh.edges = in.edges;
  const auto of_cloth = [&](const auto& all) {
    return static_cast<Index>(std::count_if(
        all.begin(), all.end(), [&](const auto& primitive) { return primitive.v[0] < in.cloth; }));
  };
  mesh.counts = {in.cloth,
                 static_cast<Index>(in.vertex_count()),
                 of_cloth(in.triangles),
                 static_cast<Index>(in.triangles.size()),
                 of_cloth(in.edges),
                 static_cast<Index>(in.edges.size())};
  constexpr double never = 1;
  for (DeviceSet& devices : all_devices()) {
    std::vector<std::size_t> pairs;
    std::vector<Outputs> contacts;
    for (const double split : {never, 0.0})
      for (const double margin : {0.0, 0.02}) {
        SweptSearch<float> search(devices, mesh, Layers<float>::thickness / 2, margin, split);
        search.run();
        in.face_pairs = search.face_pairs();
        in.edge_pairs = search.edge_pairs();
        pairs.push_back(in.face_pairs.size() + in.edge_pairs.size());
        const ProximityOn<float> on(devices[0], in, 20'000);
        const CollideCounts counts = on.launch_and_count(
            devices[0], on.args(in.cloth), in.face_pairs.size(), in.edge_pairs.size());
        const std::vector<Contact<float>> all = download(on.contacts);
        FoundContacts<float> found;
        found.faces.assign(all.begin(), all.begin() + counts.face_contacts);
        found.edges.assign(all.begin() + counts.face_contacts, all.begin() + counts.contacts);
        EXPECT_GT(found.faces.size(), 50u);
        EXPECT_GT(found.edges.size(), 50u);
        contacts.push_back(found.outputs<float>(in.positions_t0));
      }
    for (const Outputs& others : contacts) expect_same_bits(others, contacts.front());
    EXPECT_GT(pairs[1], pairs[0]);
    EXPECT_GT(pairs[3], pairs[2]);
    EXPECT_LT(2 * pairs[2], pairs[0]);
  }
}

}  // namespace
}  // namespace weft::parity
