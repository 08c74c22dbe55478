"""What every trial of a fault uses: the programs, a cloud, and the bytes that an undisturbed run of it writes."""

import dataclasses
import json
import pathlib
import random
import subprocess
import time

from curvd_process import Curvd

# A run that takes long enough to be hit in each phase, and short enough to be repeated hundreds of times.
_OPTIONS = ["--estimator=uniform", "--triangles=200", "--k=40"]
_RUN_SECONDS = 120


@dataclasses.dataclass
class Run:
    """What became of one `curv estimate`."""

    exit_code: int
    seconds: float
    message: str
    output: pathlib.Path

    def bytes(self):
        return self.output.read_bytes() if self.output.exists() else b""


class Site:
    """Directories, programs and the cloud. `points`: its size."""

    def __init__(self, programs, scratch, points, seed):
        self.curvd_binary = str(programs / "curvd")
        self.curv_binary = str(programs / "curv")
        self.scratch = scratch
        self.random = random.Random(seed)
        self.points = points
        self.cloud = scratch / "cloud.ply"
        self._runs = 0
        subprocess.run(
            [self.curv_binary, "generate", "torus", f"--points={points}", "-o", str(self.cloud)],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        with self.server() as server:
            run = self.estimate(server.address, "--summary=json")
            assert run.exit_code == 0, run.message
            self.expected = run.bytes()
            self.seconds = run.seconds  # of an undisturbed run
            self.phases = {name: s for name, s in json.loads(run.message)["seconds"].items() if name != "total"}

    def server(self, *flags, **options):
        return Curvd(self.curvd_binary, *flags, **options)

    def cloud_of(self, points):
        """Another cloud, of the same surface and `points` points."""
        cloud = self.scratch / f"cloud-{points}.ply"
        if not cloud.exists():
            command = [self.curv_binary, "generate", "torus", f"--points={points}", "-o", str(cloud)]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return cloud

    def start_estimate(self, servers, *flags, output=None, cloud=None, **options):
        """Starts `curv estimate` of the cloud, or of another; finish() waits for it."""
        self._runs += 1
        flags = flags if cloud else (*_OPTIONS, *flags)
        output = output or self.scratch / f"result-{self._runs}.ply"
        process = subprocess.Popen(
            [self.curv_binary, "estimate", str(cloud or self.cloud), "-o", str(output), f"--server={servers}", *flags],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            **options,
        )
        process.began = time.monotonic()
        process.result = output
        return process

    def finish(self, process):
        message, _ = process.communicate(timeout=_RUN_SECONDS)
        return Run(process.returncode, time.monotonic() - process.began, message, process.result)

    def estimate(self, servers, *flags, **options):
        return self.finish(self.start_estimate(servers, *flags, **options))

    def check(self, run):
        """AssertionError unless the run wrote what an undisturbed one writes; then removes the result."""
        assert run.exit_code == 0, f"curv ended with {run.exit_code}: {run.message}"
        assert run.bytes() == self.expected, "curv wrote other bytes than an undisturbed run"
        run.output.unlink()

    def random_moment(self):
        """Seconds after the start of a run, in a phase that is drawn first: short phases are hit as often as long ones."""
        order = ("read", "receive", "queue", "index", "estimate", "send", "write")
        phase = self.random.choice(["receive", "index", "estimate", "send"])
        start_up = max(0.0, self.seconds - sum(self.phases.values()))
        before = start_up + sum(self.phases[name] for name in order[: order.index(phase)])
        return before + self.random.random() * self.phases[phase]
