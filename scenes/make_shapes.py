#!/usr/bin/env python3
"""Make the turned and built shapes of the gallery under scenes/data: chess men and their board, glasses, a cove, a temple.

A turned shape is a profile of (radius, height) swept round the y axis; every file is an OBJ in metres that stands on y = 0.
Needs nothing but Python 3; the same files every time.
"""
import math
import pathlib

FOLDER = pathlib.Path(__file__).parent / "data"
AROUND = 96


def spline(points, steps=8):
    """A Catmull-Rom curve through `points`; a point given twice in a row is a corner."""
    curve = [points[0]]
    for i in range(len(points) - 1):
        a, b, c, d = (points[min(max(k, 0), len(points) - 1)] for k in range(i - 1, i + 3))
        if b == c:
            continue
        for s in range(1, steps + 1):
            t = s / steps
            curve.append(tuple(
                0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - w) * t * t + (3 * q - p - 3 * r + w) * t**3)
                for p, q, r, w in zip(a, b, c, d)))
    return [(max(r, 0.0), y) for r, y in curve]


class Shape:
    """Vertices and faces, written as one OBJ."""

    def __init__(self):
        self.vertices, self.parts = [], []

    def part(self, material, vertices, faces):
        first = len(self.vertices) + 1
        self.vertices += vertices
        self.parts.append((material, [[first + k for k in face] for face in faces]))
        return self

    def turned(self, profile, around=AROUND, material=None, wave=None):
        """Sweeps `profile`; `wave(angle)` scales the radius: the flutes of a column."""
        wave = wave or (lambda angle: 1.0)
        vertices, faces = [], []
        for r, y in profile:
            for k in range(around):
                angle = 2 * math.pi * k / around
                vertices.append((r * wave(angle) * math.cos(angle), y, r * wave(angle) * math.sin(angle)))
        for row in range(len(profile) - 1):
            for k in range(around):
                a, b = row * around + k, row * around + (k + 1) % around
                faces.append((a, a + around, b + around, b))
        return self.part(material, vertices, faces)

    def box(self, low, high, material=None):
        """An axis-parallel box."""
        vertices = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return self.part(material, vertices, faces)

    def write(self, name, library=None):
        with open(FOLDER / f"{name}.obj", "w") as out:
            if library:
                out.write(f"mtllib {library}\n")
            for v in self.vertices:
                out.write("v %.5f %.5f %.5f\n" % v)
            for material, faces in self.parts:
                if material:
                    out.write(f"usemtl {material}\n")
                for face in faces:
                    out.write("f " + " ".join(map(str, face)) + "\n")
        print(f"wrote {FOLDER / name}.obj")


# Chess men: a foot, a waist and a collar that they share, and a head of their own. Radii and heights in units of the foot.
FOOT = [(0, 0), (1, 0), (1, 0), (1, 0.22), (1, 0.22), (0.86, 0.34), (0.82, 0.42), (0.66, 0.5), (0.5, 0.72)]


def collar(y, r):
    """A ring that stands out at height y."""
    return [(0.9 * r, y - 0.05), (0.9 * r, y - 0.05), (1.45 * r, y), (1.45 * r, y + 0.07), (0.95 * r, y + 0.12), (0.95 * r, y + 0.12)]


def ball(y, r, start=-60):
    """A ball whose middle lies at y, from `start` degrees up to its top."""
    steps = 12
    angles = [math.radians(start + (90 - start) * k / steps) for k in range(steps + 1)]
    return [(r * math.cos(a) if k < steps else 0.0, y + r * math.sin(a)) for k, a in enumerate(angles)]


MEN = {
    "pawn": FOOT + [(0.36, 1.2), (0.33, 1.5)] + collar(1.62, 0.36) + ball(2.1, 0.5, -55),
    "rook": FOOT + [(0.5, 1.3), (0.48, 1.9)] + collar(2.0, 0.46)
    + [(0.66, 2.2), (0.7, 2.72), (0.7, 2.72), (0.48, 2.72), (0.48, 2.72), (0.46, 2.46), (0.46, 2.46), (0, 2.46)],
    "bishop": FOOT + [(0.36, 1.4), (0.32, 2.0)] + collar(2.12, 0.36)
    + [(0.42, 2.35), (0.5, 2.6), (0.42, 2.95), (0.2, 3.25), (0.08, 3.34)] + ball(3.42, 0.11, -50),
    "queen": FOOT + [(0.4, 1.6), (0.34, 2.5)] + collar(2.62, 0.4)
    + [(0.4, 2.86), (0.5, 3.2), (0.66, 3.52), (0.66, 3.52), (0.5, 3.44), (0.5, 3.44), (0.34, 3.6), (0.12, 3.7)] + ball(3.78, 0.13, -50),
    "king": FOOT + [(0.42, 1.7), (0.36, 2.7)] + collar(2.82, 0.42)
    + [(0.42, 3.05), (0.52, 3.4), (0.6, 3.72), (0.6, 3.72), (0.4, 3.84), (0.14, 3.92), (0.1, 3.98)] + ball(4.06, 0.12, -50),
}


def board():
    """Eight by eight squares of one metre round the origin, a frame about them."""
    squares = {"light": [], "dark": []}
    vertices = [(x - 4.0, 0.0, z - 4.0) for x in range(9) for z in range(9)]
    for x in range(8):
        for z in range(8):
            a = 9 * x + z
            squares["light" if (x + z) % 2 else "dark"].append((a, a + 1, a + 10, a + 9))
    shape = Shape()
    for name, faces in squares.items():
        shape.part(name, vertices, faces)
    edge = 4.5
    for low, high in [((-edge, -0.3, -edge), (edge, 0.02, -4)), ((-edge, -0.3, 4), (edge, 0.02, edge)),
                      ((-edge, -0.3, -4), (-4, 0.02, 4)), ((4, -0.3, -4), (edge, 0.02, 4))]:
        shape.box(low, high, "frame")
    shape.write("board")


def glassware():
    """A wine glass as one closed skin, a bowl with a lining, a solid bottle."""
    outer = spline([(0, 0), (0.36, 0), (0.36, 0.015), (0.1, 0.05), (0.04, 0.12), (0.035, 0.5), (0.06, 0.6), (0.22, 0.68), (0.36, 0.86),
                    (0.38, 1.1), (0.3, 1.45)])
    inner = spline([(0.285, 1.45), (0.365, 1.1), (0.345, 0.87), (0.21, 0.7), (0.06, 0.63), (0, 0.62)])
    Shape().turned(outer + [(0.293, 1.458)] + inner).write("glass")
    bowl = spline([(0, 0), (0.3, 0), (0.3, 0), (0.32, 0.04), (0.3, 0.08), (0.5, 0.2), (0.72, 0.42), (0.8, 0.62)])
    lining = spline([(0.77, 0.62), (0.69, 0.43), (0.47, 0.23), (0.2, 0.13), (0, 0.12)])
    Shape().turned(bowl + [(0.785, 0.635)] + lining).write("bowl")
    Shape().turned(spline([(0, 0), (0.3, 0), (0.34, 0.04), (0.34, 0.9), (0.3, 1.08), (0.14, 1.3), (0.11, 1.45), (0.11, 1.7), (0.11, 1.7),
                           (0.14, 1.72), (0.14, 1.8), (0.11, 1.82), (0.11, 1.82), (0, 1.82)])).write("bottle")


def cove():
    """A photographer's cove: floor and wall in one bend, sixty metres wide."""
    profile = [(30.0, 0.0), (-6.0, 0.0)]
    profile += [(-6.0 - 6.0 * math.sin(a), 6.0 - 6.0 * math.cos(a)) for a in (math.radians(3 * k) for k in range(1, 31))]
    profile.append((-12.0, 40.0))
    vertices = [(x, y, z) for z, y in profile for x in (-30.0, 30.0)]
    faces = [(2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2) for k in range(len(profile) - 1)]
    Shape().part(None, vertices, faces).write("cove")


def temple():
    """A temple of six by nine fluted columns 5 m high, their steps, the hall, the beam and the roof."""
    shaft = [(0.5 - 0.09 * t**1.6, 0.3 + 4.2 * t) for t in (k / 10 for k in range(11))]
    foot = spline([(0.62, 0), (0.66, 0.08), (0.62, 0.16), (0.56, 0.2), (0.58, 0.26), (0.5, 0.31)], 3)
    head = spline([(0.42, 4.48), (0.42, 4.56), (0.62, 4.78)], 4)
    column = (Shape().turned(shaft, 160, wave=lambda a: 1.0 - 0.06 * abs(math.sin(10 * a))**0.7).turned(foot, 48).turned(head, 48)
              .box((-0.68, 4.78, -0.68), (0.68, 5.0, 0.68)))
    works = Shape()
    for i in range(6):
        for j in range(9):
            if i in (0, 5) or j in (0, 8):
                x, z = 2.4 * (i - 2.5), 2.2 * (j - 4)
                works.part(None, [(x + v[0], v[1], z + v[2]) for v in column.vertices],
                           [[k - 1 for k in face] for _, faces in column.parts for face in faces])
    for step in range(3):
        out = 1.6 - 0.4 * step
        works.box((-6.25 - out, -0.9 + 0.3 * step, -9.05 - out), (6.25 + out, -0.6 + 0.3 * step, 9.05 + out))
    works.box((-6.8, 5.0, -9.6), (6.8, 5.8, 9.6)).box((-7.1, 5.8, -9.9), (7.1, 6.1, 9.9)).box((-4.0, 0, -6.4), (4.0, 5.0, 6.4))
    roof = [(x, 6.1, z) for x in (-7.3, 7.3) for z in (-10.1, 10.1)] + [(0, 8.3, -10.1), (0, 8.3, 10.1)]
    works.part(None, roof, [(0, 1, 3, 2), (0, 4, 5, 1), (2, 3, 5, 4), (0, 2, 4), (1, 5, 3)])
    works.write("temple")


FOLDER.mkdir(exist_ok=True)
for name, points in MEN.items():
    Shape().turned([(0.36 * r, 0.36 * y) for r, y in spline(points)]).write(name)
board()
glassware()
cove()
temple()
