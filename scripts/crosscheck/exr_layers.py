#!/usr/bin/env python3
"""Holds what other programs read in a picture with all layers against each other, channel by channel and bit by bit.

usage: exr_layers.py PROGRAM FOLDER

Readers: OpenEXR's Python module, oiiotool, exrheader, Mitsuba 3 by its Python interface, and the program itself. Those that are not
there are skipped, visibly.
"""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

RGB_LAYERS = ["direct", "caustic", "indirect", "stderr", "bias", "bound", "albedo"]
CHANNELS = sorted(
    ["R", "G", "B", "N.X", "N.Y", "N.Z", "Z", "photons", "radius"]
    + [f"{layer}.{channel}" for layer in RGB_LAYERS for channel in "RGB"]
)
SIZE = (48, 40)
# A glass ball, a lamp and a slope before nothing: infinite depths, and bounds that are no numbers.
SCENE = """
[film]
width = 48
height = 40
[camera]
position = [0, 3, 10]
look_at = [0, 1, 0]
fov = 50
[material.red]
diffuse = { albedo = [0.7, 0.2, 0.1] }
[material.glass]
dielectric = { ior = 1.5 }
[material.lamp]
diffuse = { albedo = [0, 0, 0] }
emission = [30, 30, 25]
[[sphere]]
center = [0, 1.5, 0]
radius = 1
material = "glass"
[[quad]]
corners = [[-4, 0, -4], [-4, 0, 4], [4, 0, 4], [4, 0, -4]]
material = "red"
[[quad]]
corners = [[-0.5, 5, -0.5], [0.5, 5, -0.5], [0.5, 5, 0.5], [-0.5, 5, 0.5]]
material = "lamp"
"""


class Check:
    """What was compared, and what does not agree."""

    def __init__(self):
        self.compared, self.faults = 0, []

    def that(self, holds, fault):
        self.compared += 1
        if not holds:
            self.faults.append(fault)

    def skip(self, reader, reason):
        print(f"exr_layers: SKIPPED {reader}: {reason}")

    def finish(self):
        for fault in self.faults:
            print(f"exr_layers: {fault}", file=sys.stderr)
        print(f"exr_layers: {self.compared} comparisons, {len(self.faults)} faults")
        sys.exit(1 if self.faults else 0)


def output_of(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout


def render(program, folder, name, *flags):
    scene, picture = folder / "scene.toml", folder / f"{name}.exr"
    scene.write_text(SCENE)
    command = [program, "render", scene, "-o", picture, "--passes", "8", "--photons", "20000", "--samples", "4"]
    subprocess.run([str(word) for word in [*command, *flags]], check=True, capture_output=True)
    return picture


def same(a, b):
    """Equal bit by bit, as far as numbers are, and of the same kind."""
    import numpy

    return a.dtype == b.dtype and a.shape == b.shape and numpy.array_equal(a, b, equal_nan=True)


def by_openexr(path):
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        return dict(file.header()), {name: channel.pixels.copy() for name, channel in file.channels().items()}


def check_openexr(check, path, header, pixels, kinds):
    check.that(sorted(pixels) == CHANNELS, f"OpenEXR sees the channels {sorted(pixels)}")
    for name, values in pixels.items():
        check.that(values.shape == SIZE[::-1], f"OpenEXR: {name} has the shape {values.shape}")
        check.that(values.dtype == kinds(name), f"OpenEXR: {name} is {values.dtype}")
    check.that("ZIP_COMPRESSION" in str(header["compression"]), f"OpenEXR: {header['compression']}")
    check.that("scanline" in str(header.get("type", "scanlineimage")), f"OpenEXR: {header.get('type')}")
    command = header.get("caustica:command", "")
    check.that(" render " in command and str(path) in command, f"OpenEXR: the command is {command!r}")
    check.that(str(header.get("software", "")).startswith("Caustica "), f"OpenEXR: {header.get('software')}")
    check.that(header.get("caustica:passes") == 8, f"OpenEXR: {header.get('caustica:passes')} passes")
    import numpy

    matrix = numpy.array(header["worldToCamera"]).reshape(4, 4)
    seen = numpy.array([0, 1, 0, 1]) @ matrix
    check.that(numpy.allclose(seen, [0, 0, -(104**0.5), 1], atol=1e-4), f"OpenEXR: the axis of view at {seen}")


def check_contents(check, pixels):
    """What must hold whoever reads it."""
    import numpy

    light = [pixels[f"{kind}.R"] for kind in ("direct", "caustic", "indirect")]
    check.that(same(pixels["R"], (light[0] + light[1]) + light[2]), "the kinds of light do not add up to the picture")
    met = numpy.isfinite(pixels["Z"])
    check.that(met.any() and not met.all(), "Z is infinite nowhere or everywhere")
    lengths = numpy.sqrt(sum(pixels[f"N.{axis}"] ** 2 for axis in "XYZ"))
    check.that((lengths <= 1.00001).all() and (lengths[~met] == 0).all(), "N has lengths beyond 1")
    check.that((pixels["albedo.R"] <= 1.00001).all() and (pixels["albedo.R"][~met] == 0).all(), "albedo exceeds 1")
    check.that((pixels["radius"] >= 0).all() and pixels["photons"].max() > 0, "no photons, or radii below 0")


def check_oiiotool(check, path, pixels):
    if not shutil.which("oiiotool"):
        return check.skip("oiiotool", "not installed")
    info = output_of("oiiotool", "--info", "-v", path)
    listed = re.search(r"channel list: (.*)", info)[1]
    names = [re.sub(r" \(\w+\)$", "", name) for name in listed.split(", ")]
    check.that(sorted(names) == CHANNELS, f"oiiotool sees the channels {names}")
    for fact in ("caustica:command", "worldToCamera", "chromaticities", "Caustica ", 'compression: "zip"'):
        check.that(fact in info, f"oiiotool does not tell {fact!r}")
    copy = path.with_name("oiiotool.exr")
    output_of("oiiotool", path, "--compression", "none", "-o", copy)
    _, read = by_openexr(copy)
    for name in CHANNELS:
        # What it writes is of one kind.
        agree = name in read and same(read[name], pixels[name].astype("float32"))
        check.that(agree, f"oiiotool reads other values of {name}")


def check_exrheader(check, path, kinds):
    if not shutil.which("exrheader"):
        return check.skip("exrheader", "not installed")
    told = output_of("exrheader", path)
    for name in CHANNELS:
        bits = {"float32": "32-bit floating-point", "float16": "16-bit floating-point"}[kinds(name)]
        check.that(re.search(rf"^ +{re.escape(name)}, {bits}, sampling 1 1", told, re.M), f"exrheader: no {name}, {bits}")
    for fact in ("zip, individual scanlines|zip, multi-scanline blocks", "caustica:command", "chromaticities", "worldToCamera"):
        check.that(re.search(fact, told), f"exrheader does not tell {fact}")


def check_mitsuba(check, path, pixels, kinds):
    try:
        import mitsuba
    except ImportError as error:
        return check.skip("Mitsuba", error)
    import numpy

    mitsuba.set_variant("scalar_rgb")
    bitmap = mitsuba.Bitmap(str(path))
    values, names = numpy.array(bitmap), [field.name for field in bitmap.struct_()]
    check.that(sorted(names) == CHANNELS, f"Mitsuba sees the channels {names}")
    # It reads all channels as it does those of the picture: the others lose precision beside 16 bits.
    check.that(values.dtype == kinds("R"), f"Mitsuba reads {values.dtype}")
    for index, name in enumerate(names):
        with numpy.errstate(over="ignore"):
            agree = same(values[:, :, index], pixels[name].astype(values.dtype))
        check.that(agree, f"Mitsuba reads other values of {name}")


def check_ourselves(check, program, path):
    """Layers of numbers alone, against what oiiotool wrote."""
    copy = path.with_name("oiiotool.exr")
    for layer in ["", ":direct", ":stderr", ":albedo", ":N", ":radius", ":photons"]:
        report = json.loads(output_of(program, "compare", f"{path}{layer}", f"{copy}{layer}", "--json"))
        check.that(report["max"] == 0.0, f"the program reads other values of {layer or 'RGB'}")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    check = Check()
    try:
        import OpenEXR  # noqa: F401
    except ImportError as error:
        check.skip("all", f"{error}, and nothing else gives the values to hold the others against")
        return
    all_layers = ["--layers", "--features", "--apart"]
    for name, flags in [("float", []), ("half", ["--half"])]:
        kinds = lambda channel: "float16" if flags and channel in "RGB" else "float32"  # noqa: B023, E731
        path = render(program, folder, name, *all_layers, *flags)
        header, pixels = by_openexr(path)
        check_openexr(check, path, header, pixels, kinds)
        check_oiiotool(check, path, pixels)
        check_exrheader(check, path, kinds)
        check_mitsuba(check, path, pixels, kinds)
        if name == "float":
            check_contents(check, pixels)
            if shutil.which("oiiotool"):
                check_ourselves(check, program, path)
    check.finish()


if __name__ == "__main__":
    main()
