"""What is refused before a call."""

import unittest
import warnings

import grpc
import numpy as np

from clouds import sphere
from curvd_client import CurvatureClient, CurvdError, Security, aio, estimate_curvature
from curvd_client.fields import shown
from curvd_client.options import curvature_header


class ArgumentTest(unittest.TestCase):
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
            ("neighbor_count_range is (0, 64)", {**auto, "neighbor_count_range": (0, 64)}),
            ("max_radius is 0", {**auto, "max_radius": 0}),
            ("max_radius is nan", {**auto, "max_radius": float("nan")}),
            ("neighbor_count_range is '16'", {**auto, "neighbor_count_range": "16"}),
            ("neighbor_count_range is (16, 64.5)", {**auto, "neighbor_count_range": (16, 64.5)}),
        ):
            with self.subTest(options), self.assertRaises(ValueError) as refused:
                estimate_curvature(*cloud, server="127.0.0.1:1", max_attempts=1, **options)
            self.assertIn(word, str(refused.exception))

    def test_numbers_that_do_not_fit_are_named(self):
        cloud = np.zeros((4, 3)), np.zeros((4, 3))
        for name, value, limit in (
            ("neighbor_count", -1, "from 1 to 4294967295"),
            ("neighbor_count", 0, "from 1 to 4294967295"),
            ("neighbor_count", 50.5, "whole number"),
            ("neighbor_count", True, "whole number"),
            ("triangle_count", 0, "from 1 to 4294967295"),
            ("rotation_count", 0, "from 1 to 4294967295"),
            ("jet_degree", 0, "from 1 to 4294967295"),
            ("jet_degree", 2**32, "from 1 to 4294967295"),
            ("regression_degree", 0, "from 1 to 4294967295"),
            ("regression_degree", 2.5, "whole number"),
            ("seed", 2**64, "from 0 to 18446744073709551615"),
            ("radius", "1", "a number"),
            ("average_normal_weight", [1], "a number"),
            ("max_attempts", 0, "from 1 to 4294967295"),
            ("max_attempts", 1.5, "whole number"),
            ("radius", True, "a number"),
            ("radius", np.True_, "a number"),
            ("average_normal_weight", True, "a number"),
            ("neighbor_count", np.array([20]), "whole number"),
            ("timeout", float("nan"), "seconds"),
            ("timeout", 0, "seconds above 0"),
            ("timeout", -1, "seconds above 0"),
            ("timeout", True, "a number"),
            ("connect_timeout", -1, "seconds from 0"),
            ("timeout", "5", "a number"),
            ("connect_timeout", float("nan"), "seconds"),
        ):
            with self.subTest((name, value)), self.assertRaises(ValueError) as refused:
                estimate_curvature(*cloud, server="127.0.0.1:1", **{name: value})
            self.assertIn(f"{name} is {value!r}; it must be", str(refused.exception))
            self.assertIn(limit, str(refused.exception))
        for options in ({"normal_neighbor_count": -1}, {"normal_radius": "1"}):
            with self.subTest(options), self.assertRaisesRegex(ValueError, "of normals is .*; it must be a"):
                estimate_curvature(cloud[0], server="127.0.0.1:1", **options)

    def test_names_and_lists_of_other_types_are_named(self):
        for name, value, limit in (
            ("estimator", ["jet"], "one of avg-hexagram"),
            ("priority", ["batch"], "one of interactive, batch"),
            ("orientation", ["closed"], "one of consistent, closed"),
            ("quantities", 5, "a list of names"),
            ("quantities", "k1", "a list of names"),
            ("neighbor_counts", {16, 64}, "a list of numbers that ascend"),
            ("neighbor_counts", {16: 1, 64: 1}, "a list of numbers that ascend"),
            ("neighbor_counts", "16,64", "a list of numbers that ascend"),
            ("neighbor_counts", 16, "a list of numbers that ascend"),
            ("neighbor_counts", [64, 16], "a list of numbers that ascend"),
        ):
            with self.subTest((name, value)), self.assertRaises(ValueError) as refused:
                estimate_curvature(np.zeros((4, 3)), server="127.0.0.1:1", **{name: value})
            self.assertIn(f"{name} is {value!r}; it must be {limit}", str(refused.exception))
        with self.assertRaisesRegex(ValueError, "quantity 'd1' is unknown; the column comes with 'principal_directions'"):
            estimate_curvature(np.zeros((4, 3)), server="127.0.0.1:1", quantities=["d1"])
        for name, value in (("normal_method", ["pca"]), ("quantities", [["k1"]]), ("neighbor_count_range", {16, 64})):
            options = {name: value, **({"estimator": "auto"} if "range" in name else {})}
            with self.subTest(name), self.assertRaisesRegex(ValueError, "(is .*; it|is unknown; it) must be"):
                estimate_curvature(np.zeros((4, 3)), server="127.0.0.1:1", **options)

    def test_numbers_and_truth_values_of_numpy_are_taken_without_a_warning(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            header, _ = curvature_header(
                True, estimator="aso", project=np.True_, neighbor_count=np.int64(20), seed=np.uint64(1)
            )
            self.assertEqual((header.options.project, header.options.neighbor_count), (True, 20))
            header, _ = curvature_header(True, neighbor_counts=np.array([16, 64]))
            self.assertEqual(list(header.options.neighbor_counts), [16, 64])
            header, _ = curvature_header(True, radius=np.float32(0.5), quantities=("radius", "mean_curvature"))
            self.assertEqual(header.options.radius, 0.5)
            with self.assertRaisesRegex(ValueError, "neighbor_count is array"):
                curvature_header(True, neighbor_count=np.array([20]))

    def test_servers_and_channels_of_other_types_are_named(self):
        for make in (CurvatureClient, aio.CurvatureClient):
            with self.assertRaisesRegex(TypeError, r"server is \['localhost:1'\]; it must be a str .*commas"):
                make(["localhost:1"])
            with self.assertRaisesRegex(TypeError, r"channel is of type builtins.str; it must be a grpc\."):
                make(channel="x")
        with self.assertRaisesRegex(TypeError, "server is "):
            estimate_curvature(np.zeros((4, 3)), server=["localhost:1"])
        with grpc.insecure_channel("127.0.0.1:1") as channel, self.assertRaisesRegex(TypeError, "be a grpc.aio.Channel"):
            aio.CurvatureClient(channel=channel)

    def test_security_of_other_types_is_named_and_not_shown(self):
        for name, value in (("token", 54321), ("token", b"54321"), ("tls", "54321"), ("ca_file", 54321)):
            with self.subTest(name), self.assertRaisesRegex(TypeError, f"{name} of Security is of type") as refused:
                Security(**{name: value})
            self.assertNotIn("54321", str(refused.exception))

    def test_messages_stay_short(self):
        cloud, digits = np.zeros((4, 3)), 10**5
        for options in (
            {"radius": 2**2000},
            {"radius": 2**digits},
            {"neighbor_count": -(2**digits)},
            {"neighbor_counts": [1] * 1_000_000},
            {"seed": "9" * digits},
            {"estimator": ["jet"] * digits},
            {"quantities": ["radius"] * digits},
            {"quantities": ["k" * digits]},
            {"request_tag": [[[["x" * 500] * 100] * 100] * 100]},
            {"timeout": [1] * digits},
            {"server": "x" * digits + ":0"},
        ):
            with self.subTest(list(options)), self.assertRaises(ValueError) as refused:
                estimate_curvature(cloud, **{"server": "127.0.0.1:1", **options})
            self.assertIn(next(iter(options)).removesuffix("ies"), str(refused.exception))
            self.assertLess(len(str(refused.exception)), 700)
        for short in (0, -1, 2**64, 0.1, None, True, "text", (16, 64.5), {16: 64}, [["k1"]]):
            self.assertEqual(shown(short), repr(short))
        self.assertEqual(shown([2**digits]), f"[an int of {digits + 1} bits]")

    def test_a_cancel_of_another_type_is_named(self):
        with self.assertRaisesRegex(TypeError, "cancel is 'now'; it must be a Cancel"):
            estimate_curvature(np.zeros((4, 3)), np.zeros((4, 3)), server="127.0.0.1:1", cancel="now")

    def test_nobody_listening_is_unavailable(self):
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(*sphere(10, 1.0), server="127.0.0.1:1", max_attempts=2)
        self.assertEqual(caught.exception.code, grpc.StatusCode.UNAVAILABLE)
