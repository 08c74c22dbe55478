#!/usr/bin/env bash
# run.sh PROGRAMS TIMES CANCELS: all that `make fault` tries. Prints tables; ends with status 1 on a finding.
set -uo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
programs=$1 times=$2 cancels=$3
status=0
PYTHONPATH=$programs/../python /usr/bin/python3 "$here/run.py" --programs "$programs" --times "$times" || status=1
for connections in 500 100 4; do
  printf '\n'
  "$programs/fault_streams" --curvd="$programs/curvd" --connections=$connections || status=1
done
printf '\n'
"$programs/fault_cancels" --curvd="$programs/curvd" --cancels="$cancels" || status=1
printf '\n'
"$programs/fault_fairness" --curvd="$programs/curvd" || status=1
printf '\n'
"$programs/fault_callers" --curvd="$programs/curvd" --times="$times" || status=1
exit $status
