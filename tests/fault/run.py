#!/usr/bin/python3
"""Tries each fault many times against real processes: run.py --programs DIR [--times N] [--quick] [--guard] [NAME...]

Prints a table: fault, times tried, what was lost, seconds until all was well again. With --guard it tries what bounds
strangers, and says how others were served beside. Exits with 1 if anything was lost, or a promise broken.
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


def try_fault(fault, site, times, most_seconds):
    """Returns the trials, and what was lost ("" if nothing). Begins no trial after most_seconds."""
    trials, until = [], time.monotonic() + most_seconds
    try:
        for trial in fault.trials(site, times):
            trials.append(trial)
            if time.monotonic() > until:
                break
    except Exception as error:  # whatever went wrong is the finding
        traceback.print_exc()
        return trials, f"{type(error).__name__}: {error}"
    return trials, ""


def broken(trials):
    """The promises that trials have broken."""
    return [trial.broken for trial in trials if getattr(trial, "broken", "")]


def row(name, tried, lost, trials):
    lost = lost or "; ".join(sorted(set(broken(trials)))) or "nothing"
    median = f"{statistics.median(trials):.2f}" if trials else ""
    longest = f"{max(trials):.2f}" if trials else ""
    return f"| {name} | {tried} | {lost} | {median} | {longest} |"


def guard_row(name, tried, lost, trials):
    for promise in broken(trials):
        print(f"{name}: {promise}", file=sys.stderr)
    if not trials:
        return f"| {name} | {tried} | | {lost} | | | | | |"
    beside = [trial.beside for trial in trials]
    return (
        f"| {name} | {tried} | {len(broken(trials))} | {lost or 'nothing'} "
        f"| {max(trial.over_limit_mib for trial in trials):+.0f} | {statistics.median(beside):.1f} | {max(beside):.1f} "
        f"| {max(trial.longest for trial in trials):.0f} | {max(trials):.1f} |"
    )


_HEADING = "| fault | times tried | lost | median seconds to recover | longest |\n| --- | --: | --- | --: | --: |"
_GUARD_HEADING = (
    "| attack | trials | failed | lost | worst MiB over the limit | calls beside, times idle: median | worst median | "
    "longest call | longest s |\n| --- | --: | --: | --- | --: | --: | --: | --: | --: |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="directory of curvd and curv")
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--quick", action="store_true", help="a small cloud, and no fault that takes a keepalive")
    parser.add_argument("--guard", action="store_true", help="what bounds strangers, and how others are served beside")
    parser.add_argument("--row-seconds", type=float, default=float("inf"), help="begin no trial of a row after that")
    parser.add_argument("--points", type=int, default=300_000)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 1_000_000)
    parser.add_argument("names", nargs="*", help="only these faults")
    options = parser.parse_args()
    unknown = sorted(set(options.names) - {fault.name for fault in _FAULTS})
    if unknown:
        parser.error(f"no fault is called {unknown[0]!r}; there are: {', '.join(fault.name for fault in _FAULTS)}")
    chosen = [fault for fault in _FAULTS if fault.name in options.names or not options.names]
    chosen = [fault for fault in chosen if not (options.quick and fault.slow) and (fault.guard or not options.guard)]
    make_row, heading = (guard_row, _GUARD_HEADING) if options.guard else (row, _HEADING)
    print(f"seed {options.seed}", flush=True)
    rows, failed = [], False
    with tempfile.TemporaryDirectory(prefix="curvd-fault-") as scratch:
        site = Site(options.programs, pathlib.Path(scratch), options.points, options.seed)
        for fault in chosen:
            missing = fault.needs()
            if missing:
                rows.append(make_row(fault.name, 0, f"not tried: {missing}", []))
                continue
            trials, lost = try_fault(fault, site, options.times, options.row_seconds)
            rows.append(make_row(fault.name, len(trials) + bool(lost), lost, trials))
            failed |= bool(lost or broken(trials))
            print(rows[-1], file=sys.stderr, flush=True)
    print(heading)
    print("\n".join(rows))
    sys.exit(failed)


if __name__ == "__main__":
    main()
