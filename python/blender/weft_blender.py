"""weft for Blender 3.4 and later: meshes become a weft scene, and the frames of a run come back.

Install this file under Edit > Preferences > Add-ons > Install. The panel "weft" is in the sidebar of
the 3D view; File > Export and File > Import have an entry each. Without a window:

    blender -b file.blend -P weft_blender.py -- export scene.json [--selected]
    blender -b [file.blend] -P weft_blender.py -- import RUN out.blend
    blender -b file.blend -P weft_blender.py -- bake shape_keys|pc2|mdd out.blend [--folder DIR]

Exit code 2: bad input, and one line says which.

An object keeps its settings in custom properties:

    weft               "cloth", "body" or "ignore"; a mesh without it is a body, unless it was imported
    weft_fabric        name of a fabric of weft, for a cloth
    weft_pins_follow   name of the body that carries the pins of a cloth
    weft_run           folder of the run that it was imported from

The vertex group "weft_pin" pins the vertices with a weight above a half.
"""

import argparse
import json
import os
import re
import sys
import traceback

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

try:
    import numpy as np
except ImportError:
    # Blender would exit with 0.
    if __name__ == "__main__" and bpy.app.background:
        print("weft: this Blender has no NumPy (on Debian, package python3-numpy for the first python3 on PATH)",
              file=sys.stderr)
        sys.exit(2)
    raise

bl_info = {
    "name": "weft",
    "description": "Exports cloth and bodies as a scene of weft, imports the frames of its runs",
    "version": (0, 2, 0),
    "blender": (3, 4, 0),
    "location": "File > Export, File > Import, 3D View > Sidebar > weft",
    "category": "Import-Export",
}

ROLE = "weft"
FABRIC = "weft_fabric"
PINS_FOLLOW = "weft_pins_follow"
RUN = "weft_run"
PIN_GROUP = "weft_pin"
DEFAULT_FABRIC = "interlock"
FABRICS = ("blanket", "cotton", "cotton_polyester", "denim", "interlock", "jersey", "leather",
           "light_jacket", "paper", "polyester", "ponte_roma", "rib_knit", "silk", "sweatshirt",
           "swimwear", "wool")
# Between these stretches, weft takes texture coordinates for metres without a warning.
METRES_BETWEEN = (0.8, 1.25)


class WeftError(Exception):
    """Bad input; the text is one line for the user."""


# ---------------------------------------------------------------------------- Blender's settings
def short(number):
    """A single-precision property as the number that its user typed: 0.01, not 0.0099999998."""
    return float(f"{number:.7g}")


def metres_per_unit(scene):
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else short(units.scale_length)


def frame_rate(scene):
    return scene.render.fps / short(scene.render.fps_base)


def set_frame_rate(scene, rate):
    # Blender's rate is a whole number over a divisor: 23.976 is 24 / 1.001.
    scene.render.fps = max(1, int(np.ceil(rate - 1e-6)))
    scene.render.fps_base = scene.render.fps / rate


def role_of(item):
    # A scene can be exported again from a file that holds its result.
    role = item.get(ROLE, "ignore" if RUN in item else "body")
    if role not in ("cloth", "body", "ignore"):
        raise WeftError(f"object '{item.name}': custom property {ROLE} is '{role}'; "
                        "allowed: cloth, body, ignore")
    return role


def fabric_of(item):
    fabric = item.get(FABRIC, DEFAULT_FABRIC)
    if fabric not in FABRICS:
        raise WeftError(f"object '{item.name}': custom property {FABRIC} is '{fabric}'; "
                        f"allowed: {', '.join(FABRICS)}")
    return fabric


# ------------------------------------------------------------------------------- Blender's meshes
class Surface:
    """The triangles of an object in the present frame, modifiers applied.

    positions  [vertices, 3], of the world, in metres
    triangles  [triangles, 3], numbers of vertices
    uv         [triangles, 3, 2], or None
    pinned     numbers of the pinned vertices
    sewn       [pairs, 2], vertices that an edge without a face joins, as Blender's own cloth is sewn
    loose      how many vertices without a triangle were left out
    corners    corners of all faces as Blender has them, to notice other faces in another frame
    """

    def __init__(self, item, graph, scale):
        evaluated = item.evaluated_get(graph)
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=graph)
        try:
            mesh.calc_loop_triangles()
            count = len(mesh.loop_triangles)
            if count == 0:
                raise WeftError(f"object '{item.name}' has no faces")
            self.triangles = array_of(mesh.loop_triangles, "vertices", np.int32, 3)
            loops = array_of(mesh.loop_triangles, "loops", np.int32, 3)
            self.corners = corners_of(mesh)
            self.uv = None
            if mesh.uv_layers.active:
                self.uv = array_of(mesh.uv_layers.active.data, "uv", np.float32, 2)[loops]
            matrix = evaluated.matrix_world.copy()
            # Mirrored: a triangle would show its back.
            if matrix.determinant() < 0:
                self.triangles = self.triangles[:, ::-1]
                self.uv = None if self.uv is None else self.uv[:, ::-1]
            self.used, inverse = np.unique(self.triangles, return_inverse=True)
            self.triangles = inverse.reshape(-1, 3)
            self.loose = len(mesh.vertices) - len(self.used)
            self.positions = world_positions(mesh, matrix, scale)[self.used]
            self.sewn = sewn_vertices(mesh, self.used)
            group = item.vertex_groups.get(PIN_GROUP)
            self.pinned = pinned_vertices(mesh, self.used, group.index) if group else []
        finally:
            evaluated.to_mesh_clear()

    def later(self, item, graph, scale, frame):
        """The positions in another frame, if the faces are the same there."""
        evaluated = item.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        try:
            if not np.array_equal(corners_of(mesh), self.corners):
                raise WeftError(f"object '{item.name}': its faces change at frame {frame}; "
                                "weft needs the same faces in all frames")
            return world_positions(mesh, evaluated.matrix_world, scale)[self.used]
        finally:
            evaluated.to_mesh_clear()


def array_of(collection, attribute, kind, width):
    values = np.empty(len(collection) * width, kind)
    collection.foreach_get(attribute, values)
    return values.reshape(-1, width)


def corners_of(mesh):
    corners = array_of(mesh.loops, "vertex_index", np.int32, 1)[:, 0]
    totals = array_of(mesh.polygons, "loop_total", np.int32, 1)[:, 0]
    return np.concatenate((corners, totals))


def world_positions(mesh, matrix, scale):
    matrix = np.array(matrix)
    local = array_of(mesh.vertices, "co", np.float32, 3).astype(np.float64)
    return (local @ matrix[:3, :3].T + matrix[:3, 3]) * scale


def sewn_vertices(mesh, used):
    edges = array_of(mesh.edges, "vertices", np.int32, 2)
    of_faces = array_of(mesh.loops, "edge_index", np.int32, 1)
    edges = np.delete(edges, np.unique(of_faces), axis=0)
    edges = edges[np.isin(edges, used).all(axis=1)]
    return np.searchsorted(used, edges)


def pinned_vertices(mesh, used, group):
    return [number for number, vertex in enumerate(used)
            if any(entry.group == group and entry.weight > 0.5
                   for entry in mesh.vertices[int(vertex)].groups)]


# -------------------------------------------------------------------------- material coordinates
def edge_lengths(corners):
    """[triangles, 3, dimensions] to [triangles, 3]."""
    return np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)


def is_flat(positions):
    spread = np.linalg.svd(positions - positions.mean(axis=0), compute_uv=False)
    return spread[2] < 1e-4 * spread[0]


def material_coordinates(name, surface):
    """Texture coordinates in metres, or None if the mesh is its own rest shape; lines of report."""
    flat = is_flat(surface.positions)
    if surface.uv is None:
        if not flat:
            raise WeftError(f"cloth '{name}' has no UV map and is not flat; unwrap it (UV > Unwrap)")
        return None, [f"cloth '{name}': no UV map; the flat mesh is the rest shape"]
    lengths = edge_lengths(surface.positions[surface.triangles])
    flat_lengths = edge_lengths(surface.uv)
    ratio = lengths / np.maximum(flat_lengths, 1e-30)
    low, scale, high = np.quantile(ratio, (0.05, 0.5, 0.95))
    if flat and not (METRES_BETWEEN[0] * scale <= low and high <= METRES_BETWEEN[1] * scale):
        return None, [f"cloth '{name}': its UV map is distorted; the flat mesh is the rest shape"]
    if scale > 1e20:
        raise WeftError(f"cloth '{name}': the faces of its UV map have no area; unwrap it (UV > Unwrap)")
    lines = []
    if METRES_BETWEEN[0] <= scale <= METRES_BETWEEN[1]:
        scale = 1.0
        lines.append(f"cloth '{name}': the UV map is in metres")
    else:
        lines.append(f"cloth '{name}': UV map times {scale:.4g} gives metres")
    if not (METRES_BETWEEN[0] * scale <= low and high <= METRES_BETWEEN[1] * scale):
        lines.append(f"cloth '{name}': WARNING: against its UV map, one edge in ten starts stretched by less "
                     f"than {low / scale:.2f} or more than {high / scale:.2f}")
    uv = surface.uv * scale
    mirrored, areas = turn_over(uv)
    if mirrored:
        lines.append(f"cloth '{name}': {mirrored} mirrored triangles of the UV map are turned over")
    empty = np.count_nonzero(areas <= 1e-9 * np.median(areas))
    if empty:
        raise WeftError(f"cloth '{name}': {empty} triangles of its UV map have no area; unwrap it (UV > Unwrap)")
    return uv, lines


def turn_over(uv):
    """Mirrors triangles that run clockwise, in place. Returns their number, and the areas of all.

    Halves of a symmetric garment often share one mirrored map, but weft wants fronts up.
    """
    side0, side1 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    areas = (side0[:, 0] * side1[:, 1] - side0[:, 1] * side1[:, 0]) / 2
    clockwise = areas < 0
    uv[clockwise, :, 0] *= -1
    return np.count_nonzero(clockwise), np.abs(areas)


def join_corners(triangles, uv):
    """Gives corners of the same vertex and place one entry.

    Returns the entries [n, 2] and their numbers [triangles, 3]. Modifiers leave rounding errors
    between corners that were the same, so places are equal up to a millionth of the map.
    """
    vertices = triangles.ravel()
    places = uv.reshape(-1, 2).astype(np.float64)
    tolerance = 1e-6 * np.ptp(places, axis=0).max()
    numbers = np.full(len(vertices), -1)
    entries = []
    open_corners = np.arange(len(vertices))
    while len(open_corners):
        # The first open corner of each vertex is an entry; corners at its place join it.
        _, first, inverse = np.unique(vertices[open_corners], return_index=True, return_inverse=True)
        made = places[open_corners[first]]
        same = np.abs(places[open_corners] - made[inverse]).max(axis=1) <= tolerance
        numbers[open_corners[same]] = sum(map(len, entries)) + inverse[same]
        entries.append(made)
        open_corners = open_corners[~same]
    return np.concatenate(entries), numbers.reshape(-1, 3)


# ----------------------------------------------------------------------------------------- files
def write_obj(path, name, surface, uv=None):
    lines = [f"o {name}"]
    lines += ["v %.9g %.9g %.9g" % tuple(x) for x in surface.positions.tolist()]
    if uv is None:
        lines += ["f %d %d %d" % tuple(t) for t in (surface.triangles + 1).tolist()]
    else:
        entries, numbers = join_corners(surface.triangles, uv)
        lines += ["vt %.9g %.9g" % tuple(x) for x in entries.tolist()]
        pairs = np.stack((surface.triangles, numbers), axis=2).reshape(-1, 6) + 1
        lines += ["f %d/%d %d/%d %d/%d" % tuple(t) for t in pairs.tolist()]
    with open(path, "w", encoding="ascii") as stream:
        stream.write("\n".join(lines) + "\n")


def write_pc2(path, frames):
    with open(path, "wb") as stream:
        header = [("magic", "S12"), ("version", "<i4"), ("vertices", "<i4"), ("start", "<f4"),
                  ("rate", "<f4"), ("samples", "<i4")]
        stream.write(np.array([(b"POINTCACHE2", 1, len(frames[0]), 0, 1, len(frames))], header).tobytes())
        for frame in frames:
            stream.write(np.ascontiguousarray(frame, "<f4").tobytes())


def write_mdd(path, frames, rate):
    with open(path, "wb") as stream:
        stream.write(np.array([len(frames), len(frames[0])], ">i4").tobytes())
        stream.write((np.arange(len(frames)) / rate).astype(">f4").tobytes())
        for frame in frames:
            stream.write(np.ascontiguousarray(frame, ">f4").tobytes())


def read_json(path, needed=True):
    try:
        with open(path, encoding="utf-8") as stream:
            return json.load(stream)
    except FileNotFoundError:
        if needed:
            raise WeftError(f"{path}: is missing; a run folder of weft has it") from None
        return {}
    except ValueError as error:
        raise WeftError(f"{path}: is not JSON: {error}") from None


# ---------------------------------------------------------------------------------------- export
def name_for_weft(name, taken):
    """Letters, digits, _ and -, and no name twice."""
    base = re.sub(r"[^A-Za-z0-9_-]", "_", name)
    unique, number = base, 2
    while unique in taken:
        unique, number = f"{base}_{number}", number + 1
    taken.add(unique)
    return unique


def objects_to_export(context, selected_only):
    items = [item for item in context.view_layer.objects
             if item.type == "MESH" and item.visible_get() and (not selected_only or item.select_get())]
    return [item for item in items if role_of(item) != "ignore"]


def export_scene(context, path, selected_only=False):
    """Writes a scene file and its meshes. Returns lines of report."""
    scene = context.scene
    items = objects_to_export(context, selected_only)
    cloths = [item for item in items if role_of(item) == "cloth"]
    bodies = [item for item in items if role_of(item) == "body"]
    if not cloths:
        raise WeftError(("no selected mesh" if selected_only else "no visible mesh") + " is a cloth; "
                        f"choose Cloth in the panel weft, or set the custom property {ROLE} to 'cloth'")
    if scene.frame_end <= scene.frame_start:
        raise WeftError(f"the frame range {scene.frame_start} to {scene.frame_end} holds no motion; "
                        "set the end of the scene")
    for item in items:
        if item.mode == "EDIT":
            item.update_from_editmode()
    present = scene.frame_current
    try:
        return write_scene(context, os.path.abspath(path), cloths, bodies)
    finally:
        scene.frame_set(present)


def write_scene(context, path, cloths, bodies):
    scene = context.scene
    scale = metres_per_unit(scene)
    folder, stem = os.path.dirname(path), os.path.splitext(os.path.basename(path))[0]
    os.makedirs(folder, exist_ok=True)
    scene.frame_set(scene.frame_start)
    graph = context.evaluated_depsgraph_get()
    surfaces = {item: Surface(item, graph, scale) for item in cloths + bodies}
    taken = set()
    names = {item: name_for_weft(item.name, taken) for item in cloths + bodies}
    lines = [f"'{item.name}': left out {surface.loose} vertices without a face"
             for item, surface in surfaces.items() if surface.loose]

    document = {"time": {"frame_rate": frame_rate(scene), "frames": scene.frame_end - scene.frame_start}}
    gravity = [short(x) for x in scene.gravity] if scene.use_gravity else [0, 0, 0]
    if gravity != [0, 0, -9.81]:
        document["gravity"] = gravity
    document.update(materials={}, cloths=[], obstacles=[], pins=[], seams=[])
    for item in cloths:
        fabric, surface = fabric_of(item), surfaces[item]
        uv, said = material_coordinates(item.name, surface)
        lines += said
        file = f"{stem}.{names[item]}.obj"
        write_obj(os.path.join(folder, file), names[item], surface, uv)
        document["materials"][fabric] = {"fabric": fabric}
        document["cloths"].append({"name": names[item], "mesh": file, "material": fabric})
        if surface.pinned:
            document["pins"].append(pin_of(item, surface, names, bodies))
        if len(surface.sewn):
            document["seams"].append({"cloths": [names[item]] * 2, "pairs": surface.sewn.tolist()})
        lines.append(f"cloth '{item.name}': {len(surface.triangles)} triangles, fabric {fabric}, "
                     f"{len(surface.pinned)} pinned vertices, {len(surface.sewn)} sewn pairs")

    motions = sample(context, {item: surfaces[item] for item in bodies}, scale)
    for item in bodies:
        name, surface = names[item], surfaces[item]
        write_obj(os.path.join(folder, f"{stem}.{name}.obj"), name, surface)
        entry = {"name": name, "mesh": f"{stem}.{name}.obj"}
        if motions[item]:
            write_pc2(os.path.join(folder, f"{stem}.{name}.pc2"), motions[item])
            entry = {"name": name, "sequence": {"mesh": f"{stem}.{name}.obj", "points": f"{stem}.{name}.pc2",
                                                "frame_rate": frame_rate(scene)}}
        document["obstacles"].append(entry)
        lines.append(f"body '{item.name}': {len(surface.triangles)} triangles, "
                     + (f"animated over {len(motions[item])} frames" if motions[item] else "at rest"))

    graph = context.evaluated_depsgraph_get()
    for item in cloths:
        if is_animated(item, graph, scale, surfaces[item], scene.frame_current):
            lines.append(f"cloth '{item.name}': WARNING: it is animated, but only its place in frame "
                         f"{scene.frame_start} counts; let its pins follow a body")
    with open(path, "w", encoding="utf-8") as stream:
        json.dump({key: value for key, value in document.items() if value != []}, stream, indent=2)
        stream.write("\n")
    return lines + [f"wrote {path}"]


def is_animated(item, graph, scale, surface, frame):
    try:
        moved = np.abs(surface.later(item, graph, scale, frame) - surface.positions).max()
    except WeftError:  # other faces
        return True
    return moved > 1e-6 * np.ptp(surface.positions, axis=0).max()


def pin_of(item, surface, names, bodies):
    pin = {"cloth": names[item], "vertices": surface.pinned}
    carrier = item.get(PINS_FOLLOW)
    if carrier:
        found = [body for body in bodies if body.name == carrier]
        if not found:
            raise WeftError(f"cloth '{item.name}': its pins follow '{carrier}', which is not an exported body")
        pin["obstacle"] = names[found[0]]
    return pin


def sample(context, surfaces, scale):
    """Positions of bodies in all frames of the scene; None for a body at rest."""
    scene = context.scene
    motions = {item: [surface.positions] for item, surface in surfaces.items()}
    for frame in range(scene.frame_start + 1, scene.frame_end + 1):
        scene.frame_set(frame)
        graph = context.evaluated_depsgraph_get()
        for item, surface in surfaces.items():
            motions[item].append(surface.later(item, graph, scale, frame).astype(np.float32))
    for item, motion in motions.items():
        start = motion[0].astype(np.float32)
        if all(np.array_equal(frame, start) for frame in motion[1:]):
            motions[item] = None
    return motions


# ---------------------------------------------------------------------------------------- import
class Stretch:
    """Consecutive frames in which a mesh has the same triangles."""

    def __init__(self, first, triangles, uv):
        self.first = first
        self.triangles = triangles
        self.uv = uv  # [triangles, 3, 2], or None
        self.frames = []  # positions [vertices, 3]

    @property
    def moves(self):
        return any(not np.array_equal(frame, self.frames[0]) for frame in self.frames[1:])


class Part:
    """One mesh of a frame file: which vertices of the file it has, and its triangles."""

    def __init__(self, corners, uv):
        self.vertices, inverse = np.unique(corners, return_inverse=True)
        self.triangles = inverse.reshape(-1, 3)
        self.uv = uv


def numbers_of(lines, kind):
    return np.array(b" ".join(lines).split(), dtype=kind)


def obj_positions(text):
    return numbers_of(re.findall(rb"^v ([^\n]*)", text, re.M), np.float64).reshape(-1, 3)


def obj_topology(text):
    """What must be equal if two frames have the same meshes."""
    return b"\n".join(re.findall(rb"^[fo] [^\n]*", text, re.M))


def obj_parts(text, path):
    places = numbers_of(re.findall(rb"^vt ([^\n]*)", text, re.M), np.float64).reshape(-1, 2)
    parts = {}
    pieces = re.split(rb"^o ([^\n]*)\n", text, flags=re.M)[1:]
    for name, piece in zip(pieces[::2], pieces[1::2]):
        faces = re.findall(rb"^f ([^\n]*)", piece, re.M)
        if not faces:
            raise WeftError(f"{path}: mesh '{name.decode()}' has no faces")
        corner = faces[0].split()[0]
        width = len(corner.replace(b"/", b" ").split())
        numbers = numbers_of([b" ".join(faces).replace(b"/", b" ")], np.int64).reshape(-1, 3, width) - 1
        has_uv = b"/" in corner and b"//" not in corner
        parts[name.decode()] = Part(numbers[:, :, 0], places[numbers[:, :, 1]] if has_uv else None)
    return parts


def ply_frame(data, path):
    """Positions and the one mesh of a binary PLY file."""
    head, mark, body = data.partition(b"end_header\n")
    if not mark or b"format binary_little_endian" not in head:
        raise WeftError(f"{path}: is not a binary PLY file of weft")
    kinds = {b"float": "<f4", b"double": "<f8", b"uchar": "u1", b"int": "<i4", b"uint": "<u4"}
    counts = dict(re.findall(rb"^element (\w+) (\d+)", head, re.M))
    fields = [(name.decode(), kinds[kind]) for kind, name in re.findall(rb"^property (float|double) (\w+)", head, re.M)]
    vertices = np.frombuffer(body, fields, int(counts[b"vertex"]))
    beside = re.findall(rb"^property (\w+) (\w+)$", head[head.index(b"element face"):], re.M)
    face = [("count", "u1"), ("corners", "<i4", 3)] + [(name.decode(), kinds[kind]) for kind, name in beside]
    faces = np.frombuffer(body, face, int(counts[b"face"]), vertices.nbytes)
    positions = np.stack([vertices[axis] for axis in "xyz"], axis=1).astype(np.float64)
    corners = faces["corners"].astype(np.int64)
    uv = np.stack((vertices["s"], vertices["t"]), axis=1)[corners] if "s" in vertices.dtype.names else None
    return positions, corners, uv


def frame_files(folder, kind, suffix, count):
    """KIND_00000.SUFFIX and so on; KIND.SUFFIX alone if nothing in it moves; none: []."""
    names = [f"{kind}_{frame:05d}.{suffix}" for frame in range(count)]
    for found in (names, [f"{kind}.{suffix}"]):
        if os.path.exists(os.path.join(folder, found[0])):
            return [os.path.join(folder, name) for name in found]
    return []


def read_frames(paths, kind, suffix):
    """Reads the frames of a kind. Returns the stretches of each mesh, by name."""
    meshes, parts, topology = {}, {}, None
    for frame, path in enumerate(paths):
        try:
            with open(path, "rb") as stream:
                data = stream.read()
        except FileNotFoundError:
            raise WeftError(f"{path}: is missing") from None
        try:
            if suffix == "obj":
                positions, now = obj_positions(data), obj_topology(data)
                if now != topology:
                    parts = obj_parts(data, path)
            else:
                positions, corners, uv = ply_frame(data, path)
                now = corners.tobytes()
                if now != topology:
                    parts = {kind: Part(corners, uv)}
        except (ValueError, LookupError) as error:
            raise WeftError(f"{path}: is not a frame of weft: {error}") from None
        topology = now
        for name, part in parts.items():
            stretches = meshes.setdefault(name, [])
            if not stretches or not np.array_equal(stretches[-1].triangles, part.triangles):
                stretches.append(Stretch(frame, part.triangles, part.uv))
            stretches[-1].frames.append(positions[part.vertices])
    return meshes


def frame_count(folder, suffix):
    numbers = {int(found.group(1)) for found in
               (re.fullmatch(rf"cloth_(\d+)\.{suffix}", name) for name in os.listdir(folder)) if found}
    if numbers != set(range(len(numbers))):
        missing = min(set(range(max(numbers) + 1)) - numbers)
        raise WeftError(f"{os.path.join(folder, f'cloth_{missing:05d}.{suffix}')}: is missing")
    return len(numbers)


def import_run(context, run):
    """Makes objects of all frames of a run. Returns lines of report."""
    scene = context.scene
    run = os.path.abspath(run)
    settings = read_json(os.path.join(run, "scene.json"))
    report = read_json(os.path.join(run, "report.json"), needed=False)
    try:
        rate = float(settings["time"]["frame_rate"])
    except (KeyError, TypeError, ValueError):
        raise WeftError(f"{run}/scene.json: time.frame_rate: is missing or not a number") from None
    origin = np.array(report.get("origin", (0, 0, 0)), np.float64)
    folder = os.path.join(run, "frames")
    files = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
    collection = bpy.data.collections.new(os.path.basename(run))
    if any(name.endswith(".pc2") for name in files):
        made, count = import_caches(scene, folder, files, collection)
        lines = []
    elif "cloth_00000.obj" in files or "cloth_00000.ply" in files:
        suffix = "obj" if "cloth_00000.obj" in files else "ply"
        count = frame_count(folder, suffix)
        made, lines = [], []
        for kind in ("cloth", "obstacle"):
            paths = frame_files(folder, kind, suffix, count)
            for name, stretches in read_frames(paths, kind, suffix).items():
                made += objects_of(scene, collection, kind, name, stretches, origin, count)
                if len(stretches) > 1:
                    lines.append(f"{kind} '{name}': its triangles change; {len(stretches)} objects take turns")
    else:
        raise WeftError(f"{folder}: no frames in obj, ply or pc2; run the scene again with --set output.format=obj")
    for item in made:
        item[RUN] = run
    set_frame_rate(scene, rate)
    scene.frame_end = scene.frame_start + count - 1
    scene.collection.children.link(collection)
    scene.frame_set(scene.frame_start)
    if "frames" in report and report["frames"] + 1 != count:
        lines.append(f"WARNING: report.json tells of {report['frames'] + 1} frames, and {count} are there")
    return lines + [f"{len(made)} objects, frames {scene.frame_start} to {scene.frame_end} "
                    f"at {rate:g} frames per second"]


def new_object(collection, kind, name, positions, triangles, uv):
    """An object with coordinates in metres."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(positions.tolist(), [], triangles.tolist())
    if uv is not None:
        mesh.uv_layers.new(name="metres").data.foreach_set("uv", uv.astype(np.float32).ravel())
    # Obstacles have edges that shading should show.
    mesh.polygons.foreach_set("use_smooth", np.full(len(mesh.polygons), kind == "cloth"))
    mesh.update()
    item = bpy.data.objects.new(name, mesh)
    collection.objects.link(item)
    return item


def place(scene, item, origin):
    scale = metres_per_unit(scene)
    item.location = origin / scale
    item.scale = (1 / scale,) * 3


def objects_of(scene, collection, kind, name, stretches, origin, count):
    made = []
    for stretch in stretches:
        frames = [frame - origin for frame in stretch.frames]
        item = new_object(collection, kind, name, frames[0], stretch.triangles, stretch.uv)
        place(scene, item, origin)
        if stretch.moves:
            set_shape_keys(item, frames, scene.frame_start + stretch.first)
        if len(stretches) > 1:
            show_only(item, scene.frame_start + stretch.first, len(frames),
                      stretch.first > 0, stretch.first + len(frames) < count)
        made.append(item)
    return made


def curve_of(block, path):
    """The curve of an animated property that has a key already."""
    data = block.animation_data
    if hasattr(data.action, "fcurves"):
        curves = data.action.fcurves
    else:  # from Blender 5 on, an action has a set of curves for each of its users
        curves = data.action.layers[0].strips[0].channelbag(data.action_slot).fcurves
    return curves.find(path)


def set_curve(block, path, owner, attribute, keys, interpolation):
    owner.keyframe_insert(attribute, frame=keys[0][0])
    curve = curve_of(block, path)
    points = curve.keyframe_points
    points.add(len(keys) - len(points))
    points.foreach_set("co", np.array(keys, np.float32).ravel())
    for point in points:
        point.interpolation = interpolation
    curve.update()


def set_shape_keys(item, frames, first):
    """One shape key for each frame but the first, which is the basis. Between two frames, both blend."""
    item.shape_key_add(name="Basis", from_mix=False)
    for number, frame in enumerate(frames[1:], 1):
        block = item.shape_key_add(name=f"frame {number}", from_mix=False)
        block.data.foreach_set("co", np.ascontiguousarray(frame, np.float32).ravel())
        keys = [(first + number - 1, 0), (first + number, 1), (first + number + 1, 0)]
        if number == len(frames) - 1:
            del keys[-1]
        set_curve(item.data.shape_keys, f'key_blocks["{block.name}"].value', block, "value", keys, "LINEAR")


def show_only(item, first, count, hide_before, hide_after):
    keys = [(first - 1, 1)] * hide_before + [(first, 0)] + [(first + count, 1)] * hide_after
    for attribute in ("hide_viewport", "hide_render"):
        set_curve(item, attribute, item, attribute, keys, "CONSTANT")


def import_caches(scene, folder, files, collection):
    made, count = [], 1
    for file in files:
        found = re.fullmatch(r"(cloth|obstacle)\.(.*)\.obj", file)
        if not found:
            continue
        path = os.path.join(folder, file)
        with open(path, "rb") as stream:
            text = stream.read()
        kind, name = found.groups()
        try:
            (part,) = obj_parts(text, path).values()
            positions = obj_positions(text)[part.vertices]
        except (ValueError, LookupError) as error:
            raise WeftError(f"{path}: is not a mesh of weft: {error}") from None
        item = new_object(collection, kind, name, positions, part.triangles, part.uv)
        base = path[: -len(".obj")]
        origin = read_json(base + ".origin.json", needed=False).get("origin", (0, 0, 0))
        place(scene, item, np.array(origin, np.float64))
        cache = base + ".pc2"
        if os.path.exists(cache):
            with open(cache, "rb") as stream:
                head = stream.read(32)
            if len(head) < 32 or not head.startswith(b"POINTCACHE2"):
                raise WeftError(f"{cache}: is not a point cache")
            count = max(count, int.from_bytes(head[28:32], "little"))
            set_cache(item, cache, "PC2", scene.frame_start)
        made.append(item)
    return made, count


def set_cache(item, path, kind, first):
    modifier = next((m for m in item.modifiers if m.type == "MESH_CACHE"), None)
    if modifier is None:
        modifier = item.modifiers.new("weft", "MESH_CACHE")
        # The cache has the vertices of the mesh, so it stands before modifiers that change them.
        with bpy.context.temp_override(object=item):
            bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=0)
    modifier.cache_format = kind
    modifier.filepath = path
    modifier.frame_start = first
    modifier.forward_axis = "POS_Y"
    modifier.up_axis = "POS_Z"
    modifier.interpolation = "LINEAR"


# ------------------------------------------------------------------------------------------ bake
def local_frames(context, items):
    """Positions of objects in their own axes in all frames, by their shape keys and caches alone."""
    scene = context.scene
    present = scene.frame_current
    others = [m for item in items for m in item.modifiers if m.type != "MESH_CACHE" and m.show_viewport]
    frames = {item: [] for item in items}
    try:
        for modifier in others:
            modifier.show_viewport = False
        for frame in range(scene.frame_start, scene.frame_end + 1):
            scene.frame_set(frame)
            graph = context.evaluated_depsgraph_get()
            for item in items:
                evaluated = item.evaluated_get(graph)
                mesh = evaluated.to_mesh()
                frames[item].append(array_of(mesh.vertices, "co", np.float32, 3))
                evaluated.to_mesh_clear()
    finally:
        for modifier in others:
            modifier.show_viewport = True
        scene.frame_set(present)
    return frames


def bake(context, items, target, folder):
    """Turns shape keys or caches into shape keys, or into one PC2 or MDD file per object."""
    # Shape keys of other meshes, such as faces, are not animations.
    items = [item for item in items if item.type == "MESH" and RUN in item and (
        item.data.shape_keys or any(m.type == "MESH_CACHE" for m in item.modifiers))]
    if not items:
        raise WeftError("no mesh to bake: none of them was imported from a run and moves")
    if target != "shape_keys" and not os.path.isabs(folder):
        raise WeftError("no folder for cache files; choose one, or save the .blend file first")
    scene = context.scene
    taken, lines = set(), []
    for item, frames in local_frames(context, items).items():
        if item.data.shape_keys:
            item.data.shape_keys.animation_data_clear()
            item.shape_key_clear()
        item.data.vertices.foreach_set("co", frames[0].ravel())
        item.data.update()
        if target == "shape_keys":
            for modifier in [m for m in item.modifiers if m.type == "MESH_CACHE"]:
                item.modifiers.remove(modifier)
            set_shape_keys(item, frames, scene.frame_start)
            lines.append(f"'{item.name}': {len(frames)} frames in shape keys")
            continue
        path = os.path.join(folder, f"{name_for_weft(item.name, taken)}.{target}")
        os.makedirs(folder, exist_ok=True)
        if target == "pc2":
            write_pc2(path, frames)
        else:
            write_mdd(path, frames, frame_rate(scene))
        set_cache(item, path, target.upper(), scene.frame_start)
        lines.append(f"'{item.name}': {len(frames)} frames in {path}")
    scene.frame_set(scene.frame_current)
    return lines


# ------------------------------------------------------------------------------------- interface
def tell(operator, work):
    """Runs the work of an operator; its lines go to the status bar, the Info editor and the console."""
    try:
        lines = work()
    except (WeftError, OSError) as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    for line in lines:
        print("weft:", line)
        operator.report({"WARNING" if "WARNING" in line else "INFO"}, line)
    return {"FINISHED"}


class WEFT_OT_export(bpy.types.Operator, ExportHelper):
    """Write meshes as a scene of weft"""

    bl_idname = "weft.export_scene"
    bl_label = "Export weft scene"
    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    selected_only: BoolProperty(name="Selected only", description="Leave out meshes that are not selected",
                                default=True)

    def execute(self, context):
        return tell(self, lambda: export_scene(context, bpy.path.abspath(self.filepath), self.selected_only))


class WEFT_OT_import(bpy.types.Operator):
    """Read the frames of a run of weft"""

    bl_idname = "weft.import_run"
    bl_label = "Import weft run"
    bl_options = {"REGISTER", "UNDO"}
    directory: StringProperty(name="Run", description="Folder that weft run wrote", subtype="DIR_PATH")

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        return tell(self, lambda: import_run(context, bpy.path.abspath(self.directory)))


class WEFT_OT_bake(bpy.types.Operator):
    """Turn the animation of the selected meshes into shape keys or a cache file"""

    bl_idname = "weft.bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}
    target: EnumProperty(items=(("shape_keys", "Shape keys", "One shape key per frame, inside the .blend file"),
                                ("pc2", "PC2 file", "Point cache, read by a Mesh Cache modifier"),
                                ("mdd", "MDD file", "MDD cache, read by a Mesh Cache modifier")))
    directory: StringProperty(name="Folder", description="Where cache files go", subtype="DIR_PATH")

    def invoke(self, context, _event):
        if self.target == "shape_keys":
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        folder = bpy.path.abspath(self.directory or "//")
        return tell(self, lambda: bake(context, context.selected_objects, self.target, folder))


class WEFT_OT_role(bpy.types.Operator):
    """Say what the selected meshes are in a scene of weft"""

    bl_idname = "weft.set_role"
    bl_label = "Set role"
    bl_options = {"REGISTER", "UNDO"}
    role: EnumProperty(items=(("cloth", "Cloth", "weft simulates it"), ("body", "Body", "Cloth collides with it"),
                              ("ignore", "Ignore", "It is not exported")))

    def execute(self, context):
        for item in context.selected_objects:
            if item.type == "MESH":
                item[ROLE] = self.role
        return {"FINISHED"}


class WEFT_PT_panel(bpy.types.Panel):
    bl_label = "weft"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "weft"

    def draw(self, context):
        layout = self.layout
        item = context.object
        if item and item.type == "MESH":
            role = item.get(ROLE, "ignore" if RUN in item else "body")
            layout.label(text=item.name, icon="MESH_DATA")
            row = layout.row(align=True)
            for value, label in (("cloth", "Cloth"), ("body", "Body"), ("ignore", "Ignore")):
                row.operator(WEFT_OT_role.bl_idname, text=label, depress=role == value).role = value
            if role == "cloth":
                layout.prop(item, "weft_fabric_choice", text="Fabric")
                if PIN_GROUP in item.vertex_groups:
                    layout.label(text=f"Pins: {PIN_GROUP}; they follow", icon="PINNED")
                    layout.prop_search(item, "weft_pins_follow_choice", context.scene, "objects", text="")
                else:
                    layout.label(text=f"No vertex group {PIN_GROUP}", icon="UNPINNED")
        layout.separator()
        layout.operator(WEFT_OT_export.bl_idname, icon="EXPORT")
        layout.operator(WEFT_OT_import.bl_idname, icon="IMPORT")
        layout.operator_menu_enum(WEFT_OT_bake.bl_idname, "target", text="Bake selected", icon="FILE_CACHE")


def get_fabric(item):
    fabric = item.get(FABRIC, DEFAULT_FABRIC)
    return FABRICS.index(fabric if fabric in FABRICS else DEFAULT_FABRIC)


def set_fabric(item, number):
    item[FABRIC] = FABRICS[number]


def set_pins_follow(item, name):
    item[PINS_FOLLOW] = name


def export_entry(self, _context):
    self.layout.operator(WEFT_OT_export.bl_idname, text="weft scene (.json)")


def import_entry(self, _context):
    self.layout.operator(WEFT_OT_import.bl_idname, text="weft run (folder)")


CLASSES = (WEFT_OT_export, WEFT_OT_import, WEFT_OT_bake, WEFT_OT_role, WEFT_PT_panel)


def register():
    for entry in CLASSES:
        bpy.utils.register_class(entry)
    # Their values are custom properties, which scripts can set without this add-on.
    bpy.types.Object.weft_fabric_choice = EnumProperty(
        name="Fabric", items=[(name, name.replace("_", " "), "") for name in FABRICS], get=get_fabric, set=set_fabric)
    bpy.types.Object.weft_pins_follow_choice = StringProperty(
        name="Pins follow", description="Body that carries the pins; empty: they stay",
        get=lambda item: item.get(PINS_FOLLOW, ""), set=set_pins_follow)
    bpy.types.TOPBAR_MT_file_export.append(export_entry)
    bpy.types.TOPBAR_MT_file_import.append(import_entry)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(import_entry)
    bpy.types.TOPBAR_MT_file_export.remove(export_entry)
    del bpy.types.Object.weft_pins_follow_choice
    del bpy.types.Object.weft_fabric_choice
    for entry in reversed(CLASSES):
        bpy.utils.unregister_class(entry)


# ---------------------------------------------------------------------------------- command line
def save(path):
    try:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(path), check_existing=False)
    except RuntimeError as error:
        raise WeftError(f"{path}: cannot be written: {' '.join(str(error).split())}") from None


def command_line(arguments):
    parser = argparse.ArgumentParser(prog="blender -b [file.blend] -P weft_blender.py --")
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("export", help="meshes to a scene file")
    command.add_argument("scene")
    command.add_argument("--selected", action="store_true", help="leave out meshes that are not selected")
    command = commands.add_parser("import", help="frames of a run to a .blend file")
    command.add_argument("run")
    command.add_argument("out")
    command = commands.add_parser("bake", help="imported animation to shape keys or cache files")
    command.add_argument("target", choices=("shape_keys", "pc2", "mdd"))
    command.add_argument("out")
    command.add_argument("--folder", help="for cache files; default: that of the .blend file")
    options = parser.parse_args(arguments)
    context = bpy.context
    if options.command == "export":
        lines = export_scene(context, options.scene, options.selected)
    elif options.command == "import":
        if not bpy.data.filepath:
            # Blender's startup file has a cube.
            for item in [item for item in bpy.data.objects if item.type == "MESH"]:
                bpy.data.objects.remove(item)
        lines = import_run(context, options.run)
        save(options.out)
    else:
        folder = os.path.abspath(options.folder or os.path.dirname(options.out) or ".")
        lines = bake(context, context.view_layer.objects, options.target, folder)
        save(options.out)
    for line in lines:
        print("weft:", line)


def main():
    register()
    if not bpy.app.background or "--" not in sys.argv:
        return
    try:
        command_line(sys.argv[sys.argv.index("--") + 1 :])
    except (WeftError, OSError) as error:
        print("weft:", error, file=sys.stderr)
        sys.exit(2)
    except Exception:  # Blender itself would go on and exit with 0
        traceback.print_exc()
        sys.exit(1)


if __name__ == "__main__":
    main()
