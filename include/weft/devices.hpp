#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "weft/exec/device.hpp"

namespace weft {

struct Scene;

/// How host devices behave under test. Results never depend on it.
struct HostDeviceOptions {
  bool poison = false;           ///< fill fresh memory with NaN bytes, so that a missed copy shows
  std::uint64_t delay_seed = 0;  ///< not 0: delay each piece of work by a pseudo-random time
};

/// n ranks on this machine's processor, each with its own memory and its own threads; a single one
/// works on the thread that calls, unless its work is delayed.
/// @throws DeviceError unless 1 <= n <= 64
DeviceSet host_devices(int n, const HostDeviceOptions& options = {});

/// One rank a number, on the card of that number; a card named twice carries two ranks.
/// @throws DeviceError if this build has no CUDA, or a card is missing
DeviceSet cuda_devices(const std::vector<int>& cards);

/// Reads "auto", "cpu", "cpu:N", "cuda" or "cuda:0,1".
/// "cpu" takes a rank a processor core; "cuda" takes card 0. "auto" is as "cpu" here, where no
/// scene is known; see choose_devices().
/// @throws SceneError if the text is none of these
/// @throws DeviceError naming rank and card if a card is missing or cannot be used
DeviceSet parse_devices(std::string_view text);

/// Time of one iteration of the linear solve on so many cards, by P-Cloth's model of overheads
/// (section 3.1.1) and the machine's own figures.
struct DeviceEstimate {
  int cards = 1;
  std::string transport;  ///< "peer" or "pipelined"; empty: one card
  double seconds = 0;     ///< [s]
};

/// What "auto" stands for on this machine.
struct DeviceChoice {
  std::string device;  ///< for parse_devices(): "cpu:8" or "cuda:0,1"; see look_for_devices()
  std::string reason;  ///< why no other; one line
  std::vector<DeviceEstimate> estimates;  ///< by number of cards; empty on the CPU
  std::vector<std::string> figures;       ///< what was measured, a line a card and a link
};

/// Takes as many cards as pay; the CPU where there is no card, or the scene's method runs there
/// alone. Measures cards and links for some milliseconds each, but only those that may pay. The
/// number of cards changes no result, cards instead of CPU do: whoever wants to repeat a run notes
/// the device.
/// @param scene valid
/// @throws DeviceError if a card cannot be measured
DeviceChoice choose_devices(const Scene& scene);

/// As choose_devices(), but a card that cannot be measured is no error: the choice then names no
/// device, and its reason is what failed. For looking at a machine, not for running on it.
/// @param scene valid
DeviceChoice look_for_devices(const Scene& scene);

/// One line about each device that this build can use, for people.
std::vector<std::string> describe_devices();

/// One line about each link between two cards, measured; none where there are fewer.
/// @throws DeviceError if a card cannot be measured
std::vector<std::string> describe_links();

}  // namespace weft
