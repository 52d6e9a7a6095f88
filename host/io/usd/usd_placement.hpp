#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "weft/core/vec.hpp"

namespace weft::io {

/// x -> linear x + translate
struct UsdPlacement {
  double linear[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Vec3<double> translate{0, 0, 0};

  /// Without the translation.
  Vec3<double> turned(const Vec3<double>& x) const;
  bool only_translates() const;
  /// Whether it turns fronts to backs.
  bool mirrors() const;
};

/// First `inner`, then `outer`.
UsdPlacement composed(const UsdPlacement& outer, const UsdPlacement& inner);

/// The transform of one prim: operations (xformOp:...), of which those count that xformOpOrder
/// names.
class UsdTransform {
 public:
  /// @return whether it is an operation with a value that can be taken over
  bool set(std::string_view name, std::string_view text);
  /// @return whether it is a list of operations
  bool set_order(std::string_view text);

  /// @param placement of the prim
  /// @return whether all operations of the order are there
  bool placement(UsdPlacement& placement) const;

 private:
  std::map<std::string, UsdPlacement, std::less<>> operations_;
  std::vector<std::string> order_;
};

}  // namespace weft::io
