# SPDX-License-Identifier: BSD-3-Clause
"""A private Slurm: munged, slurmctld and two slurmd on this machine, in the folder and on the ports
of the test. The system's configuration is neither read nor changed."""

import ctypes
import os
import pwd
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo")
# Seconds that daemons may take to start or to end.
PATIENCE = 60

CONFIGURATION = """
ClusterName=culm
SlurmctldHost=localhost
SlurmctldPort={controller_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=1,bf_interval=1
ReturnToService=2
NodeName=n1 NodeHostname=localhost Port={first_port} CPUs=4 RealMemory=1000
NodeName=n2 NodeHostname=localhost Port={second_port} CPUs=4 RealMemory=1000
PartitionName=test Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


class Unavailable(Exception):
    """The reason why Slurm cannot be started here."""


def path_with_daemons() -> str:
    """PATH with the folders of the daemons, which only root has in its PATH."""
    return os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def end_with_parent():
    """Makes a daemon end with the test, even if the test is killed (prctl PR_SET_PDEATHSIG)."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)


def free_ports(count: int) -> list[int]:
    """Ports on which no process listens."""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for one in sockets:
            one.bind(("", 0))
        return [one.getsockname()[1] for one in sockets]
    finally:
        for one in sockets:
            one.close()


class PrivateSlurm:
    """Starts the daemons; stop() ends every one of them. Commands: run("squeue", ...)."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.daemons: list[tuple[str, subprocess.Popen]] = []
        # Both nodes are this machine, so shared memory between "two nodes" must not be tried.
        self.environment = os.environ | {
            "PATH": path_with_daemons(), "SLURM_CONF": str(folder / "slurm.conf"),
            "OMPI_MCA_btl": "self,tcp"}
        for name in ("SLURM_JOB_ID", "SLURM_JOBID", "PBS_JOBID"):
            self.environment.pop(name, None)

    def start(self):
        missing = [name for name in PROGRAMS if not shutil.which(name, path=path_with_daemons())]
        if missing:
            raise Unavailable(f"not installed: {', '.join(missing)} "
                              "(Debian: munge slurmctld slurmd slurm-client)")
        try:
            self.start_munge()
            self.write_configuration()
            self.start_daemon("slurmctld", "-D")
            for node in ("n1", "n2"):
                (self.folder / node).mkdir()
                self.start_daemon("slurmd", "-D", "-N", node)
            self.wait_for(self.nodes_are_idle, "the nodes are not idle")
        except Unavailable as error:
            raise Unavailable(f"{error}\n{self.last_words()}") from error

    def start_munge(self):
        place = self.folder / "munge"
        place.mkdir(mode=0o700)
        key = place / "key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        self.start_daemon("munged", "--foreground", "--force", f"--key-file={key}",
                          f"--socket={place}/socket", f"--pid-file={place}/pid",
                          f"--log-file={place}/log", f"--seed-file={place}/seed")
        self.wait_for((place / "socket").exists, "munged has no socket")

    def write_configuration(self):
        (self.folder / "state").mkdir()
        ports = free_ports(3)
        text = CONFIGURATION.format(folder=self.folder, user=pwd.getpwuid(os.getuid()).pw_name,
                                    controller_port=ports[0], first_port=ports[1],
                                    second_port=ports[2])
        (self.folder / "slurm.conf").write_text(text, encoding="utf-8")
        (self.folder / "cgroup.conf").write_text("CgroupAutomount=no\nConstrainCores=no\n",
                                                 encoding="utf-8")

    def start_daemon(self, *command):
        name = "-".join([command[0], *command[3:4]] if command[0] == "slurmd" else command[:1])
        log = open(self.folder / f"{name}.out", "w", encoding="utf-8")
        with log:
            process = subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL,
                                       stdout=log, stderr=log, cwd=self.folder,
                                       preexec_fn=end_with_parent)
        self.daemons.append((name, process))

    def wait_for(self, condition, complaint: str):
        deadline = time.monotonic() + PATIENCE
        while not condition():
            ended = [name for name, process in self.daemons if process.poll() is not None]
            if ended:
                raise Unavailable(f"{', '.join(ended)} ended at once")
            if time.monotonic() > deadline:
                raise Unavailable(f"{complaint} after {PATIENCE} s")
            time.sleep(0.2)

    def nodes_are_idle(self) -> bool:
        answer = self.run("sinfo", "--noheader", "-N", "-o", "%T")
        return answer.returncode == 0 and answer.stdout.split() == ["idle", "idle"]

    def run(self, *command, **options) -> subprocess.CompletedProcess:
        return subprocess.run(command, env=self.environment, text=True, capture_output=True,
                              timeout=PATIENCE, check=False, **options)

    def last_words(self) -> str:
        """The last lines of the logs, for the report of a failure."""
        logs = [*self.folder.glob("*.out"), *self.folder.glob("*.log"),
                *self.folder.glob("munge/log")]
        return "\n".join(f"{log.name}: " + "\n  ".join(
            log.read_text(encoding="utf-8", errors="replace").splitlines()[-5:]) for log in logs)

    def stop(self):
        """Cancels every job, so that none of their processes remains, then ends the daemons."""
        if any(name == "slurmctld" and process.poll() is None for name, process in self.daemons):
            try:
                self.run("scancel", "--user", pwd.getpwuid(os.getuid()).pw_name)
                deadline = time.monotonic() + PATIENCE / 2
                while self.run("squeue", "--noheader").stdout and time.monotonic() < deadline:
                    time.sleep(0.2)
            except subprocess.TimeoutExpired:
                pass
        for _, process in reversed(self.daemons):
            if process.poll() is None:
                process.terminate()
        for _, process in reversed(self.daemons):
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
