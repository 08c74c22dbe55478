#!/usr/bin/python3
"""Runs a command against a curvd of its own: with_curvd.py CURVD COMMAND...

The command finds the server's HOST:PORT in CURVD_SERVER. Exits with the command's status, or 1 if curvd did not start
or did not drain to exit code 0 at SIGTERM.
"""

import os
import re
import signal
import subprocess
import sys
import threading

START_SECONDS = 30
DRAIN_SECONDS = 60


def start(curvd):
    """Starts curvd on a free port. Returns the process and its address once it says that it listens."""
    process = subprocess.Popen(
        [curvd, "--listen=127.0.0.1:0", "--metrics-listen=127.0.0.1:0"], stderr=subprocess.PIPE, text=True
    )
    watchdog = threading.Timer(START_SECONDS, process.kill)
    watchdog.start()
    for line in process.stderr:
        sys.stderr.write(line)
        address = re.search(r"127\.0\.0\.1:([1-9]\d*)", line)
        if address:
            watchdog.cancel()
            # Nobody may block curvd by not reading its log.
            threading.Thread(target=lambda: sys.stderr.writelines(process.stderr), daemon=True).start()
            return process, address.group()
    sys.exit(f"{curvd} ended with {process.wait()} before it listened")


def main():
    curvd, *command = sys.argv[1:]
    process, address = start(curvd)
    try:
        status = subprocess.run(command, env={**os.environ, "CURVD_SERVER": address}, check=False).returncode
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            drained = process.wait(DRAIN_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            drained = process.wait()
    if drained != 0:
        sys.exit(f"curvd ended with {drained} after SIGTERM")
    sys.exit(status)


if __name__ == "__main__":
    main()
