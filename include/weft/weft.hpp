#pragma once

/// The library: scenes, simulations and the devices that they run on.
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/scene.hpp"
#include "weft/simulation.hpp"
#include "weft/version.hpp"
