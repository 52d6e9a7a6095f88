#pragma once

namespace weft {

/// By how much contacts are not what the last solve took them for.
struct ContactMismatch {
  double impulse = 0;  ///< [N s] over the corners of all contacts
  // Largest of all components of cloth:
  double friction = 0;  ///< by how much it is off, in weights of the component
  double pull = 0;      ///< what contacts pull, of the component's weight and what they push
};

}  // namespace weft
