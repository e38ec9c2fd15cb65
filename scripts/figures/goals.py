"""The goals, and whether what was measured reaches them."""

from statistics import median

from figures.gather import (
    GRID,
    GROWTH,
    GROWTH_OF_A_MILLION,
    KIDDO,
    POINT_QUERY,
    TREE,
    VARIANTS,
    WALLS,
    grown,
    radius,
    set_ups,
)
from figures.passes import ANEW, COURSE, KEPT, NARROW, WIDE, measure, speed_ups, times, values
from figures.tools import digits, from_to, kept, merged, paragraphs, table, with_ends


def set_ups_of(figure, runs):
    return set_ups(kept(f"performance.{figure}", lambda: merged(*runs)))


def verdict(numbers, is_reached, otherwise):
    """Whether all numbers of a goal reach it, in words."""
    reached = sum(map(is_reached, numbers))
    return {len(numbers): "yes", 0: "**no**"}.get(reached, otherwise.format(reached, len(numbers)))


def of_rounds(is_reached, numbers, unit=""):
    """Of one thing, measured several times."""
    return f"{verdict(numbers, is_reached, 'at the edge')}: {with_ends(numbers)}{unit}"


def of_cases(is_reached, numbers, unit=""):
    """Of several things."""
    return f"{verdict(numbers, is_reached, 'in {} of {} cases')}: {from_to(numbers)}{unit}"


def at_most(bound):
    return lambda number: number <= bound


def at_least(bound):
    return lambda number: number >= bound


def of_passes():
    reports = kept("performance.passes", measure)
    course, wide, narrow = (reports[key]["all"] for key in (COURSE, WIDE, NARROW))
    sizes = [size for key in KEPT for size in values(reports[key]["all"], "bytes_per_hit_point")]
    ups = [median(speed_ups(reports[key], phase)) for key in KEPT for phase in ("trace", "gather")]
    anew = dict(zip((WIDE, NARROW), (times(reports[key]["all"]) for key in ANEW)))
    return [
        ["pass at most 1.8 x bare tracing, `course_diffuse`", of_rounds(at_most(1.8), values(course, "ratio_to_bare"), " x")],
        ["the same, `cornell_b` at radius 10", of_rounds(at_most(1.8), values(wide, "ratio_to_bare"), " x")],
        ["800,000 photons/s there", of_rounds(at_least(8e5), values(wide, "photons_per_second"))],
        ["1,200,000 photons/s at radius 2.2", of_rounds(at_least(1.2e6), values(narrow, "photons_per_second"))],
        [
            "eye paths anew, radius 10: pass at most 220 ms (half of the fastest renderer known to us)",
            of_rounds(at_most(220), anew[WIDE], " ms"),
        ],
        ["eye paths anew, radius 2.2: at most 105 ms", of_rounds(at_most(105), anew[NARROW], " ms")],
        ["at most 100 bytes a hit point", of_cases(at_most(100), sizes)],
        ["trace and gather each 1.85 x as fast on two threads as on one", of_cases(at_least(1.85), ups, " x")],
    ]


def against(rivals, bound, cases):
    """Whether the tree is so many times as fast as rivals in all cases, and where it is not."""
    factors = {case: min(rows[rival]["times_first"] for rival in rivals) for case, rows in cases.items()}
    missed = [
        f"{digits(factor, 2)} x among {points:,} at {radius(percent)}"
        for (points, percent), factor in factors.items()
        if factor < bound
    ]
    reached = of_cases(at_least(bound), list(factors.values()), " x")
    return f"{reached} ({', '.join(missed)})" if missed else reached


def of_gathering():
    cases = set_ups_of("gather", WALLS)
    wide = {case: rows for case, rows in cases.items() if case[1] >= 1}
    narrow = {case: rows for case, rows in cases.items() if case[1] == 0.1}
    built = next(iter(set_ups_of("variants", VARIANTS).values()))[TREE]["build_ms"]
    growth, of_a_million = set_ups_of("growth", GROWTH), set_ups_of("growth_of_a_million", GROWTH_OF_A_MILLION)
    return [
        ["4 x as fast as the point query at 1 % and above", against([POINT_QUERY], 4, wide)],
        ["2.5 x at 0.1 %", against([POINT_QUERY], 2.5, narrow)],
        ["as fast as hash grid and kiddo everywhere", against([GRID, KIDDO], 1, cases)],
        ["1,048,576 spheres built in 250 ms on two cores", of_rounds(at_most(250), [built[end] for end in ("min", "median", "max")], " ms")],
        ["ns a photon at most doubles from 100,000 to 4,000,000 at equal overlaps, 100,000 photons", of_rounds(at_most(2), [grown(growth, TREE)], " x")],
        ["the same, 1,000,000 photons", of_rounds(at_most(2), [grown(of_a_million, TREE)], " x")],
    ]


def goals():
    """Nothing, after the others."""
    return paragraphs(
        table(["goal", "reached"], of_passes() + of_gathering()),
        "In brackets the smallest and the largest of several runs: a goal is at the edge where they fall on both sides. Without brackets "
        "numbers are those of several scenes or set-ups, which count one by one.",
    )
