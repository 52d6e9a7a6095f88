#pragma once

#include <memory>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

struct BoxTree;

/// Boxes around the triangles of cloth that sleeps, to tell what comes near it.
class RestBoxes {
 public:
  RestBoxes();
  /// @param points    [m] where the cloth rests
  /// @param triangles of what sleeps; at least one
  /// @param piece     [triangles] number of the piece that each belongs to
  /// @param reach     [m] boxes are larger by this on all sides
  RestBoxes(Span<const Vec3<double>> points, const std::vector<Tri>& triangles,
            std::vector<Index> piece, double reach);
  RestBoxes(RestBoxes&&) noexcept;
  RestBoxes& operator=(RestBoxes&&) noexcept;
  ~RestBoxes();

  bool empty() const noexcept { return tree_ == nullptr; }

  /// Marks the pieces that anything between two corners may come near.
  /// @param low, high [m]
  /// @param near      [pieces] set to 1 where that is so
  void mark(const Vec3<double>& low, const Vec3<double>& high,
            std::vector<unsigned char>& near) const;

 private:
  std::unique_ptr<BoxTree> tree_;
  std::vector<Index> piece_;
};

}  // namespace weft
