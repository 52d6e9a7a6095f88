#!/usr/bin/env python3
"""Blender exports a scene, weft runs it, and Blender finds the frames where weft put them.

usage: blender.py --program WEFT NAME...    names of the functions below; exit code 77: no Blender
"""

import argparse
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ADDON = HERE.parent / "blender/weft_blender.py"
SCENES = HERE / "blender_scenes.py"


class Bench:
    """A folder, and the programs that work in it."""

    def __init__(self, weft, folder):
        self.weft, self.folder = weft, pathlib.Path(folder)

    def at(self, name):
        return str(self.folder / name)

    def call(self, *command):
        """Returns exit code and output."""
        # Debian's Blender takes NumPy from the first python3 on PATH. The add-on is installed in here only.
        environment = {**os.environ, "PATH": "/usr/bin:" + os.environ["PATH"],
                       "BLENDER_USER_SCRIPTS": self.at("blender"), "BLENDER_USER_CONFIG": self.at("blender")}
        done = subprocess.run([str(word) for word in command], cwd=self.folder, text=True, env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        return done.returncode, done.stdout

    def do(self, *command):
        code, output = self.call(*command)
        assert code == 0, f"exit code {code} of {command}:\n{output}"
        return output

    def make(self, *names):
        """Returns the .blend file of the last one."""
        self.do("blender", "-b", "--factory-startup", "--python-exit-code", 1, "-P", SCENES, "--", "make",
                self.folder, *names)
        return self.at(f"{names[-1]}.blend")

    def addon(self, blend, *arguments):
        return ["blender", "-b", "--factory-startup", *([blend] if blend else []), "-P", ADDON, "--", *arguments]

    def look(self, blend, *frames):
        self.do("blender", "-b", "--factory-startup", blend, "--python-exit-code", 1, "-P", SCENES, "--", "look",
                self.at("look.json"), *frames)
        return json.loads((self.folder / "look.json").read_text())

    def simulate(self, scene, run, *arguments):
        """`weft run` and `weft check` both exit with 0."""
        self.do(self.weft, "run", scene, "-o", self.at(run), "--device", "cpu:1", *arguments)
        self.do(self.weft, "check", self.at(run), "--quiet")


def obj_positions(path):
    """Positions by mesh."""
    meshes = {}
    for line in pathlib.Path(path).read_text().splitlines():
        word, *rest = line.split()
        if word == "o":
            here = meshes.setdefault(rest[0], [])
        elif word == "v":
            here.append([float(x) for x in rest])
    return meshes


def expect_same(found, expected, what):
    """To 1e-5 of the size of the mesh."""
    assert len(found) == len(expected) > 0, f"{what}: {len(found)} vertices instead of {len(expected)}"
    size = max(max(x) - min(x) for x in zip(*expected))
    worst = max(math.dist(a, b) for a, b in zip(found, expected))
    assert worst <= 1e-5 * size, f"{what}: off by {worst}"


def fabrics(bench):
    """The panel offers the fabrics that weft has."""
    listed = [line.split(":")[0] for line in bench.do(bench.weft, "info", "--fabrics").splitlines()
              if not line.startswith(" ")]
    line = ADDON.read_text().split("\nFABRICS = (")[1].split(")")[0]
    assert [word.strip(' "\n') for word in line.split(",")] == listed, listed


def round_trip(bench):
    """Export, run, check, import: places, pins, rate and range."""
    blend = bench.make("hanging")
    said = bench.do(*bench.addon(blend, "export", bench.at("scene/hanging.json")))
    assert "'red sheet': UV map times 0.4 gives metres" in said, said
    assert "'floor': left out 1 vertices without a face" in said, said
    scene = json.loads((bench.folder / "scene/hanging.json").read_text())
    assert scene["time"] == {"frame_rate": 30, "frames": 6}, scene
    assert [cloth["name"] for cloth in scene["cloths"]] == ["red_sheet"], scene
    assert scene["materials"] == {"denim": {"fabric": "denim"}}, scene
    assert sorted(body["name"] for body in scene["obstacles"]) == ["block", "floor"], scene
    pinned = scene["pins"][0]["vertices"]
    assert len(pinned) == 13, scene
    bench.simulate(bench.at("scene/hanging.json"), "run")

    bench.do(*bench.addon(None, "import", bench.at("run"), bench.at("back.blend")))
    back = bench.look(bench.at("back.blend"), 1, 4, 7)
    assert (back["start"], back["end"]) == (1, 7) and abs(back["rate"] - 30) < 1e-6, back
    assert sorted(back["shape_keys"].items()) == [("block", 7), ("red_sheet", 7)], back["shape_keys"]
    for frame in (1, 4, 7):
        cloth = obj_positions(bench.folder / f"run/frames/cloth_{frame - 1:05d}.obj")["red_sheet"]
        bodies = obj_positions(bench.folder / f"run/frames/obstacle_{frame - 1:05d}.obj")
        seen = back["frames"][str(frame)]
        expect_same(seen["red_sheet"], cloth, f"cloth in frame {frame}")
        for body in ("block", "floor"):
            expect_same(seen[body], bodies[body], f"{body} in frame {frame}")
    first, last = back["frames"]["1"], back["frames"]["7"]
    fallen = [math.dist(a, b) for a, b in zip(first["red_sheet"], last["red_sheet"])]
    assert max(fallen[v] for v in pinned) == 0 and max(fallen) > 0.01, max(fallen)

    # Where the artist put things: the sheet at the start, the bodies in all frames.
    drawn = bench.look(blend, 5, 8, 11)["frames"]
    expect_same(first["red_sheet"], drawn["5"]["red sheet"], "the sheet at the start")
    for theirs, ours in (("5", "1"), ("8", "4"), ("11", "7")):
        expect_same(back["frames"][ours]["block"], drawn[theirs]["block"], f"the block in frame {theirs}")


def refusals(bench):
    """Bad input ends with exit code 2 and one line."""
    bench.make("no_cloth", "changing_body", "no_map")
    for name, line in (
            ("no_cloth", "weft: no visible mesh is a cloth; choose Cloth in the panel weft, or set the custom "
                         "property weft to 'cloth'"),
            ("changing_body", "weft: object 'block': its faces change at frame"),
            ("no_map", "weft: cloth 'red sheet' has no UV map and is not flat; unwrap it (UV > Unwrap)")):
        code, output = bench.call(*bench.addon(bench.at(f"{name}.blend"), "export", bench.at("x.json")))
        assert code == 2 and any(said.startswith(line) for said in output.splitlines()), (name, code, output)
        assert "Traceback" not in output, output
    code, output = bench.call(*bench.addon(None, "import", bench.at("none"), bench.at("x.blend")))
    assert code == 2 and "scene.json: is missing" in output, output
    code, output = bench.call(*bench.addon(bench.at("no_map.blend"), "bake", "pc2", bench.at("x.blend")))
    assert code == 2 and "weft: no mesh to bake" in output, output
    run = bench.folder / "broken"
    (run / "frames").mkdir(parents=True)
    (run / "scene.json").write_text('{"time": {"frame_rate": 25}}')
    (run / "frames/cloth_00000.obj").write_text("o a\nv 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3\n")
    code, output = bench.call(*bench.addon(None, "import", run, bench.at("x.blend")))
    assert code == 2 and "cloth_00000.obj: is not a frame of weft" in output, output


def operators(bench):
    """The add-on can be installed, and its operators do what the command line does."""
    (bench.folder / "blender").mkdir()
    blend = bench.make("hanging")
    bench.do(*bench.addon(blend, "export", bench.at("s.json")))
    bench.simulate(bench.at("s.json"), "run")
    bench.do("blender", "-b", "--factory-startup", blend, "--python-exit-code", 1, "-P", SCENES, "--", "operate", ADDON,
             bench.folder)
    scene = json.loads((bench.folder / "operated.json").read_text())
    assert scene["materials"] == {"swimwear": {"fabric": "swimwear"}}, scene
    assert [body["name"] for body in scene["obstacles"]] == ["block"], scene
    assert scene["pins"][0]["obstacle"] == "block", scene
    assert (bench.folder / "red_sheet.pc2").stat().st_size == 32 + 7 * 169 * 12


def carried(bench):
    """Pins follow a body; a distorted UV map of a flat mesh does not count."""
    said = bench.do(*bench.addon(bench.make("carried"), "export", bench.at("carried.json")))
    assert "'red sheet': its UV map is distorted; the flat mesh is the rest shape" in said, said
    bench.simulate(bench.at("carried.json"), "run")
    scene = json.loads((bench.folder / "carried.json").read_text())
    (pin,) = scene["pins"]
    assert pin["obstacle"] == "block", pin
    places = [obj_positions(bench.folder / f"run/frames/cloth_0000{frame}.obj")["red_sheet"] for frame in (0, 6)]
    risen = min(b[2] - a[2] for v, (a, b) in enumerate(zip(*places)) if v in pin["vertices"])
    assert abs(risen - 0.1) < 1e-3, risen  # as the block does


def mirrored(bench):
    """Two halves of a sheet that share one map, mirrored, are sound cloth."""
    said = bench.do(*bench.addon(bench.make("mirrored"), "export", bench.at("mirrored.json")))
    assert "'red sheet': 144 mirrored triangles of the UV map are turned over" in said, said
    bench.simulate(bench.at("mirrored.json"), "run")


def sewn(bench):
    """Edges without a face become a seam, which closes."""
    said = bench.do(*bench.addon(bench.make("sewn"), "export", bench.at("sewn.json")))
    assert "7 sewn pairs" in said, said
    bench.simulate(bench.at("sewn.json"), "run", "--set", "time.frames=16")
    (seam,) = json.loads((bench.folder / "run/report.json").read_text())["seams"]
    assert seam["pairs"] == 7 and seam["open"] == 0, seam
    bench.do(*bench.addon(None, "import", bench.at("run"), bench.at("back.blend")))
    back = bench.look(bench.at("back.blend"), 17)["frames"]["17"]
    expected = obj_positions(bench.folder / "run/frames/cloth_00016.obj")["red_sheet"]
    (name,) = (name for name in back if name.startswith("red_sheet"))
    expect_same(back[name], expected, "sewn cloth")


def formats(bench):
    """In centimetres: point caches and PLY arrive where OBJ does, and baking keeps every place."""
    blend = bench.make("centimetres")
    bench.do(*bench.addon(blend, "export", bench.at("cm.json")))
    bench.simulate(bench.at("cm.json"), "obj")
    expected = {}
    for frame in (5, 8, 11):
        expected[frame] = [[100 * x for x in place] for place in obj_positions(
            bench.folder / f"obj/frames/cloth_{frame - 5:05d}.obj")["red_sheet"]]
    assert abs(max(x[2] for x in expected[5]) - 100) < 1e-4

    def arrived(file, name, what):
        seen = bench.look(bench.at(file), 5, 8, 11)
        assert (seen["start"], seen["end"]) == (5, 11), seen["start"]
        for frame, positions in expected.items():
            expect_same(seen["frames"][str(frame)][name][: len(positions)], positions, f"{what}, frame {frame}")
        return seen

    for kind, name in (("obj", "red_sheet"), ("pc2", "red_sheet"), ("ply", "cloth")):
        if kind != "obj":
            bench.simulate(bench.at("cm.json"), kind, "--set", f"output.format={kind}")
        # Into the artist's file, whose units and start they take.
        bench.do(*bench.addon(blend, "import", bench.at(kind), bench.at(f"{kind}.blend")))
        seen = arrived(f"{kind}.blend", name, kind)
    assert bench.look(bench.at("pc2.blend"), 5)["modifiers"]["red_sheet"] == ["MESH_CACHE"]

    # The result that is in the file now is no part of its scene.
    bench.do(*bench.addon(bench.at("obj.blend"), "export", bench.at("again/cm.json")))
    assert (bench.folder / "again/cm.json").read_text() == (bench.folder / "cm.json").read_text()

    for source, target in (("pc2", "shape_keys"), ("obj", "pc2"), ("obj", "mdd")):
        file = f"baked_{target}.blend"
        bench.do(*bench.addon(bench.at(f"{source}.blend"), "bake", target, bench.at(file), "--folder",
                              bench.at("caches")))
        seen = arrived(file, "red_sheet", f"{source} baked to {target}")
        assert seen["modifiers"]["red_sheet"] == ([] if target == "shape_keys" else ["MESH_CACHE"]), seen["modifiers"]
        assert ("red_sheet" in seen["shape_keys"]) == (target == "shape_keys"), seen["shape_keys"]
    head = (bench.folder / "caches/red_sheet.mdd").read_bytes()[:8]
    assert struct.unpack(">2i", head) == (7, 169), head

    code, output = bench.call(*bench.addon(blend, "import", bench.at("usd"), bench.at("x.blend")))
    assert code == 2, output
    bench.do(bench.weft, "run", bench.at("cm.json"), "-o", bench.at("usd"), "--device", "cpu:1", "--set",
             "output.format=usda")
    code, output = bench.call(*bench.addon(blend, "import", bench.at("usd"), bench.at("x.blend")))
    assert code == 2 and "no frames in obj, ply or pc2" in output, output


def far_away(bench):
    """Far from the origin, shapes keep their precision: the object stands at the origin of the run."""
    bench.do(*bench.addon(bench.make("hanging"), "export", bench.at("s.json")))
    scene = json.loads((bench.folder / "s.json").read_text())
    scene["pins"] = []
    for item in scene["cloths"] + scene["obstacles"]:
        item["transform"] = {"translate": [4194304, 0, 0]}
    (bench.folder / "far.json").write_text(json.dumps(scene))
    for kind in ("obj", "pc2"):
        bench.simulate(bench.at("far.json"), kind, "--set", f"output.format={kind}")
        bench.do(*bench.addon(None, "import", bench.at(kind), bench.at("back.blend")))
        seen = bench.look(bench.at("back.blend"), 7)
        here = seen["locations"]["red_sheet"]
        assert abs(here[0] - 4194304) < 1, here
        sheet = obj_positions(bench.folder / "obj/frames/cloth_00006.obj")["red_sheet"]
        expect_same(seen["local"]["7"]["red_sheet"], [[x - y for x, y in zip(place, here)] for place in sheet], kind)


def changing_triangles(bench):
    """Cloth that is remeshed becomes objects that take turns."""
    bench.do(*bench.addon(bench.make("hanging"), "export", bench.at("s.json")))
    bench.simulate(bench.at("s.json"), "run", "--method", "adaptive")
    said = bench.do(*bench.addon(None, "import", bench.at("run"), bench.at("back.blend")))
    assert "cloth 'red_sheet': its triangles change" in said, said
    back = bench.look(bench.at("back.blend"), 1, 2, 5, 7)
    for frame, seen in back["frames"].items():
        expected = obj_positions(bench.folder / f"run/frames/cloth_{int(frame) - 1:05d}.obj")["red_sheet"]
        (name,) = (name for name in seen if name.startswith("red_sheet"))
        expect_same(seen[name], expected, f"cloth in frame {frame}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("names", nargs="+")
    options = parser.parse_args()
    if shutil.which("blender") is None:
        print("NOT TESTED: there is no Blender (package blender)")
        return 77
    for name in options.names:
        with tempfile.TemporaryDirectory() as folder:
            globals()[name](Bench(options.program, folder))
        print(f"{name}: passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
