#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md from the scenes of this repository (the billiard balls' is among docs/pictures).
# `docs/make_gallery.sh gloss temple` makes those alone.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
for maker in shapes dragon; do
    python3 scenes/make_$maker.py
done
python3 scenes/make_forest.py scenes/data/dragon.obj -o scenes/data/dragons.toml
mkdir -p docs/gallery
usual="dragon soft-shadows gloss translucency depth-of-field still-life temple textures dragons"
for name in ${*:-$usual}; do
    scene=scenes/$name.toml
    [ -e "$scene" ] || scene=scenes/data/$name.toml
    target/release/drt "$scene" -q -o "docs/gallery/$name.jpg"
done
du -h docs/gallery/*
