#!/usr/bin/python3
"""What an operator finds in the log for what a caller saw: log_test.py CURVD CURV"""

import re
import subprocess
import sys
import tempfile
import unittest

import grpc

from watched_curvd import WatchedCurvd

CURVD, CURV = sys.argv[1:3]


class LogTest(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory())
        self.cloud = f"{self.folder}/torus.ply"
        subprocess.run([CURV, "generate", "torus", "--points=1000", "-o", self.cloud], check=True,
                       stdout=subprocess.DEVNULL)

    def estimate(self, server, *flags):
        return subprocess.run([CURV, "estimate", self.cloud, "-o", f"{self.folder}/out.ply",
                               f"--server={server.address}", *flags], check=False, capture_output=True, text=True)

    def test_one_line_a_call_with_phases_reason_and_bytes(self):
        with WatchedCurvd(CURVD) as server:
            self.assertEqual(self.estimate(server, "--k=20").returncode, 0)
            refused = self.estimate(server, "--k=100000")
            self.assertNotEqual(refused.returncode, 0)
        calls = {entry["code"]: entry for entry in server.log if entry["event"] == "call"}
        self.assertEqual(len(calls), 2)
        served, failed = calls["OK"], calls["RESOURCE_EXHAUSTED"]
        self.assertEqual((served["level"], served["code"], served["points"], served["points_ok"]),
                         ("info", "OK", 1000, 1000))
        self.assertGreater(served["received_bytes"], 24_000)
        self.assertGreater(served["sent_bytes"], 45_000)
        for phase in ("receive", "admit", "queue", "index", "estimate", "send"):
            self.assertLessEqual(served[f"{phase}_seconds"], served["seconds"])
        self.assertGreater(served["estimate_seconds"], 0)
        self.assertEqual((failed["level"], failed["code"], failed["reason"]),
                         ("warning", "RESOURCE_EXHAUSTED", "NEIGHBORHOOD_TOO_LARGE"))
        # What the caller reports leads to the line.
        self.assertIn(f"(request {failed['request_id']})", refused.stderr)
        self.assertNotEqual(failed["request_id"], served["request_id"])
        self.assertTrue(re.fullmatch("[0-9a-f]{8}-[0-9]+", failed["request_id"]))

    def test_no_message_puts_anything_else_into_the_log(self):
        bad_utf8_tag = b"\x0a\x03\x3a\x01\xff"
        forged_tag = b"\x0a\x0d\x3a\x0b\n{\"a\":\"b\"}\n"
        with WatchedCurvd(CURVD) as server, grpc.insecure_channel(server.address) as channel:
            estimate = channel.stream_stream("/curvature.v1.CurvatureService/EstimateCurvature")
            for message, reason in ((bad_utf8_tag, "MESSAGE_MALFORMED"), (forged_tag, "INVALID_OPTION")):
                with self.assertRaises(grpc.RpcError) as caught:
                    list(estimate(iter([message])))
                call = server.wait_for_call(reason)
                self.assertIn(f"(request {call['request_id']})", caught.exception.details())
                self.assertEqual(call["tag"], "")
        # A line that is no JSON would have ended the reading of the log.
        self.assertEqual([entry["event"] for entry in server.log], ["call", "call", "draining", "stopped"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
