#!/usr/bin/env python3
"""Watches `weft run --live` in Chromium.

- Frames and steps come by themselves; the page pauses, continues and stops the run.
- Without the word of the address, from another host name, another origin or another address of this
  machine, nothing is served.
- A port that is taken is refused in one line.

usage: live_page.py --program WEFT [--keep FOLDER]

Exit code 77: there is no Chromium, or the program was built without what --live needs.
"""

import http.client
import json
import re
import socket
import subprocess
import sys
import time

import chromium
from chromium import expect

SCENE = {
    "name": "watched", "device": "cpu:1", "time": {"step": 0.01, "frame_rate": 25, "frames": 100000},
    "materials": {"cotton": {"density": 0.15}},
    "cloths": [{"name": "sheet", "material": "cotton", "grid": {"size": [0.5, 0.5], "cells": [20, 20]},
                "transform": {"translate": [0, 0, 0.16]}}],
    "obstacles": [{"name": "ball", "sphere": {"radius": 0.15, "subdivisions": 2}}],
}


def until(test, message, seconds=20):
    """Waits until a test holds."""
    end = time.monotonic() + seconds
    while not test():
        expect(time.monotonic() < end, message)
        time.sleep(0.05)


def start(program, folder, *more):
    return subprocess.Popen([program, "run", str(folder / "scene.json"), "-o", str(folder / "run"),
                             "--no-preview", "--overwrite", *more],
                            stdout=open(folder / "said", "w"), stderr=subprocess.PIPE, text=True)


def status(port, path, method="GET", host="127.0.0.1", **headers):
    connection = http.client.HTTPConnection(host, port, timeout=10)
    try:
        connection.request(method, path, headers=headers)
        return connection.getresponse().status
    finally:
        connection.close()


def check_strangers(port, word):
    for path in ("/", "/news", f"/{word[:-1]}/", "/0/", f"/{word}/../../etc/passwd", f"/{word}/scene.json",
                 f"/{word}/frames/cloth_00000.obj"):
        expect(status(port, path) == 404, f"{path} is served")
    expect(status(port, f"/{word}/stop") == 404, "a link stops the run")
    expect(status(port, f"/{word}/", Host=f"weft.example:{port}") == 403, "another host name is served")
    expect(status(port, f"/{word}/stop", "POST", Origin="http://weft.example") == 403,
           "a page of another origin stops the run")
    expect(status(port, f"/{word}/") == 200, "the address itself is not served")
    try:
        status(port, f"/{word}/", host="127.0.0.2")
    except OSError:
        return
    raise chromium.Failed("listens on more than 127.0.0.1")


def frames(page):
    return int(page.run("document.getElementById('scrub').max")) + 1


def state(page):
    return page.run("document.getElementById('state').textContent")


def check_page(page, address, child):
    page.server = address
    page.viewport(1280, 800)
    page.open(address)
    first = frames(page)
    until(lambda: frames(page) > first + 3, "no frames come")
    expect(page.run("document.getElementById('strips').children.length") == 1, "no steps come")
    picture = page.picture()
    page.run("document.getElementById('pause').click()")
    until(lambda: state(page) == "Paused", f"does not pause: {state(page)}")
    time.sleep(0.5)
    count = frames(page)
    time.sleep(1)
    expect(frames(page) == count, "frames come while the run is paused")
    clock = page.run("document.getElementById('clock').textContent")
    expect(clock.endswith(f"frame {count - 1}"), f"{count} frames, but it shows {clock}")
    page.run("document.getElementById('pause').click()")
    until(lambda: frames(page) > count, "does not continue")
    expect(page.picture() != picture, "the picture stays")
    page.run("document.getElementById('stop').click()")
    until(lambda: child.poll() is not None, "does not stop")
    expect(child.returncode == 130, f"ends with {child.returncode}")
    until(lambda: "ended" in state(page), f"the page says {state(page)}")


def check_live(program, folder, page, keep):
    (folder / "scene.json").write_text(json.dumps(SCENE))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        refused = start(program, folder, "--live", str(taken.getsockname()[1]))
        _, text = refused.communicate(timeout=60)
        if "this build lacks" in text:
            raise chromium.Skipped(text.strip())
        expect(refused.returncode == 2 and text.count("\n") == 1 and "--live" in text, text)
    child = start(program, folder, "--live")
    try:
        said = folder / "said"
        until(lambda: "\n" in said.read_text(), "no address")
        match = re.search(r"http://127\.0\.0\.1:(\d+)/([0-9a-f]{32})/", said.read_text())
        expect(match is not None, f"no address: {said.read_text()}")
        until(lambda: (folder / "run/frames/cloth_00000.obj").exists(), "no frame")
        check_strangers(int(match[1]), match[2])
        check_page(page, match[0], child)
        keep("live")
        # The last question has nobody to answer it, or not to the end.
        ended = ("ERR_CONNECTION", "ERR_EMPTY", "ERR_CONTENT_LENGTH_MISMATCH", "ERR_INCOMPLETE")
        problems = [p for p in page.problems if not any(error in p for error in ended)]
        expect(not problems, problems)
    finally:
        child.kill()
        child.communicate()
    return "frames come, pause, continue, stop; strangers get nothing"


if __name__ == "__main__":
    sys.exit(chromium.main(__doc__, check_live))
