"""The cloth of Blender and weft on the same grids, bodies and frames: time, intersections, strain.

    python3 benchmarks/support/blender_runs.py PROGRAM [--scenes drape curtain stack] [--blender blender]

Needs Blender 3.4 or later. Blender's springs have no stiffness in newtons per metre: cloth has the
stiffness and the damping of its preset "Cotton", the mass of the scene's fabric, no drag of air, collisions of
cloth with itself on, and the scene's contact thickness as distance.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

INSIDE = "--inside"  # the word after which this file runs within Blender


def read_obj(path):
    vertices, faces = [], []
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append(tuple(map(float, words[1:4])))
        elif words[0] == "f":
            faces.append(tuple(int(word.split("/")[0]) - 1 for word in words[1:]))
    return vertices, faces


def edge_strains(before, after, faces):
    edges = {tuple(sorted((face[k], face[(k + 1) % 3]))) for face in faces for k in range(3)}
    length = lambda points, edge: sum((a - b) ** 2 for a, b in zip(points[edge[0]], points[edge[1]])) ** 0.5
    return [length(after, edge) / length(before, edge) - 1 for edge in edges]


# ------------------------------------------------------------------------------- within Blender
def make_object(bpy, name, vertices, faces):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    return made


def simulate_inside(job):
    """Simulates a job in Blender and writes its seconds and last positions."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = round(job["frame_rate"])
    scene.frame_start, scene.frame_end = 0, job["frames"]
    body = make_object(bpy, "body", job["body"], job["body_faces"])
    body.modifiers.new("collision", "COLLISION")
    body.collision.thickness_outer = job["thickness"]
    for frame, place in enumerate(job["body_places"]):
        body.location = place
        body.keyframe_insert("location", frame=frame)
    for curve in body.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    cloth = make_object(bpy, "cloth", job["vertices"], job["faces"])
    modifier = cloth.modifiers.new("cloth", "CLOTH")
    settings, contact = modifier.settings, modifier.collision_settings
    settings.quality = job["quality"]
    settings.mass = job["vertex_mass"]
    settings.tension_stiffness = settings.compression_stiffness = settings.shear_stiffness = 15
    settings.bending_stiffness = 0.5
    settings.tension_damping = settings.compression_damping = settings.shear_damping = 5
    settings.bending_damping = 0.5
    settings.air_damping = 0
    if job["pinned"]:
        pins = cloth.vertex_groups.new(name="pins")
        pins.add(job["pinned"], 1, "REPLACE")
        settings.vertex_group_mass = "pins"
    contact.use_collision = contact.use_self_collision = True
    contact.distance_min = contact.self_distance_min = job["thickness"]
    modifier.point_cache.frame_start, modifier.point_cache.frame_end = 0, job["frames"]
    begin = time.perf_counter()
    for frame in range(job["frames"] + 1):
        scene.frame_set(frame)
    seconds = time.perf_counter() - begin
    mesh = cloth.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    Path(job["result"]).write_text(json.dumps(
        {"seconds": seconds, "vertices": [tuple(vertex.co) for vertex in mesh.vertices]}))


# ------------------------------------------------------------------------------ outside of it
def run_weft(arguments, scene, folder):
    words = [arguments.program, "run", f"{arguments.folder}/{scene}.json", "-o", str(folder),
             "--no-preview", "--overwrite", "--device", arguments.device]
    done = subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{scene}: exit code {done.returncode}: {done.stderr.strip()}")
    return json.loads((folder / "report.json").read_text())


def make_job(folder, quality, mass, thickness, result):
    """What Blender is to simulate: where weft began, what weft's body did."""
    frames = sorted((folder / "frames").glob("cloth_*.obj"))
    bodies = sorted((folder / "frames").glob("obstacle*.obj"))
    vertices, faces = read_obj(frames[0])
    body, body_faces = read_obj(bodies[0])
    first = [read_obj(path)[0][0] for path in bodies]
    places = [tuple(a - b for a, b in zip(at, first[0])) for at in first] if len(bodies) > 1 else [(0, 0, 0)]
    scene = json.loads((folder / "scene.json").read_text())
    top = max(vertex[2] for vertex in vertices)
    pinned = [n for n, vertex in enumerate(vertices) if vertex[2] > top - 1e-6] if scene.get("pins") else []
    return {"frame_rate": scene["time"]["frame_rate"], "frames": len(frames) - 1, "quality": quality,
            "vertices": vertices, "faces": faces, "body": body, "body_faces": body_faces,
            "body_places": places, "pinned": pinned, "vertex_mass": mass / len(vertices),
            "thickness": thickness, "result": str(result)}


def run_blender(arguments, job, folder):
    path = folder / "job.json"
    path.write_text(json.dumps(job))
    words = [arguments.blender, "--background", "--factory-startup", "--threads", str(arguments.threads),
             "--python-exit-code", "2", "--python", __file__, "--", INSIDE, str(path)]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"Blender: exit code {done.returncode}: {done.stdout.strip()}")
    return json.loads(Path(job["result"]).read_text())


def intersections(arguments, mesh, body):
    """Pairs of triangles, of the cloth with itself and with the body."""
    result = Path(str(mesh) + ".json")
    words = [arguments.program, "check", str(mesh), "--obstacle", str(body), "--json", str(result), "--quiet"]
    done = subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode > 1:
        sys.exit(f"{mesh}: exit code {done.returncode}: {done.stderr.strip()}")
    verdict = json.loads(result.read_text())["frames"][0]["verdict"]
    return verdict["cloth_cloth"]["count"] + verdict["cloth_obstacle"]["count"]


def row(name, seconds, simulated, pairs, strains):
    spread = statistics.quantiles([abs(strain) for strain in strains], n=100)
    return (f"| {name} | {statistics.median(seconds) / simulated:.2f} | {min(seconds) / simulated:.2f}"
            f" | {pairs} | {100 * statistics.fmean(map(abs, strains)):.2f} | {100 * spread[98]:.1f}"
            f" | {100 * max(strains):.1f} |")


def compare(arguments, scene, folder):
    weft = folder / "weft"
    seconds, by_quality = [], {quality: [] for quality in arguments.quality}
    for _ in range(arguments.repeat):
        report = run_weft(arguments, scene, weft)
        seconds.append(report["wall_s"])
        frames = sorted((weft / "frames").glob("cloth_*.obj"))
        area, thickness = cloth_area(frames[0]), contact_thickness(weft)
        for quality, all_runs in by_quality.items():
            job = make_job(weft, quality, area * density(weft), thickness, folder / "result.json")
            all_runs.append(run_blender(arguments, job, folder))
    before, faces = read_obj(frames[0])
    body = sorted((weft / "frames").glob("obstacle*.obj"))[-1]
    simulated = report["simulated_s"]
    print(row(f"{scene}, weft", seconds, simulated, intersections(arguments, frames[-1], body),
              edge_strains(before, read_obj(frames[-1])[0], faces)), flush=True)
    for quality, all_runs in by_quality.items():
        mesh = folder / "blender.obj"
        after = all_runs[-1]["vertices"]
        mesh.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in after)
                        + "".join("f " + " ".join(str(n + 1) for n in face) + "\n" for face in faces))
        print(row(f"{scene}, Blender, quality {quality}", [one["seconds"] for one in all_runs], simulated,
                  intersections(arguments, mesh, body), edge_strains(before, after, faces)), flush=True)


def cloth_area(path):
    vertices, faces = read_obj(path)
    area = 0
    for a, b, c in faces:
        u = [vertices[b][k] - vertices[a][k] for k in range(3)]
        v = [vertices[c][k] - vertices[a][k] for k in range(3)]
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        area += sum(x * x for x in normal) ** 0.5 / 2
    return area


def density(run):
    """[kg/m^2] of the only material of a run's scene."""
    materials = json.loads((run / "scene.json").read_text())["materials"]
    return next(iter(materials.values()))["density"]


def contact_thickness(run):
    return json.loads((run / "scene.json").read_text())["contact"]["thickness"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="weft")
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--folder", default="scenes", help="where the scenes are")
    parser.add_argument("--scenes", nargs="+", default=["drape", "curtain", "stack"])
    parser.add_argument("--quality", nargs="+", type=int, default=[5, 12], help="steps per frame of Blender")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="of Blender")
    parser.add_argument("--device", default=f"cpu:{os.cpu_count()}", help="of weft")
    arguments = parser.parse_args()
    print("| scene and program | s per simulated s, median | least | intersecting pairs at the end"
          " | edge strain, mean, % | 99 of 100 below, % | largest, % |")
    print("|---|---:|---:|---:|---:|---:|---:|", flush=True)
    for scene in arguments.scenes:
        with tempfile.TemporaryDirectory() as folder:
            compare(arguments, scene, Path(folder))


if INSIDE in sys.argv:
    simulate_inside(json.loads(Path(sys.argv[sys.argv.index(INSIDE) + 1]).read_text()))
elif __name__ == "__main__":
    main()
