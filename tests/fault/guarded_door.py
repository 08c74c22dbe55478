"""A server that strangers attack by HTTP/2, and a caller with a token who must be served beside."""

import contextlib
import hashlib
import json
import pathlib
import statistics
import subprocess
import sys
import time

import grpc
from curvd_process import wait_for
from fault import Trial
from raw_calls import cloud_requests
from stranger_faults import Authority

INSIDERS_TOKEN = "curvd_insider_" + "7" * 51
ESTIMATE = "/curvature.v1.CurvatureService/EstimateCurvature"
CHECK = "/grpc.health.v1.Health/Check"
_TOKEN = "curvd_friend_" + "7" * 52
_MIB = 1 << 20
_MEMORY_LIMIT_MIB = 256
_MOST_OVER_LIMIT_MIB = 64
_MOST_TIMES_IDLE = 10
_LONGEST_ATTACK = 120
_LINES_A_SECOND = 20
_REASONS = ("unaccounted_bytes", "too_much_metadata", "memory_short")


class Door:
    """A curvd that asks for a token, over TLS or not, with a health port; and a caller who has the token.

    front(curvd): the address of a proxy before the server `curvd`, if callers shall come through one.
    """

    def __init__(self, site, opened, tls=False, flags=(), front=None):
        folder = pathlib.Path(site.scratch) / f"door-{time.monotonic_ns()}"
        folder.mkdir()
        tokens = folder / "tokens"
        tokens.write_text("".join(
            f"{name} sha256:{hashlib.sha256(token.encode()).hexdigest()}\n"
            for name, token in (("the-friend", _TOKEN), ("the-insider", INSIDERS_TOKEN))), encoding="utf-8")
        self.ca = None
        if tls:
            authority = Authority(folder / "authority")
            certificate, key = authority.issue("localhost")
            flags, self.ca = [*flags, f"--tls-cert={certificate}", f"--tls-key={key}"], authority.certificate
        self.server = opened.enter_context(site.server(
            f"--memory-limit={_MEMORY_LIMIT_MIB}MiB", f"--token-file={tokens}", "--health-listen=127.0.0.1:0", *flags))
        self.health_address = self.server.lines_field("health_listen")
        self.address = front(self) if front else self.server.address
        self._channel = opened.enter_context(
            grpc.secure_channel(self.address, grpc.ssl_channel_credentials(self.ca.read_bytes()))
            if tls else grpc.insecure_channel(self.address))
        self._messages = list(cloud_requests(1_000))
        for _ in range(20):
            self.call()
        self.idle = statistics.median(self.call() for _ in range(50))

    def call(self):
        """The friend has 1,000 points estimated; returns the seconds that it took."""
        began = time.monotonic()
        metadata = [("authorization", f"Bearer {_TOKEN}")]
        call = self._channel.stream_stream(ESTIMATE)
        assert list(call(iter(self._messages), metadata=metadata, timeout=60, wait_for_ready=True))
        return time.monotonic() - began

    def ended(self):
        """Connections that the guard has ended."""
        return sum(self.server.metric(f'curvd_strangers_total{{reason="{reason}"}}') for reason in _REASONS)

    def _strangers_logged(self, lines):
        return sum('"event":"stranger"' in line for line in self.server.lines[lines:])

    def attack(self, name, *flags, health=False, may_stay=False, counts=True):
        """Runs an attack of http2_attacks.py while the friend calls; returns its result, and the Trial.

        may_stay: connections may outlive the attack. counts: the server must have ended, counted and logged some.
        """
        ended, lines = self.ended(), len(self.server.lines)
        self.server.forget_peak()
        began = time.monotonic()
        program = pathlib.Path(__file__).parent / "http2_attacks.py"
        attack = subprocess.Popen(
            [sys.executable, program, name, self.health_address if health else self.address, *flags,
             *(["--tls", self.ca] if self.ca and not health else [])],
            stdout=subprocess.PIPE, text=True)
        beside = [self.call()]
        while attack.poll() is None:
            beside.append(self.call())
            if time.monotonic() - began > _LONGEST_ATTACK:
                attack.kill()
                raise AssertionError(f"{name} was not over after {_LONGEST_ATTACK} s")
        seconds = time.monotonic() - began
        result = json.loads(attack.communicate()[0])
        over = self.server.peak_resident_bytes() / _MIB - _MEMORY_LIMIT_MIB
        median, longest = statistics.median(beside) / self.idle, max(beside) / self.idle
        left = 0 if may_stay else result["tried"] - result["closed"]
        print(f"{name} {' '.join(flags)}: {over:+.0f} MiB over the limit; calls beside {median:.1f} times idle, "
              f"longest {longest:.0f} times, idle {self.idle * 1e3:.1f} ms; ended after {result['longest']} s",
              file=sys.stderr)
        broken = self._broken(over, median, left) or (self._untold(ended, lines, seconds) if counts else "")
        return result, Trial(result["longest"], over, median, longest, broken)

    def _untold(self, ended, lines, seconds):
        """What is wrong with what the server told of connections that it ended, since there were so many, and lines."""
        try:
            told = "nothing was counted or logged"
            wait_for(lambda: self.ended() > ended and self._strangers_logged(lines) > 0, 10, told)
        except AssertionError as error:
            return str(error)
        logged = self._strangers_logged(lines)
        return f"{logged} lines in {seconds:.0f} s" if logged > _LINES_A_SECOND * (seconds + 2) else ""

    @staticmethod
    def _broken(over, median, left):
        if left > 0:
            return f"{left} connections were left open"
        if over >= _MOST_OVER_LIMIT_MIB:
            return f"{over:.0f} MiB over the limit"
        if median >= _MOST_TIMES_IDLE:
            return f"calls took {median:.1f} times as long as when idle"
        return ""


def attack_trials(name, *flags, tls=False, health=False, may_stay=False):
    """Trials of an attack: memory stays bounded, the friend is served, and the attacker's connections end.

    may_stay: they may also stay, within their rations.
    """

    def trials(site, times):
        with contextlib.ExitStack() as opened:
            door = Door(site, opened, tls)
            for _ in range(times):
                yield door.attack(name, *flags, health=health, may_stay=may_stay)[1]

    return trials
