#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "host/io/scene_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

/// tests/support/check_schema.py reads the same folder.
namespace weft::io {
namespace {

namespace fs = std::filesystem;

/// Scene -> what its message must hold: the field and the value.
const std::map<std::string, std::pair<std::string, std::string>>& expected() {
  static const std::map<std::string, std::pair<std::string, std::string>> all{
      {"bad_json", {"bad JSON at line 2, column 27", "unexpected ','"}},
      {"box_pin_empty", {"pins[0].box: ", "[5,5,5]"}},
      {"box_pin_reversed", {"pins[0].box.max: ", "[1,1,0]"}},
      {"box_size", {"obstacles[0].box.size: ", "[1,1]"}},
      {"capsule_length", {"obstacles[0].capsule.length: ", "missing"}},
      {"capsule_radius", {"obstacles[0].capsule.radius: ", "0 is"}},
      {"capture_bone", {"obstacles[0].capture.radius.hip: ", "did you mean \"hips\"?"}},
      {"capture_channel", {"channel.bvh: line 4: CHANNELS: ", "\"Wrotation\""}},
      {"capture_frames", {"obstacles[0].capture.last_frame: ", "2 is"}},
      {"capture_missing", {"obstacles[0].capture.file: ", "\"meshes/none.bvh\""}},
      {"capture_scale_and_height", {"obstacles[0].capture.height: ", "2 is"}},
      {"capture_truncated", {"truncated.bvh: line 14: frame 2: ", "end of file"}},
      {"camera_field_of_view", {"camera.keys[0].field_of_view: ", "0 is"}},
      {"camera_look_at", {"camera.keys[0].look_at: ", "[2, 0, 1]"}},
      {"camera_no_position", {"camera.keys[0].position: ", "missing"}},
      {"camera_resolution", {"camera.resolution[1]: ", "0 is"}},
      {"camera_times", {"camera.keys[1].time: ", "1 is"}},
      {"camera_up", {"camera.keys[0].up: ", "[0, 0, 1]"}},
      {"checkpoint_every", {"output.checkpoint_every: ", "-1"}},
      {"cloth_name", {"cloths[0].name: ", "\"my cloth\""}},
      {"cloth_name_twice", {"cloths: ", "\"cloth\" given twice"}},
      {"cloths_object", {"cloths: ", "{\"name\":\"cloth\"}"}},
      {"contact_friction", {"contact.friction: ", "-0.1"}},
      {"contact_stiffness", {"contact.stiffness: ", "0 is"}},
      {"contact_untangle", {"contact.untangle: ", "\"yes\""}},
      {"copies_zero", {"cloths[0].copies.count: ", "0 is"}},
      {"cylinder_cells", {"cloths[0].cylinder.cells: ", "[2,4]"}},
      {"diagonals", {"cloths[0].grid.diagonals: ", "\"crossed\""}},
      {"disc_inner_radius", {"cloths[0].disc.inner_radius: ", "0.3 is"}},
      {"disc_radius", {"cloths[0].disc.radius: ", "0 is"}},
      {"duplicate_key", {"\"precision\"", "given twice"}},
      {"edge_part", {"pins[0].edge.name: ", "missing"}},
      {"empty", {"bad JSON at line 1, column 1", "unexpected end of input"}},
      {"fabric", {"materials.cotton.fabric: ", "\"felt\""}},
      {"grid_and_mesh", {"cloths[0]: ", "grid, mesh"}},
      {"grid_zero_cells", {"cloths[0].grid.cells[0]: ", "0 is"}},
      {"grid_zero_size", {"cloths[0].grid.size: ", "[1,0]"}},
      {"halvings", {"contact.halvings: ", "-1"}},
      {"handle_circumference", {"handles[0].circle.circumference: ", "0 is"}},
      {"handle_end", {"handles[0].end_time: ", "1 is"}},
      {"handle_glue", {"handles[0].glue: ", "[3]"}},
      {"jitter_amplitude", {"jitter.amplitude: ", "0.03"}},
      {"material_no_groups", {"cloths[0].material: ", "no groups of faces"}},
      {"max_iterations", {"solver.max_iterations: ", "0 is"}},
      {"measured_and_orthotropic", {"materials.cotton.orthotropic: ", "900"}},
      {"measured_form", {"materials.cotton.measured.form: ", "\"table\""}},
      {"measured_row", {"materials.cotton.measured.stretching", "50"}},
      {"measured_rows", {"materials.cotton.measured.stretching: ", "50"}},
      {"measured_warp", {"materials.cotton.measured.stretching[0][0]: ", "-50 is"}},
      {"mesh_duplicate", {"duplicate.obj: mesh.triangles: ", "triangle 2 like 1"}},
      {"mesh_empty", {"empty.obj: v: ", "no vertices"}},
      {"mesh_flipped_neighbour",
       {"flipped_neighbour.obj: mesh.triangles: ", "triangle 1 beside 0"}},
      {"mesh_huge_count", {"huge_count.ply: element \"vertex\": ", "4000000000"}},
      {"mesh_index", {"index.obj: line 6: f vertex: ", "\"5\""}},
      {"mesh_inverted", {"inverted.obj: mesh.material: ", "triangle 1"}},
      {"mesh_isolated", {"isolated.obj: mesh.positions: ", "vertex 4"}},
      {"mesh_missing", {"cloths[0].mesh: ", "\"meshes/none.obj\""}},
      {"mesh_nan", {"nan.obj: line 3: v[1]: ", "\"nan\""}},
      {"mesh_non_manifold", {"non_manifold.obj: mesh.triangles: ", "edge 0-2 of triangles 0 1 2"}},
      {"mesh_not_flat", {"not_flat.obj: vt: ", "not flat"}},
      {"mesh_seam", {"seam.obj: mesh.material: ", "inverted in material space (triangle 1)"}},
      {"mesh_truncated", {"truncated.ply: element \"face\" row 1: ", "length 3"}},
      {"mesh_unknown_format", {"unknown.format: format: ", "\".format\""}},
      {"mesh_zero_area", {"zero_area.obj: mesh.triangles: ", "triangle 2"}},
      {"mesh_zero_material_area", {"zero_material_area.obj: mesh.material: ", "triangle 1"}},
      {"missing_material", {"cloths[0].material: ", "missing"}},
      {"motion_decreasing", {"obstacles[0].motion[2].time: ", "1 is"}},
      {"motion_equal_times", {"obstacles[0].motion[1].time: ", "0 is"}},
      {"motion_no_time", {"obstacles[0].motion[1].time: ", "missing"}},
      {"motion_one_key", {"obstacles[0].motion: ", "one key"}},
      {"nan", {"bad JSON at line 2, column 21", "invalid literal"}},
      {"negative_bending", {"materials.cotton.bending_stiffness: ", "-1e-05"}},
      {"negative_damping", {"materials.cotton.damping.mass: ", "-1"}},
      {"negative_density", {"materials.cotton.density: ", "-0.1"}},
      {"negative_time_step", {"time.step: ", "-0.005"}},
      {"newton_iterations", {"solver.newton_iterations: ", "0 is"}},
      {"newton_tolerance", {"solver.newton_tolerance: ", "0 is"}},
      {"no_cloths", {"cloths: ", "[]"}},
      {"not_an_object", {"scene: ", "[]"}},
      {"number_overflow", {"bad JSON at line 2, column 21", "1e999"}},
      {"obstacle_friction", {"obstacles[0].friction: ", "-1"}},
      {"obstacle_mesh_zero_area", {"zero_area.obj: mesh.triangles: ", "triangle 2"}},
      {"obstacle_name_twice", {"obstacles[1].name: ", "\"ball\""}},
      {"obstacle_no_shape", {"obstacles[0]: ", "none of"}},
      {"obstacle_two_shapes", {"obstacles[0]: ", "sphere, box"}},
      {"partial_rows", {"solver.partial_rows: ", "1000"}},
      {"pin_corner", {"pins[0].corners[0]: ", "\"top_left\""}},
      {"pin_edge", {"pins[0].edge: ", "\"upper\""}},
      {"pin_edge_of_mesh", {"pins[0].edge: ", "\"top\""}},
      {"pin_negative", {"pins[0].vertices[0]: ", "-1"}},
      {"pin_no_vertices", {"pins[0].vertices: ", "[]"}},
      {"pin_out_of_range", {"pins[0].vertices[1]: ", "25"}},
      {"pin_release", {"pins[0].release_time: ", "0 is"}},
      {"pin_twice", {"pins[0].vertices[2]: ", "3, which"}},
      {"orthotropic_and_isotropic", {"materials.cotton.stretch_stiffness: ", "500 is"}},
      {"orthotropic_bending_coupling",
       {"materials.cotton.orthotropic_bending.coupling: ", "3e-05 is"}},
      {"orthotropic_bending_stiffness",
       {"materials.cotton.orthotropic_bending.stiffness: ", "[1e-05,-4e-05] is"}},
      {"orthotropic_bending_twist", {"materials.cotton.orthotropic_bending.twist: ", "-1e-06 is"}},
      {"orthotropic_indefinite", {"materials.cotton.orthotropic.poisson_ratio: ", "0.5 is"}},
      {"orthotropic_no_shear", {"materials.cotton.orthotropic.shear_stiffness: ", "missing"}},
      {"orthotropic_weft", {"materials.cotton.orthotropic.stretch_stiffness[1]: ", "-3 is"}},
      {"panel_cells", {"cloths[0].panel.cells: ", "[4,1]"}},
      {"panel_heights", {"cloths[0].panel.outline[2]: ", "0.4 is"}},
      {"panel_one_height", {"cloths[0].panel.outline: ", "1 heights"}},
      {"panel_width", {"cloths[0].panel.outline[1]: ", "a width > 0"}},
      {"pin_obstacle", {"pins[0].obstacle: ", "did you mean \"ball\"?"}},
      {"pin_obstacle_and_motion", {"pins[0].obstacle: ", "not both"}},
      {"pin_two_selections", {"pins[0]: ", "vertices, edge"}},
      {"plane_cells", {"obstacles[0].plane.cells[1]: ", "0 is"}},
      {"poisson_ratio", {"materials.cotton.poisson_ratio: ", "0.6"}},
      {"revolution_pole", {"obstacles[0].revolution.profile: ", "radius 0 only"}},
      {"revolution_radius", {"obstacles[0].revolution.profile[1]: ", "-0.1 is"}},
      {"rest_missing", {"cloths[0].rest: ", "\"meshes/none.obj\""}},
      {"rest_number", {"cloths[0].rest: ", "1 is"}},
      {"rest_sewn", {"cloths[1].rest: ", "seams[0]"}},
      {"rest_triangles", {"other_diagonal.obj: triangles: ", "another triangle 0"}},
      {"rest_vertices", {"square.obj: vertices: ", "4 vertices"}},
      {"rotate_zero_axis", {"cloths[0].transform.rotate: ", "[30,0,0,0]"}},
      {"scale_zero", {"cloths[0].transform.scale: ", "0 is"}},
      {"pressure", {"cloths[0].pressure: ", "\"high\""}},
      {"refine_levels", {"refine.levels: ", "7 is"}},
      {"refine_no_seams", {"refine.when: ", "without seams"}},
      {"refine_no_when", {"refine.when: ", "missing"}},
      {"refine_not_welded", {"seams[0].weld_distance: ", "0 beside refine"}},
      {"refine_pc2", {"output.format: ", "\"pc2\""}},
      {"seam_between_cloths", {"seams[0].cloths: ", "[\"front\",\"back\"]"}},
      {"seam_chain_lengths", {"seams[0].chains: ", "3 and 2 vertices"}},
      {"seam_chain_out_of_range", {"seams[0].chains[0][1]: ", "9 is"}},
      {"seam_copies", {"seams[0].cloths: ", "1 and 2 cloths"}},
      {"seam_itself", {"seams[0]: ", "pair 1, vertex 4 of cloth \"front\" sewn to itself"}},
      {"seam_negative", {"seams[0].pairs[0][1]: ", "-2"}},
      {"seam_no_cloths", {"seams[0]: ", "none of cloth, cloths"}},
      {"seam_no_kind", {"seams[0]: ", "none of pairs, chains, between"}},
      {"seam_no_pairs", {"seams[0].pairs: ", "[]"}},
      {"seam_no_partner",
       {"seams[0].between: ", "3 and 2 vertices, vertex 6 of cloth \"front\" without a partner"}},
      {"seam_one_cloth", {"seams[0].cloths: ", "[\"front\"]"}},
      {"seam_one_selection", {"seams[0].between: ", "\"edge\":\"left\""}},
      {"seam_orientation", {"seams: ", "run the same way"}},
      {"seam_out_of_range", {"seams[0].pairs[1][1]: ", "9 is"}},
      {"seam_pair_of_three", {"seams[0].pairs[1]: ", "[3,5,8]"}},
      {"seam_ramp_time", {"seams[0].ramp_time: ", "-0.5 is"}},
      {"seam_selection_key", {"seams[0].between[0].edges: ", "did you mean \"edge\"?"}},
      {"seam_start_time", {"seams[0].start_time: ", "-1 is"}},
      {"seam_stiffness", {"seams[0].stiffness: ", "0 is"}},
      {"seam_three_panels", {"seams: ", "welded along one edge"}},
      {"seam_triangle",
       {"seams: ", "vertex 0 of cloth \"front\" sewn to vertex 1 of cloth \"front\""}},
      {"seam_triangle_by_way",
       {"seams: ", "vertex 0 of cloth \"front\" sewn to vertex 1 of cloth \"front\""}},
      {"seam_twice",
       {"seams[1]: ", "vertex 0 of cloth \"front\" sewn to vertex 8 of cloth \"front\" twice"}},
      {"seam_two_kinds", {"seams[0]: ", "pairs, chains,"}},
      {"seam_unknown_cloth", {"seams[0].cloths[1]: ", "did you mean \"back\"?"}},
      {"seam_weld_distance", {"seams[0].weld_distance: ", "-1 is"}},
      {"seam_weld_too_near", {"seams[0].weld_distance: ", "4e-04 is"}},
      {"sequence_frame_rate", {"obstacles[0].sequence.frame_rate: ", "0 is"}},
      {"sequence_missing", {"none_0.obj: ", "No such file"}},
      {"sequence_no_place", {"isolated.obj: files: ", "no place for a number"}},
      {"sequence_two_kinds", {"obstacles[0].sequence: ", "files, points"}},
      {"short_vector", {"gravity: ", "[0,0]"}},
      {"skinned_not_animated", {"not_flat.obj: animation: ", "none in the file"}},
      {"skinned_scale", {"obstacles[0].skinned.scale: ", "-1"}},
      {"sphere_radius", {"obstacles[0].sphere.radius: ", "-1"}},
      {"sphere_subdivisions", {"obstacles[0].sphere.subdivisions: ", "9"}},
      {"strain_limits_max", {"materials.cotton.strain_limits[1]: ", "0.95 is"}},
      {"strain_limits_min", {"materials.cotton.strain_limits[0]: ", "1.02 is"}},
      {"strain_limits_one", {"materials.cotton.strain_limits: ", "[1.1]"}},
      {"thickness_zero", {"contact.thickness: ", "0 is"}},
      {"tolerance", {"solver.tolerance: ", "1 is"}},
      {"too_many_steps", {"time.step: ", "1e-12"}},
      {"too_many_triangles", {"cloths: ", "20000000000.0 triangles"}},
      {"triangles_too_few", {"triangles: ", "99"}},
      {"triangles_too_many", {"triangles: ", "4000001"}},
      {"truncated", {"bad JSON at line 3, column 27", "missing closing quote"}},
      {"unknown_cloth", {"pins[0].cloth: ", "did you mean \"cloth\"?"}},
      {"unknown_cloth_key", {"cloths[0].materal: ", "did you mean \"material\"?"}},
      {"unknown_format", {"output.format: ", "\"stl\""}},
      {"unknown_integrator", {"method.integrator: ", "\"rk4\""}},
      {"unknown_key", {"time.stepp: ", "did you mean \"step\"?"}},
      {"unknown_material", {"cloths[0].material: ", "\"coton\""}},
      {"unknown_method", {"method.type: ", "\"implict\""}},
      {"unknown_precision", {"precision: ", "\"half\""}},
      {"unknown_root_key", {"obstacle: ", "did you mean \"obstacles\"?"}},
      {"vector_of_text", {"gravity[2]: ", "\"low\""}},
      {"wind_density", {"wind.density: ", "-1"}},
      {"wrong_type", {"gravity: ", "\"down\""}},
      {"wrong_type_boolean", {"contact.self: ", "1 is"}},
      {"wrong_type_integer", {"time.frames: ", "2.5"}},
      {"zero_frame_rate", {"time.frame_rate: ", "0 is"}},
      {"zero_frames", {"time.frames: ", "0 is"}},
      {"thickness_alone", {"materials.cotton.young_modulus: ", "missing"}},
      {"yielding_distance", {"contact.yielding_distance: ", "-0.01"}},
      {"young_modulus", {"materials.cotton.young_modulus: ", "0 is"}},
      {"young_modulus_and_stretch", {"materials.cotton.stretch_stiffness: ", "300 is"}},
      {"zero_stretch", {"materials.cotton.stretch_stiffness: ", "0 is"}},
      {"zero_time_step", {"time.step: ", "0 is"}},
      {"zone_rounds", {"contact.zone_rounds: ", "0 is"}},
  };
  return all;
}

TEST(BrokenScenes, AreRefusedWithFieldAndValue) {
  const fs::path folder = repository_root() / "tests" / "support" / "broken_scenes";
  for (const auto& [name, message] : expected()) {
    const fs::path path = folder / (name + ".json");
    ASSERT_TRUE(fs::exists(path)) << path;
    try {
      read_scene(path);
      ADD_FAILURE() << name << " was accepted";
    } catch (const SceneError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(message.first), std::string::npos) << name << ": " << what;
      EXPECT_NE(what.find(message.second), std::string::npos) << name << ": " << what;
      EXPECT_NE(what.find(folder.string()), std::string::npos) << name << ": " << what;
      EXPECT_EQ(what.find('\n'), std::string::npos) << name << ": " << what;
    }
  }
}

TEST(BrokenScenes, AreAllInTheTable) {
  const fs::path folder = repository_root() / "tests" / "support" / "broken_scenes";
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    EXPECT_TRUE(expected().contains(entry.path().stem().string())) << entry.path();
  }
}

}  // namespace
}  // namespace weft::io
