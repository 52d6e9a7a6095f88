"""Run by Blender: reads an animation as an artist would and writes down where the vertices are.

    blender -b --factory-startup --python-exit-code 1 --python blender_positions.py -- \
        obj|pc2|usd|glb FILE OUT FRAME...

OUT gets a line a vertex: frame, name of the object, x, y, z, in the order of objects and vertices.
For pc2 FILE is the cache; the mesh stands beside it as .obj. Exit code 77: this Blender cannot read
the format.
"""

import os
import sys

import bpy


def import_objects(mode, file):
    """Returns the imported mesh objects, by name."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    if mode == "usd":
        if not bpy.app.build_options.usd:
            sys.exit(77)
        # The frames of the file are those of the scene.
        bpy.ops.wm.usd_import(filepath=file, set_frame_range=True, scale=1.0)
    elif mode == "glb":
        if "gltf" not in dir(bpy.ops.import_scene):
            sys.exit(77)
        # Times of the file are seconds.
        bpy.context.scene.render.fps = 25
        try:
            # Not shaded by normals: there Blender 3.4 fails with NumPy 1.24, which Debian 12 has.
            bpy.ops.import_scene.gltf(filepath=file, import_shading="SMOOTH")
        except ImportError:  # numpy is missing
            sys.exit(77)
    else:
        mesh = os.path.splitext(file)[0] + ".obj"
        bpy.ops.wm.obj_import(filepath=mesh, forward_axis="Y", up_axis="Z")
    objects = sorted((o for o in bpy.data.objects if o.type == "MESH"), key=lambda o: o.name)
    if mode == "pc2":
        (item,) = objects
        cache = item.modifiers.new("cache", "MESH_CACHE")
        cache.cache_format = "PC2"
        cache.filepath = file
        cache.frame_start = 0
        cache.forward_axis = "POS_Y"
        cache.up_axis = "POS_Z"
    return objects


def main():
    mode, file, out, *frames = sys.argv[sys.argv.index("--") + 1 :]
    objects = import_objects(mode, file)
    with open(out, "w", encoding="ascii") as stream:
        for frame in map(int, frames):
            bpy.context.scene.frame_set(frame)
            graph = bpy.context.evaluated_depsgraph_get()
            for item in objects:
                evaluated = item.evaluated_get(graph)
                mesh = evaluated.to_mesh()
                for vertex in mesh.vertices:
                    x, y, z = evaluated.matrix_world @ vertex.co
                    stream.write(f"{frame} {item.name} {x!r} {y!r} {z!r}\n")
                evaluated.to_mesh_clear()


main()
