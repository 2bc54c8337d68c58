#!/usr/bin/env python3
"""Writes a bumpy sphere of about N million triangles as OBJ, a row at a time.

    python3 benches/make_large.py 100 large.obj     # 100 million triangles, 7.6 GB
    drt large.obj --compact --progress plain

A closed surface: rows of a sphere whose radius is a sum of sines, a fan at each pole. Needs no memory to speak of, so that
a file of any size can be made on the machine that is to read it.
"""

import math
import sys


def write(millions, name):
    # rows × columns quads of two triangles each, twice as many columns as rows.
    rows = max(3, round(math.sqrt(millions * 1e6 / 4)))
    columns = 2 * rows
    row_of_faces = "f %d %d %d\nf %d %d %d\n" * columns
    phis = [2 * math.pi * j / columns for j in range(columns)]
    circle = [(math.cos(phi), math.sin(phi)) for phi in phis]
    coarse = [0.08 * math.cos(7 * phi) for phi in phis]
    fine = [0.01 * math.cos(58 * phi) for phi in phis]
    row_of_vertices = "v %.6f %.6f %.6f\n" * columns
    with open(name, "w", encoding="ascii") as out:
        out.write("# a bumpy sphere, made by benches/make_large.py\nv 0 1 0\nv 0 -1 0\n")
        # Row i of vertices starts at 3 + i·columns; 1 and 2 are the poles.
        for i in range(rows):
            theta = math.pi * (i + 1) / (rows + 1)
            a, b, y, s = math.sin(9 * theta), math.sin(63 * theta), math.cos(theta), math.sin(theta)
            r = [1 + a * c + b * f for c, f in zip(coarse, fine)]
            out.write(row_of_vertices % tuple([x for q, (c, n) in zip(r, circle) for x in (q * s * c, q * y, q * s * n)]))
        for j in range(columns):
            here, there, last = 3 + j, 3 + (j + 1) % columns, 3 + (rows - 1) * columns
            out.write("f 1 %d %d\nf 2 %d %d\n" % (there, here, last + j, last + (j + 1) % columns))
        for i in range(rows - 1):
            upper = range(3 + i * columns, 3 + (i + 1) * columns)
            row = []
            for u in upper:
                v = u + 1 if u + 1 < upper.stop else upper.start
                row += (u, v, u + columns, v, v + columns, u + columns)
            out.write(row_of_faces % tuple(row))
    print(f"{name}: {2 * columns * rows} triangles, {2 + rows * columns} vertices")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    write(float(sys.argv[1]), sys.argv[2])
