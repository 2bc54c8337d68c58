#!/usr/bin/env bash
# drt under valgrind: small renders on both backends, every subcommand, and all mistakes that the tests of the command
# line make. A wrong read or write, a value that was never set and memory that is lost are failures.
#
#   tests/valgrind.sh [quick]        "quick" leaves the mistakes out
#
# valgrind 3.19 knows no AVX-512 and tells programs so; drt and Embree then take AVX2 of themselves. Nothing is
# suppressed. Some 20 minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'valgrind: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

command -v valgrind >/dev/null || fail "missing: valgrind (apt-get install valgrind)"
command -v cargo >/dev/null || fail "missing: cargo (https://rustup.rs)"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/logs"

# Exit code 99 is no code of drt's, so that a test that expects another one fails as well. Messages go to a file a
# process: standard error belongs to the tests.
runner="valgrind -q --error-exitcode=99 --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite --num-callers=30 \
--log-file=$work/logs/%p"

say "building"
cargo build --release --quiet
drt=$PWD/${CARGO_TARGET_DIR:-target}/release/drt
[ -x "$drt" ] || drt=${CARGO_TARGET_DIR:-target}/release/drt
backends=$("$drt" --version | grep -q -i embree && echo embree bvh || echo bvh)

runs=0
# run CODE WORDS...: drt with these words must end with CODE.
run() {
  local expected=$1 code=0
  shift
  # shellcheck disable=SC2086
  $runner "$drt" "$@" >"$work/out" 2>"$work/err" || code=$?
  runs=$((runs + 1))
  [ "$code" = "$expected" ] && return
  cat "$work/err" "$work"/logs/* >&2
  fail "drt $*: exit code $code, not $expected"
}

scene=$PWD/scenes/cornell-box.toml
cp "$PWD"/scenes/*.obj "$work" 2>/dev/null || true
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >"$work/t.obj"
for backend in $backends; do
  say "renders with $backend"
  small=(--backend "$backend" --size 17x13 --spp 2 --threads 2 --progress none)
  run 0 "$scene" "${small[@]}" -o "$work/$backend.exr" -o "$work/$backend.png" --stats "$work/stats.json"
  run 0 "$scene" "${small[@]}" --isa sse2 --crop 3,3,9,5 --aov depth,normal,albedo,position,uv,ids -o "$work/aov.exr"
  run 0 "$work/t.obj" "${small[@]}" --set render.build=low --ground -o "$work/low.jpg"
  run 0 "$work/t.obj" "${small[@]}" --set render.compact=true --integrator ao -o "$work/ao.hdr"
  run 0 "$scene" "${small[@]}" --max-depth 2 -o "$work/dis.pfm" \
    --set 'render.integrator={ type = "distribution", rule = "stratified", directions = [[2, 2], 1] }'
done
say "the other subcommands"
run 0 --version
run 0 check "$scene" --json
run 0 compare "$work/bvh.exr" "$work/${backends%% *}.exr" --json
run 0 converge smooth --quiet -o "$work/smooth.csv"
run 0 diff-backends "$work/t.obj" --rays 200 --quiet

if [ "${1:-}" != quick ]; then
  say "the mistakes of tests/cli"
  target=$(rustc -vV | sed -n 's/^host: //p' | tr 'a-z-' 'A-Z_')
  tests=$(cargo test --release --test cli --no-run --message-format=json 2>/dev/null |
    sed -n 's/.*"executable":"\([^"]*cli-[0-9a-f]*\)".*/\1/p' | tail -n 1)
  [ -x "$tests" ] || fail "the tests of the command line could not be built"
  # Left out: whole studies and long renders, which are correct or wrong elsewhere, and what limits the process' memory.
  env "CARGO_TARGET_${target}_RUNNER=$runner" "$tests" --test-threads "$(nproc)" \
    mistakes:: usage:: files:: check:: rows_command:: rows_files:: \
    --skip c1_sizes_beyond --skip a13_an_endless_line --skip b10_pipes --skip c5_a_reader >"$work/tests" 2>&1 ||
    { tail -n 60 "$work/tests" >&2; cat "$work"/logs/* >&2; fail "a test failed under valgrind"; }
  grep '^test result' "$work/tests" >&2
fi

wrong=$(find "$work/logs" -type f -size +0 | wc -l)
total=$(find "$work/logs" -type f | wc -l)
if [ "$wrong" != 0 ]; then
  find "$work/logs" -type f -size +0 -exec cat {} + >&2
  fail "$wrong of $total processes have errors"
fi
say "$total processes, none with an error"
