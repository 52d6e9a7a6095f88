#pragma once

#include "weft/kernels/assemble/bending.hpp"
#include "weft/kernels/assemble/contact_cache.hpp"
#include "weft/kernels/assemble/plate.hpp"
#include "weft/kernels/assemble/pressure.hpp"
#include "weft/kernels/assemble/rest_shape_forces.hpp"
#include "weft/kernels/assemble/rest_shape_rows.hpp"
#include "weft/kernels/assemble/rows.hpp"
#include "weft/kernels/assemble/stretch_error.hpp"
#include "weft/kernels/assemble/wind.hpp"
#include "weft/kernels/integrate/advance.hpp"
#include "weft/kernels/integrate/apply_forces.hpp"
#include "weft/kernels/integrate/gather.hpp"
#include "weft/kernels/integrate/history.hpp"
#include "weft/kernels/integrate/moving_frame.hpp"
#include "weft/kernels/integrate/prescribe.hpp"
#include "weft/kernels/integrate/rate.hpp"
#include "weft/kernels/integrate/update.hpp"
#include "weft/kernels/integrate/world_positions.hpp"
#include "weft/kernels/respond/apply.hpp"
#include "weft/kernels/respond/remember.hpp"
#include "weft/kernels/solve/held_components.hpp"
#include "weft/kernels/solve/initial_guess.hpp"
#include "weft/kernels/solve/precondition.hpp"

/// Every element-wise kernel that computes in float or double. host/exec/element_wise.cpp and
/// cuda/exec/element_wise.cu instantiate these, and RespondRemember, which has no such numbers.
#define WEFT_ELEMENT_WISE_KERNELS(KERNEL) \
  KERNEL(AssembleBending)                 \
  KERNEL(AssembleContactCache)            \
  KERNEL(AssemblePlate)                   \
  KERNEL(AssemblePressure)                \
  KERNEL(AssembleRestShapeForces)         \
  KERNEL(AssembleRestShapeRows)           \
  KERNEL(AssembleRows)                    \
  KERNEL(AssembleStretchError)            \
  KERNEL(AssembleWind)                    \
  KERNEL(IntegrateAdvance)                \
  KERNEL(IntegrateApplyForces)            \
  KERNEL(IntegrateGather)                 \
  KERNEL(IntegrateHistory)                \
  KERNEL(IntegrateMovingFrame)            \
  KERNEL(IntegratePrescribe)              \
  KERNEL(IntegrateRate)                   \
  KERNEL(IntegrateUpdate)                 \
  KERNEL(IntegrateWorldPositions)         \
  KERNEL(RespondApply)                    \
  KERNEL(SolveHeldComponents)             \
  KERNEL(SolveInitialGuess)               \
  KERNEL(Precondition)
