#!/usr/bin/python3
"""Runs the benchmarks of two builds in turns, and tells by how much each figure differs.

  bench/compare_builds.py OLD_BUILD NEW_BUILD [--turns=N] [--programs=estimator,scaling] [-- FLAGS OF THE PROGRAMS]

A build is the folder of `cmake --preset bench`. In each turn each program runs once from either build, the older first
in every other turn, with one round unless FLAGS say otherwise, so that what the machine does in the meantime hits both
alike. A row tells the median over the turns of NEW / OLD for one figure of one row of a table, and how far that median
may be off (two standard errors, from the spread of the turns). It is marked "<-" where it is farther from 1 than
--within even so, and "?" where the turns are too few or too uneven to tell --within. Then come the geometric means of
each column of each table. Figures that only one of the builds has, or that are 0 in the older one, are named and not
compared. Exits with 1 if a row is marked "<-", or if nothing was compared.
"""

import argparse
import csv
import math
import pathlib
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
    ratios, uncompared = {}, {}
    for turn in range(arguments.turns):
        for program in arguments.programs.split(","):
            builds = {"old": arguments.old, "new": arguments.new}
            order = ["old", "new"] if turn % 2 == 0 else ["new", "old"]
            measured = {which: figures(builds[which], program, flags) for which in order}
            add_ratios(measured["old"], measured["new"], ratios, uncompared)
        print(f"turn {turn + 1} of {arguments.turns}", file=sys.stderr, flush=True)
    return report(ratios, uncompared, arguments.within)


def add_ratios(old, new, ratios, uncompared):
    """Appends new / old of each figure to `ratios`, and why there is none to `uncompared`."""
    for key in {**old, **new}:
        if key not in new:
            uncompared[key] = "only in OLD_BUILD"
        elif key not in old:
            uncompared[key] = "only in NEW_BUILD"
        elif old[key] <= 0:
            uncompared[key] = f"{old[key]:g} in OLD_BUILD"
        else:
            ratios.setdefault(key, []).append(new[key] / old[key])


def report(ratios, uncompared, within):
    """Prints what was compared and what was not; returns the exit status."""
    far = untold = 0
    columns = {}
    for (table, row, column), values in ratios.items():
        median, doubt = statistics.median(values), doubt_of_median(values)
        columns.setdefault((table, column), []).append(median)
        mark = ""
        if abs(median - 1) > within + doubt:
            mark, far = "  <-", far + 1
        elif doubt > within:
            mark, untold = "  ?", untold + 1
        print(f"{median:6.3f} +- {doubt:.3f}  {table}: {row}: {column}{mark}")
    print("geometric means over the rows:")
    for (table, column), medians in columns.items():
        print(f"{statistics.geometric_mean(medians):6.3f}  {table}: {column} ({len(medians)} rows)")
    for (table, row, column), reason in uncompared.items():
        print(f"not compared, {reason}: {table}: {row}: {column}")
    print(
        f"{len(ratios)} figures, {far} farther than {within:g} from 1, {untold} not told to {within:g}; "
        f"{len(uncompared)} not compared"
    )
    return 1 if far or not ratios else 0


def doubt_of_median(values):
    """Twice the standard error of the values' median, from their median absolute deviation, as if they were normal."""
    if len(values) < 2:
        return math.inf
    center = statistics.median(values)
    deviation = 1.4826 * statistics.median(abs(value - center) for value in values)
    return 2 * 1.2533 * deviation / math.sqrt(len(values))


if __name__ == "__main__":
    sys.exit(main())
