#pragma once

#include <vector>

#include "host/state/store.hpp"
#include "weft/device_positions.hpp"

namespace weft {

/// World positions of cloths in the order of the input, for the program to read. Nothing is
/// allocated after the first call for a cloth.
template <class T>
class ClothPositions {
 public:
  explicit ClothPositions(Store<T>& store) : store_(store) {}

  /// @param cloth  into Scene::cloths
  /// @param origin [m] that the state is relative to
  /// @param to     [vertices of the cloth] [m]
  void download(std::size_t cloth, const Vec3<double>& origin, std::vector<Vec3<float>>& to);
  /// @param stream of the program's, a cudaStream_t: its later work finds the positions, and the
  ///               work that it has so far is done before they change
  DevicePositions on_device(std::size_t cloth, const Vec3<double>& origin, void* stream);

 private:
  void gather(std::size_t cloth, const Vec3<double>& origin, Span<Vec3<float>> to);
  Span<Vec3<float>> buffer_of(std::size_t cloth);

  Store<T>& store_;
  Buffer<Index> vertices_;      ///< [inputs] internal numbers; empty: not asked for yet
  Buffer<Vec3<float>> buffer_;  ///< [inputs] on rank 0
};

}  // namespace weft
