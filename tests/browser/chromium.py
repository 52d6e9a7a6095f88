"""Drives Chromium over its DevTools pipe, with the standard library only."""

import argparse
import base64
import fcntl
import json
import os
import pathlib
import select
import shutil
import signal
import subprocess
import tempfile
import time


class Failed(Exception):
    """The page is not as expected."""


class Skipped(Exception):
    """The program lacks the page."""


def expect(holds, message):
    if not holds:
        raise Failed(message)


def find():
    """Path of the browser; None: there is none."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def main(about, check):
    """Runs a test of pages.

    about: what the test is, for --help
    check: takes the program, an empty folder, a page, and a function that keeps a picture of the page
           under a name; returns one line that says what is as expected
    Returns the exit code; 77: skipped.
    """
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("--program", required=True)
    parser.add_argument("--keep", type=pathlib.Path, help="folder for pictures of what was seen")
    request = parser.parse_args()
    browser = find()
    if browser is None:
        print("SKIPPED: there is no Chromium (apt-get install chromium)")
        return 77
    folder = pathlib.Path(tempfile.mkdtemp(prefix="weft-page-"))

    def keep(name):
        if request.keep:
            request.keep.mkdir(parents=True, exist_ok=True)
            (request.keep / f"{name}.png").write_bytes(page.picture())

    try:
        with Chromium(browser) as page:
            print(check(request.program, folder, page, keep))
    except Skipped as skipped:
        print(f"SKIPPED: {skipped}")
        return 77
    except Failed as failure:
        print(f"FAILED: {failure}")
        return 1
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return 0


class Chromium:
    """One page of a browser without a window. Collects whatever goes wrong in it."""

    def __init__(self, program):
        self.folder = tempfile.mkdtemp(prefix="weft-chromium-")
        # Away from 3 and 4, which the browser reads and writes.
        (theirs_in, ours_out), (ours_in, theirs_out) = [
            [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in os.pipe()] for _ in range(2)]

        def hand_over():
            os.dup2(theirs_in, 3)
            os.dup2(theirs_out, 4)

        self.child = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--use-gl=angle",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage",
             "--no-first-run", "--disable-extensions", "--disable-background-networking",
             "--hide-scrollbars", f"--user-data-dir={self.folder}", "about:blank"],
            preexec_fn=hand_over, pass_fds=(3, 4), start_new_session=True, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs_in)
        os.close(theirs_out)
        self.out, self.into = ours_out, ours_in
        self.pending = b""
        self.number = 0
        self.session = None
        self.problems = []  # errors of the console, exceptions, requests to anything but files
        self.server = None  # address that pages may ask
        self.loaded = False
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.killpg(self.child.pid, signal.SIGKILL)
        self.child.wait()
        os.close(self.out)
        os.close(self.into)
        shutil.rmtree(self.folder, ignore_errors=True)

    def message(self, seconds):
        """The next message; None: none in time."""
        until = time.monotonic() + seconds
        while b"\0" not in self.pending:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.into], [], [], left)[0]:
                return None
            chunk = os.read(self.into, 1 << 20)
            if not chunk:
                raise RuntimeError("the browser has ended")
            self.pending += chunk
        text, _, self.pending = self.pending.partition(b"\0")
        return json.loads(text)

    def note(self, message):
        method, about = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = about["exceptionDetails"]
            self.problems.append(details.get("exception", {}).get("description") or details["text"])
        elif method == "Runtime.consoleAPICalled" and about["type"] in ("error", "warning", "assert"):
            self.problems.append(" ".join(str(a.get("value", a)) for a in about["args"]))
        elif method == "Log.entryAdded" and about["entry"]["level"] in ("error", "warning"):
            self.problems.append(about["entry"]["text"])
        elif method == "Network.requestWillBeSent" and not about["request"]["url"].startswith(
                ("file:", "data:", "about:", self.server or "about:")):
            self.problems.append("asks for " + about["request"]["url"])
        elif method == "Page.javascriptDialogOpening":
            self.problems.append("dialog: " + about["message"])
        elif method == "Page.loadEventFired":
            self.loaded = True

    def call(self, method, **about):
        self.number += 1
        text = {"id": self.number, "method": method, "params": about}
        if self.session:
            text["sessionId"] = self.session
        os.write(self.out, json.dumps(text).encode() + b"\0")
        while True:
            message = self.message(30)
            if message is None:
                raise RuntimeError(f"{method}: no answer")
            if message.get("id") == self.number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message["result"]
            self.note(message)

    def viewport(self, width, height, phone=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=phone)
        self.call("Emulation.setTouchEmulationEnabled", enabled=phone)

    def open(self, page):
        """Loads a file, or the address of a server."""
        self.loaded = False
        address = page if isinstance(page, str) else page.resolve().as_uri()
        self.call("Page.navigate", url=address)
        until = time.monotonic() + 20
        while not self.loaded:
            message = self.message(until - time.monotonic())
            if message is None:
                raise RuntimeError(f"{page} is not loaded after 20 s")
            self.note(message)
        self.settle()

    def run(self, script):
        """Value of an expression; a promise is waited for."""
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(f"{script}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def settle(self):
        """Waits until all that was asked for is drawn."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame("
                 "() => requestAnimationFrame(done))))")

    def picture(self, whole=False):
        """PNG of what is seen."""
        self.settle()
        return base64.b64decode(self.call("Page.captureScreenshot", format="png",
                                          captureBeyondViewport=whole)["data"])

    def drag(self, start, end, touch=False):
        steps = [[a + (b - a) * k / 8 for a, b in zip(start, end)] for k in range(9)]
        for k, (x, y) in enumerate(steps):
            if touch:
                self.call("Input.dispatchTouchEvent", type="touchMove" if k else "touchStart",
                          touchPoints=[{"x": x, "y": y}])
            else:
                self.call("Input.dispatchMouseEvent", type="mouseMoved" if k else "mousePressed", x=x,
                          y=y, button="left", buttons=1, clickCount=0 if k else 1)
        if touch:
            self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        else:
            self.call("Input.dispatchMouseEvent", type="mouseReleased", x=end[0], y=end[1],
                      button="left", clickCount=1)
        self.settle()
