#!/usr/bin/python3
"""curv doctor against real servers, healthy and not: doctor_test.py CURV CURVD"""

import concurrent.futures
import contextlib
import hashlib
import json
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
import unittest

import grpc

CURV, CURVD = sys.argv[1], sys.argv[2]
del sys.argv[1:3]
START_SECONDS = 30
FAKETIME = next(iter(sorted(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))), None)


def shifted(seconds):
    """An environment in which the clock is that many seconds ahead. Waiting goes by the monotonic clock, which is right."""
    return {**os.environ, "LD_PRELOAD": str(FAKETIME), "FAKETIME": f"{seconds:+d}s", "DONT_FAKE_MONOTONIC": "1"}


@contextlib.contextmanager
def curvd(*flags, environment=None):
    """Yields the process, its port and that of its metrics."""
    process = subprocess.Popen([CURVD, "--listen=127.0.0.1:0", "--metrics-listen=127.0.0.1:0", *flags],
                               stderr=subprocess.PIPE, text=True, env=environment)
    watchdog = threading.Timer(START_SECONDS, process.kill)
    watchdog.start()
    try:
        line = next((line for line in process.stderr if '"serving"' in line), "")
        ports = [int(port) for port in re.findall(r"127\.0\.0\.1:([1-9]\d*)", line)]
        assert len(ports) == 2, line
        watchdog.cancel()
        yield process, *ports
    finally:
        watchdog.cancel()
        process.kill()
        process.wait()
        process.stderr.close()


def doctor(server, *flags, environment=None):
    """The exit code, and what was found by check: {"name": ("ok", message, remedy)}. A fault outweighs what else is said."""
    command = [CURV, "doctor", f"--server={server}", "--json", *flags]
    run = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert run.stdout, run.stderr
    found = json.loads(run.stdout)
    checks = {}
    for each in found["servers"][0]["findings"]:
        if checks.get(each["check"], ("ok",))[0] != "fault":
            checks[each["check"]] = (each["result"], each["message"], each["remedy"])
    return run.returncode, checks


def openssl(folder, *words):
    subprocess.run(["openssl", *words], cwd=folder, check=True, capture_output=True)


def make_certificate(folder, name, host, days):
    """A certificate for `host` of the authority `name`, NAME.crt and NAME.key; that of the authority is NAME-ca.crt."""
    key = "-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes".split()
    openssl(folder, "req", "-x509", *key, "-days", "3650", "-subj", f"/CN={name} authority", "-keyout", f"{name}-ca.key",
            "-out", f"{name}-ca.crt")
    openssl(folder, "req", *key, "-subj", f"/CN={name}", "-keyout", f"{name}.key", "-out", f"{name}.csr")
    (folder / "names").write_text(f"subjectAltName=DNS:{host}\n", encoding="ascii")
    openssl(folder, "x509", "-req", "-in", f"{name}.csr", "-CA", f"{name}-ca.crt", "-CAkey", f"{name}-ca.key",
            "-CAcreateserial", "-days", str(days), "-extfile", "names", "-out", f"{name}.crt")


class Doctor(unittest.TestCase):
    def assert_fault(self, found, check, says, remedy, code=5):
        self.assertEqual(found[0], code, found)
        self.assertIn(check, found[1], found)
        result, message, what_to_do = found[1][check]
        self.assertEqual(result, "fault", found)
        self.assertRegex(message, says)
        self.assertRegex(what_to_do, remedy)

    def assert_well(self, found):
        self.assertEqual(found[0], 0, found)
        self.assertEqual({result for result, _, _ in found[1].values()}, {"ok"}, found)

    def test_a_healthy_server_has_nothing_wrong(self):
        with curvd() as (_, port, _):
            found = doctor(f"localhost:{port}")
            self.assert_well(found)
            self.assertEqual(list(found[1]), ["name", "connection", "protocol", "version", "caller", "health", "limits", "clock"])
            self.assertIn("200,000,000 points a cloud", found[1]["limits"][1])
            self.assertIn("agree", found[1]["clock"][1])
            text = subprocess.run([CURV, "doctor", f"--server=127.0.0.1:{port}"], capture_output=True, text=True, check=True).stdout
            self.assertTrue(text.endswith("Nothing is wrong.\n"), text)
            self.assertIn("\n  ok       health       SERVING\n", text)

    def test_where_nobody_listens_a_server_must_be_started(self):
        with socket.socket() as reserved:
            reserved.bind(("127.0.0.1", 0))
            found = doctor(f"127.0.0.1:{reserved.getsockname()[1]}")
        self.assert_fault(found, "connection", "nothing listens there", "start curvd")
        self.assertEqual(list(found[1]), ["name", "connection"])

    def test_a_name_without_address_is_misspelled(self):
        self.assert_fault(doctor("nowhere.invalid:50061"), "name", "nowhere.invalid has no address", "spelling")

    def test_a_port_of_http_is_another_service(self):
        with curvd() as (_, _, metrics):
            self.assert_fault(doctor(f"127.0.0.1:{metrics}"), "protocol", "speaks HTTP/1", "metrics")
            self.assert_fault(doctor(f"127.0.0.1:{metrics}", "--tls"), "protocol", "HTTP/1 in plain text", "metrics")

    def test_a_port_that_says_nothing_or_something_else_is_told(self):
        def serve(listener, answer):
            with contextlib.suppress(OSError):
                while True:
                    connection, _ = listener.accept()
                    with contextlib.suppress(OSError):
                        connection.recv(4096)
                        if answer is not None:
                            connection.sendall(answer)
                            connection.close()
                        kept.append(connection)

        kept = []
        for answer, says in [(b"SSH-2.0-OpenSSH\r\n", "neither HTTP/2 nor TLS"), (b"", "closes connections"), (None, "says nothing")]:
            with socket.create_server(("127.0.0.1", 0)) as listener:
                threading.Thread(target=serve, args=(listener, answer), daemon=True).start()
                found = doctor(f"127.0.0.1:{listener.getsockname()[1]}", "--timeout=0.3")
                self.assert_fault(found, "protocol", says, ".")
        for connection in kept:
            connection.close()

    def test_another_grpc_service_is_no_curvd(self):
        other = grpc.server(concurrent.futures.ThreadPoolExecutor())
        port = other.add_insecure_port("127.0.0.1:0")
        other.start()
        self.assert_fault(doctor(f"127.0.0.1:{port}"), "version", "not curvature.v1", "another gRPC service")
        other.stop(None)

    def test_plain_text_and_tls_are_not_mistaken_for_each_other(self):
        with tempfile.TemporaryDirectory() as name, curvd() as (_, plain, _):
            folder = pathlib.Path(name)
            make_certificate(folder, "good", "localhost", 90)
            self.assert_fault(doctor(f"localhost:{plain}", "--tls"), "protocol", "speaks plain text", "leave out --tls")
            with curvd(f"--tls-cert={folder}/good.crt", f"--tls-key={folder}/good.key") as (_, port, _):
                self.assert_fault(doctor(f"localhost:{port}"), "protocol", "TLS only", "add --tls")

    @unittest.skipIf(FAKETIME is None, "libfaketime is not installed")
    def test_each_fault_of_a_certificate_is_told(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            make_certificate(folder, "good", "localhost", 90)
            make_certificate(folder, "other", "localhost", 90)
            with curvd(f"--tls-cert={folder}/good.crt", f"--tls-key={folder}/good.key") as (_, port, _):
                server, ca = f"localhost:{port}", f"--ca={folder}/good-ca.crt"
                found = doctor(server, ca)
                self.assert_well(found)
                self.assertRegex(found[1]["certificate"][1], r"valid until 20\d\d-.*, (89|90) days from now")
                self.assertIn("TLSv1.3", found[1]["protocol"][1])
                self.assert_fault(doctor(server, "--tls"), "authority", "not trusted", "--ca FILE")
                self.assert_fault(doctor(server, f"--ca={folder}/other-ca.crt"), "authority", "issued by CN = good authority",
                                  "other authorities")
                self.assert_fault(doctor(f"127.0.0.1:{port}", ca), "name", "for localhost, not for 127.0.0.1", "--server-name")
                self.assert_well(doctor(f"127.0.0.1:{port}", ca, "--server-name=localhost"))
                self.assert_fault(doctor(server, ca, environment=shifted(-86_400 * 30)), "certificate", "not valid before",
                                  "set the clock right")
                self.assert_fault(doctor(server, ca, environment=shifted(86_400 * 100)), "certificate", "expired at", "renew it")
                soon = doctor(server, ca, environment=shifted(86_400 * 80))
                self.assertEqual((soon[0], soon[1]["certificate"][0]), (0, "warning"), soon)

    def test_clients_that_are_not_let_in_learn_why(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for who in ("good", "client", "stranger"):
                make_certificate(folder, who, "localhost", 90)
            (folder / "token").write_text("a-token", encoding="ascii")
            (folder / "guess").write_text("a-guess", encoding="ascii")
            (folder / "tokens").write_text(f"alice sha256:{hashlib.sha256(b'a-token').hexdigest()}\n", encoding="ascii")
            flags = [f"--tls-cert={folder}/good.crt", f"--tls-key={folder}/good.key",
                     f"--tls-client-ca={folder}/client-ca.crt", f"--token-file={folder}/tokens"]
            with curvd(*flags) as (_, port, _):
                def ask(*more):
                    return doctor(f"localhost:{port}", f"--ca={folder}/good-ca.crt", *more)

                def own(who):
                    return f"--cert={folder}/{who}.crt", f"--key={folder}/{who}.key"

                token = f"--token-file={folder}/token"
                self.assert_well(ask(*own("client"), token))
                self.assert_fault(ask(token), "client", "ends the connection", "--cert and --key")
                self.assert_fault(ask(*own("stranger"), token), "client", "refuses the certificate", "--tls-client-ca")
                self.assert_fault(ask(*own("client")), "caller", "TOKEN_MISSING", "--token-file FILE", code=1)
                found = ask(*own("client"), f"--token-file={folder}/guess")
                self.assert_fault(found, "caller", "TOKEN_INVALID", "administrator", code=1)
                self.assertEqual(found[1]["health"][0], "ok")

    def test_a_draining_server_takes_no_clouds(self):
        with curvd("--drain-timeout=60s") as (process, port, _):
            with grpc.insecure_channel(f"127.0.0.1:{port}") as channel:
                held = threading.Event()

                def requests():
                    yield b"\x0a\x00"  # an empty header; the cloud does not come until the end of the test
                    held.wait()

                call = channel.stream_stream("/curvature.v1.CurvatureService/EstimateCurvature")(requests())
                next(call)  # the call is accepted
                process.send_signal(signal.SIGTERM)
                give_up = time.monotonic() + START_SECONDS
                while (found := doctor(f"127.0.0.1:{port}"))[0] == 0 and time.monotonic() < give_up:
                    pass
                self.assert_fault(found, "health", "drains", "another replica")
                held.set()
                call.cancel()

    @unittest.skipIf(FAKETIME is None, "libfaketime is not installed")
    def test_clocks_that_differ_are_told(self):
        for seconds, says in [(3_600, "behind"), (-3_600, "ahead of")]:
            with curvd() as (_, port, _):
                code, found = doctor(f"127.0.0.1:{port}", environment=shifted(seconds))
            self.assertEqual((code, found["clock"][0]), (0, "warning"), found)
            self.assertRegex(found["clock"][1], f"the server's is (59m5|1h).* {says} this machine's")

    def test_replicas_are_looked_at_one_by_one(self):
        with curvd() as (_, port, _):
            run = subprocess.run([CURV, "doctor", f"--server=127.0.0.1:{port},127.0.0.1:1", "--json"], capture_output=True,
                                 text=True, check=False)
        servers = json.loads(run.stdout)["servers"]
        self.assertEqual(run.returncode, 5)
        self.assertEqual([len(each["findings"]) for each in servers], [8, 2])

    def test_flags_that_make_no_sense_are_refused(self):
        for flags in (["--server=localhost:", "--json"], ["--ca=/nonexistent"], ["--server-name=other"], ["--timeout=0"]):
            run = subprocess.run([CURV, "doctor", *flags], capture_output=True, text=True, check=False)
            self.assertEqual((run.returncode, run.stdout), (2, ""), flags)


if __name__ == "__main__":
    unittest.main(verbosity=2)
