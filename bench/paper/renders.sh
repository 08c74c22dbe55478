#!/bin/bash
# Renders for Figures 6, 7 and 8 and the supplement, by the client: bench/paper/renders.sh BUILD RESULTS SHARED_DATA
# RESULTS/renders/ gets FIGURE__ROW__COLUMN.png, and panels.csv with each one's color range and the file it shows;
# pictures.py puts them together.
set -euo pipefail
curv=$1/bin/curv
paper_cloud=$1/bin/paper_cloud
clouds=$2/clouds
out=$2/renders
shared=$3
mkdir -p "$clouds" "$out"
echo figure,row,column,low,high,source >"$out/panels.csv"

# The paper's color ranges.
declare -A range=([goursat-mean]=-0.107:0.345 [goursat-gaussian]=-0.034:0.119
                  [torus-mean]=0.125:0.32 [torus-gaussian]=-0.125:0.0625)
declare -A flags=([exact]="" [jet-2]="--estimator=jet --jet-degree=2" [jet-4]="--estimator=jet --jet-degree=4"
                  [aso]="--estimator=aso" [uniform-100]="--estimator=uniform --triangles=100"
                  [uniform-200]="--estimator=uniform --triangles=200"
                  [hexagram]="--estimator=hexagram" [avg-hexagram]="--estimator=avg-hexagram --rotations=1")

# estimate CLOUD METHOD K RESULT
estimate() {
  # shellcheck disable=SC2086
  "$curv" estimate "$1" ${flags[$2]} --k="$3" -o "$4" >/dev/null
}

# render FIGURE ROW COLUMN RESULT QUANTITY RANGE SOURCE FLAGS...
render() {
  local name="$1__$2__$3"
  "$curv" render "$4" --quantity="$5" --range="$6" --size=527x400 -o "$out/$name.png" "${@:8}" >/dev/null
  echo "$1,$2,$3,${6/:/,},$7" >>"$out/panels.csv"
}

# compare FIGURE ROW SURFACE CLOUD METHOD...: mean and Gaussian curvature with K = 50; "exact" is the file's truth
compare() {
  local figure=$1 row=$2 surface=$3 cloud=$4 method quantity result
  for method in "${@:5}"; do
    result=$cloud
    if [ "$method" != exact ]; then
      result=$clouds/result.ply
      estimate "$cloud" "$method" 50 "$result"
    fi
    for quantity in mean gaussian; do
      render "$figure" "$row-$quantity" "$method" "$result" $quantity "${range[$surface-$quantity]}" "${cloud##*/}"
    done
  done
}

for noise in 0 0.1; do
  cloud=$clouds/goursat-$noise.ply
  "$curv" generate goursat --points=25000 --seed=1 --noise-position=$noise --noise-normal=$noise -o "$cloud" >/dev/null
  compare figure6 $noise goursat "$cloud" exact jet-2 jet-4 aso uniform-100 hexagram avg-hexagram
done

# The paper's clouds of uneven density where they are, else ours of the same kind.
for surface in goursat torus; do
  for kind in filter:thinned lidar:scanned; do
    given=$shared/paper/$surface-${kind%:*}.pts
    [ -e "$given" ] || given=${kind#*:}
    cloud=$clouds/$surface-${kind#*:}.ply
    "$paper_cloud" $surface "$given" "$cloud"
    compare supplement-$surface "${kind#*:}" $surface "$cloud" exact jet-2 aso uniform-200 hexagram avg-hexagram
  done
done

# The scan, its normals turned to one side; without it, a closed surface of about as many points.
scan=$clouds/scan.ply
if [ -e "$shared/scans/armadillo100k.ply" ]; then
  source=armadillo100k.ply
  view=(--up=y --view=215:15)
  "$curv" orient "$shared/scans/armadillo100k.ply" -o "$scan" >/dev/null
else
  source=goursat
  view=()
  "$curv" generate goursat --points=100000 --seed=1 -o "$scan" >/dev/null
fi
estimate "$scan" avg-hexagram 50 "$clouds/scan-50.csv"
for quantity in gaussian mean k1 k2; do
  scale=$(bench/paper/color_range.py "$clouds/scan-50.csv" $quantity)
  render figure7 all $quantity "$clouds/scan-50.csv" $quantity "$scale" $source "${view[@]}"
done
scale=$(bench/paper/color_range.py "$clouds/scan-50.csv" mean)
for k in 20 50 80 100 200 300 1000 2000 3000; do
  estimate "$scan" hexagram $k "$clouds/result.ply"
  render figure8 all $k "$clouds/result.ply" mean "$scale" $source "${view[@]}"
done

# What auto chooses on the scan, beside fixed numbers of neighbors.
"$curv" estimate "$scan" --auto --also=chosen_neighbor_count -o "$clouds/scan-auto.csv" >/dev/null
chosen=$(bench/paper/color_range.py "$clouds/scan-auto.csv" chosen_neighbor_count)
render automatic all chosen "$clouds/scan-auto.csv" chosen_neighbor_count "$chosen" $source "${view[@]}"
render automatic all auto "$clouds/scan-auto.csv" mean "$scale" $source "${view[@]}"
for k in 32 300; do
  estimate "$scan" avg-hexagram $k "$clouds/result.ply"
  render automatic all $k "$clouds/result.ply" mean "$scale" $source "${view[@]}"
done
