#!/usr/bin/env python3
"""Measures what a batch costs beside its renders: 200 jobs of 64 x 64 pixels and 4 passes, one by one and as a batch; and what 50
frames load that share a mesh of 1,002,528 triangles.

usage: batch_cost.py PROGRAM [FOLDER [JOBS [REPETITIONS]]]
"""

import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
JOBS = 200
SIZE, PASSES, PHOTONS = "64x64", 4, 20000
SCENE = ROOT / "data" / "course_diffuse.toml"
FLAGS = [f"--size={SIZE}", f"--passes={PASSES}", f"--photons={PHOTONS}"]


def seconds_of(command, **options):
    started = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr}")
    return time.perf_counter() - started, done


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def one_by_one(program, folder, jobs):
    """Seconds that the renders tell of themselves, and those of their processes."""
    told, whole = [], []
    for seed in range(jobs):
        passes = folder / "passes.jsonl"
        command = [program, "render", SCENE, *FLAGS, f"--seed={seed}", "--threads=1", "--reproducible", "-o", folder / "one.exr", "--json", passes]
        whole.append(seconds_of(command)[0])
        told.append(json.loads(passes.read_text().splitlines()[-1])["seconds_in_all"])
    return told, whole


def batch(program, out, cores, *arguments):
    """Seconds of a batch, anew, and what the program tells of each of its jobs."""
    shutil.rmtree(out, ignore_errors=True)
    seconds, _ = seconds_of([program, "batch", *arguments, f"--jobs={cores}", "--threads=1", "-o", out])
    _, status = seconds_of([program, "batch", "status", out, "--json"])
    return seconds, [json.loads(line) for line in status.stdout.splitlines()]


def as_batch(program, folder, jobs, cores):
    seeds = ",".join(map(str, range(jobs)))
    sweep = [f"--set=size={SIZE}", f"--set=photons={PHOTONS}", f"--set=seed={seeds}"]
    seconds, rows = batch(program, folder / "batch", cores, SCENE, *sweep, f"--passes={PASSES}")
    return seconds, sum(row["seconds"] for row in rows), sum(row["attempts"][0]["load_seconds"] for row in rows)


def start_up(program, folder, repetitions=40):
    """Seconds from the start of a process until its scene is ready, and those of the process alone."""
    order = json.dumps({"prepare": {"arguments": ["render", str(SCENE), *FLAGS, f"--output={folder}/start.exr"]}})
    ready, bare = [], []
    for _ in range(repetitions):
        bare.append(seconds_of([program, "worker", "--threads=1"], input="")[0])
        started = time.perf_counter()
        worker = subprocess.Popen([program, "worker", "--threads=1"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        worker.stdin.write(order + "\n")
        worker.stdin.flush()
        worker.stdout.readline()
        ready.append(time.perf_counter() - started)
        worker.stdin.close()
        worker.wait()
    return ready, bare


CELLS, FRAMES = 708, 50
FRAME = """[film]
width = 64
height = 64
[camera]
position = [0.5, 1.5, {z}]
look_at = [0.5, 0, 0.5]
fov = 40
[material.grey]
diffuse = {{ albedo = [0.5, 0.5, 0.5] }}
[[mesh]]
file = "large.obj"
material = "grey"
[[point_light]]
position = [0.5, 2, 0.5]
intensity = [1, 1, 1]
"""


def frames(program, folder, cores):
    """Seconds of the frames, how many processes rendered them, and seconds of loading: of the first of each, of the others."""
    folder = folder / "frames"
    folder.mkdir(exist_ok=True)
    subprocess.run([program, "surface", folder / "large.obj", "--cells", str(CELLS)], check=True, capture_output=True)
    for frame in range(FRAMES):
        (folder / f"frame_{frame:02}.toml").write_text(FRAME.format(z=1.5 + 0.01 * frame))
    seconds, rows = batch(program, folder / "out", cores, folder / "frame_*.toml", "--passes=1")
    loads = {}
    for attempt in (row["attempts"][0] for row in rows):
        loads.setdefault(attempt["process"], []).append(attempt["load_seconds"])
    firsts = sorted(max(loads_of_one) for loads_of_one in loads.values())
    others = sorted(load for loads_of_one in loads.values() for load in sorted(loads_of_one)[:-1])
    return {"seconds": seconds, "processes": len(loads), "firsts": firsts, "others": statistics.median(others)}


def batch_against_renders(program, folder, jobs, cores):
    """Seconds of the same jobs one by one and as a batch, and what the batch takes more than `cores` times fewer of them."""
    marks = [processor_seconds()]
    told, whole = one_by_one(program, folder, jobs)
    marks.append(processor_seconds())
    seconds, in_batch, loading = as_batch(program, folder, jobs, cores)
    marks.append(processor_seconds())
    return {
        "one by one": sum(whole),
        "renders": sum(told),
        "batch": seconds,
        "renders in the batch": in_batch,
        "loading": loading,
        "against its renders": seconds * cores / in_batch,
        "against processes": seconds * cores / sum(whole),
        "against renders": seconds * cores / sum(told),
        "renders beside each other": in_batch / sum(told),
        "processor seconds": (marks[2] - marks[1]) / (marks[1] - marks[0]),
    }


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = Path(sys.argv[1]).resolve()
    folder = Path(sys.argv[2] if len(sys.argv) > 2 else "out/batch_cost").resolve()
    jobs = int(sys.argv[3]) if len(sys.argv) > 3 else JOBS
    repetitions = int(sys.argv[4]) if len(sys.argv) > 4 else 3
    folder.mkdir(parents=True, exist_ok=True)
    cores = len(os.sched_getaffinity(0))
    ready, bare = map(statistics.median, start_up(program, folder))
    print(f"start-up: process {1e3 * bare:.1f} ms, with its scene ready {1e3 * ready:.1f} ms (medians)")
    told = frames(program, folder, cores)
    print(
        f"{FRAMES} frames that share {2 * CELLS * CELLS} triangles: {told['seconds']:.1f} s in {told['processes']} processes; the first frame of "
        f"each loads in {told['firsts'][0]:.2f} to {told['firsts'][-1]:.2f} s, the others in {told['others']:.3f} s (median)"
    )
    for _ in range(repetitions):
        numbers = batch_against_renders(program, folder, jobs, cores)
        print(f"{jobs} jobs on {cores} cores: " + ", ".join(f"{name} {number:.3f}" for name, number in numbers.items()))


if __name__ == "__main__":
    main()
