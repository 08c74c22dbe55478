"""A fault as a row of the table."""

import dataclasses
import typing


@dataclasses.dataclass(frozen=True)
class Fault:
    """trials(site, times) yields once a trial: the seconds from the fault to where all is well again. It raises if a trial
    lost anything: a result, a wrong byte, a process that hangs, a server that does not recover.

    slow: takes longer than the fault suite's short form has. needs(): what is missing to try it here, or "".
    """

    name: str
    trials: typing.Callable
    slow: bool = False
    needs: typing.Callable = lambda: ""
