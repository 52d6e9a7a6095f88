// Two certificates that let pairs skip continuous detection, over a whole scene: the slack that the
// prediction leaves each pair, which the engine uses, and displacement bounds a vertex (offset
// geometric contact, 2025), taken from the same pairs' distances. Counts what each leaves to be
// looked at in the first round of every step, and checks that neither hides a collision.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <typeinfo>
#include <vector>

#include "benchmarks/support/bench_main.hpp"
#include "benchmarks/support/displacement_bounds.hpp"
#include "benchmarks/support/scene_settings.hpp"
#include "host/base/atomic_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/kernels/collide/continuous.hpp"
#include "weft/simulation.hpp"

namespace {

using Json = nlohmann::ordered_json;
using weft::Index;
using weft::bench::DisplacementBounds;

/// Bounds are recomputed once so many of the vertices have left theirs.
constexpr double renew_share = 0.01;

/// One certificate in one step.
struct Certificate {
  std::int64_t pairs = 0;     ///< that it leaves to be looked at
  std::int64_t vertices = 0;  ///< of the cloth, out of their bounds
  std::int64_t hidden = 0;    ///< collisions of pairs that it would have skipped: must be none
};

enum Way { by_separation_bound, by_start, by_prediction, by_kept, by_either, ways };
constexpr const char* trajectory_names[ways] = {"slack_of_pairs", "bounds_about_start",
                                                "bounds_about_prediction", "bounds_kept",
                                                "slack_or_bounds_kept"};

/// First rounds of detection of one step, summed over its attempts.
struct Round {
  double time = 0;  ///< [s]
  std::int64_t pairs = 0, vertices = 0, collisions = 0;
  int queries = 0;  ///< for the bounds that are kept: how often they were recomputed
  std::array<Certificate, ways> by{};
};

/// What a launch of detection works on, in the host's memory.
template <class T>
struct Detection {
  using Args = weft::CollideContinuous<T>;

  Detection(weft::Queue& queue, const Args& a) {
    const auto all = [&queue](auto span) {
      std::vector<std::remove_const_t<std::remove_pointer_t<decltype(span.data())>>> to(
          span.size());
      queue.copy(to.data(), span.data(), to.size() * sizeof(to[0]));
      return to;
    };
    weft::CollideCounts found;
    queue.copy(&found, a.counts.data(), sizeof found);
    queue.sync();
    counts = found;
    const auto faces = static_cast<std::size_t>(counts.face_pairs);
    const auto edge_count = static_cast<std::size_t>(counts.edge_pairs);
    face_pairs = all(a.face_pairs.subspan(0, faces));
    edge_pairs = all(a.edge_pairs.subspan(0, edge_count));
    face_separation_bound = all(a.face_separation_bound.subspan(0, faces));
    edge_separation_bound = all(a.edge_separation_bound.subspan(0, edge_count));
    edges = all(a.edges);
    triangles = all(a.triangles);
    start = all(a.positions_t0);
    end = all(a.positions_t1);
    predicted = all(a.predicted);
    deviation = all(a.deviation);
    collisions = all(a.collisions.subspan(
        0, std::min(a.collisions.size(), static_cast<std::size_t>(counts.collisions))));
    queue.sync();
    args = a;
    args.face_pairs = face_pairs;
    args.edge_pairs = edge_pairs;
    args.face_separation_bound = face_separation_bound;
    args.edge_separation_bound = edge_separation_bound;
    args.edges = edges;
    args.triangles = triangles;
    args.positions_t0 = start;
    args.positions_t1 = end;
    args.predicted = predicted;
    args.deviation = deviation;
  }
  Detection(const Detection&) = delete;
  Detection& operator=(const Detection&) = delete;

  weft::CollideCounts counts;
  std::vector<weft::Pair> face_pairs, edge_pairs;
  std::vector<float> face_separation_bound, edge_separation_bound, deviation;
  std::vector<weft::Edge> edges;
  std::vector<weft::Tri> triangles;
  std::vector<weft::Vec3<T>> start, end, predicted;
  std::vector<weft::Collision> collisions;
  Args args;  ///< of all that
};

/// Looks at each first round.
class Auditor final : public weft::LaunchObserver {
 public:
  /// @param cloth_vertices which stand before those of obstacles
  explicit Auditor(std::size_t cloth_vertices) : cloth_(cloth_vertices) { current = this; }
  ~Auditor() override { current = nullptr; }
  Auditor(const Auditor&) = delete;
  Auditor& operator=(const Auditor&) = delete;

  void before(weft::Queue&) override {}
  void after(weft::Queue& queue, const std::type_info& kernel, const void* args) override {
    if (kernel == typeid(weft::CollidePairs<float>) || kernel == typeid(weft::CollidePairs<double>))
      new_pairs_ = true;
    if (kernel == typeid(weft::CollideContinuous<float>))
      look(queue, *static_cast<const weft::CollideContinuous<float>*>(args));
    if (kernel == typeid(weft::CollideContinuous<double>))
      look(queue, *static_cast<const weft::CollideContinuous<double>*>(args));
  }

  /// What the rounds since the last call came to.
  Round take(double time) {
    Round round = round_;
    round.time = time;
    round_ = {};
    return round;
  }

 private:
  /// Calls visit(First, corners, slack) for all pairs.
  template <class T, class Visit>
  static void each_pair(const Detection<T>& d, const Visit& visit) {
    const weft::ContinuousRule<T> rule(d.args);
    const auto of = [&](auto first, std::size_t count) {
      for (std::size_t n = 0; n < count; ++n) {
        Index v[4];
        rule.template corners<first()>(n, v);
        visit(first, rule, v, rule.template separation_bound<first()>(n));
      }
    };
    of(std::integral_constant<int, 1>{}, d.face_pairs.size());
    of(std::integral_constant<int, 2>{}, d.edge_pairs.size());
  }

  template <class T>
  void look(weft::Queue& queue, const weft::CollideContinuous<T>& args) {
    if (!args.moved.empty()) return;  // a later round
    const Detection<T> d(queue, args);
    if (d.counts.out_of_bounds != 0) return;  // the pairs are not all: another search follows
    const std::size_t vertices = d.start.size();
    DisplacementBounds about_start(vertices), about_prediction(vertices);
    each_pair(d, [&](auto first, const auto&, const Index v[4], float slack) {
      weft::Vec3<double> x[4];
      for (int j = 0; j < 4; ++j)
        x[j] = weft::vec_cast<double>(d.start[static_cast<std::size_t>(v[j])]);
      const double distance = std::sqrt(weft::closest_points<first()>(x).distance_sq);
      about_start.add(v, distance - std::min(0.5 * distance, d.args.separation));
      about_prediction.add(v, double(slack) - 1.0001 * d.args.separation);
    });
    keep(d, about_start);
    count(d, about_start, about_prediction);
  }

  /// Recomputes the kept bounds where the pairs are different, or too many vertices have left
  /// theirs.
  template <class T>
  void keep(const Detection<T>& d, const DisplacementBounds& about_start) {
    std::size_t out = 0;
    if (!new_pairs_)
      for (std::size_t v = 0; v < cloth_; ++v)
        if (!kept_.allow(v, kept_from_[v], weft::vec_cast<double>(d.start[v])) ||
            !kept_.allow(v, kept_from_[v], weft::vec_cast<double>(d.end[v])))
          ++out;
    if (!new_pairs_ && double(out) <= renew_share * double(cloth_)) return;
    new_pairs_ = false;
    kept_ = about_start;
    kept_from_.clear();
    for (const auto& x : d.start) kept_from_.push_back(weft::vec_cast<double>(x));
    ++round_.queries;
  }

  template <class T>
  void count(const Detection<T>& d, const DisplacementBounds& about_start,
             const DisplacementBounds& about_prediction) {
    std::array<std::vector<char>, ways> out;
    for (auto& of : out) of.assign(d.start.size(), 0);
    for (std::size_t v = 0; v < d.start.size(); ++v) {
      const auto x0 = weft::vec_cast<double>(d.start[v]);
      const auto x1 = weft::vec_cast<double>(d.end[v]);
      out[by_start][v] = about_start.allow(v, x0, x1) ? 0 : 1;
      // With what rounding adds, as the engine counts it.
      out[by_prediction][v] = double(d.deviation[v]) <= about_prediction[v] ? 0 : 1;
      out[by_kept][v] =
          kept_.allow(v, kept_from_[v], x0) && kept_.allow(v, kept_from_[v], x1) ? 0 : 1;
    }
    std::set<std::array<Index, 4>> collide;
    for (const weft::Collision& c : d.collisions) collide.insert({c.v[0], c.v[1], c.v[2], c.v[3]});
    each_pair(d, [&](auto first, const auto& rule, const Index v[4], float slack) {
      const bool hit = collide.count({v[0], v[1], v[2], v[3]}) != 0;
      for (int way = 0; way < ways; ++way) {
        const auto& beyond = out[static_cast<std::size_t>(way == by_either ? by_kept : way)];
        bool look = way == by_separation_bound;
        for (int j = 0; j < 4; ++j) look = look || beyond[static_cast<std::size_t>(v[j])] != 0;
        if (way == by_separation_bound || way == by_either)
          look = look && rule.template has_to_be_looked_at<first()>(v, slack);
        Certificate& of = round_.by[static_cast<std::size_t>(way)];
        of.pairs += look ? 1 : 0;
        of.hidden += hit && !look ? 1 : 0;
      }
    });
    for (std::size_t way = 0; way < ways; ++way)
      round_.by[way].vertices +=
          std::count(out[way].begin(), out[way].begin() + static_cast<std::ptrdiff_t>(cloth_), 1);
    round_.pairs += static_cast<std::int64_t>(d.face_pairs.size() + d.edge_pairs.size());
    round_.vertices += static_cast<std::int64_t>(cloth_);
    round_.collisions += static_cast<std::int64_t>(d.collisions.size());
  }

  std::size_t cloth_;
  bool new_pairs_ = true;
  DisplacementBounds kept_{0};
  std::vector<weft::Vec3<double>> kept_from_;
  Round round_;
};

Json steps_json(const std::vector<Round>& rounds) {
  Json steps = Json::array();
  for (const Round& r : rounds) {
    Json step = {{"time_s", r.time},
                 {"pairs", r.pairs},
                 {"collisions", r.collisions},
                 {"queries_kept", r.queries}};
    for (std::size_t way = 0; way < ways; ++way)
      step[trajectory_names[way]] = {{"pairs", r.by[way].pairs},
                                     {"vertices_out", r.by[way].vertices}};
    steps.push_back(step);
  }
  return steps;
}

/// Over all steps.
Json totals_json(const std::vector<Round>& rounds) {
  Json totals = Json::object();
  for (std::size_t way = 0; way < ways; ++way) {
    double pairs = 0, looked = 0, vertices = 0, out = 0, silent = 0;
    std::int64_t hidden = 0;
    for (const Round& r : rounds) {
      pairs += double(r.pairs);
      vertices += double(r.vertices);
      looked += double(r.by[way].pairs);
      out += double(r.by[way].vertices);
      hidden += r.by[way].hidden;
      silent += r.by[way].pairs == 0 ? 1 : 0;
    }
    totals[trajectory_names[way]] = {
        {"share_of_pairs_skipped", pairs > 0 ? 1 - looked / pairs : 1},
        {"share_of_vertices_kept", vertices > 0 ? 1 - out / vertices : 1},
        {"share_of_steps_skipped", silent / double(rounds.size())},
        {"collisions_hidden", hidden}};
    // The slack of a pair knows no bounds of vertices.
    if (way == by_separation_bound || way == by_either)
      totals[trajectory_names[way]].erase("share_of_vertices_kept");
  }
  std::int64_t queries = 0;
  for (const Round& r : rounds) queries += r.queries;
  totals[trajectory_names[by_kept]]["queries_per_step"] = double(queries) / double(rounds.size());
  return totals;
}

struct Options {
  std::string scene = WEFT_SOURCE_DIR "/scenes/sphere.json";
  std::string device = "cpu:1";
  std::vector<std::string> overrides;
  std::string json;
  bool smoke = false;
};

int run(Options options, const std::vector<std::string>& command) {
  if (options.smoke) {
    options.overrides.push_back("triangles=800");
    options.overrides.push_back("time.frames=12");
  }
  const weft::io::SceneFile file = weft::bench::read_scene_file(options.scene, options.overrides);
  Json machine = weft::bench::machine_json();
  machine["devices"] = weft::describe_devices();
  weft::DeviceSet devices = weft::parse_devices(options.device);
  if (devices.size() != 1)
    throw weft::SceneError("", "--device", options.device, "a single rank, as in cpu:1 or cuda:0");
  weft::Simulation simulation(file.scene, std::move(devices));
  std::size_t cloth_vertices = 0;
  for (const auto& positions : simulation.frame().cloth_positions)
    cloth_vertices += positions.size();
  Auditor auditor(cloth_vertices);
  std::vector<Round> rounds;
  while (simulation.frame_number() < file.scene.time.frames) {
    const weft::StepReport report = simulation.step();
    if (report.failure != weft::Failure::none)
      throw weft::SimulationError(fmt::format("step {}: {}: {}", report.number,
                                              describe(report.failure), report.failure_detail));
    rounds.push_back(auditor.take(report.time));
  }
  const Json totals = totals_json(rounds);
  fmt::print("{}\n", totals.dump(2));
  bool safe = true;
  for (const Round& r : rounds)
    for (const Certificate& of : r.by) safe = safe && of.hidden == 0;
  if (!safe) fmt::print(stderr, "weft_bench_bounds: a certificate hides collisions\n");
  if (!options.json.empty()) {
    std::size_t triangles = 0;
    for (const weft::Cloth& cloth : simulation.scene().cloths)
      triangles += cloth.mesh.triangles.size();
    const Json json = {{"benchmark", "bounds"},
                       {"build", weft::bench::build_json()},
                       {"command", command},
                       {"scene", file.scene.name},
                       {"triangle_count", triangles},
                       {"device", options.device},
                       {"renew_share", renew_share},
                       {"totals", totals},
                       {"steps", steps_json(rounds)},
                       {"resolved_scene", weft::bench::without_folders(file.resolved)},
                       {"machine", machine}};
    weft::write_file_atomically(options.json, json.dump(2) + "\n");
  }
  return safe ? weft::bench::done : weft::bench::wrong_result;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What displacement bounds and slacks leave to continuous detection",
               "weft_bench_bounds");
  Options options;
  app.add_option("--scene", options.scene, "Scene file; default: scenes/sphere.json");
  app.add_option("--set", options.overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  app.add_option("--device", options.device, "A single rank: cpu:1 (default), cuda:0, ...");
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke, "800 triangles, 12 frames");
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run(options, command);
  });
}
