#!/usr/bin/python3
"""Runs the benchmarks of two builds in turns, and tells by how much each figure differs.

  bench/compare_builds.py OLD_BUILD NEW_BUILD [--turns=N] [--programs=estimator,scaling] [-- FLAGS OF THE PROGRAMS]

A build is the folder of `cmake --preset bench`. In each turn each program runs once from either build, the older first
in every other turn, with one round unless FLAGS say otherwise, so that what the machine does in the meantime hits both
alike. A row tells NEW / OLD for one figure of one row of a table: of the medians over the turns, and of what a tenth of
the turns undercut, since what else the machine does can only make a program slower. Behind either stands how far it may
be off: two standard errors, by drawing turns again at random (Efron's bootstrap). The one with less doubt decides. It
is marked "<-" where it is farther from 1 than --within even so, and "?" where the turns are too few or too uneven to
tell --within. Then come the geometric means of each column of each table. Figures that only one of the builds has, or
that are 0 in the older one, are named and not compared. Exits with 1 if a row is marked "<-", or if nothing was
compared.
"""

import argparse
import csv
import math
import pathlib
import random
import re
import statistics
import subprocess
import sys
import tempfile


def figures(build, program, flags):
    """Runs a program; returns the numbers in its tables by (table, row, column), in words."""
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([build / "bin" / f"{program}_bench", f"--out={out}", *flags], check=True,
                       stdout=subprocess.DEVNULL)  # fmt: skip
        found = {}
        for path in sorted(pathlib.Path(out).glob("*.csv")):
            if path.stem.startswith("targets"):
                continue
            rows = list(csv.reader(path.open(encoding="utf-8")))
            # What a row is about stands before its first figure.
            first = next((i for i, name in enumerate(rows[0]) if is_figure(name)), len(rows[0]))
            for row in rows[1:]:
                for name, cell in zip(rows[0][first:], row[first:]):
                    if is_figure(name) and number(cell) is not None:
                        found[path.stem, " ".join(row[:first]), name] = number(cell)
        return found


def is_figure(column):
    """Whether a column holds what was measured, and no name or size of what was."""
    return column == "measured" or column.endswith(" s") or any(unit in column for unit in ("us/", " ms", "MB", "bytes"))


def number(cell):
    """The number that a cell begins with ("97.0 B" is 97), or None."""
    found = re.match(r"[-+0-9.eE]+", cell)
    return float(found.group()) if found else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=pathlib.Path)
    parser.add_argument("new", type=pathlib.Path)
    parser.add_argument("--turns", type=int, default=7)
    parser.add_argument("--programs", default="core,estimator,scaling,service")
    parser.add_argument("--within", type=float, default=0.02, help="of 1; rows farther away are marked [0.02]")
    own, flags = sys.argv[1:], []
    if "--" in own:  # argparse gives what stands there to positional arguments before it
        own, flags = own[: own.index("--")], own[own.index("--") + 1 :]
    arguments = parser.parse_args(own)
    if not any(flag.startswith("--rounds") for flag in flags):
        flags.append("--rounds=1")
    turns, uncompared = {}, {}
    for turn in range(arguments.turns):
        for program in arguments.programs.split(","):
            builds = {"old": arguments.old, "new": arguments.new}
            order = ["old", "new"] if turn % 2 == 0 else ["new", "old"]
            measured = {which: figures(builds[which], program, flags) for which in order}
            add_turn(measured["old"], measured["new"], turns, uncompared)
        print(f"turn {turn + 1} of {arguments.turns}", file=sys.stderr, flush=True)
    return report(turns, uncompared, arguments.within)


def add_turn(old, new, turns, uncompared):
    """Appends (old, new) of each figure to `turns`, and why there is none to `uncompared`."""
    for key in {**old, **new}:
        if key not in new:
            uncompared[key] = "only in OLD_BUILD"
        elif key not in old:
            uncompared[key] = "only in NEW_BUILD"
        elif old[key] <= 0:
            uncompared[key] = f"{old[key]:g} in OLD_BUILD"
        else:
            turns.setdefault(key, []).append((old[key], new[key]))


def report(turns, uncompared, within):
    """Prints what was compared and what was not; returns the exit status."""
    far = untold = 0
    columns = {}
    for (table, row, column), pairs in turns.items():
        # More is better for what is told per second alone.
        best = 0.9 if "per CPU second" in row + column else 0.1
        medians, bests = estimate(pairs, 0.5), estimate(pairs, best)
        ratio, doubt = min(medians, bests, key=lambda found: found[1])
        columns.setdefault((table, column), []).append((medians[0], bests[0]))
        mark = ""
        if abs(ratio - 1) > within + doubt:
            mark, far = "  <-", far + 1
        elif doubt > within:
            mark, untold = "  ?", untold + 1
        told = "  ".join(f"{ratio:6.3f} +- {doubt:.3f}" for ratio, doubt in (medians, bests))
        print(f"{told}  {table}: {row}: {column}{mark}")
    print("geometric means over the rows, of medians and of the best tenth:")
    for (table, column), ratios in columns.items():
        medians, bests = (statistics.geometric_mean(found) for found in zip(*ratios))
        print(f"{medians:6.3f}  {bests:6.3f}  {table}: {column} ({len(ratios)} rows)")
    for (table, row, column), reason in uncompared.items():
        print(f"not compared, {reason}: {table}: {row}: {column}")
    print(
        f"{len(turns)} figures, {far} farther than {within:g} from 1, {untold} not told to {within:g}; "
        f"{len(uncompared)} not compared"
    )
    return 1 if far or not turns else 0


def estimate(pairs, share, draws=200):
    """NEW / OLD of the figures that `share` of the turns undercut, and twice its standard error."""

    def ratio(pairs):
        old, new = zip(*pairs)
        return quantile(new, share) / quantile(old, share)

    if len(pairs) < 2:
        return ratio(pairs), math.inf
    draw = random.Random(len(pairs))
    return ratio(pairs), 2 * statistics.stdev(ratio(draw.choices(pairs, k=len(pairs))) for _ in range(draws))


def quantile(values, share):
    """What `share` of the values undercut, between two of them in proportion."""
    values = sorted(values)
    place = share * (len(values) - 1)
    below = min(int(place), len(values) - 2) if len(values) > 1 else 0
    above = min(below + 1, len(values) - 1)
    return values[below] + (place - below) * (values[above] - values[below])


if __name__ == "__main__":
    sys.exit(main())
