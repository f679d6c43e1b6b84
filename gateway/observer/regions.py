"""The shared regions as the page sees them: read, never written, and never waited for."""

import json
import time
from typing import Any, Protocol

from gateway.assembly.lanes import robot_axes
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.enabling_inputs import PERMITS
from gateway.pure.image.reasons import Reason, text
from gateway.pure.image.records.cell import (
    CELL_STATE_LAYOUT,
    RC_BYTES,
    AxisFlag,
    CellState,
    InputImage,
    Permit,
    Quality,
    unpack_cell_state,
    unpack_inputs,
)
from gateway.pure.image.records.planner import unpack_planner
from gateway.runtime.regions import RegionReader
from motion.geometry.units import to_si

STALE_NS = 250_000_000  # a cycle or services silent for so long: all their values are old
Row = dict[str, Any]


class Shown(Protocol):
    """Facts about a run."""

    @property
    def cell(self) -> Cell:
        """Its axes, in the order of the regions."""

    @property
    def p5_ms(self) -> int:
        """Its clock."""


class Regions:
    """The last published state of cycle and services, as plain dictionaries in the axes' own units."""

    def __init__(self, plan: Shown, fds: dict[str, int]) -> None:
        self.plan = plan
        self.axes = RegionReader(fds["axes"], "axes", CELL_STATE_LAYOUT)
        self.rc_in = RegionReader(fds["rc_in"], "rc_in")
        self.rc_out = RegionReader(fds["rc_out"], "rc_out")
        self.links = RegionReader(fds["links"], "links")
        self.planner = RegionReader(fds["planner"], "planner") if "planner" in fds else None
        self.state = CellState()
        self.status: Row = {}
        self.inputs = InputImage()
        self.outputs = bytes(RC_BYTES)
        self.facts = [(axis.name, axis.unit, to_si(1.0, axis.unit)) for axis in plan.cell.axis]
        self._robots = robot_axes(plan.cell)
        self._seen = [-1, -1, -1]

    def look(self) -> None:
        """Read new data."""
        for number, (region, take) in enumerate(((self.axes, self._state), (self.links, self._status), (self.rc_in, self._inputs))):
            payload = region.read()
            if payload is not None and region.index != self._seen[number]:
                self._seen[number] = region.index
                take(payload)
        self.outputs = self.rc_out.read() or self.outputs

    def _state(self, payload: bytes) -> None:
        self.state = unpack_cell_state(payload)

    def _status(self, payload: bytes) -> None:
        try:
            self.status = json.loads(payload)
        except ValueError:  # longer than its region: the former value stays
            return

    def _inputs(self, payload: bytes) -> None:
        self.inputs = unpack_inputs(payload)

    def ages(self) -> tuple[float, float]:
        """ms since cycle and services showed life; inf: never."""
        now, cycle, services = time.monotonic_ns(), self.axes.life[1], self.links.life[1]
        never = float("inf")
        return (now - cycle) / 1e6 if cycle else never, (now - services) / 1e6 if services else never

    def head(self) -> Row:
        """The head of every page."""
        state, (cycle, services) = self.state, self.ages()
        stale = cycle * 1e6 > STALE_NS
        missing = [name for name, permit in PERMITS if not state.permits & permit]
        return {
            "cycle_alive": not stale,
            "services_alive": services * 1e6 <= STALE_NS,
            "ready": state.ready and not stale,
            "emergency": state.emergency,
            "motion": int(state.motion),
            "override": round(state.override * 100.0, 1),
            "missing": missing,
            "withheld": [
                [name, [each for each, permit in PERMITS if state.withheld(mask) & permit]] for name, mask in self._robots.items()
            ],
            "travel": bool(state.permits & Permit.TRAVEL),
            "stop_cause": state.stop_cause,
            "stop_text": [text(Reason(state.stop_cause), language) for language in ("en", "de")] if state.stop_cause else ["", ""],
            "owner": self.status.get("owner", 0),
            "forced": self.status.get("forced", 0),
            "permits": bool(self.status.get("permits")),
            "errors": self.status.get("errors", []),
            "enabled": sum(bool(axis.flags & AxisFlag.ENABLED) for axis in state.axes[: len(self.facts)]),
            "axes": len(self.facts),
        }

    def drives(self) -> list[Row]:
        """One row for each axis."""
        stale = self.ages()[0] * 1e6 > STALE_NS
        rows = []
        for (name, _, si), axis in zip(self.facts, self.state.axes, strict=False):
            rows.append(
                {
                    "name": name,
                    "set": round(axis.set / si, 4),
                    "actual": round(axis.actual / si, 4),
                    "lag": round(axis.lag / si, 4),
                    "speed": round(axis.speed / si, 3),
                    "torque": round(axis.torque * 100.0, 1),
                    "flags": int(axis.flags) | (int(AxisFlag.LOST) if stale else 0),
                    "fault": axis.fault_code,
                    "power": axis.power,
                }
            )
        return rows

    def counters(self) -> Row:
        """Counters of the cycle."""
        state = self.state
        return {
            "cycles": state.cycle,
            "skipped": state.skipped,
            "incomplete": state.incomplete,
            "late": state.late,
            "services_lost": state.services_lost,
            "compute_us": round(state.compute_ns / 1e3, 1),
            "p5_ms": self.plan.p5_ms,
        }

    def queue(self) -> Row:
        """State of the planner; empty without one."""
        payload = self.planner.read() if self.planner is not None else None
        if payload is None:
            return {}
        planner = unpack_planner(payload).under_way
        names = ("job", "block", "share", "waiting", "handed", "ended", "failed_job", "fault", "fault_block", "fault_code", "warning")
        return {name: getattr(planner, name) for name in (*names, "tool")}

    def input_bit(self, number: int) -> tuple[int, int, int | None]:
        """Value, quality, age in ms."""
        octet = number >> 3
        stamp = self.inputs.stamps[octet]
        age = round((time.monotonic_ns() - stamp) / 1e6) if stamp else None
        return int(self.inputs.bit(number)), self.inputs.quality[octet], age

    def output_bit(self, number: int) -> tuple[int, int, int | None]:
        """Value, quality, age in ms: the cycle's own life."""
        age = self.ages()[0]
        quality = Quality.GOOD if age * 1e6 <= STALE_NS else Quality.STALE
        return self.outputs[number >> 3] >> (number & 7) & 1, int(quality), None if age == float("inf") else round(age)
