"""The asyncio twin against a real curvd."""

import asyncio
import os
import time
import unittest

import numpy as np

from clouds import sphere
from curvd_client import CurvdError, Security, aio, estimate_curvature

_LONG = {"estimator": "jet", "jet_degree": 4, "neighbor_count": 10_000}


class AioTest(unittest.IsolatedAsyncioTestCase):
    def setUp(self):
        self.server = os.environ["CURVD_SERVER"]

    async def test_results_are_those_of_the_blocking_client(self):
        cloud = sphere(20_000, radius=2.0)
        expected = estimate_curvature(*cloud, server=self.server, neighbor_count=30).points.tobytes()
        async with aio.CurvatureClient(self.server) as client:
            several = await asyncio.gather(*(client.estimate(*cloud, neighbor_count=30) for _ in range(4)))
            self.assertEqual({each.points.tobytes() for each in several}, {expected})
            normals = await client.normals(cloud[0])
            np.testing.assert_allclose(normals.points["normal"], cloud[1], atol=0.05)
            self.assertEqual(await client.health(), "SERVING")
            self.assertIn("auto", (await client.info()).estimators)
        alone = await aio.estimate_curvature(*cloud, server=self.server, neighbor_count=30)
        self.assertEqual(alone.points.tobytes(), expected)
        self.assertEqual(len((await aio.estimate_normals(cloud[0], server=self.server)).points), 20_000)

    async def test_errors_are_those_of_the_blocking_client(self):
        async with aio.CurvatureClient(self.server) as client:
            with self.assertRaises(CurvdError) as caught:
                await client.estimate(*sphere(100, 1.0), neighbor_count=2)
            self.assertEqual(caught.exception.reason, "INVALID_OPTION")
            with self.assertRaises(CurvdError) as caught:
                await client.estimate(*sphere(100_000, 1.0), timeout=0.001)
            self.assertEqual(caught.exception.code.name, "DEADLINE_EXCEEDED")

    async def test_a_cancelled_task_ends_its_call(self):
        runs = asyncio.Event()
        async with aio.CurvatureClient(self.server) as client:
            call = client.estimate(*sphere(200_000, 1.0), progress=lambda _: runs.set(), **_LONG)
            task = asyncio.create_task(call)
            await asyncio.wait_for(runs.wait(), 30)
            began = time.monotonic()
            task.cancel()
            with self.assertRaises(asyncio.CancelledError):
                await task
            self.assertLess(time.monotonic() - began, 5)
            # The client goes on.
            self.assertEqual(await client.health(), "SERVING")

    async def test_a_coroutine_for_progress_is_awaited(self):
        seen = []

        async def told(progress):
            await asyncio.sleep(0)
            seen.append(progress.point_count)

        async with aio.CurvatureClient(self.server) as client:
            await client.estimate(*sphere(20_000, 1.0), progress=told, **_LONG)
            self.assertEqual(set(seen), {20_000})

            async def stop(_):
                raise KeyError("enough")

            with self.assertRaisesRegex(KeyError, "enough"):
                await client.estimate(*sphere(20_000, 1.0), progress=stop, **_LONG)

    async def test_a_failure_of_another_call_in_progress_is_no_reason_to_try_again(self):
        tries = []

        async def ask_elsewhere(_):
            tries.append(1)
            async with aio.CurvatureClient("127.0.0.1:1") as elsewhere:
                await elsewhere.info(max_attempts=1)

        async with aio.CurvatureClient(self.server) as client:
            with self.assertRaisesRegex(CurvdError, "127.0.0.1:1"):
                await client.estimate(*sphere(200_000, 1.0), progress=ask_elsewhere, **_LONG)
        self.assertEqual(len(tries), 1)

    async def test_a_progress_function_that_never_ends_is_no_longer_waited_for_than_the_call(self):
        async def wait(_):
            await asyncio.sleep(60)

        began = time.monotonic()
        async with aio.CurvatureClient(self.server) as client:
            with self.assertRaises(CurvdError) as caught:
                await client.estimate(*sphere(200_000, 1.0), progress=wait, timeout=1.0, max_attempts=1, **_LONG)
        self.assertEqual(caught.exception.code.name, "DEADLINE_EXCEEDED")
        self.assertLess(time.monotonic() - began, 20)

    async def test_closing_ends_the_calls_that_run(self):
        runs = asyncio.Event()
        client = aio.CurvatureClient(self.server)
        call = client.estimate(*sphere(200_000, 1.0), progress=lambda _: runs.set(), **_LONG)
        task = asyncio.create_task(call)
        await asyncio.wait_for(runs.wait(), 30)
        await client.close()
        with self.assertRaises(CurvdError) as caught:
            await task
        self.assertEqual(caught.exception.code.name, "CANCELLED")
        with self.assertRaisesRegex(ValueError, "closed"):
            await client.info()


class EventLoopTest(unittest.TestCase):
    """Where no event loop runs as the client is made."""

    def setUp(self):
        self.server = os.environ["CURVD_SERVER"]

    def test_a_client_belongs_to_the_event_loop_of_its_first_call(self):
        async def nothing():
            pass

        async def ask():
            return await client.health()

        asyncio.run(nothing())  # after which asyncio gives no event loop to those that ask for one
        client = aio.CurvatureClient(self.server)
        self.assertEqual(asyncio.run(ask()), "SERVING")
        with self.assertRaisesRegex(RuntimeError, "used in another event loop before; make a client for each"):
            asyncio.run(ask())
        asyncio.run(client.close())

    def test_wrong_arguments_are_refused_as_the_client_is_made(self):
        with self.assertRaisesRegex(ValueError, "port"):
            aio.CurvatureClient("localhost:0")
        with self.assertRaisesRegex(ValueError, "plain text"):
            aio.CurvatureClient("10.0.0.7:1", security=Security(token="secret"))

    def test_one_run_after_another_is_served(self):
        for _ in range(3):
            points, _ = asyncio.run(aio.estimate_curvature(*sphere(100, 1.0), server=self.server))
            self.assertEqual(len(points), 100)

    def test_a_client_that_was_never_used_can_be_closed(self):
        client = aio.CurvatureClient(self.server)
        asyncio.run(client.close())
        with self.assertRaisesRegex(ValueError, "closed"):
            asyncio.run(client.health())
