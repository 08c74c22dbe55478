#!/usr/bin/python3
"""What gRPC's own arguments are worth against strangers: grpc_arguments.py PROGRAMS

PROGRAMS is the directory of fault_unguarded. Prints a table: for each attack of http2_attacks.py and each argument the
most memory that the server had, and the CPU seconds that it used.
"""

import argparse
import os
import pathlib
import subprocess
import sys

_CHECK = "/grpc.health.v1.Health/Check"
_ATTACKS = {
    "references": ["--most", "4000000"],
    "long_string": ["--most", "2000000"],
    "rapid_reset": ["--most", "8000000"],
    "half_messages": ["--path", _CHECK],
    "many_streams": [],
}
_ARGUMENTS = {
    "none": [],
    "metadata 8 KiB": ["--max-metadata=8192"],
    "100 streams": ["--max-streams=100"],
    "HPACK table of 0": ["--hpack-table=0"],
    "quota 64 MiB": ["--quota-mib=64"],
    "all": ["--max-metadata=8192", "--max-streams=100", "--hpack-table=0", "--quota-mib=64"],
}


def _usage(pid):
    """The most memory in MiB, and CPU seconds."""
    with open(f"/proc/{pid}/status", encoding="ascii") as status:
        peak = next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmHWM"))
    with open(f"/proc/{pid}/stat", encoding="ascii") as stat:
        ticks = stat.read().rpartition(")")[2].split()[11:13]
    return peak, sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")


def _try(program, arguments, name, flags):
    with subprocess.Popen([program, *arguments], stdout=subprocess.PIPE, text=True) as server:
        try:
            address = f"127.0.0.1:{int(server.stdout.readline())}"
            attacks = pathlib.Path(__file__).parent / "http2_attacks.py"
            subprocess.run([sys.executable, attacks, name, address, "--linger=2", *flags], check=True,
                           stdout=subprocess.DEVNULL, timeout=120)
            return "{:.0f} MiB, {:.1f} s".format(*_usage(server.pid))
        except subprocess.TimeoutExpired:
            return "{:.0f} MiB, {:.1f} s, not over after 120 s".format(*_usage(server.pid))
        finally:
            server.kill()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=pathlib.Path)
    options = parser.parse_args()
    print(f"| attack | {' | '.join(_ARGUMENTS)} |\n| --- |{' --- |' * len(_ARGUMENTS)}")
    program = options.programs / "fault_unguarded"
    for name, flags in _ATTACKS.items():
        cells = [_try(program, arguments, name, flags) for arguments in _ARGUMENTS.values()]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
