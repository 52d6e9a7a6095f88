"""Run by Blender: makes the scenes of the tests, and writes down what a .blend file shows.

    blender -b --factory-startup --python-exit-code 1 -P blender_scenes.py -- make FOLDER NAME...
    blender -b FILE.blend --python-exit-code 1 -P blender_scenes.py -- look OUT.json FRAME...
    blender -b FILE.blend --python-exit-code 1 -P blender_scenes.py -- operate ADDON FOLDER
"""

import json
import sys

import bmesh
import bpy
from mathutils import Matrix


def new_object(name, build):
    mesh = bpy.data.meshes.new(name)
    work = bmesh.new()
    build(work)
    work.to_mesh(mesh)
    work.free()
    item = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(item)
    return item


def grid(size, cells):
    def build(work):
        bmesh.ops.create_grid(work, x_segments=cells, y_segments=cells, size=size / 2, calc_uvs=False)
        layer = work.loops.layers.uv.new("UVMap")
        for face in work.faces:
            for loop in face.loops:  # in 0..1, as Blender unwraps
                loop[layer].uv = (loop.vert.co.x / size + 0.5, loop.vert.co.y / size + 0.5)
    return build


def cube(size):
    return lambda work: bmesh.ops.create_cube(work, size=size)


def key_place(item, places):
    for frame, place, angle in places:
        item.location = place
        item.rotation_euler = (0, 0, angle)
        item.keyframe_insert("location", frame=frame)
        item.keyframe_insert("rotation_euler", frame=frame)


def hanging(units_per_metre=1.0):
    """A sheet that a modifier refines hangs by two corners; a mirrored cube comes up from below."""
    scene = bpy.context.scene
    if units_per_metre != 1.0:
        scene.unit_settings.scale_length = 1 / units_per_metre
    scene.render.fps = 30
    scene.frame_start, scene.frame_end = 5, 11
    sheet = new_object("red sheet", grid(0.4 * units_per_metre, 6))
    sheet.location = (0, 0, 1 * units_per_metre)
    sheet.modifiers.new("finer", "SUBSURF").subdivision_type = "SIMPLE"
    sheet["weft"] = "cloth"
    sheet["weft_fabric"] = "denim"
    group = sheet.vertex_groups.new(name="weft_pin")
    group.add([v.index for v in sheet.data.vertices if v.co.y > 0.19 * units_per_metre], 1.0, "REPLACE")
    block = new_object("block", cube(0.1 * units_per_metre))
    block.scale = (-1, 1, 1.5)
    key_place(block, ((5, (0, 0, 0.8 * units_per_metre), 0), (11, (0, 0, 0.9 * units_per_metre), 1.2)))
    floor = new_object("floor", lambda work: bmesh.ops.create_circle(
        work, segments=7, radius=units_per_metre, cap_ends=True))
    floor.data.vertices.add(1)  # a loose vertex, which weft does not allow
    hidden = new_object("spare", cube(1.0))
    hidden["weft"] = "ignore"


def centimetres():
    hanging(100.0)


def carried():
    """The pins of a stretched UV map follow a body."""
    hanging()
    sheet = bpy.data.objects["red sheet"]
    sheet["weft_pins_follow"] = "block"
    for loop in sheet.data.uv_layers.active.data:
        loop.uv[0] *= 3


def mirrored():
    """Both halves have the map of the right one."""
    hanging()
    for loop in bpy.data.objects["red sheet"].data.uv_layers.active.data:
        loop.uv[0] = abs(loop.uv[0] - 0.5)


def sewn():
    """Two panels in one mesh; edges without a face join them."""
    hanging()
    sheet = bpy.data.objects["red sheet"]
    sheet.modifiers.clear()
    work = bmesh.new()
    work.from_mesh(sheet.data)
    middle = [face for face in work.faces if abs(face.calc_center_median().x) < 0.06]
    bmesh.ops.delete(work, geom=middle, context="FACES")
    for vertex in work.verts:
        vertex.co.x -= 0.062 * (1 if vertex.co.x > 0 else -1)
    right = [vertex for vertex in work.verts if 0 < vertex.co.x < 0.02]
    for vertex in right:
        work.edges.new((vertex, next(other for other in work.verts if -0.02 < other.co.x < 0
                                     and abs(other.co.y - vertex.co.y) < 0.01)))
    work.to_mesh(sheet.data)
    work.free()
    # Two pinned vertices cannot be pulled together.
    sheet.vertex_groups[0].remove([v.index for v in sheet.data.vertices if abs(v.co.x) < 0.02])


def no_cloth():
    hanging()
    del bpy.data.objects["red sheet"]["weft"]


def changing_body():
    hanging()
    build = bpy.data.objects["block"].modifiers.new("build", "BUILD")
    build.frame_start, build.frame_duration = 1, 10


def no_map():
    hanging()
    sheet = bpy.data.objects["red sheet"]
    sheet.data.uv_layers.remove(sheet.data.uv_layers.active)
    sheet.data.vertices[0].co.z += 0.1


def operate(addon, folder):
    """Installs the add-on in a file made by `hanging`, and does with its operators what its panel does."""
    bpy.ops.preferences.addon_install(filepath=addon)
    bpy.ops.preferences.addon_enable(module="weft_blender")
    sheet, block = bpy.data.objects["red sheet"], bpy.data.objects["block"]

    def select(*items):
        for item in bpy.data.objects:
            item.select_set(item in items)

    select(sheet)
    del sheet["weft"]
    bpy.ops.weft.set_role(role="cloth")
    assert sheet.weft_fabric_choice == "denim" and sheet.weft_pins_follow_choice == ""
    sheet.weft_fabric_choice = "swimwear"
    sheet.weft_pins_follow_choice = "block"
    select(sheet, block)
    assert bpy.ops.weft.export_scene(filepath=f"{folder}/operated.json") == {"FINISHED"}
    assert bpy.ops.weft.import_run(directory=f"{folder}/run/") == {"FINISHED"}
    select(bpy.data.objects["red_sheet"])
    assert bpy.ops.weft.bake(target="pc2", directory=folder) == {"FINISHED"}
    try:
        bpy.ops.weft.import_run(directory=f"{folder}/none/")
    except RuntimeError as error:
        assert "scene.json: is missing" in str(error), error
    else:
        assert False, "a run that is missing"
    bpy.ops.preferences.addon_disable(module="weft_blender")
    assert not hasattr(bpy.types.Object, "weft_fabric_choice")


def look(out, frames):
    scene = bpy.context.scene
    seen = {"start": scene.frame_start, "end": scene.frame_end,
            "rate": scene.render.fps / scene.render.fps_base, "frames": {}, "local": {}}
    for frame in frames:
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        positions = seen["frames"][str(frame)] = {}
        local = seen["local"][str(frame)] = {}
        for item in bpy.data.objects:
            if item.type != "MESH" or not item.visible_get():
                continue
            evaluated = item.evaluated_get(graph)
            mesh = evaluated.to_mesh()
            matrix = Matrix(evaluated.matrix_world)
            positions[item.name] = [list(matrix @ vertex.co) for vertex in mesh.vertices]
            local[item.name] = [list(vertex.co) for vertex in mesh.vertices]
            evaluated.to_mesh_clear()
    seen["locations"] = {item.name: list(item.location) for item in bpy.data.objects}
    seen["modifiers"] = {item.name: [m.type for m in item.modifiers] for item in bpy.data.objects}
    seen["shape_keys"] = {item.name: len(item.data.shape_keys.key_blocks) for item in bpy.data.objects
                          if item.type == "MESH" and item.data.shape_keys}
    with open(out, "w", encoding="ascii") as stream:
        json.dump(seen, stream)


def main():
    action, *rest = sys.argv[sys.argv.index("--") + 1 :]
    if action == "make":
        for name in rest[1:]:
            bpy.ops.wm.read_factory_settings(use_empty=True)
            globals()[name]()
            bpy.ops.wm.save_as_mainfile(filepath=f"{rest[0]}/{name}.blend")
    elif action == "operate":
        operate(*rest)
    else:
        look(rest[0], [int(frame) for frame in rest[1:]])


main()
