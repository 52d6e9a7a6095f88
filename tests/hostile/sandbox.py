"""A folder in which the program runs, and what it may do there.

    ROOT/deep/er/        two levels, so that "../.." stays within what is watched
      in/                the scene's folder
      work/              the working directory
      results/out/       the output folder, the only place that may change
      home/, tmp/        HOME and TMPDIR
      outside/           files with a secret, which no scene may read
"""

import contextlib
import dataclasses
import hashlib
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import stat
import struct
import subprocess
import tempfile
import threading
import time

SECRET = "kestrel-4217-quartz"
# What a leak of other files that every machine has would show.
SECRETS = (SECRET.encode(), b"root:x:0:0")
PAYLOAD = "PWNED"
TOKENS = {"@OUTSIDE@": "outside", "@IN@": "in", "@HOME@": "home", "@RESULTS@": "results"}

CPU_LIMIT = 1.0  # s; of the processor, so that a busy machine changes no verdict
WALL_LIMIT = 5.0  # times that; ends what hangs
MEMORY_LIMIT = 4 << 30
HASHED_MAX = 16 << 20  # bytes; larger files here are sparse
LINE_MAX = 10000  # characters of a message; room for two paths as long as paths may be

# Control characters of C0 and C1, and those that turn the direction of text.
UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ufffe]")


@dataclasses.dataclass
class Outcome:
    code: int  # of the process; negative: the signal that ended it
    out: bytes
    err: bytes
    cpu: float  # s
    stopped: bool = False  # it ran until the limit

    def errors(self):
        """Lines on standard error that are no warnings."""
        lines = self.err.decode("utf-8", "surrogateescape").splitlines()
        return [line for line in lines if not line.startswith("weft: warning: ")]


def limit_memory():
    """Children inherit it: a file that claims much must be refused, not fill the machine."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class Sandbox:
    def __init__(self, program, scale=1.0):
        """scale multiplies the limits of time; for builds with sanitizers"""
        self.program = str(pathlib.Path(program).resolve())
        self.scale = scale
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="weft_hostile_"))
        self.user = None
        deep = self.root / "deep" / "er"
        for name in ("in", "work", "results", "home", "tmp", "outside"):
            (deep / name).mkdir(parents=True)
            setattr(self, name, deep / name)
        self.out = self.results / "out"
        (self.outside / "secret.txt").write_text(SECRET + "\n")
        (self.outside / "secret.obj").write_text(
            f"# {SECRET}\no {SECRET}\nusemtl {SECRET}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        (self.outside / "secret.json").write_text(json.dumps({"name": SECRET, "oops": SECRET}))
        (self.outside / "secret.bin").write_bytes(struct.pack("<3f", 0, 0, 0) * 3 + SECRET.encode())
        (self.home / "key").write_text(SECRET + "\n")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.remove()

    def remove(self):
        for folder, folders, _ in os.walk(self.root):
            for name in folders:
                if not os.path.islink(path := os.path.join(folder, name)):
                    os.chmod(path, 0o700)
        shutil.rmtree(self.root, ignore_errors=True)

    # ------------------------------------------------------------------------------------ filling
    def path(self, text):
        """A path below in/, or one that begins with a place such as @OUTSIDE@ or {out}."""
        text = self.filled(text)
        return pathlib.Path(text) if text.startswith("/") else self.in_path(text)

    def in_path(self, name):
        return pathlib.Path(getattr(self, "in")) / name

    def filled(self, text):
        for token, name in TOKENS.items():
            text = text.replace(token, str(getattr(self, name)))
        for name in ("in", "out", "results", "outside", "home"):
            text = text.replace("{" + name + "}", str(getattr(self, name)))
        return text

    def place(self, source, name=None):
        """Copies a file into in/; places in its text become those of this sandbox."""
        content = pathlib.Path(source).read_bytes()
        for token, place in TOKENS.items():
            content = content.replace(token.encode(), str(getattr(self, place)).encode())
        target = self.path(name or pathlib.Path(source).name)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        return target

    def give_away(self):
        """Runs the program as a user whom permissions bind."""
        if os.geteuid() != 0:
            return
        self.user = 65534
        for folder, folders, files in os.walk(self.root):
            for name in [folder] + [os.path.join(folder, n) for n in folders + files]:
                os.chown(name, self.user, self.user, follow_symlinks=False)

    # ------------------------------------------------------------------------------------ running
    def environment(self):
        keep = {k: os.environ[k] for k in ("PATH", "LD_LIBRARY_PATH", "ASAN_OPTIONS", "UBSAN_OPTIONS")
                if k in os.environ}
        return {**keep, "HOME": str(self.home), "TMPDIR": str(self.tmp), "LC_ALL": "C.UTF-8",
                "WEFT_HOSTILE_SECRET": SECRET}

    def start(self, arguments, **options):
        words = [self.program] + [os.fsencode(self.filled(a)) for a in arguments]
        return subprocess.Popen(words, cwd=self.work, env=self.environment(),
                                stdin=subprocess.DEVNULL, user=self.user, start_new_session=True,
                                **options)

    def run(self, arguments, stops=False, seconds=CPU_LIMIT):
        """
        stops: one that takes too long is asked to stop first, as runs may go on for long
        seconds: of the processor, from where on it takes too long
        """
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            process = self.start(arguments, stdout=out, stderr=err)
            ended, fired = threading.Event(), []
            watcher = threading.Thread(target=self.watch, args=(process.pid, ended, fired, stops, seconds))
            watcher.start()
            _, status, usage = os.wait4(process.pid, 0)
            ended.set()
            watcher.join()
            process.returncode = os.waitstatus_to_exitcode(status)
            out.seek(0)
            err.seek(0)
            return Outcome(process.returncode, out.read(), err.read(),
                           usage.ru_utime + usage.ru_stime, bool(fired))

    def watch(self, pid, ended, fired, stops, seconds):
        """Signals a process that takes too long."""
        start = time.monotonic()
        while not ended.wait(0.05):
            if not fired and stops and cpu_time(pid) > seconds * self.scale:
                fired.append(signal.SIGTERM)
                start = time.monotonic()
            elif time.monotonic() - start > WALL_LIMIT * seconds * self.scale:
                fired.append(signal.SIGKILL)
            else:
                continue
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, fired[-1])

    # ----------------------------------------------------------------------------------- watching
    def snapshot(self, output):
        """Everything in the sandbox but what is below the output folder."""
        seen = {}
        # Making the output folder changes those above it, and a temporary file may come and go.
        timeless = {os.fsencode(p) for p in [self.tmp, output, *output.parents]}

        def look(path):
            facts = os.lstat(path)
            kind = stat.S_IFMT(facts.st_mode)
            entry = [kind, facts.st_mode]
            if path not in timeless:
                entry.append(facts.st_mtime_ns)
            if kind == stat.S_IFLNK:
                entry.append(os.readlink(path))
            elif kind == stat.S_IFREG:
                entry.append(facts.st_size)
                if facts.st_size <= HASHED_MAX and os.access(path, os.R_OK):
                    with open(path, "rb") as file:
                        entry.append(hashlib.sha256(file.read()).hexdigest())
            seen[path] = tuple(entry)
            if kind == stat.S_IFDIR and os.access(path, os.R_OK | os.X_OK):
                for name in sorted(os.listdir(path)):
                    child = os.path.join(path, name)
                    if child != os.fsencode(output):
                        look(child)

        look(os.fsencode(self.root))
        return seen

    def changes(self, before, after):
        changed = []
        for path in sorted(before.keys() | after.keys()):
            if before.get(path) != after.get(path):
                what = "made" if path not in before else "gone" if path not in after else "changed"
                changed.append(f"{what}: {os.path.relpath(path, os.fsencode(self.root))!r}")
        return changed


def cpu_time(pid):
    """Seconds of the processor that a process has used; 0 once it is gone."""
    with contextlib.suppress(OSError):
        text = pathlib.Path(f"/proc/{pid}/stat").read_text("utf-8", "replace")
        user, system = text.rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")
    return 0.0


# ------------------------------------------------------------------------------------- what must hold
def told_problems(outcome):
    """What standard output and error may not look like, whatever the outcome."""
    problems = []
    for name, content in (("standard output", outcome.out), ("standard error", outcome.err)):
        try:
            text = content.decode("utf-8")
        except UnicodeDecodeError as error:
            problems.append(f"{name} is no UTF-8: {error}")
            continue
        # A carriage return redraws the line of progress.
        found = UNPRINTABLE.search(text.replace("\r", "") if name == "standard output" else text)
        if found:
            problems.append(f"{name} holds the character U+{ord(found.group()):04X}")
    for line in outcome.err.split(b"\n"):
        if line and not line.startswith(b"weft: "):
            problems.append(f"a line on standard error does not begin with weft: {line[:200]!r}")
        if len(line) > LINE_MAX:
            problems.append(f"a line on standard error has {len(line)} bytes")
    return problems


def leaks(outcome, output):
    problems = []
    places = [("standard output", outcome.out), ("standard error", outcome.err)]
    for path in files_of(output):
        places.append((str(path), path.read_bytes()))
    for name, content in places:
        problems += [f"{name} holds a secret" for secret in SECRETS if secret in content]
    return problems


def files_of(folder):
    """Regular files below a folder, which may be missing; no links."""
    for path, folders, names in os.walk(os.fsencode(folder)):
        for name in sorted(names):
            file = pathlib.Path(os.fsdecode(os.path.join(path, name)))
            if stat.S_ISREG(os.lstat(file).st_mode) and os.lstat(file).st_size <= HASHED_MAX:
                yield file


def strict_json(text):
    def refuse(constant):
        raise ValueError(f"{constant} is no JSON")
    return json.loads(text, parse_constant=refuse)


def output_problems(output):
    """Whether other programs can read what was written, and only read."""
    problems = []
    for path in files_of(output):
        name = path.name
        if PAYLOAD == name:
            problems.append("a command in a name was run: " + str(path))
        try:
            if name.endswith(".json"):
                strict_json(path.read_text("utf-8"))
            elif name.endswith(".jsonl"):
                for line in path.read_text("utf-8").splitlines():
                    strict_json(line)
            elif name.endswith(".html"):
                text = path.read_text("utf-8").lower()
                if text.count("<script") != 1 or text.count("</script") != 1:
                    problems.append(f"{name} has more than one script")
            elif name.endswith(".gp"):
                # Text in single quotes is only text, and so is a comment.
                bare = re.sub(r"'(?:[^'\n]|'')*'|^#[^\n]*(?<!\\)$", "", path.read_text("utf-8"),
                              flags=re.M)
                if PAYLOAD in bare:
                    problems.append(f"{name} holds a name as a command")
        except ValueError as error:
            problems.append(f"{path.name} cannot be read: {error}")
    return problems
