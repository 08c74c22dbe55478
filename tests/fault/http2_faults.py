"""What gRPC's HTTP/2 lets strangers do: memory stays bounded, a caller with a token is served, the connection ends."""

import contextlib

from fault import Fault
from guarded_door import CHECK, ESTIMATE, INSIDERS_TOKEN, Door, attack_trials

_NAMES = {
    "references": "references to a header, no SETTINGS ACK",
    "long_string": "a header of 63 MiB in small frames",
    "rapid_reset": "rapid reset",
    "half_messages": "200 half messages",
    "many_streams": "30,000 calls on a connection",
}
# What a header of 8 KiB may take, and some seconds.
_MOST_DRIP_SECONDS = 26 + 6


def _drips(tls=False, health=False):
    """Trials of a header that drips in, all at once."""

    def trials(site, times):
        with contextlib.ExitStack() as opened:
            door = Door(site, opened, tls)
            # As many as the health port takes.
            connections = min(times, 20)
            result, trial = door.attack("drip", f"--connections={connections}", health=health)
            assert result["longest"] < _MOST_DRIP_SECONDS, f"a header dripped for {result['longest']} s"
            for _ in range(connections):
                yield trial

    return trials


def _row(title, *attack, **options):
    # They judge times, which a machine that is busy with other tests does not keep.
    return Fault(title, attack_trials(*attack, **options), slow=True, guard=True)


FAULTS = [
    *(_row(title, name) for name, title in _NAMES.items()),
    *(_row(f"{title}, TLS", name, tls=True) for name, title in _NAMES.items()),
    *(_row(f"{title}, health port", name, *(["--path", CHECK] if name == "half_messages" else []), health=True)
      for name, title in _NAMES.items()),
    *(_row(f"{title}, by a caller with a token", name, "--path", ESTIMATE, "--token", INSIDERS_TOKEN)
      for name, title in _NAMES.items() if name in ("references", "half_messages")),
    *(_row(f"{_NAMES[name]}, 100 connections for 10 s", name, "--repeat=10", "--connections=100")
      for name in ("references", "rapid_reset", "long_string")),
    # Each connection sends less than what a caller may whose call waits: it may stay while nobody needs its ration.
    *(_row(f"740 calls of 15 bytes, {connections} connections for 10 s{place}", "small_calls", "--repeat=10", "--linger=3",
           f"--connections={connections}", *path, may_stay=True, **options)
      for place, connections, path, options in (("", 100, [], {}), (", TLS", 100, [], {"tls": True}),
                                                (", health port", 30, ["--path", CHECK], {"health": True}))),
    Fault("a header that drips in", _drips(), slow=True, guard=True),
    Fault("a header that drips in, TLS", _drips(tls=True), slow=True, guard=True),
    Fault("a header that drips in, health port", _drips(health=True), slow=True, guard=True),
]
