#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// All that the state of a run depends on, part by part: a name such as "pins[0]" or
/// "contact.friction", and its value as text. Large parts, such as meshes, stand there as a
/// checksum. Output, devices and the number of frames are left out; the camera counts for the
/// method "view" only.
using Fingerprint = std::vector<std::pair<std::string, std::string>>;

/// @pre validate(scene) passes
Fingerprint fingerprint_of(const Scene& scene);

/// One line for each part that differs: "NAME was THEN, now NOW".
std::vector<std::string> differences_between(const Fingerprint& then, const Fingerprint& now);

/// @throws SceneError naming the differences, if there are any
/// @param file checkpoint
void refuse_differences(const std::vector<std::string>& differences,
                        const std::filesystem::path& file);

/// As a checkpoint holds it.
std::string fingerprint_bytes(const Fingerprint& fingerprint);

/// @return false if the bytes are no fingerprint
bool fingerprint_from(const std::string& bytes, Fingerprint& fingerprint);

}  // namespace weft
