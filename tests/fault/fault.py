"""A fault as a row of the table."""

import dataclasses
import typing


class Trial(float):
    """Seconds of a trial that also measured how others were served. A trial that broke a promise goes on to the next.

    over_limit_mib: the most memory that the server had, less its limit. beside, longest: the median of another caller's
    calls, and the longest of them, divided by the median of calls to the idle server. broken: the promise, or "".
    """

    def __new__(cls, seconds, over_limit_mib, beside, longest, broken=""):
        trial = super().__new__(cls, seconds)
        trial.over_limit_mib = over_limit_mib
        trial.beside = beside
        trial.longest = longest
        trial.broken = broken
        return trial


@dataclasses.dataclass(frozen=True)
class Fault:
    """trials(site, times) yields once a trial: the seconds from the fault to where all is well again, or a Trial. It
    raises if a trial lost anything: a result, a wrong byte, a process that hangs, a server that does not recover.

    slow: takes longer than the fault suite's short form has. needs(): what is missing to try it here, or "". guard:
    tries what bounds strangers; its trials are Trials.
    """

    name: str
    trials: typing.Callable
    slow: bool = False
    needs: typing.Callable = lambda: ""
    guard: bool = False
