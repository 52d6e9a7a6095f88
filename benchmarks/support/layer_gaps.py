"""Distances between layers of cloth in a frame: parts that are far apart along the cloth."""

import math
from collections import defaultdict

RINGS = 6  # edges that a triangle is away from a vertex at least, to be another layer
FAR = 4  # thicknesses from which layers are not looked at


def read_obj(path):
    """Vertices [m] and triangles of an OBJ file."""
    vertices, triangles = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words and words[0] == "v":
            vertices.append(tuple(map(float, words[1:4])))
        elif words and words[0] == "f":
            triangles.append(tuple(int(word.split("/")[0]) - 1 for word in words[1:4]))
    return vertices, triangles


def minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def to_segment(p, a, b):
    """[m] distance of a point from a segment"""
    along, to_p = minus(b, a), minus(p, a)
    length_sq = dot(along, along)
    share = min(1.0, max(0.0, dot(to_p, along) / length_sq)) if length_sq > 0 else 0.0
    return math.dist(p, [a[k] + share * along[k] for k in range(3)])


def to_triangle(p, a, b, c):
    """[m] distance of a point from a triangle"""
    u, v, w = minus(b, a), minus(c, a), minus(p, a)
    uu, uv, vv, wu, wv = dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v)
    det = uu * vv - uv * uv
    if det > 0:
        s, t = (vv * wu - uv * wv) / det, (uu * wv - uv * wu) / det
        if s >= 0 and t >= 0 and s + t <= 1:
            return math.dist(p, [a[k] + s * u[k] + t * v[k] for k in range(3)])
    return min(to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a))


def layer_gaps(path, thickness):
    """[m] distances of vertices from the nearest other layer, of those within FAR thicknesses.

    path: of an OBJ frame   thickness: [m]
    """
    vertices, triangles = read_obj(path)
    reach = FAR * thickness
    neighbours = defaultdict(set)
    for triangle in triangles:
        for corner in triangle:
            neighbours[corner].update(triangle)
    longest = max(math.dist(vertices[t[k]], vertices[t[k - 1]]) for t in triangles for k in range(3))
    cell = longest + reach

    def cell_of(x):
        return tuple(math.floor(x[k] / cell) for k in range(3))

    grid = defaultdict(set)
    for number, triangle in enumerate(triangles):
        corners = [vertices[corner] for corner in triangle]
        low = cell_of([min(x[k] for x in corners) - reach for k in range(3)])
        high = cell_of([max(x[k] for x in corners) + reach for k in range(3)])
        for x in range(low[0], high[0] + 1):
            for y in range(low[1], high[1] + 1):
                for z in range(low[2], high[2] + 1):
                    grid[x, y, z].add(number)
    gaps = []
    for vertex, place in enumerate(vertices):
        around = front = {vertex}
        for _ in range(RINGS):
            front = {n for v in front for n in neighbours[v]} - around
            around = around | front
        gap = min((to_triangle(place, *(vertices[corner] for corner in triangles[number]))
                   for number in grid.get(cell_of(place), ())
                   if around.isdisjoint(triangles[number])), default=math.inf)
        if gap < reach:
            gaps.append(gap)
    return gaps
