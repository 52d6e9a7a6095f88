#pragma once

#include <string_view>

namespace weft::io {
class OutlineFile;
}

/// One function a reader, for libFuzzer and for the unit tests alike. Each makes a file of its
/// input, has it read, and returns if the reader took it or refused it with a SceneError of one
/// printable line. Whatever else the reader throws passes through; a broken promise of the reader,
/// or content that does not survive being written and read again, throws std::logic_error.
namespace weft::fuzz {

void obj(std::string_view input);
void ply(std::string_view input);
void pc2(std::string_view input);           ///< alone, and as a sequence beside its mesh
void bvh(std::string_view input);           ///< and the body made of it
void mot(std::string_view input);           ///< motion capture of ARCSim
void material(std::string_view input);      ///< material file of ARCSim
void arcsim_scene(std::string_view input);  ///< the translation alone
void scene(std::string_view input);         ///< weft's and ARCSim's; resolved, it is the same scene
void pattern(std::string_view input);       ///< sewing patterns of GarmentCode, and their meshes
void dxf(std::string_view input);           ///< outlines of panels, in both kinds of units
void svg(std::string_view input);           ///< the same
void usda(std::string_view input);
void spool(std::string_view input);       ///< as it is, and with checksums that fit
void checkpoint(std::string_view input);  ///< the same, in both precisions

/// Panels of outlines are closed, or refused.
void require_panels(const io::OutlineFile& outlines);

struct Target {
  std::string_view name;  ///< of the folder with its seeds
  void (*run)(std::string_view input);
};

inline constexpr Target targets[] = {
    {"obj", obj},         {"ply", ply},
    {"pc2", pc2},         {"bvh", bvh},
    {"mot", mot},         {"material", material},
    {"scene", scene},     {"arcsim_scene", arcsim_scene},
    {"pattern", pattern}, {"dxf", dxf},
    {"svg", svg},         {"usda", usda},
    {"spool", spool},     {"checkpoint", checkpoint},
};

}  // namespace weft::fuzz
