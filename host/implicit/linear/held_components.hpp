#pragma once

#include <vector>

#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Components of cloth that pins, springs or contacts hold. All others fall freely, and the initial
/// guess of a solve assumes that.
template <class T>
class HeldComponents {
 public:
  explicit HeldComponents(Store<T>& store);

  /// Reallocates the buffers of all ranks.
  void make_ranks();

  /// @param fixed [vertices] see fixed_vertices()
  void note_pins(const std::vector<unsigned char>& fixed);
  void set_springs(const std::vector<Spring<T>>& springs);

  /// Whether gravity is the only load of the scene.
  bool can_fall() const noexcept { return can_fall_ && store_.accelerations().empty(); }
  /// Whether it is, and neither pins nor springs hold anything.
  bool all_fall() const;

  /// Marks the components that are held, on rank r.
  /// @return [components] in the memory of the rank
  Span<const Index> mark(int r, const RankGeometry<T>& geometry, Span<const Contact<T>> contacts);

 private:
  struct Rank {
    Buffer<Index> always, held;  ///< [components] see SolveInitialGuess
  };
  Store<T>& store_;
  bool can_fall_;
  std::vector<Index> component_of_vertex_;  ///< [cloth vertices]
  std::vector<Index> pinned_;               ///< [components] 1: has fixed vertices
  std::vector<Index> always_;  ///< [components] 1: these, or has springs; empty: not known
  std::vector<Rank> ranks_;
};

}  // namespace weft
