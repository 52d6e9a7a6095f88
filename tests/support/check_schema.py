#!/usr/bin/env python3
"""Keeps scenes/scene.schema.json and the scene reader in step.

Every scene in scenes/ must pass the schema. Every scene in tests/support/broken_scenes/ must fail
it, or fail to parse, unless BEYOND_SCHEMA lists it; one that is listed must pass, so that the list
stays exact. That the reader accepts the former and refuses all of the latter is tested in
tests/unit/io/broken_scenes.cpp.

usage: check_schema.py [REPOSITORY] [SCENE...]    scenes are further files that must pass
"""

import json
import math
import pathlib
import sys

import jsonschema

# Each key has a user who would miss it; more of them need a reason, and this number.
MOST_KEYS = 179

# What no schema can say: references between parts, orders, sums, and the content of other files.
BEYOND_SCHEMA = {
    "until_time_parallel", "output_frames_time_parallel", "automatic_asynchronous", "automatic_frame", "automatic_sleep", "automatic_time_parallel",
    "asynchronous_bdf2", "asynchronous_float", "asynchronous_handle", "asynchronous_limits",
    "asynchronous_pressure", "asynchronous_wind", "time_parallel_seams",
    "time_parallel_adaptive_format",
    "time_parallel_view_camera",
    "driven_axis", "driven_method", "driven_motion", "driven_times",
    "seam_unknown_cloth", "seam_out_of_range", "seam_chain_out_of_range", "seam_chain_lengths",
    "seam_itself", "seam_twice", "seam_triangle", "seam_triangle_by_way",
    "seam_orientation", "seam_stacked_triangles", "seam_to_itself", "seam_part_beyond", "seam_no_partner", "seam_copies",
    "seam_weld_too_near", "refine_no_seams", "refine_not_welded", "refine_pc2", "refine_glb",
    "remeshing_size", "ribbon_across", "ribbon_same_point", "adaptive_pc2", "adaptive_glb", "glb_frames", "pin_group",
    "mesh_usd_units", "mesh_usd_transform", "adaptive_rest", "adaptive_refine",
    "handle_along", "handle_end", "jitter_amplitude", "material_no_groups", "pin_obstacle",
    "measured_warp", "orthotropic_bending_coupling", "orthotropic_indefinite",
    "disc_inner_radius", "panel_cells", "panel_heights", "panel_width", "revolution_pole",
    "camera_look_at", "camera_times", "camera_up",
    "box_pin_empty", "box_pin_reversed", "capture_bone", "capture_channel", "capture_frames",
    "capture_missing", "capture_truncated", "cloth_name_twice", "mesh_duplicate", "mesh_empty",
    "mesh_flipped_neighbour", "mesh_huge_count", "mesh_index", "mesh_inverted", "mesh_isolated",
    "mesh_missing", "mesh_nan", "garment_missing", "mesh_non_manifold", "mesh_not_flat", "mesh_seam", "mesh_truncated",
    "mesh_unknown_format", "mesh_zero_area", "mesh_zero_material_area", "motion_decreasing",
    "motion_equal_times", "obstacle_mesh_zero_area", "obstacle_name_twice", "pin_edge_of_mesh",
    "pin_out_of_range", "pin_twice", "rest_missing", "rest_triangles",
    "rest_vertices", "rotate_zero_axis", "sequence_missing", "sequence_no_place",
    "skinned_not_animated", "sleep_method", "too_many_steps", "too_many_triangles", "unknown_cloth",
    "unknown_material", "fabric_not_material", "view_track",
    "no_materials", "pin_obstacle_none", "repair_nothing_left", "motion_too_far", "mesh_too_far",
    "refine_too_fine",
}


def without_comments(text: str) -> str:
    """Blanks out // comments, but not inside strings."""
    out, i, in_string = [], 0, False
    while i < len(text):
        c = text[i]
        if in_string and c == "\\":
            out.append(text[i : i + 2])
            i += 2
            continue
        if c == '"':
            in_string = not in_string
        if not in_string and text.startswith("//", i):
            end = text.find("\n", i)
            i = len(text) if end < 0 else end
            continue
        out.append(c)
        i += 1
    return "".join(out)


def unique_keys(pairs):
    keys = [key for key, _ in pairs]
    if len(set(keys)) != len(keys):
        raise ValueError("a key is given twice")
    return dict(pairs)


def finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} overflows")
    return value


def no_constant(text: str):
    raise ValueError(f"{text} is no JSON")


def load(path: pathlib.Path):
    """Raises ValueError for anything that is no JSON as the reader takes it."""
    return json.loads(
        without_comments(path.read_text(encoding="utf-8")),
        object_pairs_hook=unique_keys, parse_float=finite, parse_constant=no_constant)


def first_error(validator, path: pathlib.Path):
    """Why the scene fails, as one line, or None."""
    try:
        scene = load(path)
    except ValueError as error:
        return f"does not parse: {error}"
    errors = sorted(validator.iter_errors(scene), key=lambda e: list(map(str, e.path)))
    if not errors:
        return None
    return "/".join(map(str, errors[0].path)) + ": " + errors[0].message


def leaf_keys(schema) -> int:
    """Keys that hold no object with keys of its own; a shared definition counts once."""
    definitions = schema.get("$defs", {})

    def holds_keys(node) -> bool:
        name = node.get("$ref", "").removeprefix("#/$defs/")
        return (count(node) > 0 or (name in definitions and holds_keys(definitions[name]))
                or any(holds_keys(entry) for entry in parts(node)))

    def parts(node):
        of_lists = [node[word] for word in ("items", "additionalProperties")
                    if isinstance(node.get(word), dict)]
        return of_lists + [entry for word in ("oneOf", "anyOf", "allOf")
                           for entry in node.get(word, [])]

    def count(node) -> int:
        below = sum(count(entry) for entry in parts(node))
        for value in node.get("properties", {}).values():
            below += count(value) or (0 if holds_keys(value) else 1)
        return below

    return count(schema) + sum(count(entry) for entry in definitions.values())


def main() -> int:
    here = pathlib.Path(__file__).resolve()
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else here.parents[2]
    schema_path = root / "scenes" / "scene.schema.json"
    schema = load(schema_path)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)

    failures = []
    good = [p for p in sorted((root / "scenes").glob("*.json")) if p != schema_path]
    good += [pathlib.Path(name) for name in sys.argv[2:]]
    if not good:
        failures.append("no scenes found")
    for path in good:
        error = first_error(validator, path)
        if error:
            failures.append(f"{path}: should pass the schema: {error}")

    broken = sorted((root / "tests" / "support" / "broken_scenes").glob("*.json"))
    if not broken:
        failures.append("no broken scenes found")
    for path in broken:
        error = first_error(validator, path)
        if path.stem in BEYOND_SCHEMA:
            if error:
                failures.append(f"{path}: listed in BEYOND_SCHEMA, but: {error}")
        elif not error:
            failures.append(f"{path}: should fail the schema, or stand in BEYOND_SCHEMA")
    for name in sorted(BEYOND_SCHEMA - {path.stem for path in broken}):
        failures.append(f"{name}: listed in BEYOND_SCHEMA, but there is no such scene")

    if leaf_keys(schema) > MOST_KEYS:
        failures.append(f"{leaf_keys(schema)} keys; at most {MOST_KEYS}")

    for failure in failures:
        print(failure)
    print(f"{leaf_keys(schema)} keys; {len(good)} good and {len(broken)} broken scenes, "
          f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
