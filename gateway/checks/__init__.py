"""Cross checks of a cell: keys that do not fit each other, reported like field faults; and notes on valid but doubtful settings."""

from collections.abc import Callable, Mapping

from gateway.checks import (
    alter,
    axes,
    belts,
    blocks,
    buses,
    canopen,
    contacts,
    controller,
    lines,
    modbus,
    northbound,
    notes,
    programs,
    retain,
    robots,
    routes,
    shared,
    telegrams,
    web,
)
from gateway.checks import command_sources as doors
from gateway.checks import rho3_can as rho3can
from gateway.checks.context import Context
from gateway.pure.cell.cell import Cell, Notice
from gateway.pure.cell.faults import Fault
from gateway.pure.image.signals import SignalList

__all__ = ["cross_faults", "notices"]


def cross_faults(cell: Cell, known: Mapping[str, frozenset[str]], signals: SignalList, line_of: Callable[[str], int | None]) -> list[Fault]:
    """All cross faults of the valid parts.  `known` has the names of all parts, also of those left out; `line_of` finds a key's line."""
    context = Context(cell, known, signals, line_of)
    for check in (
        *doors.CHECKS,
        *lines.CHECKS,
        *modbus.CHECKS,
        *blocks.CHECKS,
        *buses.CHECKS,
        *rho3can.CHECKS,
        *canopen.CHECKS,
        *axes.CHECKS,
        *telegrams.CHECKS,
        *robots.CHECKS,
        *programs.CHECKS,
        *belts.CHECKS,
        *alter.CHECKS,
        *shared.CHECKS,
        *web.CHECKS,
        *northbound.CHECKS,
        *controller.CHECKS,
        *routes.CHECKS,
        *contacts.CHECKS,
        *retain.CHECKS,
    ):
        check(context)
    return context.faults


def notices(cell: Cell) -> list[Notice]:
    """Warnings and notes of a cell without faults, in the order of a reader's questions."""
    return [
        notice
        for check in (
            *telegrams.NOTES,
            *lines.NOTES,
            *rho3can.NOTES,
            *notes.NOTES,
            *canopen.NOTES,
            *routes.NOTES,
            *controller.NOTES,
            *programs.NOTES,
            *retain.NOTES,
        )
        for notice in check(cell)
    ]
