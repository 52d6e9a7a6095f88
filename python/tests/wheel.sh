#!/bin/sh
# usage: wheel.sh PYTHON BUILT: makes a wheel of the built package, installs it into a fresh
# environment without a network, and drapes a sheet with it.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$2"
"$1" -W ignore setup.py --quiet bdist_wheel --bdist-dir "$folder/parts" --dist-dir "$folder" >"$folder/log" 2>&1 ||
  { cat "$folder/log"; exit 1; }
"$1" -m venv --system-site-packages "$folder/venv"
"$folder/venv/bin/pip" install --quiet --no-index --disable-pip-version-check "$folder"/weft-*.whl
cd "$folder"
env -u PYTHONPATH "$folder/venv/bin/python" - <<'PROGRAM'
import numpy, weft
side = numpy.linspace(-0.2, 0.2, 3)
x, y = numpy.meshgrid(side, side)
scene = weft.Scene()
sheet = scene.add_cloth(numpy.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), [[0, 1, 4], [0, 4, 3]] + [
    [1, 2, 5], [1, 5, 4], [3, 4, 7], [3, 7, 6], [4, 5, 8], [4, 8, 7]], fabric="denim")
scene.pin(sheet, [0])
for frame in weft.run(scene, seconds=0.2):
    pass
print(weft.__version__, "fell", frame.positions(sheet)[8, 2] < -0.05)
PROGRAM
