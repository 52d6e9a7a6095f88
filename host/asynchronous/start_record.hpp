#pragma once

namespace weft {

/// Tells whether it is worth beginning the next window while the last one is looked at, by how
/// often detection has left nothing in its way of late. That is known of every detection, whether
/// or not a window was begun beside it, so that it need not be tried to be found out. It depends on
/// counts alone, so that the same run begins the same windows.
class StartRecord {
 public:
  /// Whether starts would have stood after at least a quarter of the last detections, of which one
  /// counts seven eighths of the next.
  bool worthwhile() const { return share_ >= all / 4; }

  /// @param clear a detection found nothing, and expects nothing
  void learn(bool clear) { share_ += ((clear ? all : 0) - share_) / 8; }

 private:
  static constexpr int all = 1024;
  int share_ = all;  ///< of detections that were clear
};

}  // namespace weft
