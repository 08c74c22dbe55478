#!/usr/bin/python3
"""Kills servers, workers and drivers while engines estimate tiles: kill_trial.py --programs DIR [--kills N] [ENGINE...]

Each round begins a plan anew, kills with SIGKILL at random moments what it draws, lets the engine end, and compares the merged
result with that of one estimate of the whole cloud. PYTHONPATH names the package curvd_client. Prints a table. Exits with 1 if a
byte differs, a result was written again, or more tiles were begun again than were at hand when something was killed.
"""

import argparse
import collections
import pathlib
import random
import sys
import tempfile
import time

from engines import ENGINES
from tile_site import TileSite

_ROUND_SECONDS = 900
_VICTIMS = ("server", "worker", "driver")


class Round:
    """One plan, from nothing done to all."""

    def __init__(self, site, engine, draw, most_kills):
        self._site, self._engine, self._random, self._most = site, engine, draw, most_kills
        self.kills = collections.Counter()
        self.at_hand = 0  # tiles, summed over the kills
        self.again = 0
        self._kept = {}

    def _kill(self):
        victim = self._random.choice(_VICTIMS)
        begun, at_hand = self._site.begun_tiles(), self._site.tiles_at_hand()
        self._note_results()
        if victim == "server":
            self._site.kill_server(self._random.randrange(2))
            killed = True
        else:
            kill = self._engine.kill_driver if victim == "driver" else self._engine.kill_worker
            killed = kill(self._random)
        if killed:
            self.kills[victim] += 1
            # A tile that was begun since may have been killed as well.
            self.at_hand += at_hand + self._site.begun_tiles() - begun

    def _note_results(self):
        results = self._site.results()
        for name, about in self._kept.items():
            assert results.get(name) == about, f"{name} was done, and written again"
        self._kept = results

    def run(self):
        self._site.begin()
        self._engine.start()
        give_up = time.monotonic() + _ROUND_SECONDS
        # A kill each time that some tiles more are begun, so that a round has all its kills on any machine.
        between = max(1.0, self._site.tiles / (self._most + 1))
        next_kill = self._random.uniform(1, between)
        while len(self._kept) < self._site.tiles:
            assert time.monotonic() < give_up, f"{len(self._site.left())} tiles are left after {_ROUND_SECONDS} s"
            if self.kills.total() < self._most and len(self._site.results()) >= next_kill:
                time.sleep(self._random.uniform(0, 0.3))
                self._kill()
                next_kill += self._random.uniform(0.5, 1.5) * between
            self._engine.revive()
            self._note_results()
            time.sleep(0.02)
        self.again = self._site.begun_tiles() - self._site.tiles
        assert self.again <= self.at_hand, f"{self.again} tiles were begun again; {self.at_hand} were at hand at kills"
        self._site.check()


def try_engine(engine_class, site, scratch, kills, draw):
    total, rounds, at_hand, again, began = collections.Counter(), 0, 0, 0, time.monotonic()
    with engine_class(site, scratch) as engine:
        while total.total() < kills:
            trial = Round(site, engine, draw, min(12, kills - total.total()))
            trial.run()
            rounds += 1
            total += trial.kills
            at_hand += trial.at_hand
            again += trial.again
            print(f"{engine.name}: {total.total()} of {kills} kills, {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    counts = " | ".join(str(total[victim]) for victim in _VICTIMS)
    return f"| {engine_class.name} | {rounds} | {counts} | {at_hand} | {again} | 0 |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="directory of curvd and curv")
    parser.add_argument("--kills", type=int, default=35, help="for each engine")
    parser.add_argument("--points", type=int, default=50_000)
    parser.add_argument("--tile-points", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 1_000_000)
    parser.add_argument("engines", nargs="*", help="only these, by the first word of their names")
    options = parser.parse_args()
    chosen = [each for each in ENGINES if not options.engines or each.name in options.engines]
    print(f"seed {options.seed}", flush=True)
    rows, tiles = [], 0
    for engine_class in chosen:
        missing = engine_class.missing()
        if missing:
            rows.append(f"| {engine_class.name} | not tried: no {missing} | | | | | | |")
            continue
        with tempfile.TemporaryDirectory(prefix="curv-engines-") as scratch:
            with TileSite(options.programs, scratch, options.points, options.tile_points) as site:
                rows.append(try_engine(engine_class, site, pathlib.Path(scratch), options.kills, random.Random(options.seed)))
                tiles = site.tiles
                print(rows[-1], file=sys.stderr, flush=True)
    print(f"\n{options.points:,} points in {tiles} tiles\n")
    print("| engine | rounds | servers killed | workers | drivers | tiles at hand then | begun again | bytes that differ |")
    print("| --- | --: | --: | --: | --: | --: | --: | --: |")
    print("\n".join(rows))


if __name__ == "__main__":
    main()
