#!/usr/bin/env python3
"""Writes scenes of dancers before a camera, for weft_bench_adaptive.

    crowd_scenes.py DIR                 karate, dancer, dancers_10, dancers_100 (.json)
    crowd_scenes.py DIR --take FILE     another copy of Boxing_Toes.bvh of assimp's test models

Every dancer is a body of capsules on that take of motion capture, in a circular skirt that starts
flat around the waist (scenes/dancer_skirt.json). They stand for scenes of Koh, Narain and O'Brien
2015 (Table 1), whose characters and garments are not published: a boxer in three skirts over each
other for Karate's three interacting garments, one dancer, ten of them. `triangles` are the paper's.
"""

import argparse
import json
import math
import sys
from pathlib import Path

TAKE = "/usr/share/assimp/models/BVH/Boxing_Toes.bvh"
WAIST = (-0.096, -0.51, 1.055)  # [m] of the body at the first frame that is used
TILT = [4.36, -0.038, 0.066, 0]
MIDDLE = (-0.1, -0.5)           # [m] about which the body moves
# Faces of the paper's fixed meshes.
FACES = {"karate": 123790, "dancer": 43710, "dancers_10": 437100}


def body(name, place, edge):
    return {
        "name": name,
        "units": "cm",
        "capture": {
            "file": arguments.take, "first": 520, "last": 1000,
            "start_time": 0.6, "radius": {"Hips": 0.105, "Ab": 0.11, "Chest": 0.1}, "edge": edge
        },
        "transform": {"translate": [place[0], place[1], 0]},
        "friction": 0.3,
    }


def skirt(name, place, inner=0.13, outer=0.68, lift=0.0):
    x, y, z = WAIST
    return {
        "name": name,
        "disc": {"inner_radius": inner, "radius": outer},
        "transform": {"translate": [x + place[0], y + place[1], z + lift], "rotate": TILT},
        "material": "viscose",
    }


def pin(cloth, obstacle):
    return {"cloth": cloth, "edge": "inner", "obstacle": obstacle}


def key(time, position, look_at, view=38, jump=False):
    made = {"time": time, "position": position, "look_at": look_at, "field_of_view": view}
    return {**made, "jump": True} if jump else made


def scene(name, description, triangles, keys, places, edge=0.03, layers=None, view=None):
    """A skirt of each layer on each place.

    layers: (inner radius, outer radius, lift) [m]
    """
    cloths, obstacles, pins = [], [], []
    layers = layers or [(0.13, 0.68, 0.0)]
    for i, place in enumerate(places):
        obstacles.append(body(f"dancer_{i}", place, edge))
        for k, (inner, outer, lift) in enumerate(layers):
            cloth = f"skirt_{i}" if len(layers) == 1 else f"skirt_{i}_{k}"
            cloths.append(skirt(cloth, place, inner, outer, lift))
            pins.append(pin(cloth, f"dancer_{i}"))
    return {
        "name": name, "description": description, "triangles": triangles,
        "time": {"step": 0.004, "frame_rate": 25, "frames": 75},
        "materials": {
            "viscose": {"density": 0.13, "stretch_stiffness": 600, "poisson_ratio": 0.3,
                        "bending_stiffness": 4e-6, "damping": {"stiffness": 3e-4}}
        },
        "cloths": cloths, "obstacles": obstacles, "pins": pins,
        "method": {"type": "view", "view": view or {}},
        "camera": {"resolution": [960, 540], "keys": keys},
    }


def one_dancer_keys():
    """Closes in until the hem is out of the picture, and cuts to the other side."""
    x, y = MIDDLE
    return [key(0, [x + 1.4, y - 3.2, 1.5], [x, y, 0.95]),
            key(1, [x + 0.9, y - 1.9, 1.5], [x, y, 1.1]),
            key(1.6, [x - 1.6, y + 2.0, 1.6], [x, y, 1.0], 34, True),
            key(3.2, [x - 2.0, y + 1.2, 1.5], [x, y, 0.95], 34)]


def grid(columns, rows, dx, dy):
    return [((i - (columns - 1) / 2) * dx, j * dy) for j in range(rows) for i in range(columns)]


def crowd_keys(depth):
    """Passes by the first row, and cuts to one dancer who hides some of the others."""
    x, y = MIDDLE
    return [key(0, [x - 3.0, y - 3.6, 1.7], [x - 1.2, y + 1.0, 0.9]),
            key(1.4, [x + 0.5, y - 3.2, 1.6], [x + 0.9, y + 1.0, 0.9]),
            key(1.8, [x + 1.1, y - 2.4, 1.5], [x + 1.1, y + depth, 0.95], 34, True),
            key(3.2, [x + 1.6, y - 2.2, 1.5], [x + 1.0, y + depth, 0.95], 34)]


def scenes():
    hides = {"occlusion": True}
    yield scene("karate", "Three skirts over each other on a boxer.", FACES["karate"],
                one_dancer_keys(), [(0, 0)],
                layers=[(0.13, 0.52, 0.0), (0.14, 0.6, 0.014), (0.15, 0.68, 0.028)],
                view={"factor_out": 0.1})
    yield scene("dancer", "One dancer.", FACES["dancer"], one_dancer_keys(), [(0, 0)])
    yield scene("dancers_10", "Ten dancers, some of them hidden.", FACES["dancers_10"],
                crowd_keys(1.0), grid(5, 2, 2.2, 2.4), edge=0.04, view=hides)
    yield scene("dancers_100", "A hundred dancers.", 200000, crowd_keys(8.0),
                grid(10, 10, 2.2, 2.4), edge=0.08, view=hides)


def main():
    for made in scenes():
        path = arguments.directory / f"{made['name']}.json"
        path.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="crowd_scenes.py", description=__doc__.splitlines()[0])
    parser.add_argument("directory", type=Path, metavar="DIR", help="where the files go")
    parser.add_argument("--take", default=TAKE, metavar="FILE", help=f"default: {TAKE}")
    arguments = parser.parse_args()
    try:
        sys.exit(main())
    except OSError as error:
        print(f"crowd_scenes.py: {error}", file=sys.stderr)
        sys.exit(2)
