#!/usr/bin/env python3
"""Has Mitsuba 3 and the program path trace the scenes of data/, written as XML by the program, and compares means of blocks.

usage: data_scenes.py PROGRAM FOLDER [NAME..]

Neither path tracer finds light of points, spots and suns that glass or water focuses, so both lack it alike. What of it comes through
masks `volpath` finds and the program does not, to whose shadow rays masks are opaque; so they are made opaque to Mitsuba's, too. Scenes that
Mitsuba has no words for, such as those with the course's fixed weights, are skipped, visibly. Without Mitsuba all is skipped.
"""

import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from scenes import ROOT, SHARE, TOLERANCE, compare, mitsuba, mitsuba_render, run

# Pixels and samples are few: blocks of 16 pixels a side are compared.
LONGEST = 112
SAMPLES = {"mitsuba": 48, "program": 768}


def smaller(xml):
    """The same scene in few pixels with a box filter."""
    text = xml.read_text()
    width, height = (int(re.search(rf'name="{side}" value="(\d+)"', text)[1]) for side in ("width", "height"))
    scale = LONGEST / max(width, height)
    for side, pixels in (("width", width), ("height", height)):
        text = re.sub(rf'name="{side}" value="\d+"', f'name="{side}" value="{round(scale * pixels)}"', text)
    xml.write_text(re.sub(r'<rfilter[^>]*type="\w+"[^>]*?(/>|>.*?</rfilter>)', '<rfilter type="box"/>', text, flags=re.S))


def with_opaque_shadows(xml):
    """The scene with masks that shadow rays of `volpath` do not pass: those know masks alone, not masks below bumps, even of no height.

    Lamps and skies behind masks would lose light by that: scenes with those stay as they are.
    """
    scene = ElementTree.parse(xml)
    masks = scene.findall(".//bsdf[@type='mask']")
    if not masks or {emitter.get("type") for emitter in scene.iter("emitter")} - {"point", "spot", "directional"}:
        return xml
    for mask in masks:
        inner = ElementTree.Element("bsdf", type="mask")
        inner.extend(mask)
        height = ElementTree.Element("texture", type="uniform")
        ElementTree.SubElement(height, "float", name="value", value="1")
        mask[:] = [height, inner]
        mask.set("type", "bumpmap")
    opaque = xml.with_name(f"{xml.stem}_opaque_shadows.xml")
    scene.write(opaque)
    return opaque


def convert(program, scene, xml):
    """Why the scene cannot be written, or nothing."""
    done = subprocess.run([program, "convert", scene, xml], capture_output=True, text=True, check=False)
    return done.stderr.strip().splitlines()[-1] if done.returncode else None


def check(program, folder, name, mi, numpy):
    xml = folder / f"data_{name}.xml"
    missing = convert(program, ROOT / "data" / f"{name}.toml", xml)
    if missing:
        print(f"{name:14}  skipped: {missing}")
        return True
    smaller(xml)
    theirs, ours = (folder / f"data_{name}_{what}" for what in ("mitsuba", "program"))
    integrator = "volpath" if 'type="volpath"' in xml.read_text() else "path"
    mitsuba_render(mi, numpy, with_opaque_shadows(xml), integrator, SAMPLES["mitsuba"], theirs)
    run(program, "reference", xml, "--spp", SAMPLES["program"], "-o", f"{ours}.exr")
    errors = ("--stderr", f"{ours}_stderr.exr", "--reference-stderr", f"{theirs}_stderr.exr")
    found = compare(program, f"{ours}.exr", f"{theirs}.exr", *errors)
    share = found["blocks"]["n_within"] / found["blocks"]["n_blocks"]
    good = share >= SHARE
    print(
        f"{name:14}  {share:.1%} of the blocks within {TOLERANCE:.0%} + 3 standard errors, z {found['z']['rms']:.2f}, "
        f"mean off by {abs(found['mean_ratio_overall'] - 1):.2%}  {'ok' if good else 'WRONG'}",
        flush=True,
    )
    return good


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    names = sys.argv[3:] or sorted(scene.stem for scene in (ROOT / "data").glob("*.toml"))
    there = mitsuba("scenes of data/")
    if not there:
        return 0
    mi, numpy = there
    return 0 if all([check(program, folder, name, mi, numpy) for name in names]) else 1


if __name__ == "__main__":
    sys.exit(main())
