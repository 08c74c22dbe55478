#!/bin/bash
# Makes the evidence of the paper: numbers, plots, renders, and the tables of docs/paper/README.md.
#   bench/paper/run.sh BUILD_FOLDER [--quick]
# Stops at the first program that fails; docs/paper/ then stays as it was, or partly new where plotting fails.
set -euo pipefail
build=$1
shift
results=$build/paper
shared=../shared/data
output=docs/paper
rm -rf "$results"
mkdir -p "$results/clouds" "$output"
bench/report.py machine "$results" "$build" "$@"

# Times first: the machine has not been warmed up by anything else, and nothing runs beside them.
echo "== times"
"$build/bin/paper_times" --out="$results/times.csv" "$@" >"$results/times.log"
echo "== errors"
"$build/bin/paper_errors" --out="$results/errors.csv" --paper-clouds="$shared/paper" "$@" 2>"$results/errors.log"
echo "== the automatic choice"
"$build/bin/automatic_curves" --out="$results/automatic.csv" "$@"
echo "== curves"
bench/paper/curves.py "$results" "$output"
bench/paper/automatic.py "$results" "$output"
echo "== renders"
bench/paper/renders.sh "$build" "$results" "$shared"
bench/paper/pictures.py "$results/renders" "$output"
echo "== tables"
bench/paper/tables.py "$results" ../shared/measured/peers_accuracy.csv
bench/report.py tables "$results" "$output/README.md"
