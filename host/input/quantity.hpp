#pragma once

#include <numbers>
#include <string>

/// The ranges of a scene's numbers, one per kind of quantity. They are wider than anything that
/// cloth is made of, and so narrow that neither the numbers nor what a step computes from one of
/// them leaves the range of a float. Products of several are checked by check_products().
namespace weft {

/// A finite number from `least` to `most`, or 0 if `or_zero`.
struct Quantity {
  const char* noun;  ///< with its article
  const char* unit;  ///< empty: none
  double least;
  double most;
  bool or_zero = false;

  bool holds(double value) const {
    return (value >= least && value <= most) || (or_zero && value == 0);
  }
  /// Such as "a length from 1e-9 to 1e7 m".
  std::string allowed() const;
};

/// The shortest text that says exactly this number, with exponents such as 1e-9.
std::string short_number(double value);

namespace quantity {

inline constexpr double most_length = 1e7;
inline constexpr double least_length = 1e-9;
inline constexpr double most_time = 1e9;
inline constexpr double least_time = 1e-9;
inline constexpr double most_degrees = 1e9;

// geometry
inline constexpr Quantity coordinate{"a coordinate", "m", -most_length, most_length};
/// World place of a scene's (0, 0, 0), which its positions are relative to.
inline constexpr Quantity origin{"a coordinate", "m", -1e15, 1e15};
inline constexpr Quantity length{"a length", "m", least_length, most_length};
inline constexpr Quantity length_or_zero{"a length", "m", least_length, most_length, true};
inline constexpr Quantity angle{"an angle", "degrees", -most_degrees, most_degrees};
inline constexpr Quantity radians{"an angle", "rad", -most_degrees* std::numbers::pi / 180,
                                  most_degrees* std::numbers::pi / 180};
inline constexpr Quantity bend{"an angle", "rad", 1e-6, 1e6};
inline constexpr Quantity scale{"a factor", "", 1e-9, 1e9};
inline constexpr Quantity pixels{"a number", "pixels", 1e-6, 1e6, true};

// time and motion
inline constexpr Quantity instant{"a time", "s", -most_time, most_time};
inline constexpr Quantity instant_from_zero{"a time", "s", 0, most_time};
inline constexpr Quantity duration{"a time", "s", least_time, most_time};
inline constexpr Quantity duration_or_zero{"a time", "s", least_time, most_time, true};
inline constexpr Quantity step{"a time", "s", least_time, 1e6};
inline constexpr Quantity shortest_step{"a time", "s", 1e-15, most_time};
inline constexpr Quantity rate{"a rate", "1/s", 1e-9, 1e9};
inline constexpr Quantity speed_factor{"a factor", "", 1e-6, 1e6};
inline constexpr Quantity velocity{"a velocity", "m/s", -1e6, 1e6};
inline constexpr Quantity speed{"a velocity", "m/s", 1e-9, 1e6};
inline constexpr Quantity angular_velocity{"an angular velocity", "rad/s", -1e6, 1e6};
inline constexpr Quantity force{"a force", "N", -1e9, 1e9};
inline constexpr Quantity acceleration{"an acceleration", "m/s^2", -1e6, 1e6};

// materials and forces
inline constexpr Quantity area_density{"a mass per area", "kg/m^2", 1e-9, 1e9};
inline constexpr Quantity air_density{"a density", "kg/m^3", 1e-9, 1e6, true};
inline constexpr Quantity drag{"a drag", "kg/(m^2 s)", 1e-9, 1e9, true};
inline constexpr Quantity stiffness{"a stiffness", "N/m", 1e-9, 1e12};
/// Of a single spring: one that holds a small sheet is soft.
inline constexpr Quantity spring{"a stiffness", "N/m", 1e-15, 1e12};
inline constexpr Quantity coefficient{"a stiffness", "N/m", -1e12, 1e12};
inline constexpr Quantity bending{"a stiffness", "N m", 1e-18, 1e9, true};
inline constexpr Quantity bending_coupling{"a stiffness", "N m", -1e9, 1e9};
inline constexpr Quantity poisson_ratio{"a number", "", -0.999, 0.5};
inline constexpr Quantity damping_rate{"a rate", "1/s", 1e-9, 1e9, true};
inline constexpr Quantity damping_time{"a time", "s", 1e-12, 1e6, true};
inline constexpr Quantity pressure{"a pressure", "Pa", -1e9, 1e9};
inline constexpr Quantity friction{"a coefficient", "", 1e-9, 1e4, true};
inline constexpr Quantity inertia{"an inertia", "kg m^2", 1e-15, 1e15};
inline constexpr Quantity torque{"a torque", "N m", -1e15, 1e15};
inline constexpr Quantity least_stretch{"a stretch", "", 1e-6, 0.99999, true};
inline constexpr Quantity most_stretch{"a stretch", "", 1.00001, 1e6};

// settings of methods
inline constexpr Quantity repulsion{"a number", "", 1e-6, 1e9};
inline constexpr Quantity tolerance{"a number", "", 1e-15, 0.999};
inline constexpr Quantity loose_tolerance{"a number", "", 1e-15, 1e6};
inline constexpr Quantity tolerance_or_zero{"a number", "", 1e-15, 1e6, true};
inline constexpr Quantity share{"a number", "", 0, 1};
inline constexpr Quantity positive_share{"a number", "", 1e-6, 1};
inline constexpr Quantity share_below_one{"a number", "", 0, 0.999};
inline constexpr Quantity weight{"a number", "", 1e-12, 1e6, true};
inline constexpr Quantity factor_above_one{"a number", "", 1.001, 1e9};
inline constexpr Quantity factor_from_one{"a number", "", 1, 1e6};
inline constexpr Quantity exponent{"a number", "", 1, 1000};
inline constexpr Quantity frames_ahead{"a number", "frames", 0, 1000};

}  // namespace quantity

/// Bounds of what decides how much memory or time a run takes.
namespace count {

inline constexpr int frames = 1'000'000;
inline constexpr int iterations = 1'000'000;  ///< rounds, iterations, rollbacks of one step
inline constexpr int slices = 100'000;
inline constexpr int partial_rows = 1 << 20;

}  // namespace count

}  // namespace weft
