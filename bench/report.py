#!/usr/bin/python3
"""Writes benchmark results into docs/benchmarks.md.

report.py machine RESULTS BUILD [FLAGS...]  notes what the programs are about to run on, as RESULTS/machine.csv
report.py tables RESULTS DOCUMENT           replaces each table of DOCUMENT between <!-- table NAME --> and
                                            <!-- end NAME --> by RESULTS/NAME.csv; a table without results is emptied,
                                            so that no run shows another's figures
"""
import csv
import datetime
import os
import pathlib
import re
import subprocess
import sys


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def cpu_info(key):
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith(key):
            return line.split(":", 1)[1].strip()
    return "unknown"


def compiler(build):
    cache = (build / "CMakeCache.txt").read_text()
    path = re.search(r"^CMAKE_CXX_COMPILER:\w+=(.*)$", cache, re.M).group(1)
    return output(path, "--version").splitlines()[0]


def instruction_sets():
    known = ("sse4_2", "avx2", "avx512f")
    flags = cpu_info("flags").split()
    return " ".join(name for name in known if name in flags) or "none of " + " ".join(known)


def note_machine(results, build, flags):
    changed = output("git", "status", "--porcelain", "--untracked-files=no", "--", "core", "server", "client", "proto",
                     "bench")
    kilobytes = int(re.search(r"MemTotal:\s+(\d+)", pathlib.Path("/proc/meminfo").read_text()).group(1))
    load = os.getloadavg()[0]
    cores = len(os.sched_getaffinity(0))
    rows = [
        ("date", datetime.date.today().isoformat()),
        ("processor", f"{cpu_info('model name')}, family {cpu_info('cpu family')} model {cpu_info('model')}"),
        ("cores", cores),
        ("instruction sets", instruction_sets()),
        ("memory", f"{kilobytes / 2**20:.0f} GiB"),
        ("compiler", compiler(build)),
        ("commit", output("git", "rev-parse", "--short=12", "HEAD") + (" with local changes" if changed else "")),
        ("run", " ".join(flags) or "standard"),
        ("load average at the start", f"{load:.2f}" + (
            " (**busy: times and speedups are not to be trusted**)" if load > 0.5 else "")),
    ]
    with open(results / "machine.csv", "w", newline="") as file:
        csv.writer(file).writerows([("what", "value"), *rows])
    if load > 0.5:
        print(f"warning: load average {load:.2f}: others are at work on this machine", file=sys.stderr)


def markdown(rows):
    lines = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def read_table(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    if any(len(row) != len(rows[0]) for row in rows):
        sys.exit(f"{path}: rows of different lengths")
    return rows


def read_targets(results):
    """All programs' targets as one table."""
    tables = [read_table(path) for path in sorted(results.glob("targets_*.csv"))]
    return tables[0][:1] + [row for table in tables for row in table[1:]] if tables else None


def fill(document, results):
    def replace(match):
        name = match.group(1)
        path = results / f"{name}.csv"
        rows = read_targets(results) if name == "targets" else read_table(path) if path.exists() else None
        body = markdown(rows) if rows else "Not measured in this run."
        return f"<!-- table {name} -->\n{body}\n<!-- end {name} -->"

    return re.sub(r"<!-- table (\w+) -->\n.*?<!-- end \1 -->", replace, document, flags=re.S)


def main():
    command, results = sys.argv[1], pathlib.Path(sys.argv[2])
    if command == "machine":
        note_machine(results, pathlib.Path(sys.argv[3]), sys.argv[4:])
    else:
        document = pathlib.Path(sys.argv[3])
        document.write_text(fill(document.read_text(), results))


if __name__ == "__main__":
    main()
