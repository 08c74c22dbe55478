#!/usr/bin/env bash
# Fails if the kernels for AVX2 of these objects copy tables where they find neighbors: tables_stay.sh OBJECT...
#
# Highway keeps the tables of Compress in local constants. gcc copies one to the stack, 1 KiB, at each use, unless it is told that
# constants may share their addresses (CMakeLists.txt).
set -euo pipefail

searches=0
for object in "$@"; do
  code=$(objdump --disassemble --demangle --no-show-raw-insn "$object")
  counted=$(awk '/^[0-9a-f]+ </ { inside = /N_AVX2::/ && /FindNearest|GatherLeaves/; searches += inside }
                 inside && /rep movs|memcpy/ { ++copies; print > "/dev/stderr" }
                 END { print searches + 0, copies + 0 }' <<<"$code")
  searches=$((searches + ${counted% *}))
  if [ "${counted#* }" -ne 0 ]; then
    echo "$object copies tables where it searches" >&2
    exit 1
  fi
done
if [ "$searches" -eq 0 ]; then
  echo "no search for AVX2 in $*" >&2
  exit 1
fi
