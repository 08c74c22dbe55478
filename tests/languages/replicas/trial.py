#!/usr/bin/python3
"""How calls split over two replicas behind one name, and when a name behind which nobody listens is given up, by client.

  trial.py BIN_DIR PYTHON_DIR CACHE_DIR [--calls N]

BIN_DIR has curvd, curv and replica_calls, PYTHON_DIR the package curvd_client, CACHE_DIR what Go has compiled. Go and Java
are left out, saying so, where Debian's packages for them are not installed. Two real curvds listen on 127.0.0.1 and
127.0.0.2; the name of both stands in a copy of /etc/hosts that only this program and its children see. Prints a table in
Markdown; exits with 1 if a row breaks its bound, and with 77 where namespaces are not allowed.
"""

import argparse
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent))
import foreign_trial  # noqa: E402

NAME = "replicas.test"
SKIPPED = 77
# A client whose connections are kept takes turns: half of the calls each, but for those before the second connection stands.
KEPT_SHARE = 0.4
# Programs of one call each draw lots: fewer than a quarter of 100 come to one of two less than once in a million trials.
DRAWN_SHARE = 0.25
DEAD_SECONDS = 2.0
# Where others keep the machine busy, the second connection may stand late: a client is tried again then.
TRIALS = 3


def in_namespace():
    """Runs this program again where /etc/hosts may be covered."""
    own_user = [] if os.geteuid() == 0 else ["--map-root-user"]
    command = ["unshare", *own_user, "--mount", "--propagation=private"]
    if subprocess.run([*command, "true"], capture_output=True, check=False).returncode != 0:
        print("skipped: no namespaces of mounts here")
        return SKIPPED
    return subprocess.run([*command, sys.executable, *sys.argv], env={**os.environ, "REPLICAS_APART": "1"}, check=False).returncode


def name_both():
    with tempfile.NamedTemporaryFile("w", suffix=".hosts") as hosts:
        hosts.write(f"127.0.0.1 localhost\n127.0.0.1 {NAME}\n127.0.0.2 {NAME}\n")
        hosts.flush()
        subprocess.run(["mount", "--bind", hosts.name, "/etc/hosts"], check=True)


class Replica:
    def __init__(self, curvd, listen, *flags):
        command = [curvd, f"--listen={listen}", "--metrics-listen=127.0.0.1:0", *flags]
        self._process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        line = next((line for line in self._process.stderr if '"serving"' in line), "")
        found = re.search(r'"listen":"[\d.]+:(\d+)".*"metrics_listen":"([\d.:]+)"', line)
        assert found, f"curvd did not listen on {listen}"
        self.port, self._metrics = found[1], found[2]
        threading.Thread(target=self._process.stderr.read, daemon=True).start()

    def calls(self):
        with urllib.request.urlopen(f"http://{self._metrics}/metrics") as page:
            text = page.read().decode()
        return sum(int(count) for count in re.findall(r'grpc_server_handled_total\{.*"EstimateCurvature".*\} (\d+)', text))

    def stop(self):
        self._process.send_signal(signal.SIGTERM)
        assert self._process.wait(60) == 0


def clients(bin_dir, folder):
    """Rows of name, command for SERVER and a number of calls, and whether a program makes one call alone."""
    here = pathlib.Path(__file__).parent
    (folder / "cloud.xyz").write_text("".join(f"{i % 3} {i // 3} 0 0 0 1\n" for i in range(9)), encoding="ascii")

    def curv(server, _):
        return [bin_dir / "curv", "estimate", folder / "cloud.xyz", "-o", folder / "out.xyz", "--k=4", f"--server={server}"]

    def python(way):
        return lambda server, calls: [sys.executable, here / "calls.py", way, server, calls]

    def node(way):
        return lambda server, calls: ["node", here / "calls.mjs", way, server, calls]

    return [
        ("C++, `CurvatureClient`", lambda server, calls: [bin_dir / "replica_calls", server, calls], False),
        ("`curv`, a process a call", curv, True),
        ("Python, `CurvatureClient`", python("client"), False),
        ("Python, `estimate_curvature`", python("function"), False),
        ("Python, `aio.CurvatureClient`", python("asyncio"), False),
        ("Node.js, `CurvatureClient`", node("client"), False),
        ("Node.js, `estimateCurvature`", node("function"), False),
    ]


def foreign_clients(cache, folder):
    """The same rows for the languages whose packages are installed."""
    here = pathlib.Path(__file__).parent
    source_dir = here.parents[2]

    def build_go(own):
        return foreign_trial.build_go(source_dir, cache, own, (here / "calls.go").read_text(encoding="utf-8"))

    def build_java(own):
        return foreign_trial.build_java(source_dir, own, "Calls", (here / "Calls.java").read_text(encoding="utf-8"))

    rows = []
    for name, build in (("Go, `round_robin` on `dns:///`", build_go), ("Java, `round_robin`", build_java)):
        own = folder / name[:2]
        own.mkdir()
        try:
            program = build(own)
        except SystemExit:
            continue  # it has said why
        rows.append((name, lambda server, calls, program=program: [*program, server, calls], False))
    return rows


def free_port():
    with socket.socket() as reserved:
        reserved.bind(("127.0.0.1", 0))
        return reserved.getsockname()[1]


def split_of(replicas, before, calls):
    """How many calls came to each replica since. curvd counts a call once it has ended, when its client may know already."""
    deadline = time.monotonic() + 10.0
    while True:
        split = [replica.calls() - count for replica, count in zip(replicas, before)]
        if sum(split) >= calls or time.monotonic() > deadline:
            return split
        time.sleep(0.05)


def try_client(make, one_call_each, replicas, calls, environment):
    """The calls that came to each replica, and the seconds until a call was given up where nobody listens."""
    before = [replica.calls() for replica in replicas]
    server = f"{NAME}:{replicas[0].port}"
    for _ in range(calls if one_call_each else 1):
        subprocess.run(list(map(str, make(server, calls))), check=True, env=environment, stdout=subprocess.DEVNULL)
    split = split_of(replicas, before, calls)
    seconds, status = timed(make(f"{NAME}:{free_port()}", 1), environment)
    assert status == 5, status
    idle = ["true"] if one_call_each else make(f"{NAME}:{free_port()}", 0)
    return split, seconds - timed(idle, environment)[0]


def timed(command, environment):
    """The seconds that a program runs, and its exit status."""
    start = time.monotonic()
    status = subprocess.run(list(map(str, command)), check=False, env=environment, capture_output=True).returncode
    return time.monotonic() - start, status


def start_both(curvd, *flags):
    first = Replica(curvd, "127.0.0.1:0", *flags)
    return [first, Replica(curvd, f"127.0.0.2:{first.port}", *flags)]


def check_certificate(bin_dir, folder):
    """Whichever address the lot falls on, the certificate is for the name."""
    request = "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=replicas -keyout key -out crt".split()
    subprocess.run(["openssl", *request, "-addext", f"subjectAltName=DNS:{NAME}"], cwd=folder, check=True, capture_output=True)
    replicas = start_both(bin_dir / "curvd", f"--tls-cert={folder}/crt", f"--tls-key={folder}/key")
    for _ in range(8):
        asked = [bin_dir / "curv", "info", "--health", f"--server={NAME}:{replicas[0].port}", f"--ca={folder}/crt"]
        health = subprocess.run(asked, check=True, capture_output=True, text=True).stdout
        assert health == "SERVING\n", health
    for replica in replicas:
        replica.stop()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("python_dir")
    parser.add_argument("cache_dir", type=pathlib.Path)
    parser.add_argument("--calls", type=int, default=100)
    options = parser.parse_args()
    if "REPLICAS_APART" not in os.environ:
        return in_namespace()
    name_both()
    environment = {**os.environ, "PYTHONPATH": options.python_dir}
    replicas = start_both(options.bin_dir / "curvd")
    faults = 0
    print(f"| client | {options.calls} calls over two replicas | nobody listens, given up after (without the start of the program) |\n| --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        own = pathlib.Path(folder)
        foreign = foreign_clients(options.cache_dir.resolve(), own)
        for name, make, one_call_each in [*clients(options.bin_dir.resolve(), own), *foreign]:
            share = DRAWN_SHARE if one_call_each else KEPT_SHARE
            for _ in range(TRIALS):
                split, seconds = try_client(make, one_call_each, replicas, options.calls, environment)
                print(f"| {name} | {split[0]} and {split[1]} | {seconds:.2f} s |", flush=True)
                lost = sum(split) != options.calls
                in_bounds = not lost and min(split) >= share * options.calls and seconds <= DEAD_SECONDS
                if in_bounds or lost:
                    break
            faults += not in_bounds
        check_certificate(options.bin_dir, pathlib.Path(folder))
    for replica in replicas:
        replica.stop()
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
