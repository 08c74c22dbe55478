"""The Python client against a real curvd (CURVD_SERVER) and against servers that misbehave."""

import concurrent.futures
import contextlib
import dataclasses
import os
import pathlib
import time
import unittest

import grpc
import numpy as np
from google.protobuf import any_pb2

from curvature.v1 import curvature_pb2 as pb
from curvature.v1 import curvature_pb2_grpc
from curvd_client import (
    RESULT_DTYPE,
    CurvdError,
    CurvdWarning,
    PointStatus,
    Security,
    errors,
    estimate_curvature,
    estimate_normals,
)


def sphere(point_count, radius, dtype=np.float32):
    """Positions and outward normals, evenly spread along a spiral."""
    height = 1 - (2 * np.arange(point_count) + 1) / point_count
    angle = np.pi * (3 - np.sqrt(5)) * np.arange(point_count)
    ring = np.sqrt(1 - height**2)
    normals = np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1)
    return (radius * normals).astype(dtype), normals.astype(dtype)


class RealServerTest(unittest.TestCase):
    def setUp(self):
        self.server = os.environ["CURVD_SERVER"]

    def assert_sphere(self, points, radius):
        # 20,000 points: the error of the estimate itself is far below a percent.
        np.testing.assert_allclose(points["mean_curvature"], 1 / radius, rtol=0.02)
        np.testing.assert_allclose(points["gaussian_curvature"], 1 / radius**2, rtol=0.04)
        self.assertTrue(np.all(points["k1"] <= points["k2"]))
        self.assertTrue(np.all(points["status"] == PointStatus.OK))

    def test_sphere_has_the_curvature_of_a_sphere(self):
        positions, normals = sphere(20_000, radius=2.0)
        points, summary = estimate_curvature(positions, normals, server=self.server)
        self.assertEqual(points.dtype, RESULT_DTYPE)
        self.assertEqual(len(points), 20_000)
        self.assertEqual(summary.status_counts.ok, 20_000)
        self.assert_sphere(points, 2.0)
        np.testing.assert_allclose(np.einsum("ij,ij->i", np.cross(points["d1"], points["d2"]), normals), 1, atol=1e-3)

    def test_doubles_stay_exact_far_from_the_origin(self):
        positions, normals = sphere(20_000, radius=2.0, dtype=np.float64)
        points, _ = estimate_curvature(positions + 5e6, normals, server=self.server)
        self.assert_sphere(points, 2.0)

    def test_many_chunks_of_a_strided_view_arrive_in_order(self):
        positions, normals = sphere(100_000, radius=3.0)
        both = np.concatenate([positions, normals], axis=1)
        strided, _ = estimate_curvature(both[:, :3], both[:, 3:], server=self.server)
        packed, _ = estimate_curvature(positions, normals, server=self.server)
        self.assertEqual(strided.tobytes(), packed.tobytes())

    def test_options_reach_the_server(self):
        positions, normals = sphere(2_000, radius=1.0)
        points, _ = estimate_curvature(positions, normals, server=self.server, radius=0.25, estimator="hexagram")
        self.assertTrue(np.all(points["radius"] == 0.25))

    def test_only_what_was_asked_for_comes(self):
        positions, normals = sphere(40_000, radius=2.0)
        everything, _ = estimate_curvature(positions, normals, server=self.server)
        points, _ = estimate_curvature(
            positions, normals, server=self.server, quantities=["principal_directions", "mean_curvature"]
        )
        self.assertEqual(points.dtype.names, ("mean_curvature", "d1", "d2", "status"))
        for name in points.dtype.names:
            np.testing.assert_array_equal(points[name], everything[name])

    def test_unknown_quantities_are_refused_before_a_call(self):
        positions, normals = sphere(10, radius=1.0)
        for wrong in (["curl"], ["radius", "radius"], "radius", ["unspecified"]):
            with self.subTest(wrong), self.assertRaises(ValueError):
                estimate_curvature(positions, normals, server=self.server, quantities=wrong)

    def test_no_quantities_are_all_quantities(self):
        positions, normals = sphere(100, radius=1.0)
        everything, _ = estimate_curvature(positions, normals, server=self.server)
        for none in ([], (), None):
            points, _ = estimate_curvature(positions, normals, server=self.server, quantities=none)
            np.testing.assert_array_equal(points, everything)

    def test_every_estimator_has_a_name(self):
        positions, normals = sphere(20_000, radius=2.0)
        for estimator in ("avg-hexagram", "hexagram", "delaunay", "jet", "aso", "normal-regression"):
            with self.subTest(estimator):
                points, _ = estimate_curvature(positions, normals, server=self.server, estimator=estimator)
                self.assert_sphere(points, 2.0)
        for estimator in ("uniform", "independent"):
            with self.subTest(estimator):
                _, summary = estimate_curvature(positions, normals, server=self.server, estimator=estimator)
                self.assertEqual(summary.status_counts.ok, 20_000)

    def test_a_jet_needs_as_many_neighbors_as_coefficients(self):
        positions, normals = sphere(1_000, radius=2.0)
        for degree, status in ((2, PointStatus.OK), (4, PointStatus.SINGULAR_FIT)):
            points, summary = estimate_curvature(
                positions, normals, server=self.server, estimator="jet", jet_degree=degree, neighbor_count=14
            )
            self.assertTrue(np.all(points["status"] == status))
            self.assertEqual(summary.status_counts.singular_fit, 1_000 if degree == 4 else 0)

    def test_auto_chooses_what_suits_the_cloud(self):
        positions, normals = sphere(10_000, radius=2.0)
        positions += np.random.default_rng(1).normal(scale=0.01, size=positions.shape).astype(np.float32)
        error = {}
        for estimator in ("auto", "avg-hexagram"):
            points, summary = estimate_curvature(positions, normals, server=self.server, estimator=estimator)
            self.assertEqual(summary.status_counts.ok, 10_000)
            error[estimator] = np.mean(np.abs(points["mean_curvature"] - 0.5))
            self.assertEqual(summary.HasField("scale"), estimator == "auto")
            if estimator == "auto":
                self.assertAlmostEqual(sum(outcome.share for outcome in summary.scale.outcomes), 1)
                self.assertAlmostEqual(summary.scale.position_noise, 0.01, delta=0.002)
        self.assertLess(error["auto"], 0.7 * error["avg-hexagram"])

    def test_estimator_or_scale_alone_may_be_left_open(self):
        cloud = sphere(5_000, radius=2.0)
        _, summary = estimate_curvature(
            *cloud, server=self.server, estimator="jet", neighbor_count="auto", neighbor_count_range=(64, 128)
        )
        outcomes = {(each.estimator, each.neighbor_count) for each in summary.scale.outcomes}
        self.assertEqual(outcomes, {(pb.ESTIMATOR_JET_FITTING, count) for count in (64, 91, 128)})
        _, summary = estimate_curvature(*cloud, server=self.server, estimator="auto", neighbor_count=100)
        self.assertEqual({each.neighbor_count for each in summary.scale.outcomes}, {100})

    def test_no_estimate_looks_farther_than_max_radius(self):
        cloud = sphere(5_000, radius=2.0)
        points, _ = estimate_curvature(*cloud, server=self.server, estimator="auto", max_radius=0.3)
        is_ok = points["status"] == PointStatus.OK
        self.assertGreater(np.sum(is_ok), 4_000)
        self.assertLessEqual(np.max(points["radius"][is_ok]), 0.3)
        points, _ = estimate_curvature(*cloud, server=self.server, estimator="auto", max_radius=1e-6)
        self.assertTrue(np.all(points["status"] == PointStatus.TOO_FEW_NEIGHBORS))

    def test_one_choice_for_the_whole_cloud_differs(self):
        positions, normals = sphere(5_000, radius=2.0)
        noise = np.random.default_rng(2).normal(scale=0.02, size=positions.shape)
        positions += np.where(positions[:, 2:] > 0, noise, 0).astype(np.float32)
        auto = {"server": self.server, "estimator": "auto"}
        each, _ = estimate_curvature(positions, normals, **auto)
        all_alike, _ = estimate_curvature(positions, normals, scale_per_cloud=True, **auto)
        self.assertFalse(np.array_equal(each["mean_curvature"], all_alike["mean_curvature"]))

    def test_scales_that_the_server_refuses_are_named(self):
        cloud = sphere(100, radius=1.0)
        for words, options in (
            ("it must be auto, avg-hexagram", {"estimator": "aso", "neighbor_count": "auto"}),
            ("jet_degree is 2; it must be 4", {"estimator": "jet", "neighbor_count": "auto", "jet_degree": 2}),
            ("least_neighbor_count is 15; it must be from 16", {"estimator": "auto", "neighbor_count_range": (15, 64)}),
            ("max_radius is nan", {"estimator": "auto", "max_radius": float("nan")}),
        ):
            with self.subTest(options), self.assertRaises(CurvdError) as refused:
                estimate_curvature(*cloud, server=self.server, **options)
            self.assertEqual(refused.exception.reason, "INVALID_OPTION")
            self.assertIn(words, refused.exception.message)

    def test_even_weights_reach_the_server(self):
        positions, normals = sphere(1_000, radius=2.0)
        positions[:, 2] *= 2  # an ellipsoid: on a sphere all triangles say the same
        delaunay = {"server": self.server, "estimator": "delaunay"}
        fading, _ = estimate_curvature(positions, normals, **delaunay)
        even, _ = estimate_curvature(positions, normals, even_weights=True, **delaunay)
        self.assertFalse(np.array_equal(fading["mean_curvature"], even["mean_curvature"]))

    def test_opposed_normals_are_warned_of_or_refused(self):
        positions, normals = sphere(2_000, radius=2.0)
        normals[:1_000] *= -1
        with self.assertWarns(CurvdWarning) as caught:
            points, summary = estimate_curvature(positions, normals, server=self.server)
        self.assertEqual(caught.warning.code, "OPPOSED_NORMALS")
        self.assertIn("make all normals point to one side", str(caught.warning))
        self.assertEqual(pathlib.Path(caught.filename).name, pathlib.Path(__file__).name)
        self.assertEqual(summary.warnings[0].point_count, np.sum(points["status"] == PointStatus.OPPOSED_NORMALS))
        self.assertGreater(summary.warnings[0].point_count, 0)
        self.assertEqual(summary.warnings[0].flipped_patch_count, 1)
        with self.assertRaises(CurvdError) as refused:
            estimate_curvature(positions, normals, server=self.server, reject_opposed_normals=True)
        self.assertEqual(refused.exception.reason, "OPPOSED_NORMALS")

    def test_a_cloud_without_normals_gets_them(self):
        positions, normals = sphere(20_000, radius=2.0)
        points, summary = estimate_curvature(positions, server=self.server)
        self.assertEqual(points.dtype.names, (*RESULT_DTYPE.names[:-1], "normal", "status"))
        self.assert_sphere(points, 2.0)
        np.testing.assert_allclose(points["normal"], normals, atol=0.01)
        self.assertEqual(summary.normals.closed_piece_count, 1)
        self.assertLess(summary.normals.certificate, 0.25)
        some, _ = estimate_curvature(positions, server=self.server, quantities=["mean_curvature"])
        self.assertEqual(some.dtype.names, ("mean_curvature", "status"))
        np.testing.assert_array_equal(some["mean_curvature"], points["mean_curvature"])

    def test_given_normals_are_turned_only_if_a_side_is_asked_for(self):
        positions, normals = sphere(2_000, radius=2.0)
        inward = -normals
        given, _ = estimate_curvature(positions, inward, server=self.server)
        self.assertEqual(given.dtype, RESULT_DTYPE)
        self.assertLess(np.median(given["mean_curvature"]), 0)
        for side in ({"orientation": "consistent"}, {"orientation": "closed"}):
            turned, summary = estimate_curvature(positions, inward, server=self.server, **side)
            np.testing.assert_allclose(turned["normal"], normals, atol=1e-6)
            self.assertGreater(np.median(turned["mean_curvature"]), 0)
            self.assertEqual(summary.normals.turned_count, 2_000)

    def test_normals_alone_have_quality_and_no_curvature(self):
        positions, normals = sphere(2_000, radius=2.0, dtype=np.float64)
        positions += [5e5, 5e6, 100.0]
        points, summary = estimate_normals(positions, server=self.server, method="pca", neighbor_count=12)
        self.assertEqual(points.dtype.names, ("normal", "normal_residual", "normal_variance_ratio", "status"))
        np.testing.assert_allclose(points["normal"], normals, atol=0.05)
        self.assertTrue(np.all(points["normal_residual"] < 0.2))
        self.assertEqual(summary.normals.method, pb.NORMAL_METHOD_PCA)
        self.assertEqual(summary.normals.neighbor_count, 12)
        self.assertEqual(summary.seconds.estimate, 0)
        turned, _ = estimate_normals(positions, -normals, server=self.server, orientation="closed")
        np.testing.assert_allclose(turned["normal"], normals, atol=1e-6)
        self.assertTrue(np.all(np.isnan(turned["normal_residual"])))

    def test_sides_follow_viewpoints_and_directions(self):
        positions, normals = sphere(2_000, radius=2.0)
        ask = {"server": self.server, "neighbor_count": 12}
        np.testing.assert_allclose(estimate_normals(positions, viewpoint=[0, 0, 0], **ask)[0]["normal"], -normals, atol=0.1)
        outside = 3 * positions
        seen, _ = estimate_normals(positions, viewpoint=outside, **ask)
        np.testing.assert_allclose(seen["normal"], normals, atol=0.1)
        down, _ = estimate_normals(positions, direction=(0, 0, -1), **ask)
        self.assertTrue(np.all(down["normal"][:, 2] <= 0))

    def test_sides_that_cannot_be_trusted_are_warned_of(self):
        # A Moebius strip, which has one side alone.
        random = np.random.default_rng(4)
        around, across = random.uniform(0, 2 * np.pi, 4_000), random.uniform(-0.4, 0.4, 4_000)
        radius = 1 + across * np.cos(around / 2)
        strip = np.stack([radius * np.cos(around), radius * np.sin(around), across * np.sin(around / 2)], axis=1)
        with self.assertWarns(CurvdWarning) as caught:
            _, summary = estimate_normals(strip, server=self.server, orientation="closed")
        self.assertEqual(caught.warning.code, "DOUBTFUL_ORIENTATION")
        self.assertEqual(pathlib.Path(caught.filename).name, pathlib.Path(__file__).name)
        self.assertTrue(summary.normals.doubtful)

    def test_arguments_for_normals_that_make_no_sense_are_refused_before_a_call(self):
        positions, normals = sphere(10, radius=1.0)
        for word, wrong in (
            ("exclude", {"orientation": "closed", "direction": (0, 0, 1)}),
            ("orientation is 'up'", {"orientation": "up"}),
            ("viewpoint has shape (2,)", {"viewpoint": (1, 2)}),
            ("10 positions but 9 viewpoints", {"viewpoint": positions[:9]}),
            ("goes with normals=None", {"normals": normals, "method": "pca"}),
            ("method of normals is 'best'", {"method": "best"}),
            ("exclude", {"neighbor_count": 10, "radius": 1.0}),
        ):
            with self.subTest(wrong), self.assertRaises(ValueError) as refused:
                estimate_normals(positions, server=self.server, **wrong)
            self.assertIn(word, str(refused.exception))

    def test_a_viewpoint_that_is_no_place_is_named(self):
        positions, _ = sphere(10, radius=1.0)
        with self.assertRaises(CurvdError) as refused:
            estimate_normals(positions, server=self.server, viewpoint=(0, float("nan"), 0))
        self.assertEqual(refused.exception.reason, "INVALID_OPTION")
        self.assertIn("header.normals.viewpoint", refused.exception.message)

    def test_priorities_do_not_change_a_byte(self):
        positions, normals = sphere(1_000, radius=2.0)
        first, *others = (
            estimate_curvature(positions, normals, server=self.server, priority=priority).points.tobytes()
            for priority in (None, "interactive", "batch")
        )
        self.assertEqual(others, [first, first])

    def test_empty_cloud_gives_an_empty_result(self):
        points, summary = estimate_curvature(np.zeros((0, 3)), np.zeros((0, 3)), server=self.server)
        self.assertEqual((len(points), summary.point_count), (0, 0))

    def test_invalid_point_is_named_in_the_error(self):
        positions, normals = sphere(1_000, radius=1.0)
        positions[123, 1] = np.nan
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(positions, normals, server=self.server)
        self.assertEqual(caught.exception.code, grpc.StatusCode.INVALID_ARGUMENT)
        self.assertIn("123", caught.exception.message)
        self.assertNotEqual(caught.exception.reason, "")
        # What leads to the line in the server's log is in the message itself.
        self.assertIn(f"(request {caught.exception.metadata['request_id']})", str(caught.exception))

    def test_invalid_point_is_skipped_on_request(self):
        positions, normals = sphere(1_000, radius=1.0)
        positions[123, 1] = np.nan
        points, summary = estimate_curvature(positions, normals, server=self.server, skip_invalid=True)
        self.assertEqual(points["status"][123], PointStatus.INVALID_INPUT)
        self.assertTrue(np.isnan(points["mean_curvature"][123]))
        self.assertEqual(summary.status_counts.invalid_input, 1)

    def test_bad_option_is_refused(self):
        positions, normals = sphere(100, radius=1.0)
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(positions, normals, server=self.server, neighbor_count=2)
        self.assertEqual(caught.exception.code, grpc.StatusCode.INVALID_ARGUMENT)
        self.assertIn("neighbor_count", caught.exception.message)

    def test_deadline_ends_the_call(self):
        positions, normals = sphere(100_000, radius=1.0)
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(positions, normals, server=self.server, timeout=0.001)
        self.assertEqual(caught.exception.code, grpc.StatusCode.DEADLINE_EXCEEDED)


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

    def test_the_token_is_not_shown(self):
        self.assertNotIn(self.security.token, repr(self.security))


class ArgumentTest(unittest.TestCase):
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

    def test_arrays_that_make_no_cloud_are_refused(self):
        for positions, normals in [
            (np.zeros((4, 2)), np.zeros((4, 2))),
            (np.zeros(12), np.zeros(12)),
            (np.zeros((4, 3)), np.zeros((5, 3))),
        ]:
            with self.assertRaises(ValueError):
                estimate_curvature(positions, normals)

    def test_options_that_exclude_each_other_are_refused(self):
        cloud = np.zeros((4, 3)), np.zeros((4, 3))
        for options in [{"estimator": "best"}, {"neighbor_count": 9, "radius": 1.0}, {"priority": "now"}]:
            with self.assertRaises(ValueError):
                estimate_curvature(*cloud, **options)

    def test_scales_that_make_no_sense_are_refused_before_a_call(self):
        cloud = np.zeros((4, 3)), np.zeros((4, 3))
        need, auto = "need neighbor_count", {"estimator": "auto"}
        for word, options in (
            (need, {"neighbor_count_range": (16, 64)}),
            (need, {"max_radius": 1.0}),
            (need, {"scale_per_cloud": True}),
            (need, {**auto, "neighbor_count": 50, "max_radius": 1.0}),
            ("'auto'", {"neighbor_count": "some"}),
            ("radius does not go with", {**auto, "radius": 1.0}),
            ("radius does not go with", {"neighbor_count": "auto", "radius": 1.0}),
            ("neighbor_count_range is 64", {**auto, "neighbor_count_range": 64}),
            ("neighbor_count_range is (64,)", {**auto, "neighbor_count_range": (64,)}),
            ("neighbor_count_range is (-1, 64)", {**auto, "neighbor_count_range": (-1, 64)}),
            ("neighbor_count_range is '16'", {**auto, "neighbor_count_range": "16"}),
            ("neighbor_count_range is (16, 64.5)", {**auto, "neighbor_count_range": (16, 64.5)}),
        ):
            with self.subTest(options), self.assertRaises(ValueError) as refused:
                estimate_curvature(*cloud, server="127.0.0.1:1", max_attempts=1, **options)
            self.assertIn(word, str(refused.exception))

    def test_nobody_listening_is_unavailable(self):
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(*sphere(10, 1.0), server="127.0.0.1:1", max_attempts=2)
        self.assertEqual(caught.exception.code, grpc.StatusCode.UNAVAILABLE)


class ScriptedServer(curvature_pb2_grpc.CurvatureServiceServicer):
    """Reads the whole cloud, then plays a script."""

    def __init__(self, script):
        self._script = script

    def EstimateCurvature(self, request_iterator, context):
        for _ in request_iterator:
            pass
        yield from self._script(context)


@contextlib.contextmanager
def scripted(script):
    server = grpc.server(concurrent.futures.ThreadPoolExecutor(2))
    curvature_pb2_grpc.add_CurvatureServiceServicer_to_server(ScriptedServer(script), server)
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    yield f"127.0.0.1:{port}"
    server.stop(0)


def result(first, count, status_bytes=None):
    status = b"\1" * (count if status_bytes is None else status_bytes)
    return pb.EstimateCurvatureResponse(result=pb.ResultChunk(first_index=first, point_count=count, status=status))


def summary(count):
    return pb.EstimateCurvatureResponse(summary=pb.Summary(point_count=count))


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


def packed_details(*only):
    """A google.rpc.Status with an ErrorInfo, a RetryInfo and a detail that nobody knows, or `only` some of them."""
    messages = errors._MESSAGES
    info = messages["google.rpc.ErrorInfo"](reason="MEMORY_LIMIT", domain="curvd", metadata={"limit": "8"})
    retry = messages["google.rpc.RetryInfo"]()
    retry.retry_delay.seconds, retry.retry_delay.nanos = 1, 500_000_000
    status = messages["google.rpc.Status"](code=8)
    for name, value in [
        ("ErrorInfo", info.SerializeToString()),
        ("RetryInfo", retry.SerializeToString()),
        ("Unknown", b"?"),
    ]:
        if only and name not in only:
            continue
        detail = any_pb2.Any(type_url=f"type.googleapis.com/google.rpc.{name}", value=value)
        status.details.add().MergeFromString(detail.SerializeToString())
    return status.SerializeToString()


if __name__ == "__main__":
    unittest.main()
