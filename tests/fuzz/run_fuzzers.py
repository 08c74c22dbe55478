#!/usr/bin/python3
"""Runs every fuzz target and prints what came of it: run_fuzzers.py BIN_DIR WORK_DIR SECONDS [EXECUTIONS]

Each target runs SECONDS, or EXECUTIONS times, however long that takes; as many at a time as there are cores, from the
seeds beside this script and from what earlier runs left in WORK_DIR/corpus. Inputs that break a target are kept in
WORK_DIR/findings; exits with 1 if there are any.
To see one again: BIN_DIR/TARGET_fuzzer FINDING.
"""

import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
# An input must not take longer, nor ask for more: seeds and mutants are a few kilobytes.
LIMITS = ["-max_len=4096", "-timeout=20", "-rss_limit_mb=1024", "-malloc_limit_mb=256"]


def run(fuzzer, work_dir, bound):
    """Runs one target. Returns its name, executions, branches covered and the files of its findings."""
    target = fuzzer.name.removesuffix("_fuzzer")
    corpus, findings = (work_dir / kind / target for kind in ("corpus", "findings"))
    for folder in (corpus, findings):
        folder.mkdir(parents=True, exist_ok=True)
    before = set(findings.iterdir())
    dictionary = HERE / "dictionaries" / target
    command = [fuzzer, *LIMITS, bound, f"-artifact_prefix={findings}/", "-print_final_stats=1",
               *([f"-dict={dictionary}"] if dictionary.exists() else []), corpus, HERE / "corpus" / target]
    log = work_dir / f"{target}.log"
    with log.open("w", encoding="utf-8") as output:
        status = subprocess.run(command, stdout=output, stderr=subprocess.STDOUT, check=False).returncode
    text = log.read_text(encoding="utf-8", errors="replace")
    executions = re.findall(r"^stat::number_of_executed_units: *(\d+)", text, re.MULTILINE)
    covered = re.findall(r"cov: (\d+)", text)
    found = sorted(set(findings.iterdir()) - before)
    if status != 0 and not found:
        sys.exit(f"{fuzzer} ended with {status}:\n{text[-2000:]}")
    # A seed that is a finding ends the run before anything is covered.
    return target, int((executions or [0])[-1]), int((covered or [0])[-1]), found


def main():
    bin_dir, work_dir = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    bound = f"-runs={int(sys.argv[4])}" if len(sys.argv) > 4 else f"-max_total_time={int(sys.argv[3])}"
    fuzzers = sorted(bin_dir.glob("*_fuzzer"))
    if not fuzzers:
        sys.exit(f"{bin_dir} holds no fuzz targets")
    work_dir.mkdir(parents=True, exist_ok=True)
    findings = []
    print(f"{'target':<12}{'executions':>12}{'branches':>10}{'new findings':>14}")
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for target, executions, covered, found in pool.map(lambda fuzzer: run(fuzzer, work_dir, bound), fuzzers):
            print(f"{target:<12}{executions:>12,}{covered:>10,}{len(found):>14}", flush=True)
            findings += found
    for finding in findings:
        print(f"finding: {finding}")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
