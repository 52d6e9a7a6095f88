#include "host/app/run/balance_report.hpp"

namespace weft::app {
namespace {

using Json = nlohmann::ordered_json;

Json work_json(const SharedWork& work) {
  return {{"busiest", work.busiest}, {"even", work.even}, {"imbalance", work.imbalance()}};
}

SharedWork parse_work(const Json& json) {
  return {json.at("busiest").get<double>(), json.at("even").get<double>()};
}

}  // namespace

Json balance_json(const BalanceReport& b) {
  const auto known = [&](double imbalance) {
    return b.rebalances > 0 ? Json(imbalance) : Json(nullptr);
  };
  return {{"rows_bytes", work_json(b.rows)},
          {"box_tests", work_json(b.box_tests)},
          {"pairs", work_json(b.pairs)},
          {"ccd_tests", work_json(b.ccd_tests)},
          {"queries", work_json(b.queries)},
          {"rebalances", b.rebalances},
          {"ms", b.seconds * 1e3},
          {"imbalance_before", known(b.imbalance_before)},
          {"imbalance_after", known(b.imbalance_after)}};
}

BalanceReport parse_balance(const Json& json) {
  BalanceReport b;
  b.rows = parse_work(json.at("rows_bytes"));
  b.box_tests = parse_work(json.at("box_tests"));
  b.pairs = parse_work(json.at("pairs"));
  b.ccd_tests = parse_work(json.at("ccd_tests"));
  b.queries = parse_work(json.at("queries"));
  b.rebalances = json.at("rebalances").get<int>();
  b.seconds = json.at("ms").get<double>() / 1e3;
  if (b.rebalances == 0) return b;
  b.imbalance_before = json.at("imbalance_before").get<double>();
  b.imbalance_after = json.at("imbalance_after").get<double>();
  return b;
}

}  // namespace weft::app
