#!/usr/bin/env bash
# Estimates the tiles of a plan that are not done by GNU parallel, each by `curv tiles run DIR --tile=N`:
#   run.sh DIR HOST:PORT[,HOST:PORT...] [FLAGS OF PARALLEL...]
# Ends with the number of tiles that failed five times. Run again, it does what is left.
set -euo pipefail
if (($# < 2)); then
  echo "usage: run.sh DIR HOST:PORT[,HOST:PORT...] [FLAGS OF PARALLEL...]" >&2
  exit 2
fi
directory=$1 servers=$2
IFS=, read -ra each <<<"$servers"

left=$(curv tiles status "$directory" --left)
# Two tiles for each server: while one is estimated, another is read or written. Servers share the calls.
exec parallel --will-cite --quote --no-run-if-empty --jobs=$((2 * ${#each[@]})) --retries=5 "${@:3}" \
  curv tiles run "$directory" --tile={} --server="$servers" <<<"$left"
