"""Calls to a curvd that asks for TLS, a certificate and a token."""

import dataclasses
import os
import pathlib
import subprocess
import tempfile
import unittest

import grpc
import numpy as np

from clouds import sphere
from curvd_client import CurvdError, Security, estimate_curvature


class SecureServerTest(unittest.TestCase):
    """Against a curvd that asks for TLS, a certificate and a token."""

    def setUp(self):
        self.server = os.environ["CURVD_SECURE_SERVER"]
        folder = pathlib.Path(os.environ["CURVD_SECURE_DIR"])
        self.security = Security(
            ca_file=folder / "server.crt",
            cert_file=folder / "client.crt",
            key_file=folder / "client.key",
            token=(folder / "token").read_text(encoding="utf-8"),
        )

    def estimate(self, **changes):
        security = dataclasses.replace(self.security, **changes)
        return estimate_curvature(*sphere(1_000, 1.0), server=self.server, security=security, max_attempts=1)

    def code(self, **changes):
        with self.assertRaises(CurvdError) as caught:
            self.estimate(**changes)
        return caught.exception.code, caught.exception.reason

    def test_serves_whom_it_knows(self):
        self.assertEqual(self.estimate().summary.status_counts.ok, 1_000)

    def test_refuses_others(self):
        self.assertEqual(self.code(token="guess"), (grpc.StatusCode.UNAUTHENTICATED, "TOKEN_INVALID"))
        self.assertEqual(self.code(token=None), (grpc.StatusCode.UNAUTHENTICATED, "TOKEN_MISSING"))
        self.assertEqual(self.code(cert_file=None, key_file=None)[0], grpc.StatusCode.UNAVAILABLE)
        self.assertEqual(self.code(ca_file=self.security.cert_file)[0], grpc.StatusCode.UNAVAILABLE)
        self.assertEqual(self.code(server_name="other.example")[0], grpc.StatusCode.UNAVAILABLE)

    def test_files_that_hold_no_pem_are_named(self):
        folder = pathlib.Path(os.environ["CURVD_SECURE_DIR"])
        for changes, words in (
            ({"ca_file": folder / "token"}, "ca_file: no certificate can be read from .*token"),
            ({"cert_file": folder / "token"}, "cert_file and key_file: .*token and .*client.key do not hold"),
            ({"key_file": folder / "token"}, "cert_file and key_file: .*client.crt and .*token do not hold"),
            ({"cert_file": folder / "server.crt"}, "key values mismatch"),
        ):
            with self.subTest(changes), self.assertRaisesRegex(ValueError, words):
                self.estimate(**changes)
        with self.assertRaises(FileNotFoundError):
            self.estimate(ca_file=folder / "nowhere")

    def test_openssls_own_kind_of_certificate_is_one(self):
        with tempfile.NamedTemporaryFile(suffix=".pem") as trusted:
            certificate = pathlib.Path(os.environ["CURVD_SECURE_DIR"]) / "server.crt"
            subprocess.run(
                ["openssl", "x509", "-in", certificate, "-trustout", "-addtrust", "serverAuth", "-out", trusted.name], check=True
            )
            Security(ca_file=trusted.name).open_channel("localhost:1", []).close()

    def test_pipes_are_read_once(self):
        pipes = []
        for name in ("server.crt", "client.crt", "client.key"):
            reader, writer = os.pipe()
            self.addCleanup(os.close, reader)
            os.write(writer, (pathlib.Path(os.environ["CURVD_SECURE_DIR"]) / name).read_bytes())
            os.close(writer)
            pipes.append(f"/dev/fd/{reader}")
        self.assertEqual(self.estimate(**dict(zip(("ca_file", "cert_file", "key_file"), pipes))).summary.status_counts.ok, 1_000)

    def test_tokens_that_no_header_can_hold_are_refused_and_not_shown(self):
        for token in ("two words", "line\nbreak", "\u00e9", "x" * 5_000):
            with self.subTest(token), self.assertRaisesRegex(ValueError, "printable ASCII") as caught:
                self.estimate(token=token)
            self.assertNotIn(token, str(caught.exception))

    def test_the_token_is_not_shown(self):
        self.assertNotIn(self.security.token, repr(self.security))


class PlainTextTest(unittest.TestCase):
    def test_a_token_goes_in_plain_text_to_this_machine_only(self):
        cloud = np.zeros((4, 3)), np.zeros((4, 3))
        for server in ("curvd.example:50061", "10.0.0.7:50061", "127.0.0.1.example.com:1", "localhost:1,10.0.0.7:1"):
            with self.subTest(server), self.assertRaisesRegex(ValueError, "plain text"):
                estimate_curvature(*cloud, server=server, security=Security(token="secret"))
        local = Security(token="secret")
        for server in ("127.0.0.1:1", "localhost:1", "[::1]:1", "unix:/run/curvd.sock"):
            local.open_channel(server, []).close()

    def test_settings_that_contradict_each_other_are_refused(self):
        for security in (Security(cert_file="a"), Security(key_file="a"), Security(server_name="a")):
            with self.assertRaises(ValueError):
                security.open_channel("127.0.0.1:1", [])
