"""What every trial of an engine uses: a cloud with its plan, two servers, and the bytes of one estimate of the whole cloud."""

import os
import pathlib
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "fault"))

from curvd_process import Curvd

# A tile is to take long enough to be hit. Draws depend on the ids of points, which tiles must keep.
_ESTIMATE = ("--estimator=uniform", "--triangles=2000", "--k=60")

# Stands for curv on the engines' PATH: notes beside a plan's directory which of its tiles are begun that have no result yet, and
# becomes curv.
_WRAPPER = """\
#!/bin/sh
work= tile=
for word; do
  case $word in
    {scratch}/work-*) work=$word ;;
    --tile=*) tile=${{word#--tile=}} ;;
  esac
done
[ -z "$tile" ] || [ -e "$work/results/$(printf 'tile-%06d' "$tile")" ] || echo "$tile" >>"$work.begun"
exec "{curv}" "$@"
"""


class TileSite:
    """Directories, programs, servers. Usable with `with`."""

    def __init__(self, programs, scratch, points, tile_points):
        self.scratch = pathlib.Path(scratch)
        self.programs = pathlib.Path(programs).resolve()
        self.curv_binary = str(self.programs / "curv")
        self.work = None  # the directory of the plan that is under way
        self.servers = []
        self._begins = 0
        bin_folder = self.scratch / "bin"
        bin_folder.mkdir()
        wrapper = bin_folder / "curv"
        wrapper.write_text(_WRAPPER.format(scratch=self.scratch, curv=self.curv_binary), encoding="ascii")
        wrapper.chmod(0o755)
        self.environment = {"PATH": f"{bin_folder}:{os.environ['PATH']}"}
        self.cloud, whole = self.scratch / "cloud.ply", self.scratch / "whole.ply"
        self.curv("generate", "goursat", f"--points={points}", "--noise-position=0.05", "--noise-normal=0.1", "-o", self.cloud)
        self.curv("estimate", self.cloud, "-o", whole, "--threads=1", *_ESTIMATE)
        self.expected = whole.read_bytes()
        self.curv("tiles", "plan", self.cloud, "-o", self.scratch / "plan", f"--tile-points={tile_points}", *_ESTIMATE)
        self.tiles = len(self._left(self.scratch / "plan"))

    def __enter__(self):
        for _ in range(2):
            self.servers.append(self._server())
        return self

    def __exit__(self, *_):
        for server in self.servers:
            server.kill()

    @property
    def addresses(self):
        return ",".join(server.address for server in self.servers)

    def _server(self, like=None):
        return Curvd(str(self.programs / "curvd"), "--threads=1", like=like)

    def kill_server(self, number):
        """Kills it, and starts another at its address, as a supervisor does."""
        self.servers[number].kill()
        self.servers[number] = self._server(like=self.servers[number])

    def curv(self, *arguments):
        done = subprocess.run([self.curv_binary, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"curv {arguments} ended with {done.returncode}: {done.stderr}"
        return done.stdout

    def _left(self, directory):
        return self.curv("tiles", "status", directory, "--left").split()

    def begin(self):
        """A directory of its own with the plan, in which nothing is done.

        What an engine has left of an earlier one, such as a task that Slurm puts back when all its tiles are done, then finds that one.
        """
        self._begins += 1
        self.work = self.scratch / f"work-{self._begins}"
        shutil.copytree(self.scratch / "plan", self.work)
        self._begun.write_text("", encoding="ascii")

    def left(self):
        return self._left(self.work)

    @property
    def _begun(self):
        return self.work.with_suffix(".begun")

    def begun_tiles(self):
        return len(self._begun.read_text(encoding="ascii").split())

    def results(self):
        """What tells a file of results from one that was written again, by name."""
        kept = {}
        for entry in os.scandir(self.work / "results"):
            if entry.name.startswith("tile-") and "." not in entry.name:
                about = entry.stat()
                kept[entry.name] = (about.st_ino, about.st_mtime_ns)
        return kept

    def at_work(self):
        """The processes that estimate a tile of this site's, and which; one that waits for another counts as well."""
        found = {}
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                words = pathlib.Path("/proc", pid, "cmdline").read_bytes().split(b"\0")
                program = os.readlink(f"/proc/{pid}/exe")
            except OSError:
                continue
            is_tile = b"tiles" in words and b"run" in words and str(self.work).encode() in words
            if program == self.curv_binary and is_tile:
                found[int(pid)] = next(word.decode() for word in words if word.startswith(b"--tile="))
        return found

    def tiles_at_hand(self):
        """Tiles that were begun and have no result: also those whose process is about to become curv."""
        begun = {f"tile-{int(tile):06d}" for tile in self._begun.read_text(encoding="ascii").split()}
        return len(begun - self.results().keys())

    def check(self):
        """AssertionError unless all is done, with the bytes of the whole cloud."""
        out = self.scratch / "merged.ply"
        self.curv("tiles", "verify", self.work)
        self.curv("tiles", "merge", self.work, "-o", out)
        assert out.read_bytes() == self.expected, "tiles and whole cloud have other bytes"
        out.unlink()


def wait_for(condition, seconds, complaint):
    give_up = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < give_up, f"{complaint} after {seconds} s"
        time.sleep(0.05)
