#!/usr/bin/python3
"""Sends a result through other programs and back into curv, and tells what came back.

round_trips.py CURV

Prints a Markdown table: for each program that is installed (Debian: cloudcompare, meshlab, pcl-tools, python3-open3d) and
each way to it, which columns curv reads back, and how far values are off. Not a part of the test run, as the programs
bring 500 MB of packages; run it when a format or a name changes, and bring docs/files.md up to date.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

POINTS = 2000
# A result far from the origin, as surveys are.
OFFSET = np.array([500_000.0, 5_800_000.0, 100.0])


def run(*words, **more):
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True, timeout=120,
                          env=environment, **more)


class Curv:
    def __init__(self, binary, folder):
        self.binary, self.folder = binary, folder

    def result(self, far):
        """A table with every column that an estimate has; `far` ones are in doubles."""
        cloud, result = self.folder / "cloud.ply", self.folder / f"result_{far}.npy"
        run(self.binary, "generate", "torus", f"--points={POINTS}", "-o", cloud, *(["--double"] if far else []))
        run(self.binary, "estimate", cloud, "-o", result)
        table = np.load(result)
        table = table[[name for name in table.dtype.names if not name.startswith("true_")]].copy()
        if far:
            for axis, name in enumerate("xyz"):
                table[name] += OFFSET[axis]
        np.save(result, table)
        return result

    def convert(self, source, target, *flags):
        run(self.binary, "select", source, "--where", "x == x", "-o", target, *flags)

    def read(self, path):
        copy = path.with_suffix(".read.npy")
        self.convert(path, copy)
        return np.load(copy)


def cloudcompare(source, target):
    run("CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF", "-O", "-GLOBAL_SHIFT", "AUTO", source, "-C_EXPORT_FMT", "PLY",
        "-SAVE_CLOUDS", "FILE", target)


def meshlab(source, target):
    # It asks for OpenGL even to convert a file.
    run("xvfb-run", "-a", "meshlabserver", "-i", source, "-o", target, "-m", "vn", "vq")


def pcl_ply(source, target):
    run("pcl_ply2pcd", source, target)


def pcl_pcd(source, target):
    run("pcl_convert_pcd_ascii_binary", source, target, "2")


OPEN3D = """
import sys
import open3d
cloud = open3d.t.io.read_point_cloud(sys.argv[1])
open3d.t.io.write_point_cloud(sys.argv[2], cloud)
"""
OPEN3D_LEGACY = """
import sys
import open3d
open3d.io.write_point_cloud(sys.argv[2], open3d.io.read_point_cloud(sys.argv[1]))
"""


def open3d(source, target, program=OPEN3D):
    run("/usr/bin/python3", "-c", program, source, target)


def has_open3d():
    return subprocess.run(["/usr/bin/python3", "-c", "import open3d"], capture_output=True, check=False).returncode == 0


# Program, how it is found, what it is given (ending, flags of curv), what it gives back, the way through it.
WAYS = [
    ("CloudCompare", "CloudCompare", ".ply", [], ".ply", cloudcompare),
    ("CloudCompare, --names=cloudcompare", "CloudCompare", ".ply", ["--names=cloudcompare"], ".ply", cloudcompare),
    ("MeshLab", "meshlabserver", ".ply", [], ".ply", meshlab),
    ("MeshLab, --names=meshlab", "meshlabserver", ".ply", ["--names=meshlab"], ".ply", meshlab),
    ("Open3D, tensor", has_open3d, ".ply", [], ".ply", open3d),
    ("Open3D, tensor", has_open3d, ".pcd", [], ".pcd", open3d),
    ("Open3D, legacy", has_open3d, ".ply", [], ".ply", lambda a, b: open3d(a, b, OPEN3D_LEGACY)),
    ("PCL, PLY to PCD", "pcl_ply2pcd", ".ply", [], ".pcd", pcl_ply),
    ("PCL, PCD", "pcl_convert_pcd_ascii_binary", ".pcd", [], ".pcd", pcl_pcd),
]


def shown(names):
    """Names, those of vectors and of long lists in short."""
    names = list(names)
    for vector in ("n", "d1", "d2"):
        parts = [vector + axis for axis in "xyz"]
        if all(part in names for part in parts):
            names[names.index(parts[0])] = vector
            names = [name for name in names if name not in parts]
    return " ".join(names) if names else "nothing"


def compare(sent, back):
    """What is lost, and the largest difference of what is kept: relative to the column's largest value."""
    if len(sent) != len(back):
        return f"{len(back)} of {len(sent)} points", ""
    kept = [name for name in sent.dtype.names if name in back.dtype.names]
    lost = [name for name in sent.dtype.names if name not in kept]
    new = [name for name in back.dtype.names if name not in sent.dtype.names]
    worst = ("", 0.0)
    for name in kept:
        a, b = sent[name].astype(float), back[name].astype(float)
        # Positions are compared by how far the cloud reaches, not by how far it is away.
        size = np.ptp(a) if name in "xyz" else np.nanmax(np.abs(a))
        difference = np.nanmax(np.abs(a - b)) / size
        if difference > worst[1] or (np.isnan(a) != np.isnan(b)).any():
            worst = (name, difference)
    more = f"; new: {shown(new)}" if new else ""
    return shown(lost) + more, f"{worst[1]:.1e} ({worst[0]})" if worst[0] else "none"


def main(binary):
    print("| program | positions | sent | lost | largest difference |")
    print("| --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        curv = Curv(binary, folder)
        for far in (False, True):
            result = curv.result(far)
            sent = np.load(result)
            for program, finder, ending, flags, back_ending, way in WAYS:
                if not (finder() if callable(finder) else shutil.which(finder)):
                    continue
                source, target = folder / f"sent{ending}", folder / f"back{back_ending}"
                target.unlink(missing_ok=True)
                curv.convert(result, source, *flags)
                try:
                    way(source, target)
                    row = compare(sent, curv.read(target))
                except (subprocess.SubprocessError, OSError) as error:
                    told = getattr(error, "stderr", "") or str(error)
                    row = (f"all: {told.strip().splitlines()[-1]}", "")
                kind = "doubles, far away" if far else "floats"
                print(f"| {program} | {kind} | {ending} | {row[0]} | {row[1]} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
