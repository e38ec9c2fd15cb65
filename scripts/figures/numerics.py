"""Figures of docs/numerics.md."""

from figures.tools import caustica_json, commands, digits, from_to, paragraphs, table

NUMERICS = "bench --numerics 20000"
ROUNDS = 3
LEAKS = "bench --leaks 1e7"
INFO = ("course_diffuse", "course_water", "cornell_b")
PLAIN = ("largest coordinate", "wrong in a million")


def scientific(error):
    return "0" if error == 0 else f"{error:.1e}".replace("e-0", "e-")


def bytes_of_renders():
    """Memory of whole renders, a hit point."""
    infos = [caustica_json(f"info data/{scene}.toml --json") for scene in INFO]
    return [info["memory_bytes"] / info["setup"]["hit_points"] for info in infos]


def number_rows(reports):
    """A row for each way to keep each number: nanoseconds are medians of all reports."""
    rows, last = [], None
    for same in zip(*(report["rows"] for report in reports)):
        row, times = same[0], [row["nanoseconds"] for row in same]
        number = row["number"] if row["number"] != last else ""
        error = (digits(row["error"], 2) if row["number"].endswith(PLAIN) else scientific(row["error"]))
        cost = "" if None in times else from_to(times, 2)
        rows.append([number, row["way"], error, f"{row['bytes']:.0f}", cost])
        last = row["number"]
    return rows


def precision():
    """Half a minute."""
    reports = [caustica_json(NUMERICS, "--json -") for _ in range(ROUNDS)]
    rows = {(row["number"].split(",")[0].split(" of ")[0], row["way"]): row for row in reports[0]["rows"]}
    weights = rows["point off its triangle", "weights of the corners"]["error"]
    ray = rows["point off its triangle", "along the ray"]["error"]
    radius, light = (rows[name, "f32"]["error"] for name in ("R² by a common schedule", "light"))
    return paragraphs(
        table(["number", "way", "error", "bytes", "ns an update"], number_rows(reports)),
        f"Nanoseconds: the smallest and the largest of {ROUNDS} runs.",
        "\n".join(
            [
                f"- A point computed along the ray is off its triangle by up to {digits(ray, 2)} roundings of its largest coordinate, one from "
                f"the weights of the corners by up to {digits(weights, 2)}. The bound is 32.",
                f"- In f32 the squared radius ends up off by {scientific(radius)} and the light by {scientific(light)}, both far below the noise. Ten "
                f"million equal photons sum to {digits(100 * rows['sum', 'f32']['error'], 2)} % less than they should, and a count to twenty "
                f"million ends {digits(100 * rows['count', 'f32']['error'], 2)} % short.",
                f"- Renders of {', '.join(f'`{scene}`' for scene in INFO)} take {from_to(bytes_of_renders())} bytes a hit point in all.",
            ]
        ),
        commands(f"caustica {NUMERICS}", *(f"caustica info data/{scene}.toml --json" for scene in INFO)),
    )


def seams():
    """A minute or two."""
    report = caustica_json(LEAKS, "--json -")
    parts = ("edges", "vertices", "bounces")
    rows = [
        [row["mesh"], f"{row['triangles']:,}", f"`{row['traversal']}`"]
        + [f"{row[part][key]:,}" for part in parts for key in ("rays", "leaks")]
        for row in report["rows"]
    ]

    def lost(part, traversal, mesh=None):
        """Of the rays at all meshes, or at one."""
        own = [row[part] for row in report["rows"] if row["traversal"] == traversal and mesh in (None, row["mesh"])]
        leaks, rays = (sum(counts[key] for counts in own) for key in ("leaks", "rays"))
        return f"{leaks:,} of {rays:,} ({100 * leaks / rays:.2g} %)" if leaks else f"none of {rays:,}"

    head = ["mesh", "triangles", "traversal", "rays to edges", "lost", "rays to vertices", "lost", "bounces from there", "lost"]
    return paragraphs(
        table(head, rows),
        "\n".join(
            [
                f"- At edges of all meshes Embree's robust mode loses {lost('edges', 'embree')}, the project's own tree "
                f"{lost('edges', 'custom')}; at edges of the ball Embree without that mode {lost('edges', 'embree-fast', 'ball')}.",
                f"- At vertices of the ball Embree's robust mode loses {lost('vertices', 'embree', 'ball')}, without it "
                f"{lost('vertices', 'embree-fast', 'ball')}; the own tree at vertices of all meshes {lost('vertices', 'custom')}.",
                f"- Of the rays that bounce off the seams the robust mode loses {lost('bounces', 'embree')}, the own tree "
                f"{lost('bounces', 'custom')}.",
            ]
        ),
        commands(f"caustica {LEAKS}"),
    )


FIGURES = {"precision": precision, "seams": seams}
