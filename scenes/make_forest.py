#!/usr/bin/env python3
"""Write a scene file with one mesh in very many places, e.g. scenes/data/dragons.toml with 10,000 dragons.

  python3 scenes/make_forest.py scenes/data/dragon.obj --count 10000 -o scenes/data/dragons.toml
  drt scenes/data/dragons.toml --size 1280x720 --spp 16

The triangles are kept once. Needs nothing but Python 3; the same numbers every time.
"""
import argparse
import math
import os
import pathlib
import random

EARTH = 'type = "diffuse"\nreflectance = [0.30, 0.27, 0.20]'
MATERIALS = {
    "clay": 'type = "diffuse"\nreflectance = [0.62, 0.42, 0.30]',
    "jade": 'type = "plastic"\nreflectance = [0.16, 0.42, 0.20]\nroughness = 0.25',
    "gold": 'type = "conductor"\nmetal = "gold"\nroughness = 0.5',
    "slate": 'type = "diffuse"\nreflectance = [0.20, 0.24, 0.30]',
}


def size_of(mesh):
    """Smallest and largest corner of an OBJ's vertices."""
    low, high = [math.inf] * 3, [-math.inf] * 3
    with open(mesh, "rb") as lines:
        for line in lines:
            if line.startswith(b"v "):
                for k, word in enumerate(line.split()[1:4]):
                    low[k], high[k] = min(low[k], float(word)), max(high[k], float(word))
    return low, high


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("mesh", type=pathlib.Path)
    words.add_argument("--count", type=int, default=10_000)
    words.add_argument("--copies", action="store_true", help="copy the triangles, to compare (for small counts)")
    words.add_argument("-o", "--output", type=pathlib.Path, required=True)
    words = words.parse_args()
    low, high = size_of(words.mesh)
    height, across = high[1] - low[1], max(high[0] - low[0], high[2] - low[2])
    middle = [-(low[k] + high[k]) / 2 for k in range(3)]
    middle[1] = -low[1]
    numbers = random.Random(8)
    side = math.ceil(math.sqrt(words.count))
    step = 1.35 * across / height
    places = []
    for i in range(words.count):
        x = (i % side - side / 2 + 0.35 * numbers.uniform(-1, 1)) * step
        z = (-(i // side) + 0.35 * numbers.uniform(-1, 1)) * step
        scale, angle = numbers.uniform(0.75, 1.25), numbers.uniform(0, 360)
        material = numbers.choices(list(MATERIALS), [8, 4, 1, 4])[0]
        places.append(
            f"  {{ scale = {scale:.4f}, rotate = {{ axis = [0, 1, 0], angle = {angle:.2f} }}, "
            f'translate = [{x:.4f}, 0, {z:.4f}], material = "{material}" }},'
        )
    folder = words.output.parent or "."
    file, floor = (os.path.relpath(f, folder) for f in (words.mesh, pathlib.Path(__file__).parent / "floor.obj"))
    with open(words.output, "w") as out:
        out.write(f"""# {words.count} of {words.mesh.name}: made by scenes/make_forest.py.

[camera]
position = [0, 3.4, {3.5 * step:.3f}]
look_at = [0, 0.9, {-6 * step:.3f}]
fov = 40

[film]
size = [640, 360]

[render]
spp = 32
max_depth = 6

[[light]]
type = "sun-sky"
elevation = 24
azimuth = 120
turbidity = 3
scale = 0.013

[[mesh]]
file = "{floor}"
material = "earth"
transform = {{ scale = 100 }}

[[mesh]]
file = "{file}"
normals = "smooth"
instance = {str(not words.copies).lower()}
# Stands on the ground, one metre high.
transform = {{ matrix = [{1 / height:.9g}, 0, 0, {middle[0] / height:.9g}, 0, {1 / height:.9g}, 0, {middle[1] / height:.9g}, 0, 0, {1 / height:.9g}, {middle[2] / height:.9g}, 0, 0, 0, 1] }}
instances = [
""")
        out.write("\n".join(places))
        out.write("\n]\n")
        for name, keys in [*MATERIALS.items(), ("earth", EARTH)]:
            out.write(f"\n[materials.{name}]\n{keys}\n")


main()
