"""Figures of docs/assignment.md."""

from figures.tools import caustica, caustica_json, commands, digits, machine, paragraphs, table, typed

DEEPEST = ("course_balls", "cornell_b")


def cut(scene):
    """What the scene's own limit of depth loses of its picture."""
    told = caustica_json(f"info data/{scene}.toml --json")
    lost = next(cut["lost_share"] for cut in told["cuts"] if cut["depth"] == told["depth"])
    return f"{100 * lost:.5f} % of the weight of `{scene}` at the depth of {told['depth']}"


def depth():
    """Seconds."""
    return paragraphs(f"Cut off is {' and '.join(map(cut, DEEPEST))}.", typed(*(f"info data/{scene}.toml" for scene in DEEPEST)))


PASS = "bench --pass data/course_diffuse.toml --repetitions 21"


def one_pass():
    """Seconds."""
    told = caustica_json(f"{PASS} --json -")
    seconds = told["spread"]["seconds_per_pass"]
    return paragraphs(
        f"On {machine()} a pass of {told['photons']:,} photons over {told['hit_points']:,} hit points takes "
        f"{digits(seconds['median'], 2)} s ({digits(seconds['min'], 2)} to {digits(seconds['max'], 2)}).",
        typed(PASS),
    )


def noise_of(sampling):
    """How two renders differ that share nothing but their settings: MSE and relMSE."""
    for seed in (1, 2):
        caustica(f"render data/course_diffuse.toml --passes 16 --sampling {sampling} --seed {seed} -o out/{sampling}_{seed}.exr")
    told = caustica_json(f"compare out/{sampling}_1.exr out/{sampling}_2.exr --json")
    return told["mse"], told["rel_mse"]


def bounces():
    """Half a minute."""
    cosine, uniform = noise_of("cosine"), noise_of("uniform")
    rows = [[name, *map(digits, noise)] for name, noise in (("cosine", cosine), ("uniform", uniform))]
    return paragraphs(
        commands(
            "caustica render data/course_diffuse.toml --passes 16 --sampling cosine --seed 1 -o out/cosine_1.exr    # and seed 2",
            "caustica render data/course_diffuse.toml --passes 16 --sampling uniform --seed 1 -o out/uniform_1.exr  # and seed 2",
            "caustica compare out/cosine_1.exr out/cosine_2.exr",
            "caustica compare out/uniform_1.exr out/uniform_2.exr",
        ),
        table(["bounces", "MSE between seeds", "relative MSE between seeds"], rows),
        f"Uniform sampling has {uniform[0] / cosine[0]:.2f} times the variance, so it needs so many times the photons.",
    )


FIGURES = {"depth": depth, "pass": one_pass, "bounces": bounces}
