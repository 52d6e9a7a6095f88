#pragma once

namespace weft {

/// By how much contacts are not what the last solve took them for.
struct ContactMismatch {
  double impulse = 0;   ///< [N s] over the corners of all contacts
  double friction = 0;  ///< largest of all components of cloth, in weights of the component
};

}  // namespace weft
