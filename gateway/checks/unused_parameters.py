"""Parameters without effect in this cell: P numbers of [rho3] whose tuning has no effect, a file of zeros."""

from collections.abc import Iterator
from dataclasses import fields

from gateway.files.texts import read_texts
from gateway.pure.cell.cell import Cell, Notice, Rho3
from gateway.pure.cell.rho3 import CONTROLLED, COUPLED, DOWNLOADED, ENDLESS, JOGGED
from gateway.registry import BUS_PROTOCOLS, CONTROLLERS

SIGNALS = frozenset(("P2", "P9", "P20", "P24"))  # of the control's own list
AXES = frozenset("P103 P104 P108 P109 P204 P205 P207 P208 P303 P401".split())
ENDS = frozenset(("P204", "P205"))  # an axis that goes round has none
KINEMATICS = frozenset(("P306", "P313"))
BLOCKS = frozenset(("P30", "P31", "P32"))


def given(params: Rho3) -> list[str]:
    """In the order of their numbers, without those that set the default."""
    own = [each.name for each in fields(params) if each.name.startswith("P") and getattr(params, each.name) != each.default]
    return sorted((*own, *params.others), key=lambda name: int(name[1:]))


def why_unused(cell: Cell, params: Rho3, name: str) -> str:
    """Why: name of the sentence in configs/texts/check.toml; empty: it acts."""
    controlled = cell.controller is not None and CONTROLLERS[cell.controller.kind].parameters
    jogs = name in JOGGED and "P113" in params.others and bool(cell.axis)
    boosted = any(BUS_PROTOCOLS[bus.protocol].boosted for bus in cell.bus)
    reasons = (
        (name in CONTROLLED | SIGNALS | {"P21"} and not controlled, "no_controller"),
        (name == "P21" and params.P20 not in COUPLED, "not_coupled"),
        (name in AXES and not cell.axis, "no_axis"),
        (name in ENDS and all(axis.modulo > 0.0 for axis in cell.axis), "all_endless"),
        (name == "P311" and not set(ENDLESS) & set(params.P303), "not_endless"),
        (name in KINEMATICS and not cell.robot, "no_robot"),
        (name in BLOCKS and not cell.bus, "no_bus"),
        (name == "P113" and not cell.axis, "no_axis"),
        (name == "P128" and not jogs, "no_jog_speed"),
        (name in DOWNLOADED and not params.P601 and not jogs, "download_off"),
        (name in DOWNLOADED | {"P601"} and not boosted and not jogs, "no_booster"),
        (name in params.others and name not in DOWNLOADED | CONTROLLED | JOGGED, "unused_parameter"),
    )
    return next((why for holds, why in reasons if holds), "")


def unused_notes(cell: Cell) -> Iterator[Notice]:
    """One for each, with its meaning."""
    if cell.rho3 is None:
        return
    texts, meanings = read_texts("check"), read_texts("rho3-parameters")
    for name in given(cell.rho3):
        if why := why_unused(cell, cell.rho3, name):
            yield Notice("warning", f"rho3.{name}", texts.said(why, meanings.said(name)))


def unread_zeros(cell: Cell) -> Iterator[Notice]:
    """Files of zeros that a robot names: the zeros in force are those in the state folder."""
    for robot in cell.robot:
        if robot.zero:
            yield Notice("warning", f"robot.{robot.name}.zero" if robot.name else "robot.zero", read_texts("check").said("unread_zero"))


CHECKS: tuple[()] = ()
NOTES = (unused_notes, unread_zeros)
