#!/usr/bin/python3
"""Tells whether two builds of curv give the same results to the last byte, or prints the hashes of one build.

  bench/same_bytes.py BIN               prints the SHA-256 of each result of the curv in folder BIN
  bench/same_bytes.py OLD_BIN NEW_BIN   compares two of them

Exits with 1 if a result differs, if a program failed (though both did so with the same words), or if --only left no
case.

A result is the file that `curv estimate` writes, less its comments: every point with its status, and every quantity. The cases are every
estimator with each of its options, by count and by radius, on clouds in float32 and in float64, with noise, with
invalid points, with ties in distance, with duplicates, with two densities, with sheets that lie close to each other, and
too small to be estimated, on one worker thread and on two. Hashes hold for one kind of CPU: vectors of another width add in another order.
"""

import argparse
import hashlib
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

POINTS = 20_000
ESTIMATORS = {
    "avg-hexagram": [[], ["--rotations=1"], ["--rotations=3"], ["--rotations=4"], ["--average-normal-weight=0"]],
    "hexagram": [[]],
    "uniform": [[], ["--triangles=7", "--seed=3"]],
    "independent": [[], ["--triangles=7", "--seed=3"]],
    "delaunay": [[], ["--even-weights"]],
    "jet": [[], ["--jet-degree=3"], ["--jet-degree=4"]],
    "aso": [[], ["--project"]],
    "normal-regression": [[], ["--average-normal-weight=0"]],
}
COUNTS = (5, 15, 50, 300)
# A jet that its normal equations cannot solve is solved by another factorization, whose rounding may change.
JET_TOLERANCE = 1e-8


def write_ply(path, points, normals, scalar):
    """Writes a binary PLY of positions and normals, as `scalar` ("float" or "double")."""
    kind = "<f4" if scalar == "float" else "<f8"
    properties = "".join(f"property {scalar} {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n{properties}end_header\n"
    path.write_bytes(header.encode() + np.hstack([points, normals]).astype(kind).tobytes())


def sphere(count, rng):
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals * 2.0, normals


def make_clouds(folder, curv):
    """Makes the clouds; returns for each its file, its radii, and further flags."""
    rng = np.random.default_rng(7)
    clouds = {}

    def add(name, points, normals, radii, scalar="float", flags=()):
        path = folder / f"{name}.ply"
        write_ply(path, points, normals, scalar)
        clouds[name] = (path, radii, list(flags))

    for surface in ("torus", "goursat"):
        for scalar, more in (("float", []), ("double", ["--double"])):
            path = folder / f"{surface}-{scalar}.ply"
            subprocess.run(
                [curv, "generate", surface, f"--points={POINTS}", "--noise-position=0.02", "--noise-normal=0.1", *more,
                 "-o", path], check=True, stdout=subprocess.DEVNULL)  # fmt: skip
            clouds[f"{surface}-{scalar}"] = (path, (0.3, 1.0), [])

    points, normals = sphere(POINTS, rng)
    add("far-away", points + [500_000.25, 4_000_000.5, 90.125], normals, (0.2,), "double")
    add("tiny-unit", points * 1e-6, normals, (2e-7,))

    broken, broken_normals = points.copy(), normals.copy()
    broken[::97] = np.nan
    broken_normals[::89] = 0.0
    add("invalid-points", broken, broken_normals, (0.2,), flags=["--on-invalid=skip"])
    add("invalid-points-double", broken, broken_normals, (0.2,), "double", flags=["--on-invalid=skip"])

    grid = np.stack(np.meshgrid(np.arange(100.0), np.arange(100.0), [0.0]), axis=-1).reshape(-1, 3)
    tilted = np.tile([0.0, 0.0, 1.0], (len(grid), 1)) + 0.05 * rng.normal(size=grid.shape)
    order = rng.permutation(len(grid))
    add("ties", grid[order], tilted[order], (2.0, 5.0))

    twice = np.concatenate([points[:4000], points[:4000], np.tile(points[:1], (300, 1))])
    twice_normals = np.concatenate([normals[:4000], normals[:4000], np.tile(normals[:1], (300, 1))])
    order = rng.permutation(len(twice))
    add("duplicates", twice[order], twice_normals[order], (0.3,))

    dense, dense_normals = sphere(5000, rng)
    both = np.concatenate([points[:2000], dense * 1e-3 + [5.0, 0.0, 0.0]])
    add("two-densities", both, np.concatenate([normals[:2000], dense_normals]), (0.4,))

    # Sheets whose normals are opposed by right: 2 spacings apart, meeting at an edge, and touching in a point.
    count = 6000
    side = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    across = rng.uniform(0.0, 2.0, (count, 2))
    flat = np.zeros(count)
    plate = np.column_stack([across, side * np.sqrt(8.0 / count)])
    add("thin-plate", plate, np.column_stack([flat, flat, side]), (0.15,))
    slope = np.radians(10.0)
    knife = np.column_stack([across, side * across[:, 1] * np.sin(slope)])
    knife[:, 1] *= np.cos(slope)
    add("knife", knife, np.column_stack([flat, flat - np.sin(slope), side * np.cos(slope)]), (0.15,))
    unit, unit_normals = points[:6000] / 2.0, normals[:6000]
    add("touching-spheres", np.concatenate([unit[:3000], unit[3000:] + [2.0, 0.0, 0.0]]), unit_normals, (0.2,))

    line = np.zeros((500, 3))
    line[:, 0] = np.arange(500) * 0.1
    add("line", line, np.tile([0.0, 0.0, 1.0], (500, 1)), (1.0,))
    for count in (1, 3, 5, 17):
        add(f"{count}-points", points[:count], normals[:count], (3.0,))
    return clouds


def cases(clouds):
    for cloud, (path, radii, flags) in clouds.items():
        for estimator, variants in ESTIMATORS.items():
            sizes = [f"--k={count}" for count in COUNTS] + [f"--radius={radius}" for radius in radii]
            for variant in variants:
                # Variants in full on one cloud, by one count on the others.
                for size in sizes if not variant or cloud == "torus-float" else sizes[2:3]:
                    yield cloud, path, [f"--estimator={estimator}", size, *variant, *flags]


def without_comments(ply):
    """Less the comments of the header, which list the statuses that a build knows."""
    end = ply.index(b"end_header\n")
    lines = ply[:end].splitlines(keepends=True)
    return b"".join(line for line in lines if not line.startswith(b"comment ")) + ply[end:]


def run(curv, path, flags, threads, out):
    """Returns what `curv estimate` writes, without comments; prints its error and returns None if it fails."""
    done = subprocess.run([curv, "estimate", path, "-o", out, f"--threads={threads}", *flags],
                          capture_output=True, text=True, check=False)  # fmt: skip
    if done.returncode == 0:
        return without_comments(out.read_bytes())
    title = " ".join([path.stem, *flags, f"threads={threads}"])
    print(f"FAILS: {curv} {title}: exit {done.returncode}: {done.stderr.strip()}", flush=True)
    return None


def nearly_equal(old, new):
    """Whether two result files agree to JET_TOLERANCE relative to the largest value of each column."""
    split = old.index(b"end_header\n") + 11
    if old[:split] != new[:split] or len(old) != len(new):
        return False
    types = {"float": "f4", "double": "f8", "uchar": "u1", "int": "i4"}
    fields = [line.split()[1:] for line in old[:split].decode().splitlines() if line.startswith("property")]
    layout = np.dtype([(name, "<" + types[kind]) for kind, name in fields])
    a, b = np.frombuffer(old[split:], layout), np.frombuffer(new[split:], layout)
    for name in layout.names:
        x, y = a[name].astype(float), b[name].astype(float)
        scale = np.nanmax(np.abs(x), initial=0.0)
        # Values are float32: one unit in the last place is allowed besides.
        if not np.allclose(x, y, rtol=6e-8, atol=JET_TOLERANCE * scale, equal_nan=True):
            return False
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bins", nargs="+", type=pathlib.Path, metavar="BIN", help="a folder that holds curv")
    parser.add_argument("--only", default="", help="run the cases whose words contain this")
    arguments = parser.parse_args()
    if len(arguments.bins) > 2:
        parser.error("at most two builds are compared")
    curvs = [folder / "curv" for folder in arguments.bins]
    differing, tolerated, failed, count = 0, 0, 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for cloud, path, flags in cases(make_clouds(folder, curvs[0])):
            title = " ".join([cloud, *flags])
            if arguments.only not in title:
                continue
            for threads in (1, 2):
                results = [run(curv, path, flags, threads, folder / "out.ply") for curv in curvs]
                count += 1
                if None in results:
                    failed += 1
                elif len(results) == 1:
                    print(hashlib.sha256(results[0]).hexdigest(), title, f"threads={threads}", flush=True)
                elif results[0] != results[1]:
                    is_jet = "--estimator=jet" in flags
                    if is_jet and nearly_equal(*results):
                        tolerated += 1
                        continue
                    differing += 1
                    print(f"DIFFERS: {title} threads={threads}", flush=True)
    if len(curvs) == 2:
        print(f"{count} results compared: {differing} differ, {failed} failed, "
              f"{tolerated} of jets agree to {JET_TOLERANCE:g}")  # fmt: skip
    return 1 if differing or failed or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
