#pragma once

#include <vector>

#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/pairs.hpp"

namespace weft {

/// Pairs that a search lacks because a few vertices have left their motion boxes: these boxes are
/// grown, and only what has a corner there is held against all the rest. The list of the search
/// with these pairs is that of a search with the grown boxes, pair for pair. On the host only.
template <class T>
class StrayPairs {
 public:
  /// A search has made all boxes.
  void begin() noexcept { grown_.clear(); }

  /// Grows the motion boxes of the vertices that end outside.
  /// @param boxes    of the latest search, with margins and motion boxes, but where positions_t1
  ///                 are now
  /// @param search   over these boxes, by which a rank knows its share
  /// @return false if these are too many, since the latest begin(), for that to save any work, or
  ///         obstacles among them: nothing has changed
  bool find(const CollideBoxes<T>& boxes, const CollidePairs<T>& search);

  /// What the latest find() has found of the rank's share, in the order of CollidePairs.
  const std::vector<Pair>& face_pairs() const noexcept { return face_pairs_; }
  const std::vector<Pair>& edge_pairs() const noexcept { return edge_pairs_; }

 private:
  /// A primitive of the cloth with a corner that has strayed.
  struct Touched {
    Index number;
    bool now;  ///< in the latest find(); otherwise since begin()
    SplitBox<T> box, before;
  };

  bool gather(const CollideBoxes<T>& boxes);
  std::vector<Touched> touched(const CollideBoxes<T>& boxes, int kind) const;
  SplitBox<T> split_box(const CollideBoxes<T>& boxes, int kind, Index i) const;
  SplitBox<T> box_before(const CollideBoxes<T>& boxes, int kind, Index i) const;

  bool split_ = false;
  std::vector<Index> grown_;              ///< vertices since begin(), ascending
  std::vector<Index> strays_;             ///< of these the latest
  std::vector<BoxOf<T>> boxes_before_;    ///< [strays]
  std::vector<Index> stray_of_;           ///< [vertices] -1: did not stray in the latest find()
  std::vector<unsigned char> has_grown_;  ///< [vertices] since begin()
  std::vector<Pair> face_pairs_, edge_pairs_;
};

}  // namespace weft
