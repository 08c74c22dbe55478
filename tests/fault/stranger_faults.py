"""Those who should stay out: each must be refused or bounded, logged and counted, while a friend is served."""

import contextlib
import hashlib
import pathlib
import resource
import socket
import subprocess
import threading
import time

import grpc
from curvd_process import wait_for
from fault import Fault

_FRIENDS_TOKEN = "curvd_friend_" + "7" * 52
_CROWD = 10_000
_REFUSED_CALLS = 1_000
_RELOADS = 'curvd_credential_reloads_total{result="ok"}'
_INFO = "/curvature.v1.CurvatureService/GetServerInfo"
_ESTIMATE = "/curvature.v1.CurvatureService/EstimateCurvature"
_CROWD_ADDRESS = "127.0.0.2"


class Authority:
    """Makes certificates in a folder of its own, with the openssl program."""

    def __init__(self, folder):
        self._folder = folder
        folder.mkdir()
        self.certificate = folder / "ca.crt"
        (folder / "index").touch()
        (folder / "config").write_text(
            f"[ca]\ndefault_ca=a\n[a]\ndatabase={folder}/index\nnew_certs_dir={folder}\nrand_serial=yes\n"
            "default_md=sha256\nunique_subject=no\npolicy=p\n[p]\ncommonName=supplied\n",
            encoding="utf-8",
        )
        self._openssl(
            *"req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=authority".split(),
            *("-keyout", folder / "ca.key", "-out", self.certificate),
        )

    def issue(self, name, days_left=2):
        """Paths of a certificate for `name`, and of its key. It has expired if days_left is below 0."""
        certificate, key = self._folder / f"{name}{days_left}.crt", self._folder / f"{name}{days_left}.key"
        request, extensions = self._folder / "request", self._folder / "extensions"
        extensions.write_text(f"subjectAltName=DNS:{name},IP:127.0.0.1\n", encoding="utf-8")
        self._openssl(
            *f"req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN={name}".split(),
            *("-keyout", key, "-out", request),
        )
        start, end = (
            time.strftime("%Y%m%d%H%M%SZ", time.gmtime(time.time() + days * 86_400)) for days in (-10, days_left)
        )
        self._openssl(
            *("ca", "-batch", "-notext", "-config", self._folder / "config", "-cert", self.certificate),
            *("-keyfile", self._folder / "ca.key", "-in", request, "-out", certificate, "-extfile", extensions),
            *("-startdate", start, "-enddate", end),
        )
        return certificate, key

    @staticmethod
    def _openssl(*arguments):
        subprocess.run(["openssl", *map(str, arguments)], check=True, capture_output=True)


class Fort:
    """A curvd that asks for a certificate, a name and a token, and a friend who has them."""

    def __init__(self, site, folder, *flags):
        self._site = site
        self.authority = Authority(folder / "authority")
        self.tokens, self.friends_token = folder / "tokens", self._write(folder / "friend.token", _FRIENDS_TOKEN)
        self.friend = self.authority.issue("friend")
        certificate, key = self.authority.issue("localhost")
        self.write_tokens()
        self.server = site.server(
            f"--tls-cert={certificate}",
            f"--tls-key={key}",
            f"--tls-client-ca={self.authority.certificate}",
            f"--tls-client-names={self._write(folder / 'names', 'friend')}",
            f"--token-file={self.tokens}",
            *flags,
        )

    @staticmethod
    def _write(path, text):
        path.write_text(text + "\n", encoding="utf-8")
        return path

    def write_tokens(self, **others):
        lines = [f"{name} sha256:{hashlib.sha256(token.encode()).hexdigest()}"
                 for name, token in {"the-friend": _FRIENDS_TOKEN, **others}.items()]
        self._write(self.tokens.with_suffix(".new"), "\n".join(lines)).rename(self.tokens)

    def flags(self, certificate=None, token_file=None):
        """curv's, for a caller who shows these."""
        shown = [f"--cert={certificate[0]}", f"--key={certificate[1]}"] if certificate else []
        return [f"--ca={self.authority.certificate}", *shown, f"--token-file={token_file or self.friends_token}"]

    def ask(self, *flags):
        """Runs `curv info`; returns its exit code and what it said."""
        run = subprocess.run(
            [self._site.curv_binary, "info", f"--server={self.server.address}", "--timeout=20", *flags],
            capture_output=True, text=True, check=False, timeout=60,
        )
        return run.returncode, run.stdout + run.stderr

    def serve_friend(self):
        """The friend's estimate must write what an undisturbed run writes."""
        self._site.check(self._site.estimate(self.server.address, *self.flags(self.friend)))

    def count(self, series):
        return self.server.metric(series)


@contextlib.contextmanager
def _fort(site, *flags):
    folder = pathlib.Path(site.scratch) / f"fort-{time.monotonic_ns()}"
    folder.mkdir()
    fort = Fort(site, folder, *flags)
    with fort.server:
        yield fort


def _refused(site, times, series, log, attack):
    """Trials in which attack(fort, trial) is refused, counted in `series` and logged with the words `log`."""
    with _fort(site) as fort:
        for trial in range(times):
            before, logged = fort.count(series), sum(log in line for line in fort.server.lines)
            began = time.monotonic()
            attack(fort, trial)
            wait_for(lambda: fort.count(series) > before, 30, f"{series} did not count")
            wait_for(lambda: sum(log in line for line in fort.server.lines) > logged, 30, f"no line with {log}")
            fort.serve_friend()
            yield time.monotonic() - began
        assert not any(_FRIENDS_TOKEN in line for line in fort.server.lines), "a token in the log"


def _stranger(reason):
    return f'curvd_strangers_total{{reason="{reason}"}}', f'"reason":"{reason}"'


def _failure(reason):
    return f'curvd_failures_total{{reason="{reason}"}}', f'"reason":"{reason}"'


def _refuse(fort, words, *flags):
    code, said = fort.ask(*flags)
    assert code != 0, "a stranger came in"
    assert words in said, f"curv said: {said}"


def no_certificate(site, times):
    yield from _refused(site, times, *_stranger("no_call"),
                        lambda fort, _: _refuse(fort, "--cert", *fort.flags()))


def expired_certificate(site, times):
    def attack(fort, _):
        _refuse(fort, "UNAVAILABLE", *fort.flags(fort.authority.issue("friend", -1)))

    yield from _refused(site, times, *_stranger("no_call"), attack)


def wrong_name(site, times):
    def attack(fort, _):
        _refuse(fort, "CLIENT_NOT_ALLOWED", *fort.flags(fort.authority.issue("mallory")))

    yield from _refused(site, times, *_failure("CLIENT_NOT_ALLOWED"), attack)


def wrong_token(site, times):
    def attack(fort, trial):
        guess = site.scratch / "guess.token"
        guess.write_text(f"curvd_guess_{trial}", encoding="utf-8")
        _refuse(fort, "TOKEN_INVALID", *fort.flags(fort.friend, guess))

    yield from _refused(site, times, *_failure("TOKEN_INVALID"), attack)


def revoked_token(site, times):
    def attack(fort, trial):
        token = site.scratch / "bob.token"
        token.write_text(f"curvd_bob_{trial}", encoding="utf-8")
        fort.write_tokens(bob=token.read_text(encoding="utf-8"))
        flags = fort.flags(fort.friend, token)
        wait_for(lambda: fort.ask(*flags)[0] == 0, 30, "a new token does not work")
        fort.write_tokens()
        wait_for(lambda: fort.ask(*flags)[0] != 0, 30, "a revoked token works")
        _refuse(fort, "TOKEN_INVALID", *flags)

    yield from _refused(site, times, *_failure("TOKEN_INVALID"), attack)


def plain_text(site, times):
    yield from _refused(site, times, *_stranger("no_call"), lambda fort, _: _refuse(fort, "--tls"))


def oversized_header(site, times):
    def attack(fort, _):
        ca, key, certificate = (path.read_bytes() for path in (fort.authority.certificate, fort.friend[1],
                                                               fort.friend[0]))
        credentials = grpc.ssl_channel_credentials(ca, key, certificate)
        with grpc.secure_channel(fort.server.address, credentials) as channel:
            call = channel.unary_unary(_INFO)
            with contextlib.suppress(grpc.RpcError):
                call(b"", metadata=[("filler", "x" * 20_000)], timeout=20)
                raise AssertionError("a header of 20 kB came in")

    yield from _refused(site, times, *_stranger("no_call"), attack)


def idle_connections(site, times):
    """10,000 connections that say nothing. Few stay, a friend is served meanwhile, and memory comes back."""
    host, limit = _CROWD_ADDRESS, 100
    # All connect within the time that a handshake may take, else the first make room for others: it took 11 s when busy.
    with _fort(site, "--handshake-timeout=10m") as fort:
        fort.serve_friend()
        port = int(fort.server.address.rpartition(":")[2])
        refused = 'curvd_strangers_total{reason="peer_connection_limit"}'
        for _ in range(times):
            before, began = fort.count(refused), time.monotonic()
            with contextlib.ExitStack() as opened:
                for _ in range(_CROWD):
                    opened.enter_context(contextlib.closing(
                        socket.create_connection(("127.0.0.1", port), 30, source_address=(host, 0))))
                wait_for(lambda: fort.count(refused) - before >= _CROWD - limit, 60, "the crowd was not bounded")
                assert fort.count("curvd_connections_open") <= limit + 10
                fort.serve_friend()
                yield time.monotonic() - began
            wait_for(lambda: fort.count("curvd_connections_open") == 0, 60, "connections stay open")
        wait_for(lambda: any("peer_connection_limit" in line for line in fort.server.lines), 30, "nothing was logged")


def refused_calls(site, times):
    """A flood of calls without a token: the log must not grow with it, and the friend is served."""
    with _fort(site) as fort:
        ca, key, certificate = (path.read_bytes() for path in (fort.authority.certificate, fort.friend[1],
                                                               fort.friend[0]))
        credentials = grpc.ssl_channel_credentials(ca, key, certificate)
        with grpc.secure_channel(fort.server.address, credentials) as channel:
            call = channel.unary_unary(_INFO)
            for _ in range(times):
                before, lines, began = fort.count(_failure("TOKEN_MISSING")[0]), len(fort.server.lines), time.monotonic()
                for _ in range(_REFUSED_CALLS):
                    with contextlib.suppress(grpc.RpcError):
                        call(b"", timeout=20)
                        raise AssertionError("a call without a token came in")
                seconds = time.monotonic() - began
                assert fort.count(_failure("TOKEN_MISSING")[0]) - before == _REFUSED_CALLS, "not all were counted"
                logged = sum("TOKEN_MISSING" in line for line in fort.server.lines[lines:])
                assert logged <= 20 * (seconds + 2), f"{logged} lines in {seconds} s"
                fort.serve_friend()
                yield seconds


def half_requests(site, times):
    """60 requests to the metrics port that never end: a scrape must be answered within Prometheus' 10 s."""
    with site.server() as server:
        host, port = server.metrics_address.rsplit(":", 1)
        for _ in range(times):
            with contextlib.ExitStack() as opened:
                for _ in range(60):
                    half = opened.enter_context(contextlib.closing(socket.create_connection((host, int(port)), 30)))
                    half.sendall(b"GET /metrics HTTP/1.1\r\nHost:")
                began = time.monotonic()
                server.metric("curvd_connections_open")
                seconds = time.monotonic() - began
            assert seconds < 10, f"a scrape took {seconds} s"
            yield seconds


def long_token_file(site, times):
    """100,000 tokens are read again and again while calls are open: new calls must not wait for it."""
    with _fort(site, "--max-streams-per-peer=1000") as fort, contextlib.ExitStack() as opened:
        others = {f"caller-{number}": f"curvd_caller_{number}" for number in range(100_000)}
        fort.write_tokens(**others)
        wait_for(lambda: fort.count(_RELOADS) == 1, 60, "the tokens were not read")
        ca, key, certificate = (path.read_bytes() for path in (fort.authority.certificate, fort.friend[1],
                                                               fort.friend[0]))
        credentials = grpc.ssl_channel_credentials(ca, key, certificate)
        channel = opened.enter_context(grpc.secure_channel(fort.server.address, credentials))
        metadata = [("authorization", "Bearer curvd_caller_99999")]  # the last line of the file
        stay = threading.Event()
        opened.callback(stay.set)
        calls = [channel.stream_stream(_ESTIMATE)(_until(stay), metadata=metadata, timeout=600) for _ in range(400)]
        wait_for(lambda: fort.count("curvd_streams_open") == len(calls), 60, "the calls were not let in")
        for trial in range(times):
            reloads = fort.count(_RELOADS)
            fort.write_tokens(**others, **{f"one-more-{trial}": f"curvd_more_{trial}"})
            longest, read_at = 0.0, None
            # The open calls are checked after the file was read.
            while read_at is None or time.monotonic() - read_at < 1:
                began = time.monotonic()
                with contextlib.suppress(grpc.RpcError):  # it sends no header
                    list(channel.stream_stream(_ESTIMATE)(iter(()), metadata=metadata, timeout=60))
                if read_at is None and fort.count(_RELOADS) > reloads:
                    read_at = time.monotonic()
                longest = max(longest, time.monotonic() - began)
            assert longest < 1, f"a call and a scrape took {longest} s while tokens were read"
            yield longest
        for call in calls:
            call.cancel()


def _until(event):
    """Requests of a call that sends nothing until `event`."""
    event.wait()
    yield from ()


def _descriptors_missing():
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard < _CROWD + 200:
        return f"this process may open {hard} files only"
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    return ""


FAULTS = [
    Fault("no certificate", no_certificate),
    Fault("expired certificate", expired_certificate),
    Fault("certificate with another name", wrong_name),
    Fault("wrong token", wrong_token),
    Fault("revoked token", revoked_token, slow=True),
    Fault("plain text to the TLS port", plain_text),
    Fault("oversized header", oversized_header),
    Fault("calls without a token", refused_calls),
    Fault("half requests to the metrics port", half_requests),
    Fault("100,000 tokens read again", long_token_file, slow=True),
    Fault("10,000 idle connections", idle_connections, slow=True, needs=_descriptors_missing),
]
