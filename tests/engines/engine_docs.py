#!/usr/bin/python3
"""Types what deploy/engines/ENGINE/README.md and docs/scale.md say of an engine: engine_docs.py SOURCE_DIR BUILD_DIR ENGINE

The README's blocks `sh`, and those of docs/scale.md that are `sh ENGINE`, run as on a built clone with curv on the path, each in
at most five commands, and the result has the bytes of one estimate. Exits with 77 where the engine is not installed.
"""

import contextlib
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "fault"), str(HERE.parent / "docs")]

import engines
import slurm_site
from curvd_process import Curvd
from snippets import blocks

MOST_COMMANDS = 5
POINTS = 10_000
BLOCK_SECONDS = 240
MISSING = {"parallel": engines.Parallel.missing, "dask": engines.Dask.missing, "slurm": engines.Slurm.missing}


def commands_of(code):
    return [line for line in code.splitlines() if line.strip() and not line.startswith("#")]


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def type_block(code, folder, environment):
    """Runs it; ends what it left in the background."""
    shell = subprocess.Popen(["bash", "-euo", "pipefail", "-c", code], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                             start_new_session=True)
    try:
        return shell.wait(BLOCK_SECONDS)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(shell.pid, signal.SIGKILL)


def try_block(code, build_dir, folder, servers, environment):
    commands = commands_of(code)
    assert len(commands) <= MOST_COMMANDS, f"{len(commands)} commands: {code}"
    for default, own in {"localhost:50061": servers[0].address, "localhost:50062": servers[1].address}.items():
        code = code.replace(default, own)
    code = code.replace("8786", str(free_port()))
    assert type_block(code, folder, environment) == 0, code
    result = (folder / "curvature.ply").read_bytes()
    assert result == (folder / "whole.ply").read_bytes(), "tiles and whole cloud have other bytes"
    left = subprocess.run([build_dir / "bin" / "curv", "tiles", "status", "work", "--left"], cwd=folder, check=True, capture_output=True)
    assert left.stdout == b""
    subprocess.run(["rm", "-r", "work", "curvature.ply"], cwd=folder, check=True)
    print(f"--- ran {len(commands)} commands:\n{code}", flush=True)


def main():
    source_dir, build_dir, engine = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
    missing = MISSING[engine]()
    if missing:
        print(f"skipped: no {missing}")
        sys.exit(77)
    told = [code for kind, code in blocks(source_dir / "deploy" / "engines" / engine / "README.md") if kind == "sh"]
    told += [code for kind, code in blocks(source_dir / "docs" / "scale.md") if kind == f"sh {engine}"]
    assert len(told) == 2, f"{len(told)} blocks tell of {engine}"
    with contextlib.ExitStack() as stack:
        folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="curv-engine-")))
        (folder / "deploy").symlink_to(source_dir.resolve() / "deploy")
        servers = [stack.enter_context(Curvd(str(build_dir / "bin" / "curvd"), "--threads=1")) for _ in range(2)]
        environment = {**os.environ, "PATH": f"{build_dir}/bin:/usr/bin:{os.environ['PATH']}", "PYTHONPATH": f"{build_dir}/python"}
        for command in (f"generate goursat --points={POINTS} --noise-normal=0.1 -o large.ply", "estimate large.ply -o whole.ply --threads=1"):
            subprocess.run([build_dir / "bin" / "curv", *command.split()], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        if engine == "slurm":
            site = folder / "slurm"
            site.mkdir()
            environment |= stack.enter_context(slurm_site.SlurmSite(site)).environment
        for code in told:
            try_block(code, build_dir, folder, servers, environment)


if __name__ == "__main__":
    main()
