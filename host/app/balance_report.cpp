#include "host/app/balance_report.hpp"

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
  Json json{{"rows_bytes", work_json(b.rows)}, {"box_tests", work_json(b.box_tests)},
            {"pairs", work_json(b.pairs)},     {"ccd_tests", work_json(b.ccd_tests)},
            {"rebalances", b.rebalances},      {"ms", b.seconds * 1e3}};
  if (b.rebalances > 0) {
    json["imbalance_before"] = b.imbalance_before;
    json["imbalance_after"] = b.imbalance_after;
  }
  return json;
}

BalanceReport parse_balance(const Json& json) {
  BalanceReport b;
  b.rows = parse_work(json.at("rows_bytes"));
  b.box_tests = parse_work(json.at("box_tests"));
  b.pairs = parse_work(json.at("pairs"));
  b.ccd_tests = parse_work(json.at("ccd_tests"));
  b.rebalances = json.at("rebalances").get<int>();
  b.seconds = json.at("ms").get<double>() / 1e3;
  b.imbalance_before = json.value("imbalance_before", 0.0);
  b.imbalance_after = json.value("imbalance_after", 0.0);
  return b;
}

}  // namespace weft::app
