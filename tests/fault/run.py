#!/usr/bin/python3
"""Tries each fault many times against real processes: run.py --programs DIR [--times N] [--quick] [NAME...]

Prints a table: fault, times tried, what was lost, seconds until all was well again. Exits with 1 if anything was lost.
"""

import argparse
import importlib
import pathlib
import statistics
import sys
import tempfile
import time
import traceback

from trial_site import Site

# Every *_faults.py beside this file has a list FAULTS.
_MODULES = sorted(file.stem for file in pathlib.Path(__file__).parent.glob("*_faults.py"))
_FAULTS = [fault for name in _MODULES for fault in importlib.import_module(name).FAULTS]


def try_fault(fault, site, times):
    """Returns the seconds of each trial, and what was lost ("" if nothing)."""
    seconds = []
    try:
        for recovery in fault.trials(site, times):
            seconds.append(recovery)
    except Exception as error:  # whatever went wrong is the finding
        traceback.print_exc()
        return seconds, f"{type(error).__name__}: {error}"
    return seconds, ""


def row(name, tried, lost, seconds):
    median = f"{statistics.median(seconds):.2f}" if seconds else ""
    longest = f"{max(seconds):.2f}" if seconds else ""
    return f"| {name} | {tried} | {lost} | {median} | {longest} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="directory of curvd and curv")
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--quick", action="store_true", help="a small cloud, and no fault that takes a keepalive")
    parser.add_argument("--points", type=int, default=300_000)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 1_000_000)
    parser.add_argument("names", nargs="*", help="only these faults")
    options = parser.parse_args()
    unknown = sorted(set(options.names) - {fault.name for fault in _FAULTS})
    if unknown:
        parser.error(f"no fault is called {unknown[0]!r}; there are: {', '.join(fault.name for fault in _FAULTS)}")
    chosen = [fault for fault in _FAULTS if fault.name in options.names or not options.names]
    chosen = [fault for fault in chosen if not (options.quick and fault.slow)]
    print(f"seed {options.seed}", flush=True)
    rows, failed = [], False
    with tempfile.TemporaryDirectory(prefix="curvd-fault-") as scratch:
        site = Site(options.programs, pathlib.Path(scratch), options.points, options.seed)
        for fault in chosen:
            missing = fault.needs()
            if missing:
                rows.append(row(fault.name, 0, f"not tried: {missing}", []))
                continue
            seconds, lost = try_fault(fault, site, options.times)
            rows.append(row(fault.name, len(seconds) + bool(lost), lost or "nothing", seconds))
            failed |= bool(lost)
            print(rows[-1], file=sys.stderr, flush=True)
    print("| fault | times tried | lost | median seconds to recover | longest |\n| --- | --: | --- | --: | --: |")
    print("\n".join(rows))
    sys.exit(failed)


if __name__ == "__main__":
    main()
