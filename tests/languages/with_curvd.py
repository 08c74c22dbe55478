#!/usr/bin/python3
"""Runs a command against two curvds of its own: with_curvd.py CURVD COMMAND...

The command finds the HOST:PORT of one that takes calls of everybody in CURVD_SERVER. In CURVD_SECURE_SERVER it finds that
of one that asks for TLS, a client certificate and a token, and in CURVD_SECURE_DIR the files server.crt, client.crt,
client.key and token that it needs there. Exits with the command's status, or 1 if a curvd did not start or did not drain
to exit code 0 at SIGTERM.
"""

import hashlib
import os
import pathlib
import re
import secrets
import signal
import subprocess
import sys
import tempfile
import threading

START_SECONDS = 30
DRAIN_SECONDS = 60


def start(curvd, *flags):
    """Starts curvd on a free port. Returns the process and its address once it says that it listens."""
    process = subprocess.Popen(
        [curvd, "--listen=127.0.0.1:0", "--metrics-listen=127.0.0.1:0", *flags], stderr=subprocess.PIPE, text=True
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


def stop(process):
    """Returns curvd's exit status after SIGTERM."""
    process.send_signal(signal.SIGTERM)
    try:
        return process.wait(DRAIN_SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def make_secrets(folder):
    """Fills `folder` with what the secure server and its clients need. Returns the server's flags."""
    for name in ("server", "client"):
        subprocess.run(
            ["openssl", *"req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2".split()]
            + ["-subj", f"/CN={name}", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1"]
            + ["-keyout", folder / f"{name}.key", "-out", folder / f"{name}.crt"],
            check=True,
            capture_output=True,
        )
    token = secrets.token_hex(32)
    (folder / "token").write_text(token, encoding="utf-8")
    (folder / "tokens").write_text(f"tester sha256:{hashlib.sha256(token.encode()).hexdigest()}\n", encoding="utf-8")
    return [
        f"--tls-cert={folder}/server.crt",
        f"--tls-key={folder}/server.key",
        f"--tls-client-ca={folder}/client.crt",
        f"--token-file={folder}/tokens",
    ]


def main():
    curvd, *command = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        secure_flags = make_secrets(pathlib.Path(folder))
        process, address = start(curvd)
        secure_process, secure_address = start(curvd, *secure_flags)
        environment = {
            "CURVD_PROGRAM": curvd,
            "CURVD_SERVER": address,
            "CURVD_SECURE_SERVER": secure_address,
            "CURVD_SECURE_DIR": folder,
        }
        try:
            status = subprocess.run(command, env={**os.environ, **environment}, check=False).returncode
        finally:
            drained = [stop(each) for each in (process, secure_process)]
    if any(drained):
        sys.exit(f"the curvds ended with {drained} after SIGTERM")
    sys.exit(status)


if __name__ == "__main__":
    main()
