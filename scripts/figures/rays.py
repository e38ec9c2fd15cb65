"""Rays of real renders: Embree asked and built in all its ways, and the project's own tree."""

from figures.tools import commands, digits, from_to, merged, paragraphs, table

RAYS = ["bench --rays --triangles 36,2e4 --repetitions 9", "bench --rays --triangles 131072,1e6 --repetitions 3"]
OURS, CUSTOM = "Embree high robust", "custom tree"
BUILDS = [f"Embree {quality}{robust}" for robust in (" robust", "") for quality in ("high", "medium", "low")]
LOOSE = [build for build in BUILDS if "robust" not in build]
SINGLE, ANY, CUSTOM_NEAREST, CUSTOM_ANY = "rtcIntersect1", "rtcOccluded1", "nearest hit", "any hit"
PACKETS = [f"rtcIntersect{width}{order}" for order in ("", " coherent") for width in (8, 16)]
KINDS = ("eye", "shadow", "photon")


class Rows:
    """The rows of the report, by what they measured."""

    def __init__(self, report):
        self.all = {(r["triangles"], r["kind"], r["structure"], r["query"]): r for r in report["rows"]}
        self.triangles = list(dict.fromkeys(r["triangles"] for r in report["rows"]))
        self.rays = sum(self.of(size, kind, OURS, SINGLE)["rays"] for size in self.triangles for kind in KINDS)

    def of(self, triangles, kind, structure, query):
        return self.all[triangles, kind, structure, query]

    def speed(self, *which):
        """Million rays a second on one thread."""
        return self.of(*which)["one_thread"]["median"]

    def factors(self, these, those, kinds=KINDS, sizes=None):
        """How many times as fast (structure, query) are as another, of all kinds of rays and sizes."""
        return [
            self.speed(size, kind, *these) / self.speed(size, kind, *those)
            for size in sizes or self.triangles
            for kind in kinds
        ]

    def row(self, label, kind, these, those):
        """Speeds through scenes of all sizes, and what multiples they are of others."""

        def cell(size):
            speed, first = (self.speed(size, kind, *which) for which in (these, those))
            return digits(speed) + (f" ({speed / first:.2f})" if these != those else "")

        return [label, *(cell(size) for size in self.triangles)]

    def disagreements(self, structure, queries, key):
        return sum(
            self.of(size, kind, structure, query)[key]
            for size in self.triangles
            for kind in KINDS
            for query in queries
        )


def asked(kind):
    """Ways to ask rays of a kind, and what to call them."""
    ways = [((OURS, query), f"`{query}`".replace(" coherent`", "`, coherent")) for query in (SINGLE, *PACKETS)]
    ways.append(((CUSTOM, CUSTOM_NEAREST), "custom tree, nearest hit"))
    any_hit = [((OURS, ANY), f"`{ANY}`"), ((CUSTOM, CUSTOM_ANY), "custom tree, any hit")]
    return ways + (any_hit if kind == "shadow" else [])


def ways_table(rows):
    lines = []
    for kind in KINDS:
        for which, label in asked(kind):
            lines.append([kind if which[1] == SINGLE else "", *rows.row(label, kind, which, (OURS, SINGLE))])
    return table(["rays", "asked by", *sizes(rows)], lines)


def sizes(rows):
    return [f"{size:,} triangles" for size in rows.triangles]


def builds_table(rows):
    lines = []
    for kind in KINDS:
        query = ANY if kind == "shadow" else SINGLE
        for build in BUILDS:
            label = build.removeprefix("Embree ")
            lines.append([kind if build == OURS else "", *rows.row(label, kind, (build, query), (OURS, query))])
    return table(["rays", "Embree's build", *sizes(rows)], lines)


def costs_table(rows):
    def cells(build):
        query = CUSTOM_NEAREST if build == CUSTOM else SINGLE
        of_sizes = [rows.of(size, "eye", build, query) for size in rows.triangles]
        milliseconds = [digits(row["build_ms"]["median"], 2) for row in of_sizes]
        return [build.removeprefix("Embree "), *milliseconds, *(digits(row["bytes_per_triangle"], 2) for row in of_sizes[1:])]

    ends = [f"bytes ({size:,})" for size in rows.triangles[1:]]
    return table(["build", *sizes(rows), *ends], [cells(build) for build in (*BUILDS, CUSTOM)])


def of_packets(rows):
    few, *more = rows.triangles
    single = (OURS, SINGLE)
    sorted_ = [(OURS, query) for query in PACKETS[2:]]

    def coherent(kinds, some):
        return from_to([factor for these in sorted_ for factor in rows.factors(these, single, kinds, some)], 2)

    return [
        f"- Packets of 8 are {from_to(rows.factors((OURS, PACKETS[0]), single), 2)} times as fast as single rays, packets of 16 "
        f"{from_to(rows.factors((OURS, PACKETS[1]), single), 2)} times.",
        f"- Sorted and declared coherent, eye and shadow rays go {coherent(('eye', 'shadow'), [few])} times as fast among {few} triangles, "
        f"and {coherent(('eye', 'shadow'), more)} times among more; photon rays {coherent(('photon',), [few])} and "
        f"{coherent(('photon',), more)} times.",
    ]


def of_queries(rows):
    any_hit = rows.factors((OURS, ANY), (OURS, SINGLE), ["shadow"])
    custom_any = rows.factors((CUSTOM, CUSTOM_ANY), (CUSTOM, CUSTOM_NEAREST), ["shadow"])
    custom = rows.factors((CUSTOM, CUSTOM_NEAREST), (OURS, SINGLE))
    threads = [
        row["all_threads"]["median"] / row["one_thread"]["median"]
        for row in (rows.of(size, kind, OURS, SINGLE) for size in rows.triangles[1:] for kind in KINDS)
    ]
    return [
        f"- `{ANY}` is {from_to(any_hit, 2)} times as fast as `{SINGLE}` on the same rays, the custom tree's any hit "
        f"{from_to(custom_any, 2)} times as fast as its nearest hit.",
        f"- The custom tree reaches {from_to(custom, 2)} of Embree's single rays.",
        f"- All threads answer {from_to(threads, 2)} times as many single rays as one from {rows.triangles[1]:,} triangles on. "
        "Among the fewest a round is over in milliseconds, and waking the threads shows.",
    ]


def of_builds(rows):
    def nearest(these, those):
        return from_to(rows.factors((these, SINGLE), (those, SINGLE)), 2)

    def costs(key, build, query=SINGLE):
        pairs = [(rows.of(s, "eye", build, query), rows.of(s, "eye", OURS, SINGLE)) for s in rows.triangles[1:]]
        value = (lambda row: row[key]["median"]) if key == "build_ms" else (lambda row: row[key])
        return from_to([value(row) / value(first) for row, first in pairs], 2)

    low, plain = "Embree low robust", "Embree medium"
    return [
        f"- *Robust* makes nearest hits {nearest('Embree medium robust', plain)} times as fast with the build *medium*.",
        "- In robust scenes Embree takes *high* for *medium*: it splits no triangles there, so the two rows are one tree measured "
        f"twice. They are {nearest('Embree medium robust', OURS)} of each other: what the rest may be off by.",
        f"- Without *robust*, *high* does split: it is {nearest('Embree high', plain)} times as fast as *medium*.",
        f"- *Low* builds in {costs('build_ms', low)} of the time from {rows.triangles[1]:,} triangles on, answers {nearest(low, OURS)} times "
        f"as fast, and takes {costs('bytes_per_triangle', low)} times the memory.",
        f"- The custom tree takes {costs('build_ms', CUSTOM, CUSTOM_NEAREST)} times as long to build there, and "
        f"{costs('bytes_per_triangle', CUSTOM, CUSTOM_NEAREST)} times the memory.",
    ]


def agreement(rows):
    """Of how many rays somebody says otherwise than `rtcIntersect1`."""
    keys = ("different", "ties", "distances")
    robust = [b for b in BUILDS if b not in LOOSE and b != OURS]
    faithful = sum(rows.disagreements(OURS, PACKETS, key) + sum(rows.disagreements(b, [SINGLE], key) for b in robust) for key in keys)
    loose = [max(rows.disagreements(build, [SINGLE], key) for build in LOOSE) for key in keys]
    custom = [rows.disagreements(CUSTOM, [CUSTOM_NEAREST], key) for key in keys]

    def words(counts):
        return (
            f"something else, or nothing, for {counts[0]:,} rays; on an edge the other triangle for {counts[1]:,}; the same triangle at a "
            f"distance that differs by more than 1e-5 of itself for {counts[2]:,}"
        )

    return (
        f"**Do they agree?** Of {rows.rays:,} rays, packets and robust builds of all qualities say otherwise than `{SINGLE}` for {faithful:,}. "
        f"Builds that are not robust find at most: {words(loose)}. The custom tree finds {words(custom)}."
    )


def rays():
    """Two to three minutes."""
    rows = Rows(merged(*RAYS))
    return paragraphs(
        f"{rows.rays:,} rays in all. **Ways to ask**, million rays a second on one thread; in brackets as a multiple of `{SINGLE}`:",
        ways_table(rows),
        "\n".join(of_packets(rows) + of_queries(rows)),
        "**Ways to build**, single rays, one thread, million a second; shadow rays by `rtcOccluded1`; in brackets as a multiple of what "
        "the program builds:",
        builds_table(rows),
        "Time to build on all threads (ms) and bytes a triangle, the structure's copy of the triangles included:",
        costs_table(rows),
        "\n".join(of_builds(rows)),
        agreement(rows),
        commands(*(f"caustica {run}" for run in RAYS)),
    )
