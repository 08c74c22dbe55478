#!/usr/bin/python3
"""Runs `curv tiles` with real servers, kills what takes part, and compares with one estimate of the whole cloud.

  tiles_test.py CURV CURVD
"""

import json
import math
import os
import pathlib
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

CURV, CURVD = sys.argv[1:3]
OK, FAILED, USAGE, INPUT, OUTPUT, UNAVAILABLE = 0, 1, 2, 3, 4, 5
POINTS = 20_000


def curv(*arguments, code=OK, **how):
    done = subprocess.run([CURV, *arguments], capture_output=True, text=True, timeout=120, check=False, **how)
    if done.returncode != code:
        raise AssertionError(f"curv {' '.join(arguments)}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout if code == OK else done.stderr


class Server:
    """A curvd on a port of its own choice, or on a given one."""

    def __init__(self, port=0, *flags):
        command = [CURVD, f"--listen=127.0.0.1:{port}", "--metrics-listen=none", "--threads=1", *flags]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            found = re.search(r"127\.0\.0\.1:([1-9][0-9]*)", line)
            if found:
                self.port = int(found[1])
                break
        self.address = f"127.0.0.1:{self.port}"

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.process.stderr.close()


class Tiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="curv-tiles-"))
        cls.cloud = str(cls.folder / "cloud.ply")
        curv("generate", "goursat", f"--points={POINTS}", "--noise-position=0.1", "--noise-normal=0.1", "-o", cls.cloud)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def setUp(self):
        self.work = str(self.folder / "work")
        self.result = str(self.folder / "tiled.ply")
        self.addCleanup(shutil.rmtree, self.work, ignore_errors=True)

    def plan(self, *flags, cloud=None, code=OK):
        return curv("tiles", "plan", cloud or self.cloud, "-o", self.work, "--tile-points=2000", *flags, code=code)

    def status(self):
        return json.loads(curv("tiles", "status", self.work, "--json"))

    def whole(self, *flags):
        path = str(self.folder / "whole.ply")
        curv("estimate", self.cloud, "-o", path, *flags)
        return pathlib.Path(path).read_bytes()

    def merged(self):
        curv("tiles", "verify", self.work)
        curv("tiles", "merge", self.work, "-o", self.result)
        return pathlib.Path(self.result).read_bytes()

    def test_has_the_bytes_of_the_whole_cloud_however_wide_the_halo(self):
        for flags in ((), ("--estimator=hexagram", "--k=40"), ("--estimator=uniform",), ("--estimator=jet", "--radius=0.6"),
                      ("--estimator=aso", "--k=30"), ("--estimator=delaunay", "--k=31")):
            whole = self.whole(*flags)
            for halo in ("0", "0.5", "1.25"):
                with self.subTest(flags=flags, halo=halo):
                    shutil.rmtree(self.work, ignore_errors=True)
                    self.plan(*flags)
                    outcome = json.loads(curv("tiles", "run", self.work, f"--halo={halo}", "--summary=json"))
                    self.assertEqual(outcome["points"], POINTS)
                    self.assertEqual(self.merged(), whole)
                    if halo == "0":
                        self.assertGreater(outcome["uncertain_points"], 1000)
                    if halo == "1.25":
                        self.assertLess(outcome["uncertain_points"], 2000)

    def test_the_statuses_are_those_of_the_whole_cloud(self):
        cloud = str(self.folder / "flawed.ply")
        header, end, points = pathlib.Path(self.cloud).read_bytes().partition(b"end_header\n")
        self.assertIn(b"format binary_little_endian 1.0\n", header)
        self.assertRegex(header, rb"vertex [0-9]+\nproperty float x\n")
        pathlib.Path(cloud).write_bytes(header + end + struct.pack("<f", math.nan) + points[4:])
        flags = ("--radius=0.35", "--on-invalid=skip")
        wanted = curv("estimate", cloud, "-o", str(self.folder / "whole.ply"), *flags)
        counts = json.loads(curv("estimate", cloud, "-o", str(self.folder / "whole.ply"), *flags, "--summary=json"))["status"]
        self.assertEqual(counts["invalid_input"], 1)
        self.assertGreater(counts["too_few_neighbors"], 100)
        self.assertGreater(min(counts["ok"], counts["degenerate_area"]), 100)
        self.plan(*flags, cloud=cloud)
        curv("tiles", "run", self.work)
        out = str(self.folder / "tiled.ply")
        text = curv("tiles", "merge", self.work, "-o", out)
        self.assertIn(f"{POINTS:,} points\n  ok ", text)
        self.assertEqual(text.splitlines()[1:5], wanted.splitlines()[1:5])
        merged = json.loads(curv("tiles", "merge", self.work, "-o", out, "--summary=json"))
        self.assertEqual((merged["points"], merged["status"]), (POINTS, counts))
        tiled = ("estimate", cloud, "-o", out, "--tiles", *flags)
        self.assertEqual(curv(*tiled).splitlines()[1:5], wanted.splitlines()[1:5])
        self.assertEqual(json.loads(curv(*tiled, "--summary=json"))["status"], counts)

    def test_every_column_and_all_inputs_come_back_in_their_order(self):
        second = str(self.folder / "second.csv")
        curv("estimate", self.cloud, "-o", second)
        curv("tiles", "plan", second, second, "-o", self.work, "--tile-points=3000", "--memory=16MiB", "--quantities=mean")
        curv("tiles", "run", self.work)
        out = str(self.folder / "both.csv")
        merge = subprocess.run([CURV, "tiles", "merge", self.work, "-o", out], capture_output=True, text=True, check=True)
        self.assertRegex(merge.stderr, r"note: left out columns that are named like results: mean_curvature, .*, status\n")
        lines = pathlib.Path(out).read_text(encoding="ascii").splitlines()
        self.assertEqual(lines[0].split(",")[:8], ["x", "y", "z", "nx", "ny", "nz", "mean_curvature", "status"])
        self.assertEqual(len(lines), 1 + 2 * POINTS)
        first = pathlib.Path(second).read_text(encoding="ascii").splitlines()[1].split(",")
        for at in (1, 1 + POINTS):
            self.assertEqual([float(v) for v in lines[at].split(",")[:3]], [float(v) for v in first[:3]])

    def test_columns_that_are_not_alike_throughout_are_left_out_before_anything_is_estimated(self):
        cells_of = self.folder / "cells.csv"
        curv("generate", "goursat", f"--points={POINTS}", "-o", str(cells_of))
        rows = cells_of.read_text(encoding="ascii").splitlines()
        late = [("", "3") if i < POINTS // 2 else ("tree", "2.5") for i in range(POINTS)]
        early = [("tree", "3") if i % 5000 == 0 else (str(i % 7), "3") for i in range(POINTS)]
        for name, cells, notes in (("late", late, ("class: it holds words", "status: its values are not all")),
                                   ("early", early, ("class: it holds words",))):
            mixed = self.folder / f"{name}.csv"
            lines = [rows[0] + ",class,status"] + [f"{row},{word},{code}" for row, (word, code) in zip(rows[1:], cells)]
            mixed.write_text("\n".join(lines) + "\n", encoding="ascii")
            plan = subprocess.run([CURV, "tiles", "plan", str(mixed), "-o", self.work, "--memory=16MiB"],
                                  capture_output=True, text=True, check=True)
            for note in notes:
                self.assertIn(f"left out column {note}", plan.stderr)
            curv("tiles", "run", self.work)
            out = self.folder / "mixed-result.csv"
            curv("tiles", "merge", self.work, "-o", str(out))
            with open(out, encoding="ascii") as result:
                self.assertNotIn("class", result.readline())
                self.assertEqual(sum(1 for _ in result), POINTS)
            shutil.rmtree(self.work)

    def test_resumes_after_kills_of_run_and_server(self):
        whole = self.whole()
        self.plan()
        server = Server()
        self.addCleanup(lambda: server.kill())
        kills = 0
        results = pathlib.Path(self.work, "results")
        while not self.status()["complete"]:
            # The first run is killed as soon as it begins a result; others once they begin the next or the one after, so that
            # they end some.
            until = len(os.listdir(results)) + kills % 3
            run = subprocess.Popen([CURV, "tiles", "run", self.work, f"--server={server.address}", "--jobs=1"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while run.poll() is None and len(os.listdir(results)) <= until:
                pass
            run.send_signal(signal.SIGKILL)
            run.wait()
            kills += 1
            if kills == 2:  # the next run finds another server at the address
                server.kill()
                server = Server(server.port)
        self.assertGreaterEqual(kills, 3)
        self.assertEqual(self.merged(), whole)
        leftover = [name for name in os.listdir(self.work) if name.startswith("spill")]
        self.assertEqual(leftover, [])

    def test_two_runs_at_once_share_the_tiles(self):
        whole = self.whole()
        self.plan()
        runs = [subprocess.Popen([CURV, "tiles", "run", self.work, "--threads=1", "--summary=json"],
                                 stdout=subprocess.PIPE, text=True) for _ in range(2)]
        outcomes = [json.loads(run.communicate(timeout=120)[0]) for run in runs]
        self.assertEqual([run.returncode for run in runs], [OK, OK])
        self.assertEqual(sum(outcome["points"] for outcome in outcomes), POINTS)
        self.assertEqual(self.merged(), whole)
        again = json.loads(curv("tiles", "run", self.work, "--summary=json"))
        self.assertEqual(again["tiles"], 0)

    def test_does_one_tile(self):
        self.plan()
        curv("tiles", "run", self.work, "--tile=1")
        self.assertEqual(self.status()["tiles_done"], 1)
        tiles = self.status()["tiles"]
        left = curv("tiles", "status", self.work, "--left").split()
        self.assertEqual(left, [str(tile) for tile in range(tiles) if tile != 1])
        self.assertIn("there is no tile 999", curv("tiles", "run", self.work, "--tile=999", code=USAGE))
        self.assertIn("is not done", curv("tiles", "merge", self.work, "-o", self.result, code=INPUT))

    def test_finds_damaged_results_and_makes_them_again(self):
        whole = self.whole()
        self.plan()
        curv("tiles", "run", self.work)
        flipped, short = (pathlib.Path(self.work, "results", f"tile-00000{tile}") for tile in (0, 1))
        content = bytearray(flipped.read_bytes())
        content[-5] ^= 1
        flipped.write_bytes(content)
        short.write_bytes(short.read_bytes()[:-1])
        verified = subprocess.run([CURV, "tiles", "verify", self.work, "--json"], capture_output=True, check=False)
        self.assertEqual(verified.returncode, INPUT)
        self.assertEqual([fault["tile"] for fault in json.loads(verified.stdout)["damaged"]], [0, 1])
        self.assertIn("tile-000001: it has", curv("tiles", "merge", self.work, "-o", self.result, code=INPUT))
        curv("tiles", "run", self.work)
        self.assertIn("checksum", curv("tiles", "merge", self.work, "-o", self.result, code=INPUT))
        flipped.unlink()
        curv("tiles", "run", self.work)
        self.assertEqual(self.merged(), whole)

    def test_a_full_disk_ends_with_an_error_and_the_run_goes_on_later(self):
        whole = self.whole()
        self.plan()

        def small_files():
            # A result may not be as large as this: writing fails as on a full disk, with another reason.
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

        message = curv("tiles", "run", self.work, code=OUTPUT, preexec_fn=small_files)
        self.assertIn("cannot write", message)
        self.assertEqual(self.status()["tiles_damaged"], 0)
        self.assertEqual(sorted(os.listdir(pathlib.Path(self.work, "results"))), [])
        curv("tiles", "run", self.work)
        self.assertEqual(self.merged(), whole)

    @unittest.skipUnless(os.getuid() == 0, "only root mounts file systems")
    def test_a_disk_that_fills_up_ends_each_step_with_an_error_and_all_goes_on_when_there_is_room(self):
        disk = self.folder / "disk"
        disk.mkdir(exist_ok=True)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", disk], capture_output=True, check=False).returncode:
            self.skipTest("no file system may be mounted here")
        self.addCleanup(subprocess.run, ["umount", "--lazy", disk], check=True)
        self.work, self.result = str(disk / "work"), str(disk / "tiled.ply")
        filler = disk / "filler"

        def fill(free):
            filler.unlink(missing_ok=True)
            room = os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize
            filler.write_bytes(bytes(room - free))

        whole = self.whole()
        fill(300_000)
        self.assertIn("No space left on device", self.plan(code=OUTPUT))
        filler.unlink()
        self.plan()
        fill(400_000)  # for some results, and not for all
        message = curv("tiles", "run", self.work, code=OUTPUT)
        self.assertRegex(message, r"results/tile-\d{6}.*No space left on device")
        stopped = self.status()
        self.assertGreater(stopped["tiles_done"], 0)
        self.assertFalse(stopped["complete"])
        self.assertEqual(stopped["tiles_damaged"], 0)
        filler.unlink()
        again = json.loads(curv("tiles", "run", self.work, "--summary=json"))
        self.assertEqual(again["tiles"], stopped["tiles"] - stopped["tiles_done"])
        fill(200_000)
        self.assertIn("No space left on device", curv("tiles", "merge", self.work, "-o", self.result, code=OUTPUT))
        self.assertFalse(os.path.exists(self.result))
        filler.unlink()
        self.assertEqual(self.merged(), whole)

    def test_refuses_what_no_tile_can_decide(self):
        for flags, word in ((["--auto"], "--auto"), (["--k=auto"], "--k=auto"), (["--normals=estimate"], "curv normals"),
                            (["--orient"], "curv orient"), (["--estimator=delaunay", "--k=20"], "31"),
                            (["--estimator=delaunay", "--radius=1"], "31")):
            with self.subTest(flags=flags):
                self.assertIn(word, self.plan(*flags, code=USAGE))
        self.assertFalse(os.path.exists(self.work))

    def test_refuses_inputs_whose_coordinates_have_other_types(self):
        text = self.folder / "doubles.xyz"
        text.write_text("".join(f"{i} {i * i} 0 0 0 1\n" for i in range(9)), encoding="utf-8")
        said = curv("tiles", "plan", self.cloud, str(text), "-o", self.work, code=INPUT)
        self.assertIn("doubles.xyz: its column x is float64, and float32 in the inputs before it", said)

    def test_the_help_of_plan_has_no_flag_that_it_refuses(self):
        flags = set(re.findall(r"^ +(?:-o,)?(--[a-z-]+)", curv("tiles", "plan", "--help"), re.MULTILINE))
        self.assertIn("--radius", flags)
        for flag in ("--auto", "--k-range", "--max-radius", "--per-cloud", "--normals", "--orient", "--up", "--normal-k"):
            self.assertNotIn(flag, flags)
        self.assertIn("--up", self.plan("--up", code=USAGE))

    def test_refuses_changed_inputs_and_used_directories(self):
        copy = str(self.folder / "copy.ply")
        shutil.copyfile(self.cloud, copy)
        self.plan(cloud=copy)
        self.assertIn("has a plan already", self.plan(cloud=copy, code=USAGE))
        curv("tiles", "run", self.work)
        os.utime(copy, (1, 1))
        self.assertIn("has changed", curv("tiles", "merge", self.work, "-o", self.result, code=INPUT))

    def test_damaged_options_name_the_plan(self):
        self.plan()
        path = pathlib.Path(self.work, "plan.json")
        plan = json.loads(path.read_text(encoding="utf-8"))
        plan["options"]["project"] = 1
        path.write_text(json.dumps(plan), encoding="utf-8")
        self.assertIn("plan.json: the plan's options: project is neither true nor false",
                      curv("tiles", "run", self.work, code=INPUT))

    def test_points_that_are_not_usable_get_a_status_or_are_refused(self):
        lines = [f"{i % 50} {i // 50} {'nan' if i == 777 else 0} 0 0 {0 if i == 5 else 1}" for i in range(2500)]
        cloud = str(self.folder / "holes.xyz")
        pathlib.Path(cloud).write_text("# x y z nx ny nz\n" + "\n".join(lines), encoding="ascii")
        self.assertIn("point 5 has a normal without a direction", self.plan(cloud=cloud, code=INPUT))
        self.plan("--on-invalid=skip", "--estimator=jet", cloud=cloud)
        curv("tiles", "run", self.work)
        out = str(self.folder / "holes.csv")
        curv("tiles", "merge", self.work, "-o", out)
        words = [line.rsplit(",", 1)[1] for line in pathlib.Path(out).read_text(encoding="ascii").splitlines()[1:]]
        self.assertEqual([i for i, word in enumerate(words) if word == "invalid_input"], [5, 777])

    def test_coordinates_beyond_what_a_server_takes_are_refused(self):
        cloud = str(self.folder / "beyond.csv")
        lines = [f"{i % 50},{i // 50},{'1e300' if i == 777 else 0},0,0,1" for i in range(2500)]
        pathlib.Path(cloud).write_text("x,y,z,nx,ny,nz\n" + "\n".join(lines), encoding="ascii")
        self.assertIn("point 777 has a coordinate beyond 3e38", self.plan(cloud=cloud, code=INPUT))

    def test_lattices_that_no_server_takes_are_refused(self):
        cloud = str(self.folder / "doubles.ply")
        curv("generate", "sphere", "--points=500", "--double", "-o", cloud)
        for spacing in ("1e-300", "1e300"):
            error = self.plan(f"--lattice={spacing}", cloud=cloud, code=INPUT)
            self.assertRegex(error, r"is [\d.]+e[-+]?\d+ \(--lattice\); it must be from 2\^-100 to 2\^100")
            shutil.rmtree(self.work)
        small = self.folder / "small.csv"
        lines = ["x,y,z,nx,ny,nz"] + [f"{i % 30}e-40,{i // 30}e-40,0,0,0,1" for i in range(900)]
        small.write_text("\n".join(lines) + "\n", encoding="ascii")
        self.assertIn("of the distance between points; it must be from", self.plan(cloud=str(small), code=INPUT))

    def test_doubles_have_the_same_bytes_for_other_tiles(self):
        far = str(self.folder / "far.csv")
        table = str(self.folder / "near.csv")
        curv("generate", "goursat", "--points=5000", "-o", table)
        rows = [line.split(",") for line in pathlib.Path(table).read_text(encoding="ascii").splitlines()]
        for row in rows[1:]:
            row[0], row[1] = repr(float(row[0]) + 512_000.0), repr(float(row[1]) + 5_400_000.0)
        # One point far from all others takes no digits from them.
        rows.append(["9e7", "9e7", "9e7", "0", "0", "1", *rows[1][6:]])
        pathlib.Path(far).write_text("\n".join(",".join(row) for row in rows), encoding="ascii")
        results = []
        for points, halo in (("1000", "1.25"), ("2400", "0.3")):
            curv("tiles", "plan", far, "-o", self.work, f"--tile-points={points}", "--estimator=jet", "--quantities=mean")
            curv("tiles", "run", self.work, f"--halo={halo}")
            curv("tiles", "merge", self.work, "-o", self.result)
            results.append(pathlib.Path(self.result).read_bytes())
            shutil.rmtree(self.work)
        self.assertEqual(results[0], results[1])

    def test_says_in_how_many_tiles_normals_do_not_fit(self):
        cloud = self.folder / "placeholders.xyz"
        curv("generate", "sphere", f"--points={POINTS}", "-o", str(cloud))
        rows = [line.split()[:3] + ["0", "0", "1"] for line in cloud.read_text().splitlines() if line[0] in "-.0123456789"]
        cloud.write_text("".join(" ".join(row) + "\n" for row in rows))
        self.plan(cloud=str(cloud))
        outcome = json.loads(curv("tiles", "run", self.work, "--summary=json"))
        self.assertGreater(outcome["tiles_with_normals_off_surface"], 5)
        self.assertEqual(self.status()["tiles_with_normals_off_surface"], outcome["tiles_with_normals_off_surface"])
        self.assertIn("tiles whose normals do not fit the positions", curv("tiles", "status", self.work))

    def test_says_that_no_server_answers(self):
        self.plan()
        started = time.monotonic()
        message = curv("tiles", "run", self.work, "--server=127.0.0.1:1", "--connect-timeout=0.3", code=UNAVAILABLE)
        self.assertIn("UNAVAILABLE", message)
        self.assertLess(time.monotonic() - started, 30)

    def test_metrics_are_those_of_the_status(self):
        self.plan()
        curv("tiles", "run", self.work, "--tile=0")
        out = str(self.folder / "curv.prom")
        curv("tiles", "status", self.work, f"--prometheus={out}")
        text = pathlib.Path(out).read_text(encoding="ascii")
        self.assertRegex(text, r'(?m)^curv_tiles_done\{plan="[0-9a-f]{16}"\} 1$')
        self.assertIn("nobody works", curv("tiles", "status", self.work))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
