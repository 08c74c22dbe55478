#!/usr/bin/env bash
# Checks that programs were built so that a bug in them is hard to use: hardened.sh PROGRAM...
set -euo pipefail

failures=0
# check PROGRAM WHAT COMMAND...: the command must succeed.
check() {
  "${@:3}" || { echo "$1: $2"; failures=$((failures + 1)); }
}
# Reads all of it: readelf must not fail because nobody listens.
shows() { readelf "$1" --wide "$3" | grep -E -- "$2" >/dev/null; }
hides() { ! shows "$@"; }

for program in "$@"; do
  check "$program" "is no position-independent executable" shows --file-header 'Type: +DYN' "$program"
  check "$program" "has no read-only relocations" shows --program-headers 'GNU_RELRO' "$program"
  check "$program" "binds functions late" shows --dynamic 'BIND_NOW|Flags:.* NOW' "$program"
  check "$program" "tells nothing about its stack" shows --program-headers 'GNU_STACK' "$program"
  check "$program" "has a stack that may be executed" hides --program-headers 'GNU_STACK .* RWE' "$program"
  check "$program" "has a segment that may be written and executed" hides --program-headers 'LOAD .* RWE' "$program"
  check "$program" "does not guard its stack" shows --dyn-syms ' __stack_chk_fail(@|$)' "$program"
  check "$program" "calls no fortified function" shows --dyn-syms ' __[a-z]+_chk(@|$)' "$program"
  check "$program" "looks for libraries where it was built" hides --dynamic '\((RPATH|RUNPATH)\)' "$program"
done
[ "$failures" -eq 0 ] || exit 1
echo "hardened: $*"
