#!/usr/bin/env python3
"""Makes the mannequin that patterns.py drafts for: arms lowered by 42 degrees, 1.66 m tall, y up, in metres.

usage: mannequin.py FILE.obj [--cell 0.02]

Its surface is where a blend of ellipsoids and cones with round ends is zero, cut by tetrahedra.
"""
import argparse
import math
import pathlib
import sys

BLEND = 0.035  # m, over which shapes run into each other

# Ellipsoids: centre, radii. [m]
ELLIPSOIDS = [((0, 0.86, 0.015), (0.186, 0.15, 0.134)), ((0, 1.06, 0.03), (0.15, 0.16, 0.116)),
              ((0, 1.215, 0.015), (0.156, 0.15, 0.128)), ((0, 1.555, 0.015), (0.075, 0.112, 0.095))]


def limbs():
    """Cones with round ends: two centres, two radii. [m]"""
    c, s = math.cos(math.radians(42)), math.sin(math.radians(42))
    made = [((0, 1.34, -0.02), (0, 1.46, 0.01), 0.056, 0.05)]
    for side in (1, -1):
        def arm(along, side=side):
            return (side * (0.165 + c * along), 1.33 - s * along, -0.025)
        made += [((side * 0.05, 1.345, -0.02), (side * 0.165, 1.33, -0.025), 0.06, 0.056),
                 (arm(0), arm(0.27), 0.046, 0.038), (arm(0.27), arm(0.5), 0.038, 0.027), (arm(0.5), arm(0.63), 0.03, 0.024),
                 ((side * 0.095, 0.80, 0.02), (side * 0.098, 0.46, 0.0), 0.088, 0.056),
                 ((side * 0.098, 0.46, 0.0), (side * 0.1, 0.09, -0.03), 0.056, 0.037),
                 ((side * 0.1, 0.045, -0.05), (side * 0.105, 0.035, 0.1), 0.04, 0.032)]
    return made


CONES = limbs()


def ellipsoid(p, centre, radii):
    """About the distance from its surface."""
    q = [(x - c) / r for x, c, r in zip(p, centre, radii)]
    far = math.sqrt(sum(x * x for x in q))
    slope = math.sqrt(sum((x / r) ** 2 for x, r in zip(q, radii)))
    return far * (far - 1) / slope if slope > 0 else -min(radii)


def cone(p, a, b, ra, rb):
    axis = [y - x for x, y in zip(a, b)]
    t = sum((x - y) * z for x, y, z in zip(p, a, axis)) / sum(z * z for z in axis)
    t = min(max(t, 0.0), 1.0)
    return math.sqrt(sum((x - y - t * z) ** 2 for x, y, z in zip(p, a, axis))) - (ra + t * (rb - ra))


def height(p):
    """Below zero inside of the body."""
    total = 1.0
    for d in [ellipsoid(p, *e) for e in ELLIPSOIDS] + [cone(p, *c) for c in CONES]:
        h = max(BLEND - abs(total - d), 0.0) / BLEND
        total = min(total, d) - h * h * BLEND / 4
    return total


# The six tetrahedra of a cube, all around its diagonal, so that faces of neighbours match.
TETRAHEDRA = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]


def surface(cell):
    """Vertices and triangles, fronts outside."""
    low, count = (-0.72, -0.04, -0.2), [math.ceil(x / cell) for x in (1.44, 1.76, 0.42)]
    place = lambda i, j, k: (low[0] + i * cell, low[1] + j * cell, low[2] + k * cell)
    values = {(i, j, k): height(place(i, j, k)) for i in range(count[0] + 1) for j in range(count[1] + 1)
              for k in range(count[2] + 1)}
    vertices, numbers, triangles = [], {}, []

    def crossing(a, b):
        if (key := (min(a, b), max(a, b))) not in numbers:
            a, b = key
            t = min(max(values[a] / (values[a] - values[b]), 0.03), 0.97)  # no slivers
            numbers[key] = len(vertices)
            vertices.append([x + t * (y - x) for x, y in zip(place(*a), place(*b))])
        return numbers[key]

    for i in range(count[0]):
        for j in range(count[1]):
            for k in range(count[2]):
                cube = [(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)) for c in range(8)]
                if len({values[c] < 0 for c in cube}) == 1:
                    continue
                for tetrahedron in TETRAHEDRA:
                    corners = [cube[c] for c in tetrahedron]
                    inside = [c for c in corners if values[c] < 0]
                    outside = [c for c in corners if values[c] >= 0]
                    if not inside or not outside:
                        continue
                    if len(inside) == 2:
                        ring = [crossing(inside[m], outside[n]) for m, n in ((0, 0), (0, 1), (1, 1), (1, 0))]
                    else:
                        ring = [crossing(a, b) for a in inside for b in outside]
                    middle = [sum(c[n] for c in outside) / len(outside) - sum(c[n] for c in inside) / len(inside)
                              for n in range(3)]
                    p, q, r = (vertices[v] for v in ring[:3])
                    u, v = [y - x for x, y in zip(p, q)], [y - x for x, y in zip(p, r)]
                    normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
                    if sum(x * y for x, y in zip(normal, middle)) < 0:
                        ring.reverse()
                    triangles += [(ring[0], ring[n], ring[n + 1]) for n in range(1, len(ring) - 1)]
    return vertices, triangles


def write(path, cell=0.02):
    vertices, triangles = surface(cell)
    lines = ["o body", *(f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices),
             *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles)]
    pathlib.Path(path).write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("file")
    parser.add_argument("--cell", type=float, default=0.02, help="edge length of its surface [m]")
    given = parser.parse_args()
    write(given.file, given.cell)
    return 0


if __name__ == "__main__":
    sys.exit(main())
