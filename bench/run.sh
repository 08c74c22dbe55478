#!/bin/bash
# Runs every benchmark program of a build, then writes docs/benchmarks.md's tables and plots.
#   bench/run.sh BUILD_FOLDER [--quick | --full] [--rounds=N]
# Stops at the first program that fails: its comparison is void, and the document stays as it was.
set -euo pipefail
build=$1
shift
results=$build/results
rm -rf "$results"
mkdir -p "$results"
bench/report.py machine "$results" "$build" "$@"
for program in core search estimator scaling service; do
  echo "== ${program}_bench $*"
  "$build/bin/${program}_bench" --out="$results" "$@"
done
bench/plot.py "$results" docs/images
bench/report.py tables "$results" docs/benchmarks.md
