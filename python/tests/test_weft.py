"""The Python package as its users use it. PYTHONPATH names the folder of the built package."""
import ctypes
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest

import weft

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"


def grid(n=8, size=0.4, height=0.3):
    side = numpy.linspace(-size / 2, size / 2, n + 1)
    x, y = numpy.meshgrid(side, side)
    vertices = numpy.stack([x.ravel(), y.ravel(), numpy.full(x.size, height)], axis=1)
    corner = (numpy.arange(n)[:, None] * (n + 1) + numpy.arange(n)).ravel()
    a, b, c, d = corner, corner + 1, corner + n + 2, corner + n + 1
    return vertices, numpy.concatenate([numpy.stack([a, b, c], 1), numpy.stack([a, c, d], 1)])


def sheet_over_plate():
    scene = weft.Scene()
    vertices, faces = grid()
    plate = scene.add_obstacle(*grid(4, 0.8, 0.0))
    sheet = scene.add_cloth(vertices, faces, fabric="denim")
    corners = scene.pin(sheet, [0, 8])
    return scene, sheet, plate, corners


@pytest.mark.parametrize("fabric", ["silk", "cotton", "denim", "wool", "leather", "jersey", "paper"])
def test_takes_fabrics_by_name(fabric):
    scene = weft.Scene()
    scene.add_cloth(*grid(), fabric=fabric)


def test_runs_frames_and_gives_views():
    scene, sheet, _, _ = sheet_over_plate()
    vertices, _ = grid()
    heights = []
    for frame in weft.run(scene, seconds=0.2, device="cpu:1"):
        x = frame.positions(sheet)
        assert x.shape == vertices.shape and x.dtype == numpy.float32
        assert not x.flags.owndata and not x.flags.writeable
        heights.append(x[:, 2].mean())
    assert frame.number == 5 and frame.time == pytest.approx(0.2)
    assert (numpy.diff(heights) < 0).all(), "it does not fall"
    numpy.testing.assert_array_equal(x[[0, 8]], vertices[[0, 8]].astype(numpy.float32))
    frame.simulation.close()
    x.sum()  # the view keeps its memory


def test_moves_bodies_and_pins_and_repeats_states():
    scene, sheet, plate, corners = sheet_over_plate()
    places, _ = grid(4, 0.8, 0.0)
    simulation = weft.Simulation(scene, "cpu:1")
    start = simulation.state()
    hashes = []
    for _ in range(2):
        simulation.restore(start)
        for f in range(1, 6):
            simulation.move(plate, places + [0, 0, 0.02 * f])
            simulation.move(corners, grid()[0][[0, 8]] + [0, 0.02 * f, 0])
            simulation.set_wind([0, 1, 0])
            assert simulation.advance(1 / 25)
        hashes.append(simulation.state_hash)
        numpy.testing.assert_allclose(simulation.positions(sheet)[[0, 8], 1], grid()[0][[0, 8], 1] + 0.1, atol=1e-6)
    assert hashes[0] == hashes[1]
    simulation.release(corners)
    simulation.set_gravity([0, 0, -1])
    assert not simulation.advance(1 / 25, budget=0)
    assert set(simulation.energy()) == {"kinetic", "elastic", "gravitational"}


def test_forces_lift_what_they_carry():
    scene, sheet, _, corners = sheet_over_plate()
    simulation = weft.Simulation(scene, "cpu:1")
    simulation.release(corners)
    n = len(grid()[0])
    weight = 0.4 * 0.4 * weft_density(simulation) * 9.81
    simulation.set_forces(sheet, numpy.full((n, 3), [0, 0, 2 * weight / n]))
    simulation.advance(1 / 25)
    assert simulation.positions(sheet)[:, 2].mean() > 0.3
    with pytest.raises(weft.SceneError, match="cloths.0. .*: 3 forces; allowed: 81, one for each"):
        simulation.set_forces(sheet, numpy.zeros((3, 3)))
    simulation.set_forces(sheet, None)


def weft_density(simulation):
    """[kg/m^2] from the energy: the sheet of 0.4 x 0.4 m hangs at 0.3 m."""
    return simulation.energy()["gravitational"] / (0.3 * 9.81 * 0.4 * 0.4)


def test_device_positions_are_there_on_a_gpu():
    scene, sheet, _, _ = sheet_over_plate()
    with weft.Simulation(scene, "cpu:1") as simulation:
        with pytest.raises(weft.DeviceError, match="runs on the CPU; use positions"):
            simulation.device_positions(sheet)
    try:
        simulation = weft.Simulation(scene, "cuda:0")
    except weft.DeviceError as error:
        pytest.skip(f"no GPU: {error}")
    simulation.advance(1 / 25)
    array = simulation.device_positions(sheet)
    interface = array.__cuda_array_interface__
    assert interface["shape"] == (81, 3) and interface["typestr"] == "<f4" and array.gpu == 0
    copied = numpy.empty((81, 3), dtype=numpy.float32)
    driver = ctypes.CDLL("libcuda.so.1")
    assert driver.cuMemcpyDtoH_v2(copied.ctypes.data_as(ctypes.c_void_p), ctypes.c_uint64(interface["data"][0]),
                                  ctypes.c_size_t(copied.nbytes)) == 0
    numpy.testing.assert_array_equal(copied, simulation.positions(sheet))


def test_numbers_that_are_no_indices_are_refused():
    scene = weft.Scene()
    vertices, faces = grid()
    with pytest.raises(weft.SceneError, match="faces: numbers of type float64; allowed: whole"):
        scene.add_cloth(vertices, faces + 0.5, fabric="denim")
    broken = vertices.copy()
    broken[7, 1] = numpy.nan
    for add in (scene.add_cloth, scene.add_obstacle):
        with pytest.raises(weft.SceneError, match=r"vertices\[7\]: .*nan.*; allowed: finite"):
            add(broken, faces)
        with pytest.raises(weft.SceneError, match=r"vertices: shape \(0, 3\)"):
            add(numpy.empty((0, 3)), faces)
    sheet = scene.add_cloth(vertices, faces, fabric="denim")
    for chosen in ([0.5, 8], vertices[:, 0] < 0):
        with pytest.raises(weft.SceneError, match="vertices: numbers of type (float64|bool)"):
            scene.pin(sheet, chosen)
    scene.pin(sheet, numpy.flatnonzero(vertices[:, 0] < -0.19))


def test_sizes_that_are_no_metres_are_told():
    vertices, faces = grid()
    with pytest.warns(UserWarning, match="uv: half of its edges start stretched by a factor of 0.01"):
        weft.Scene().add_cloth(vertices, faces, uv=100 * vertices[:, :2], fabric="denim")
    with pytest.warns(UserWarning, match="vertices: the cloth is 40 m large; lengths are in metres"):
        weft.Scene().add_cloth(100 * vertices, faces, fabric="denim")


def test_frames_that_are_over_are_refused():
    scene, sheet, _, _ = sheet_over_plate()
    frames = list(weft.run(scene, seconds=0.08, device="cpu:1"))
    frames[1].positions(sheet)
    with pytest.raises(RuntimeError, match="frame 1 is over; take its positions before the next frame"):
        frames[0].positions(sheet)
    for seconds in (0, -1, float("nan")):
        with pytest.raises(weft.SceneError, match="seconds: .*; allowed: a time > 0"):
            next(weft.run(scene, seconds=seconds))


def test_thickness_follows_fine_meshes():
    scene = weft.Scene()
    assert scene.thickness is None
    scene.thickness = 0.002
    assert scene.thickness == 0.002


def test_cloth_without_uv_has_the_flat_start_as_its_pattern():
    vertices, faces = grid()
    turn = numpy.linalg.qr(numpy.random.default_rng(1).normal(size=(3, 3)))[0]
    energies = []
    for v in (vertices, vertices @ turn.T):
        scene = weft.Scene()
        scene.add_cloth(v, faces, fabric="denim")
        scene.gravity = [0, 0, 0]
        with weft.Simulation(scene, "cpu:1") as simulation:
            simulation.advance(1 / 25)
            energies.append(simulation.energy()["elastic"])
    assert max(energies) < 1e-9
    with pytest.raises(weft.SceneError, match="does not start flat"):
        weft.Scene().add_cloth(vertices + numpy.random.default_rng(1).normal(size=vertices.shape), faces)


@pytest.mark.parametrize("call, words", [
    (lambda s, w, c: w.add_cloth(numpy.zeros((5, 2)), [[0, 1, 2]], uv=numpy.zeros((5, 2))), r"vertices: shape \(5, 2\)"),
    (lambda s, w, c: w.add_cloth(numpy.zeros((5, 3)), [[0, 1, 5]], uv=numpy.zeros((5, 2))), "faces: 5; .* 0 to 5"),
    (lambda s, w, c: w.add_cloth(*grid(), uv=numpy.zeros((5, 2))), r"uv: shape \(5, 2\)"),
    (lambda s, w, c: w.add_cloth(*grid(), fabric="velcro"), "velcro.*denim"),
    (lambda s, w, c: w.pin(sheet_over_plate()[1], [0]), "another scene"),
    (lambda s, w, c: s.move(sheet_over_plate()[2], numpy.zeros((25, 3))), "another scene"),
    (lambda s, w, c: s.move(c, numpy.zeros((25, 3))), "25 places; .* 2, one for each"),
    (lambda s, w, c: s.move(c, [[0, 0, 0], [0, float("nan"), 0]]), "vertex 1: nan"),
    (lambda s, w, c: w.pin(c, [0]), r"cloth: PinId\(0\); .* add_cloth"),
    (lambda s, w, c: s.move(7, [[0, 0, 0]]), "part: 7; .* add_obstacle"),
    (lambda s, w, c: s.advance(0), "a time from 1e-9 s"),
    (lambda s, w, c: s.restore(b"nonsense"), "does not begin with WEFT"),
    (lambda s, w, c: weft.Simulation(w, "cpu:many"), "cpu:many"),
    (lambda s, w, c: weft.load("nowhere.json"), "nowhere.json"),
])
def test_misuse_has_one_line(call, words):
    scene, _, _, corners = sheet_over_plate()
    simulation = weft.Simulation(scene, "cpu:1")
    with pytest.raises(weft.SceneError, match=words) as caught:
        call(simulation, scene, corners)
    assert "\n" not in str(caught.value)


def test_misspelt_settings_are_refused():
    with pytest.raises(AttributeError, match="time_step"):
        weft.Scene().timestep = 0.01


def test_use_after_close_and_by_two_threads():
    scene, sheet, _, _ = sheet_over_plate()
    simulation = weft.Simulation(scene, "cpu:1")
    failures = []

    def advance():
        try:
            simulation.advance(4)
        except RuntimeError as error:
            failures.append(str(error))

    threads = [threading.Thread(target=advance) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == ["the simulation is in use by another thread; allowed: one at a time"]
    simulation.close()
    with pytest.raises(RuntimeError, match="closed"):
        simulation.positions(sheet)


def test_interrupt_stops_a_step_and_leaves_a_valid_state():
    program = """
import sys; sys.path.insert(0, %r)
import test_weft, weft
scene, sheet, _, _ = test_weft.sheet_over_plate()
simulation = weft.Simulation(scene, "cpu:1")
print("ready", flush=True)
try:
    simulation.advance(4000)
except KeyboardInterrupt:
    before = simulation.time
    simulation.advance(4000, budget=0)  # one step more of the same frame
    print("stopped", simulation.time > before)
""" % str(pathlib.Path(__file__).parent)
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.3)
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=20)
    assert out == "stopped True\n" and child.returncode == 0


def test_scene_files_and_sweeps():
    scene = weft.load(SCENES / "swing.json", ["triangles=100"])
    assert len(scene.cloths) == 1
    ends = list(weft.sweep(SCENES / "swing.json", {"triangles": [100], "time.step": [0.02, 0.01]}, seconds=0.1,
                           processes=2))
    assert [values["time.step"] for values, _ in ends] == [0.02, 0.01]
    difference = numpy.abs(ends[0][1][0] - ends[1][1][0]).max()
    assert 0 < difference < 0.02


def test_scene_files_warn():
    with pytest.warns(UserWarning, match="^time.step: 5 s is longer than a frame"):
        weft.load(SCENES / "swing.json", ["triangles=100", "time.step=5"])


def test_a_sweep_accounts_for_every_run():
    grid = {"triangles": [100, -5, 100], "model.bending": [False], "wind.velocity": [(0, 0, 0)],
            "time.step": numpy.array([0.02])}
    ends = []
    with pytest.raises(weft.SceneError, match="1 of 3 runs failed, the first with .*'triangles': -5.* allowed: ") as raised:
        ends.extend(weft.sweep(SCENES / "swing.json", grid, seconds=0.04))
    assert len(ends) == 2 and len(raised.value.failed) == 1
    numpy.testing.assert_array_equal(ends[0][1][0], ends[1][1][0])
    for values in ("12", 12):
        with pytest.raises(weft.SceneError, match="grid: time.frames: .* allowed: a list of values"):
            list(weft.sweep(SCENES / "swing.json", {"time.frames": values}))


KILLED = """
import os, signal, threading, time
import weft
def kill_a_worker():
    while True:
        for process in os.listdir("/proc"):
            try:
                stat = open(f"/proc/{process}/stat").read().rsplit(")", 1)[1].split()
                line = open(f"/proc/{process}/cmdline").read()
            except OSError:
                continue
            if int(stat[1]) == os.getpid() and "spawn_main" in line:
                os.kill(int(process), signal.SIGKILL)
                return
        time.sleep(0.01)
if __name__ == "__main__":
    threading.Thread(target=kill_a_worker).start()
    try:
        list(weft.sweep("SCENE", {"triangles": [100, 120]}))
    except RuntimeError as error:
        print(len(error.failed))
"""


def test_a_sweep_whose_process_is_killed_ends(tmp_path):
    script = tmp_path / "killed.py"
    script.write_text(KILLED.replace("SCENE", str(SCENES / "swing.json")))
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60)
    assert done.stdout == "2\n", done.stderr


def write_tube(folder, lift):
    """A run of two panels that are sewn along both sides, above a triangle."""
    frames = folder / "frames"
    frames.mkdir(exist_ok=True)
    for number, height in enumerate((0.0, lift)):
        lines = ["o tube"]
        for y, sign in ((0.1, 1), (-0.1, -1)):  # the sides of the panels are at y = 0
            for x, depth in ((-1, 0), (0, y), (1, 0)):
                lines += [f"v {x} {depth} {z + height}" for z in (0, 1)]
        lines += [f"vt {u} {v}" for _ in range(2) for u in (0, 1.5, 3) for v in (0, 1)]
        lines.append("# panel front leg")
        for name, first in (("front", 1), ("back", 7)):
            lines.append(f"g {name}")
            for k in (first, first + 2):
                for corners in ((k, k + 2, k + 3), (k, k + 3, k + 1)):
                    lines.append("f " + " ".join(f"{c}/{c}" for c in corners))
        (frames / f"cloth_0000{number}.obj").write_text("\n".join(lines) + "\n")
    (frames / "obstacle.obj").write_text("o body\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")


def test_garments_are_one_mesh_with_panels_and_seams(tmp_path):
    write_tube(tmp_path, 0.5)
    (garment,) = weft.garments(tmp_path)
    assert garment.name == "tube" and garment.frame == 1
    assert garment.vertices.shape == (8, 3) and garment.faces.shape == (8, 3)
    assert garment.uv.shape == (12, 2) and garment.faces_uv.max() == 11
    numpy.testing.assert_array_equal(garment.rest[:, :2], garment.uv)
    numpy.testing.assert_array_equal(garment.vertices - garment.start, [[0, 0, 0.5]] * 8)
    assert [garment.panel_names[k] for k in garment.panels] == ["front"] * 4 + ["back"] * 4
    assert garment.panel_labels == ["leg", ""]
    ends = garment.vertices[garment.seam_edges]
    assert sorted(ends[:, :, 0].mean(axis=1)) == [-1, 1] and (ends[:, :, 1] == 0).all()
    assert garment.body_vertices.shape == (3, 3) and garment.body_faces.tolist() == [[0, 1, 2]]
    garment.save(tmp_path / "tube.npz")
    with numpy.load(tmp_path / "tube.npz", allow_pickle=False) as file:
        for key in ("vertices", "faces", "uv", "faces_uv", "rest", "start", "panels", "seam_edges", "body_vertices"):
            numpy.testing.assert_array_equal(file[key], getattr(garment, key))
        assert file["panel_names"].tolist() == ["front", "back"] and file["panel_labels"].tolist() == ["leg", ""]


def test_garments_of_a_frame_that_is_not_there(tmp_path):
    write_tube(tmp_path, 0.5)
    assert weft.garments(tmp_path, 0)[0].frame == 0
    with pytest.raises(weft.SceneError, match="frame: 7; allowed: one of the 2 frames from 0 to 1"):
        weft.garments(tmp_path, 7)
    with pytest.raises(weft.SceneError):
        weft.garments(tmp_path / "nothing")
