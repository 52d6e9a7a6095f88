#include "host/implicit/contact/self_certificate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/small_scenes.hpp"
#include "tests/unit/collide/meshes.hpp"
#include "weft/elements/ccd.hpp"
#include "weft/elements/pair_lanes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

using test::Points;
using test::Random;

constexpr double thickness = 1e-3;  // [m]
constexpr double edge = 0.01;       // [m]

/// Meshes of several sheets as one cloth.
struct Sheets {
  std::vector<Tri> triangles;
  std::vector<Vec2<double>> picture;
  void add(int cells, Diagonals diagonals = Diagonals::alternating) {
    const Mesh grid = make_grid({edge * cells, edge * cells}, {cells, cells}, diagonals);
    const auto first = static_cast<Index>(picture.size());
    for (const Tri& t : grid.triangles)
      triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
    picture.insert(picture.end(), grid.material.begin(), grid.material.end());
  }
  std::vector<PlanarDomain> domains() const {
    return planar_domains(static_cast<Index>(picture.size()), triangles, picture);
  }
  Points placed(const std::function<Vec3<double>(const Vec2<double>&)>& shape) const {
    Points x;
    for (const Vec2<double>& p : picture) x.push_back(shape(p));
    return x;
  }
};

template <class T>
bool certified(const std::vector<PlanarDomain>& domains, const Points& from, const Points& to,
               int ranks = 1) {
  SelfCertificate<T> certificate(domains, thickness, ranks);
  std::vector<Vec3<T>> x, y;
  for (const auto& p : from) x.push_back(vec_cast<T>(p));
  for (const auto& p : to) y.push_back(vec_cast<T>(p));
  const auto motion = [&](int) {
    return typename SelfCertificate<T>::Motion{Span<const Vec3<T>>(x), Span<const Vec3<T>>(y)};
  };
  const auto all = [&](const std::function<void(int)>& part) {
    for (int r = 0; r < ranks; ++r) part(r);
  };
  // What holds for contacts holds for collisions.
  return certificate.holds(motion, all) && certificate.holds_to(motion, all);
}

/// The nearest that any two primitives without a common vertex come to each other: at many times
/// on the way, and as contacts are told from the prediction.
class Nearest {
 public:
  Nearest(const Sheets& sheets, const Points& from, const Points& to) {
    const SweptMesh mesh = make_swept_mesh(from, to, sheets.triangles);  // in another order
    from_ = mesh.positions_t0;
    to_ = mesh.positions_t1;
    for (Index v = 0; v < mesh.counts.vertices; ++v)
      for (const Tri& t : mesh.triangles)
        if (shares_no_vertex(v, t)) add<1>({v, t.v[0], t.v[1], t.v[2]});
    for (std::size_t i = 0; i < mesh.edges.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (shares_no_vertex(mesh.edges[i], mesh.edges[j]))
          add<2>({mesh.edges[i].v[0], mesh.edges[i].v[1], mesh.edges[j].v[0], mesh.edges[j].v[1]});
  }
  double contact = std::numeric_limits<double>::infinity();   ///< [m]
  double distance = std::numeric_limits<double>::infinity();  ///< [m] at any time
  bool collides = false;

 private:
  template <int First>
  void add(const std::array<Index, 4>& v) {
    Vec3<double> x[4], y[4], z[4];
    for (int j = 0; j < 4; ++j) {
      x[j] = from_[static_cast<std::size_t>(v[static_cast<std::size_t>(j)])];
      y[j] = to_[static_cast<std::size_t>(v[static_cast<std::size_t>(j)])];
    }
    const Proximity<double> start = closest_points<First>(x);
    const double at_start = std::sqrt(start.distance_sq);
    double predicted = at_start;
    for (int j = 0; j < 4; ++j)
      predicted += start.w[j] * dot(start.difference, y[j] - x[j]) / at_start;
    contact = std::min({contact, at_start, predicted});
    constexpr int times = 8;
    for (int k = 0; k <= times; ++k) {
      const double t = k / double(times);
      for (int j = 0; j < 4; ++j) z[j] = (1 - t) * x[j] + t * y[j];
      distance = std::min(distance, std::sqrt(closest_points<First>(z).distance_sq));
    }
    // The whole test for those that may.
    if (at_start < 0.02) collides = collides || detail::ccd<First>(x, y, 0.1 * thickness, 0.0).hit;
  }
  Points from_, to_;
};

/// A sheet rolled up by `angle` in all about an axis at `slant` to its side, sheared and swayed.
struct Fold {
  double angle, slant, ripple, sway;
  static Fold random(Random& random, double angle_max) {
    return {random.uniform(0, angle_max), random.uniform(0, 3), random.uniform(0, 0.7),
            random.uniform(-0.4, 0.4)};
  }
  Vec3<double> operator()(const Vec2<double>& p, double size) const {
    const double c = std::cos(slant), s = std::sin(slant);
    const double along = c * p[0] + s * p[1], across = c * p[1] - s * p[0];
    const double k = std::max(1e-9, angle / size);
    return {std::sin(k * along) / k, across + sway * along,
            (1 - std::cos(k * along)) / k + ripple * size / 20 * std::sin(40 * across / size)};
  }
};

TEST(PlanarDomain, OfAGrid) {
  Sheets sheets;
  sheets.add(7, Diagonals::same);
  const auto domains = sheets.domains();
  ASSERT_EQ(domains.size(), 1u);
  EXPECT_EQ(domains[0].triangles.size(), 98u);
  EXPECT_EQ(domains[0].sides.size(), 28u);
  EXPECT_NEAR(domains[0].least_gap, edge / std::numbers::sqrt2, 1e-5 * edge);
  sheets.add(4);
  EXPECT_EQ(sheets.domains().size(), 2u);
}

TEST(PlanarDomain, MirroredOrStretchedIsOneAsWell) {
  Sheets sheets;
  sheets.add(5);
  for (auto& p : sheets.picture) p = {-1.7 * p[0], 0.3 * p[1]};
  EXPECT_EQ(sheets.domains().size(), 1u);
}

TEST(PlanarDomain, NoneWhereLinesLeaveIt) {
  Sheets whole;
  whole.add(6);
  Sheets corner = whole;  // L-shaped
  std::erase_if(corner.triangles, [&](const Tri& t) {
    return std::all_of(t.v, t.v + 3, [&](Index v) {
      const auto& p = corner.picture[static_cast<std::size_t>(v)];
      return p[0] > -1e-9 && p[1] > -1e-9;
    });
  });
  Sheets hole = whole;
  std::erase_if(hole.triangles, [&](const Tri& t) {
    return std::all_of(t.v, t.v + 3, [&](Index v) {
      const auto& p = hole.picture[static_cast<std::size_t>(v)];
      return std::abs(p[0]) < 1.5 * edge && std::abs(p[1]) < 1.5 * edge;
    });
  });
  Sheets dent = whole;
  dent.picture[3][1] += 0.1 * edge;
  Sheets folded = whole;  // a triangle is turned over
  folded.picture[8] = folded.picture[20];
  for (const Sheets* s : {&corner, &hole, &dent, &folded}) {
    const auto used = s->domains();
    EXPECT_TRUE(used.empty());
  }
  Sheets loose = whole;
  loose.picture.push_back({1, 1});
  EXPECT_TRUE(loose.domains().empty());
  whole.picture[0][0] = std::nan("");
  EXPECT_TRUE(whole.domains().empty());
}

TEST(SelfCertificate, HoldsForWhatFallsFlat) {
  Sheets sheets;
  sheets.add(12);
  const Points from = sheets.placed([](const auto& p) { return Vec3<double>{p[0], p[1], 3.0}; });
  Points to = from;
  for (auto& x : to) x += Vec3<double>{0.2, 0, -1.5};
  for (const int ranks : {1, 2, 5}) {
    EXPECT_TRUE(certified<float>(sheets.domains(), from, to, ranks));
    EXPECT_TRUE(certified<double>(sheets.domains(), from, to, ranks));
  }
}

TEST(SelfCertificate, HoldsForAGentleCylinder) {
  Sheets sheets;
  sheets.add(12);
  const double size = 12 * edge;
  const Fold fold{2.0, 0.5, 0, 0}, later{2.1, 0.5, 0, 0.01};  // up to 60 degrees either side
  const Points from = sheets.placed([&](const auto& p) { return fold(p, size); });
  const Points to = sheets.placed([&](const auto& p) { return later(p, size); });
  EXPECT_TRUE(certified<float>(sheets.domains(), from, to));
  EXPECT_TRUE(certified<double>(sheets.domains(), from, to));
}

TEST(SelfCertificate, DoesNotHoldForWhatTurnsOverOrIsNoNumber) {
  Sheets sheets;
  sheets.add(8);
  const Points flat = sheets.placed([](const auto& p) { return Vec3<double>{p[0], p[1], 0.0}; });
  const Points turned = sheets.placed([](const auto& p) { return Vec3<double>{-p[0], p[1], 0.0}; });
  EXPECT_TRUE(certified<double>(sheets.domains(), turned, turned));
  EXPECT_FALSE(certified<double>(sheets.domains(), flat, turned));
  Points far = flat;
  for (const double no_number : {std::nan(""), std::numeric_limits<double>::infinity()})
    for (std::size_t v = 0; v < far.size(); v += 5) {
      far = flat;
      far[v][static_cast<int>(v % 3)] = no_number;
      EXPECT_FALSE(certified<double>(sheets.domains(), flat, far));
      EXPECT_FALSE(certified<double>(sheets.domains(), far, flat));
    }
}

TEST(SelfCertificate, IsNoUseForMeshesAsFineAsTheThickness) {
  Sheets sheets;
  sheets.add(4);
  EXPECT_TRUE(SelfCertificate<float>(sheets.domains(), 0.5 * edge, 1).of_use());
  EXPECT_FALSE(SelfCertificate<float>(sheets.domains(), 0.8 * edge, 1).of_use());
  EXPECT_FALSE(SelfCertificate<float>({}, thickness, 1).of_use());
}

TEST(SelfCertificate, PiecesHaveToStayOnTheirSides) {
  Sheets sheets;
  sheets.add(4);
  const std::size_t first = sheets.picture.size();
  sheets.add(5);
  const auto at = [&](double below, double above) {
    Points x = sheets.placed([](const auto& p) { return Vec3<double>{p[0], p[1], 0.0}; });
    for (std::size_t v = 0; v < x.size(); ++v) x[v][2] = v < first ? below : above;
    return x;
  };
  const auto domains = sheets.domains();
  EXPECT_TRUE(certified<float>(domains, at(0, 0.002), at(0.5, 0.502)));
  EXPECT_FALSE(certified<float>(domains, at(0, 0.002), at(0.5, 0.5009)));
  EXPECT_FALSE(certified<float>(domains, at(0, 0.0009), at(0.5, 0.502)));
  EXPECT_FALSE(certified<float>(domains, at(0, 0.002), at(0.502, 0.5)));  // through each other
}

/// Folding sheets against all pairs: nothing that is certified comes near on the way.
TEST(SelfCertificate, NeverHoldsWhereAnyPairComesNear) {
  Random random(11);
  int held = 0, near = 0, turned = 0;
  for (int trial = 0; trial < 90; ++trial) {
    const int cells = 4 + trial % 3;
    Sheets sheets;
    sheets.add(cells, trial % 2 == 0 ? Diagonals::alternating : Diagonals::same);
    const double size = cells * edge;
    const Fold fold = Fold::random(random, 5.0);
    const double share = random.uniform(0, 1);  // of another fold that it moves to
    const Fold other = Fold::random(random, 9.0);
    const double jitter = random.uniform(0, 1) < 0.5 ? 0 : random.uniform(0, 0.5 * edge);
    Points from = sheets.placed([&](const auto& p) { return fold(p, size); });
    Points to = sheets.placed([&](const auto& p) {
      return (1 - share * share) * fold(p, size) + share * share * other(p, size);
    });
    for (auto& x : from) x = vec_cast<double>(vec_cast<float>(x + random.within(jitter)));
    for (auto& x : to)
      x = vec_cast<double>(vec_cast<float>(x + Vec3<double>{0.3, 0, 0} + random.within(jitter)));
    const Nearest nearest(sheets, from, to);
    const bool is_near =
        nearest.contact < thickness || nearest.distance < thickness || nearest.collides;
    for (const bool holds : {certified<double>(sheets.domains(), from, to, 1 + trial % 3),
                             certified<float>(sheets.domains(), from, to)}) {
      EXPECT_FALSE(holds && is_near) << trial << " " << nearest.contact << " " << nearest.distance;
      held += holds ? 1 : 0;
    }
    near += is_near ? 1 : 0;
    turned += fold.angle > 3.2 ? 1 : 0;
  }
  EXPECT_GT(held, 10) << held << " " << near << " " << turned;
  EXPECT_GT(near, 10) << held << " " << near << " " << turned;
  EXPECT_GT(turned, 10) << held << " " << near << " " << turned;
}

struct Run {
  std::uint64_t hash = 0;
  int certified = 0;
  std::int64_t proximities = 0;
};

Run run(Scene scene, bool certificate, int ranks, int steps) {
  scene.contact.self_certificate = certificate;
  Simulation simulation(std::move(scene), host_devices(ranks));
  Run r;
  for (int k = 0; k < steps; ++k) {
    const StepReport report = simulation.step();
    EXPECT_EQ(report.failure, Failure::none) << report.failure_detail;
    r.certified += report.self_certified ? 1 : 0;
    r.proximities += report.proximities;
  }
  r.hash = simulation.state_hash();
  return r;
}

/// @param least, most steps that have to be certified
void expect_same(const Scene& scene, int least, int most, int steps = 24) {
  const Run without = run(scene, false, 1, steps);
  EXPECT_EQ(without.certified, 0) << scene.name;
  for (const int ranks : {1, 3}) {
    const Run with = run(scene, true, ranks, steps);
    EXPECT_EQ(with.hash, without.hash) << scene.name << ", " << ranks << " ranks";
    EXPECT_EQ(with.proximities, without.proximities) << scene.name;
    EXPECT_GE(with.certified, least) << scene.name;
    EXPECT_LE(with.certified, most) << scene.name;
  }
}

TEST(SelfCertificate, ChangesNoBitsOfSheetsThatDrape) {
  for (const Precision p : {Precision::single_precision, Precision::double_precision}) {
    expect_same(test::sheet_on_sphere(p, 10), 5, 24);
    expect_same(test::two_sheets(p), 1, 23);
    expect_same(test::released_sheet(p), 5, 24);
  }
}

TEST(SelfCertificate, ChangesNoBitsOfSheetsThatHangOrCurl) {
  expect_same(test::hanging_sheet(Precision::single_precision, Integrator::implicit_euler), 5, 24);
  expect_same(test::hanging_sheet(Precision::double_precision, Integrator::bdf2), 5, 24);
  expect_same(test::curled_sheet(Precision::single_precision, Bending::hinge), 1, 24);
}

TEST(SelfCertificate, ChangesNoBitsWithNewtonsMethodAndLongSteps) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  scene.solver.newton_iterations = 4;
  scene.time.step = 0.02;
  expect_same(scene, 1, 12, 12);
}

}  // namespace
}  // namespace weft
