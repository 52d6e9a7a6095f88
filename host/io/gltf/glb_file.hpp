#pragma once

#include <filesystem>

#include "host/io/spool/frame_spool.hpp"

namespace weft::io {

/// Writes an animated binary glTF 2.0 file from a spool, for programs that show or render it. A
/// root node "World" turns z up into the y up of glTF and holds the origin of the spool; below it
/// are the nodes "cloths" and "obstacles" with a node per mesh. A mesh that deforms has a morph
/// target per frame, whose weights are animated; an obstacle that moves as a rigid body, or grows
/// or shrinks as a whole, has an animated node; anything else stands once. Times are frame numbers
/// over the frame rate; linear between frames. Groups are materials; a mesh has a primitive for
/// each material and part, whose extras name the panel and its label. Vertices keep their numbers;
/// a vertex with several texture coordinates is repeated at the end. Seam edges are a primitive of
/// lines. Holds one mesh at a time.
/// Written beside the target, then renamed.
/// @param seams [cloths or none] of each mesh; their vertices are those of the meshes
/// @throws SceneError if the spool has no frames or is damaged, if a mesh changes its triangles, if
///         there are more frames or bytes than a file can hold, or it cannot be written
void write_glb(const std::filesystem::path& path, const SpoolReader& spool,
               const SeamEdges& seams = {});

}  // namespace weft::io
