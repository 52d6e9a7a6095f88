#!/usr/bin/env python3
"""Writes walk.bvh: a body that stands with its arms held out, lowers them, and walks off.

Everything is worked out from a few numbers: footsteps are planned, the hips move over them, legs
follow by inverse kinematics, arms swing against the legs. Units are centimetres and degrees, y is
up, the body faces +z, as in most files of motion capture.

usage: make_walk.py [FILE]    default: walk.bvh beside this program
"""

import math
import pathlib
import sys

FRAME_RATE = 50
DURATION = 7.0
ARMS_DOWN = (2.0, 3.2)  # [s] when the arms are lowered
FIRST_STEP = 2.8        # [s]
STEP_TIME = 0.58        # [s]
STEP_LENGTH = 56.0

ARM_OUT, ARM_HANGING = 38.0, 66.0  # [degrees] below the horizontal

# name: (parent, offset)
JOINTS = {
    "Hips": (None, (0, 0, 0)),
    "LeftUpLeg": ("Hips", (8.5, -5, 0)),
    "LeftLeg": ("LeftUpLeg", (0, -41, 0)),
    "LeftFoot": ("LeftLeg", (0, -40, 0)),
    "LeftToeBase": ("LeftFoot", (0, -4.5, 13)),
    "RightUpLeg": ("Hips", (-8.5, -5, 0)),
    "RightLeg": ("RightUpLeg", (0, -41, 0)),
    "RightFoot": ("RightLeg", (0, -40, 0)),
    "RightToeBase": ("RightFoot", (0, -4.5, 13)),
    "Spine": ("Hips", (0, 10, 0)),
    "Spine1": ("Spine", (0, 14, 0)),
    "Neck": ("Spine1", (0, 16, 0)),
    "Head": ("Neck", (0, 11, 1)),
    "LeftShoulder": ("Spine1", (5, 12, 0)),
    "LeftArm": ("LeftShoulder", (11.5, 1.5, 0)),
    "LeftForeArm": ("LeftArm", (27, 0, 0)),
    "LeftHand": ("LeftForeArm", (24, 0, 0)),
    "RightShoulder": ("Spine1", (-5, 12, 0)),
    "RightArm": ("RightShoulder", (-11.5, 1.5, 0)),
    "RightForeArm": ("RightArm", (-27, 0, 0)),
    "RightHand": ("RightForeArm", (-24, 0, 0)),
}
ENDS = {
    "LeftToeBase": (0, -0.5, 6), "RightToeBase": (0, -0.5, 6), "Head": (0, 19, 1),
    "LeftHand": (17, 0, 0), "RightHand": (-17, 0, 0),
}
THIGH, SHIN = 41.0, 40.0
ANKLE = 6.5                          # height of the ankle of a foot on the floor
STANDING = ANKLE + SHIN + THIGH + 5  # height of the hips with straight legs


# ------------------------------------------------------------------------------------------ vectors
def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def scaled(a, s):
    return tuple(x * s for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return scaled(a, 1 / math.sqrt(dot(a, a)))


def product(a, b):
    return tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def transposed(a):
    return tuple(zip(*a))


def times(a, x):
    return tuple(dot(row, x) for row in a)


def turn(axis, degrees):
    """Rotation matrix about x, y or z."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return {"x": ((1, 0, 0), (0, c, -s), (0, s, c)),
            "y": ((c, 0, s), (0, 1, 0), (-s, 0, c)),
            "z": ((c, -s, 0), (s, c, 0), (0, 0, 1))}[axis]


def euler_zxy(m):
    """Angles z, x, y [degrees] with turn(z) turn(x) turn(y) = m."""
    x = math.asin(max(-1.0, min(1.0, m[2][1])))
    z = math.atan2(-m[0][1], m[1][1])
    y = math.atan2(-m[2][0], m[2][2])
    return tuple(math.degrees(a) for a in (z, x, y))


# ------------------------------------------------------------------------------------------- curves
def ease(t, start, end):
    """0 before start, 1 after end, smooth between them."""
    s = max(0.0, min(1.0, (t - start) / (end - start)))
    return s * s * s * (s * (6 * s - 15) + 10)


def footprint(k):
    """Where foot k is set down, left ones even; both stand at 0 before the first step."""
    return STEP_LENGTH * (k + 0.5) if k >= 0 else 0.0


def hips_forward(t):
    """Halfway between both feet whenever one is set down; smooth between."""
    def knot(k):  # at FIRST_STEP + k STEP_TIME
        return 0.0 if k <= 0 else (footprint(k - 1) + footprint(k - 2)) / 2

    def slope(k):
        return 0.0 if k <= 0 else (knot(k + 1) - knot(k - 1)) / 2
    s = (t - FIRST_STEP) / STEP_TIME
    k = math.floor(s)
    s -= k
    h = (2 * s**3 - 3 * s**2 + 1, s**3 - 2 * s**2 + s, -2 * s**3 + 3 * s**2, s**3 - s**2)
    return h[0] * knot(k) + h[1] * slope(k) + h[2] * knot(k + 1) + h[3] * slope(k + 1)


def foot(t, side):
    """Forward position and height of an ankle, and the pitch of its foot [degrees], toes up > 0.
    @param side 0: left, which takes steps 0, 2, ...; 1: right"""
    s = (t - FIRST_STEP) / STEP_TIME
    step = math.floor(s)
    if step < 0 or (step == 0 and side == 1):
        lift = ease(s - side, -0.3, 0)
        return 0.0, ANKLE + 4.5 * lift, -22 * lift
    if step % 2 != side:  # stands; late in the step the heel comes up
        lift = ease(s - step, 0.7, 1)
        flat = ease(s - step, 0, 0.18)
        pitch = 14 * (1 - flat) - 22 * lift
        return footprint(step - 1), ANKLE + 4.5 * lift + 1.2 * (1 - flat), pitch
    s -= step
    here, there = footprint(step - 2), footprint(step)
    height = ANKLE + 4.5 * (1 - ease(s, 0, 0.6)) + 1.2 * ease(s, 0.6, 1) \
        + 7 * math.sin(math.pi * s) ** 2
    pitch = -22 + 8 * math.sin(math.pi * min(1, 2 * s)) * -1 + 36 * ease(s, 0.25, 1)
    return here + (there - here) * ease(s, -0.1, 1.05), height, pitch


# --------------------------------------------------------------------------------------------- pose
def frame_along(down):
    """Frame of a leg's bone that points along `down`, its x axis to the left."""
    y = scaled(down, -1)
    x = unit(sub((1, 0, 0), scaled(y, y[0])))
    return transposed((x, y, cross(x, y)))


def leg(hip, ankle):
    """Frames of thigh and shin: two bones of fixed length, the knee to the front."""
    way = sub(ankle, hip)
    reach = min(math.sqrt(dot(way, way)), 0.9985 * (THIGH + SHIN))
    along = unit(way)
    front = unit(sub((0, 0, 1), scaled(along, along[2])))
    cosine = (THIGH**2 + reach**2 - SHIN**2) / (2 * THIGH * reach)
    knee = add(scaled(along, THIGH * cosine), scaled(front, THIGH * math.sqrt(1 - cosine**2)))
    return frame_along(unit(knee)), frame_along(unit(sub(scaled(along, reach), knee)))


def pose(t):
    """Position of the hips and the frame of every joint in the world."""
    walking = ease(t, FIRST_STEP - 0.4, FIRST_STEP + STEP_TIME)
    phase = math.pi * (t - FIRST_STEP) / STEP_TIME  # a cycle of two steps is 2 pi
    # Lowest shortly after a foot is set down; towards the leg that stands.
    height = STANDING - 0.4 - walking * (3.0 + 1.4 * math.cos(2 * phase - 0.5))
    hips_at = (-2.0 * walking * math.sin(phase), height, hips_forward(t))
    swing = walking * -math.cos(phase)  # -1: the left leg is behind
    yaw = -5 * swing
    frames = {"Hips": product(turn("y", yaw), turn("z", -3 * walking * math.sin(phase)))}
    for side, name in enumerate(("Left", "Right")):
        hip = add(hips_at, times(frames["Hips"], JOINTS[name + "UpLeg"][1]))
        forward, up, pitch = foot(t, side)
        ankle = ((7.5, -7.5)[side], up, forward)
        frames[name + "UpLeg"], frames[name + "Leg"] = leg(hip, ankle)
        frames[name + "Foot"] = turn("x", -pitch)
        # The toes stay flat while the heel comes up.
        frames[name + "ToeBase"] = turn("x", -max(pitch, 0.3 * pitch))
    back = turn("y", -yaw * 0.8)
    frames["Spine"] = product(turn("y", -yaw * 0.2), turn("x", 2 * walking))
    frames["Spine1"] = product(back, turn("x", 3 * walking))
    frames["Neck"] = frames["Head"] = turn("x", 2 * walking)
    down = ARM_OUT + (ARM_HANGING - ARM_OUT) * ease(t, *ARMS_DOWN)
    bend = 4 + 14 * ease(t, *ARMS_DOWN)
    for name, sign in (("Left", 1), ("Right", -1)):
        forward = -sign * 17 * swing  # against the leg of its side
        frames[name + "Shoulder"] = back
        frames[name + "Arm"] = product(product(back, turn("x", -forward)), turn("z", -sign * down))
        bent = turn("y", -sign * (bend + 0.4 * max(0, forward)))
        frames[name + "ForeArm"] = product(frames[name + "Arm"], bent)
        frames[name + "Hand"] = frames[name + "ForeArm"]
    return hips_at, frames


# --------------------------------------------------------------------------------------------- file
def hierarchy(name, depth):
    parent, offset = JOINTS[name]
    tab = "  " * depth
    lines = [f"{tab}{'JOINT' if parent else 'ROOT'} {name}", tab + "{",
             f"{tab}  OFFSET " + " ".join(f"{x:g}" for x in offset)]
    position = "" if parent else "Xposition Yposition Zposition "
    lines.append(f"{tab}  CHANNELS {3 if parent else 6} {position}Zrotation Xrotation Yrotation")
    for child in (n for n, (p, _) in JOINTS.items() if p == name):
        lines += hierarchy(child, depth + 1)
    if name in ENDS:
        lines += [tab + "  End Site", tab + "  {",
                  f"{tab}    OFFSET " + " ".join(f"{x:g}" for x in ENDS[name]), tab + "  }"]
    return lines + [tab + "}"]


def depth_first(name):
    yield name
    for child in (n for n, (p, _) in JOINTS.items() if p == name):
        yield from depth_first(child)


def numbers(t):
    """The channels of one frame."""
    at, frames = pose(t)
    values = list(at)
    for name in depth_first("Hips"):
        parent = JOINTS[name][0]
        local = product(transposed(frames[parent]), frames[name]) if parent else frames[name]
        values += euler_zxy(local)
    return values


def walk():
    """The whole file."""
    count = round(DURATION * FRAME_RATE) + 1
    lines = ["HIERARCHY"] + hierarchy("Hips", 0)
    lines += ["MOTION", f"Frames: {count}", f"Frame Time: {1 / FRAME_RATE:g}"]
    for f in range(count):
        # + 0.0 makes a zero of what would be written as -0.000
        lines.append(" ".join(f"{round(x, 3) + 0.0:.3f}" for x in numbers(f / FRAME_RATE)))
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent / "walk.bvh"
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    target.write_text(walk(), encoding="ascii")
