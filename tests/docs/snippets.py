#!/usr/bin/python3
"""Runs the code in a Markdown file as its reader would.

snippets.py extract DOCUMENT LANGUAGE OUTPUT    writes the blocks of one language to a file
snippets.py run DOCUMENT SOURCE_DIR BUILD_DIR   runs all blocks, in order, from a folder that looks like a built clone

What a block is for stands after its language:
  sh            commands; must succeed
  sh clone      the same, for a clone alone: who has installed packages types other commands
  sh server     starts curvd, which then serves the blocks that follow
  sh install    commands that change the machine; not run here
  python, js    programs; must succeed
  cpp           a program that the build has made, in BUILD_DIR/bin/docs_snippet
Where no block starts a server, one serves them all. `buf` is found where `make proto-check` puts it.
Blocks of other kinds (text, json, ...) are only shown. The default ports are replaced with free ones.
"""

import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

DEFAULT_PORTS = ("50061", "9461")
DEFAULT_SERVER = "build/release/bin/curvd --listen=127.0.0.1:50061 --metrics-listen=127.0.0.1:9461"
BLOCK_SECONDS = 120
START_SECONDS = 30


def blocks(document):
    """Yields (kind, code) of each fenced block; kind is what stands after the fence, such as "sh server"."""
    text = pathlib.Path(document).read_text(encoding="utf-8")
    for match in re.finditer(r"^```([^\n]*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield match[1].strip(), match[2]


def extract(document, language, output):
    code = [code for kind, code in blocks(document) if kind == language]
    if not code:
        sys.exit(f"{document} has no {language} block")
    pathlib.Path(output).write_text("\n".join(code), encoding="utf-8")


def reserve_port():
    """Returns a socket that holds a free port, and its number, until it is closed. The system gives the port to nobody else;
    curvd, which asks for SO_REUSEADDR as this socket does, and listens, which it does not, may still have it."""
    holder = socket.socket()
    holder.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    holder.bind(("127.0.0.1", 0))
    return holder, str(holder.getsockname()[1])


class Reader:
    """Somebody who types the blocks, in one folder, against one server."""

    def __init__(self, folder, source_dir):
        self._folder = folder
        self._holders, self._ports = [], {}
        for default in DEFAULT_PORTS:
            holder, self._ports[default] = reserve_port()
            self._holders.append(holder)
        self._server = None
        self._path = f"{source_dir}/build/tools/buf/node_modules/.bin:{os.environ['PATH']}"

    def _own_ports(self, code):
        for default, own in self._ports.items():
            code = code.replace(default, own)
        return code

    def copy(self, document):
        """Puts a document into the folder, with this reader's ports."""
        text = self._own_ports(document.read_text(encoding="utf-8"))
        (self._folder / document.name).write_text(text, encoding="utf-8")

    def type(self, kind, code):
        code = self._own_ports(code)
        shell = ["bash", "-euo", "pipefail", "-c", code]
        address = f"localhost:{self._ports['50061']}"
        if kind == "sh server":
            self._server = subprocess.Popen(["bash", "-c", "exec " + code.strip()], cwd=self._folder)
            self._run(["bash", "-c", f"until build/release/bin/curv info --server={address}; do sleep 0.1; done"],
                      START_SECONDS)
        elif kind in ("sh", "sh clone"):
            self._run(shell)
        elif kind == "python":
            self._run(["/usr/bin/python3", "-c", code], environment={"PYTHONPATH": "build/release/python"})
        elif kind == "js":
            script = self._folder / "snippet.mjs"
            script.write_text(code, encoding="utf-8")
            self._run(["node", str(script)])
        elif kind == "cpp":
            self._run(["build/release/bin/docs_snippet", address])
        else:
            return
        print(f"--- ran: {kind}\n{code}", flush=True)

    def _run(self, command, seconds=BLOCK_SECONDS, environment=None):
        subprocess.run(command, cwd=self._folder, stdin=subprocess.DEVNULL, timeout=seconds, check=True,
                       env={**os.environ, "PATH": self._path, **(environment or {})})

    def leave(self):
        """Stops the server and gives its ports back. Exits with an error if it was not there or did not end well."""
        for holder in self._holders:
            holder.close()
        if self._server is None:
            sys.exit("no block started a server")
        self._server.send_signal(signal.SIGTERM)
        if self._server.wait(60) != 0:
            sys.exit(f"curvd ended with {self._server.returncode}")


def run(document, source_dir, build_dir):
    with tempfile.TemporaryDirectory() as folder:
        clone = pathlib.Path(folder)
        for name in ("client", "proto", "deploy", "tests"):
            (clone / name).symlink_to(pathlib.Path(source_dir) / name)
        (clone / "build").mkdir()
        (clone / "build" / "release").symlink_to(build_dir)
        reader = Reader(clone, source_dir)
        reader.copy(pathlib.Path(source_dir) / "README.md")
        began = time.monotonic()
        try:
            if not any(kind == "sh server" for kind, _ in blocks(document)):
                reader.type("sh server", DEFAULT_SERVER)
            for kind, code in blocks(document):
                reader.type(kind, code)
        finally:
            reader.leave()
        print(f"{document}: all blocks ran in {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    {"extract": extract, "run": run}[sys.argv[1]](*sys.argv[2:])
