#!/usr/bin/env bash
# Sends a noisy cloud through a curvd of its own and shows what comes back: demo.sh BIN_DIR RESULT_DIR
set -euo pipefail

bin=$1
results=$2
mkdir -p "$results"
log=$results/curvd.log
: >"$log"

"$bin/curvd" --listen=127.0.0.1:0 --metrics-listen=127.0.0.1:0 2>"$log" &
curvd=$!
stop_curvd() {
  kill -TERM "$curvd" 2>/dev/null || true
  wait "$curvd"
}
trap 'stop_curvd || cat "$log" >&2' EXIT

for _ in {1..300}; do
  server=$(sed -nE 's/.*"listen":"([^"]*)".*/\1/p' "$log")
  [ -z "$server" ] || break
  kill -0 "$curvd" 2>/dev/null || exit 1
  sleep 0.1
done
: "${server:?curvd did not start listening}"

run() {
  echo
  echo "\$ curv $*"
  "$bin/curv" "$@"
}
run info "--server=$server"
run generate goursat --points=100000 --noise-position=0.05 --noise-normal=0.1 --seed=1 -o "$results/goursat.ply"
run estimate "$results/goursat.ply" -o "$results/curvature.ply" --k=100 "--server=$server"
run evaluate "$results/curvature.ply"
run render "$results/curvature.ply" -o "$results/mean_curvature.png" --quantity=mean --range=-0.107:0.345
run render "$results/curvature.ply" -o "$results/gaussian_curvature.png" --quantity=gaussian --range=-0.034:0.119
run report "$results/curvature.ply" -o "$results/report.html"

cat <<TEXT

Done. Look at:
  $results/mean_curvature.png, $results/gaussian_curvature.png   the surface, colored by curvature
  $results/report.html                                      the same to turn and to click, in a browser
  $results/curvature.ply                                    points with curvature, for any point cloud viewer
  $results/curvd.log                                        what the server logged
TEXT
