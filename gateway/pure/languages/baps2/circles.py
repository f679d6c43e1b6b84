"""The two points of a circle, which one process supplies in sequence (AX-1744).  Pure."""

from gateway.pure.languages.baps2 import demands
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.tasks import Task
from gateway.pure.languages.base.requests import Request

AT_REST = (3, 15, 21, 28, 43, 44, 45)  # special functions that wait for the blocks before
WAITING = (
    demands.Dwell, demands.WaitFor, demands.SyncBelt, demands.Synchronise, demands.Reference, demands.ReadPosition,
    demands.Drain, demands.Branches, demands.Halt,
)  # fmt: skip


def follow(task: Task, request: Request) -> None:
    """Notes a point of a circle; a runtime error where the other one is missing: it would be waited for without end."""
    match request:
        case demands.MoveTo(kinematic=kinematic, way="circular", via=via):
            if task.circle not in (None, kinematic) or (task.circle is None and not via):
                raise fault(223)
            task.circle = kinematic if task.circle is None else None
        case demands.MoveTo():
            _complete(task)
        case demands.ReadInput(channel=channel) if channel < 1_000:
            _complete(task)
        case demands.Special(number=number) if number in AT_REST:
            _complete(task)
        case _ if isinstance(request, WAITING):
            _complete(task)


def _complete(task: Task) -> None:
    if task.circle is not None:
        raise fault(223)
