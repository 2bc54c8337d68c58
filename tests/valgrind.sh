#!/usr/bin/env bash
# drt under valgrind: what Embree, the system's calls and the rooms for unsafe code might do wrong in silence. A wrong
# read or write, a value that was never set and memory that is lost are failures; so is any exit code but the expected.
#
#   tests/valgrind.sh [quick]
#
# It covers small renders on both backends (build qualities, instruction sets, outputs, threads), every subcommand, and
# the error paths of the command line: the rows C1–C5 of tests/README.md and missing and broken files of every kind that
# is read. "quick" leaves the error paths out. It does not cover AVX-512, which valgrind 3.19 does not know and tells
# programs so (drt and Embree then take AVX2 of themselves), large scenes, and signals. Nothing is suppressed. Some
# four minutes on a machine that does nothing else.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'valgrind: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

command -v valgrind >/dev/null || fail "missing: valgrind (apt-get install valgrind)"
command -v cargo >/dev/null || fail "missing: cargo (https://rustup.rs)"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/logs"

# Exit code 99 is no code of drt's. Messages go to a file a process: standard error belongs to drt.
runner="valgrind -q --error-exitcode=99 --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite --num-callers=30 \
--log-file=$work/logs/%p"

say "building"
cargo build --release --quiet --bin drt
drt=$PWD/target/release/drt
[ -z "${CARGO_TARGET_DIR:-}" ] || drt=$(realpath "$CARGO_TARGET_DIR")/release/drt
backends=$("$drt" --version | grep -q -i embree && echo embree bvh || echo bvh)

runs=0
# run CODE WORDS...: drt with these words must end with CODE, and say one "error:" line where that is not 0.
run() {
  local expected=$1 code=0
  shift
  # shellcheck disable=SC2086
  $runner "$drt" "$@" >"$work/out" 2>"$work/err" </dev/null || code=$?
  runs=$((runs + 1))
  [ "$code" = "$expected" ] && { [ "$code" = 0 ] || [ "$(grep -c '^error:' "$work/err")" = 1 ]; } && return
  cat "$work/err" "$work"/logs/* >&2
  fail "drt $*: exit code $code, not $expected"
}

scene=$PWD/scenes/cornell-box.toml
tiny=(--size 4x3 --spp 1 --threads 1 --progress none)
cd "$work"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >t.obj

renders() {
  local small
  for backend in $backends; do
    say "renders with $backend"
    small=(--backend "$backend" --size 17x13 --spp 2 --threads 2 --progress none)
    run 0 "$scene" "${small[@]}" -o "$backend.exr" -o "$backend.png" --stats stats.json
    run 0 "$scene" "${small[@]}" --isa sse2 --crop 3,3,9,5 --aov depth,normal,albedo,position,uv,ids -o aov.exr
    run 0 t.obj "${small[@]}" --set render.build=low --ground -o low.jpg
    run 0 t.obj "${small[@]}" --set render.compact=true --integrator ao -o ao.hdr
    run 0 "$scene" "${small[@]}" --max-depth 2 -o dis.pfm \
      --set 'render.integrator={ type = "distribution", rule = "stratified", directions = [[2, 2], 1] }'
  done
  say "the other subcommands"
  run 0 --version
  run 0 --help
  run 0 check "$scene" --json
  run 0 compare bvh.exr "${backends%% *}.exr" --json
  run 0 converge smooth --quiet -o smooth.csv
  run 0 diff-backends t.obj --rays 100 --quiet
}

# C1, C2: words and numbers.
words() {
  say "C1, C2: words and numbers that cannot be"
  local wrong
  for wrong in 0x0 1x 4294967296x4294967296 -5x3 65536x65536; do run 2 t.obj "--size=$wrong" -o x.png; done
  for wrong in --spp=-1 --spp=nan --spp=0 --max-depth=x --seed=1e400 --threads=0 --backend=none --isa=mmx \
    --integrator=none --crop=9,9,9,9 --aov=none --exposure=nan --progress=none2 --no-such-flag; do
    run 2 t.obj "${tiny[@]:0:4}" "$wrong" -o x.png
  done
  run 2
  run 2 compare only-one.exr
  run 1 converge nothing-such --quiet
  run 2 diff-backends t.obj --contestants nobody
  run 2 diff-backends t.obj --rays 0
  run 2 t.obj --set film.fliter=box -o x.png
  run 2 t.obj --set nonsense -o x.png
}

# C3: inputs.
inputs() {
  say "C3: inputs that are none"
  local command
  mkdir folder
  : >empty.obj
  : >empty.toml
  head -c 3000 "$drt" >binary.obj
  printf 'v 0 0 0\nv nan 1 1e99\nv 0 1 0\nf 1 2 3\n' >nan.obj
  printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\nf 0 1 2\nf -9 1 2\nf 99999999999999999999 1 2\nf 1//7 2/8 3\n' >index.obj
  printf '\xff\xfev\0 \0' >utf16.obj
  printf '[film]\nsize = [4, \n' >syntax.toml
  printf '[[mesh]]\nfile = "no-such.obj"\n' >nothing.toml
  printf '[flim]\n' >misspelt.toml
  printf '[case]\nmesh = "no-such.obj"\norigin = [0, 0, 0]\n' >case-1.toml
  printf 'mtllib no-such.mtl t.mtl\nusemtl m\n' | cat - t.obj >materials.obj
  printf 'newmtl m\nKd 9 nan x\nmap_Kd no-such.png\nmap_Ke broken.png\n' >t.mtl
  head -c 60 bvh.png >broken.png
  head -c 700 bvh.exr >broken.exr
  printf 'PF\n9999999 9999999\n-1\n' >broken.pfm
  for input in no-such.obj folder empty.obj empty.toml binary.obj nan.obj utf16.obj syntax.toml nothing.toml \
    misspelt.toml case-1.toml; do
    run 1 "$input" "${tiny[@]}" -o x.png
  done
  for command in check diff-backends; do
    for input in no-such.obj empty.obj nan.obj syntax.toml; do run 1 "$command" "$input"; done
  done
  run 1 diff-backends case-1.toml
  run 0 index.obj "${tiny[@]}" -o x.png
  run 1 index.obj "${tiny[@]}" --strict -o x.png
  run 0 materials.obj "${tiny[@]}" -o x.png
  run 1 materials.obj "${tiny[@]}" --strict -o x.png
  run 1 compare bvh.exr no-such.exr
  for input in broken.png broken.exr broken.pfm t.obj; do run 1 compare bvh.exr "$input"; done
}

# C4, C5: outputs.
outputs() {
  say "C4, C5: outputs that cannot be, readers that went away"
  local output
  for output in no-such/x.png folder x.bmp x t.obj; do
    run_any "1 2" t.obj "${tiny[@]}" -o "$output"
  done
  run 1 t.obj "${tiny[@]}" -o x.png --stats no-such/stats.json
  run 1 diff-backends t.obj --rays 10 -o t.obj
  for command in "--help" "check t.obj" "check t.obj --json" "compare bvh.exr bvh.exr"; do
    # shellcheck disable=SC2086
    { $runner "$drt" $command || [ $? != 99 ]; } 2>"$work/err" | true
    ! grep -q panicked err || fail "drt $command | true: panicked"
  done
}

# As run, with one of several codes.
run_any() {
  local codes=$1 code=0
  shift
  # shellcheck disable=SC2086
  $runner "$drt" "$@" >"$work/out" 2>"$work/err" </dev/null || code=$?
  runs=$((runs + 1))
  case " $codes " in *" $code "*) ;; *) cat err logs/* >&2; fail "drt $*: exit code $code, not one of $codes" ;; esac
}

renders
if [ "${1:-}" != quick ]; then words; inputs; outputs; fi

wrong=$(find logs -type f -size +0 | wc -l)
total=$(find logs -type f | wc -l)
if [ "$wrong" != 0 ]; then
  find logs -type f -size +0 -exec cat {} + >&2
  fail "$wrong of $total processes have errors"
fi
say "$runs runs, $total processes, none with an error"
