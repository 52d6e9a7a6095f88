#!/bin/sh
# usage: notebook.sh NOTEBOOK: runs all of its cells and looks at what they leave. Exit code 77: the
# programs for it are missing.
set -eu
if ! command -v jupyter-nbconvert >/dev/null || ! /usr/bin/python3 -c "import ipykernel, matplotlib" 2>/dev/null; then
  echo "SKIPPED: jupyter-nbconvert, ipykernel or matplotlib is missing; ./dev setup --notebook installs them"
  exit 77
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export JUPYTER_CONFIG_DIR="$folder" JUPYTER_DATA_DIR="$folder" IPYTHONDIR="$folder" MPLCONFIGDIR="$folder"
jupyter-nbconvert --to notebook --execute --log-level WARN --output-dir "$folder" --output run.ipynb "$1"
/usr/bin/python3 - "$folder/run.ipynb" <<'PROGRAM'
import json, sys
outputs = [o for cell in json.load(open(sys.argv[1]))["cells"] for o in cell.get("outputs", [])]
print("".join(o["text"] if isinstance(o["text"], str) else "".join(o["text"]) for o in outputs if "text" in o).strip())
print(sum("image/png" in o.get("data", {}) for o in outputs), "pictures")
PROGRAM
