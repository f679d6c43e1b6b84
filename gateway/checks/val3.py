"""Cross checks of [val3]; the reader of its application, and so the robot's kinematics, is loaded only for such a cell."""

from collections.abc import Iterator

from gateway.checks.context import Context
from gateway.pure.cell.cell import Cell, Notice


def application(check: Context) -> None:
    """All that keeps the application from its start."""
    if check.cell.val3 is not None:
        from gateway.checks.applications.val3 import application as checked

        checked(check)


def warnings(cell: Cell) -> Iterator[Notice]:
    """Warnings of its files."""
    if cell.val3 is not None:
        from gateway.checks.applications.val3 import warnings as found

        yield from found(cell)


CHECKS = (application,)
NOTES = (warnings,)
