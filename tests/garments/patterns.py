#!/usr/bin/env python3
"""Drafts sewing patterns and writes them in GarmentCode's JSON format.

usage: patterns.py FOLDER [NAME...]     FOLDER/NAME_specification.json; without names, all
       patterns.py --list

The wearer is about 166 cm tall, with arms lowered by 42 degrees: BODY holds the measures. Lengths
are centimetres, y points up, z to the front, and "left" is the wearer's left, at positive x.
Panels stand around the wearer as GarmentCode places them: before and behind, flat, their fronts
away from the body. `OVER` names patterns that are worn over another one.
"""
import json
import math
import pathlib
import sys

BODY = {"waist": 84.0, "waist_y": 106.0, "hips": 107.0, "hips_y": 83.0, "bust": 97.0, "crotch_y": 76.0,
        "neck_y": 140.0, "shoulder_y": 136.5, "shoulder": 18.5, "underarm_y": 120.5, "thigh": 67.0,
        "knee_y": 45.0, "ankle_y": 9.0, "arm": 42.0, "arm_length": 54.0, "wrist": 20.0}
BEFORE, BEHIND = 25.0, -22.0  # where panels stand


# ------------------------------------------------------------------------------------------ curves
def quadratic(x, y):
    """A control point along and across the chord, as shares of its length."""
    return ("quadratic", [[x, y]])


def cubic(a, b):
    return ("cubic", [list(a), list(b)])


def arc(radius, large, right):
    return ("circle", [radius, int(large), int(right)])


def turned(curve):
    """The same curve from its end to its beginning."""
    if curve is None:
        return None
    kind, params = curve
    if kind == "circle":
        return arc(params[0], params[1], not params[2])
    return (kind, [[1 - x, -y] for x, y in reversed(params)])


def mirrored(curve):
    if curve is None:
        return None
    kind, params = curve
    if kind == "circle":
        return arc(params[0], params[1], not params[2])
    return (kind, [[x, -y] for x, y in params])


def curve_length(a, b, curve):
    chord = math.dist(a, b)
    if curve is None:
        return chord
    kind, params = curve
    if kind == "circle":
        angle = 2 * math.asin(min(1.0, chord / (2 * params[0])))
        return params[0] * (2 * math.pi - angle if params[1] else angle)
    controls = [(0.0, 0.0), *params, (1.0, 0.0)]
    def point(t):
        points = controls
        while len(points) > 1:
            points = [[(1 - t) * p + t * q for p, q in zip(u, v)] for u, v in zip(points, points[1:])]
        return points[0]
    steps = [point(k / 200) for k in range(201)]
    return chord * sum(math.dist(p, q) for p, q in zip(steps, steps[1:]))


# ------------------------------------------------------------------------------------------ panels
class Panel:
    """path: corners (x, y, name of the edge that begins there, its curve or None, its label or "")."""

    def __init__(self, name, label, path, at=(0, 0, 0), turn=(0, 0, 0)):
        self.name, self.label, self.at, self.turn = name, label, list(at), list(turn)
        self.path = [(list(corner) + [None, ""])[:5] if len(corner) < 5 else list(corner) for corner in path]

    def edge(self, name):
        return [corner[2] for corner in self.path].index(name)

    def length(self, name):
        k = self.edge(name)
        corner, after = self.path[k], self.path[(k + 1) % len(self.path)]
        return curve_length(corner[:2], after[:2], corner[3])

    def mirror(self, name):
        """The other side of the body, with the same names of edges."""
        path = [[-x, y, edge, mirrored(curve), label] for x, y, edge, curve, label in self.path]
        return Panel(name, self.label, path, [-self.at[0], *self.at[1:]], [self.turn[0], -self.turn[1], -self.turn[2]])

    def place(self, x, y):
        point = [x, y, 0.0]
        for axis in range(3):
            c, s = math.cos(math.radians(self.turn[axis])), math.sin(math.radians(self.turn[axis]))
            j, k = (axis + 1) % 3, (axis + 2) % 3
            point[j], point[k] = c * point[j] - s * point[k], s * point[j] + c * point[k]
        return [p + t for p, t in zip(point, self.at)]

    def reverse(self):
        path, n = self.path, len(self.path)
        self.path = [[*path[(k + 1) % n][:2], path[k][2], turned(path[k][3]), path[k][4]] for k in reversed(range(n))]

    def face_outwards(self):
        """Front away from the body's axis: to the side that the panel stands on."""
        twice = sum(p[0] * q[1] - p[1] * q[0] for p, q in zip(self.path, self.path[1:] + self.path[:1]))
        origin, tip = self.place(0, 0), [0, 0, 1.0]
        for axis in range(3):
            c, s = math.cos(math.radians(self.turn[axis])), math.sin(math.radians(self.turn[axis]))
            j, k = (axis + 1) % 3, (axis + 2) % 3
            tip[j], tip[k] = c * tip[j] - s * tip[k], s * tip[j] + c * tip[k]
        if (twice > 0) != (tip[0] * origin[0] + tip[2] * origin[2] > 0):
            self.reverse()

    def json(self):
        self.face_outwards()
        x0, y0 = self.path[0][:2]
        edges = []
        for k, (_, _, _, curve, label) in enumerate(self.path):
            edge = {"endpoints": [k, (k + 1) % len(self.path)]}
            if curve is not None:
                edge["curvature"] = {"type": curve[0], "params": curve[1]}
            if label:
                edge["label"] = label
            edges.append(edge)
        panel = {"translation": self.place(x0, y0), "rotation": self.turn,
                 "vertices": [[x - x0, y - y0] for x, y, *_ in self.path], "edges": edges}
        if self.label:
            panel["label"] = self.label
        return panel


class Pattern:
    def __init__(self):
        self.panels, self.stitches = {}, []

    def add(self, *panels):
        for panel in panels:
            self.panels[panel.name] = panel
        return self

    def sew(self, a, b, *marks):
        """Sides as "panel.edge"; lists of them one by one."""
        if isinstance(a, list):
            for one, other in zip(a, b, strict=True):
                self.sew(one, other, *marks)
        else:
            self.stitches.append((a.rsplit(".", 1), b.rsplit(".", 1), marks))
        return self

    def length(self, side):
        panel, edge = side.rsplit(".", 1)
        return self.panels[panel].length(edge)

    def json(self):
        panels = {name: panel.json() for name, panel in self.panels.items()}
        side = lambda panel, edge: {"panel": panel, "edge": self.panels[panel].edge(edge)}
        stitches = [[side(*a), side(*b), *marks] for a, b, marks in self.stitches]
        return {"pattern": {"panels": panels, "stitches": stitches, "panel_order": list(panels)},
                "parameters": {}, "parameter_order": [],
                "properties": {"curvature_coords": "relative", "normalize_panel_translation": False,
                               "normalized_edge_loops": True, "units_in_meter": 100}}


def whole(half):
    """A symmetric outline from its left half, which runs from the centre below to the centre above; edges get _l and _r.

    An edge that begins or ends on the centre line becomes two, but the first one, which becomes one.
    """
    left = [list(c) + [None, ""][len(c) - 3:] if len(c) < 5 else list(c) for c in half]
    ends = [*left[1:], None]
    path = []
    for k, (x, y, edge, curve, label) in enumerate(left[:-1]):
        if k > 0:
            path.append([x, y, edge + "_l", curve, label])
    x, y, _, _, _ = left[-1]
    path.append([x, y, left[-2][2] + "_r", mirrored(turned(left[-2][3])), left[-2][4]])
    for k in range(len(left) - 2, 0, -1):
        x, y = left[k][:2]
        before = left[k - 1]
        name = before[2] + "_r" if k > 1 else before[2]
        path.append([-x, y, name, mirrored(turned(before[3])), before[4]])
    return path


# ------------------------------------------------------------------------------------------- torso
def torso(pattern, prefix="", label="body", hem_y=98.0, bust=107.0, hem=None, neck=8.0, depth=(9.0, 2.5),
          shoulder=None, underarm_y=None, neck_curve=None, split=False, out=0.0, hem_label="", waist_darts=0.0,
          open_front=False):
    """Front and back of a top, sewn at shoulders and sides. Edges: hem, side, armhole, shoulder, neck (and centre)."""
    shoulder = BODY["shoulder"] if shoulder is None else shoulder
    under = BODY["underarm_y"] if underarm_y is None else underarm_y
    hem = bust if hem is None else hem
    for part, low in (("f", depth[0]), ("b", depth[1])):
        z = BEFORE + out if part == "f" else BEHIND - out
        curve = neck_curve if neck_curve else quadratic(0.5, -0.28)
        half = [(0, hem_y, "hem", None, hem_label), (hem / 4, hem_y, "side"),
                (bust / 4, under, "armhole", cubic((0.45, 0.25), (0.75, 0.2))),
                (shoulder, BODY["shoulder_y"] + 1, "shoulder"), (neck, BODY["neck_y"] + 1.5, "neck", curve),
                (0, BODY["neck_y"] + 1.5 - low, "centre")]
        if waist_darts:
            x, w = hem / 8, waist_darts / 2
            half[0:1] = [(0, hem_y, "hem", None, hem_label), (x - w, hem_y, "dart_in"), (x, hem_y + 13, "dart_out"),
                         (x + w, hem_y, "hem_side", None, hem_label)]
        name = prefix + part + "torso"
        if split or waist_darts:
            left = Panel("left_" + name, label, half, (0, 0, z))
            pattern.add(left, left.mirror("right_" + name))
        else:
            pattern.add(Panel(name, label, whole(half), (0, 0, z)))
    halves = split or bool(waist_darts)
    for side in ("l", "r"):
        full = {"l": "left_", "r": "right_"}[side] + prefix if halves else prefix
        suffix = "" if halves else "_" + side
        for edge in ("side", "shoulder"):
            pattern.sew(f"{full}ftorso.{edge}{suffix}", f"{full}btorso.{edge}{suffix}")
        if waist_darts:
            for part in "fb":
                pattern.sew(f"{full}{part}torso.dart_in", f"{full}{part}torso.dart_out")
    if halves:
        for part in "b" if open_front else "fb":
            pattern.sew(f"left_{prefix}{part}torso.centre", f"right_{prefix}{part}torso.centre")
    return pattern


def torso_edge(pattern, part, edge, side, prefix=""):
    """The name of an edge of a torso, whole or in halves. side: l or r"""
    whole_name = f"{prefix}{part}torso"
    if whole_name in pattern.panels:
        return f"{whole_name}.{edge}_{side}"
    return f"{ {'l': 'left_', 'r': 'right_'}[side]}{whole_name}.{edge}"


def sleeves(pattern, length=50.0, wrist=26.0, cuff=0.0, cuff_length=22.0, sides="lr", prefix="", width=None, out=0.0,
            label="arm"):
    """Two panels an arm, before and behind it, with or without cuffs."""
    for part, z in (("f", 14.0 + out), ("b", -16.0 - out)):
        hole = pattern.length(torso_edge(pattern, part, "armhole", sides[0], prefix))
        high = hole * 0.86 if width is None else width / 2
        curve, low, far = cubic((0.35, -0.12), (0.65, 0.1)), 0.0, hole
        for _ in range(60):  # how far the lower end of the cap stands out, so that cap and armhole are as long
            middle = (low + far) / 2
            if curve_length((middle, -high), (0, 0), curve) < hole:
                low = middle
            else:
                far = middle
        path = [(0, 0, "top"), (length, 0, "wrist"), (length, -wrist / 2, "under"), (low, -high, "cap", curve)]
        at = (BODY["shoulder"] + 3, BODY["shoulder_y"] + 2, z)
        panel = Panel(f"left_sleeve_{prefix}{part}", label, path, at, (0, 0, -BODY["arm"]))
        band = [(length + 3, 0, "top"), (length + 3 + cuff, 0, "wrist"), (length + 3 + cuff, -cuff_length / 2, "under"),
                (length + 3, -cuff_length / 2, "sleeve")]
        cuff_panel = Panel(f"left_cuff_{prefix}{part}", label, band, at, (0, 0, -BODY["arm"]))
        for side in sides:
            for made in [panel] + ([cuff_panel] if cuff else []):
                pattern.add(made if side == "l" else made.mirror(made.name.replace("left", "right", 1)))
    for side in sides:
        name = {"l": "left", "r": "right"}[side]
        for part in "fb":
            pattern.sew(f"{name}_sleeve_{prefix}{part}.cap", torso_edge(pattern, part, "armhole", side, prefix))
            if cuff:
                pattern.sew(f"{name}_sleeve_{prefix}{part}.wrist", f"{name}_cuff_{prefix}{part}.sleeve")
        for edge in ("top", "under"):
            pattern.sew(f"{name}_sleeve_{prefix}f.{edge}", f"{name}_sleeve_{prefix}b.{edge}")
            if cuff:
                pattern.sew(f"{name}_cuff_{prefix}f.{edge}", f"{name}_cuff_{prefix}b.{edge}")
    return pattern


def stand_collar(pattern, height=4.0):
    for part, z in (("f", 18.0), ("b", -20.0)):
        half = pattern.length(torso_edge(pattern, part, "neck", "l"))
        y = BODY["neck_y"] + 3
        path = [(-half, y, "neck_r"), (0, y, "neck_l"), (half, y, "end_l"), (half, y + height, "top"),
                (-half, y + height, "end_r")]
        pattern.add(Panel(f"collar_{part}", "body", path, (0, 0, z)))
        for side in "lr":
            pattern.sew(f"collar_{part}.neck_{side}", torso_edge(pattern, part, "neck", side))
    return pattern.sew(["collar_f.end_l", "collar_f.end_r"], ["collar_b.end_l", "collar_b.end_r"])


def lapels(pattern):
    """A strip behind the neck, and a lapel on each side of an open neckline."""
    back = pattern.length(torso_edge(pattern, "b", "neck", "l"))
    front = pattern.length(torso_edge(pattern, "f", "neck", "l"))
    y = BODY["neck_y"] + 3
    path = [(-back, y, "neck_r"), (0, y, "neck_l"), (back, y, "left_collar"), (back, y + 7, "top"),
            (-back, y + 7, "right_collar")]
    pattern.add(Panel("collar_b", "body", path, (0, 0, -20.0)))
    left = Panel("left_lapel", "body",
                 [(0, 0, "neck"), (0, front, "left_collar", None, ""), (-7, front, "edge", quadratic(0.4, -0.2))],
                 (8.0, BODY["neck_y"] - front + 2, 30.0), (0, 0, -12.0))
    pattern.add(left, left.mirror("right_lapel"))
    for side, name in (("l", "left"), ("r", "right")):
        pattern.sew(f"{name}_lapel.neck", torso_edge(pattern, "f", "neck", side))
        pattern.sew(f"collar_b.neck_{side}", torso_edge(pattern, "b", "neck", side))
        pattern.sew(f"{name}_lapel.left_collar", f"collar_b.{name}_collar")
    return pattern


def hood(pattern):
    """Two panels beside the head."""
    back, front = (pattern.length(torso_edge(pattern, part, "neck", "l")) for part in "bf")
    path = [(-back, 0, "neck_b", quadratic(0.5, -0.05)), (0, 0, "neck_f"), (front, -2, "face", quadratic(0.5, -0.08)),
            (front + 1, 31, "top", cubic((0.3, -0.3), (0.75, -0.4))), (-back - 4, 9, "nape", quadratic(0.5, 0.05))]
    left = Panel("left_hood", "", path, (17.0, BODY["neck_y"] + 3, 0), (0, -90, 0))
    pattern.add(left, left.mirror("right_hood"))
    for side, name in (("l", "left"), ("r", "right")):
        pattern.sew(f"{name}_hood.neck_f", torso_edge(pattern, "f", "neck", side))
        pattern.sew(f"{name}_hood.neck_b", torso_edge(pattern, "b", "neck", side))
    return pattern.sew(["left_hood.top", "left_hood.nape"], ["right_hood.top", "right_hood.nape"])


# ------------------------------------------------------------------------------------------ skirts
def band(pattern, name="wb", length=None, height=4.0, low=None, label="body", edge_label="lower_interface"):
    """A waistband of two panels; both halves of its lower edge are edges."""
    length = BODY["waist"] if length is None else length
    low = BODY["waist_y"] if low is None else low
    half = length / 4
    for part, z in (("front", BEFORE - 5), ("back", BEHIND + 3)):
        path = [(-half, low, "low_r", None, edge_label), (0, low, "low_l", None, edge_label), (half, low, "end_l"),
                (half, low + height, "top_l"), (0, low + height, "top_r"), (-half, low + height, "end_r")]
        pattern.add(Panel(f"{name}_{part}", label, path, (0, 0, z)))
    return pattern.sew([f"{name}_front.end_l", f"{name}_front.end_r"], [f"{name}_back.end_l", f"{name}_back.end_r"])


def skirt(pattern, length=60.0, waist=None, hem=130.0, darts=0.0, top=None, slit=0.0, hips=None, label="leg",
          curve=None, prefix="skirt", top_label="lower_interface", godets=0, pleats=0, pleat=0.0):
    """Front and back. Edges: hem, side, waist (several with darts, pleats and godets)."""
    waist = BODY["waist"] + 2 if waist is None else waist
    top = BODY["waist_y"] if top is None else top
    for part, z in (("front", BEFORE), ("back", BEHIND)):
        half = [(0, top - length, "hem"), (hem / 4, top - length, "side")]
        if godets and part == "front":
            half[0:1] = [(0, top - length, "hem"), (hem / 8, top - length, "cut_in"),
                         (hem / 8, top - length * 0.55, "cut_out"), (hem / 8 + 0.8, top - length, "hem_side")]
        upper = waist / 4 + darts
        if hips:
            half[-1] = (hem / 4, top - length, "side")
            half.append((hips / 4, top - (BODY["waist_y"] - BODY["hips_y"]), "hip", quadratic(0.5, -0.06)))
        if pleats:
            upper = waist / 4 + pleats * pleat
            step = waist / 4 / (pleats + 1)
            x = upper
            for k in range(pleats):
                half.append((x, top, f"waist{k}", None, top_label))
                x -= step
                half.append((x, top, f"pleat{k}_out"))
                half.append((x - pleat / 2, top, f"pleat{k}_in"))
                x -= pleat
            half.append((x, top, "waist", None, top_label))
        elif darts:
            x = waist / 8 + darts / 2
            half.append((upper, top, "waist0", None, top_label))
            half.append((x + darts / 2, top - 0.3, "dart_out"))
            half.append((x, top - 11, "dart_in"))
            half.append((x - darts / 2, top - 0.3, "waist", None, top_label))
        else:
            half.append((upper, top + (0.8 if curve else 0), "waist", curve, top_label))
        half.append((0, top - 0.5 if curve or darts else top, "centre"))
        if slit and part == "back":
            path = whole(half)
            k = next(i for i, corner in enumerate(path) if corner[2] == "hem")
            y = top - length
            path[k:k + 1] = [[*path[k][:2], "hem_r", None, ""], [-0.4, y, "slit_r", None, ""],
                             [0, y + slit, "slit_l", None, ""], [0.4, y, "hem_l", None, ""]]
            pattern.add(Panel(f"{prefix}_{part}", label, path, (0, 0, z)))
        else:
            pattern.add(Panel(f"{prefix}_{part}", label, whole(half), (0, 0, z)))
    for side in "lr":
        pattern.sew(f"{prefix}_front.side_{side}", f"{prefix}_back.side_{side}")
        if hips:
            pattern.sew(f"{prefix}_front.hip_{side}", f"{prefix}_back.hip_{side}")
        for part in ("front", "back"):
            if darts and not pleats:
                pattern.sew(f"{prefix}_{part}.dart_out_{side}", f"{prefix}_{part}.dart_in_{side}")
            for k in range(pleats):
                pattern.sew(f"{prefix}_{part}.pleat{k}_out_{side}", f"{prefix}_{part}.pleat{k}_in_{side}")
    if godets:
        depth = math.dist((0, 0), (0, length * 0.45))
        for side, sign in (("l", 1), ("r", -1)):
            path = [(-9, -depth, "hem", quadratic(0.5, -0.1)), (9, -depth, "out"), (0, 0, "in")]
            pattern.add(Panel(f"godet_{side}", "leg", path, (sign * hem / 8, top - length * 0.55, BEFORE + 4)))
            pattern.sew(f"godet_{side}.in", f"{prefix}_front.{'cut_in' if side == 'l' else 'cut_out'}_{side}")
            pattern.sew(f"godet_{side}.out", f"{prefix}_front.{'cut_out' if side == 'l' else 'cut_in'}_{side}")
    return pattern


def waist_edges(pattern, panel, pleats=0, darts=False):
    """Edges along the top of a skirt's panel by side, from the side seam to the centre."""
    names = [f"waist{k}" for k in range(pleats)] if pleats else ["waist0"] if darts else []
    return {side: [f"{panel}.{name}_{side}" for name in [*names, "waist"]] for side in "lr"}


def circle_skirt(pattern, length=50.0, turn=1.0, waist=None, prefix="skirt", top=None):
    """Each panel is half of `turn` circles."""
    waist = BODY["waist"] if waist is None else waist
    top = BODY["waist_y"] if top is None else top
    radius, angle = waist / (2 * math.pi * turn), math.pi * turn / 2
    far, large = radius + length, angle > math.pi

    def at(r, a):
        return r * math.sin(a), top + radius - r * math.cos(a)

    for part, z in (("front", BEFORE), ("back", BEHIND)):
        path = [(*at(far, 0), "hem_l", arc(far, large, True)), (*at(far, angle), "side_l"),
                (*at(radius, angle), "waist_l", arc(radius, large, False), "lower_interface"),
                (*at(radius, 0), "waist_r", arc(radius, large, False), "lower_interface"), (*at(radius, -angle), "side_r"),
                (*at(far, -angle), "hem_r", arc(far, large, True))]
        pattern.add(Panel(f"{prefix}_{part}", "leg", path, (0, 0, z)))
    return pattern.sew([f"{prefix}_front.side_l", f"{prefix}_front.side_r"],
                       [f"{prefix}_back.side_l", f"{prefix}_back.side_r"])


def hang(pattern, top="wb", skirt_name="skirt", pleats=0, darts=False):
    """Sews a skirt to a waistband; without pleats and darts half by half."""
    for part in ("front", "back"):
        for side in "lr":
            edges = waist_edges(pattern, f"{skirt_name}_{part}", pleats, darts)[side]
            if len(edges) == 1:
                pattern.sew(edges[0], f"{top}_{part}.low_{side}")
                continue
            # the band's edge is cut as the skirt's is
            panel = pattern.panels[f"{top}_{part}"]
            k = panel.edge(f"low_{side}")
            x0, y, _, _, label = panel.path[k]
            x1 = panel.path[k + 1][0]
            parts = edges if side == "r" else edges[::-1]
            whole_length = sum(pattern.length(e) for e in parts)
            corners, x = [], x0
            for n, e in enumerate(parts):
                corners.append([x, y, f"low_{side}{n}", None, label])
                x += (x1 - x0) * pattern.length(e) / whole_length
            panel.path[k:k + 1] = corners
            for n, e in enumerate(parts):
                pattern.sew(e, f"{top}_{part}.low_{side}{n}")
    return pattern


# ------------------------------------------------------------------------------------------- pants
def pants(pattern, length=90.0, hem=36.0, hips=112.0, waist=None, top=None, darts=0.0, ease=1.5):
    """Front and back of each leg. ease: of the crotch, which hangs that much lower."""
    waist = BODY["waist"] + 4 if waist is None else waist
    top = BODY["waist_y"] if top is None else top
    crotch = BODY["crotch_y"] - ease
    for part, z, fork in (("f", BEFORE, 6.5), ("b", BEHIND, 12.0)):
        width = hips / 4
        low = top - length
        x = -0.5  # the middle
        mid = (width - fork) / 2
        upper = [(waist / 4 + darts, top, "waist", None, "lower_interface")]
        if darts:
            c = waist / 8 + darts / 2
            upper = [(waist / 4 + darts, top, "waist0", None, "lower_interface"), (c + darts / 2, top, "dart_out"),
                     (c, top - 10, "dart_in"), (c - darts / 2, top, "waist", None, "lower_interface")]
        path = [(mid - hem / 4, low, "hem"), (mid + hem / 4, low, "outseam"),
                (width, BODY["hips_y"], "hip", quadratic(0.5, -0.06)), *upper, (0, top - 0.5, "crotch_top"),
                (x, BODY["hips_y"] + 3, "crotch", quadratic(0.75, -0.35)),
                (-fork, crotch, "inseam")]
        left = Panel(f"pant_{part}_l", "leg", path, (0.6, 0, z))
        pattern.add(left, left.mirror(f"pant_{part}_r"))
    for side in "lr":
        for edge in ("outseam", "hip", "inseam"):
            pattern.sew(f"pant_f_{side}.{edge}", f"pant_b_{side}.{edge}")
        if darts:
            for part in "fb":
                pattern.sew(f"pant_{part}_{side}.dart_out", f"pant_{part}_{side}.dart_in")
    for part in "fb":
        for edge in ("crotch_top", "crotch"):
            pattern.sew(f"pant_{part}_l.{edge}", f"pant_{part}_r.{edge}")
    return pattern


def hang_pants(pattern, top="wb"):
    for part, name in (("f", "front"), ("b", "back")):
        for side in "lr":
            pattern.sew(f"pant_{part}_{side}.waist", f"{top}_{name}.low_{side}")
    return pattern


def below_torso(pattern, skirt_name="skirt"):
    """Sews a skirt of two panels to the hem of a torso in halves."""
    for part, name in (("f", "front"), ("b", "back")):
        for side, full in (("l", "left"), ("r", "right")):
            pattern.sew(f"{full}_{part}torso.hem", f"{skirt_name}_{name}.waist_{side}")
    return pattern


# ---------------------------------------------------------------------------------------- garments
def pencil_skirt():
    return skirt(Pattern(), 58, hem=100, darts=3.0, hips=113, slit=18)


def a_line_skirt():
    return hang(skirt(band(Pattern()), 62, waist=BODY["waist"] + 1, hem=170))


def circle_skirt_full():
    return hang(circle_skirt(band(Pattern()), 50, 1.0))


def circle_skirt_half():
    return hang(circle_skirt(band(Pattern()), 60, 0.5))


def pleated_skirt():
    return hang(skirt(band(Pattern()), 48, hem=150, pleats=3, pleat=5.0), pleats=3)


def gathered_skirt():
    return hang(skirt(band(Pattern()), 55, waist=BODY["waist"] * 2, hem=BODY["waist"] * 2.1))


def two_tier_skirt():
    pattern = hang(skirt(band(Pattern()), 30, waist=BODY["waist"] + 2, hem=128))
    skirt(pattern, 30, waist=128 * 1.6, hem=128 * 1.8, top=BODY["waist_y"] - 34, prefix="tier", top_label="")
    for part in ("front", "back"):
        panel = pattern.panels[f"skirt_{part}"]
        k = panel.edge("hem")
        x, y, _, curve, label = panel.path[k]
        panel.path[k:k + 1] = [[x, y, "hem_r", curve, label], [0, y, "hem_l", curve, label]]
        for side in "lr":
            pattern.sew(f"skirt_{part}.hem_{side}", f"tier_{part}.waist_{side}")
    return pattern


def godet_skirt():
    return skirt(Pattern(), 60, hem=124, darts=3.0, hips=113, godets=2)


def tee(bust, length=88.0):
    return sleeves(torso(Pattern(), hem_y=length, bust=bust), 20, wrist=bust / 2.9)


def tee_small():
    return tee(101, 91)


def tee_medium():
    return tee(109)


def tee_large():
    return tee(124, 84)


def shirt():
    pattern = torso(Pattern(), hem_y=88, bust=112, hem=118, neck=7.5, depth=(8, 2), split=True)
    return stand_collar(sleeves(pattern, 47, wrist=28, cuff=6, cuff_length=23))


def turtleneck():
    return stand_collar(sleeves(torso(Pattern(), hem_y=96, bust=106, neck=7.5, depth=(7, 2)), 52, wrist=24), 9)


def lapel_shirt():
    pattern = torso(Pattern(), hem_y=92, bust=112, hem=114, depth=(19, 2.5), neck_curve=quadratic(0.5, -0.05), split=True)
    return lapels(sleeves(pattern, 50, wrist=27))


def dart_top():
    return torso(Pattern(), hem_y=103, bust=104, hem=BODY["waist"] + 4 + 16, waist_darts=4.0, depth=(12, 5))


def strapless_top():
    pattern = Pattern()
    under, low = BODY["underarm_y"] + 2, 100.0
    for part, z in (("f", BEFORE), ("b", BEHIND)):
        half = [(0, low, "hem"), (BODY["hips"] / 4 - 4, low, "side"), (BODY["bust"] / 4 - 0.5, under, "top", None, "strapless_top"),
                (0, under, "centre")]
        pattern.add(Panel(part + "torso", "body", whole(half), (0, 0, z)))
    return pattern.sew(["ftorso.side_l", "ftorso.side_r"], ["btorso.side_l", "btorso.side_r"])


def gored_skirt(gores=8):
    """Panels stand on a circle about the wearer."""
    pattern, length, low = Pattern(), 58.0, BODY["waist_y"] - 58
    waist, hips, hem = (BODY["waist"] + 2) / gores, 114 / gores, 190 / gores
    for k in range(gores):
        angle = 360 * (k + 0.5) / gores
        half = [(0, low, "hem"), (hem / 2, low, "side"), (hips / 2, BODY["hips_y"], "hip", quadratic(0.5, -0.05)),
                (waist / 2, low + length, "waist", None, "lower_interface"), (0, low + length, "centre")]
        at = (32 * math.sin(math.radians(angle)), 0, 32 * math.cos(math.radians(angle)))
        pattern.add(Panel(f"gore_{k}", "leg", whole(half), at, (0, angle, 0)))
    for k in range(gores):
        for edge in ("side", "hip"):
            pattern.sew(f"gore_{k}.{edge}_l", f"gore_{(k + 1) % gores}.{edge}_r")
    return pattern


def cuffed_trousers():
    """Wide below the knee, and gathered into bands at the ankles."""
    pattern = hang_pants(pants(band(Pattern(), length=BODY["waist"] + 2), 86, hem=50, hips=116, waist=BODY["waist"] + 12))
    for part, z in (("f", BEFORE - 8), ("b", BEHIND + 6)):
        panel = pattern.panels[f"pant_{part}_l"]
        x0, x1, y = panel.path[0][0], panel.path[1][0], panel.path[0][1]
        middle, half = (x0 + x1) / 2, 7.0
        path = [(middle - half, y - 7, "hem"), (middle + half, y - 7, "out"), (middle + half, y - 1, "top"),
                (middle - half, y - 1, "in")]
        cuff = Panel(f"cuff_{part}_l", "leg", path, (0.6, 0, z))
        pattern.add(cuff, cuff.mirror(f"cuff_{part}_r"))
    for side in "lr":
        for part in "fb":
            pattern.sew(f"pant_{part}_{side}.hem", f"cuff_{part}_{side}.top")
        for edge in ("in", "out"):
            pattern.sew(f"cuff_f_{side}.{edge}", f"cuff_b_{side}.{edge}")
    return pattern


def open_jacket():
    """Not closed in front."""
    pattern = torso(Pattern(), hem_y=84, bust=116, hem=120, neck=8.5, depth=(10, 2.5), split=True, open_front=True)
    return sleeves(pattern, 44, wrist=30)


def open_hoody():
    return hood(open_jacket())


def trousers():
    return hang_pants(pants(band(Pattern(), length=BODY["waist"] + 2), waist=BODY["waist"] + 4))


def wide_trousers():
    return hang_pants(pants(band(Pattern(), length=BODY["waist"] + 2), 94, hem=64, hips=120, waist=BODY["waist"] + 18))


def shorts():
    return pants(Pattern(), 48, hem=68, hips=118, darts=1.5)


def hoody():
    pattern = torso(Pattern(), hem_y=90, bust=116, neck=8.5, depth=(9, 2.5), split=True)
    return hood(sleeves(pattern, 48, wrist=28, cuff=6, cuff_length=23))


def jumpsuit():
    pattern = torso(Pattern(), hem_y=BODY["waist_y"], bust=108, hem=BODY["waist"] + 8, split=True)
    hang_pants(pants(band(pattern, length=BODY["waist"] + 4, edge_label=""), hem=40, hips=116, waist=BODY["waist"] + 8, ease=8))
    for part, name in (("f", "front"), ("b", "back")):
        for side, full in (("l", "left"), ("r", "right")):
            pattern.sew(f"{full}_{part}torso.hem", f"wb_{name}.top_{side}")
    return sleeves(pattern, 20, wrist=36)


def gathered_dress():
    pattern = torso(Pattern(), hem_y=BODY["waist_y"], bust=104, hem=BODY["waist"] + 6, split=True)
    skirt(pattern, 55, waist=(BODY["waist"] + 6) * 1.8, hem=(BODY["waist"] + 6) * 2, top=BODY["waist_y"] - 3, top_label="")
    return below_torso(pattern)


def circle_dress():
    pattern = torso(Pattern(), hem_y=BODY["waist_y"], bust=104, hem=BODY["waist"] + 5, split=True)
    circle_skirt(pattern, 48, 0.8, waist=BODY["waist"] + 5, top=BODY["waist_y"] - 3)
    return below_torso(sleeves(pattern, 24, wrist=34))


def asymmetric_dress():
    """One sleeve, and a hem that falls to one side."""
    pattern = torso(Pattern(), hem_y=70, bust=106, hem=128)
    for part in "fb":
        panel = pattern.panels[part + "torso"]
        for corner in panel.path:
            if corner[2] == "hem":
                corner[1] -= 22
                corner[3] = quadratic(0.4, -0.05)
    return sleeves(pattern, 46, wrist=27, sides="l")


def vest():
    """Worn over a shirt."""
    return torso(Pattern(), hem_y=94, bust=128, hem=130, neck=9.5, depth=(16, 4), shoulder=18, underarm_y=118, split=True,
                 out=8.0)


PATTERNS = {"pencil_skirt": pencil_skirt, "a_line_skirt": a_line_skirt, "circle_skirt": circle_skirt_full,
            "half_circle_skirt": circle_skirt_half, "pleated_skirt": pleated_skirt, "gathered_skirt": gathered_skirt,
            "two_tier_skirt": two_tier_skirt, "godet_skirt": godet_skirt, "tee_small": tee_small, "tee_medium": tee_medium,
            "tee_large": tee_large, "shirt": shirt, "turtleneck": turtleneck, "lapel_shirt": lapel_shirt,
            "dart_top": dart_top, "strapless_top": strapless_top, "trousers": trousers, "wide_trousers": wide_trousers,
            "shorts": shorts, "hoody": hoody, "jumpsuit": jumpsuit, "gathered_dress": gathered_dress,
            "circle_dress": circle_dress, "gored_skirt": gored_skirt, "cuffed_trousers": cuffed_trousers,
            "open_jacket": open_jacket, "open_hoody": open_hoody, "asymmetric_dress": asymmetric_dress, "vest": vest}
OVER = {"vest": "shirt"}


def main():
    words = sys.argv[1:]
    if words == ["--list"]:
        print("\n".join(PATTERNS))
        return 0
    if not words or words[0].startswith("-") or any(name not in PATTERNS for name in words[1:]):
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(words[0])
    folder.mkdir(parents=True, exist_ok=True)
    for name in words[1:] or PATTERNS:
        (folder / f"{name}_specification.json").write_text(json.dumps(PATTERNS[name]().json(), indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
