"""The contract inside the package: whole in every implementation of protobuf, and in nobody's way."""

import os
import subprocess
import sys
import tempfile
import unittest

from google.protobuf import descriptor_pb2, descriptor_pool

from curvd_client import RESULT_DTYPE, PointStatus
from curvd_client import curvature_pb2 as pb

_COLUMNS = ("mean_curvature", "gaussian_curvature", "k1", "k2", "d1", "d2", "radius", "status")


class ContractTest(unittest.TestCase):
    def test_protobuf_in_pure_python_knows_the_same_columns(self):
        self.assertEqual(RESULT_DTYPE.names, _COLUMNS)
        printed = subprocess.run(
            [sys.executable, "-c", "import curvd_client; print(*curvd_client.RESULT_DTYPE.names)"],
            env={**os.environ, "PROTOCOL_BUFFERS_PYTHON_IMPLEMENTATION": "python"},
            cwd=tempfile.gettempdir(),
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        self.assertEqual(tuple(printed.split()), _COLUMNS)

    def test_statuses_are_those_of_the_contract(self):
        values = {name.removeprefix("POINT_STATUS_"): value for name, value in pb.PointStatus.items() if value}
        self.assertEqual({status.name: status.value for status in PointStatus}, values)
        counts = {field.name.upper(): field.number for field in pb.StatusCounts.DESCRIPTOR.fields}
        self.assertEqual(counts, values)

    def test_another_contract_of_that_name_does_no_harm(self):
        other = descriptor_pb2.FileDescriptorProto(name="curvature/v1/curvature.proto", package="curvature.v1")
        other.message_type.add(name="Summary").field.add(name="something_else", number=1, label=1, type=9)
        descriptor_pool.Default().AddSerializedFile(other.SerializeToString())
        self.assertEqual(pb.Summary.FromString(pb.Summary(point_count=3).SerializeToString()).point_count, 3)
        self.assertEqual(pb.Progress.Phase.Name(pb.Progress.PHASE_QUEUED), "PHASE_QUEUED")
        self.assertEqual(pb.Estimator.Value("ESTIMATOR_JET_FITTING"), pb.ESTIMATOR_JET_FITTING)
