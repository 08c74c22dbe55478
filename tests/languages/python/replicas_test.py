"""Several servers behind one name, and servers that nobody reaches."""

import collections
import contextlib
import time
import unittest
from unittest import mock

import numpy as np

from clouds import sphere
from curvd_client import CurvatureClient, CurvdError, aio, estimate_curvature
from curvd_client.addresses import drawn, is_local, split_servers
from scripted_server import result, scripted, summary

_CALLS = 100
# The promise is 40 to 60 of 100; the policy takes turns once both are connected.
_LEAST = 40


@contextlib.contextmanager
def two_replicas():
    """Addresses of two servers, and how many calls each had."""
    calls = collections.Counter()

    def script_of(name):
        def script(_):
            calls[name] += 1
            return [result(0, 10), summary(10)]

        return script

    with scripted(script_of("first")) as first, scripted(script_of("second")) as second:
        yield first, second, calls


class DrawnTest(unittest.TestCase):
    def drawn(self, server, *addresses):
        found = [(None, None, None, "", (address, 50061)) for address in addresses]
        with mock.patch("socket.getaddrinfo", return_value=found):
            return drawn(server)

    def test_each_address_of_a_name_comes_first_at_times(self):
        seen = {self.drawn("curvd.example", "10.0.0.1", "10.0.0.2") for _ in range(100)}
        both = {"10.0.0.1:50061,10.0.0.2:50061", "10.0.0.2:50061,10.0.0.1:50061"}
        self.assertEqual(seen, {(each, "curvd.example") for each in both})
        self.assertIn("[fd00::1]:9", self.drawn("curvd.example:9", "fd00::1", "10.0.0.1")[0])

    def test_others_stay_as_they_are(self):
        for server in ("localhost", "10.0.0.1:5", "[::1]:5", "a,b", "dns:///curvd.example", "unix:/run/curvd"):
            self.assertEqual(self.drawn(server, "10.0.0.1", "10.0.0.2") if "10" not in server else drawn(server), (server, None))
        self.assertEqual(self.drawn("curvd.example", "10.0.0.1"), ("curvd.example", None))
        with mock.patch("socket.getaddrinfo", side_effect=OSError):
            self.assertEqual(drawn("curvd.example"), ("curvd.example", None))


class SplitTest(unittest.TestCase):
    def assert_split(self, calls):
        self.assertEqual(sum(calls.values()), _CALLS)
        self.assertGreaterEqual(min(calls["first"], calls["second"]), _LEAST, calls)

    def test_a_client_takes_turns(self):
        for form in ("ipv4:{},{}", "{},{}"):
            with self.subTest(form), two_replicas() as (first, second, calls):
                with CurvatureClient(form.format(first, second)) as client:
                    for _ in range(_CALLS):
                        client.estimate(*sphere(10, 1.0))
                self.assert_split(calls)

    def test_functions_take_turns_as_well(self):
        with two_replicas() as (first, second, calls):
            for _ in range(_CALLS):
                estimate_curvature(*sphere(10, 1.0), server=f"ipv4:{first},{second}")
            self.assert_split(calls)


class UnreachableTest(unittest.TestCase):
    def seconds_to_fail(self, call):
        began = time.monotonic()
        with self.assertRaises(CurvdError) as caught:
            call()
        self.assertEqual(caught.exception.code.name, "UNAVAILABLE")
        return time.monotonic() - began

    def test_nobody_there_is_reported_within_two_seconds(self):
        cloud = sphere(10, 1.0)
        for server in ("127.0.0.1:1", "127.0.0.1:1,127.0.0.1:2", "ipv4:127.0.0.1:1,127.0.0.1:2"):
            with self.subTest(server), CurvatureClient(server) as client:
                self.assertLess(self.seconds_to_fail(lambda client=client: client.estimate(*cloud)), 2)
        with CurvatureClient("127.0.0.1:1") as client:
            self.assertLess(self.seconds_to_fail(client.info), 2)
            self.assertLess(self.seconds_to_fail(client.health), 2)
        self.assertLess(self.seconds_to_fail(lambda: estimate_curvature(*cloud, server="127.0.0.1:1")), 2)

    def test_who_asks_for_longer_gets_it(self):
        with CurvatureClient("127.0.0.1:1") as client:
            seconds = self.seconds_to_fail(lambda: client.info(connect_timeout=4))
        self.assertGreater(seconds, 2)


class UnreachableAioTest(unittest.IsolatedAsyncioTestCase):
    async def test_nobody_there_is_reported_within_two_seconds(self):
        began = time.monotonic()
        async with aio.CurvatureClient("127.0.0.1:1") as client:
            with self.assertRaises(CurvdError):
                await client.estimate(np.zeros((4, 3)))
        self.assertLess(time.monotonic() - began, 2)

    async def test_a_client_takes_turns(self):
        with two_replicas() as (first, second, calls):
            async with aio.CurvatureClient(f"ipv4:{first},{second}") as client:
                for _ in range(_CALLS):
                    await client.estimate(*sphere(10, 1.0))
        self.assertGreaterEqual(min(calls["first"], calls["second"]), _LEAST, calls)


class AddressTest(unittest.TestCase):
    def test_a_port_is_added_where_there_is_none(self):
        for given, targets in {
            "localhost": ["localhost:50061"],
            "10.0.0.7": ["10.0.0.7:50061"],
            "a:1, b": ["a:1", "b:50061"],
            "::1": ["[::1]:50061"],
            "[::1]": ["[::1]:50061"],
            "[::1]:7": ["[::1]:7"],
            "dns:///curvd.example": ["dns:///curvd.example:50061"],
            "dns://9.9.9.9/curvd.example:1": ["dns://9.9.9.9/curvd.example:1"],
            "ipv4:10.0.0.1:1,10.0.0.2": ["ipv4:10.0.0.1:1,10.0.0.2:50061"],
            "ipv4:10.0.0.1,unix:/run/curvd": ["ipv4:10.0.0.1:50061", "unix:/run/curvd"],
            "unix:/run/curvd.sock": ["unix:/run/curvd.sock"],
        }.items():
            with self.subTest(given):
                self.assertEqual(split_servers(given), targets)

    def test_what_is_no_address_is_refused(self):
        for given in ("", "a,,b", "localhost:", "localhost:http", "localhost:0", "localhost:65536", ":50061"):
            with self.subTest(given), self.assertRaises(ValueError):
                split_servers(given)
        with self.assertRaises(TypeError):
            split_servers(50061)

    def test_a_url_of_the_web_is_named_as_one(self):
        for given, hint in {"http://a:1": "without http://$", "b, HTTPS://a": "TLS has an option of its own$", "DNS:///a": "DNS://$", "foo:///x": "foo://$"}.items():
            with self.subTest(given), self.assertRaisesRegex(ValueError, "is a URL; it must be HOST or HOST:PORT.*" + hint):
                split_servers(given)

    def test_only_loopback_is_this_machine(self):
        for target in ("localhost:1", "ipv4:127.0.0.1:1,127.0.0.2:1", "ipv6:[::1]:1", "unix:/x", "dns:///localhost:1"):
            self.assertTrue(is_local(target), target)
        for target in ("ipv4:127.0.0.1:1,10.0.0.1:1", "dns:///curvd.example:1", "dns://localhost/a.example:1", "a:1"):
            self.assertFalse(is_local(target), target)
