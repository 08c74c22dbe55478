"""A container of curvd's image, run with podman, and what can be seen of it from outside."""

import pathlib
import subprocess
import time
import urllib.request

import grpc

IMAGE = "curvd:latest"
START_SECONDS = 60
ADDRESS = "--format={{range .NetworkSettings.Networks}}{{.IPAddress}}{{end}}"
# As Kubernetes, which gives a read-only root no writable /tmp; and with limits that podman may set everywhere: left to
# itself it asks for 2^20 processes and files.
OPTIONS = ["--read-only", "--read-only-tmpfs=false", "--ulimit=nofile=20000:20000", "--ulimit=nproc=4096:4096"]


def podman(*arguments, check=True):
    """What the command printed."""
    done = subprocess.run(["podman", *arguments], capture_output=True, text=True, check=False)
    if check and done.returncode != 0:
        raise AssertionError(f"podman {' '.join(arguments)}: {done.returncode}\n{done.stderr}")
    return done.stdout.strip()


def client(folder, *arguments, entrypoint="curv", options=("--user=0:0",)):
    """A process of the image's that runs on this machine's network and sees `folder` as /work; to be waited for."""
    return subprocess.Popen(
        ["podman", "run", "--rm", "--no-healthcheck", "--network=host", *options, f"--volume={folder}:/work",
         "--workdir=/work", f"--entrypoint={entrypoint}", IMAGE, *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def finish(process):
    """Its exit status and output."""
    output, _ = process.communicate(timeout=300)
    return process.returncode, output


def health(address, service):
    """The status that a probe of Kubernetes gets: grpc.health.v1, in plain text; 1 is SERVING, None no answer."""
    name = service.encode()
    with grpc.insecure_channel(address) as channel:
        check = channel.unary_unary("/grpc.health.v1.Health/Check")
        try:
            answer = check(b"\x0a" + bytes([len(name)]) + name, timeout=5)
        except grpc.RpcError:
            return None
    return answer[1] if answer[:1] == b"\x08" else 0


class Container:
    """A running curvd. `arguments` are those of curvd, `options` those of podman run. Usable with `with`."""

    def __init__(self, options=(), arguments=()):
        self.id = podman("create", *OPTIONS, *options, IMAGE, *arguments)
        self._remove = ["rm", "--force", "--time=0", self.id]
        self._start(["start", self.id], self.id)

    def _start(self, command, owner_of_address):
        try:
            podman(*command)
            self.address = podman("inspect", ADDRESS, owner_of_address)
            self.pid = int(podman("inspect", "--format={{.State.Pid}}", self.id))
            self._memory = self._memory_group()
            self._wait_until_serving()
        except BaseException:
            self.__exit__()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        podman(*self._remove, check=False)

    def _wait_until_serving(self):
        deadline = time.monotonic() + START_SECONDS
        while '"event":"serving"' not in self.log():
            if time.monotonic() > deadline or not self.is_running():
                raise AssertionError(f"curvd does not serve: {self.log()}")
            time.sleep(0.05)

    def is_running(self):
        return podman("inspect", "--format={{.State.Running}}", self.id) == "true"

    def log(self):
        done = subprocess.run(["podman", "logs", self.id], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=True)
        return done.stdout.decode()

    def status(self):
        """/proc/PID/status as a dict."""
        lines = pathlib.Path(f"/proc/{self.pid}/status").read_text(encoding="ascii").splitlines()
        return {name: value.strip() for name, _, value in (line.partition(":") for line in lines)}

    def metric(self, series):
        """The value of `series`, written as in a scrape; 0 if there is none."""
        with urllib.request.urlopen(f"http://{self.address}:9461/metrics", timeout=30) as answer:
            for line in answer.read().decode().splitlines():
                name, _, value = line.rpartition(" ")
                if name == series:
                    return float(value)
        return 0.0

    def stop(self):
        """As `podman stop` does, with time for a drain. Returns curvd's exit status."""
        podman("stop", "--time=40", self.id)
        return int(podman("inspect", "--format={{.State.ExitCode}}", self.id))

    def _memory_group(self):
        root = pathlib.Path("/sys/fs/cgroup")
        for line in pathlib.Path(f"/proc/{self.pid}/cgroup").read_text(encoding="ascii").splitlines():
            _, controllers, path = line.split(":", 2)
            if controllers == "memory":
                return root / "memory" / path[1:]
            if not controllers and not (root / "memory").is_dir():
                return root / path[1:]
        raise AssertionError("the container is in no control group that limits memory")

    def peak_bytes(self):
        """The most memory that the container ever took, or None where the kernel does not tell."""
        for name in ("memory.peak", "memory.max_usage_in_bytes"):
            if (self._memory / name).exists():
                return int((self._memory / name).read_text())
        return None

    def kills(self):
        """Processes that the kernel killed for want of memory."""
        for name in ("memory.events", "memory.oom_control"):
            if (self._memory / name).exists():
                words = (self._memory / name).read_text().split()
                return int(words[words.index("oom_kill") + 1])
        raise AssertionError("the kernel tells of no kills")


class Pod(Container):
    """The first replica of the deployment curvd in `manifest`, a file, as `podman play kube` starts it."""

    def __init__(self, manifest):
        self.id = "curvd-pod-0-curvd"
        self._remove = ["pod", "rm", "--force", "--time=0", "curvd-pod-0"]
        podman("play", "kube", "--start=false", manifest)
        infra = podman("pod", "inspect", "--format={{.InfraContainerID}}", "curvd-pod-0")
        self._start(["pod", "start", "curvd-pod-0"], infra)
