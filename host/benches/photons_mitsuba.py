"""Photons a second of `arboleda shoot` and of Mitsuba's particle tracer, on figure 4(b), one thread each, in turns.

    pip install mitsuba numpy
    cargo build --release
    python host/benches/photons_mitsuba.py target/release/arboleda

Both shoot from the same light at the same triangles and reflectances, and decide by Russian roulette from the first
bounce. Mitsuba's camera looks away from the scene, so that it connects no photon to a pixel: its `ptracer` then only
traces. `arboleda shoot` also counts the hits of each side of each triangle, and hashes all hits.

The variant of Mitsuba is an argument: `llvm_ad_rgb` (compiled, with Embree's vectors; the first run compiles and is
not counted) or `scalar_rgb`.
"""

import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

PROGRAM = sys.argv[1]
VARIANT = sys.argv[2] if len(sys.argv) > 2 else "llvm_ad_rgb"
PHOTONS = 1_000_000
ROUNDS = 7
FLOOR_TRIANGLES = 5_000  # of figure 4(b), the first ones; its floor reflects 0.7, its teapots 0.5
LIGHT_SIDE, LIGHT_HEIGHT = 18.0, 10.8
# Mitsuba decides by the weight of a photon, which begins as the flux: with 1 W, it survives by the reflectance, as ours.
FLUX = 1.0


def triangles():
    """Reads the corners of the scene's triangles from the mesh that `arboleda shoot` writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "mesh.ply")
        run = [PROGRAM, "shoot", "--scene", "fig4b", "--photons", "1000", "--mesh-ply", path]
        subprocess.run(run, check=True, capture_output=True)
        header, data = open(path, "rb").read().split(b"end_header\n", 1)
    vertices, faces = (int(re.search(rb"element %s (\d+)" % name, header)[1]) for name in (b"vertex", b"face"))
    points = np.frombuffer(data, "<f4", 3 * vertices).reshape(-1, 3)
    row = np.dtype([("count", "u1"), ("corners", "<u4", 3), ("irradiance", "<f4", 6), ("colour", "u1", 3)])
    return points, np.frombuffer(data, row, faces, 12 * vertices)["corners"]


def mitsuba_scene(mi):
    """Makes the scene, and an integrator that shoots PHOTONS photons."""
    points, corners = triangles()

    def mesh(name, faces, reflectance):
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": reflectance}})
        made = mi.Mesh(name, len(points), len(faces), props=properties)
        parameters = mi.traverse(made)
        parameters["vertex_positions"] = points.ravel()
        parameters["faces"] = faces.astype(np.uint32).ravel()
        parameters.update()
        return made

    to_world = mi.ScalarTransform4f()
    lamp = to_world.translate([0, 0, LIGHT_HEIGHT]) @ to_world.rotate([1, 0, 0], 180)
    radiance = FLUX / (np.pi * LIGHT_SIDE**2)
    scene = mi.load_dict({
        "type": "scene",
        "floor": mesh("floor", corners[:FLOOR_TRIANGLES], 0.7),
        "teapots": mesh("teapots", corners[FLOOR_TRIANGLES:], 0.5),
        "light": {
            "type": "rectangle",
            "to_world": lamp @ to_world.scale([LIGHT_SIDE / 2, LIGHT_SIDE / 2, 1]),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}},
        },
        "camera": {
            "type": "perspective",
            "to_world": to_world.look_at(origin=[0, 0, 100], target=[0, 0, 200], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 1000, "height": 1000, "rfilter": {"type": "box"}},
        },
    })
    return scene, mi.load_dict({"type": "ptracer", "rr_depth": 1, "max_depth": 65})


def main():
    import drjit as dr
    import mitsuba as mi

    mi.set_variant(VARIANT)
    mi.set_log_level(mi.LogLevel.Warn)
    dr.set_thread_count(1)
    scene, integrator = mitsuba_scene(mi)

    def theirs():
        start = time.process_time()
        image = mi.render(scene, integrator=integrator, spp=PHOTONS // 1_000_000, seed=1)
        dr.eval(image)
        dr.sync_thread()
        return time.process_time() - start

    def seconds_of(photons):
        run = [PROGRAM, "shoot", "--scene", "fig4b", "--index", "wide-bvh", "--threads", "1"]
        start = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run([*run, "--photons", str(photons)], check=True, capture_output=True)
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - start

    def ours():
        return seconds_of(PHOTONS) - seconds_of(1)

    theirs()
    pairs = [(ours(), theirs()) for _ in range(ROUNDS)]
    names = ["arboleda", f"mitsuba {mi.__version__} {VARIANT}"]
    for name, seconds in zip(names, zip(*pairs)):
        rates = sorted(PHOTONS / second for second in seconds)
        print(f"{name}: {statistics.median(rates):,.0f} photons/s ({rates[0]:,.0f} to {rates[-1]:,.0f})")
    print(f"ratio: {statistics.median(b / a for a, b in pairs):.2f}")


main()
