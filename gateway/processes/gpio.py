"""Contacts on gpiochips: a process of its own, because the character device may be slow and the cycle must not wait.

    python -m gateway.processes.gpio --plan FD --fds NAME=FD,...      (started by the supervisor)

Outputs show the last completed cycle (AX-404): without a new one for the time the supervisor allows the cycle, every output changes to
on_loss, or 0, and the watchdog stops.  A missing chip or line is reported once a second at most and tried again.
"""

import argparse
import contextlib
import signal
import time
from collections.abc import Iterable, Mapping, Sequence

import gpiod
from gpiod.line import Direction, Value

from gateway.assembly.contacts import CHIP, outputs_of
from gateway.assembly.run import RunPlan, load_plan
from gateway.pure.buses.contacts import SAID_LAYOUT, WATCHDOG, Outputs, Said, pack_said, unpack_said
from gateway.pure.cell.cell import Io
from gateway.pure.image.records.cell import CELL_STATE_LAYOUT, RC_BYTES, Quality, unpack_cell_state
from gateway.runtime.realtime import die_with_parent
from gateway.runtime.regions import RegionReader, RegionWriter, fds_from_text
from protocols.base.machine import Ns, ms

SERVICES_GONE: Ns = ms(250)
AGAIN_NS: Ns = ms(1000)
CONSUMER = "axisgate"


class Chip:
    """The lines of one gpiochip; opened again when it goes away."""

    def __init__(self, path: str, contacts: Mapping[int, Io]) -> None:
        self.path, self.contacts = path, contacts
        self._request: gpiod.LineRequest | None = None
        self._due: Ns = 0
        self._printed = ""

    def turn(self, shown: Mapping[int, bool], now: Ns) -> dict[int, Said]:
        """Writes outputs, reads inputs; state of each contact."""
        if self._request is None and not self._open(now):
            return {}
        try:
            assert self._request is not None
            outputs = {n: io.device.output for n, io in self.contacts.items() if io.device.output is not None}
            if outputs:
                self._request.set_values({line: Value.ACTIVE if shown[n] else Value.INACTIVE for n, line in outputs.items()})
            inputs = {n: io.device.input for n, io in self.contacts.items() if io.device.input is not None}
            levels = self._request.get_values(list(inputs.values())) if inputs else []
        except OSError as error:
            self._lose(error)
            return {}
        found = {n: Said(shown[n], Quality.GOOD) for n in outputs}
        return found | {n: Said(level is Value.ACTIVE, Quality.GOOD) for n, level in zip(inputs, levels, strict=True)}

    def close(self) -> None:
        if self._request is not None:
            self._request.release()
            self._request = None

    def _open(self, now: Ns) -> bool:
        if now < self._due:
            return False
        self._due = now + AGAIN_NS
        settings: dict[Iterable[int | str] | int | str, gpiod.LineSettings | None] = {}
        for io in self.contacts.values():
            line = io.device.input if io.device.output is None else io.device.output
            assert line is not None  # the cell's checks: exactly one of both
            way = Direction.INPUT if io.device.output is None else Direction.OUTPUT
            initial = Value.ACTIVE if io.on_loss else Value.INACTIVE
            settings[line] = gpiod.LineSettings(direction=way, active_low=io.device.active_low, output_value=initial)
        try:
            self._request = gpiod.request_lines(self.path, consumer=CONSUMER, config=settings)
        except (OSError, ValueError) as error:
            self._say(f"{self.path}: {words_of(error)}; contacts {', '.join(io.name for io in self.contacts.values())} are out")
            return False
        self._say(f"{self.path}: open")
        return True

    def _lose(self, error: OSError) -> None:
        with contextlib.suppress(OSError):
            self.close()
        self._request = None
        self._say(f"{self.path}: {words_of(error)}")

    def _say(self, words: str) -> None:
        if words != self._printed:
            self._printed = words
            print(words, flush=True)


def words_of(error: Exception) -> str:
    """The remedy."""
    if isinstance(error, FileNotFoundError):
        return "no such gpiochip; gpiodetect lists those that exist"
    if isinstance(error, PermissionError):
        return "not permitted; add this user to the group gpio, or give the device to it"
    if isinstance(error, OSError) and error.strerror == "Device or resource busy":
        return "a line is in use by another program; gpioinfo names it"
    return str(error)


class Chips:
    """All chips of a cell, in step with the cycle."""

    def __init__(self, plan: RunPlan, fds: Mapping[str, int]) -> None:
        cell = plan.cell
        self._axes, self._rc_out = RegionReader(fds["axes"], "axes", CELL_STATE_LAYOUT), RegionReader(fds["rc_out"], "rc_out")
        self._said, self._links = RegionReader(fds["io_out"], "io_out", SAID_LAYOUT), RegionReader(fds["links"], "links")
        self._heard = RegionWriter(fds["io_chip"], "io_chip", SAID_LAYOUT)
        self._outputs = Outputs(outputs_of(cell, CHIP, plan.p5_ms), len(cell.axis))
        self._cell_io = cell.io
        self._patience = max(5 * plan.p5_ms, 50) * 1_000_000
        mine = {n: io for n, io in enumerate(cell.io) if io.device.type == CHIP}
        paths = sorted({io.device.chip for io in mine.values()})
        self.chips = [Chip(path, {n: io for n, io in mine.items() if io.device.chip == path}) for path in paths]
        self._watchdogs = {n: False for n, io in mine.items() if io.signal == WATCHDOG}
        self.period_s = plan.p5_ms / 1000.0

    def turn(self, now: Ns) -> None:
        """Outputs of the last completed cycle; without a new one for too long, none."""
        payload = self._axes.read()
        alive = payload is not None and now - self._axes.life[1] < self._patience
        heard: list[Said] = [Said()] * len(self._cell_io)
        if alive and payload is not None:
            octets = self._said.read()
            said = unpack_said(octets) if octets is not None and now - self._links.life[1] < SERVICES_GONE else []
            shown = self._outputs.show(unpack_cell_state(payload), self._rc_out.read() or bytes(RC_BYTES), said)
            self._watchdogs = {n: shown[n] for n in self._watchdogs}
        else:
            shown = {n: bool(io.on_loss) for n, io in enumerate(self._cell_io)} | self._watchdogs
        for chip in self.chips:
            for n, what in chip.turn(shown, now).items():
                heard[n] = what
        self._heard.write(pack_said(heard), now)
        self._heard.beat(now)


def run(chips: Chips, stopped: Sequence[bool]) -> None:
    """Once per period, until stopped."""
    while not stopped:
        chips.turn(time.monotonic_ns())
        time.sleep(chips.period_s)
    for chip in chips.chips:
        chip.close()


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate chips", description="contacts on gpiochips; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    stopped: list[bool] = []
    signal.signal(signal.SIGTERM, lambda number, frame: stopped.append(True))
    run(Chips(load_plan(arguments.plan), fds_from_text(arguments.fds)), stopped)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
