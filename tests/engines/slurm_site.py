"""A Slurm of one machine, in a folder of its own: munged, slurmctld and slurmd. Needs root and Debian's slurm-wlm."""

import contextlib
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time
from random import randrange

START_SECONDS = 60
# slurmctld waits as long until it lets a job that was requeued start again; the default is 120.
CREDENTIAL_SECONDS = 5

_CONFIGURATION = """\
ClusterName=curv
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire={credential}
CryptoType=crypto/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmdParameters=config_overrides
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
SlurmctldTimeout=10
SlurmdTimeout=30
InactiveLimit=0
KillWait=2
MinJobAge=300
SchedulerParameters=sched_interval=1,batch_sched_delay=0,sched_min_interval=10000
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE OverSubscribe=NO State=UP
"""


def missing():
    """What is missing to start one, or ""."""
    for program in ("munged", "slurmctld", "slurmd", "sbatch", "scontrol"):
        if not shutil.which(program, path=os.environ["PATH"] + ":/usr/sbin"):
            return f"{program} (Debian's slurm-wlm)"
    return "" if os.getuid() == 0 else "root"


def _free_port():
    """A port that nobody has, below those that the system gives to connections: one of these could take it meanwhile."""
    first_given = int(pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range").read_text(encoding="ascii").split()[0])
    while True:
        port = randrange(first_given // 2, first_given)
        with socket.socket() as free, contextlib.suppress(OSError):
            free.bind(("", port))
            return port


class SlurmSite:
    """Usable with `with`. `environment` is what sbatch and its friends need to find it."""

    def __init__(self, folder, cpus=4):
        self.folder = pathlib.Path(folder)
        self.environment = {"SLURM_CONF": str(self.folder / "slurm.conf")}
        for name in ("state", "spool", "munge"):
            (self.folder / name).mkdir(mode=0o700)
        self.folder.chmod(0o755)
        key = self.folder / "munge" / "key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        host = socket.gethostname().split(".")[0]
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") >> 20
        (self.folder / "slurm.conf").write_text(_CONFIGURATION.format(
            host=host, controller=_free_port(), daemon=_free_port(), folder=self.folder, cpus=cpus, memory=memory // 2,
            credential=CREDENTIAL_SECONDS), encoding="ascii")
        self._processes = {}
        self._key = key

    def __enter__(self):
        try:
            self._start_all()
        except BaseException:
            self.__exit__()
            raise
        return self

    def _start_all(self):
        self._start("munged", "--foreground", f"--socket={self.folder}/munge.socket", f"--key-file={self._key}",
                    f"--log-file={self.folder}/munge.log", f"--pid-file={self.folder}/munge.pid",
                    f"--seed-file={self.folder}/munge.seed", "--force")
        self._wait(lambda: (self.folder / "munge.socket").exists(), "munged made no socket")
        self.start_controller("-c")
        self.start_daemon()
        self._wait(lambda: "idle" in self.tell("sinfo", "-h", "-o", "%t"), "no node is idle")

    def __exit__(self, *_):
        for name in ("slurmd", "slurmctld", "munged"):
            self.kill(name)

    def start_controller(self, *flags):
        self._start("slurmctld", "-D", *flags)

    def start_daemon(self):
        self._start("slurmd", "-D")

    def process(self, name):
        return self._processes[name]

    def kill(self, name):
        process = self._processes.pop(name, None)
        if process:
            process.send_signal(signal.SIGKILL)
            process.wait()

    def kill_step(self, random):
        """Kills a process that watches over a task; whether there was one."""
        steps = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                words = pathlib.Path("/proc", pid, "cmdline").read_bytes()
                environment = pathlib.Path("/proc", pid, "environ").read_bytes()
            except OSError:
                continue
            if words.startswith(b"slurmstepd:") and str(self.folder).encode() in environment:
                steps.append(int(pid))
        if not steps:
            return False
        with contextlib.suppress(ProcessLookupError):
            os.kill(random.choice(steps), signal.SIGKILL)
        return True

    def tell(self, *command):
        """What a program of Slurm's says; "" where it fails, as while nobody answers."""
        done = subprocess.run(command, env={**os.environ, **self.environment}, capture_output=True, text=True, check=False,
                              timeout=60)
        return done.stdout if done.returncode == 0 else ""

    def wake_node(self):
        """Lets a node that was drained, or is down, take jobs again, as an administrator would."""
        state = self.tell("sinfo", "-h", "-o", "%t").strip()
        if state.startswith(("drain", "drng", "down")):
            self.tell("scontrol", "update", f"NodeName={socket.gethostname().split('.')[0]}", "State=RESUME")

    def saved_at(self):
        """When the controller has saved its jobs; 0: not yet."""
        try:
            return (self.folder / "state" / "job_state").stat().st_mtime
        except FileNotFoundError:
            return 0.0

    def release_held(self):
        """Lets tasks run again that Slurm holds since it could not start them, as an administrator would."""
        for line in self.tell("squeue", "-h", "--states=pending", "-o", "%i %r").splitlines():
            task, _, reason = line.partition(" ")
            if "held" in reason.lower():
                self.tell("scontrol", "release", task)

    def _start(self, program, *arguments):
        path = shutil.which(program, path=os.environ["PATH"] + ":/usr/sbin")
        log = open(self.folder / f"{program}.out", "ab")
        self._processes[program] = subprocess.Popen([path, *arguments], env={**os.environ, **self.environment},
                                                    stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        log.close()

    def _wait(self, condition, complaint):
        give_up = time.monotonic() + START_SECONDS
        while not condition():
            for name, process in self._processes.items():
                if process.poll() is not None:
                    raise AssertionError(f"{name} ended: {(self.folder / (name + '.out')).read_text()[-2000:]}")
            if time.monotonic() > give_up:
                raise AssertionError(f"{complaint} after {START_SECONDS} s")
            time.sleep(0.1)
