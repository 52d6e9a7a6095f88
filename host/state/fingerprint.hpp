#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Everything that the state of a run depends on. Each part has a name, such as "pins[0]" or
/// "contact.friction", and a value as text; for a large part, such as a mesh, the value is a
/// checksum. It includes the camera only for the method "view", and never output, devices or the
/// number of frames.
using Fingerprint = std::vector<std::pair<std::string, std::string>>;

/// @pre validate(scene) passes
Fingerprint fingerprint_of(const Scene& scene);

/// One line for each part that differs, such as "NAME was THEN, now NOW" or "NAME has changed".
std::vector<std::string> differences_between(const Fingerprint& then, const Fingerprint& now);

/// @throws SceneError naming the differences, if there are any
/// @param file checkpoint
void refuse_differences(const std::vector<std::string>& differences,
                        const std::filesystem::path& file);

/// The bytes that a checkpoint stores.
std::string fingerprint_bytes(const Fingerprint& fingerprint);

/// Reads those bytes.
/// @return false if they are not a fingerprint
bool fingerprint_from(const std::string& bytes, Fingerprint& fingerprint);

}  // namespace weft
