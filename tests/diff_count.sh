#!/usr/bin/env bash
# Asks everybody about many rays over several scenes and prints a row a scene: no disagreement may be real.
#
#   tests/diff_count.sh RAYS INPUT...       RAYS of each kind, e.g. 250000 scenes/cornell-box.toml grid.obj hall.obj
#
# tests/diff_meshes.py makes grid.obj and hall.obj, scenes/make_dragon.py the dragon. DRT names the program (default:
# target/release/drt), OUT a folder for the reports (default: diff-count). docs/diff-backends.md says how to read it.
set -euo pipefail

[ $# -ge 2 ] || { sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0" >&2; exit 2; }
drt=${DRT:-$(dirname "$0")/../target/release/drt}
out=${OUT:-diff-count}
rays=$1
shift
mkdir -p "$out"
printf '%-20s %10s %12s %9s %9s %9s %9s %9s %6s %8s\n' scene rays answers tie edge vertex graze sliver real failures
worst=0
for input in "$@"; do
  name=$(basename "${input%.*}")
  "$drt" diff-backends "$input" --rays "$rays" --quiet --progress none -o "$out/$name" 2>"$out/$name.log" || worst=1
  [ -e "$out/$name/report.json" ] || { cat "$out/$name.log" >&2; exit 1; }
  python3 - "$name" "$out/$name/report.json" <<'EOF'
import json, sys
name, path = sys.argv[1:]
with open(path) as file:
    report = json.load(file)
t = report["totals"]
counts = " ".join(f"{t[c]:9}" for c in ("tie", "edge", "vertex", "graze", "sliver"))
print(f"{name:20} {sum(report['rays'].values()):10} {t['rays']:12} {counts} {t['real']:6} {t['failures']:8}", flush=True)
EOF
done
exit $worst
