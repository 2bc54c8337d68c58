#!/usr/bin/env bash
# fuzz/counters.sh RUSTC ARGUMENT...: compiles as cargo fuzz asks (RUSTC_WRAPPER), but puts libFuzzer's counters into drt
# and the targets alone. A new path through a library is no finding about drt, and its counters take more time than drt's.
set -euo pipefail
compiler=$1
shift
crate='' before=''
for word in "$@"; do
  [ "$before" != --crate-name ] || crate=$word
  before=$word
done
here=$(dirname "$0")
if [ "$crate" = drt ] || [ "$crate" = drt_fuzz ] || [ -e "$here/fuzz_targets/$crate.rs" ]; then
  exec "$compiler" "$@"
fi
kept=()
for word in "$@"; do
  case $word in
    -Cpasses=sancov-module | -Cllvm-args=-sanitizer-coverage-* | -Cllvm-args=-sanitizer-trace-*) ;;
    *) kept+=("$word") ;;
  esac
done
exec "$compiler" "${kept[@]}"
