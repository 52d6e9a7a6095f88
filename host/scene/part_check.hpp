#pragma once

#include <cstddef>
#include <string>

#include "weft/error.hpp"
#include "weft/scene.hpp"

namespace weft {

/// @param list its name in messages
/// @throws SceneError unless `id` is that of one of `count` parts of this scene
template <class Part>
void refuse_foreign(const Scene& scene, const Id<Part>& id, std::size_t count, const char* list) {
  if (id.scene != scene.identity.number())
    throw SceneError(scene.file, list, "a part of another scene",
                     "what this scene's add() has returned");
  if (id.index < 0 || static_cast<std::size_t>(id.index) >= count)
    throw SceneError(
        scene.file, list, "number " + std::to_string(id.index),
        count == 0 ? "none, as the list is empty" : "0 to " + std::to_string(count - 1));
}

/// @throws SceneError if a value of the wind is out of range
void validate_wind(const Scene& scene);

}  // namespace weft
