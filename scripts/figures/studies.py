"""Tables of what `caustica study` measured."""

import json
import shutil
import sys

from figures.tools import ROOT, caustica, digits


# A slow machine may not get through a study within its budget; the same command goes on with it.
ATTEMPTS = 4


def study(arguments, folder):
    """All that a study measures, anew, into a folder of out/."""
    shutil.rmtree(ROOT / folder, ignore_errors=True)
    report = ROOT / folder / "study.json"
    for _ in range(ATTEMPTS):
        caustica(f"study {arguments} -o {folder}")
        told = json.loads(report.read_text()) if report.exists() else None
        if told and told["complete"]:
            return told
    sys.exit(f"caustica study {arguments} was not complete after {ATTEMPTS} times its budget")


def curves(told):
    """The curves of a study by the names of their configurations."""
    return {curve["name"]: curve for curve in told["curves"]}


def seconds_to(curve, percent):
    """Seconds to an error, and whether they were measured; `None` where it is out of reach."""
    conclusion = next(to["seconds"] for to in curve["seconds_to"] if to["percent"] == percent)
    if conclusion == "out_of_reach":
        return None
    [(kind, value)] = conclusion.items()
    return (value["median"], True) if kind == "measured" else (value, False)


def reached(curve, percent):
    found = seconds_to(curve, percent)
    if found is None:
        return "not reached"
    seconds, is_measured = found
    return f"{digits(seconds, 2)} s" if is_measured else f"≈ {digits(seconds, 2)} s predicted"


def exponent(curve):
    if curve["exponent"] is None:
        return "unknown"
    width = curve["exponent_half_width"]
    return f"{curve['exponent']:.3f}" + (f" ± {width:.3f}" if width is not None else "")


def price_of_half(curve):
    return f"x {curve['price_of_half']:.1f}" if curve["price_of_half"] is not None else "out of reach"


def theory(curve):
    noise, bias = curve["theory"]["noise"], curve["theory"]["bias"]
    return f"{noise:.3f}, " + ("none" if not bias else f"{bias:.3f}")


def spread(seconds):
    return f"{digits(seconds['median'])} ({digits(seconds['min'])} to {digits(seconds['max'])})"
