#!/usr/bin/env bash
# fuzz/coverage.sh TARGET FOLDER...: how much of src/ the inputs in these folders reach, as regions, functions and lines.
# Wants `rustup component add llvm-tools --toolchain nightly`. The libraries' code is built in as well and not counted.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
target=${1:?name a target of fuzz/README.md, and folders of inputs}
shift
folders=()
for folder in "$@"; do folders+=("$(realpath "$folder")"); done
tools=$(dirname "$(find "$(rustc +nightly --print sysroot)" -name llvm-profdata | head -1)")
cd "$here"
[ -e Cargo.lock ] || cp ../Cargo.lock Cargo.lock
RUSTFLAGS=-Cinstrument-coverage cargo +nightly build --quiet --release --bin cover --target-dir target/coverage
found=$(mktemp -d)
trap 'rm -rf "$found"' EXIT
LLVM_PROFILE_FILE="$found/%m.profraw" target/coverage/release/cover "$target" "${folders[@]}"
"$tools/llvm-profdata" merge -sparse "$found"/*.profraw -o "$found/all.profdata"
"$tools/llvm-cov" report target/coverage/release/cover --instr-profile "$found/all.profdata" --sources ../src |
    awk '/^Filename|^TOTAL/' | cut -c1-160
