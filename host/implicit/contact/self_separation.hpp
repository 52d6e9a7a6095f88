#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/implicit/contact/self_certificate.hpp"
#include "host/state/rank_geometry.hpp"

namespace weft {

/// Asks the certificate of a run's cloth whether motions keep it apart from itself; where that
/// often cannot be told, rarely. On the host only: devices do not ask for it.
template <class T>
class SelfSeparation {
 public:
  SelfSeparation(Store<T>& store, std::vector<RankMotion<T>>& motion)
      : store_(store), motion_(motion) {}

  /// Another motion has been predicted, of which nothing has been said yet.
  void begin() { stays_apart_.reset(); }

  /// Whether the motion to where positions_t1 are now, the prediction, certainly makes neither
  /// contacts nor collisions of cloth with cloth. Asked again before begin() it says the same.
  bool holds();

  /// Whether the motion to where positions_t1 are now certainly makes no collisions.
  /// @pre holds() has said yes of the prediction
  bool holds_to_end();

  /// [s] wall time spent so far
  double seconds() const noexcept { return seconds_; }

 private:
  template <class Prove>
  bool prove(Prove prove);

  Store<T>& store_;
  std::vector<RankMotion<T>>& motion_;
  /// None: not asked for yet. Null: cannot be had.
  std::optional<std::unique_ptr<SelfCertificate<T>>> certificate_;
  std::optional<bool> stays_apart_;  ///< what it says of the prediction; none: not asked
  int without_ = 0;                  ///< motions that are not to be asked about
  int failures_ = 0;                 ///< in a row
  double seconds_ = 0;
};

}  // namespace weft
