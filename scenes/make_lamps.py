#!/usr/bin/env python3
"""Make scenes/data/galaxy.obj and .mtl, a spiral of 100,000 tiny lamps in five colours, for many-lamps.toml.

Needs nothing but Python 3; the same numbers every time.
"""
import math
import pathlib
import random

COUNT = 100_000
COLOURS = {"ember": (9.0, 2.6, 0.9), "amber": (9.0, 5.2, 1.8), "white": (7.0, 6.6, 6.0), "ice": (3.0, 5.4, 9.0), "violet": (4.6, 2.2, 9.0)}

numbers = random.Random(7)
folder = pathlib.Path(__file__).parent / "data"
folder.mkdir(exist_ok=True)
lamps = {name: [] for name in COLOURS}
vertices = []
for i in range(COUNT):
    # Two arms, denser in the middle; colours go from warm to cold outwards.
    radius = 3.0 * numbers.random() ** 0.6
    arm = math.pi * numbers.randrange(2) + 1.9 * radius + numbers.gauss(0, 0.28)
    x, z = radius * math.cos(arm), radius * math.sin(arm)
    y = 0.55 + 0.05 * math.exp(-radius) * numbers.gauss(0, 1) + 0.02 * numbers.gauss(0, 1)
    shade = min(len(COLOURS) - 1, max(0, int(radius / 3.0 * len(COLOURS) + numbers.gauss(0, 0.7))))
    size = 0.004
    corners = []
    for _ in range(3):
        corners.append([c + size * numbers.gauss(0, 1) for c in (x, y, z)])
    lamps[list(COLOURS)[shade]].append(len(vertices) + 1)
    vertices += corners

with open(folder / "galaxy.obj", "w") as out:
    out.write("mtllib galaxy.mtl\n")
    for v in vertices:
        out.write("v %.5f %.5f %.5f\n" % tuple(v))
    for name, faces in lamps.items():
        out.write(f"usemtl {name}\n")
        for first in faces:
            out.write(f"f {first} {first + 1} {first + 2}\n")
with open(folder / "galaxy.mtl", "w") as out:
    for name, colour in COLOURS.items():
        out.write("newmtl %s\nKd 0 0 0\nKe %g %g %g\n" % (name, *(2.5 * c for c in colour)))
print(f"wrote {COUNT} lamps to {folder / 'galaxy.obj'}")
