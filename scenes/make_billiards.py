#!/usr/bin/env python3
"""Make the balls of scenes/billiards.toml in scenes/data: a sphere with texture coordinates, and a picture for each number.

Needs nothing but Python 3.
"""
import math
import pathlib
import struct
import zlib

FOLDER = pathlib.Path(__file__).parent / "data"
WIDTH, HEIGHT = 512, 256
WHITE = (240, 234, 220)
# Number: colour, whether it is a stripe.
BALLS = {1: ((238, 178, 20), False), 4: ((74, 34, 118), False), 8: ((16, 16, 18), False), 9: ((238, 178, 20), True)}
DIGITS = {
    1: ["..#..", ".##..", "..#..", "..#..", "..#..", "..#..", ".###."],
    4: ["...#.", "..##.", ".#.#.", "#..#.", "#####", "...#.", "...#."],
    8: [".###.", "#...#", "#...#", ".###.", "#...#", "#...#", ".###."],
    9: [".###.", "#...#", "#...#", ".####", "....#", "...#.", ".##.."],
}


def colour(number, u, v):
    """The colour at a texture coordinate: twice a number in a white disc, on a solid or striped ball."""
    body, striped = BALLS[number]
    theta, phi = math.pi * v, 2 * math.pi * u
    p = (math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi))
    for side in (1, -1):
        # In the plane that touches the ball in the middle of the disc.
        x, y, depth = -side * p[2], p[1], side * p[0]
        if depth > 0 and math.hypot(x, y) < 0.42:
            column, row = math.floor(x / 0.085 + 2.5), math.floor(3.5 - y / 0.085)
            inked = 0 <= column < 5 and 0 <= row < 7 and DIGITS[number][row][column] == "#"
            return (20, 20, 22) if inked else WHITE
    return WHITE if striped and abs(p[1]) > 0.55 else body


def png(path, rows):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    raw = b"".join(b"\0" + bytes(c for pixel in row for c in pixel) for row in rows)
    head = struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b"")
    )


def mean(number, x, y):
    """Of 3 × 3 points of a pixel."""
    points = [colour(number, (x + i / 3 + 1 / 6) / WIDTH, (y + j / 3 + 1 / 6) / HEIGHT) for i in range(3) for j in range(3)]
    return [round(sum(p[k] for p in points) / 9) for k in range(3)]


def sphere(path, rows=64, columns=128):
    lines = []
    for r in range(rows + 1):
        for c in range(columns + 1):
            theta, phi = math.pi * r / rows, 2 * math.pi * c / columns
            p = math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi)
            lines.append("v %.6f %.6f %.6f" % p)
            lines.append("vt %.6f %.6f" % (c / columns, 1 - r / rows))
    for r in range(rows):
        for c in range(columns):
            a = r * (columns + 1) + c + 1
            b, d, e = a + 1, a + columns + 1, a + columns + 2
            # Triangles at the poles, where a side has no length.
            corners = [a, b, e, d] if 0 < r < rows - 1 else [a, e, d] if r == 0 else [a, b, d]
            lines.append("f " + " ".join(f"{i}/{i}" for i in corners))
    path.write_text("\n".join(lines) + "\n")


FOLDER.mkdir(exist_ok=True)
sphere(FOLDER / "billiard-ball.obj")
for number in BALLS:
    rows = [[mean(number, x, y) for x in range(WIDTH)] for y in range(HEIGHT)]
    png(FOLDER / f"billiard-{number}.png", rows)
print(f"wrote {FOLDER}/billiard-ball.obj and billiard-*.png")
