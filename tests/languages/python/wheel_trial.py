#!/usr/bin/python3
"""Builds the wheel, installs it in an empty folder, and uses it there: wheel_trial.py SOURCE_DIR, with CURVD_SERVER
set.

Runs the Python block of README.md, the one of client/python/README.md, and the command, each from outside the clone and
with nothing of it on the path. Exits with 1 if anything of that fails.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

_PYTHON = "/usr/bin/python3"
_ORIGIN = "import curvd_client, sys; sys.exit(not curvd_client.__file__.startswith(sys.argv[1]))"
_NOTHING_ELSE = "import importlib.util, sys, curvd_client; sys.exit(importlib.util.find_spec('curvature') is not None)"


def python_blocks(document, server):
    """The programs in a document, for `server` in place of the default one."""
    code = re.findall(r"^```python\n(.*?)^```$", document.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert code, f"{document} has no python block"
    return [block.replace("localhost:50061", server).replace('"localhost"', f'"{server}"') for block in code]


def main():
    source, server = pathlib.Path(sys.argv[1]).resolve(), os.environ["CURVD_SERVER"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        clean = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "MAKEFLAGS", "MAKELEVEL")}

        def run(*command, environment=None, output=None):
            return subprocess.run(
                [str(word) for word in command],
                cwd=folder,
                env=environment or clean,
                check=True,
                stdout=output,
                text=True,
            ).stdout

        run("make", "-C", source, "wheel", f"DIST={folder / 'dist'}")
        wheels = list((folder / "dist").glob("curvd_client-*-py3-none-any.whl"))
        assert len(wheels) == 1, wheels
        site = folder / "site"
        offline = ("--quiet", "--no-deps", "--no-index", "--root-user-action=ignore")
        run(_PYTHON, "-m", "pip", "install", *offline, "--target", site, wheels[0])

        installed = {**clean, "PYTHONPATH": str(site), "COLUMNS": "100"}
        run(_PYTHON, "-c", _ORIGIN, site, environment=installed)
        run(_PYTHON, "-c", _NOTHING_ELSE, environment=installed)
        for document in (source / "README.md", source / "client" / "python" / "README.md"):
            for block in python_blocks(document, server):
                printed = run(_PYTHON, "-c", block, environment=installed, output=subprocess.PIPE)
                assert abs(float(printed.split()[0]) - 0.5) < 0.01, printed

        command = site / "bin" / "curvd-client"
        state = run(_PYTHON, command, "health", f"--server={server}", environment=installed, output=subprocess.PIPE)
        assert state == "SERVING\n", state
        version = run(_PYTHON, command, "--version", environment=installed, output=subprocess.PIPE)
        assert wheels[0].name.split("-")[1] == version.split()[1], (wheels[0].name, version)
    print("the wheel works in an empty folder")


if __name__ == "__main__":
    main()
