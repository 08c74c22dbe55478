"""A curvd on free ports, and what its metrics port exports."""

import json
import re
import subprocess
import threading
import time
import urllib.request

START_SECONDS = 60


class WatchedCurvd:
    """Runs from `with` on; says so if it does not drain to exit code 0."""

    def __init__(self, curvd):
        self._process = subprocess.Popen([curvd, "--listen=127.0.0.1:0", "--metrics-listen=127.0.0.1:0"],
                                         stderr=subprocess.PIPE, text=True)
        watchdog = threading.Timer(START_SECONDS, self._process.kill)
        watchdog.start()
        for line in self._process.stderr:
            entry = json.loads(line)
            if entry.get("event") == "serving":
                self.address, self.metrics_address = entry["listen"], entry["metrics_listen"]
                break
        else:
            raise RuntimeError(f"{curvd} did not start to serve")
        watchdog.cancel()
        self.log = []  # entries that follow
        self._reader = threading.Thread(target=self._read_log, daemon=True)
        self._reader.start()

    def _read_log(self):
        for line in self._process.stderr:
            self.log.append(json.loads(line))

    def wait_for_call(self, reason):
        """The log's entry of the call that failed for that reason, once it is there."""
        deadline = time.monotonic() + START_SECONDS
        while time.monotonic() < deadline and self._reader.is_alive():
            for entry in list(self.log):
                if entry.get("reason") == reason:
                    return entry
            time.sleep(0.01)
        raise AssertionError(f"no call with reason {reason} in {self.log}")

    def stop(self):
        """Drains the server. Returns its exit status; the log is complete then."""
        self._process.terminate()
        status = self._process.wait(60)
        self._reader.join()
        self._process.stderr.close()
        return status

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        status = self.stop()
        if status != 0 and kind is None:
            raise RuntimeError(f"curvd ended with {status}")

    def exported(self):
        """Every exported metric, as a dict from name to a dict from label to the set of its values."""
        with urllib.request.urlopen(f"http://{self.metrics_address}/metrics", timeout=30) as answer:
            text = answer.read().decode()
        metrics = {}
        for name, labels in re.findall(r"^([a-z_]+)(?:\{(.*)\})? \S+$", text, re.MULTILINE):
            values = metrics.setdefault(name, {})
            for label, value in re.findall(r'([a-z_]+)="([^"]*)"', labels):
                values.setdefault(label, set()).add(value)
        return metrics
