"""A Slurm of one node on the loopback, in a folder of its own: controller, node and authentication, nothing of the system's touched."""

from __future__ import annotations

import os
import platform
import shutil
import socket
import subprocess
import time
from contextlib import suppress
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "srun", "squeue", "scancel", "scontrol")
PATIENCE = 60.0
"""How long a daemon may take to answer, s."""


class CannotStart(Exception):
    """Slurm cannot run here; the text says why."""


class LocalSlurm:
    """A node with more cores than the machine has, so that jobs overlap, and a card that is one by name; used as a context."""

    def __init__(self, folder: Path, cores: int = 4, memory: int = 16_000) -> None:
        self.folder, self.cores, self.memory = folder, cores, memory
        path = f"{folder / 'bin'}:{os.environ['PATH']}:/usr/sbin"
        self.environment = os.environ | {"SLURM_CONF": str(folder / "slurm.conf"), "PATH": path}
        self._daemons: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> LocalSlurm:
        missing = [name for name in PROGRAMS if shutil.which(name, path=self.environment["PATH"]) is None]
        if missing:
            raise CannotStart(f"not installed: {', '.join(missing)} (apt-get install slurmctld slurmd slurm-client munge)")
        if os.geteuid() != 0:
            raise CannotStart("slurmd needs to be root")
        try:
            self._start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _start(self) -> None:
        for name in ("state", "spool", "munge", "bin"):
            (self.folder / name).mkdir(parents=True)
        # Snakemake's plugin takes all variables of Slurm's from its steps, the place of the configuration among them.
        srun = self.folder / "bin" / "srun"
        srun.write_text(f'#!/bin/sh\nSLURM_CONF={self.folder}/slurm.conf exec {shutil.which("srun", path=self.environment["PATH"])} "$@"\n')
        srun.chmod(0o755)
        self.folder.chmod(0o755)
        key, socket_path = self.folder / "munge" / "key", self.folder / "munge" / "socket"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        host, ports = platform.node().partition(".")[0], [_free_port() for _ in range(2)]
        (self.folder / "slurm.conf").write_text(
            "\n".join(
                [
                    "ClusterName=loopback",
                    f"SlurmctldHost={host}(127.0.0.1)",
                    f"SlurmctldPort={ports[0]}",
                    f"SlurmdPort={ports[1]}",
                    "SlurmUser=root",
                    "SlurmdUser=root",
                    "AuthType=auth/munge",
                    "CredType=cred/munge",
                    f"AuthInfo=socket={socket_path}",
                    f"StateSaveLocation={self.folder}/state",
                    f"SlurmdSpoolDir={self.folder}/spool",
                    f"SlurmctldPidFile={self.folder}/slurmctld.pid",
                    f"SlurmdPidFile={self.folder}/slurmd.pid",
                    "ProctrackType=proctrack/linuxproc",
                    "TaskPlugin=task/none",
                    "SwitchType=switch/none",
                    "MpiDefault=none",
                    "SelectType=select/cons_tres",
                    "SelectTypeParameters=CR_CPU",
                    "JobAcctGatherType=jobacct_gather/none",
                    "ReturnToService=2",
                    "SlurmdParameters=config_overrides",
                    "MinJobAge=86400",
                    "KillWait=5",
                    "GresTypes=gpu",
                    f"NodeName={host} NodeAddr=127.0.0.1 CPUs={self.cores} RealMemory={self.memory} Gres=gpu:1 State=UNKNOWN",
                    f"PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP",
                    f"PartitionName=gpu Nodes={host} MaxTime=INFINITE State=UP",
                    "",
                ]
            )
        )
        (self.folder / "gres.conf").write_text(f"NodeName={host} Name=gpu File=/dev/null\n")
        logs = self.folder
        self._daemon("munged", "--foreground", "--force", "--key-file", key, "--socket", socket_path, "--pid-file", logs / "munged.pid",
                     "--seed-file", logs / "munge" / "seed", "--log-file", logs / "munged.log")  # fmt: skip
        self._until("munged", socket_path.exists)
        self._daemon("slurmctld", "-D", "-L", logs / "slurmctld.log")
        self._daemon("slurmd", "-D", "-N", host, "-L", logs / "slurmd.log")
        self._until("the node", lambda: self.ask("sinfo", "--noheader", "--format=%T").strip() == "idle")

    def _daemon(self, *command: object) -> None:
        arguments = [str(word) for word in command]
        self._daemons.append(subprocess.Popen(arguments, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))

    def _until(self, what: str, ready: object) -> None:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with suppress(subprocess.CalledProcessError):
                if ready():  # type: ignore[operator]
                    return
            if any(daemon.poll() is not None for daemon in self._daemons):
                break
            time.sleep(0.2)
        told = {path.name: path.read_text(errors="replace")[-500:] for path in sorted(self.folder.glob("*.log"))}
        raise CannotStart(f"{what} does not answer: {told}")

    def ask(self, *command: str) -> str:
        """Output of a command of Slurm's; CalledProcessError if it fails."""
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, check=True).stdout

    def jobs(self, *states: str) -> list[tuple[str, str]]:
        """Number and state of every job submitted so far, or of those in some states."""
        told = self.ask("squeue", "--noheader", "--states=all", "--format=%i %T")
        found = [tuple(line.split()) for line in told.splitlines()]
        return [(number, state) for number, state in found if not states or state in states]

    def stop(self) -> None:
        """End all jobs and the daemons that were started, last first."""
        with suppress(subprocess.CalledProcessError, OSError):
            self.ask("scancel", "--user=root")
            self._wait_for_jobs()
        for daemon in reversed(self._daemons):
            daemon.terminate()
        for daemon in self._daemons:
            with suppress(subprocess.TimeoutExpired):
                daemon.wait(10.0)
                continue
            daemon.kill()

    def _wait_for_jobs(self) -> None:
        end = time.monotonic() + 10.0
        while self.jobs("RUNNING", "COMPLETING", "PENDING") and time.monotonic() < end:
            time.sleep(0.2)


def _free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])
