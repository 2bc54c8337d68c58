#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md from the scenes of this repository, and docs/dragon.jpg of the README.
# `docs/make_gallery.sh gloss temple` makes those alone.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
for maker in shapes dragon lamps; do
    python3 scenes/make_$maker.py
done
mkdir -p docs/gallery
usual="dragon soft-shadows gloss translucency depth-of-field still-life temple textures materials many-lamps"
for scene in ${*:-$usual}; do
    target/release/drt "scenes/$scene.toml" -q -o "docs/gallery/$scene.jpg"
done
du -h docs/gallery/*
