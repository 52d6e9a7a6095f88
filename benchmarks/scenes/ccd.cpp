// Continuous collision detection on queries with known answers: how often it is wrong, how early
// its times are, how long it takes, beside a plain cubic solver in the same run.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "benchmarks/support/bench_main.hpp"
#include "benchmarks/support/ccd_queries.hpp"
#include "benchmarks/support/cubic_solver.hpp"
#include "host/base/atomic_file.hpp"
#include "weft/elements/ccd.hpp"
#include "weft/error.hpp"

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
using weft::Vec3;
using weft::bench::CcdQuery;

struct Options {
  std::vector<std::string> files;
  std::string precision = "double";
  std::string json;
  std::size_t queries = 100000;
  int repeats = 5;
  bool smoke = false;
};

struct Answer {
  bool hit = false;
  double toi = 1;
};

/// A query as the code under test takes it.
template <class T>
struct Input {
  bool edges;
  T input_error;  ///< [m] of the coordinates
  Vec3<T> x_t0[4], x_t1[4];
};

template <class T>
Input<T> make_input(const CcdQuery& q) {
  Input<T> in{};
  in.edges = q.edges;
  for (int j = 0; j < 4; ++j) {
    in.x_t0[j] = weft::vec_cast<T>(q.x_t0[j]);
    in.x_t1[j] = weft::vec_cast<T>(q.x_t1[j]);
  }
  // Floats stand for the doubles that they were rounded from, and the truth is about those.
  if (sizeof(T) < sizeof(double)) in.input_error = weft::rounding_of_input(in.x_t0, in.x_t1);
  return in;
}

struct Certified {
  template <class T>
  Answer operator()(const Input<T>& q) const {
    const weft::Impact<T> impact =
        q.edges ? weft::ccd_edge_edge(q.x_t0, q.x_t1, T(0), q.input_error)
                : weft::ccd_vertex_triangle(q.x_t0, q.x_t1, T(0), q.input_error);
    return {impact.hit, static_cast<double>(impact.toi)};
  }
};

struct Cubic {
  template <class T>
  Answer operator()(const Input<T>& q) const {
    double toi = 1;
    const bool hit = weft::bench::plain_cubic_ccd(q.edges, q.x_t0, q.x_t1, toi);
    return {hit, toi};
  }
};

/// Time that a clock reading adds to what it measures. [ns]
double clock_cost() {
  std::vector<double> costs;
  for (int i = 0; i < 10001; ++i) {
    const auto begin = Clock::now();
    const auto end = Clock::now();
    costs.push_back(std::chrono::duration<double, std::nano>(end - begin).count());
  }
  std::nth_element(costs.begin(), costs.begin() + 5000, costs.end());
  return costs[5000];
}

struct Run {
  std::vector<Answer> answers;
  std::vector<double> ns;  ///< each query's shortest time over all sweeps
  double mean() const { return std::accumulate(ns.begin(), ns.end(), 0.0) / double(ns.size()); }
};

/// Sweeps over all queries again and again, so that a query does not find the branch predictor
/// trained by itself.
template <class T, class Method>
Run run(const std::vector<Input<T>>& inputs, int repeats, double clock, const Method& method) {
  Run r;
  r.answers.resize(inputs.size());
  r.ns.assign(inputs.size(), 1e300);
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const auto begin = Clock::now();
      r.answers[i] = method(inputs[i]);
      const auto end = Clock::now();
      const double ns = std::chrono::duration<double, std::nano>(end - begin).count() - clock;
      r.ns[i] = std::min(r.ns[i], std::max(ns, 0.0));
    }
  }
  return r;
}

/// The element that a share of all are below.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

struct Verdict {
  std::size_t queries = 0, positives = 0, false_negatives = 0, false_positives = 0;
  std::size_t late_toi = 0;
  std::size_t later = 0;  ///< hits whose true time is > 0
  std::size_t zero = 0;   ///< of these, answered with zero
  std::vector<double> gaps;
};

Verdict judge(const std::vector<CcdQuery>& queries, const Run& run) {
  Verdict v;
  v.queries = queries.size();
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const CcdQuery& q = queries[i];
    const Answer& a = run.answers[i];
    v.positives += q.truth;
    v.false_negatives += q.truth && !a.hit;
    v.false_positives += !q.truth && a.hit;
    if (!q.truth || !a.hit || std::isnan(q.toi)) continue;
    v.late_toi += a.toi > q.toi;
    if (!(q.toi > 0)) continue;
    ++v.later;
    v.zero += a.toi == 0;
    v.gaps.push_back(q.toi - a.toi);
  }
  return v;
}

Json to_json(const std::vector<CcdQuery>& queries, const Run& run) {
  const Verdict v = judge(queries, run);
  const std::size_t negatives = v.queries - v.positives;
  const auto share = [](std::size_t part, std::size_t all) {
    return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0;
  };
  const auto number = [](double x) { return std::isnan(x) ? Json(nullptr) : Json(x); };
  return {{"queries", v.queries},
          {"positives", v.positives},
          {"false_negatives", v.false_negatives},
          {"false_positives", v.false_positives},
          {"false_positive_fraction", share(v.false_positives, negatives)},
          {"late_toi", v.late_toi},
          {"zero_toi_fraction", share(v.zero, v.later)},
          {"median_toi_gap", number(quantile(v.gaps, 0.5))},
          {"p99_toi_gap", number(quantile(v.gaps, 0.99))},
          {"ns_per_query_median", quantile(run.ns, 0.5)},
          {"ns_per_query_p99", quantile(run.ns, 0.99)},
          {"ns_per_query_max", quantile(run.ns, 1)},
          {"ns_per_query_mean", run.mean()}};
}

/// Whether a query whose coordinates are only known to be within input_error of those given may
/// hold an impact, and so has to be reported by whoever misses none: shifts by that much of both
/// primitives, against each other, bridge twice as much.
template <class T>
bool undecidable(const Input<T>& q) {
  Vec3<double> x_t0[4], x_t1[4];
  for (int j = 0; j < 4; ++j) {
    x_t0[j] = weft::vec_cast<double>(q.x_t0[j]);
    x_t1[j] = weft::vec_cast<double>(q.x_t1[j]);
  }
  const double separation = 2 * static_cast<double>(q.input_error);
  return q.edges ? weft::ccd_edge_edge(x_t0, x_t1, separation, 0.0).hit
                 : weft::ccd_vertex_triangle(x_t0, x_t1, separation, 0.0).hit;
}

/// Of queries without an impact: how many rounded input leaves undecided, and in how many of the
/// others one is reported.
template <class T>
void count_undecidable(const std::vector<CcdQuery>& queries, const std::vector<Input<T>>& inputs,
                       const Run& run, Json& json) {
  std::size_t open = 0;
  std::size_t decidable = 0;
  std::size_t in_vain = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (queries[i].truth) continue;
    const bool is_open = inputs[i].input_error > 0 && undecidable(inputs[i]);
    ++(is_open ? open : decidable);
    in_vain += !is_open && run.answers[i].hit;
  }
  json["undecidable_negatives"] = open;
  json["false_positive_fraction_of_decidable"] =
      decidable > 0 ? static_cast<double>(in_vain) / static_cast<double>(decidable) : 0.0;
}

/// Both methods on one set of queries.
template <class T>
Json compare(const std::string& name, const std::vector<CcdQuery>& queries,
             const Options& options) {
  std::vector<Input<T>> inputs;
  for (const CcdQuery& q : queries) inputs.push_back(make_input<T>(q));
  std::vector<Input<double>> doubles;
  for (const CcdQuery& q : queries) doubles.push_back(make_input<double>(q));
  const double clock = clock_cost();
  const Run certified = run(inputs, options.repeats, clock, Certified{});
  const Run cubic = run(doubles, options.repeats, clock, Cubic{});
  Json json = {{"queries_from", name}, {"precision", options.precision}};
  json.update(to_json(queries, certified));
  count_undecidable(queries, inputs, certified, json);
  json["cubic_solver"] = to_json(queries, cubic);
  json["median_over_cubic_solver"] = quantile(certified.ns, 0.5) / quantile(cubic.ns, 0.5);
  json["mean_over_cubic_solver"] = certified.mean() / cubic.mean();
  return json;
}

void print_row(const std::string& method, const Json& j) {
  const Json& gap = j.at("median_toi_gap");
  fmt::print("  {:<10} {:>8} {:>6} {:>6} {:>6} {:>9.2g} {:>10.2g} {:>9.0f} {:>9.0f} {:>9.0f}\n",
             method, j.at("queries").get<std::size_t>(), j.at("false_negatives").get<std::size_t>(),
             j.at("false_positives").get<std::size_t>(), j.at("late_toi").get<std::size_t>(),
             j.at("zero_toi_fraction").get<double>(), gap.is_null() ? 0.0 : gap.get<double>(),
             j.at("ns_per_query_median").get<double>(), j.at("ns_per_query_mean").get<double>(),
             j.at("ns_per_query_max").get<double>());
}

int run_all(Options options, const std::vector<std::string>& command) {
  if (options.smoke) {
    options.queries = std::min<std::size_t>(options.queries, 5000);
    options.repeats = 1;
  }
  const Json machine = weft::bench::machine_json();
  Json sets = Json::array();
  std::size_t missed = 0;
  const auto add = [&](const std::string& name, const std::vector<CcdQuery>& queries) {
    sets.push_back(options.precision == "float" ? compare<float>(name, queries, options)
                                                : compare<double>(name, queries, options));
    const Json& set = sets.back();
    missed += set.at("false_negatives").get<std::size_t>() + set.at("late_toi").get<std::size_t>();
    fmt::print("{}, {}\n  {:<10} {:>8} {:>6} {:>6} {:>6} {:>9} {:>10} {:>9} {:>9} {:>9}\n", name,
               options.precision, "", "queries", "missed", "vain", "late", "zero", "gap",
               "ns median", "mean", "max");
    print_row("certified", set);
    print_row("cubic", set.at("cubic_solver"));
    std::fflush(stdout);
  };
  std::vector<CcdQuery> all;
  for (const std::string& file : options.files) {
    const std::vector<CcdQuery> queries = weft::bench::read_ccd_queries(file);
    add(file, queries);
    all.insert(all.end(), queries.begin(), queries.end());
  }
  if (options.files.empty()) add("made", weft::bench::make_ccd_queries(options.queries, 1));
  if (options.files.size() > 1) add("all files", all);
  if (!options.json.empty()) {
    const Json json = {{"benchmark", "ccd"}, {"build", weft::bench::build_json()},
                       {"command", command}, {"repeats", options.repeats},
                       {"sets", sets},       {"machine", machine}};
    weft::write_file_atomically(options.json, json.dump(2) + "\n");
  }
  if (missed > 0) fmt::print(stderr, "weft_bench_ccd: {} impacts missed or late\n", missed);
  return missed == 0 ? weft::bench::done : weft::bench::wrong_result;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Continuous collision detection on queries with known answers", "weft_bench_ccd");
  Options options;
  app.add_option("files", options.files,
                 "Files of 208-byte records (benchmarks/support/ccd_queries.hpp); default: makes "
                 "its own queries");
  app.add_option("--precision", options.precision, "float or double; default: double")
      ->check(CLI::IsMember({"float", "double"}));
  app.add_option("--queries", options.queries, "How many to make without files; default: 100000")
      ->check(CLI::Range(std::size_t{1}, std::size_t{10000000}));
  app.add_option("--repeats", options.repeats, "Sweeps over all queries; default: 5")
      ->check(CLI::Range(1, 1000));
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke, "At most 5000 made queries, one sweep");
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run_all(options, command);
  });
}
