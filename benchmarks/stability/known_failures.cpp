#include <array>

#include "benchmarks/stability/case.hpp"

namespace weft::stability {
namespace {

struct Known {
  std::string_view name;
  std::string_view method;
  const char* reason;
};

constexpr std::array<Known, 0> known{};

/// Cases that no method has ended within a minute.
constexpr std::array long_ones{
    Known{"gravity_1e3", "asynchronous", ""},
    Known{"stiffness_ratio_1e+06", "asynchronous", ""},
    Known{"stiffness_ratio_1e+06_double", "asynchronous", ""},
    Known{"fold_200", "asynchronous", ""},
};

template <class List>
const Known* find(const List& list, std::string_view name, std::string_view method) {
  for (const Known& k : list)
    if (k.name == name && k.method == method) return &k;
  return nullptr;
}

}  // namespace

const char* known_failure(std::string_view name, std::string_view method) {
  const Known* found = find(known, name, method);
  return found != nullptr ? found->reason : nullptr;
}

bool takes_long(std::string_view name, std::string_view method) {
  return find(long_ones, name, method) != nullptr;
}

}  // namespace weft::stability
