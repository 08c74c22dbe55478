#!/usr/bin/python3
"""Runs curvd:latest with podman as deploy/ asks: image_test.py SOURCE_DIR

Prints what it measured; the tests of what the files say are in manifests_test.py.
"""

import copy
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import yaml

from container import IMAGE, Container, Pod, client, finish, health, podman

SOURCE_DIR = pathlib.Path(sys.argv[1])
DEPLOYMENT = next(item for item in yaml.safe_load_all((SOURCE_DIR / "deploy" / "kubernetes.yaml").read_text("utf-8"))
                  if item["kind"] == "Deployment")
COMPOSE = yaml.safe_load((SOURCE_DIR / "deploy" / "compose.yaml").read_text(encoding="utf-8"))["services"]["curvd"]
SERVICE = "curvature.v1.CurvatureService"
SERVING, NOT_SERVING = 1, 2
NOBODY = 65532
POINTS = 500_000
CLIENTS = 24
CONTAINER_BYTES = 512 << 20


def tell(text):
    print(f"  {text}", file=sys.stderr)


def compose_options():
    """What podman run is to be told so that it does as compose.yaml says."""
    options = [f"--user={COMPOSE['user']}", f"--pids-limit={COMPOSE['pids_limit']}"]
    options += [f"--cap-drop={capability}" for capability in COMPOSE["cap_drop"]]
    options += [f"--security-opt={option.removesuffix(':true')}" for option in COMPOSE["security_opt"]]
    options += [f"--ulimit={name}={limit['soft']}:{limit['hard']}" for name, limit in COMPOSE["ulimits"].items()]
    options += [f"--env={name}={value}" for name, value in COMPOSE["environment"].items()]
    return options


def run(*command):
    subprocess.run(command, check=True, capture_output=True)


class ImageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.curv("generate", "goursat", f"--points={POINTS}", "--noise-position=0.05", "-o", "cloud.ply")
        cls.curv("estimate", "cloud.ply", "-o", "expected.ply")
        cls.expected = (cls.folder / "expected.ply").read_bytes()
        cls.make_secrets()

    @classmethod
    def curv(cls, *arguments):
        status, output = finish(client(cls.folder, *arguments))
        if status != 0:
            raise AssertionError(f"curv {' '.join(arguments)}: {status}\n{output}")
        return output

    @classmethod
    def make_secrets(cls):
        """Files as Kubernetes mounts secrets: of root, readable to the group of the pod."""
        cls.secrets = cls.folder / "secrets"
        for name in ("tls", "tokens"):
            (cls.secrets / name).mkdir(parents=True)
        key, certificate = cls.secrets / "tls" / "tls.key", cls.secrets / "tls" / "tls.crt"
        run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "1",
            "-subj", "/CN=curvd", "-addext", "subjectAltName=DNS:curvd", "-keyout", key, "-out", certificate)
        (cls.folder / "ca.crt").write_bytes(certificate.read_bytes())
        line = cls.curv("token", "alice", "-o", "alice.token").splitlines()
        (cls.secrets / "tokens" / "tokens").write_text("\n".join(word for word in line if word.startswith("alice ")))
        for path in (key, certificate, cls.secrets / "tokens" / "tokens"):
            os.chown(path, 0, NOBODY)
            path.chmod(0o440)

    @classmethod
    def manifest_for_podman(cls):
        """A file with the deployment as far as podman 4.3 follows it.

        It would publish the ports on this machine, and mounts secrets as they stand in their manifest, in base64.
        """
        deployment = copy.deepcopy(DEPLOYMENT)
        deployment["spec"]["replicas"] = 1
        pod = deployment["spec"]["template"]["spec"]
        del pod["containers"][0]["ports"]
        pod["volumes"] = [{"name": volume["name"], "hostPath": {"path": str(cls.secrets / volume["name"])}}
                          for volume in pod["volumes"]]
        path = cls.folder / "kubernetes.yaml"
        path.write_text(yaml.safe_dump(deployment), encoding="utf-8")
        return str(path)

    def estimates(self, address, count=1, flags=()):
        """Clients of `address` at once, each with an output of its own. Their statuses and outputs."""
        each = 'curv "$@" -o $i.ply >$i.log 2>&1; echo $? >$i.status'
        script = f"for i in $(seq 0 {count - 1}); do ({each}) & done; wait"
        finish(client(self.folder, "-c", script, "sh", "estimate", "cloud.ply", f"--server={address}", *flags,
                      entrypoint="sh"))
        return [(int((self.folder / f"{i}.status").read_text()), (self.folder / f"{i}.log").read_text())
                for i in range(count)]

    def check_estimates(self, address, count=1, flags=()):
        for i, (status, output) in enumerate(self.estimates(address, count, flags)):
            self.assertEqual(status, 0, output)
            self.assertTrue((self.folder / f"{i}.ply").read_bytes() == self.expected, "another result than in-process")

    def check_may_do_nothing_but_serve(self, container):
        status = container.status()
        self.assertEqual(status["Uid"].split(), [str(NOBODY)] * 4)
        for capabilities in ("CapInh", "CapPrm", "CapEff", "CapBnd", "CapAmb"):
            self.assertEqual(int(status[capabilities], 16), 0, capabilities)
        self.assertEqual(status["NoNewPrivs"], "1")
        self.assertEqual(status["Seccomp"], "2", "no seccomp profile applies")
        mounts = pathlib.Path(f"/proc/{container.pid}/mounts").read_text(encoding="utf-8").splitlines()
        root = next(line.split() for line in mounts if line.split()[1] == "/")
        self.assertEqual(root[3].split(",")[0], "ro")

    def test_needs_to_be_told_how_calls_are_protected(self):
        done = subprocess.run(["podman", "run", "--rm", IMAGE], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("--insecure", done.stderr)

    def test_serves_as_compose_runs_it(self):
        with Container(compose_options()) as container:
            self.check_may_do_nothing_but_serve(container)
            self.check_estimates(f"{container.address}:50061")
            podman("healthcheck", "run", container.id)
            self.assertEqual(container.metric('curvd_points_total{status="ok"}'), POINTS)
            self.assertEqual(container.stop(), 0)
            self.assertIn('"event":"stopped"', container.log())

    def test_serves_as_kubernetes_runs_it(self):
        with Pod(self.manifest_for_podman()) as container:
            pod = DEPLOYMENT["spec"]["template"]["spec"]
            memory = int(pod["containers"][0]["resources"]["limits"]["memory"].removesuffix("Gi")) << 30
            self.assertEqual(container.metric("curvd_memory_limit_bytes"), memory // 10 * 8)
            self.check_may_do_nothing_but_serve(container)
            flags = ["--ca=ca.crt", "--server-name=curvd"]
            self.check_estimates(f"{container.address}:50061", 1, [*flags, "--token-file=alice.token"])
            (status, output), = self.estimates(f"{container.address}:50061", 1, flags)
            self.assertEqual(status, 1, output)  # without a token
            self.assertIn("UNAUTHENTICATED", output.upper())
            for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
                asked = pod["containers"][0][probe]["grpc"]
                self.assertEqual(health(f"{container.address}:{asked['port']}", asked.get("service", "")), SERVING)
            self.assertEqual(container.stop(), 0)

    def test_finishes_calls_before_it_stops(self):
        with Container([*compose_options(), "--cpus=1"]) as container:
            call = client(self.folder, "estimate", "cloud.ply", "-o", "0.ply", "--k=300", "--max-attempts=1",
                          f"--server={container.address}:50061")
            while container.metric("curvd_workers_busy") == 0:
                self.assertIsNone(call.poll(), "the call ended before the container was stopped")
                time.sleep(0.01)
            began = time.monotonic()
            self.assertEqual(container.stop(), 0)
            tell(f"stopped {time.monotonic() - began:.1f} s after SIGTERM, with a call of {POINTS} points to finish")
            self.assertEqual(finish(call)[0], 0)

    def test_starts_no_more_workers_than_it_has_processors(self):
        usable = len(os.sched_getaffinity(0))
        for cpus, workers in (("1", 1), ("1.5", min(2, usable))):
            with Container([*compose_options(), f"--cpus={cpus}"]) as container:
                self.assertEqual(container.metric("curvd_workers"), workers, f"--cpus={cpus}")

    def check_memory(self, container):
        self.assertTrue(container.is_running())
        self.assertEqual(container.kills(), 0)
        peak = container.peak_bytes()
        tell(f"{CLIENTS} clients of {POINTS} points: at most {(peak or 0) >> 20} of {CONTAINER_BYTES >> 20} MiB")

    def test_draws_letters_without_writing_anywhere_else(self):
        pictures = self.folder / "pictures"
        pictures.mkdir()
        pictures.chmod(0o777)
        (pictures / "result.ply").write_bytes(self.expected)
        status, output = finish(client(pictures, "render", "result.ply", "-o", "picture.png",
                                       options=(f"--user={NOBODY}:{NOBODY}", "--read-only", "--read-only-tmpfs=false")))
        self.assertEqual(status, 0, output)
        # Alone: a font cache that cannot be written would be told before.
        self.assertRegex(output, r"\Apicture\.png: mean of result\.ply.*\n\Z")

    def test_serves_in_turn_what_its_memory_does_not_hold(self):
        with Container([*compose_options(), f"--memory={CONTAINER_BYTES}"]) as container:
            limit = CONTAINER_BYTES // 10 * 8
            self.assertEqual(container.metric("curvd_memory_limit_bytes"), limit)
            self.assertGreater(CLIENTS * POINTS * 96, limit)
            self.check_estimates(f"{container.address}:50061", CLIENTS)
            self.check_memory(container)
            self.assertEqual(container.stop(), 0)

    def test_refuses_what_may_not_wait(self):
        with Container([*compose_options(), f"--memory={CONTAINER_BYTES}"], ["--max-waiting=1"]) as container:
            results = self.estimates(f"{container.address}:50061", CLIENTS, ["--max-attempts=1"])
            for status, output in results:
                self.assertIn(status, (0, 1), output)
            refused = [output for status, output in results if status != 0]
            self.assertTrue(refused)
            self.assertLess(len(refused), CLIENTS)
            tell(f"--max-waiting=1: {len(refused)} refused, as in: {refused[0].strip()}")
            self.check_memory(container)
            # Asked again as RetryInfo says, all are served.
            self.check_estimates(f"{container.address}:50061", CLIENTS, ["--max-attempts=100"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
