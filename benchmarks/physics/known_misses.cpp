// What is known to miss its tolerance, and why. Who mends the cause takes the entry out: the suite
// tests/physics fails when one of these passes.
#include <algorithm>

#include "benchmarks/physics/test.hpp"

namespace weft::physics {
namespace {

struct KnownMiss {
  const char* test;
  std::vector<Parameter> when;  ///< parameters, key and value, that all have to hold
  const char* reason;
};

const std::vector<KnownMiss>& misses() {
  static const std::vector<KnownMiss> list = {};
  return list;
}

}  // namespace

const char* known_miss(std::string_view name, const Parameters& parameters) {
  for (const KnownMiss& miss : misses())
    if (miss.test == name && std::all_of(miss.when.begin(), miss.when.end(), [&](const auto& p) {
          return parameters.text(p.key) == p.value;
        }))
      return miss.reason;
  return nullptr;
}

}  // namespace weft::physics
