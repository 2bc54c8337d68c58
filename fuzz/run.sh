#!/usr/bin/env bash
# fuzz/run.sh TARGET [EXECUTIONS]: runs a target from its seeds. The corpus grows in fuzz/corpus/TARGET.
set -euo pipefail
cd "$(dirname "$0")/.."
target=${1:?name a target of fuzz/README.md} executions=${2:-10000000}
mkdir -p "fuzz/corpus/$target"
# What is fuzzed is what is built: the same versions of everything.
[ -e fuzz/Cargo.lock ] || cp Cargo.lock fuzz/Cargo.lock
# No address sanitizer: the readers and the hierarchy's builder are safe Rust, and run five times as fast without.
exec cargo +nightly fuzz run --sanitizer none "$target" \
  "fuzz/corpus/$target" "fuzz/seeds/$target" -- \
  -runs="$executions" -timeout=20 -rss_limit_mb=3000 -max_len=8192 -print_final_stats=1
