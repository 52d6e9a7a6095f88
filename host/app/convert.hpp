#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft convert IN OUT [--frame N]... [--only cloths|obstacles]`: writes meshes and
/// animations in another format, which the ending of OUT says. IN is what io::open_sequence()
/// takes: the directory of a run, numbered meshes (DIR/%05d.obj), an animated .usda, a .pc2 beside
/// its mesh, or any mesh file. OUT: .obj and .ply hold one frame, or have a place for its number
/// (%05d); .pc2 holds all frames of one mesh, whose first frame stands beside it as .obj (several
/// meshes: NAME_MESH.pc2); .usda holds everything, and so does .glb if no mesh changes its
/// triangles. From a scene of ARCSim or a sewing pattern of GarmentCode, OUT is a scene (.json); of
/// a pattern `[--body MESH] [--edge M] [--fabric NAME]` say what it is cut for.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set to 0 when the subcommand has run
void add_convert_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
