"""Clients that outlive their server: curvd is drained (SIGTERM), and started again on the same port."""

import asyncio
import contextlib
import os
import random
import signal
import socket
import subprocess
import threading
import time
import unittest

from clouds import sphere
from curvd_client import CurvatureClient, CurvdError, aio

_CLOUD = sphere(2_000, 1.0)


def free_port():
    """One that the system gives nobody by itself, so that it is still free after a restart."""
    while True:
        port = random.randrange(20_000, 32_000)
        with contextlib.suppress(OSError), socket.socket() as listener:
            listener.bind(("127.0.0.1", port))
            return port


class RestartTest(unittest.TestCase):
    def setUp(self):
        self.address = f"127.0.0.1:{free_port()}"
        self.process = None
        self.start()
        self.addCleanup(self.stop)

    def start(self):
        self.process = subprocess.Popen(
            [os.environ["CURVD_PROGRAM"], f"--listen={self.address}", "--metrics-listen=none"], stderr=subprocess.DEVNULL
        )
        host, port = self.address.split(":")
        end = time.monotonic() + 30
        while True:
            try:
                socket.create_connection((host, int(port))).close()
                return
            except OSError:
                self.assertLess(time.monotonic(), end, "curvd does not start")
                time.sleep(0.02)

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.assertEqual(self.process.wait(timeout=30), 0)

    def outcome_of(self, estimate):
        """The code of the error that a call in a thread of its own ends in, or "OK"; fails if it does not end."""
        outcomes = []

        def run():
            try:
                outcomes.append("OK" if estimate().summary.status_counts.ok == len(_CLOUD[0]) else "WRONG")
            except CurvdError as error:
                outcomes.append(error.code.name)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        thread.join(timeout=30)
        self.assertFalse(thread.is_alive(), "the call does not end")
        return outcomes[0]

    def assert_survives(self, estimate):
        """`estimate(timeout)` makes a call."""
        self.assertEqual(self.outcome_of(lambda: estimate(None)), "OK")
        self.stop()
        self.assertIn(self.outcome_of(lambda: estimate(1)), ("UNAVAILABLE", "DEADLINE_EXCEEDED"))
        self.start()
        self.assertEqual(self.outcome_of(lambda: estimate(None)), "OK")

    def test_the_blocking_client_survives(self):
        with CurvatureClient(self.address) as client:
            self.assert_survives(lambda timeout: client.estimate(*_CLOUD, timeout=timeout))

    def test_the_client_for_asyncio_survives(self):
        loop = asyncio.new_event_loop()
        thread = threading.Thread(target=loop.run_forever, daemon=True)
        thread.start()

        def run(work):
            return asyncio.run_coroutine_threadsafe(work, loop).result()

        async def make_client():
            return aio.CurvatureClient(self.address)

        client = run(make_client())
        self.assert_survives(lambda timeout: run(client.estimate(*_CLOUD, timeout=timeout)))
        run(client.close())
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()


if __name__ == "__main__":
    unittest.main()
