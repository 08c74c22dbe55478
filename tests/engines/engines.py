"""The engines, as a trial starts them, and what of each can be killed.

An engine has name, missing() ("" where it can be tried), and, usable with `with`: start() begins the tiles that are left;
running() tells whether they are still at hand; kill_worker(random) kills what does a tile, kill_driver(random) what hands
tiles out, and start again what somebody would; they return whether there was anything; revive() puts right what a person or a supervisor would.
"""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import slurm_site
from tile_site import wait_for

_ENGINES = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "engines"


def _kill(process):
    process.send_signal(signal.SIGKILL)
    process.wait()


class _ProcessEngine:
    """One whose driver is a process that ends when all is done."""

    def __init__(self, site, scratch):
        self.site = site
        self.scratch = scratch
        self.driver = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.driver and self.driver.poll() is None:
            _kill(self.driver)
        wait_for(lambda: not self.site.at_work(), 120, "curv works on")

    def popen(self, *command):
        log = open(self.scratch / f"{self.name}.log", "ab")
        with log:
            return subprocess.Popen([*map(str, command)], env={**os.environ, **self.site.environment}, stdin=subprocess.DEVNULL,
                                    stdout=log, stderr=log)

    def running(self):
        return self.driver is not None and self.driver.poll() is None

    def kill_driver(self, random):
        if not self.running():
            return False
        _kill(self.driver)
        self.start()
        return True

    def kill_worker(self, random):
        """Kills a process that estimates a tile."""
        pids = list(self.site.at_work())
        if not pids:
            return False
        try:
            os.kill(random.choice(pids), signal.SIGKILL)
        except ProcessLookupError:
            return False
        return True

    def revive(self):
        if not self.running():
            self.start()


class Parallel(_ProcessEngine):
    name = "GNU parallel"

    @staticmethod
    def missing():
        return "" if shutil.which("parallel") else "parallel"

    def start(self):
        self.driver = self.popen(_ENGINES / "parallel" / "run.sh", self.site.work, self.site.addresses)


class Dask(_ProcessEngine):
    name = "Dask"
    _CALL = """\
import sys
import time
from curvd_client.dask import run_tiles
print(run_tiles(sys.argv[1], cluster=sys.argv[2], server=sys.argv[3]))
"""

    @staticmethod
    def missing():
        found = subprocess.run(["/usr/bin/python3", "-c", "import distributed"], capture_output=True, check=False).returncode == 0
        return "" if found and shutil.which("dask-worker") else "distributed (Debian's python3-distributed)"

    def __enter__(self):
        self._file = self.scratch / "scheduler.json"
        self._start_cluster()
        return self

    def _start_cluster(self):
        self._file.unlink(missing_ok=True)
        self.scheduler = self.popen("dask-scheduler", "--host=127.0.0.1", "--port=0", "--no-dashboard", f"--scheduler-file={self._file}")
        wait_for(self._has_address, 60, "no scheduler")
        self.workers = [self._worker() for _ in range(2)]

    def _worker(self):
        return self.popen("dask-worker", f"--scheduler-file={self._file}", "--no-nanny", "--nthreads=2", "--no-dashboard",
                          f"--local-directory={self.scratch}", "--death-timeout=60")

    def _kill_cluster(self):
        for process in (self.scheduler, *self.workers):
            _kill(process)

    def __exit__(self, *_):
        super().__exit__()
        self._kill_cluster()

    def _has_address(self):
        """The scheduler makes its file, and then writes it: until it is whole there is no address."""
        try:
            return bool(self._address())
        except (FileNotFoundError, json.JSONDecodeError):
            return False

    def _address(self):
        return json.loads(self._file.read_text())["address"]

    def kill_driver(self, random):
        """Kills the caller; or the scheduler with its workers, which the caller must notice."""
        if random.random() < 0.5 or not self.running():
            return super().kill_driver(random)
        self._kill_cluster()
        wait_for(lambda: not self.running(), 60, "run_tiles waits for a scheduler that is gone")
        code = self.driver.returncode
        assert code == 1 or (code == 0 and not self.site.left()), f"run_tiles ended with {code}"
        self._start_cluster()
        self.start()
        return True

    def start(self):
        self.driver = self.popen("/usr/bin/python3", "-c", self._CALL, self.site.work, self._address(), self.site.addresses)

    def kill_worker(self, random):
        """Kills a process that estimates a tile; or a worker of Dask's, and starts another: what it ran goes on, as nobody's."""
        if random.random() < 0.5:
            return super().kill_worker(random)
        number = random.randrange(len(self.workers))
        if not self.site.at_work():
            return False
        _kill(self.workers[number])
        self.workers[number] = self._worker()
        return True


class Slurm(_ProcessEngine):
    name = "Slurm"
    TASKS = 4

    @staticmethod
    def missing():
        return slurm_site.missing()

    def __enter__(self):
        folder = self.scratch / "slurm"
        folder.mkdir()
        self.slurm = slurm_site.SlurmSite(folder, cpus=self.TASKS)
        self.slurm.__enter__()
        self._restarts = 0
        return self

    def __exit__(self, *_):
        self.slurm.tell("scancel", "--user=root")
        super().__exit__()
        self.slurm.__exit__()

    def start(self):
        done = subprocess.run(
            ["sbatch", f"--array=0-{self.TASKS - 1}", f"--output={self.scratch}/curv-tiles-%a.log", str(_ENGINES / "slurm" / "tiles.sbatch"),
             str(self.site.work), f"--server={self.site.addresses}"],
            env={**os.environ, **self.site.environment, **self.slurm.environment}, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"sbatch: {done.stderr}"
        self._started = time.time()

    def running(self):
        # squeue says nothing where nobody answers, too.
        return bool(self.slurm.tell("squeue", "-h", "--states=pending,running,completing,configuring")) or not self.slurm.tell("sinfo", "-h")

    def kill_driver(self, random):
        """A controller that is killed forgets what it took within the last seconds, whose tasks go on, and gives their numbers
        to others: it is killed once it has saved them."""
        wait_for(lambda: self.slurm.saved_at() > self._started, 60, "the controller does not save its state")
        self.slurm.kill("slurmctld")
        self.slurm.start_controller()
        wait_for(lambda: self.slurm.tell("sinfo", "-h"), 60, "no controller")
        return True

    def kill_worker(self, random):
        """Kills a process that estimates a tile, one that watches over a task, or the daemon that starts these."""
        victim = random.choice(("curv", "slurmstepd", "slurmd"))
        if victim == "curv":
            return super().kill_worker(random)
        if victim == "slurmstepd":
            return self.slurm.kill_step(random)
        self.slurm.kill("slurmd")
        self.slurm.start_daemon()
        return True

    def revive(self):
        self.slurm.wake_node()
        self.slurm.release_held()
        if not self.running():
            self.start()


ENGINES = (Parallel, Dask, Slurm)
