"""Cloth that neither passes through itself nor through bodies. SI units, z up.

    import weft
    scene = weft.Scene()
    shirt = scene.add_cloth(V, F, uv=uv, fabric="denim")
    for frame in weft.run(scene, seconds=2.0):
        x = frame.positions(shirt)
"""

from __future__ import annotations

import collections
import concurrent.futures
import itertools
import json
import multiprocessing
import os
import sys
import threading
import warnings
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Sequence

from weft import _weft
from weft._weft import ClothId, DeviceArray, DeviceError, ObstacleId, PinId, SceneError, SimulationError, __version__
from weft._garment import Garment, garments

if TYPE_CHECKING:
    import numpy
    from numpy.typing import ArrayLike, NDArray

__all__ = ["ClothId", "DeviceArray", "DeviceError", "Frame", "Garment", "ObstacleId", "PinId", "Scene", "SceneError", "Simulation",
           "SimulationError", "__version__", "garments", "load", "run", "sweep"]


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _expect(value: object, kind: type | tuple[type, ...], name: str, source: str) -> None:
    """Raises SceneError unless `value` is an id that `source` returns."""
    if not isinstance(value, kind):
        raise SceneError(f"{name}: {value!r}; allowed: what {source} has returned")


class Scene:
    """Cloths, obstacles and pins, and how they are simulated.

    gravity: [x, y, z] in m/s^2; time_step: seconds; frame_rate: frames a second; thickness: metres at which
    cloth begins to repel, None: 1 mm or a quarter of the edges of finer cloth; friction: of cloth against cloth;
    method: "implicit", "adaptive", "asynchronous".
    cloths: the ids of all cloths. frames: how many the scene file asks for.
    """

    gravity: list[float]
    time_step: float
    frame_rate: float
    thickness: float | None
    friction: float
    method: str
    cloths: list[ClothId]
    frames: int

    _fields = tuple(__annotations__)
    _scene: _weft.Scene

    def __init__(self) -> None:
        object.__setattr__(self, "_scene", _weft.Scene())

    def __getattr__(self, name: str) -> Any:
        if name not in self._fields:
            raise AttributeError(f"Scene has no {name}; it has {', '.join(self._fields)}")
        return getattr(self._scene, name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self._fields:
            raise AttributeError(f"Scene has no {name}; it has {', '.join(self._fields)}")
        setattr(self._scene, name, value)

    def add_cloth(self, vertices: ArrayLike, faces: ArrayLike, uv: ArrayLike | None = None,
                  fabric: str = "cotton_polyester", name: str = "") -> ClothId:
        """Adds cloth and returns its id. The arrays are copied.

        vertices: (n, 3) metres, where it starts; faces: (m, 3) vertices, counter-clockwise from the front;
        uv: (n, 2) metres, the flat pattern. Without uv the start has to be flat, and is the pattern.
        fabric: such as "cotton", "silk" or "denim"; `weft info --fabrics` lists all, and says which numbers are estimates.
        Raises SceneError for wrong shapes, faces out of range or an unknown fabric.
        """
        vertices, faces = _places(vertices, "vertices"), _whole_numbers(faces, "faces")
        pattern = _pattern(vertices) if uv is None else _numbers(uv)
        _warn_of_sizes(vertices, faces, pattern)
        return self._scene.add_cloth(vertices, faces, pattern, fabric, name)

    def add_obstacle(self, vertices: ArrayLike, faces: ArrayLike, friction: float = 0.3, name: str = "") -> ObstacleId:
        """Adds a body and returns its id. Simulation.move() moves it; unmoved it stays.

        vertices: (n, 3) metres; faces: (m, 3). Raises SceneError for wrong shapes or faces out of range.
        """
        return self._scene.add_obstacle(_places(vertices, "vertices"), _whole_numbers(faces, "faces"), friction, name)

    def pin(self, cloth: ClothId, vertices: ArrayLike) -> PinId:
        """Holds vertices of a cloth where they start, until they are moved or released.

        vertices: their numbers, counted from 0. numpy.flatnonzero() makes them of a mask.
        """
        _expect(cloth, ClothId, "cloth", "add_cloth()")
        return self._scene.pin(cloth, _whole_numbers(vertices, "vertices"))


def _numbers(values: ArrayLike) -> NDArray[numpy.float64]:
    import numpy
    return numpy.asarray(values, dtype=numpy.float64)


def _places(values: ArrayLike, name: str) -> NDArray[numpy.float64]:
    """(n, 3) Raises SceneError for any other shape, and for what is not finite."""
    import numpy
    x = _numbers(values)
    if x.ndim != 2 or x.shape[0] < 1 or x.shape[1] != 3:
        raise SceneError(f"{name}: shape {x.shape}; allowed: shape (n, 3)")
    if not numpy.isfinite(x).all():
        row = int(numpy.flatnonzero(~numpy.isfinite(x).all(axis=1))[0])
        raise SceneError(f"{name}[{row}]: {x[row].tolist()}; allowed: finite numbers")
    return x


def _whole_numbers(values: ArrayLike, name: str) -> NDArray[numpy.int64]:
    """Raises SceneError for numbers with a fraction, and for a mask."""
    import numpy
    found = numpy.asarray(values)
    if found.size > 0 and not numpy.issubdtype(found.dtype, numpy.integer):
        raise SceneError(f"{name}: numbers of type {found.dtype}; allowed: whole numbers")
    return found.astype(numpy.int64)


def _warn_of_sizes(x: NDArray[numpy.float64], faces: NDArray[numpy.int64], uv: NDArray[numpy.float64]) -> None:
    """Warns of what scene files warn of: cloth in other units than metres, and such patterns."""
    import numpy
    size = float(numpy.ptp(x, axis=0).max())
    if 30 <= size <= 3000:
        warnings.warn(f"vertices: the cloth is {size:.3g} m large; lengths are in metres", stacklevel=3)
    if uv.shape != (len(x), 2) or faces.ndim != 2 or faces.shape[1] != 3 or not faces.size:
        return  # which add_cloth refuses
    if faces.min() < 0 or faces.max() >= len(x):
        return  # the same
    a, b = faces.ravel(), numpy.roll(faces, -1, axis=1).ravel()
    flat = numpy.linalg.norm(uv[b] - uv[a], axis=1)
    if not (flat > 0).all():
        return  # the same
    stretch = float(numpy.median(numpy.linalg.norm(x[b] - x[a], axis=1) / flat))
    if not 0.8 <= stretch <= 1.25:
        warnings.warn(f"uv: half of its edges start stretched by a factor of {stretch:.3g}; uv is in metres, and "
                      f"uv * {stretch:.3g} would fit", stacklevel=3)


def _pattern(vertices: NDArray[numpy.float64]) -> NDArray[numpy.float64]:
    """(n, 2) A flat start as its own pattern: in the two axes of the plane in which it lies."""
    import numpy
    x = vertices - vertices.mean(axis=0)
    _, sizes, axes = numpy.linalg.svd(x, full_matrices=False)
    if len(sizes) < 3 or sizes[2] > 1e-6 * sizes[0]:
        raise SceneError("uv: None; allowed: (n, 2) metres for cloth that does not start flat")
    if numpy.linalg.det(axes) < 0:
        axes[1] = -axes[1]
    pattern: NDArray[numpy.float64] = x @ axes[:2].T
    return pattern


class Simulation:
    """A running scene. One thread at a time may use it; close() frees its memory.

    device: "auto", "cpu", "cpu:N" or "cuda:0". time: seconds. state_hash: of the bits of the state.
    """

    def __init__(self, scene: Scene, device: str = "auto") -> None:
        """Raises SceneError for a bad scene, DeviceError for a missing device."""
        self._simulation = _weft.Simulation(scene._scene, device, _in_main_thread())

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._simulation.close()

    @property
    def time(self) -> float:
        return self._simulation.time

    @property
    def state_hash(self) -> int:
        return self._simulation.state_hash

    def advance(self, seconds: float, budget: float | None = None) -> bool:
        """Goes on for this time, in steps no longer than the scene's, and returns whether these are done.

        budget: seconds after which no further step begins; False is then returned, and the next call goes on.
        Ctrl-C stops the step under way and raises KeyboardInterrupt; the state is that of its start.
        Raises SimulationError if the simulation cannot go on.
        """
        return self._simulation.advance(seconds, budget, _in_main_thread())

    def positions(self, cloth: ClothId) -> NDArray[numpy.float32]:
        """(n, 3) float32 metres, in the order of the vertices given: a read-only view, which the next call
        for this cloth overwrites. With remeshing and refinement: a copy."""
        _expect(cloth, ClothId, "cloth", "add_cloth()")
        return self._simulation.positions(cloth)

    def device_positions(self, cloth: ClothId, stream: int = 1) -> DeviceArray:
        """The same (n, 3) float32 on the GPU, without a copy to the host: an object for cupy.asarray(),
        torch.as_tensor() and others that take __cuda_array_interface__. The memory is overwritten by the next call
        and goes with the simulation.

        stream: of CUDA, as that interface counts: 1 is the default stream. Its later work finds the positions.
        Raises DeviceError where the simulation runs on the CPU.
        """
        _expect(cloth, ClothId, "cloth", "add_cloth()")
        return self._simulation.device_positions(cloth, stream)

    def move(self, part: ObstacleId | PinId, places: ArrayLike) -> None:
        """Where the vertices of an obstacle or a pin, (n, 3) metres, are to be at the end of the next advance."""
        _expect(part, (ObstacleId, PinId), "part", "add_obstacle() or pin()")
        self._simulation.move(part, places)

    def release(self, pin: PinId) -> None:
        """Lets a pin go."""
        _expect(pin, PinId, "pin", "pin()")
        self._simulation.release(pin)

    def set_gravity(self, gravity: Sequence[float]) -> None:
        """gravity: [x, y, z] in m/s^2"""
        self._simulation.set_gravity(gravity)

    def set_wind(self, velocity: Sequence[float], density: float = 1.2, drag: float = 0.0) -> None:
        """velocity: [x, y, z] in m/s; density: kg/m^3 of the air; drag: along the cloth, kg/(m^2 s)"""
        self._simulation.set_wind(velocity, density, drag)

    def set_forces(self, cloth: ClothId, forces: ArrayLike | None) -> None:
        """Constant forces on the vertices of a cloth, (n, 3) N, from now on; None: no longer."""
        _expect(cloth, ClothId, "cloth", "add_cloth()")
        self._simulation.set_forces(cloth, forces)

    def state(self) -> bytes:
        """The state, and all that has been set, as bytes for restore()."""
        return self._simulation.state()

    def restore(self, state: bytes) -> None:
        """Goes on from such bytes, bit for bit. Raises SceneError if they are damaged or another scene's."""
        self._simulation.restore(state)

    def energy(self) -> dict[str, float]:
        """{"kinetic", "elastic", "gravitational"} in J"""
        return self._simulation.energy()


class Frame:
    """A frame of run(). number: from 1; time: seconds; simulation: what made it, to move things in."""

    def __init__(self, number: int, simulation: Simulation) -> None:
        self.number = number
        self.time = simulation.time
        self.simulation = simulation

    def positions(self, cloth: ClothId) -> NDArray[numpy.float32]:
        """As Simulation.positions(): overwritten by the next frame, so copy() keeps them.
        Raises RuntimeError if the next frame is there already."""
        if self.simulation.time != self.time:
            raise RuntimeError(f"frame {self.number} is over; take its positions before the next frame")
        return self.simulation.positions(cloth)


def run(scene: Scene, seconds: float | None = None, device: str = "auto",
        progress: bool | None = None) -> Iterator[Frame]:
    """Simulates a scene and yields a Frame after each of its frames.

    seconds: default: as many frames as the scene asks for; progress: whether a line on stderr says how far it
    is; default: in a terminal or a notebook.
    """
    if seconds is not None and not 0 < seconds < float("inf"):
        raise SceneError(f"seconds: {seconds}; allowed: a time > 0")
    frames = scene.frames if seconds is None else max(1, round(seconds * scene.frame_rate))
    if progress is None:
        progress = sys.stderr.isatty() or "ipykernel" in sys.modules
    simulation = Simulation(scene, device)  # which the frames keep, also after the last
    for number in range(1, frames + 1):
        simulation.advance(1 / scene.frame_rate)
        if progress:
            end = "\n" if number == frames else ""
            print(f"\rframe {number} of {frames}, {simulation.time:.2f} s", end=end, file=sys.stderr, flush=True)
        yield Frame(number, simulation)


def load(file: str | os.PathLike[str], overrides: Sequence[str] = ()) -> Scene:
    """A Scene from a scene file. overrides: such as ["time.step=0.01"]. Warns as `weft run` does."""
    scene = Scene()
    object.__setattr__(scene, "_scene", _weft.load(str(file), list(overrides)))
    for warning in scene._scene.warnings:
        warnings.warn(warning, stacklevel=2)
    return scene


def sweep(file: str | os.PathLike[str], grid: Mapping[str, Sequence[Any]], seconds: float | None = None,
          device: str = "cpu:1",
          processes: int = 1) -> Iterator[tuple[dict[str, Any], list[NDArray[numpy.float32]]]]:
    """Runs a scene file with every combination of values and yields (values, positions of all cloths at the end).

    grid: such as {"time.step": [0.01, 0.005], "wind.density": [0, 1.2]}; processes: how many at once.
    Runs that are refused or fail are left out. Once all others are done, the first of these errors is raised with
    a count; its attribute `failed` is a list of (values, error).
    """
    for key, each in grid.items():
        if isinstance(each, str) or not hasattr(each, "__iter__"):
            raise SceneError(f"grid: {key}: {each!r}; allowed: a list of values")
    all_values = [dict(zip(grid, each)) for each in itertools.product(*grid.values())]
    failed: list[tuple[dict[str, Any], Exception]] = []
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(processes, context) as pool:
        try:
            runs = collections.deque(
                pool.submit(_last, str(file), [f"{key}={_text(value)}" for key, value in values.items()], seconds,
                            device) for values in all_values)
            for values in all_values:
                one = runs.popleft()  # so that results go once they have been taken
                error = one.exception()
                if error is None:
                    yield values, one.result()
                elif isinstance(error, Exception):
                    failed.append((values, error))
                else:
                    raise error
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
    if failed:
        values, first = failed[0]
        kind = type(first) if isinstance(first, (SceneError, DeviceError, SimulationError)) else RuntimeError
        raised = kind(f"{len(failed)} of {len(all_values)} runs failed, the first with {values}: {first}")
        raised.failed = failed  # type: ignore[attr-defined]
        raise raised


def _text(value: Any) -> str:
    """As --set reads it: texts as they are, all else as JSON."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    return json.dumps(value, default=lambda array: array.tolist())


def _last(file: str, overrides: list[str], seconds: float | None, device: str) -> list[NDArray[numpy.float32]]:
    """Positions of all cloths at the end of one run of sweep()."""
    scene = load(file, overrides)
    for frame in run(scene, seconds, device, progress=False):
        pass
    return [frame.positions(cloth).copy() for cloth in scene.cloths]
