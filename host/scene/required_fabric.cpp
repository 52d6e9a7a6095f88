#include "host/scene/required_fabric.hpp"

#include <vector>

#include "host/input/nearest_word.hpp"
#include "weft/error.hpp"

namespace weft {

const Fabric& required_fabric(const std::string& name, const std::string& field) {
  if (const Fabric* found = find_fabric(name)) return *found;
  std::string list;
  std::vector<std::string> names;
  for (const Fabric& known : fabrics()) {
    list += (list.empty() ? "" : ", ") + std::string(known.name);
    names.emplace_back(known.name);
  }
  throw SceneError({}, field, "\"" + name + "\"", list + did_you_mean(name, names));
}

}  // namespace weft
