#!/usr/bin/python3
"""Estimates clouds whole and in tiles, compares every byte, and tells what the tiles cost.

  bench/tiles_trial.py BUILD [--points=N] [--shapes=torus,terrain] [--scalars=float,double] [--estimators=NAME,...]
                       [--tile-points=N,...] [--halo=FACTOR,...] [--memory=SIZE] [--memory-limit=SIZE] [--no-whole]

A build is the folder of `cmake --preset bench` or `cmake --preset release`. The torus has points that are up to 20 times
denser at its inner rim than at its outer one; the terrain was seen by a scanner in its middle, so that density falls with
the square of the distance, 900 times from the first meter to the last. Doubles lie far from zero, as national grids do.

The whole cloud goes to a curvd once for each estimator, and so do the tiles of each size and halo. Of floats the result
of the tiles is compared with that of the whole file. Of doubles, which a plan rounds to a lattice, results are compared
with those of tiles that are twice as large as the largest, with a halo of 2. Times for each point are CPU seconds of a
process and the kernel's work for it, which other programs disturb little. A row tells:

  different    bytes that differ, of the points' results
  halo %       points that went along with the tiles, of the cloud's
  again %      points that were sent to estimate some a second time, of the cloud's
  uncertain %  points whose first estimate was not certain, of the cloud's
  seconds      wall time of plan, run and merge together
  plan, driver and merge us/point, and MB: what `curv tiles plan`, `run` and `merge` took on this side, and their largest
               resident memory
  server us/point, and of whole: what curvd took, and how often that of the untiled cloud

Exits with 1 if a byte differs. --no-whole compares the tiles of all sizes and halos with each other alone: for clouds that
are too large to be estimated whole.
"""

import argparse
import filecmp
import json
import multiprocessing
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

BLOCK = 1 << 20
PROPERTIES = ("x", "y", "z", "nx", "ny", "nz")
ORIGIN = (432_000.0, 5_300_000.0, 800.0)  # of doubles


def torus(count, rng):
    """Points of a torus that is denser inside, and its normals."""
    tube = 2.0 * np.pi * rng.random(count) ** 1.5
    ring = 2.0 * np.pi * rng.random(count)
    radius = 6.0 + 2.0 * np.cos(np.pi + tube)
    normals = np.stack([np.cos(np.pi + tube) * np.cos(ring), np.cos(np.pi + tube) * np.sin(ring), np.sin(np.pi + tube)], 1)
    points = np.stack([radius * np.cos(ring), radius * np.sin(ring), 2.0 * np.sin(np.pi + tube)], 1)
    return points, normals


def terrain(count, rng):
    """Points of hills whose density falls with the square of the distance from the middle, 1 to 30 away from it."""
    distance = 30.0 ** rng.random(count)
    angle = 2.0 * np.pi * rng.random(count)
    x, y = distance * np.cos(angle), distance * np.sin(angle)
    z = 0.6 * np.sin(x / 2.0) * np.cos(y / 3.0)
    slope_x = 0.3 * np.cos(x / 2.0) * np.cos(y / 3.0)
    slope_y = -0.2 * np.sin(x / 2.0) * np.sin(y / 3.0)
    normals = np.stack([-slope_x, -slope_y, np.ones(count)], 1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.stack([x, y, z], 1), normals


def write_cloud(path, shape, scalar, count):
    """Writes a binary PLY, a block of points at a time, in random order and with a little noise."""
    rng = np.random.default_rng(18)
    kind = "<f4" if scalar == "float" else "<f8"
    header = "".join(f"property {scalar} {name}\n" for name in PROPERTIES)
    with path.open("wb") as file:
        file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{header}end_header\n".encode())
        for first in range(0, count, BLOCK):
            points, normals = SHAPES[shape](min(BLOCK, count - first), rng)
            points += rng.normal(scale=2e-4, size=points.shape)
            normals += rng.normal(scale=0.02, size=points.shape)
            if scalar == "double":
                points += ORIGIN
            file.write(np.hstack([points, normals]).astype(kind).tobytes())


SHAPES = {"torus": torus, "terrain": terrain}


def run(*command):
    """Runs a program to its end; returns what it printed, its CPU seconds and its largest resident MB."""
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True)
    text = process.stdout.read()
    process.stdout.close()
    _, code, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(code)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}: exit code {process.returncode}")
    return text, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


class Server:
    """A curvd of its own, so that its CPU seconds are those of one estimate."""

    def __init__(self, bin_folder, memory_limit):
        flags = ["--listen=127.0.0.1:0", "--metrics-listen=none", "--max-points=2000000000"]
        if memory_limit:
            flags.append(f"--memory-limit={memory_limit}")
        self.process = subprocess.Popen([bin_folder / "curvd", *flags], stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            found = re.search(r"127\.0\.0\.1:([1-9][0-9]*)", line)
            if found:
                self.address = f"127.0.0.1:{found[1]}"
                return
        raise SystemExit("curvd did not start")

    def end(self):
        """Returns its CPU seconds and its largest resident MB."""
        self.process.terminate()
        self.process.stderr.read()
        _, _, usage = os.wait4(self.process.pid, 0)
        self.process.returncode = 0
        return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


def different_bytes(a, b):
    """How many bytes of two files differ; all of them where they have other lengths."""
    if filecmp.cmp(a, b, shallow=False):
        return 0
    if a.stat().st_size != b.stat().st_size:
        return max(a.stat().st_size, b.stat().st_size)
    left, right = np.memmap(a, np.uint8, "r"), np.memmap(b, np.uint8, "r")
    return sum(int(np.count_nonzero(left[i:i + BLOCK] != right[i:i + BLOCK])) for i in range(0, len(left), BLOCK))


class Trial:
    """One cloud, one estimator: whole, and in tiles."""

    def __init__(self, flags, folder, cloud, scalar, estimator):
        self.flags, self.folder, self.cloud, self.scalar = flags, folder, cloud, scalar
        self.options = [f"--estimator={estimator}", "--quantities=mean,gaussian,k1,k2,radius"]
        self.bin = pathlib.Path(flags.build) / "bin"

    def per_point(self, seconds):
        return 1e6 * seconds / self.flags.points

    def whole(self, out):
        """Estimates the file whole; returns the server's CPU seconds."""
        server = Server(self.bin, None)
        run(self.bin / "curv", "estimate", self.cloud, "-o", out, f"--server={server.address}", *self.options)
        return server.end()[0]

    def tiled(self, out, tile_points, halo):
        """Plans, runs, merges; returns what a row tells, by column."""
        work = self.folder / "work"
        shutil.rmtree(work, ignore_errors=True)
        curv = self.bin / "curv"
        begin = time.monotonic()
        _, plan, plan_mb = run(curv, "tiles", "plan", self.cloud, "-o", work, f"--tile-points={tile_points}",
                               f"--memory={self.flags.memory}", *self.options)  # fmt: skip
        server = Server(self.bin, self.flags.memory_limit)
        text, driver, run_mb = run(curv, "tiles", "run", work, f"--server={server.address}", f"--halo={halo}",
                                   "--summary=json")  # fmt: skip
        served, server_mb = server.end()
        _, merge, merge_mb = run(curv, "tiles", "merge", work, "-o", out)
        seconds = time.monotonic() - begin
        outcome = json.loads(text)
        store = sum(file.stat().st_size for file in work.rglob("*") if file.is_file())
        shutil.rmtree(work)
        percent = 100.0 / outcome["points"]
        return {
            "tiles": outcome["tiles"],
            "halo %": percent * outcome["halo_points"],
            "again %": percent * outcome["repair_points"],
            "uncertain %": percent * outcome["uncertain_points"],
            "seconds": seconds,
            "plan us/point": self.per_point(plan),
            "driver us/point": self.per_point(driver),
            "merge us/point": self.per_point(merge),
            "server us/point": self.per_point(served),
            "plan MB": plan_mb,
            "run MB": run_mb,
            "merge MB": merge_mb,
            "server MB": server_mb,
            "directory MB": store / 1e6,
        }


def trials(flags, folder):
    """Yields a row for each cloud, estimator, size of tiles and halo."""
    for shape in flags.shapes:
        for scalar in flags.scalars:
            cloud = folder / f"{shape}-{scalar}.ply"
            # In a process of its own: a program that this one starts counts this one's memory as its own.
            writer = multiprocessing.Process(target=write_cloud, args=(cloud, shape, scalar, flags.points))
            writer.start()
            writer.join()
            if writer.exitcode != 0:
                raise SystemExit("the cloud could not be written")
            for estimator in flags.estimators:
                trial = Trial(flags, folder, cloud, scalar, estimator)
                wanted, out = folder / "wanted.ply", folder / "tiled.ply"
                wanted.unlink(missing_ok=True)
                whole = 0.0
                if not flags.no_whole:
                    whole = trial.whole(wanted)
                    if scalar == "double":
                        trial.tiled(wanted, 2 * max(flags.tile_points), 2)
                for tile_points in flags.tile_points:
                    for halo in flags.halo:
                        row = {"cloud": f"{shape} {scalar}", "estimator": estimator, "tile": tile_points, "halo": halo}
                        made = trial.tiled(out, tile_points, halo)
                        if not wanted.exists():
                            out.rename(wanted)
                            row["different"] = 0
                        else:
                            row["different"] = different_bytes(out, wanted)
                        made["of whole"] = made["server us/point"] / trial.per_point(whole) if whole else float("nan")
                        yield row | made
            cloud.unlink()


def words(text):
    return text.split(",")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--shapes", type=words, default=["torus", "terrain"])
    parser.add_argument("--scalars", type=words, default=["float", "double"])
    parser.add_argument("--estimators", type=words,
                        default=["avg-hexagram", "hexagram", "jet", "aso", "normal-regression"])  # fmt: skip
    parser.add_argument("--tile-points", type=lambda text: [int(v) for v in words(text)],
                        default=[350_000, 120_000, 40_000])  # fmt: skip
    parser.add_argument("--halo", type=words, default=["0", "0.5", "1.25"])
    parser.add_argument("--memory", default="1GiB")
    parser.add_argument("--memory-limit", help="of curvd for the tiles")
    parser.add_argument("--no-whole", action="store_true")
    parser.add_argument("--folder", help="where clouds and results are written [a temporary folder]")
    flags = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="tiles-trial-", dir=flags.folder))
    differ = 0
    try:
        first = True
        for row in trials(flags, folder):
            if first:
                print("| " + " | ".join(row) + " |\n|" + " --- |" * len(row))
            first = False
            print("| " + " | ".join(f"{v:.3g}" if isinstance(v, float) else str(v) for v in row.values()) + " |",
                  flush=True)  # fmt: skip
            differ += row["different"]
    finally:
        shutil.rmtree(folder)
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
