#!/usr/bin/env python3
"""Make meshes for tests/diff_count.sh: python3 tests/diff_meshes.py FOLDER writes grid.obj and hall.obj.

grid: a city of blocks on an integer grid. Every ray along an axis runs within planes, through edges and vertices.
hall: boards, pipes and braces of some 100,000 triangles, up to 50 m long and a few millimetres wide.
"""
import math
import pathlib
import random
import sys


class Obj:
    """A mesh under construction."""

    def __init__(self):
        self.lines, self.vertices, self.faces = [], 0, 0

    def face(self, *corners):
        self.lines += ["v %.6g %.6g %.6g" % tuple(p) for p in corners]
        names = range(self.vertices + 1, self.vertices + 1 + len(corners))
        self.lines.append("f " + " ".join(map(str, names)))
        self.vertices += len(corners)
        self.faces += len(corners) - 2

    def pipe(self, start, end, radius, sides):
        along = unit([b - a for a, b in zip(start, end)])
        least = min(range(3), key=lambda i: abs(along[i]))
        right = unit(cross(along, [float(i == least) for i in range(3)]))
        up, first = cross(along, right), self.vertices + 1
        for i in range(sides):
            cos, sin = math.cos(math.tau * i / sides), math.sin(math.tau * i / sides)
            out = [(r * cos + u * sin) * radius for r, u in zip(right, up)]
            for p in (start, end):
                self.lines.append("v %.6g %.6g %.6g" % tuple(a + b for a, b in zip(p, out)))
        for i in range(sides):
            a, b = first + 2 * i, first + 2 * ((i + 1) % sides)
            self.lines += [f"f {a} {b} {a + 1}", f"f {b} {b + 1} {a + 1}"]
        self.vertices += 2 * sides
        self.faces += 2 * sides


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return [x / length for x in a]


def grid(n=120):
    mesh, choose = Obj(), random.Random(7)
    high = [[choose.choice([0, 0, 0, 1, 1, 2, 3, 5]) for _ in range(n)] for _ in range(n)]
    for y in range(n):
        for x in range(n):
            z = high[y][x]
            mesh.face((x, z, y), (x, z, y + 1), (x + 1, z, y + 1), (x + 1, z, y))
            if x + 1 < n and high[y][x + 1] != z:
                w = high[y][x + 1]
                mesh.face((x + 1, z, y), (x + 1, z, y + 1), (x + 1, w, y + 1), (x + 1, w, y))
            if y + 1 < n and high[y + 1][x] != z:
                w = high[y + 1][x]
                mesh.face((x, z, y + 1), (x + 1, z, y + 1), (x + 1, w, y + 1), (x, w, y + 1))
    return mesh


def hall():
    mesh, choose = Obj(), random.Random(13)
    x, y, z = 50.0, 14.0, 24.0
    for i in range(600):
        a, b = z * i / 600, z * (i + 1) / 600
        for level in (0, y):
            mesh.face((0, level, a), (x, level, a), (x, level, b), (0, level, b))
        a, b = x * i / 600, x * (i + 1) / 600
        for side in (0, z):
            mesh.face((a, 0, side), (a, y, side), (b, y, side), (b, 0, side))
    for end in (0, x):
        mesh.face((end, 0, 0), (end, y, 0), (end, y, z), (end, 0, z))
    while mesh.faces < 100_000:
        at = [choose.uniform(0, x), choose.uniform(8, y), choose.uniform(0, z)]
        low = [choose.uniform(0, x), choose.uniform(0.5, y), choose.uniform(0, 1.5)]
        mesh.pipe((0, at[1], at[2]), (x, at[1], at[2]), 0.04, 12)
        mesh.pipe((at[0], at[1], 0), (at[0], at[1], z), 0.03, 12)
        mesh.pipe(at, (at[0], y + 0.1, at[2]), 0.01, 8)
        mesh.pipe(low, (low[0], y, low[2]), 0.05, 12)
        mesh.pipe(at, (at[0] + 5, at[1] + 2, at[2] + low[2] - 0.2 * at[2]), 0.02, 8)
    return mesh


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    for make in (grid, hall):
        (folder / f"{make.__name__}.obj").write_text("\n".join(make().lines) + "\n")


if __name__ == "__main__":
    main()
