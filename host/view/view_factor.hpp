#pragma once

#include <functional>
#include <vector>

#include "host/view/view_camera.hpp"
#include "host/view/view_surface.hpp"

namespace weft {

/// View factor of a triangle by how far it is out of view.
/// @param facing   factor of what is in view: 1, or less if it turns its back
/// @param distance [m] >= 0 from what is in view
/// @cite koh2015, eq. (3)
double smoothed_factor(double facing, double distance, const ViewSettings& settings);

/// How much an instant ahead counts, 1 - delay / window; where there is no window, 1 now and 0
/// after.
/// @param delay, window [s] >= 0
/// @cite koh2015, eq. (4)
double anticipation_weight(double delay, double window);

/// What of a view at one instant says how important each triangle is: its front or its back, its
/// distance from the frustum, and, where occlusion counts, from what is not hidden, along the cloth
/// from centre to centre.
/// @return [triangles] factors of eq. (3)
std::vector<double> view_factors(const ViewCamera& camera, const ViewSurface& surface,
                                 const ViewPlaces& places, const ViewSettings& settings);

/// Triangles no part of which is in the frustum. [triangles] 1 or 0
std::vector<unsigned char> out_of_frustum(const ViewCamera& camera, const ViewSurface& surface,
                                          const ViewPlaces& places);

/// Refines the dark side of silhouettes: where the factors of two neighbours differ by more than
/// the threshold, the lower one becomes their mean; with several such neighbours the highest
/// counts.
/// @cite koh2015, section 3.3
std::vector<double> transferred_factors(const std::vector<double>& factors,
                                        const ViewSurface& surface, double threshold);

/// One instant that is looked ahead to.
struct ViewInstant {
  ViewCamera camera;
  double delay;   ///< [s] from now
  double weight;  ///< of anticipation, > 0
};

/// Instants whose views count now: now, each frame of the window, and each key of the camera in it,
/// so that cuts count from the instant at which they happen. Views that are the same as an earlier
/// one, which counts more, are left out.
/// @param time [s]
/// @pre the camera has keys
std::vector<ViewInstant> view_instants(const Camera& camera, const ViewSettings& settings,
                                       double frame_rate, double time);

/// What is looked at, instant by instant.
struct ViewField {
  struct View {
    ViewInstant instant;
    ViewPlaces places;
    std::vector<double> factors;  ///< [triangles] of the instant, transferred, times its weight
  };
  std::vector<View> views;  ///< now first
  ViewSettings settings;

  /// View factor of a triangle, the greatest of all instants: eq. (4).
  double factor(Index triangle) const;
};

/// @param places_at where things are taken to be after a delay [s]; at 0 where they are
ViewField look(const std::vector<ViewInstant>& instants, const ViewSurface& surface,
               const std::function<ViewPlaces(double)>& places_at, const ViewSettings& settings);

}  // namespace weft
