#!/usr/bin/env bash
# Makes the pictures of docs/notes.md from the scenes of this repository.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
drt=target/release/drt
out=docs/pictures
mkdir -p "$out"

# 13.2–13.6: one detail below a pixel, four points a pixel, three rules.
for rule in uniform random stratified; do
    "$drt" scenes/checkerboard.toml -q --spp 4 --set film.rule=$rule -o "$out/pixel-$rule.png"
done

# 13.5–13.8: direct light by 64 directions at every hit, seen from the pixels' centres.
for rule in uniform random stratified nonuniform sobol importance; do
    "$drt" scenes/cornell-box.toml -q --size 200x200 --max-depth 1 \
        --set film.rule='{ type = "uniform", grid = [1, 1] }' \
        --set render.integrator="{ type = \"distribution\", rule = \"$rule\", directions = [[8, 8]] }" \
        -o "$out/hemisphere-$rule.png"
done

# 13.2–13.8: how fast each rule converges.
"$drt" converge smooth -q -o "$out/converge-smooth.svg"
"$drt" converge step -q -o "$out/converge-step.svg"
"$drt" converge scenes/cornell-box.toml -q --max-n 1024 -o "$out/converge-cornell-box.svg"
du -h "$out"/*
