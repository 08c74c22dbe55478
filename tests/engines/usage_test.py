#!/usr/bin/python3
"""Starts what runs tiles without arguments: usage_test.py SOURCE_DIR. No engine is needed."""

import pathlib
import subprocess
import sys

for name, words in {"parallel/run.sh": "usage: run.sh DIR HOST:PORT", "slurm/tiles.sbatch": "usage: sbatch --array"}.items():
    script = pathlib.Path(sys.argv[1], "deploy", "engines", name)
    done = subprocess.run(["bash", script], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr.startswith(words)) == (2, True), (name, done)
