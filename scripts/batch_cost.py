#!/usr/bin/env python3
"""Measures what a batch costs beside its renders: 200 jobs of 64 x 64 pixels and 4 passes, one by one and as a batch; and what 50
frames load that share a mesh of 1,002,528 triangles.

usage: batch_cost.py PROGRAM [FOLDER [JOBS [REPETITIONS]]]
"""

import json
import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
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


def as_batch(program, folder, jobs, cores):
    out = folder / "batch"
    subprocess.run(["rm", "-rf", out], check=True)
    seeds = ",".join(map(str, range(jobs)))
    command = [program, "batch", SCENE, f"--set=size={SIZE}", f"--set=photons={PHOTONS}", f"--set=seed={seeds}", f"--passes={PASSES}"]
    seconds, _ = seconds_of([*command, f"--jobs={cores}", "--threads=1", "-o", out])
    status = subprocess.run([program, "batch", "status", out, "--json"], check=True, capture_output=True, text=True)
    rows = [json.loads(line) for line in status.stdout.splitlines()]
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
    """How many processes render the frames, and what each of them loads."""
    folder = folder / "frames"
    folder.mkdir(exist_ok=True)
    subprocess.run([program, "surface", folder / "large.obj", "--cells", str(CELLS)], check=True, stderr=subprocess.DEVNULL)
    for frame in range(FRAMES):
        (folder / f"frame_{frame:02}.toml").write_text(FRAME.format(z=1.5 + 0.01 * frame))
    out = folder / "out"
    subprocess.run(["rm", "-rf", out], check=True)
    seconds, _ = seconds_of([program, "batch", folder / "frame_*.toml", "--passes=1", f"--jobs={cores}", "--threads=1", "-o", out])
    status = subprocess.run([program, "batch", "status", out, "--json"], check=True, capture_output=True, text=True)
    attempts = [json.loads(line)["attempts"][0] for line in status.stdout.splitlines()]
    loads = {}
    for attempt in attempts:
        loads.setdefault(attempt["process"], []).append(attempt["load_seconds"])
    firsts = sorted(max(loads_of_one) for loads_of_one in loads.values())
    others = sorted(load for loads_of_one in loads.values() for load in sorted(loads_of_one)[:-1])
    print(
        f"{FRAMES} frames that share {2 * CELLS * CELLS} triangles: {seconds:.1f} s in {len(loads)} processes; the first frame of each loads in "
        f"{firsts[0]:.2f} to {firsts[-1]:.2f} s, the others in {statistics.median(others):.3f} s (median)"
    )


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = Path(sys.argv[1]).resolve()
    folder = Path(sys.argv[2] if len(sys.argv) > 2 else "out/batch_cost").resolve()
    jobs = int(sys.argv[3]) if len(sys.argv) > 3 else 200
    repetitions = int(sys.argv[4]) if len(sys.argv) > 4 else 3
    folder.mkdir(parents=True, exist_ok=True)
    cores = len(os.sched_getaffinity(0))
    ready, bare = start_up(program, folder)
    print(f"start-up: process {1e3 * statistics.median(bare):.1f} ms, with its scene ready {1e3 * statistics.median(ready):.1f} ms (medians)")
    frames(program, folder, cores)
    for _ in range(repetitions):
        marks = [processor_seconds()]
        told, whole = one_by_one(program, folder, jobs)
        marks.append(processor_seconds())
        batch, in_batch, loading = as_batch(program, folder, jobs, cores)
        marks.append(processor_seconds())
        alone, together = marks[1] - marks[0], marks[2] - marks[1]
        ideal = sum(whole) / cores
        print(
            f"{jobs} jobs on {cores} cores: one by one {sum(whole):.2f} s, of which renders {sum(told):.2f} s; batch {batch:.2f} s, "
            f"in which renders took {in_batch:.2f} s, loading {loading:.2f} s; "
            f"batch / (processes one by one / cores) = {batch / ideal:.3f}, batch / (renders in the batch / cores) = {batch * cores / in_batch:.3f}; "
            f"processor seconds {alone:.2f} one by one, {together:.2f} as a batch: {together / alone:.3f}"
        )


if __name__ == "__main__":
    main()
