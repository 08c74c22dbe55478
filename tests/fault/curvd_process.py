"""A curvd process under test, and what can be seen of it from outside."""

import os
import re
import signal
import subprocess
import threading
import time
import urllib.request

START_SECONDS = 30


class Curvd:
    """Serves on ports that the system picks, or on those of `like`, a process that has ended. Usable with `with`."""

    def __init__(self, binary, *flags, like=None, environment=None, wrap=(), before_exec=None):
        listen, metrics = (like.address, like.metrics_address) if like else ("127.0.0.1:0", "127.0.0.1:0")
        self.lines = []
        self._changed = threading.Condition()
        self.process = subprocess.Popen(
            [*wrap, binary, f"--listen={listen}", f"--metrics-listen={metrics}", *flags],
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, **(environment or {})},
            preexec_fn=before_exec,
        )
        threading.Thread(target=self._read_log, daemon=True).start()
        line = self.wait_for_line('"event":"serving"', START_SECONDS)
        self.address = re.search(r'"listen":"([^"]*)"', line).group(1)
        self.metrics_address = re.search(r'"metrics_listen":"([^"]*)"', line).group(1)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()

    def _read_log(self):
        for line in self.process.stderr:
            with self._changed:
                self.lines.append(line)
                self._changed.notify_all()

    def wait_for_line(self, text, seconds=START_SECONDS):
        """The first log line that holds `text`, once there is one."""
        with self._changed:
            found = self._changed.wait_for(lambda: next((line for line in self.lines if text in line), None), seconds)
        if found is None:
            raise AssertionError(f"curvd logged no {text} within {seconds} s: {self.lines[-3:]}")
        return found

    def metric(self, series):
        """The value of `series`, written as in a scrape; 0 if there is none."""
        with urllib.request.urlopen(f"http://{self.metrics_address}/metrics", timeout=START_SECONDS) as answer:
            for line in answer.read().decode().splitlines():
                name, _, value = line.rpartition(" ")
                if name == series:
                    return float(value)
        return 0.0

    def metric_or_none(self, series):
        """The same; None if the process no longer answers."""
        try:
            return self.metric(series)
        except OSError:
            return None

    def is_idle(self):
        idle = ("curvd_streams_open", "curvd_memory_reserved_bytes", 'curvd_queue_jobs{queue="memory"}')
        return all(self.metric(series) == 0 for series in (*idle, "curvd_workers_busy"))

    def wait_until_idle(self, seconds=60):
        wait_for(self.is_idle, seconds, "curvd is not idle again")

    def alive(self):
        return self.process.poll() is None

    def signal(self, number):
        self.process.send_signal(number)

    def kill(self):
        self.process.kill()
        self.process.wait()

    def drain(self, seconds=60):
        """Ends it politely; returns the exit status."""
        self.signal(signal.SIGTERM)
        return self.process.wait(seconds)

    def lines_field(self, name):
        """What the line "serving" says of the port `name`."""
        return re.search(rf'"{name}":"([^"]*)"', self.wait_for_line('"event":"serving"')).group(1)

    def forget_peak(self):
        """peak_resident_bytes begins anew."""
        with open(f"/proc/{self.process.pid}/clear_refs", "w") as clear:
            clear.write("5")

    def peak_resident_bytes(self):
        with open(f"/proc/{self.process.pid}/status") as status:
            return next(int(line.split()[1]) << 10 for line in status if line.startswith("VmHWM"))

    def resident_bytes(self):
        with open(f"/proc/{self.process.pid}/statm") as statm:
            return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def wait_for(condition, seconds, complaint):
    """Returns the seconds until condition() is true. AssertionError with `complaint` if it stays false."""
    began = time.monotonic()
    while not condition():
        if time.monotonic() - began > seconds:
            raise AssertionError(f"{complaint} after {seconds} s")
        time.sleep(0.005)
    return time.monotonic() - began
