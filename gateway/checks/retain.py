"""Cross checks of [retain]: only data that may outlive power-off and that this cell has (AX-425)."""

from collections.abc import Iterator

from gateway.assembly.telegrams import named_values
from gateway.checks.context import Context
from gateway.pure.cell.cell import Cell, Notice
from gateway.registry import CONTROLLERS
from gateway.runtime.retained.groups import GROUPS

CONTROLLED = ("flags", "counter")


def groups(context: Context) -> None:
    """A pattern begins with a group; start bits, releases and commands have none."""
    for number, pattern in enumerate(context.cell.retain.values if context.cell.retain else (), 1):
        if pattern.partition(".")[0] not in GROUPS or "." not in pattern:
            known = ", ".join(f"{group}.*" for group in GROUPS)
            context.fault(f"retain.values[{number}]", pattern, f"kept over a restart are {known}; commands and start bits never are")


def idle(cell: Cell) -> Iterator[Notice]:
    """Patterns nothing of this cell answers to."""
    kind = CONTROLLERS[cell.controller.kind] if cell.controller else None
    for number, pattern in enumerate(cell.retain.values if cell.retain else (), 1):
        group = pattern.partition(".")[0]
        missing = {
            "flags": "" if kind and kind.flags else "[controller] of kind rho3 or reis",
            "counter": "" if kind and kind.counters else "[controller] of kind rho3",
            "belt": "" if any(belt.bus for belt in cell.belt) else "a [[belt]] with an encoder on a bus",
            "order": "" if any(name.startswith("order.") for name in named_values(cell).names()) else "a value order.* of a telegram",
        }.get(group, "")
        if missing:
            yield Notice("note", f"retain.values[{number}]", f"{pattern} is not retained here: it needs {missing}")


CHECKS = (groups,)
NOTES = (idle,)
