"""Photons among hit-point spheres: the sphere tree and its rivals."""

from figures.tools import digits, from_to, keep, merged, paragraphs, table, typed

TREE = "sphere tree"
UNSORTED = "sphere tree (photons as traced)"
SINGLE = "sphere tree (one by one)"
POINT_QUERY = "Embree point query"
GRID = "hash grid"
KIDDO = "k-d tree (kiddo)"
LOOSE = (POINT_QUERY, GRID, KIDDO)
RIVALS = (UNSORTED, SINGLE, *LOOSE)
NAMES = {UNSORTED: "photons as traced", SINGLE: "one by one", KIDDO: "kiddo"}
SHAPES = ("by volume", "leaves of 12", "leaves of 8", "leaves of 4")
LANES = ("portable lanes", "AVX2 lanes", "AVX-512 lanes")

# A round among few spheres is over in a millisecond or two: it takes more of them.
WALLS = ["bench --gather --points 1e4,1e5 --repetitions 15", "bench --gather --points 1e6,4e6 --repetitions 3"]
VARIANTS = ["bench --gather --variants --points 1048576 --radii 0.1,0.4,1,5 --repetitions 5"]
GROWTH = ["bench --gather --points 1e5,4e5,1e6,4e6 --overlaps 50 --repetitions 5"]
GROWTH_OF_A_MILLION = ["bench --gather --photons 1e6 --points 1e5,4e6 --overlaps 50 --repetitions 3"]
WATER = ["bench --gather --scene data/course_water.toml --points 1e5,1e6 --radii 0.05,0.1,0.4,1 --repetitions 3"]
CORNELL = [
    "bench --gather --scene data/cornell_b.toml --photons 1e5 --points 1e4 --radii 0.05,0.4,1,5 --repetitions 15",
    "bench --gather --scene data/cornell_b.toml --photons 1e5 --points 1e6 --radii 0.05,0.4,1,5 --repetitions 3",
]


def measured(runs):
    """The report of commands, and its rows by structure for each number of spheres and radius."""
    report = merged(*runs)
    return report, set_ups(report)


def set_ups(report):
    """Rows by structure, for each number of spheres and radius in order."""
    cases = {}
    for row in report["rows"]:
        cases.setdefault((row["points"], row["radius_percent"]), {})[row["structure"]] = row
    return cases


def radius(percent):
    return f"{digits(percent, 3).rstrip('0').rstrip('.')} %"


def nanoseconds(row):
    return digits(row["ns_per_photon"]["median"])


def times(row):
    return f"{digits(row['times_first'], 2 if row['times_first'] < 1 else 3)} x"


def of_all(cases, key, structures):
    return [case[name][key] for case in cases for name in structures]


def multiples_table(report, cases):
    """A row for each case: the tree's nanoseconds, and the rivals as multiples of them."""
    head = ["spheres", "radius", "overlaps a photon", "sphere tree (ns a photon)", *(NAMES.get(r, r) for r in RIVALS)]
    rows = [
        [
            f"{points:,}",
            radius(percent),
            digits(case[TREE]["overlaps"] / report["photons"], 2),
            nanoseconds(case[TREE]),
            *(times(case[rival]) for rival in RIVALS),
        ]
        for (points, percent), case in cases.items()
    ]
    return table(head, rows)


def ranges(cases):
    """By how much each of the independent structures is slower than the tree."""
    return "; ".join(f"{NAMES.get(name, name)} {from_to(of_all(cases, 'times_first', [name]))} times" for name in LOOSE)


def exceptions(cases):
    """Where a rival gathers faster than the tree, in words."""
    faster = [
        f"{NAMES.get(name, name)} among {points:,} at {radius(percent)}"
        for (points, percent), case in cases.items()
        for name in LOOSE
        if case[name]["times_first"] < 1
    ]
    return f"Faster than the tree: {', '.join(faster)}." if faster else "No rival gathers faster."


def compared(cases):
    return f"- As a multiple of the sphere tree's time they take: {ranges(cases.values())}. {exceptions(cases)}"


def helped(cases):
    """What sorting and walking as a batch are worth."""
    return (
        f"- Photons that are not sorted take {from_to(of_all(cases.values(), 'times_first', [UNSORTED]), 2)} times as long, and those that "
        f"walk down one by one {from_to(of_all(cases.values(), 'times_first', [SINGLE]), 2)} times."
    )


def builds(cases):
    """Milliseconds to build, by the numbers of spheres: over all radii."""
    by_points = {}
    for (points, _), case in cases.items():
        by_points.setdefault(points, []).append(case)
    rows = [
        [f"{points:,}", *(from_to([b["median"] for b in of_all(same, "build_ms", [name])], 2) for name in (TREE, *LOOSE))]
        for points, same in by_points.items()
    ]
    return table(["spheres", TREE, *(NAMES.get(name, name) for name in LOOSE)], rows)


def sizes(cases):
    each = [f"{NAMES.get(s, s)} {from_to(of_all(cases.values(), 'bytes_per_point', [s]))}" for s in (TREE, *LOOSE)]
    return f"- Bytes a sphere: {', '.join(each)}."


def gather():
    """Four minutes, half of them for 4,000,000 spheres."""
    report, cases = measured(WALLS)
    keep("performance.gather", report)
    return paragraphs(
        multiples_table(report, cases),
        "Building on all threads (ms; medians, the smallest and the largest over the radii):",
        builds(cases),
        "\n".join([compared(cases), helped(cases), sizes(cases)]),
        typed(*WALLS),
    )


def grown(cases, name):
    """By how much a photon comes to cost more from the fewest spheres to the most."""
    first, *_, last = (case[name]["ns_per_photon"]["median"] for case in cases.values())
    return last / first


def growth():
    """Two minutes: most of it is a million photons among 4,000,000 spheres."""
    report, cases = measured(GROWTH)
    keep("performance.growth", report)
    report, many = measured(GROWTH_OF_A_MILLION)
    keep("performance.growth_of_a_million", report)
    structures = (TREE, *LOOSE)
    rows = [
        [of, f"{points:,}", radius(percent), *(nanoseconds(case[name]) for name in structures), digits(case[TREE]["ns_per_overlap"], 2)]
        for of, of_photons in (("100,000", cases), ("1,000,000", many))
        for (points, percent), case in of_photons.items()
    ]
    head = ["photons", "spheres", "radius", *(f"{NAMES.get(name, name)} (ns a photon)" for name in structures)]
    told = [
        f"{', '.join(f'{NAMES.get(name, name)} {digits(grown(c, name), 2)} times' for name in structures)} as much for {of} photons"
        for of, c in (("100,000", cases), ("1,000,000", many))
    ]
    return paragraphs(
        table([*head, "sphere tree (ns an overlap)"], rows),
        f"From the fewest spheres to the most a photon comes to cost: {'; '.join(told)}.",
        typed(*GROWTH, *GROWTH_OF_A_MILLION),
    )


def of_scene(name, runs):
    report, cases = measured(runs)
    text = f"`{name}`, {report['photons']:,} photons, radii in percent of {digits(report['extent'])}:"
    return paragraphs(text, multiples_table(report, cases), "\n".join([compared(cases), helped(cases)]))


def real():
    """Five minutes."""
    return paragraphs(
        of_scene("course_water", WATER),
        of_scene("cornell_b", CORNELL),
        typed(*WATER, *CORNELL),
    )


def variants():
    """A minute."""
    report, cases = measured(VARIANTS)
    keep("performance.variants", report)
    there = [name for name in LANES if name in next(iter(cases.values()))]
    others = (*SHAPES, *there)
    rows = [
        [radius(percent), nanoseconds(case[TREE]), *(times(case[name]) for name in others)]
        for (_, percent), case in cases.items()
    ]
    each = "; ".join(f"{name} {from_to(of_all(cases.values(), 'times_first', [name]), 3)}" for name in others)
    return paragraphs(
        table(["radius", "sphere tree (ns a photon)", *others], rows),
        f"As multiples of the program's tree: {each}.",
        typed(*VARIANTS),
    )
