"""Figures of docs/formats.md."""

from figures.tools import commands, machine, paragraphs, run, table

WORDS = {
    "tobj": "`tobj` alone",
    "mesh.obj": "OBJ",
    "mesh_vn.obj": "OBJ with normals",
    "ascii.ply": "ASCII PLY",
    "binary.ply": "binary PLY",
    "next frame of mesh.obj": "next frame of the OBJ",
    "next frame of binary.ply": "next frame of the binary PLY",
}


def loaded():
    """The table that the benchmark prints: its head, and rows by what was loaded."""
    lines = [line for line in run("cargo", "bench", "--locked", "--bench", "load").splitlines() if line.startswith("|")]
    head, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return head, {row[0]: row[1:] for row in rows}


def loading():
    """Half a minute, and the build of a benchmark."""
    head, rows = loaded()
    of_tobj = {name: row[2] for name, row in rows.items()}
    return paragraphs(
        table(head, [[WORDS[name], *row] for name, row in rows.items()]),
        f"On {machine()}. OBJ takes {of_tobj['mesh.obj']} of what `tobj` takes to parse it, with normals {of_tobj['mesh_vn.obj']}, "
        f"binary PLY {of_tobj['binary.ply']}.",
        commands("cargo bench --bench load"),
    )


FIGURES = {"loading": loading}
