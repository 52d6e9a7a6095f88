#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/app/view/quantise.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/render/picture_values.hpp"

namespace weft::app {

/// Ends of what a page holds in few bits. The low end of every colour scale is 0.
struct PlayerRanges {
  /// Over all frames, displaced obstacles included. Both empty, as in a run that still goes on:
  /// each frame has boxes of its own.
  Aabb cloths, obstacles;
  double strain = 0;      ///< 0: no frame has material coordinates
  double contact = 0;     ///< [thicknesses] 0: the thickness is not known
  double compliance = 0;  ///< [m] 0: no frame has displaced obstacles
};

/// A frame before it is stored.
struct PlayerFrame {
  int number = 0;
  double time = 0;         ///< [s]
  io::FrameMeshes meshes;  ///< in world positions, each cloth and each obstacle apart
  /// Where the obstacles were simulated, vertices in the order of `meshes`; empty: as prescribed.
  std::vector<Vec3<double>> displaced{};
  /// [m] By cloth and vertex, how far pinned vertices are from their prescribed places; NaN: not
  /// pinned. Empty: no pin is known.
  std::vector<std::vector<float>> pins{};
  io::CornerValues strain{};   ///< empty: none
  io::CornerValues contact{};  ///< equal at all corners of a vertex; empty: none
};

/// A run as the player's page holds it. What does not change from one frame to the next is stored
/// once.
class PlayerRun {
 public:
  /// @param facts what the page says of the run; a JSON object
  PlayerRun(nlohmann::ordered_json facts, PlayerRanges ranges)
      : ranges_(std::move(ranges)), facts_(std::move(facts)) {}

  /// @pre the frame is inside the ranges
  void add(const PlayerFrame& frame);

  /// Adds to what the page says of the run.
  /// @param step a list of values, see run_facts()
  void add_step(nlohmann::ordered_json step) { facts_["steps"].push_back(std::move(step)); }

  /// Everything but blobs, to which it refers by their numbers.
  nlohmann::ordered_json json() const;

  /// The rest of the run, for a page that has these many frames, topologies, blobs and steps.
  /// Numbers beyond the end ask for nothing.
  nlohmann::ordered_json news(std::size_t frames, std::size_t topologies, std::size_t blobs,
                              std::size_t steps) const;

  bool empty() const { return frames_.empty(); }

  /// Triangles, positions and levels, in base64.
  const std::vector<std::string>& blobs() const { return blobs_; }

  /// Bytes of all blobs.
  std::size_t size() const { return size_; }

 private:
  /// What a blob holds; of each, the last blob is kept in mind.
  enum Kind {
    cloth_triangles,
    obstacle_triangles,
    cloth_positions,
    obstacle_positions,
    strain_levels,
    contact_levels,
    displaced_positions,
    compliance_levels,
    pin_levels,
    kinds
  };

  /// @return number of a blob with these bytes; -1 if there are none
  int store(Kind kind, std::string bytes);

  PlayerRanges ranges_;
  Aabb cloths_, obstacles_;  ///< of all frames so far, if the ranges do not say
  nlohmann::ordered_json facts_;
  nlohmann::ordered_json topologies_ = nlohmann::ordered_json::array();
  nlohmann::ordered_json frames_ = nlohmann::ordered_json::array();
  std::vector<std::string> blobs_;
  std::size_t size_ = 0;
  struct Last {
    std::string bytes;
    int number = -1;
  };
  std::array<Last, kinds> last_;
};

}  // namespace weft::app
