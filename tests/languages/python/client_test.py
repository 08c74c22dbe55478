"""CurvatureClient against a real curvd: what it tells, how its calls end early."""

import functools
import gc
import io
import threading
import time
import unittest

import grpc
import numpy as np

import curvd_client
from clouds import sphere
from curvd_client import Cancel, CurvatureClient, CurvdError, estimate_curvature
from curvd_client.progress import Progress, TerminalLine
from real_server import RealServerTest

_PHASES = {"receiving", "queued", "indexing", "estimating_normals", "orienting", "estimating", "sending"}
# Takes far longer than it takes to notice that it was cancelled.
_LONG = {"estimator": "jet", "jet_degree": 4, "neighbor_count": 10_000}


class ClientTest(RealServerTest):
    def test_a_client_gives_what_the_functions_give(self):
        cloud = sphere(2_000, radius=2.0)
        expected = estimate_curvature(*cloud, server=self.server, neighbor_count=30).points.tobytes()
        with CurvatureClient(self.server) as client:
            for _ in range(3):
                self.assertEqual(client.estimate(*cloud, neighbor_count=30).points.tobytes(), expected)
            normals = client.normals(cloud[0]).points["normal"]
        np.testing.assert_allclose(normals, cloud[1], atol=0.05)

    def test_it_tells_what_the_server_is(self):
        with CurvatureClient(self.server) as client:
            info = client.info()
            self.assertEqual(client.health(), "SERVING")
        # Client and server are of one repository, and have one version.
        self.assertEqual(info.version, curvd_client.__version__)
        self.assertLessEqual({"avg-hexagram", "jet", "aso", "auto"}, set(info.estimators))
        self.assertGreater(info.limits.max_points, 1_000_000)
        self.assertGreater(info.worker_threads, 0)

    def test_progress_is_reported(self):
        seen = []
        with CurvatureClient(self.server) as client:
            client.estimate(*sphere(20_000, radius=1.0), progress=seen.append, **_LONG)
        self.assertGreater(len(seen), 2)
        self.assertLessEqual({each.phase for each in seen}, _PHASES)
        self.assertEqual({each.point_count for each in seen}, {20_000})
        self.assertGreater(max(each.points_estimated for each in seen), 0)
        self.assertTrue(all(0 <= each.fraction <= 1 for each in seen))
        self.assertEqual(seen[-1], Progress.of_all(20_000))

    def test_progress_ends_with_all_points(self):
        seen = []
        with CurvatureClient(self.server) as client:  # too small a cloud for the server to tell progress
            client.estimate(*sphere(100, radius=1.0), progress=seen.append)
        self.assertEqual((seen[-1].fraction, seen[-1].points_estimated), (1.0, 100))

    def test_a_failure_of_another_call_in_progress_is_no_reason_to_try_again(self):
        tries = []

        def ask_elsewhere(_):
            tries.append(1)
            raise CurvdError(grpc.StatusCode.UNAVAILABLE, "elsewhere", transient=True)

        with CurvatureClient(self.server) as client, self.assertRaisesRegex(CurvdError, "elsewhere"):
            client.estimate(*sphere(200_000, radius=1.0), progress=ask_elsewhere, **_LONG)
        self.assertEqual(len(tries), 1)

    def test_what_progress_raises_ends_the_call(self):
        def stop(_):
            raise KeyError("enough")

        with CurvatureClient(self.server) as client, self.assertRaisesRegex(KeyError, "enough"):
            client.estimate(*sphere(200_000, radius=1.0), progress=stop, **_LONG)

    def test_a_handle_cancels_the_call(self):
        cancel = Cancel()
        began = time.monotonic()
        with CurvatureClient(self.server) as client, self.assertRaises(CurvdError) as caught:
            client.estimate(*sphere(200_000, radius=1.0), cancel=cancel, progress=lambda _: cancel.cancel(), **_LONG)
        self.assertEqual(caught.exception.code.name, "CANCELLED")
        self.assertLess(time.monotonic() - began, 5)
        with CurvatureClient(self.server) as client, self.assertRaises(CurvdError):
            client.estimate(*sphere(10, radius=1.0), cancel=cancel)

    def test_a_handle_cancels_the_pause_between_tries(self):
        cancel = Cancel()
        threading.Timer(0.1, cancel.cancel).start()
        with CurvatureClient("127.0.0.1:1") as client, self.assertRaises(CurvdError) as caught:
            client.estimate(*sphere(10, radius=1.0), cancel=cancel, connect_timeout=60)
        self.assertEqual(caught.exception.code.name, "CANCELLED")

    def test_closing_ends_the_calls_that_run(self):
        client, caught, runs = CurvatureClient(self.server), [], threading.Event()

        def call():
            try:
                client.estimate(*sphere(200_000, radius=1.0), progress=lambda _: runs.set(), **_LONG)
            except CurvdError as error:
                caught.append(error)

        thread = threading.Thread(target=call)
        thread.start()
        self.assertTrue(runs.wait(30))
        client.close()
        thread.join(30)
        self.assertEqual([error.code.name for error in caught], ["CANCELLED"])
        client.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            client.info()

    def test_threads_share_a_client(self):
        cloud, results = sphere(5_000, radius=2.0), []
        with CurvatureClient(self.server) as client:

            def call():
                results.append(client.estimate(*cloud).points.tobytes())

            threads = [threading.Thread(target=call) for _ in range(8)]
            for each in threads:
                each.start()
            for each in threads:
                each.join()
        self.assertEqual((len(results), len(set(results))), (8, 1))

    def test_a_call_that_failed_is_gone_with_its_error(self):
        # One that stayed for the garbage collector could keep its program from ending: grpc's finalizer takes a lock.
        gc.collect()
        gc.disable()
        self.addCleanup(gc.enable)
        with CurvatureClient(self.server) as client:
            with self.assertRaises(CurvdError) as caught:
                client.estimate(*sphere(100, radius=1.0), neighbor_count=2)
        self.assertIn("neighbor_count", caught.exception.message)  # the error is still here, the call is not
        self.assertEqual(_calls_alive(), 0)
        # Port 1 has no server, so this call is one that nobody answers.
        with CurvatureClient("127.0.0.1:1") as client, self.assertRaises(CurvdError):
            client.health(connect_timeout=0.1, max_attempts=1)
        self.assertEqual(_calls_alive(), 0)


def _calls_alive() -> int:
    return sum(isinstance(each, grpc.Call) for each in gc.get_objects())


class ProgressTest(unittest.TestCase):
    def test_a_terminal_shows_phase_and_share(self):
        stream = io.StringIO()
        line = TerminalLine(stream)
        line.show(Progress("receiving", 0, 0, 1_000))
        line.show(Progress("estimating", 1_000, 500, 1_000))
        line.show(Progress("estimating", 1_000, 501, 1_000))  # too soon after the last
        line.show(Progress("sending", 1_000, 1_000, 1_000))
        line.show(Progress.of_all(1_000))
        line.end()
        self.assertIn("receiving", stream.getvalue())
        self.assertIn("estimating  50% |############            | 500 of 1,000 points", stream.getvalue())
        self.assertNotIn("501", stream.getvalue())
        self.assertRegex(stream.getvalue(), r"sending 100% \|#{24}\| 1,000 of 1,000 points, 0\.\d s\n$")

    def test_points_are_those_that_the_phase_counts(self):
        self.assertEqual(Progress("receiving", 1_000, 0, 2_000).counted(), "1,000 of 2,000 points")
        self.assertEqual(Progress("indexing", 2_000, 0, 2_000).counted(), "2,000 points")
        self.assertEqual(Progress("estimating", 1, 0, 1).counted(), "0 of 1 point")

    def test_what_is_no_function_is_refused(self):
        with self.assertRaisesRegex(TypeError, "progress is 'yes'"):
            estimate_curvature(np.zeros((4, 3)), server="127.0.0.1:1", progress="yes")

    def test_what_nobody_would_await_is_refused(self):
        async def told(_):
            pass

        class Told:
            async def __call__(self, _):
                pass

        for progress in (told, functools.partial(told), Told()):
            with self.subTest(progress), self.assertRaisesRegex(TypeError, "progress is .* awaits; it must be a function"):
                estimate_curvature(np.zeros((4, 3)), server="127.0.0.1:1", progress=progress)
