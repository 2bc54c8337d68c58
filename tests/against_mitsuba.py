#!/usr/bin/env python3
"""Renders the same ball in drt and in Mitsuba 3 and compares the pictures: material by material, under a picture of a sky, and
through a thin lens.

    pip install mitsuba==3.9.1 numpy
    cargo build --release && tests/against_mitsuba.py [--spp 256] [--size 64]

The ball stands in a dim sky under a square lamp; both programs read scenes/ball.obj with its facets. A mean that is
off by more than 0.3 % and five standard errors is a failure, and so is a structure in the difference: eight by eight
blocks of the picture must agree within 1 % of the mean and five standard errors. Where both programs compute the same
integral to the last digit (EXACT below), the blocks must differ by noise alone: the root mean square of their differences
over that of their standard errors is 1 then, and 1.5 is too much.

Mitsuba multiplies the shadowing of the two directions (G1·G1) where drt correlates their heights, so rough materials
are compared at α = 0.05, where the two differ by less than the limit, with single scattering in both.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

ROOT = Path(__file__).resolve().parent.parent
BALL = ROOT / "scenes" / "ball.obj"
GOLD = {"eta": [0.143, 0.375, 1.442], "k": [3.983, 2.386, 1.603]}


def rgb(value):
    return {"type": "rgb", "value": value}


MATERIALS = {
    "diffuse": ("type = 'diffuse'\nreflectance = [0.7, 0.4, 0.2]", {"type": "diffuse", "reflectance": rgb([0.7, 0.4, 0.2])}),
    "conductor": (
        f"type = 'conductor'\neta = {GOLD['eta']}\nk = {GOLD['k']}",
        {"type": "conductor", "eta": rgb(GOLD["eta"]), "k": rgb(GOLD["k"])},
    ),
    "rough conductor": (
        f"type = 'conductor'\neta = {GOLD['eta']}\nk = {GOLD['k']}\nalpha = 0.05\ncompensate = false",
        {"type": "roughconductor", "distribution": "ggx", "alpha": 0.05, "eta": rgb(GOLD["eta"]), "k": rgb(GOLD["k"])},
    ),
    "dielectric": ("type = 'dielectric'\nior = 1.5", {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}),
    "thin dielectric": (
        "type = 'dielectric'\nior = 1.5\nthin = true",
        {"type": "thindielectric", "int_ior": 1.5, "ext_ior": 1.0},
    ),
    "rough dielectric": (
        "type = 'dielectric'\nior = 1.5\nalpha = 0.05\ncompensate = false",
        {"type": "roughdielectric", "distribution": "ggx", "alpha": 0.05, "int_ior": 1.5, "ext_ior": 1.0},
    ),
    "plastic": (
        "type = 'plastic'\nreflectance = [0.7, 0.4, 0.2]\nior = 1.5",
        {"type": "plastic", "diffuse_reflectance": rgb([0.7, 0.4, 0.2]), "int_ior": 1.5, "ext_ior": 1.0},
    ),
    "nonlinear plastic": (
        "type = 'plastic'\nreflectance = [0.7, 0.4, 0.2]\nior = 1.5\nnonlinear = true",
        {
            "type": "plastic",
            "diffuse_reflectance": rgb([0.7, 0.4, 0.2]),
            "int_ior": 1.5,
            "ext_ior": 1.0,
            "nonlinear": True,
        },
    ),
    # Black: Mitsuba's rough plastic loses light in its base (a white one sends back 0.957 in a white furnace at this α and
    # 0.792 at α = 0.2), so that the coat alone can be compared.
    "rough black plastic": (
        "type = 'plastic'\nreflectance = 0.0\nior = 1.5\nalpha = 0.05",
        {
            "type": "roughplastic",
            "distribution": "ggx",
            "alpha": 0.05,
            "diffuse_reflectance": rgb([0.0] * 3),
            "int_ior": 1.5,
            "ext_ior": 1.0,
        },
    ),
}

# Both programs compute the same integral; elsewhere they define shadowing or their tables differently.
EXACT = ["diffuse", "conductor", "environment map", "thin lens"]
LENS = {"aperture": 0.25, "focus": 3.2}


def sky_picture(width=512, height=256, to_the_poles=False):
    """A smooth sky that is different in every direction: two coloured lobes over a gradient, in the shared convention
    u = atan2(x, -z)/2π, v = acos(y)/π. A row of drt's is the middle of its band; Mitsuba's first and last are the poles."""
    rows = np.arange(height) / (height - 1) if to_the_poles else (np.arange(height) + 0.5) / height
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, rows)
    phi, theta = 2 * np.pi * u, np.pi * v
    d = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], axis=-1)
    lobe = lambda axis, sharp: np.exp(sharp * (d @ (np.array(axis) / np.linalg.norm(axis)) - 1))[..., None]
    sky = 0.3 + 0.25 * d[..., 1:2] * np.array([0.2, 0.5, 1.0])
    return (sky + 6 * lobe([1, 0.8, 0.6], 20) * [1, 0.7, 0.3] + 3 * lobe([-1, 0.3, -0.7], 8) * [0.2, 0.9, 0.5]).astype("<f4")


def write_pfm(path, pixels):
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (pixels.shape[1], pixels.shape[0]))
        f.write(np.ascontiguousarray(pixels[::-1]).tobytes())


CORNERS = [[-2.0, 4.0, -2.0], [-2.0, 4.0, 2.0], [2.0, 4.0, 2.0], [2.0, 4.0, -2.0]]


def by_drt(drt, case, material, size, spp, seed, folder):
    lens = f'aperture = {LENS["aperture"]}\nfocus_distance = {LENS["focus"]}' if case == "thin lens" else ""
    if case == "environment map":
        write_pfm(folder / "sky.pfm", sky_picture())
        lights = '[[light]]\ntype = "environment"\nfile = "sky.pfm"\n'
    else:
        lights = f"""
[[light]]
type = "environment"
radiance = 0.3
[[light]]
type = "rectangle"
corner = {CORNERS[0]}
edge_u = [4.0, 0.0, 0.0]
edge_v = [0.0, 0.0, 4.0]
radiance = 5.0
two_sided = false
"""
    scene = f"""
[camera]
position = [1.0, 1.2, 4.0]
look_at = [0.0, 0.0, 0.0]
fov = 32
{lens}
[film]
size = [{size}, {size}]
[render]
spp = {spp}
max_depth = 40
seed = {seed}
[[mesh]]
file = {json.dumps(str(BALL))}
material = "m"
normals = "flat"
[materials.m]
{material.replace("'", '"')}
{lights}
"""
    path, out = folder / "scene.toml", folder / "out.pfm"
    path.write_text(scene)
    subprocess.run([drt, path, "-o", out, "-q"], check=True)
    with open(out, "rb") as f:
        f.readline(), f.readline(), f.readline()
        pixels = np.frombuffer(f.read(), "<f4").reshape(size, size, 3)
    return pixels[::-1].astype(float)


def by_mitsuba(case, material, size, spp, seed):
    sensor = {
        "type": "perspective",
        "fov": 32,
        "fov_axis": "y",
        "to_world": mi.ScalarTransform4f().look_at([1.0, 1.2, 4.0], [0, 0, 0], [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
        "sampler": {"type": "independent", "sample_count": spp},
    }
    if case == "thin lens":
        sensor |= {"type": "thinlens", "aperture_radius": LENS["aperture"], "focus_distance": LENS["focus"]}
    lamp = mi.ScalarTransform4f().translate([0, 4, 0]).rotate([1, 0, 0], 90).scale([2, 2, 1])
    lights = {
        "sky": {"type": "constant", "radiance": rgb([0.3] * 3)},
        "lamp": {
            "type": "rectangle",
            "to_world": lamp,
            "bsdf": {"type": "diffuse", "reflectance": rgb([0.0] * 3)},
            "emitter": {"type": "area", "radiance": rgb([5.0] * 3)},
        },
    }
    if case == "environment map":
        lights = {"sky": {"type": "envmap", "bitmap": mi.Bitmap(sky_picture(to_the_poles=True))}}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 41, "rr_depth": 50},
            "sensor": sensor,
            "ball": {"type": "obj", "filename": str(BALL), "face_normals": True, "bsdf": material},
            **lights,
        }
    )
    return np.array(mi.render(scene, spp=spp, seed=seed)).reshape(size, size, 3).astype(float)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drt", default=str(ROOT / "target" / "release" / "drt"))
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--runs", type=int, default=8)
    parser.add_argument("--only", help="the materials whose name contains this")
    options = parser.parse_args()
    failed = False
    print(f"{'material':20} {'drt':>9} {'Mitsuba':>9} {'differ':>9} {'error':>8} {'worst block':>12} {'structure':>10}")
    with tempfile.TemporaryDirectory() as folder:
        cases = MATERIALS | {name: MATERIALS["diffuse"] for name in ("environment map", "thin lens")}
        for name, (ours, theirs) in cases.items():
            if options.only and options.only not in name:
                continue
            seeds = range(options.runs)
            a = np.array([by_drt(options.drt, name, ours, options.size, options.spp, s, Path(folder)) for s in seeds])
            b = np.array([by_mitsuba(name, theirs, options.size, options.spp, s + 1) for s in seeds])
            mean_a, mean_b = a.mean(), b.mean()
            spread = lambda x: x.var(axis=0, ddof=1) / len(x)
            error = np.sqrt(spread(a.mean(axis=(1, 2, 3))) + spread(b.mean(axis=(1, 2, 3)))) / mean_b
            k = options.size // 8
            blocks = lambda x: x.reshape(len(x), 8, k, 8, k, 3).mean(axis=(2, 4, 5))
            ba, bb = blocks(a), blocks(b)
            block_error = np.sqrt(spread(ba) + spread(bb)) / mean_b
            difference = np.abs(ba.mean(axis=0) - bb.mean(axis=0)) / mean_b
            worst = (difference / np.maximum(0.01, 5 * block_error)).max()
            relative = mean_a / mean_b - 1
            apart = (ba.mean(axis=0) - bb.mean(axis=0)) / mean_b
            structure = np.sqrt((apart**2).sum() / (block_error**2).sum())
            wrong = abs(relative) > max(0.003, 5 * error) or worst > 1 or (name in EXACT and structure > 1.5)
            failed |= bool(wrong)
            verdict = "WRONG" if wrong else ""
            print(
                f"{name:20} {mean_a:9.5f} {mean_b:9.5f} {100 * relative:8.3f}% {100 * error:7.3f}% {worst:12.2f} {structure:10.2f} {verdict}",
                flush=True,
            )
    sys.exit(failed)


if __name__ == "__main__":
    main()
