#!/usr/bin/env python3
"""Has Mitsuba 3 and the program render the same XML scenes, and compares means of blocks by their standard errors.

usage: scenes.py PROGRAM FOLDER [NAME..]

The program's path tracer (its light tracer for caustics of point lights) is held against Mitsuba's `path` (`ptracer`; `volpath` for
masks and bodies that absorb): both are unbiased, so that only their standard errors may part them. Photon mapping, which is not,
may differ by 4 % of the whole picture.
Without Mitsuba all is skipped, visibly.

Coarse meshes are flat here: where a shading normal and its face disagree about which side light comes from, Mitsuba believes the
shading normal, the program both.
"""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
RENDERS, BLOCK = 16, 16
# Of the blocks, so many must be within 1 % and three standard errors of the difference; three in a thousand are beyond by chance.
SHARE, TOLERANCE = 0.97, 0.01
OF_PHOTONS = 0.04

SENSOR = """<sensor type="{kind}"><float name="fov" value="38"/><string name="fov_axis" value="smaller"/>{lens}
<transform name="to_world"><lookat origin="0.5,2.5,7" target="0,0.9,0" up="0.1,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="112"/><integer name="height" value="96"/><rfilter type="box"/></film></sensor>"""
PINHOLE = SENSOR.format(kind="perspective", lens="")
LENS = SENSOR.format(
    kind="thinlens", lens='<float name="aperture_radius" value="0.12"/><float name="focus_distance" value="6.5"/>'
)
ROOM = """<bsdf type="twosided" id="white"><bsdf type="diffuse"><rgb name="reflectance" value="0.7,0.65,0.6"/></bsdf></bsdf>
<bsdf type="twosided" id="red"><bsdf type="diffuse"><rgb name="reflectance" value="0.6,0.1,0.1"/></bsdf></bsdf>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform><ref id="white"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="4"/><translate y="4" z="-3"/></transform><ref id="white"/></shape>
<shape type="rectangle"><transform name="to_world"><rotate y="1" angle="90"/><scale value="4"/><translate x="-3" y="4"/></transform>
<ref id="red"/></shape>"""
POINT = """<emitter type="point"><point name="position" value="1.5,4,2.5"/><rgb name="intensity" value="30,28,22"/></emitter>"""
LAMP = """<shape type="disk"><transform name="to_world"><rotate x="1" angle="90"/><scale value="0.9"/><translate y="4" z="1"/></transform>
<bsdf type="diffuse"><float name="reflectance" value="0"/></bsdf>
<emitter type="area"><rgb name="radiance" value="9,8,6"/></emitter></shape>"""


def body(x, z, bsdf, kind="sphere"):
    return f"""<shape type="{kind}"><transform name="to_world"><scale value="0.75"/><translate x="{x}" y="0.8" z="{z}"/></transform>
{bsdf}</shape>"""


def bsdf(kind, properties=""):
    return f'<bsdf type="{kind}">{properties}</bsdf>'


def two_sided(kind, properties=""):
    return bsdf("twosided", bsdf(kind, properties))


def masked(opacity, inner):
    return bsdf("mask", f'<float name="opacity" value="{opacity}"/>{inner}')


def interior(sigma_t):
    """What absorbs and does not scatter; colours of Mitsuba end at 1."""
    properties = f'<float name="albedo" value="0"/><rgb name="sigma_t" value="{sigma_t}"/><float name="scale" value="2"/>'
    return f'<medium type="homogeneous" name="interior">{properties}</medium>'


GGX = '<string name="distribution" value="ggx"/><float name="alpha" value="{}"/>'
GOLD = '<rgb name="eta" value="0.14,0.37,1.44"/><rgb name="k" value="3.98,2.39,1.6"/>'
SHAPES = """<shape type="cube"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="30"/><translate x="-1.6" y="0.5" z="0.8"/></transform>
<ref id="red"/></shape>
<shape type="cylinder"><point name="p0" value="1.5,0,0.5"/><point name="p1" value="1.2,1.6,0"/><float name="radius" value="0.4"/>
<ref id="white"/></shape>
<shape type="disk"><transform name="to_world"><rotate x="1" angle="-40"/><translate x="0.2" y="0.9" z="0.6"/></transform><ref id="red"/></shape>
<shape type="obj"><string name="filename" value="roof.obj"/><boolean name="face_normals" value="true"/><transform name="to_world"><matrix value="1 0 0 -2.4 0 1 0 0 0 0 1 -2 0 0 0 1"/></transform>
<ref id="white"/></shape>
<shape type="ply"><string name="filename" value="roof.ply"/><boolean name="face_normals" value="true"/>
<transform name="to_world"><scale x="-1"/><translate x="2.6" z="-2"/></transform><ref id="white"/></shape>"""
ROOF = [(0, 0, 0), (0, 0, 1), (1, 1.4, 0), (1, 1.4, 1), (2, 0, 0), (2, 0, 1)]
SLOPES = [(0, 1, 3, 2), (2, 3, 5, 4)]

# Name: sensor, contents, the integrator, samples a pixel of one of Mitsuba's renders, the program's method and its samples.
SCENES = {
    "shapes": (PINHOLE, POINT + SHAPES, "path", 64, "path", 256),
    "lens": (LENS, LAMP + SHAPES, "path", 64, "path", 512),
    "mirrors": (
        PINHOLE,
        LAMP
        + body(-1.5, 0, two_sided("conductor", '<string name="material" value="none"/>'))
        + body(0.2, 0.3, two_sided("conductor", GOLD))
        + body(1.8, 0, two_sided("roughconductor", GGX.format(0.2) + GOLD)),
        "path", 128, "path", 1024,
    ),
    "glass": (
        PINHOLE,
        LAMP
        + body(-1.5, 0, bsdf("dielectric", '<string name="int_ior" value="water"/>'))
        + body(0.2, 0.3, bsdf("roughdielectric", GGX.format(0.3)))
        + body(1.8, 0, bsdf("thindielectric"), "cube"),
        "path", 256, "path", 2048,
    ),
    "plastic": (
        PINHOLE,
        LAMP
        + body(-1.2, 0, two_sided("plastic", '<rgb name="diffuse_reflectance" value="0.2,0.3,0.8"/>'))
        + body(1.2, 0, two_sided("plastic", '<rgb name="diffuse_reflectance" value="0.8,0.3,0.1"/><boolean name="nonlinear" value="true"/>')),
        "path", 128, "path", 1024,
    ),
    "spot": (
        PINHOLE,
        """<emitter type="spot"><float name="cutoff_angle" value="35"/><float name="beam_width" value="15"/>
<rgb name="intensity" value="60,50,40"/><transform name="to_world"><lookat origin="2,4,3" target="0,0,0" up="0,1,0"/></transform></emitter>
<emitter type="directional"><vector name="direction" value="-1,-2,-1.5"/><float name="irradiance" value="0.4"/></emitter>"""
        + SHAPES,
        "path", 64, "path", 256,
    ),
    "sky": (
        PINHOLE,
        """<emitter type="envmap"><string name="filename" value="sky.exr"/><float name="scale" value="1.5"/>
<transform name="to_world"><rotate y="1" angle="25"/></transform></emitter>""" + SHAPES,
        "path", 128, "path", 1024,
    ),
    "balls": (
        PINHOLE,
        """<emitter type="constant"><rgb name="radiance" value="0.2,0.25,0.3"/></emitter>"""
        + """<shape type="sphere"><point name="center" x="-0.5" y="3.2" z="1"/><float name="radius" value="0.5"/>
<emitter type="area"><rgb name="radiance" value="9,8,6"/></emitter></shape>"""
        + body(1.2, 0, two_sided("diffuse")),
        "path", 128, "path", 2048,
    ),
    "pictures": (
        PINHOLE,
        POINT
        + "".join(
            f"""<shape type="{kind}">{file}<transform name="to_world"><scale value="0.9"/><translate x="{x}" y="1.2" z="0.5"/></transform>
<bsdf type="twosided"><bsdf type="diffuse"><texture name="reflectance" type="bitmap"><string name="filename" value="tile.exr"/>
<boolean name="raw" value="true"/></texture></bsdf></bsdf></shape>"""
            for kind, file, x in (
                ("rectangle", "", -2),
                ("obj", '<string name="filename" value="tile.obj"/>', 0),
                ("ply", '<string name="filename" value="tile.ply"/>', 2),
            )
        ),
        "path", 64, "path", 256,
    ),
    "caustic": (PINHOLE, POINT + body(0.3, 0.3, bsdf("dielectric")), "ptracer", 256, "light", 1024),
    "mask": (
        PINHOLE,
        LAMP
        + body(-1.5, 0, masked(0.6, two_sided("diffuse", '<rgb name="reflectance" value="0.2,0.6,0.3"/>')))
        + body(1.8, 0, masked(0.3, two_sided("plastic")), "cube")
        + """<shape type="rectangle"><transform name="to_world"><scale value="0.9"/><rotate x="1" angle="-60"/>
<translate x="0.2" y="1.8" z="0.6"/></transform><bsdf type="mask"><texture name="opacity" type="bitmap">
<string name="filename" value="tile.exr"/><boolean name="raw" value="true"/></texture><ref id="red"/></bsdf></shape>""",
        "volpath", 256, "path", 2048,
    ),
    "absorption": (
        PINHOLE,
        LAMP
        + body(-1.5, 0, bsdf("dielectric") + interior("1,0.3,0.05"))
        + body(0.2, 0.3, bsdf("roughdielectric", GGX.format(0.3)) + interior("0.05,0.25,1"))
        + body(1.8, 0, bsdf("dielectric", '<string name="int_ior" value="water"/>') + interior("0.75,0.05,0.5"), "cube"),
        "volpath", 1024, "path", 2048,
    ),
}


def write_meshes(folder):
    lines = [f"v {x} {y} {z}" for x, y, z in ROOF] + ["f " + " ".join(str(i + 1) for i in face) for face in SLOPES]
    (folder / "roof.obj").write_text("\n".join(lines) + "\n")
    # Mitsuba's reader knows triangles alone.
    halves = [half for a, b, c, d in SLOPES for half in ((a, b, c), (a, c, d))]
    header = (
        f"ply\nformat ascii 1.0\nelement vertex {len(ROOF)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(halves)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    values = [" ".join(map(str, point)) for point in ROOF] + [f"3 {' '.join(map(str, face))}" for face in halves]
    (folder / "roof.ply").write_text(header + "\n".join(values) + "\n")


def write_tile(mi, numpy, folder):
    """A square with texture coordinates, and a picture of eight by eight colours."""
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    uvs = [(0, 0), (1, 0), (1, 1), (0, 1)]
    lines = [f"v {x} {y} 0" for x, y in corners] + [f"vt {u} {v}" for u, v in uvs]
    (folder / "tile.obj").write_text("\n".join(lines + ["f 1/1 2/2 3/3", "f 1/1 3/3 4/4"]) + "\n")
    properties = "".join(f"property float {name}\n" for name in "xyzuv")
    values = [f"{x} {y} 0 {u} {v}" for (x, y), (u, v) in zip(corners, uvs)]
    (folder / "tile.ply").write_text(
        f"ply\nformat ascii 1.0\nelement vertex 4\n{properties}element face 2\nproperty list uchar int vertex_indices\n"
        "end_header\n" + "\n".join(values + ["3 0 1 2", "3 0 2 3"]) + "\n"
    )
    write(mi, numpy.random.default_rng(1).uniform(0.1, 0.9, (8, 8, 3)), str(folder / "tile.exr"))


def write_sky(mi, numpy, folder):
    """Blue above, brown below, and a soft sun to the right of the middle."""
    y, x = numpy.mgrid[0:32, 0:64] / 32.0
    horizon = 1 / (1 + numpy.exp(20 * (y - 0.5)))[..., None]
    sun = 12 * numpy.exp(-((x - 1.3) ** 2 + (y - 0.3) ** 2) / 0.02)[..., None]
    write(mi, horizon * (0.3, 0.4, 0.7) + (1 - horizon) * (0.2, 0.15, 0.1) + sun * (1, 0.9, 0.7), str(folder / "sky.exr"))


def mitsuba_render(mi, numpy, xml, integrator, spp, stem):
    """The mean of independent renders and its standard error."""
    # Where it merges shapes, Mitsuba 3.9.1 leaves them out of the scene's bounds, and shadow rays towards skies end before they leave it.
    scene = mi.load_file(str(xml), optimize=False)
    integrator = mi.load_dict({"type": integrator, "max_depth": -1, "rr_depth": 16})
    renders = [
        numpy.array(mi.render(scene, integrator=integrator, spp=spp, seed=seed), dtype=numpy.float64)[..., :3]
        for seed in range(RENDERS)
    ]
    write(mi, numpy.mean(renders, axis=0), f"{stem}.exr")
    write(mi, numpy.std(renders, axis=0, ddof=1) / RENDERS**0.5, f"{stem}_stderr.exr")


def write(mi, pixels, path):
    mi.Bitmap(pixels.astype("float32")).write(path)


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


def compare(program, ours, theirs, *more):
    return json.loads(run(program, "compare", ours, theirs, "--block", BLOCK, "--block-tolerance", TOLERANCE, *more, "--json"))


def check(program, folder, name, mi, numpy):
    sensor, contents, integrator, spp, method, samples = SCENES[name]
    xml = folder / f"{name}.xml"
    xml.write_text(f'<scene version="3.0.0">\n{sensor}\n{ROOM}\n{contents}\n</scene>\n')
    theirs, ours, photons = (folder / f"{name}_{what}" for what in ("mitsuba", "reference", "photons"))
    mitsuba_render(mi, numpy, xml, integrator, spp, theirs)
    run(program, "reference", xml, "--method", method, "--spp", samples, "-o", f"{ours}.exr")
    errors = ("--stderr", f"{ours}_stderr.exr", "--reference-stderr", f"{theirs}_stderr.exr")
    exact = compare(program, f"{ours}.exr", f"{theirs}.exr", *errors)
    run(program, "render", xml, "--passes", 48, "--photons", 200000, "-o", f"{photons}.exr")
    mapped = compare(program, f"{photons}.exr", f"{ours}.exr")
    return judged(name, method, exact, mapped)


def judged(name, method, exact, mapped):
    blocks, z = exact["blocks"], exact["z"]["rms"]
    share, ratio = blocks["n_within"] / blocks["n_blocks"], abs(mapped["mean_ratio_overall"] - 1)
    # Light tracing finds no light in glass; photon mapping does.
    good = share >= SHARE and (ratio <= OF_PHOTONS or method == "light")
    print(
        f"{name:8}  {method} tracing: {share:.1%} of the blocks within {TOLERANCE:.0%} + 3 standard errors of Mitsuba's, "
        f"z {z:.2f}; photon mapping against it: mean off by {ratio:.2%}  {'ok' if good else 'WRONG'}"
    )
    return good


def mitsuba(checks):
    """Mitsuba and numpy; nothing where they are missing, which is told."""
    try:
        import mitsuba as mi
        import numpy
    except ImportError as error:
        print(f"skipped: {checks} by Mitsuba: {error}")
        return None
    # The one variant that needs nothing beyond the package.
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    return mi, numpy


def main():
    program, folder, names = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), sys.argv[3:] or list(SCENES)
    there = mitsuba("scenes")
    if not there:
        return 0
    mi, numpy = there
    write_meshes(folder)
    write_sky(mi, numpy, folder)
    write_tile(mi, numpy, folder)
    return 0 if all([check(program, folder, name, mi, numpy) for name in names]) else 1


if __name__ == "__main__":
    sys.exit(main())
