"""Random scenes as users write them, from a seed and a number."""

import math
import random

GRAVITY = 9.81
STEPS_MAX = 600  # per scene
FABRICS = {  # [N/m] the smaller of warp and weft
    "blanket": 278, "cotton": 2820, "cotton_polyester": 4130, "denim": 436, "interlock": 56, "jersey": 56,
    "leather": 16000, "light_jacket": 106, "paper": 300000, "polyester": 4110, "ponte_roma": 107, "rib_knit": 95,
    "silk": 1410, "sweatshirt": 26, "swimwear": 82, "wool": 1000}


def rounded(x):
    """with numbers of six digits"""
    if isinstance(x, float):
        return float(f"{x:.6g}")
    if isinstance(x, list):
        return [rounded(value) for value in x]
    if isinstance(x, dict):
        return {key: rounded(value) for key, value in x.items()}
    return x


class SceneGenerator:
    """scene: what the scene file holds; files: the text of others, by name; and what a verdict has to know:

    situation: name of the function that made the scene
    hard: the scene may ask for the impossible, so it may end with exit code 4
    floor: [m] height of a floor beneath everything, or None
    speed: [m/s] that bodies, pins, wind, pressure and the start give to cloth
    settles: nothing but gravity moves the cloth, onto things that stand
    close: some things start closer than the thickness, so contacts hold energy then
    free: the cloth touches nothing and nothing but gravity acts
    """

    def __init__(self, seed, index):
        self.random = random.Random(f"{seed}:{index}")
        self.files = {}
        self.hard = self.close = self.settles = self.free = False
        self.floor = None
        self.speed = 0.0
        self.size = self.log(0.05, 20) if self.chance(0.5) else self.log(0.3, 2)
        self.triangles = int(self.log(200, 2000))
        self.rate = self.pick([24, 25, 25, 30, 50, 60])
        self.duration = self.uniform(0.3, 1.0)
        self.pace = math.sqrt(GRAVITY * self.size)  # [m/s] of a fall through half of the size
        self.step = self.pick([0.0005, 0.001, 0.002, 0.004, 0.005, 0.005, 0.005, 0.01, 0.01, 1 / 60, 0.02, 1 / 30,
                               0.04, "auto"])
        if self.step != "auto":
            self.duration = min(self.duration, STEPS_MAX * self.step)
        self.frames = max(2, round(self.duration * self.rate))
        self.duration = self.frames / self.rate
        self.scene = {"time": {"step": self.step, "frame_rate": self.rate, "frames": self.frames}, "materials": {},
                      "cloths": [], "obstacles": [], "pins": [], "handles": [], "seams": []}
        self.layers = 1
        situations = [self.drop] * 6 + [self.hang] * 4 + [self.carry] * 3 + [self.sewn] * 3 + [self.tube] * 3 + [
            self.throw] * 2 + [self.ribbon] * 2 + [self.hammock] * 2 + [self.handled] * 2 + [
            self.rings, self.bowl, self.roller]
        situation = self.pick(situations)
        self.situation = situation.__name__
        self.cell = self.size / math.sqrt(self.triangles / 2)
        self.thickness = min(0.001, self.cell / 4)
        if self.chance(0.5):
            self.thickness = min(self.cell * self.uniform(0.03, 0.3), 0.03 * self.size)
            self.scene["contact"] = {"thickness": self.thickness}
        situation()
        self.settings()
        for key in [key for key, value in self.scene.items() if value in ([], {})]:
            del self.scene[key]
        self.scene = rounded(self.scene)
        if self.chance(0.06):
            self.shift([self.sign() * round(self.log(10, 1e4) * self.size) for _ in range(3)])

    # ------------------------------------------------------------------ chance

    def chance(self, share):
        return self.random.random() < share

    def uniform(self, low, high):
        return self.random.uniform(low, high)

    def log(self, low, high):
        return math.exp(self.random.uniform(math.log(low), math.log(high)))

    def pick(self, choices):
        return choices[int(self.random.random() * len(choices))]

    def sign(self):
        return self.pick([-1, 1])

    # ------------------------------------------------------------------- parts

    def gap(self):
        """[m] between things that start apart"""
        gap = self.thickness * self.pick([0.5, 1.0, 1.5, 3, 3]) + self.pick([0, 0.2, 0.5, 2]) * self.cell
        self.close = self.close or gap < self.thickness
        return gap

    def material(self):
        """adds what a cloth is made of to the scene, and returns the keys of the cloth"""
        if self.chance(0.2):
            return {}
        stiff = 10 * 0.2 * GRAVITY * self.size  # [N/m] from which cloth of 0.2 kg/m2 bears its own weight
        if self.chance(0.5):
            name = self.pick([name for name, stiffness in FABRICS.items() if stiffness > stiff] or ["paper"])
            if self.chance(0.5):
                return {"fabric": name}
            material = {"fabric": name}
        else:
            density = self.log(0.02, 2)
            material = {"density": density, "bending_stiffness": self.pick([0, self.log(1e-7, 1e-3)])}
            stiffness = self.log(max(20, stiff * density / 0.2), max(1e5, 10 * stiff * density / 0.2))
            if self.chance(0.6):
                material |= {"stretch_stiffness": stiffness, "poisson_ratio": self.uniform(0, 0.45)}
            else:
                material["orthotropic"] = {"stretch_stiffness": [stiffness, stiffness * self.log(1, 10)],
                                           "shear_stiffness": stiffness * self.log(0.03, 0.5)}
            if self.chance(0.2):
                del material["bending_stiffness"]
                bending = self.log(1e-7, 1e-4)
                material["orthotropic_bending"] = {"stiffness": [bending, bending * self.log(0.3, 3)]}
        if self.chance(0.15):
            material["strain_limits"] = [self.pick([0, self.uniform(0.6, 0.95)]), self.uniform(1.03, 1.3)]
        if self.chance(0.2):
            material["damping"] = {"mass": self.pick([0, self.uniform(0, 2)]), "stiffness": self.log(1e-5, 1e-2)}
        name = f"material_{len(self.scene['materials'])}"
        self.scene["materials"][name] = material
        return {"material": name}

    def cloth(self, name, keys):
        cloth = {"name": name} | self.material() | keys
        self.scene["cloths"].append(cloth)
        return cloth

    def cells(self, width, height):
        """[across, along] cells of a rectangle with its share of the triangles"""
        edge = math.sqrt(2 * width * height / (self.triangles / self.layers))
        return [max(1, round(width / edge)), max(1, round(height / edge))]

    def grid(self, width, height):
        keys = {"size": [width, height], "cells": self.cells(width, height)}
        if self.chance(0.2):
            keys["diagonals"] = "same"
        return {"grid": keys}

    def mesh(self, width, height):
        """a flat sheet from an OBJ file, with vertices that are not in rows, and perhaps a hole or a missing corner"""
        n, m = (max(4, cells) for cells in self.cells(width, height))
        missing = self.pick(["nothing", "hole", "corner"])
        units, scale = self.pick([("m", 1.0), ("m", 1.0), ("cm", 100.0), ("mm", 1000.0)])
        y_up = self.chance(0.3)
        has_uv = self.chance(0.5)

        def stays(i, j):
            if missing == "hole":
                return not (n / 3 < i + 0.5 < 2 * n / 3 and m / 3 < j + 0.5 < 2 * m / 3)
            return missing != "corner" or i + 0.5 < n / 2 or j + 0.5 < m / 2
        triangles = []
        for j in range(m):
            for i in range(n):
                if stays(i, j):
                    a, b, c, d = j * (n + 1) + i, j * (n + 1) + i + 1, (j + 1) * (n + 1) + i + 1, (j + 1) * (n + 1) + i
                    triangles += [[a, b, c], [a, c, d]] if self.chance(0.5) else [[a, b, d], [b, c, d]]
        used = {vertex: k for k, vertex in enumerate(sorted({v for t in triangles for v in t}))}
        lines, uv = [], []
        for vertex in used:
            i, j = vertex % (n + 1), vertex // (n + 1)
            inside = 0 < i < n and 0 < j < m
            x = [width * ((i + inside * self.uniform(-0.25, 0.25)) / n - 0.5),
                 height * ((j + inside * self.uniform(-0.25, 0.25)) / m - 0.5)]
            place = [x[0], 0.0, -x[1]] if y_up else [x[0], x[1], 0.0]
            lines.append("v " + " ".join(f"{scale * c:.7g}" for c in place))
            uv.append(f"vt {scale * x[0]:.7g} {scale * x[1]:.7g}")
        if has_uv:
            lines += uv
        for triangle in triangles:
            corners = [used[v] + 1 for v in triangle]
            lines.append("f " + " ".join(f"{v}/{v}" if has_uv else str(v) for v in corners))
        name = f"cloth_{len(self.files)}.obj"
        self.files[name] = "\n".join(lines) + "\n"
        return {"mesh": name, "units": units, "up": "y" if y_up else "z"} | ({"uv": "fit"} if self.chance(0.2) else {})

    def sheet(self, size):
        """a cloth in the xy plane about the origin, within `size` of it"""
        width, height = size, size * self.uniform(0.4, 1)
        kind = self.pick(["grid"] * 4 + ["disc", "panel", "mesh", "mesh"])
        if kind == "grid":
            return self.grid(width, height)
        if kind == "mesh":
            return self.mesh(width, height)
        if kind == "disc":
            rings = max(2, round(math.sqrt(self.triangles / self.layers / 6)))
            disc = {"radius": size / 2, "cells": rings}
            if self.chance(0.3):
                disc["inner_radius"] = size / 2 * self.uniform(0.1, 0.6)
            return {"disc": disc}
        heights = sorted(self.uniform(0.1, 0.9) for _ in range(self.pick([0, 1, 2])))
        outline = [[h * height / 2, width / 2 * self.uniform(0.5, 1)] for h in [0] + heights + [1]]
        rows = self.cells(width, height / 2)
        return {"panel": {"outline": outline, "cells": [rows[0], max(rows[1], len(outline) + 1)]}}

    def obstacle(self, keys, place, turn=None):
        obstacle = {"name": f"body_{len(self.scene['obstacles'])}"} | keys | {"transform": {"translate": place}}
        if turn:
            obstacle["transform"]["rotate"] = turn
        if self.chance(0.5):
            obstacle["friction"] = self.pick([0, self.uniform(0, 1), self.uniform(0, 1)])
        self.scene["obstacles"].append(obstacle)
        return obstacle

    def body(self, size):
        """a closed body about the origin, and how far it reaches from there: keys, reach"""
        r = size / 2
        kind = self.pick(["sphere", "sphere", "box", "box", "capsule", "revolution", "torus", "rock"])
        if kind == "sphere":
            return {"sphere": {"radius": r}}, r
        if kind == "box":
            half = [r * self.uniform(0.2, 1) for _ in range(3)]
            return {"box": {"size": [2 * h for h in half]}}, math.hypot(*half)
        if kind == "capsule":
            radius = r * self.uniform(0.05, 0.6)
            return {"capsule": {"radius": radius, "length": 2 * (r - radius)}}, r
        if kind == "revolution":  # a vase, or a ring with sharp edges
            if self.chance(0.5):
                profile = [[0, -r], [r * self.uniform(0.3, 0.7), -r * 0.6], [r * self.uniform(0.1, 0.7), 0.1 * r],
                           [r * self.uniform(0.1, 0.5), 0.7 * r], [0, r]]
                return {"revolution": {"profile": profile}}, r
            inner, height = r * self.uniform(0.3, 0.8), r * self.uniform(0.1, 0.4)
            profile = [[r, -height], [r, height], [inner, height], [inner, -height]]
            return {"revolution": {"profile": profile, "closed": True}}, math.hypot(r, height)
        name = f"body_{len(self.files)}.obj"
        self.files[name] = self.torus(r) if kind == "torus" else self.rock(r)
        return {"mesh": name}, r

    def torus(self, r):
        tube = r * self.uniform(0.1, 0.3)
        around, across = 24, 10
        lines = []
        for i in range(around):
            for j in range(across):
                a, b = 2 * math.pi * i / around, 2 * math.pi * j / across
                radius = r - tube + tube * math.cos(b)
                lines.append(f"v {radius * math.cos(a):.6g} {radius * math.sin(a):.6g} {tube * math.sin(b):.6g}")
        for i in range(around):
            for j in range(across):
                a, b = i * across, (i + 1) % around * across
                k = (j + 1) % across
                lines += [f"f {a + j + 1} {b + j + 1} {b + k + 1}", f"f {a + j + 1} {b + k + 1} {a + k + 1}"]
        return "\n".join(lines) + "\n"

    def rock(self, r):
        """a polyhedron with facets of all sizes, star-shaped about the origin"""
        around, rings = 9, 5
        lines = [f"v 0 0 {-r * self.uniform(0.6, 1):.6g}"]
        for i in range(1, rings):
            for j in range(around):
                a, b = math.pi * (i / rings - 0.5), 2 * math.pi * (j + self.uniform(-0.2, 0.2)) / around
                radius = r * self.uniform(0.7, 1)
                lines.append(f"v {radius * math.cos(a) * math.cos(b):.6g} {radius * math.cos(a) * math.sin(b):.6g} "
                             f"{radius * math.sin(a):.6g}")
        top = 2 + (rings - 1) * around
        lines.append(f"v 0 0 {r * self.uniform(0.6, 1):.6g}")
        for j in range(around):
            k = (j + 1) % around
            lines.append(f"f 1 {2 + k} {2 + j}")
            for i in range(rings - 2):
                a, b = 2 + i * around, 2 + (i + 1) * around
                lines += [f"f {a + j} {a + k} {b + k}", f"f {a + j} {b + k} {b + j}"]
            last = 2 + (rings - 2) * around
            lines.append(f"f {last + j} {last + k} {top}")
        return "\n".join(lines) + "\n"

    def turn(self):
        return [self.uniform(-180, 180), self.uniform(-1, 1), self.uniform(-1, 1), self.uniform(0.1, 1)]

    def move(self, obstacle, travel, turns=0.0, axis=(0, 0, 1), back=False):
        """lets a body travel by a vector and turn, over part of the run"""
        start = obstacle.pop("transform")
        begin = self.duration * self.pick([0, 0, self.uniform(0, 0.3)])
        end = self.duration * self.uniform(0.6, 1)
        place = start["translate"]
        there = [a + b for a, b in zip(place, travel)]
        keys = [{"time": begin, "translate": place}, {"time": end, "translate": there}]
        if turns:
            keys[0]["rotate"], keys[1]["rotate"] = [0, *axis], [360 * turns, *axis]
        elif "rotate" in start:
            for key in keys:
                key["rotate"] = start["rotate"]
        if back and not turns:
            keys.insert(1, dict(keys[1], time=(begin + end) / 2))
            keys[2]["translate"] = place
        if self.chance(0.4):
            keys[0]["interpolation"] = "linear"
        obstacle["motion"] = keys
        reach = self.size
        self.speed += 3 * (math.hypot(*travel) * (2 if back else 1) + 2 * math.pi * abs(turns) * reach) / (end - begin)

    def travel_for(self, limit):
        """[m] that something moves by at an ordinary speed"""
        return min(limit, self.pace * self.uniform(0.05, 0.8) * self.duration * 0.7)

    def pin(self, cloth, selection, motion=None, release=False):
        pin = {"cloth": cloth} | selection
        if motion:
            pin["motion"] = motion
        if release:
            pin["release_time"] = self.duration * self.uniform(0.2, 0.8)
        self.scene["pins"].append(pin)

    def pin_keys(self, places, turns=None):
        """keys of a motion through displacements [m]; also counts their speed"""
        times = [self.duration * (0.9 * i / (len(places) - 1)) for i in range(len(places))]
        keys = [{"time": t, "translate": list(p)} for t, p in zip(times, places)]
        if turns:
            for i, key in enumerate(keys):
                key["rotate"] = [360 * turns * i / (len(keys) - 1), 0, 0, 1]
        if self.chance(0.5):
            for key in keys[:-1]:
                key["interpolation"] = "linear"
        fastest = max(math.dist(a, b) for a, b in zip(places, places[1:])) / (times[1] - times[0])
        self.speed += 3 * fastest + (2 * math.pi * abs(turns) * self.size / self.duration if turns else 0)
        return keys

    # -------------------------------------------------------------- situations

    def add_floor(self, z, moving=False):
        size = self.size * self.uniform(6, 12)
        if self.chance(0.8):
            floor = self.obstacle({"plane": {"size": [size, size]}}, [0, 0, z])
        else:
            height = self.size * self.uniform(0.1, 0.5)
            floor = self.obstacle({"box": {"size": [size, size, height]}}, [0, 0, z - height / 2])
        if self.chance(0.3):
            cells = self.pick([1, 2, 10])
            kind = "plane" if "plane" in floor else "box"
            floor[kind]["cells"] = [cells, cells] if kind == "plane" else [cells, cells, 1]
        if moving:
            if self.chance(0.5):
                self.move(floor, [self.sign() * self.travel_for(2 * self.size), 0, 0])
            else:
                self.move(floor, [0, 0, 0], self.sign() * self.uniform(0.1, 1) * self.duration)
        self.floor = z

    def drop(self):
        """sheets above things that they fall on"""
        self.layers = self.pick([1, 1, 1, 2, 2, 3, 4, 5])
        top, moving = 0.0, False
        has_floor = self.chance(0.7)
        bodies = self.pick([0, 1, 1, 2, 3]) if has_floor else self.pick([1, 1, 2, 3])
        if has_floor:
            moving = self.chance(0.2)
            self.add_floor(0.0, moving)
        for _ in range(bodies):
            keys, reach = self.body(self.size * self.log(0.1, 0.7))
            high = reach + self.pick([0, self.uniform(0.1, 0.5) * self.size])
            place = [self.size * self.uniform(-0.3, 0.3), self.size * self.uniform(-0.3, 0.3), high]
            obstacle = self.obstacle(keys, place, self.turn() if self.chance(0.5) else None)
            top = max(top, high + reach)
            if self.chance(0.25):
                moving = True
                if self.chance(0.5):
                    self.move(obstacle, [0, 0, 0], self.sign() * self.uniform(0.1, 1.5) * self.duration)
                else:
                    a = self.uniform(0, 2 * math.pi)
                    way = self.travel_for(self.size)
                    self.move(obstacle, [way * math.cos(a), way * math.sin(a), 0], back=self.chance(0.3))
                    self.hard = self.hard or has_floor  # cloth between it and the floor
        height = top + self.gap() + self.thickness * 0.2
        rotate = [self.uniform(0, 360), 0, 0, 1]
        tilt = 0.0
        if self.chance(0.3):
            tilt = self.uniform(0, 90)
            rotate = [tilt, self.uniform(-1, 1), self.uniform(-1, 1), 0]
        height += self.size * math.sin(math.radians(tilt))
        between = (self.gap() + 0.1 * self.thickness) / max(0.05, math.cos(math.radians(tilt)))
        velocity = [0, 0, -self.pace * self.uniform(0, 1)] if self.chance(0.2) else None
        if self.layers > 1 and tilt < 85 and self.chance(0.5):
            cloth = self.cloth("cloth", self.sheet(self.size) | {
                "transform": {"rotate": rotate, "translate": [0, 0, height]},
                "copies": {"count": self.layers, "translate": [0, 0, between]}})
            if velocity:
                cloth["velocity"] = velocity
        else:
            if tilt >= 85:
                self.layers = 1
            for k in range(self.layers):
                keys = self.sheet(self.size * self.pick([1, 1, self.uniform(0.3, 1)]))
                turned = [self.uniform(0, 360), 0, 0, 1] if tilt == 0 and self.chance(0.5) else rotate
                cloth = self.cloth(f"cloth_{k}", keys | {
                    "transform": {"rotate": turned, "translate": [0, 0, height + k * between]}})
                if velocity:
                    cloth["velocity"] = velocity
        if velocity:
            self.speed += abs(velocity[2])
        fall = math.sqrt(2 * (height + self.layers * between) / GRAVITY)
        self.settles = not moving and has_floor and bodies == 0 and self.duration > 3 * fall + 0.2

    def hang(self):
        """sheets that hang from pins, perhaps in the wind, or with bodies that pass"""
        self.layers = self.pick([1, 1, 1, 2, 3])
        between = self.gap() + 0.1 * self.thickness
        width, height = self.size, self.size * self.uniform(0.4, 1)
        grid = self.grid(width, height)
        top = {"rotate": [90, 1, 0, 0], "translate": [0, 0, 0]}
        if self.layers > 1 and self.chance(0.5):
            self.cloth("cloth", grid | {"transform": top,
                                        "copies": {"count": self.layers, "translate": [0, between, 0]}})
            names = ["cloth"]
        else:
            names = [f"cloth_{k}" for k in range(self.layers)]
            for k, name in enumerate(names):
                self.cloth(name, grid | {"transform": dict(top, translate=[0, k * between, 0])})
        n, m = grid["grid"]["cells"]
        row = m * (n + 1)
        selection = self.pick([{"edge": "top"}, {"edge": "top"}, {"edge": "left"}, {"corners": ["min_max", "max_max"]},
                               {"corners": ["min_max"]}, {"vertices": sorted({row, row + n // 2, row + n})}])
        motion = None
        kind = self.pick(["still", "still", "shake", "lift", "twirl"])
        way = self.travel_for(0.5 * self.size)
        if kind == "shake":
            axis = self.pick([0, 1, 2])
            there = [way if k == axis else 0 for k in range(3)]
            motion = self.pin_keys([[0, 0, 0], there, [0, 0, 0], [-c for c in there]])
        elif kind == "lift":
            motion = self.pin_keys([[0, 0, 0], [way * self.uniform(-1, 1), way * self.uniform(-1, 1), way]])
        elif kind == "twirl":
            motion = self.pin_keys([[0, 0, 0], [0, 0, 0]], self.sign() * self.uniform(0.1, 0.8) * self.duration)
        for name in names:
            self.pin(name, selection, motion, self.chance(0.15))
        if kind in ("still", "lift") and self.chance(0.6):
            keys, reach = self.body(self.size * self.uniform(0.1, 0.5))
            side = self.sign()
            beyond = reach + self.gap() + 0.2 * self.thickness
            y = (self.layers - 1) * between + beyond if side > 0 else -beyond
            obstacle = self.obstacle(keys, [self.uniform(-0.4, 0.4) * width, y, self.uniform(-0.5, 0.2) * height])
            if self.chance(0.8):
                self.move(obstacle, [0, -side * self.travel_for(self.size), 0], back=self.chance(0.3))
                if selection.get("edge") == "left":
                    self.hard = True
        self.blow(0.5)
        if self.chance(0.3):
            self.add_floor(-height / 2 - self.pick([self.gap() + 0.2 * self.thickness, self.uniform(0.05, 0.5) * height]))

    def blow(self, share):
        if self.chance(share):
            speed = self.uniform(1, 15)
            a = self.uniform(0, 2 * math.pi)
            self.scene["wind"] = {"density": self.uniform(0.5, 1.5),
                                  "velocity": [speed * math.cos(a), speed * math.sin(a), self.uniform(-2, 2)]}
            if self.chance(0.3):
                self.scene["wind"]["drag"] = self.uniform(0, 0.5)
            self.speed += speed + 2

    def carry(self):
        """a sheet on a floor or a body, drawn along by pins"""
        self.layers = self.pick([1, 1, 1, 2])
        self.add_floor(0.0)
        high = 0.0
        if self.chance(0.4):
            keys, reach = self.body(self.size * self.uniform(0.1, 0.4))
            self.obstacle(keys, [self.uniform(-0.3, 0.3) * self.size, self.uniform(-0.3, 0.3) * self.size, reach])
            high = 2 * reach
        start = high + self.gap() + 0.2 * self.thickness
        between = self.gap() + 0.1 * self.thickness
        for k in range(self.layers):
            self.cloth(f"cloth_{k}", self.grid(self.size, self.size * self.uniform(0.4, 1)) | {
                "transform": {"translate": [0, 0, start + k * between]}})
        way = self.travel_for(0.7 * self.size)
        side = self.pick([{"edge": "left"}, {"corners": ["min_min"]}, {"corners": ["min_min", "min_max"]},
                          {"edge": {"name": "left", "from": 0.2 * self.size}}])
        route = self.pick([
            [[0, 0, 0], [0, 0, way]],
            [[0, 0, 0], [-way, 0, 0]],
            [[0, 0, 0], [way * 0.5, 0, way * 0.7], [way, 0, way * 0.6]],
            [[0, 0, 0], [0, 0, way * 0.5], [way * 0.6, 0, way * 0.5], [way * 0.8, 0, 0.15 * way]]])
        self.pin(f"cloth_{self.layers - 1}", side, self.pin_keys(route), self.chance(0.3))

    def sewn(self):
        """panels that seams join: a tube around a body, or a cushion"""
        self.layers = 2
        width, height = self.size, self.size * self.uniform(0.4, 1)
        same = self.chance(0.6)
        first, second = self.grid(width, height), self.grid(width, height)
        if not same:
            for keys in (first, second):
                keys["grid"]["cells"] = [max(2, round(c * self.uniform(0.8, 1.2))) for c in keys["grid"]["cells"]]
        material = self.material()
        seam = {}
        if self.chance(0.4):
            seam["ramp_time"] = self.uniform(0.1, 0.5)
        if self.duration < 2.5 * seam.get("ramp_time", 0.5):
            self.frames = math.ceil(2.5 * seam.get("ramp_time", 0.5) * self.rate)
            self.duration = self.frames / self.rate
            self.scene["time"]["frames"] = self.frames
            if self.step != "auto":
                self.scene["time"]["step"] = self.step = max(self.step, 0.002)
        if self.chance(0.6):
            radius = width * self.uniform(0.15, 0.27)
            body, reach = self.pick([({"sphere": {"radius": radius}}, radius),
                                     ({"capsule": {"radius": radius, "length": height}}, radius)])
            obstacle = self.obstacle(body, [0, 0, 0])
            apart = reach + self.gap() + 0.2 * self.thickness
            panels = [("front", first, {"rotate": [90, 1, 0, 0], "translate": [0, -apart, 0]}),
                      ("back", second, {"rotate": [180, 0, 1, 1], "translate": [0, apart, 0]})]
            pairs = [("left", "right"), ("right", "left")]
            if self.chance(0.2):
                self.move(obstacle, [0, 0, self.travel_for(0.3 * height)])
            self.blow(0.15)
        else:
            between = self.gap() + 0.2 * self.thickness
            panels = [("front", first, {"translate": [0, 0, between]}),
                      ("back", second, {"rotate": [180, 0, 1, 0], "translate": [0, 0, 0]})]
            pairs = [("left", "right"), ("right", "left"), ("bottom", "bottom"), ("top", "top")]
            if self.chance(0.7):
                self.add_floor(-self.gap() - 0.2 * self.thickness)
        for name, keys, transform in panels:
            cloth = {"name": name} | material | keys | {"transform": transform}
            if len(pairs) == 4 and self.chance(0.7):
                cloth["pressure"] = self.uniform(1, 10) * 0.2 * GRAVITY
                self.speed += cloth["pressure"] / 0.02 * self.duration
            self.scene["cloths"].append(cloth)
        self.speed += 20 * self.size
        for one, other in pairs:
            self.scene["seams"].append({"between": [{"cloth": "front", "edge": one}, {"cloth": "back", "edge": other}]}
                                       | seam)
        if self.chance(0.15) and self.triangles < 600:
            self.scene["refine"] = {"when": "sewn", "levels": 1}

    def tube(self):
        """a tube around a body, held at its upper rim or loose, above a floor or not"""
        radius = self.size * self.uniform(0.15, 0.35)
        height = self.size * self.uniform(0.4, 1)
        around = 2 * math.pi * radius
        cells = self.cells(around, height)
        self.cloth("tube", {"cylinder": {"radius": radius, "height": height, "cells": [max(6, cells[0]), cells[1]]}})
        inside = radius * math.cos(math.pi / max(6, cells[0])) - self.gap() - 0.2 * self.thickness
        body = None
        if inside > 0.2 * radius and self.chance(0.75):
            thick = inside * self.uniform(0.3, 1)
            body = self.obstacle({"capsule": {"radius": thick, "length": height * self.uniform(0.5, 3)}}, [0, 0, 0])
        held = body is None or self.chance(0.7)
        if held:
            if body and self.chance(0.6):
                self.scene["pins"].append({"cloth": "tube", "edge": "top", "obstacle": body["name"]})
            else:
                self.pin("tube", {"edge": "top"}, None, self.chance(0.2))
                held = False
        if body and (held or "rotate" not in body) and self.chance(0.7):
            if held:
                if self.chance(0.5):
                    self.move(body, [0, 0, 0], self.sign() * self.uniform(0.1, 1.5) * self.duration)
                else:
                    way = self.travel_for(self.size)
                    self.move(body, [way, 0, self.uniform(-0.5, 0.5) * way], back=self.chance(0.4))
            else:
                self.move(body, [0, 0, 0], self.sign() * self.uniform(0.1, 1) * self.duration)
        elif not body and self.chance(0.5):
            self.add_floor(-height / 2 - self.gap() - 0.2 * self.thickness)
        self.blow(0.25)

    def throw(self):
        """cloth in free flight, perhaps two that meet"""
        self.layers = self.pick([1, 1, 2])
        speed = self.pace * self.uniform(0, 2)
        for k in range(self.layers):
            cloth = self.cloth(f"cloth_{k}", self.sheet(self.size) | {
                "transform": {"rotate": self.turn(), "translate": [2.5 * k * self.size, 0, 0]}})
            cloth["velocity"] = [(1 - 2 * k) * speed if self.layers == 2 else speed, 0, self.uniform(-0.3, 0.3) * speed]
            if self.chance(0.3) and self.layers == 1:
                cloth["angular_velocity"] = [self.uniform(-6, 6) for _ in range(3)]
                self.speed += 11 * self.size
        self.free = self.layers == 1 and "angular_velocity" not in self.scene["cloths"][0]
        self.speed += speed
        if not self.free:
            self.blow(0.2)

    def ribbon(self):
        """a strip along a curve, held at its ends, or loose above a floor"""
        width, points = self.size * self.uniform(0.03, 0.15), []
        count = self.pick([3, 5, 8])
        if self.chance(0.5):
            for i in range(count):
                points.append([self.size * (i / (count - 1) - 0.5), 0.1 * self.size * self.uniform(-1, 1), 0.0])
            across = [0, 0, 1]
        else:  # a helix
            radius = self.size * 0.15
            for i in range(4 * count):
                a = math.pi * i / 3
                points.append([radius * math.cos(a), radius * math.sin(a), (width + 0.05 * self.size) * i / 5])
            across = [0, 0, 1]
        length = 1.1 * sum(math.dist(a, b) for a, b in zip(points, points[1:]))
        cells = [min(600, max(4 * len(points), self.cells(length, width)[0])), max(1, self.cells(length, width)[1])]
        self.cell = min(self.cell, length / cells[0], width / cells[1])
        if "contact" in self.scene:
            self.scene["contact"]["thickness"] = self.thickness = min(self.thickness, 0.3 * self.cell)
        self.cloth("ribbon", {"ribbon": {"width": width, "path": points, "across": across, "cells": cells}})
        held = self.pick([[], ["left"], ["left", "right"]])
        for edge in held:
            way = self.travel_for(0.3 * self.size)
            motion = None
            if self.chance(0.5):
                motion = self.pin_keys([[0, 0, 0], [-way / 3 if edge == "right" else way / 3, 0, way]])
            self.pin("ribbon", {"edge": edge}, motion, self.chance(0.2))
        if self.chance(0.7):
            self.add_floor(-width / 2 - self.gap() - 0.5 * width)
        self.blow(0.2)

    def hammock(self):
        """a sheet held at its corners or edges, with a body that comes from above or below"""
        self.layers = self.pick([1, 1, 2])
        between = self.gap() + 0.1 * self.thickness
        held = self.pick([[{"corners": ["min_min", "max_min", "min_max", "max_max"]}],
                          [{"edge": "left"}, {"edge": "right"}]])
        for k in range(self.layers):
            self.cloth(f"cloth_{k}", self.grid(self.size, self.size * self.uniform(0.5, 1)) | {
                "transform": {"translate": [0, 0, k * between]}})
            if k == 0 or self.chance(0.5):
                for selection in held:
                    self.pin(f"cloth_{k}", selection)
        side = self.sign()
        keys, reach = self.body(self.size * self.uniform(0.15, 0.5))
        beyond = reach + self.gap() + 0.2 * self.thickness
        z = (self.layers - 1) * between + beyond if side > 0 else -beyond
        obstacle = self.obstacle(keys, [0.1 * self.size * self.uniform(-1, 1), 0, z], self.turn())
        if side > 0 or self.chance(0.6):
            self.move(obstacle, [0, 0, -side * self.travel_for(0.2 * self.size)], back=self.chance(0.5))
            stiffest = max([material.get("stretch_stiffness", 0) for material in self.scene["materials"].values()] or [0])
            self.hard = self.hard or stiffest > 1e5

    def handled(self):
        """springs that draw at corners, or tie them together"""
        cloth = self.grid(self.size, self.size * self.uniform(0.4, 1))
        upright = self.chance(0.5)
        self.cloth("cloth", cloth | {"transform": {"rotate": [90 if upright else 0, 1, 0, 0], "translate": [0, 0, 0]}})
        n, m = cloth["grid"]["cells"]
        way = self.travel_for(0.5 * self.size)
        mass = 0.2 * self.size ** 2
        for selection in self.pick([[{"corners": ["min_max"]}, {"corners": ["max_max"]}], [{"edge": "top"}],
                                    [{"corners": ["min_min", "max_max"]}]]):
            handle = {"cloth": "cloth"} | selection | {"stiffness": self.log(1, 1000) * mass * GRAVITY / self.size}
            if self.chance(0.6):
                handle["motion"] = self.pin_keys([[0, 0, 0], [way * self.uniform(-1, 1), way * self.uniform(-1, 1), way]])
            if self.chance(0.4):
                handle |= {"end_time": self.duration * self.uniform(0.3, 0.9), "fade_time": self.uniform(0, 0.2)}
            self.scene["handles"].append(handle)
        if self.chance(0.3):
            self.scene["handles"].append({"cloth": "cloth", "glue": [0, n], "stiffness": 10 * mass * GRAVITY / self.size})
        self.speed += 3 * self.pace
        if self.chance(0.5):
            self.add_floor(-(self.size if upright else 0) - self.gap() - 0.2 * self.thickness)

    def rings(self):
        """a curtain on rings that move together"""
        grid = self.grid(self.size, self.size * self.uniform(0.4, 1))
        n, m = grid["grid"]["cells"]
        self.cloth("cloth", grid | {"transform": {"rotate": [90, 1, 0, 0], "translate": [0, 0, 0]}})
        count = min(self.pick([3, 5, 9]), n // 2 + 1)
        share = self.uniform(0.1, 0.6)
        for k in range(count):
            i = round(k * n / max(1, count - 1))
            x = self.size * (i / n - 0.5)
            self.pin("cloth", {"vertices": [m * (n + 1) + i]}, self.pin_keys([[0, 0, 0], [-share * x, 0, 0]]))
        self.scene["jitter"] = {"amplitude": 1e-4 * self.cell}
        self.blow(0.3)

    def bowl(self):
        """a sheet falls into a bowl or a funnel"""
        rim, depth = self.size * self.uniform(0.3, 0.8), self.size * self.uniform(0.2, 0.6)
        hole = self.pick([0, self.uniform(0.1, 0.4) * rim])
        wall = 0.1 * depth
        profile = [[hole, 0], [0.6 * (rim - hole) + hole, 0.25 * depth], [rim, depth]]
        if self.chance(0.5):
            self.obstacle({"revolution": {"profile": profile}}, [0, 0, 0])
        elif hole > 0:
            profile += [[rim, depth + wall], [0.6 * (rim - hole) + hole, 0.25 * depth + wall], [hole, wall]]
            self.obstacle({"revolution": {"profile": profile, "closed": True}}, [0, 0, 0])
        else:
            profile += [[rim, depth + wall], [0.6 * rim, 0.25 * depth + wall], [0, wall]]
            self.obstacle({"revolution": {"profile": profile}}, [0, 0, 0])
        self.layers = self.pick([1, 1, 2])
        for k in range(self.layers):
            self.cloth(f"cloth_{k}", self.sheet(self.size) | {"transform": {
                "translate": [0, 0, depth + wall + self.thickness + (k + 1) * (self.gap() + self.thickness)]}})
        if self.chance(0.3):
            self.move(self.scene["obstacles"][0], [0, 0, 0], self.sign() * self.uniform(0.2, 1) * self.duration)

    def roller(self):
        """a sheet that hangs from a roller, which winds it up"""
        height = self.size * self.uniform(0.4, 1)
        radius = self.size * self.uniform(0.05, 0.2)
        self.files["roller.obj"] = self.rod(radius, 1.3 * self.size)
        roller = self.obstacle({"mesh": "roller.obj"}, [0, 0, 0])
        turns, end = -self.uniform(0.2, 1.2) * self.duration, 0.9 * self.duration
        del roller["transform"]
        roller["motion"] = [{"time": 0, "rotate": [0, 0, 1, 0]}, {"time": end, "rotate": [360 * turns, 0, 1, 0]}]
        # the width of the sheet lies along y, its height along z
        self.cloth("cloth", self.grid(self.size, height) | {"transform": {"rotate": [120, 1, 1, 1], "translate": [
            radius + self.gap() + 0.2 * self.thickness, 0, -height / 2]}})
        self.scene["pins"].append({"cloth": "cloth", "edge": "top", "obstacle": roller["name"]})
        self.speed += 3 * 2 * math.pi * abs(turns) / end * (radius + 0.1 * self.size)
        self.blow(0.2)

    def rod(self, radius, length):
        """along y, with blunt points at its ends"""
        around, rows = 24, 16
        lines = [f"v 0 {-length / 2 - radius / 2:.6g} 0"]
        for i in range(rows + 1):
            for j in range(around):
                a = 2 * math.pi * j / around
                lines.append(f"v {radius * math.cos(a):.6g} {length * (i / rows - 0.5):.6g} {radius * math.sin(a):.6g}")
        last = 2 + (rows + 1) * around
        lines.append(f"v 0 {length / 2 + radius / 2:.6g} 0")
        for j in range(around):
            k = (j + 1) % around
            lines.append(f"f 1 {2 + j} {2 + k}")
            for i in range(rows):
                a, b = 2 + i * around, 2 + (i + 1) * around
                lines += [f"f {a + j} {b + j} {b + k}", f"f {a + j} {b + k} {a + k}"]
            lines.append(f"f {last - around + j} {last} {last - around + k}")
        return "\n".join(lines) + "\n"

    # ---------------------------------------------------------------- settings

    def settings(self):
        """of the scene as a whole"""
        scene = self.scene
        contact = scene.setdefault("contact", {})
        if self.chance(0.5):
            contact["friction"] = self.pick([0, self.uniform(0, 1), self.uniform(0, 1)])
        if self.chance(0.05):
            contact["untangle"] = True
        if self.chance(0.2):
            kind = self.pick(["tilted", "weak", "strong", "none", "any"])
            if kind == "none":
                scene["gravity"] = [0, 0, 0]
            elif kind == "tilted":
                scene["gravity"] = [self.uniform(-5, 5), self.uniform(-5, 5), -8]
            elif kind == "any" and self.floor is None:
                scene["gravity"] = self.pick([[0, -GRAVITY, 0], [GRAVITY, 0, 0], [0, 0, GRAVITY]])
            else:
                scene["gravity"] = [0, 0, -self.pick([1.62, 3.7]) if kind == "weak" else -24.8]
            self.settles = False
        if self.chance(0.2):
            scene["precision"] = self.pick(["float", "double"])
        if self.chance(0.1):
            scene["solver"] = self.pick([{"newton_iterations": 1}, {"newton_iterations": 10}, {"tolerance": 1e-3}])
        if self.chance(0.08) and not scene["seams"]:
            for cloth in scene["cloths"]:
                cloth["pressure"] = self.uniform(-3, 3) * 0.2 * GRAVITY
                self.speed += abs(cloth["pressure"]) / 0.02 * self.duration
            self.free = self.settles = False
        if self.chance(0.1) and "jitter" not in scene:
            scene["jitter"] = {"amplitude": 1e-4 * self.cell}
        self.method()

    def method(self):
        scene = self.scene
        kind = self.pick(["implicit"] * 16 + ["adaptive"] * 2 + ["view", "asynchronous", "time_parallel"])
        if kind == "asynchronous":
            # each element takes steps as short as its stiffness asks
            unsupported = (scene["seams"] or scene["handles"] or "wind" in scene or self.size < 0.3
                           or any("pressure" in cloth for cloth in scene["cloths"]) or scene.get("precision") == "float")
            if unsupported:
                kind = "implicit"
            else:
                scene["materials"] = {"soft": {"density": 0.2, "stretch_stiffness": 20 * self.size,
                                               "bending_stiffness": 1e-6 * self.size ** 3}}
                for cloth in scene["cloths"]:
                    cloth.pop("fabric", None)
                    cloth["material"] = "soft"
                scene["time"]["step"] = 0.005
                scene["time"]["frames"] = self.frames = min(self.frames, round(0.3 * self.rate))
                self.settles = False
        few = self.triangles < 1000 * self.layers  # the method begins with a mesh of a twenty-fifth of them
        if kind == "time_parallel" and (scene["seams"] or self.step == "auto" or few):
            kind = "implicit"
        if kind in ("adaptive", "view") and "refine" in scene:
            kind = "implicit"
        if kind != "implicit":
            scene["method"] = {"type": kind}
        self.kind = kind
        if kind == "view":
            self.passing_camera()
        if kind != "asynchronous" and self.chance(0.15):
            scene.setdefault("method", {})["integrator"] = "bdf2"
        if kind == "time_parallel":
            scene["method"]["time_parallel"] = {"slices": 2}
        if kind == "implicit" and self.step != "auto" and self.chance(0.05):
            scene.setdefault("method", {})["implicit"] = {"sleep_distance": 0.001 * self.size}

    def passing_camera(self):
        """sees a part of the first cloth, then all of it, from nearer or after a cut, and that part again"""
        cloth = self.scene["cloths"][0]
        placed = cloth["motion"][0] if "motion" in cloth else cloth.get("transform", {})
        x, y, z = placed.get("translate", [0, 0, 0])
        size = self.size
        part = {"position": [x + size, y - 1.5 * size, z + size], "look_at": [x + size, y, z], "field_of_view": 25}
        whole = {"position": [x, y - 2.5 * size, z + size], "look_at": [x, y, z], "field_of_view": 35}
        self.scene["camera"] = {"keys": [
            {"time": 0, **part},
            {"time": self.duration / 2, **whole, "jump": self.frames % 2 == 0},
            {"time": 1.01 * self.duration, **part},
        ]}

    def shift(self, by):
        """moves the whole scene, as if it stood in a landscape"""
        scene = self.scene
        turning = any("angular_velocity" in cloth for cloth in scene["cloths"]) or any(
            "rotate" in key for pin in scene.get("pins", []) + scene.get("handles", []) for key in pin.get("motion", []))
        if turning:
            return
        for part in scene["cloths"] + scene.get("obstacles", []):
            for key in part["motion"] if "motion" in part else [part.setdefault("transform", {})]:
                key["translate"] = [a + b for a, b in zip(key.get("translate", [0, 0, 0]), by)]
        for key in scene.get("camera", {}).get("keys", []):
            for place in ("position", "look_at"):
                key[place] = [a + b for a, b in zip(key[place], by)]
        if self.floor is not None:
            self.floor += by[2]
