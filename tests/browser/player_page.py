#!/usr/bin/env python3
"""Plays the page of `weft view` in Chromium.

- Frames advance, and can be chosen.
- Turning with the mouse, and with a finger, changes the picture; so does every look that there is.
- A wide screen and a phone show all of it; nothing is wider than the phone.
- The console stays empty, nothing is asked of a network, and names of a stranger stay names.

usage: player_page.py --program WEFT [--keep FOLDER]

Exit code 77: there is no Chromium, or the program was built without three.js.
"""

import json
import re
import shutil
import subprocess
import sys
import time

import chromium
from chromium import expect

NAME = "</script><script>window.hurt=1</script><img/src=x/onerror=window.hurt=2>"
SCENE = {
    "name": "press", "device": "cpu",
    "time": {"step": 0.01, "frame_rate": 25, "frames": 7},
    "materials": {"cotton": {"density": 0.15}},
    "contact": {"thickness": 0.004, "compliance_distance": None},
    "cloths": [{"name": "sheet", "material": "cotton", "grid": {"size": [0.3, 0.3], "cells": [8, 8]}}],
    "obstacles": [
        {"name": "below", "box": {"size": [0.2, 0.2, 0.1], "cells": [4, 4, 2]}, "motion": [
            {"time": 0, "translate": [0, 0, -0.07]}, {"time": 0.4, "translate": [0, 0, -0.035]}]},
        {"name": "above", "box": {"size": [0.2, 0.2, 0.1], "cells": [4, 4, 2]}, "motion": [
            {"time": 0, "translate": [0, 0, 0.07]}, {"time": 0.4, "translate": [0, 0, 0.035]}]}],
}


def weft(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    if "lacks three.js" in done.stderr:
        print(f"SKIPPED: {done.stderr.strip()}")
        sys.exit(77)
    expect(done.returncode == 0, f"weft {arguments}: {done.stderr}")


def choose(page, look):
    page.run(f"{{ const c = document.getElementById('colour'); c.value = '{look}';"
             "c.dispatchEvent(new Event('change')); }")


def scrub(page, place):
    page.run(f"{{ const s = document.getElementById('scrub'); s.value = {place};"
             "s.dispatchEvent(new Event('input')); }")


def clock(page):
    return page.run("document.getElementById('clock').textContent")


def stage(page):
    """Middle of the picture."""
    return page.run("(box => [box.left + box.width / 2, box.top + box.height / 2])"
                    "(document.getElementById('scene').getBoundingClientRect())")


def turns(page, touch):
    x, y = stage(page)
    before = page.picture()
    expect(page.picture() == before, "the picture changes by itself")
    page.drag((x - 60, y), (x + 60, y + 30), touch)
    expect(page.picture() != before, f"{'touch' if touch else 'mouse'} does not turn the picture")


def make_strange(run, strange):
    """A run as weft writes none: cloths may not have such names."""
    shutil.copytree(run, strange)
    (strange / "scene.json").unlink()
    for frame in (strange / "frames").glob("cloth_*.obj"):
        frame.write_text(re.sub(r"^([og]) .*$", lambda m: f"{m[1]} {NAME}", frame.read_text(), flags=re.M))
    report = json.loads((strange / "report.json").read_text())
    (strange / "report.json").write_text(json.dumps({**report, "scene": NAME, "method": NAME}))


def check_strange_names(page, file):
    page.viewport(1280, 800)
    page.open(file)
    expect(page.run("window.hurt") is None, "a name in the run was executed")
    expect(page.run("document.images.length") == 0, "a name in the run became markup")
    expect(page.run("document.getElementById('title').textContent") == NAME, "the scene's name is lost")
    expect(NAME in page.run("document.getElementById('parts').textContent"), "the cloth's name is lost")


def check_playing(page):
    expect(clock(page) == "0.000 s, frame 0", f"starts at {clock(page)}")
    page.run("document.getElementById('play').click()")
    until = time.monotonic() + 10
    seen = {clock(page)}
    while len(seen) < 4 and time.monotonic() < until:
        time.sleep(0.02)
        seen.add(clock(page))
    expect(len(seen) >= 4, f"frames do not advance: {seen}")
    page.run("document.getElementById('play').click()")
    still = clock(page)
    time.sleep(0.2)
    expect(clock(page) == still, "does not pause")
    scrub(page, 7)
    expect(clock(page) == "0.280 s, frame 7", f"scrubbed to {clock(page)}")
    facts = page.run("document.getElementById('facts').innerText")
    expect("step\t25 to 28" in facts and "wall time" in facts, f"facts: {facts}")
    page.run("document.getElementById('loop').checked = false")
    page.run("document.getElementById('speed').value = '4'")
    scrub(page, 5)
    page.run("document.getElementById('play').click()")
    until = time.monotonic() + 10
    while page.run("document.getElementById('play').textContent") != "Play":
        expect(time.monotonic() < until, "does not stop at the end")
        time.sleep(0.02)
    expect(clock(page) == "0.280 s, frame 7", f"stops at {clock(page)}")


def check_looks(page):
    seen = {}
    for look in ("plain", "strain", "height", "contact", "compliance"):
        choose(page, look)
        picture = page.picture()
        expect(picture not in seen, f"{look} looks like {seen.get(picture)}")
        seen[picture] = look
    choose(page, "plain")
    for box in ("cloths", "obstacles", "wires"):
        page.run(f"document.getElementById('{box}').click()")
        expect(page.picture() not in seen, f"{box} changes nothing")
        page.run(f"document.getElementById('{box}').click()")
    expect(page.picture() in seen, "the toggles do not return")


def check_wide(page, file):
    page.viewport(1000, 700)
    page.open(file)
    check_playing(page)
    check_looks(page)
    turns(page, touch=False)
    before = page.picture()
    page.run("document.getElementById('reset').click()")
    expect(page.picture() != before, "reset does nothing")
    x, y, wide = page.run("(box => [box.left, box.top + box.height / 2, box.width])"
                          "(document.querySelector('#strips canvas').getBoundingClientRect())")
    page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + wide * 0.49, y=y)
    facts = page.run("document.getElementById('facts').innerText")
    expect("this step" in facts and "step\t14\n" in facts, f"facts under the cursor: {facts}")


def check_phone(page, file):
    page.viewport(390, 844, phone=True)
    page.open(file)
    wide = page.run("document.documentElement.scrollWidth")
    expect(wide <= 390, f"the page is {wide} pixels wide on a phone")
    tall = page.run("document.getElementById('scene').getBoundingClientRect().height")
    expect(tall > 300, f"the picture is {tall} pixels tall on a phone")
    for element in ("play", "speed", "scrub"):
        bottom = page.run(f"document.getElementById('{element}').getBoundingClientRect().bottom")
        expect(bottom <= 844, f"{element} is below the screen of a phone")
    turns(page, touch=True)


def check_beside(page, file):
    page.viewport(1280, 800)
    page.open(file)
    expect(page.run("document.querySelectorAll('#names span').length") == 2, "the runs have no names")
    scrub(page, 7)
    turns(page, touch=False)


def check_player(program, folder, page, keep):
    (folder / "scene.json").write_text(json.dumps(SCENE))
    run, fewer = str(folder / "run"), str(folder / "fewer")
    weft(program, "run", str(folder / "scene.json"), "-o", run, "--no-preview")
    weft(program, "run", str(folder / "scene.json"), "-o", fewer, "--no-preview", "--frames", "4")
    weft(program, "view", run)
    make_strange(folder / "run", folder / "strange")
    weft(program, "view", str(folder / "strange"))
    both = folder / "both.html"
    weft(program, "view", run, "--beside", fewer, "-o", str(both))
    checks = ((check_wide, folder / "run/view.html"), (check_phone, folder / "run/view.html"),
              (check_beside, both), (check_strange_names, folder / "strange/view.html"))
    for check, file in checks:
        check(page, file)
        keep(check.__name__)
        expect(not page.problems, f"{check.__name__}: {page.problems}")
    return "wide, phone and two runs: all as expected"


if __name__ == "__main__":
    sys.exit(chromium.main(__doc__, check_player))
