"""A Slurm cluster of one node on loopback, for tests: munged, slurmctld and slurmd of Debian's packages, started by root and
without systemd, all of whose files lie in one folder."""

import os
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

PROGRAMS = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel"]
PACKAGES = ["slurmctld", "slurmd", "slurm-client", "munge"]
START_SECONDS = 30

CONF = """\
ClusterName=caustica
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort={ctld_port}
SlurmdPort={slurmd_port}
AuthType=auth/munge
CredType=cred/munge
# A job that was requeued waits until credentials of its first start have expired.
AuthInfo=socket={folder}/munge.socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=1
ReturnToService=2
JobRequeue=1
KillWait=15
MinJobAge=3600
SlurmdTimeout=20
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=render Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def missing():
    """The programs that are not there."""
    return [name for name in PROGRAMS if not shutil.which(name)]


def install():
    """Gets the packages, as root."""
    if missing():
        environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        command = ["apt-get", "install", "-y", "--no-install-recommends", *PACKAGES]
        subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL)


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Node:
    """A running cluster; leaving the `with` ends it."""

    def __init__(self, folder, cpus):
        self.folder = Path(folder)
        self.cpus = cpus
        self.host = socket.gethostname().split(".")[0]
        self.daemons = {}
        # Clients find the cluster by this alone.
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf")}

    def __enter__(self):
        for name in ["state", "spool"]:
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        conf = CONF.format(
            host=self.host, folder=self.folder, cpus=self.cpus, ctld_port=free_port(), slurmd_port=free_port()
        )
        (self.folder / "slurm.conf").write_text(conf)
        (self.folder / "munge.key").write_bytes(os.urandom(1024))
        (self.folder / "munge.key").chmod(0o400)
        try:
            self.start_munge()
            self.start("slurmctld", "-D", "-i")
            self.start("slurmd", "-D")
            self.wait_until_idle()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for name in ["slurmd", "slurmctld", "munged"]:
            self.stop(name)

    def start_munge(self):
        files = {"key-file": "munge.key", "socket": "munge.socket", "pid-file": "munge.pid", "log-file": "munge.log", "seed-file": "munge.seed"}
        options = [f"--{option}={self.folder / file}" for option, file in files.items()]
        self.start("munged", "--foreground", "--force", *options)
        self.wait(lambda: (self.folder / "munge.socket").exists(), "munged makes no socket")

    def start(self, name, *arguments):
        output = open(self.folder / f"{name}.out", "ab")
        self.daemons[name] = subprocess.Popen(
            [name, *arguments], env=self.environment, stdout=output, stderr=output, start_new_session=True
        )

    def stop(self, name, by=signal.SIGTERM):
        daemon = self.daemons.pop(name, None)
        if daemon is None:
            return
        daemon.send_signal(by)
        try:
            daemon.wait(20)
        except subprocess.TimeoutExpired:
            daemon.kill()
            daemon.wait()

    def wait(self, is_so, otherwise, seconds=START_SECONDS):
        deadline = time.monotonic() + seconds
        while not is_so():
            if time.monotonic() > deadline:
                raise RuntimeError(f"{otherwise} within {seconds} s\n{self.logs()}")
            time.sleep(0.1)

    def wait_until_idle(self):
        def idle():
            state = self.run("sinfo", "-h", "-o", "%T", check=False)
            return state.strip() in ("idle", "mixed", "allocated")

        self.wait(idle, "the node does not come up")

    def run(self, *command, check=True):
        """What a client prints."""
        done = subprocess.run(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if check and done.returncode:
            raise RuntimeError(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout}\n{self.logs()}")
        return done.stdout

    def begin(self, *command):
        """The process of a client that nobody waits for; what it says is lost."""
        return subprocess.Popen(command, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def logs(self):
        names = ["slurmctld.log", "slurmd.log", "munged.out"]
        texts = [(self.folder / name) for name in names if (self.folder / name).exists()]
        return "\n".join(f"--- {path.name}\n{path.read_text(errors='replace')[-6000:]}" for path in texts)
