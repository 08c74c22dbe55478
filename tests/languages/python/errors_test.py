"""What a call raises and warns of, as programs hand it on. No server is needed."""

import copy
import pickle
import unittest

import grpc

from curvd_client import CurvdError, CurvdWarning


class ErrorsTest(unittest.TestCase):
    def test_errors_go_from_process_to_process(self):
        error = CurvdError(grpc.StatusCode.RESOURCE_EXHAUSTED, "busy", "QUEUE_FULL", {"value": "9"}, retry_after=2.5, transient=True)
        error.answered = False
        for other in (pickle.loads(pickle.dumps(error)), copy.deepcopy(error)):
            self.assertIs(type(other), CurvdError)
            self.assertEqual(str(other), "RESOURCE_EXHAUSTED: busy")
            self.assertEqual(vars(other), vars(error))

    def test_warnings_go_from_process_to_process(self):
        warning = CurvdWarning("NO_RESULTS", "no point has a result")
        for other in (pickle.loads(pickle.dumps(warning)), copy.deepcopy(warning)):
            self.assertIs(type(other), CurvdWarning)
            self.assertEqual((other.code, str(other)), ("NO_RESULTS", "no point has a result"))


if __name__ == "__main__":
    unittest.main()
