"""Dressed garments from the frames of a run, as arrays."""

from __future__ import annotations

import dataclasses
import os
from typing import TYPE_CHECKING, Any

from weft import _weft

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray


@dataclasses.dataclass(frozen=True, eq=False)
class Garment:
    """A garment as one mesh: vertices that sewing has brought to one place are one. SI units, z up.

    name; frame: number. vertices: (n, 3) draped; faces: (m, 3).
    uv: (k, 2) metres, the flat pattern, each panel in its own coordinates; faces_uv: (m, 3) rows of uv and rest.
    A vertex on a seam has a row for each of its panels. Without a pattern, k is 0.
    rest: (k, 3) the same pattern as points in space, with z = 0; start: (n, 3) places in frame 0, empty if the run has none.
    panels: (m,) number of each face's panel in panel_names and panel_labels, the latter "" where the pattern has none.
    seam_edges: (e, 2) vertices of edges along which panels, or the sides of a dart, are sewn together.
    body_vertices: (b, 3), body_faces: (c, 3): all obstacles in this frame.
    """

    name: str
    frame: int
    vertices: NDArray[numpy.float64]
    faces: NDArray[numpy.int64]
    uv: NDArray[numpy.float64]
    faces_uv: NDArray[numpy.int64]
    rest: NDArray[numpy.float64]
    start: NDArray[numpy.float64]
    panels: NDArray[numpy.int32]
    panel_names: list[str]
    panel_labels: list[str]
    seam_edges: NDArray[numpy.int64]
    body_vertices: NDArray[numpy.float64]
    body_faces: NDArray[numpy.int64]

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes a compressed .npz with an array per field. numpy.load(file) reads it, without pickle."""
        import numpy
        arrays: dict[str, Any] = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        for key in ("panel_names", "panel_labels"):
            arrays[key] = numpy.asarray(arrays[key], dtype=numpy.str_)
        numpy.savez_compressed(file, **arrays)


def garments(run: str | os.PathLike[str], frame: int | None = None) -> list[Garment]:
    """The cloths of a run as they hang in one of its frames.

    run: directory of `weft run`; frame: default: the last. Raises SceneError if there is no such frame.
    """
    numbers = _weft.frame_numbers(str(run))
    number = numbers[-1] if frame is None else frame
    meshes = _weft.load_frame(str(run), number)
    cloths = [mesh for mesh in meshes if not mesh["obstacle"]]
    body = _joined([mesh for mesh in meshes if mesh["obstacle"]])
    first = [mesh for mesh in _weft.load_frame(str(run), 0) if not mesh["obstacle"]] if numbers[0] == 0 else []
    if [len(mesh["vertices"]) for mesh in first] != [len(mesh["vertices"]) for mesh in cloths]:
        first = []
    return [_garment(mesh, number, first[k]["vertices"] if first else None, *body) for k, mesh in enumerate(cloths)]


def _joined(meshes: list[dict[str, Any]]) -> tuple[NDArray[numpy.float64], NDArray[numpy.int64]]:
    """(b, 3) vertices, (c, 3) faces of all of them."""
    import numpy
    vertices, faces, count = [numpy.zeros((0, 3))], [numpy.zeros((0, 3), dtype=numpy.int64)], 0
    for mesh in meshes:
        vertices.append(mesh["vertices"])
        faces.append(mesh["faces"] + count)
        count += len(mesh["vertices"])
    return numpy.concatenate(vertices), numpy.concatenate(faces)


def _garment(mesh: dict[str, Any], number: int, start: NDArray[numpy.float64] | None,
             body_vertices: NDArray[numpy.float64], body_faces: NDArray[numpy.int64]) -> Garment:
    import numpy
    x, before, uv = mesh["vertices"], mesh["faces"], mesh["uv"]
    _, first, inverse = numpy.unique(x, axis=0, return_index=True, return_inverse=True)
    order = numpy.argsort(first)  # vertices keep their order
    welded = numpy.empty(len(order), dtype=numpy.int64)
    welded[order] = numpy.arange(len(order))
    welded = welded[inverse.reshape(-1)]
    count = len(order)
    begin = numpy.zeros((0, 3))
    if start is not None:  # the mean of the vertices that have become one
        begin = numpy.zeros((count, 3))
        numpy.add.at(begin, welded, start)
        begin /= numpy.bincount(welded, minlength=count)[:, None]
    faces = welded[before]
    labels = mesh["panel_labels"] or [""] * len(mesh["panel_names"])
    panels, names = mesh["panels"], mesh["panel_names"]
    if len(panels) != len(faces):
        panels, names, labels = numpy.zeros(len(faces), dtype=numpy.int32), [mesh["name"]], [""]
    return Garment(mesh["name"], number, x[first[order]], faces, uv,
                   mesh["faces_uv"] if len(uv) else numpy.zeros((len(faces), 3), dtype=numpy.int64),
                   numpy.column_stack([uv, numpy.zeros(len(uv))]), begin, panels, names, labels,
                   _seam_edges(before, faces), body_vertices, body_faces)


def _seam_edges(before: NDArray[numpy.int64], faces: NDArray[numpy.int64]) -> NDArray[numpy.int64]:
    """(e, 2) Edges at which faces meet that had no common edge before their vertices became one."""
    import numpy

    def edges(f: NDArray[numpy.int64]) -> NDArray[numpy.int64]:
        return numpy.sort(numpy.stack([f, numpy.roll(f, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)

    both = numpy.unique(numpy.concatenate([edges(faces), edges(before)], axis=1), axis=0)
    found, counts = numpy.unique(both[:, :2], axis=0, return_counts=True)
    seams: NDArray[numpy.int64] = found[counts > 1]
    return seams


