#!/usr/bin/env python3
"""Renders every scene of data/ and writes docs/gallery.md with time, passes and error under each picture:

    make gallery

usage: gallery.py [SCENE ...]

With names, renders these alone and keeps what the page has of the others. Pictures go to docs/images/gallery/. Times are
those of the machine that runs it.
"""

import sys

from figures.tools import ROOT, caustica_lines, machine

PICTURES = ROOT / "docs/images/gallery"

# Name, size, passes, what it is there for.
SCENES = [
    ("metals", "384x216", 64, "smooth and rough metals: conductors by name and by index, GGX facets, a lamp, a pixel filter"),
    ("ground_glass", "384x216", 64, "smooth and rough glass, a pane, a spot, a constant sky, a picture on a wall"),
    ("plastics", "384x216", 64, "coats over diffuse bases, spheres that shine"),
    ("evening", "384x216", 64, "light from a picture of the sky; pictures as colour and as roughness"),
    ("window", "384x288", 128, "the sun through a pane: light from afar, indirect light, glass and brass"),
    ("pool", "384x288", 64, "the sun through waves: caustics seen through the water that makes them"),
    ("tinted_glass", "384x216", 64, "glass that absorbs, tinted caustics, the shadow of a screen that is cut out"),
    ("depth_of_field", "384x216", 64, "a thin lens, two spots, caustics out of focus"),
    ("cornell_a", "288x288", 64, "point light, diffuse walls: photons bring indirect light alone"),
    ("cornell_b", "288x288", 64, "area light, a mirror and a glass ball"),
    ("course_diffuse", "288x288", 64, "the course's box, all diffuse"),
    ("course_balls", "288x288", 64, "the course's balls: fixed shares of reflection and refraction"),
    ("course_water", "288x288", 64, "the course's water: a mesh of 131,072 triangles under a point light"),
    ("glass_bead", "288x288", 64, "a bead of a thousandth of its room: photons aimed at it"),
    ("keyhole", "288x288", 64, "a room lit through a gap: photons guided to what is seen"),
]

HEAD = """# Gallery

Every scene of `data/`, rendered by one command:

```
make gallery
```

Seconds are those of the machine that is named beside them, the error is the program's own estimate (√relMSE of all light that changes from pass to pass, at most, with 90 %
confidence; [accuracy.md](accuracy.md) says what that is worth). Where light comes from one point through glass no path tracer has a
picture to compare; `make crosscheck` holds the others against Mitsuba 3.
"""


def render(name, size, passes):
    """Seconds and the last estimate of the error."""
    output = ROOT / "out" / "gallery" / f"{name}.exr"
    output.parent.mkdir(parents=True, exist_ok=True)
    records = caustica_lines(f"render data/{name}.toml --size {size} --passes {passes} --json - -o", output)
    (PICTURES / f"{name}.png").write_bytes(output.with_suffix(".png").read_bytes())
    errors = [record["error"]["upper"] for record in records if record.get("error")]
    return records[-1]["seconds_in_all"], errors[-1] if errors else None


def entry(name, size, passes, words):
    seconds, error = render(name, size, passes)
    known = f"error at most {100 * error:.1f} %" if error is not None else "nothing changes from pass to pass"
    shown = f"caustica render data/{name}.toml --size {size} --passes {passes}"
    return (
        f"\n## {name}\n\n![{name}](images/gallery/{name}.png)\n\n"
        f"{words[0].upper()}{words[1:]}.\n\n`{shown}`: {passes} passes in {seconds:.0f} s on {machine()}, {known}.\n"
    )


def known():
    """The entries of the page as it is, by the names of their scenes."""
    page = ROOT / "docs/gallery.md"
    entries = page.read_text().split("\n## ")[1:] if page.exists() else []
    return {entry.split("\n", 1)[0]: f"\n## {entry}" for entry in entries}


def main(names):
    unknown = set(names) - {scene[0] for scene in SCENES}
    if unknown:
        sys.exit(f"no scene of the gallery: {', '.join(sorted(unknown))}; allowed: {', '.join(s[0] for s in SCENES)}")
    PICTURES.mkdir(parents=True, exist_ok=True)
    kept = known() if names else {}
    pages = [HEAD]
    for scene in SCENES:
        if scene[0] not in names and scene[0] in kept:
            pages.append(kept[scene[0]])
            continue
        print(scene[0], flush=True)
        pages.append(entry(*scene))
    (ROOT / "docs/gallery.md").write_text("".join(pages))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
