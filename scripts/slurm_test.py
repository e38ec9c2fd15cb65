#!/usr/bin/env python3
"""Renders a picture by a Slurm cluster of one node, and breaks what can break on the way:

    make slurm-test

usage: slurm_test.py PROGRAM

A task is killed in the middle, another one is told to leave its node, the daemon of the node is killed and started again.
What is missing afterwards is submitted again, and the picture must have the bytes of one that was rendered in one piece
without Slurm. Needs root, and installs Debian's packages of Slurm where they are missing.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from slurm_node import PACKAGES, Node, install, missing

ROOT = Path(__file__).resolve().parent.parent
PASSES, SHARD_PASSES = 60, 10
FLAGS = ["--size", "96x96", "--photons", "2000000", "--seed", "3", "--checkpoint-every", "0.5"]
SECONDS = 240


def say(text):
    print(f"{time.monotonic() - START:6.1f} s  {text}", flush=True)


def in_one_piece(program, scene, folder):
    shard, picture = folder / "whole.shard", folder / "whole.exr"
    render = [program, "render", scene, *FLAGS, "--passes", f"0..{PASSES}", "--partial", "-o", shard]
    subprocess.run(render, check=True, stderr=subprocess.DEVNULL)
    subprocess.run([program, "merge", shard, "-o", picture], check=True, stderr=subprocess.DEVNULL)
    return picture


class Farm:
    """What `caustica submit` and `caustica status` do on the node."""

    def __init__(self, node, program, scene, folder):
        self.node, self.program, self.scene = node, program, scene
        self.picture, self.folder = folder / "farm.exr", folder / "farm.farm"

    def submit(self):
        split = ["--passes", str(PASSES), "--shard-passes", str(SHARD_PASSES)]
        command = [self.program, "submit", "--slurm", self.scene, *split, "-o", self.picture, "--", *FLAGS]
        return self.node.run(*command).strip()

    def status(self):
        text = subprocess.run(
            [self.program, "status", self.folder, "--json"], env=self.node.environment, stdout=subprocess.PIPE
        ).stdout
        return json.loads(text)

    def running(self):
        """Numbers of tasks and jobs that Slurm runs."""
        lines = self.node.run("squeue", "--noheader", "--array", "--states=R", "--format", "%K %A").split("\n")
        pairs = [line.split() for line in lines if line.strip()]
        return {int(task): job for task, job in pairs if task.isdigit()}

    def log(self, task):
        path = self.folder / "logs" / f"task-{task}.log"
        return path.read_text() if path.exists() else ""

    def render_of(self, task):
        """The process that renders a task."""
        shard = f"{task:06}.shard".encode()
        for path in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = path.read_bytes().split(b"\0")
            except OSError:
                continue
            if words[0].endswith(b"caustica") and any(word.endswith(shard) for word in words):
                return int(path.parent.name)
        return None

    def wait_for_begun(self, barred):
        """A running task, not `barred`, that has kept some of its passes already, and its job."""
        found = []

        def begun():
            states = self.status()["progress"]["tasks"]
            found[:] = [(t, j) for t, j in self.running().items() if t not in barred and states[t] == "begun"]
            return bool(found)

        self.node.wait(begun, "no task begins", SECONDS)
        return found[0]

    def wait_until_over(self):
        def over():
            return not self.node.run("squeue", "--noheader", "--states=PD,R,CG", "--format", "%T").strip()

        self.node.wait(over, "the queue does not empty", SECONDS)


def disturb(farm, node):
    """Kills a task, asks another to leave, kills the daemon; the number of the one that was killed."""
    killed, _ = farm.wait_for_begun(barred=[])
    os.kill(farm.render_of(killed), signal.SIGKILL)
    say(f"killed the render of task {killed}")
    asked, job = farm.wait_for_begun(barred=[killed])
    # Slurm refuses to signal a job that it is still starting.
    time.sleep(2)
    # It may also deliver the signal and yet call the job busy: then scancel goes on asking until all tasks are over.
    with node.begin("scancel", "--signal=USR1", "--batch", job) as scancel:
        node.wait(lambda: "back into the queue" in farm.log(asked), f"task {asked} does not go back into the queue")
        scancel.kill()
    say(f"task {asked} kept its passes and went back into the queue")
    farm.wait_for_begun(barred=[killed])
    node.stop("slurmd", by=signal.SIGKILL)
    node.start("slurmd", "-D")
    node.wait_until_idle()
    say("killed slurmd and started it again")
    return killed, asked


def check(condition, text):
    if not condition:
        sys.exit(f"slurm_test.py: {text}")
    say(text)


def check_jobs(node, program, scene, folder):
    """Jobs of a batch as tasks of an array, against the same batch without Slurm."""
    sweep = ["--set", "seed=1,2,3", "--set", "size=32x32", "--passes", "4"]
    node.run(program, "submit", "--slurm", "--each", scene, "-o", folder / "night", "--", *sweep)
    farm = Farm(node, program, scene, folder)
    farm.wait_until_over()
    subprocess.run([program, "batch", scene, "-o", folder / "local", *sweep], check=True, stderr=subprocess.DEVNULL)
    local = sorted((folder / "local").glob("*.exr"))
    ours = [folder / "night/jobs" / picture.stem / picture.name for picture in local]
    same = all(a.exists() and a.read_bytes() == b.read_bytes() for a, b in zip(ours, local))
    check(len(local) == 3 and same, "jobs of a batch, too, have the bytes that they have without Slurm")


def main(program):
    program = str(Path(program).resolve())
    with tempfile.TemporaryDirectory(prefix="caustica-slurm-") as name:
        folder = Path(name)
        scene = folder / "scene.toml"
        scene.write_bytes((ROOT / "data/cornell_b.toml").read_bytes())
        whole = in_one_piece(program, scene, folder)
        say("rendered in one piece, without Slurm")
        with Node(folder / "slurm", cpus=2) as node:
            say("a cluster of one node is up")
            farm = Farm(node, program, scene, folder)
            farm.submit()
            killed, asked = disturb(farm, node)
            farm.wait_until_over()
            states = farm.status()["progress"]["tasks"]
            check([t for t, s in enumerate(states) if s != "whole"] == [killed], f"task {killed} alone is not whole")
            log = (farm.folder / "logs/merge.log").read_text()
            check(not farm.picture.exists() and f"--array={killed}" in log, "the merge named what is missing")
            check("going on" in farm.log(asked), f"task {asked} went on from what it had kept")
            farm.submit()
            farm.wait_until_over()
            check(farm.log(killed).count("going on") == 1, f"task {killed} was submitted again, and went on, too")
            check(farm.picture.read_bytes() == whole.read_bytes(), "the picture has the bytes of the one in one piece")
            status = farm.status()["progress"]
            check(status["is_complete"] and status["passes"] == [PASSES, PASSES], "the status says so")
            check_jobs(node, program, scene, folder)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    if os.geteuid() != 0:
        sys.exit("slurm_test.py: Slurm's daemons are started by root; run it as root")
    install()
    if missing():
        sys.exit(f"slurm_test.py: there is no {', '.join(missing())}; install {' '.join(PACKAGES)}")
    START = time.monotonic()
    main(sys.argv[1])
