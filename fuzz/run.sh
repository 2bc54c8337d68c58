#!/usr/bin/env bash
# fuzz/run.sh TARGET [EXECUTIONS]: runs a target from its seeds and from what earlier runs found (fuzz/grown). The corpus grows in
# fuzz/corpus/TARGET.
set -euo pipefail
cd "$(dirname "$0")/.."
target=${1:?name a target of fuzz/README.md} executions=${2:-10000000}
mkdir -p "fuzz/corpus/$target"
# What is fuzzed is what is built: the same versions of everything.
[ -e fuzz/Cargo.lock ] || cp Cargo.lock fuzz/Cargo.lock
# A seed of the target needs so many bytes: a tile of a checkpoint with layers has 9 KiB.
case $target in checkpoint) most=12288 ;; bvh) most=512 ;; *) most=4096 ;; esac
from=("fuzz/seeds/$target")
[ ! -e "fuzz/grown/$target" ] || from+=("fuzz/grown/$target")
dictionary=()
[ ! -e "fuzz/dict/$target.dict" ] || dictionary=("-dict=fuzz/dict/$target.dict")
# Large buffers, which readers ask for and give back at every execution, come from the heap instead of the kernel, which
# would clear their pages each time: five times as fast.
export MALLOC_MMAP_THRESHOLD_=1073741824 MALLOC_TRIM_THRESHOLD_=4294967296 MALLOC_TOP_PAD_=67108864
export RUSTC_WRAPPER="$PWD/fuzz/counters.sh"
# No address sanitizer: the readers and the hierarchy's builder are safe Rust, and run five times as fast without.
exec cargo +nightly fuzz run --sanitizer none "$target" \
  "fuzz/corpus/$target" "${from[@]}" -- \
  -runs="$executions" -timeout=20 -rss_limit_mb=3000 -max_len="$most" -print_final_stats=1 "${dictionary[@]}"
