"""Servers that misbehave, die, or are not there."""

import time
import unittest

import grpc

from clouds import sphere
from curvd_client import CurvdError, estimate_curvature
from curvd_client import curvature_pb2 as pb
from curvd_client.retries import Schedule
from scripted_server import packed_details, result, scripted, summary


class MisbehavingServerTest(unittest.TestCase):
    def fails_with(self, script):
        with scripted(script) as server, self.assertRaises(CurvdError) as caught:
            estimate_curvature(*sphere(10, 1.0), server=server, max_attempts=2)
        return caught.exception

    def test_breaches_of_the_protocol_are_found(self):
        breaches = {
            "starts at 5, not 4": [result(0, 4), result(5, 5), summary(10)],
            "starts at 0, not 10": [result(0, 10), result(0, 10), summary(10)],
            "up to point 11": [result(0, 11), summary(11)],
            "9 results": [result(0, 9), summary(10)],
            "summary of 9": [result(0, 10), summary(9)],
            "without a summary": [result(0, 10)],
            "status of 10 points has 9 bytes": [result(0, 10, status_bytes=9), summary(10)],
            "of 0 points": [result(0, 0), summary(10)],
        }
        for message, responses in breaches.items():
            with self.subTest(message):
                error = self.fails_with(lambda _, responses=responses: responses)
                self.assertEqual(error.code, grpc.StatusCode.INTERNAL)
                self.assertIn(message, error.message)

    def test_a_server_that_is_too_old_to_choose_a_scale_is_found(self):
        old = pb.EstimateCurvatureResponse(accepted=pb.Accepted(options=pb.EstimatorOptions(neighbor_count=50)))
        with scripted(lambda _: [old, result(0, 10), summary(10)]) as server, self.assertRaises(CurvdError) as caught:
            estimate_curvature(*sphere(10, 1.0), server=server, neighbor_count="auto", max_attempts=1)
        self.assertEqual(caught.exception.code, grpc.StatusCode.UNIMPLEMENTED)
        self.assertIn("too old to choose a scale", caught.exception.message)

    def test_a_server_that_dies_is_tried_again(self):
        for code in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.UNKNOWN, grpc.StatusCode.INTERNAL):
            with self.subTest(code.name):
                calls = []

                def die_once(context, code=code, calls=calls):
                    calls.append(code)
                    if len(calls) == 1:
                        context.abort(code, "Stream removed")
                    yield from [result(0, 10), summary(10)]

                with scripted(die_once) as server:
                    points, _ = estimate_curvature(*sphere(10, 1.0), server=server)
                self.assertEqual((len(points), len(calls)), (10, 2))

    def test_another_replica_is_tried(self):
        with scripted(lambda _: [result(0, 10), summary(10)]) as server:
            for _ in range(4):
                points, _ = estimate_curvature(*sphere(10, 1.0), server=f"127.0.0.1:1,{server}", max_attempts=2)
                self.assertEqual(len(points), 10)

    def test_a_defect_of_the_server_is_not_tried_again(self):
        calls = []

        def fail(context):
            calls.append(1)
            context.set_trailing_metadata([("grpc-status-details-bin", packed_details("ErrorInfo"))])
            context.abort(grpc.StatusCode.INTERNAL, "a defect")
            yield

        self.assertFalse(self.fails_with(fail).transient)
        self.assertEqual(len(calls), 1)

    def test_no_try_starts_after_the_timeout(self):
        began = time.monotonic()
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(*sphere(10, 1.0), server="127.0.0.1:1", timeout=1.0)
        self.assertTrue(caught.exception.transient or caught.exception.code == grpc.StatusCode.DEADLINE_EXCEEDED)
        self.assertLess(time.monotonic() - began, 5)

    def test_error_details_reach_the_caller(self):
        error = self.refused_with(packed_details())
        self.assertEqual((error.reason, error.metadata), ("MEMORY_LIMIT", {"limit": "8"}))
        self.assertEqual(error.retry_after, 1.5)

    def test_details_that_are_none_do_no_harm(self):
        self.assertEqual(self.refused_with(b"no message").reason, "")

    def refused_with(self, details):
        def refuse(context):
            context.set_trailing_metadata([("grpc-status-details-bin", details)])
            context.abort(grpc.StatusCode.RESOURCE_EXHAUSTED, "memory: 9 bytes asked, limit 8")
            yield

        error = self.fails_with(refuse)
        self.assertEqual(error.code, grpc.StatusCode.RESOURCE_EXHAUSTED)
        self.assertEqual(error.message, "memory: 9 bytes asked, limit 8")
        return error


class ScheduleTest(unittest.TestCase):
    def test_a_server_that_is_gone_is_tried_for_eight_seconds_at_most(self):
        schedule = Schedule(1, 0, reached=True, timeout=None, max_attempts=6, connect_seconds=1.5)
        gone = CurvdError(grpc.StatusCode.UNAVAILABLE, "gone", transient=True)
        gone.answered = False
        waits = []
        with self.assertRaises(CurvdError):
            while True:
                waits.append(schedule.pause_after(gone) + schedule.connect_seconds)
        self.assertEqual(len(waits), 5)
        self.assertLess(sum(waits), 8)
        self.assertGreater(sum(waits), 5)

    def test_the_pause_that_a_server_asks_for_is_kept(self):
        schedule = Schedule(2, 0, reached=False, timeout=None, max_attempts=6, connect_seconds=1.5)
        busy = CurvdError(grpc.StatusCode.RESOURCE_EXHAUSTED, "busy", retry_after=7.0, transient=True)
        self.assertEqual(schedule.pause_after(busy), 7.0)
        self.assertEqual(schedule.replica, 1)

    def test_each_replica_is_tried_however_long_the_first_kept_silent(self):
        schedule = Schedule(2, 0, reached=False, timeout=None, max_attempts=6, connect_seconds=0.0)
        silent = CurvdError(grpc.StatusCode.UNAVAILABLE, "keepalive watchdog timeout", transient=True)
        silent.answered = False
        self.assertEqual(schedule.pause_after(silent), 0.0)
        self.assertEqual(schedule.replica, 1)
        with self.assertRaises(CurvdError):
            schedule.pause_after(silent)

    def test_a_timeout_of_centuries_is_none(self):
        for timeout in (1e300, float("inf")):
            schedule = Schedule(1, 0, reached=True, timeout=timeout, max_attempts=6, connect_seconds=1.5)
            self.assertIsNone(schedule.time_left)

    def test_no_pause_goes_beyond_the_timeout(self):
        schedule = Schedule(1, 0, reached=True, timeout=5.0, max_attempts=6, connect_seconds=1.5)
        busy = CurvdError(grpc.StatusCode.RESOURCE_EXHAUSTED, "busy", retry_after=7.0, transient=True)
        with self.assertRaises(CurvdError):
            schedule.pause_after(busy)
