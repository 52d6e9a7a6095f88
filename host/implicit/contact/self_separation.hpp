#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/implicit/contact/self_certificate.hpp"
#include "host/state/rank_geometry.hpp"

namespace weft {

/// Asks the self certificate whether a motion keeps the cloth apart from itself. After repeated
/// failures it asks less often. On the host only.
template <class T>
class SelfSeparation {
 public:
  SelfSeparation(Store<T>& store, std::vector<RankMotion<T>>& motion)
      : store_(store), motion_(motion) {}

  /// Call this for each newly predicted motion: it drops the previous answer.
  void begin() { stays_apart_.reset(); }

  /// Whether the motion to the present positions_t1, the prediction, provably causes neither
  /// contacts nor collisions of cloth with cloth. The answer is kept until begin().
  bool holds();

  /// Whether the motion to the present positions_t1 provably causes no collisions.
  /// @pre holds() was true for the prediction
  bool holds_to_end();

  /// [s] wall time spent so far
  double seconds() const noexcept { return seconds_; }

 private:
  template <class Prove>
  bool prove(Prove prove);

  Store<T>& store_;
  std::vector<RankMotion<T>>& motion_;
  /// Empty: not made yet. Null: no certificate is possible for this scene.
  std::optional<std::unique_ptr<SelfCertificate<T>>> certificate_;
  std::optional<bool> stays_apart_;  ///< answer for the prediction; empty: not asked yet
  int without_ = 0;                  ///< number of motions still to skip
  int failures_ = 0;                 ///< in a row
  double seconds_ = 0;
};

}  // namespace weft
