"""Estimates the tiles of a plan of `curv tiles plan` on a Dask cluster; each is a task that runs `curv tiles run DIR --tile=N`.

This module needs Dask's distributed. Workers need no package of ours: only the program curv, and the directory at the same path.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import json
import os
import subprocess
import typing

# Wrong flags, inputs that cannot be read, results that cannot be written: no other try ends better.
_HOPELESS = (2, 3, 4)


class TilesDone(typing.NamedTuple):
    """What run_tiles did: tiles that were not done before and the points in them, and the tasks that this took."""

    tiles: int
    points: int
    tasks: int


class TilesError(Exception):
    """Not all tiles are done; those that are stay so, and another run goes on with the rest.

    tile:      the one that failed; None where none was begun.
    exit_code: of curv; None where it did not run.
    """

    def __init__(self, message: str, tile: int | None = None, exit_code: int | None = None) -> None:
        super().__init__(message)
        self.tile = tile
        self.exit_code = exit_code


def run_tiles(
    directory: str | os.PathLike[str],
    *,
    cluster: typing.Any = None,
    server: str | None = None,
    flags: typing.Sequence[str] = (),
    curv: str = "curv",
    max_attempts: int = 5,
) -> TilesDone:
    """Estimates the tiles of a plan that are not done, and waits for them.

    directory:    the plan's, as this process and all workers see it.
    cluster:      the address of a scheduler ("tcp://host:8786"), or a cluster or client of Dask's; None: threads of this process.
    server:       HOST:PORT of curvd, or several with commas between; None: each task has a server of its own, with one thread.
    flags:        more flags of `curv tiles run`, such as "--ca=/etc/curvd/ca.crt".
    curv:         the program, as this process and all workers find it.
    max_attempts: tasks for a tile before it is given up; one whose worker died is one.

    Raises ImportError without distributed, ValueError for an argument out of range, OSError where no scheduler answers, and
    TilesError.
    """
    distributed = _import_distributed()
    if max_attempts < 1:
        raise ValueError(f"max_attempts is {max_attempts}; it must be at least 1")
    directory = os.path.abspath(directory)
    command = [curv, "tiles", "run", directory, "--summary=json", f"--server={server}" if server else "--threads=1", *flags]
    tiles = _tiles_left(curv, directory)
    with contextlib.ExitStack() as stack:
        client = cluster
        if cluster is None:
            cluster = stack.enter_context(distributed.LocalCluster(processes=False, n_workers=1, dashboard_address=None))
        if not isinstance(cluster, distributed.Client):
            client = stack.enter_context(distributed.Client(cluster))
        done = _run(distributed, client, command, tiles, max_attempts)
    return done


def _import_distributed() -> typing.Any:
    try:
        import distributed
    except ImportError as error:
        raise ImportError(
            "curvd_client.dask needs Dask's distributed: install Debian's python3-distributed, or curvd-client[dask] with pip"
        ) from error
    return distributed


def _tiles_left(curv: str, directory: str) -> list[int]:
    try:
        told = subprocess.run([curv, "tiles", "status", directory, "--left"], capture_output=True, text=True, check=False)
    except OSError as error:
        raise TilesError(f"cannot run {curv}: {error.strerror}") from error
    if told.returncode != 0:
        raise TilesError(told.stderr.strip(), exit_code=told.returncode)
    return [int(line) for line in told.stdout.split()]


def _run(
    distributed: typing.Any, client: typing.Any, command: list[str], tiles: list[int], max_attempts: int
) -> TilesDone:
    attempts = dict.fromkeys(tiles, 0)
    tile_of = {}

    def submit(tile: int) -> typing.Any:
        attempts[tile] += 1
        # A function of Python's own: workers can run it whatever they have installed.
        future = client.submit(
            subprocess.run,
            [*command, f"--tile={tile}"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            pure=False,
        )
        tile_of[future.key] = tile
        return future

    done_tiles = done_points = 0
    pending = distributed.as_completed([submit(tile) for tile in tiles])
    for future in pending:
        tile = tile_of.pop(future.key)
        completed, fault = _outcome_of(distributed, future, tile)
        if completed is not None and completed.returncode == 0:
            outcome = json.loads(completed.stdout)
            done_tiles += outcome["tiles"]
            done_points += outcome["points"]
        elif attempts[tile] < max_attempts and (completed is None or completed.returncode not in _HOPELESS):
            pending.add(submit(tile))
        else:
            raise TilesError(f"tile {tile}: {fault}", tile, None if completed is None else completed.returncode)
    return TilesDone(done_tiles, done_points, sum(attempts.values()))


def _outcome_of(distributed: typing.Any, future: typing.Any, tile: int) -> tuple[typing.Any, str]:
    """What curv ended with, or None where its worker died; and what is wrong, if anything is."""
    try:
        completed = future.result()
    except distributed.KilledWorker as error:
        return None, f"its workers died: {error}"
    except concurrent.futures.CancelledError as error:
        raise TilesError(f"tile {tile}: the scheduler is gone, or somebody cancelled the task", tile) from error
    except Exception as error:  # whatever a worker says, such as that it has no curv
        raise TilesError(f"tile {tile}: {type(error).__name__}: {error}", tile) from error
    return completed, completed.stderr.strip() or f"curv ended with {completed.returncode}"
