"""The cycle of a shadow: clocked by the old controller's SYNC, fed with the drives' answers; nothing is sent (AX-493).

One step for each SYNC, as soon as all drives have answered it, or with the next one.  What the step would have sent is compared with what
the old controller sends after the next SYNC: the bits that command the drives, positions, and the bytes of digital outputs.
"""

import argparse
import os
import select
import signal
import time
from collections.abc import Sequence

from drivers.drives.cia402 import Mode
from drivers.drives.cia402_family import Cia402Family
from drivers.drives.family import Actual, SetRecord
from drivers.ports.base import PortError
from drivers.ports.can.open import open_can
from drivers.ports.listening import ListeningCan
from gateway.assembly.axis_scaling import scaling_of
from gateway.assembly.run import RunPlan, load_plan
from gateway.cycle.bus_link import BusLink
from gateway.cycle.loop import Cycle
from gateway.pure.image.records.cell import pack_cell_state
from gateway.pure.scope.records import pack_scope
from gateway.pure.shadow.addresses import Place
from gateway.pure.shadow.compare import Answer, Comparison, as_data
from gateway.pure.shadow.set_values import SetValues
from gateway.runtime.realtime import die_with_parent
from gateway.runtime.regions import fds_from_text
from gateway.shadow.log_writer import keep
from gateway.shadow.plan import BUSES
from motion.geometry.units import to_si
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid

LOOK_S = 0.05
REOPEN_NS: Ns = 250_000_000
KEEP_NS: Ns = 1_000_000_000
SILENT_LOOKS = 4  # failed looks in a row: the drives are lost, as for a control whose bus is down


class ShadowCycle(Cycle):
    """The loop around the core, led by the bus."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        super().__init__(plan, fds)
        self._folder = plan.folder
        self._sets = [SetValues(bus.family) for bus in self.buses]
        self._drives = {(axis.drive.bus, axis.drive.node or axis.drive.module): axis for axis in plan.cell.axis}
        self._names = [bus.name for bus in plan.cell.bus if bus.name in plan.buses]
        self._tolerances = plan.tolerances
        self.comparison = Comparison(slack=self.period_ns + self.period_ns // 2)
        self._actuals: list[Actual | None] = [None] * len(self.core.plans)
        self._open = False  # a SYNC was seen whose step is still to come
        self._in_vain = SILENT_LOOKS  # looks at the ports since a SYNC came: a shadow that was held up itself finds the frames waiting
        self._again: Ns = 0
        self._keep_next: Ns = 0
        self._missing = 0
        self._began = time.monotonic_ns()
        self._lead = self._driving[0]  # its SYNC is the clock
        self.syncs = self.silences = 0
        self._silent = True

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._on_signal)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        self._prepare(self.core.idle())
        while not self._stop:
            self._listen()
            now = time.monotonic_ns()
            self.axes.beat(now)
            if self._in_vain >= SILENT_LOOKS:
                self._nothing_heard()
            if now >= self._keep_next:
                self._keep_next = now + KEEP_NS
                self._keep(now)
        self.comparison.finish()
        self._keep(time.monotonic_ns())
        for bus in self.buses:
            bus.close()

    def _listen(self) -> None:
        now = time.monotonic_ns()
        if now >= self._again:
            self._again = now + REOPEN_NS
            for bus in self.buses:
                if bus.port is None:
                    self._attach(bus)
        fds = [bus.fd for bus in self.buses if bus.port is not None]
        if not fds:
            time.sleep(LOOK_S)
            self._in_vain += 1
            return
        if not select.select(fds, (), (), LOOK_S)[0]:
            self._in_vain += 1
            return
        for bus in self.buses:
            for frame in self._received(bus):
                self._frame(bus, frame)

    def _attach(self, bus: BusLink) -> None:
        try:
            bus.port = ListeningCan(open_can(bus.url))
        except PortError as error:
            self._say(bus, str(error))
            return
        bus.fd, bus.last_error = bus.port.fileno(), ""
        print(f"{bus.url}: open, listening only", flush=True)

    def _received(self, bus: BusLink) -> Sequence[Frame]:
        if bus.port is None:
            return ()
        try:
            return bus.port.receive()
        except PortError as error:
            bus.close()
            self._say(bus, str(error))
            return ()

    def _say(self, bus: BusLink, words: str) -> None:
        if words != bus.last_error:
            bus.last_error = words
            print(words, flush=True)

    # ---- frames ------------------------------------------------------------------------------------------------------
    def _frame(self, bus: BusLink, frame: Frame) -> None:
        if frame.identifier == self._sets[bus.number].sync:
            if bus is self._lead:
                self._sync(frame.stamp_ns)
            return
        if isinstance(bus.family, Cia402Family):
            self._meet(bus.family, frame)
        key = (bus.number, frame.identifier)
        if key in self.comparison.blocks:
            self.comparison.theirs(Answer(key, frame.stamp_ns, frame.stamp_ns, 0, self._compared(bus, frame)))
        try:
            heard = bus.family.hear(frame)
        except DecodeError:
            encoder = bus.encoders.get(frame.identifier)
            if encoder is not None:
                encoder.hear(frame.data)
            else:
                bus.foreign += key not in self.comparison.blocks
            return
        finally:
            bus.family.aside.clear()  # SDO and the like belong to the old controller; nothing here waits for them
        if heard is None or not self._open:
            return
        self._missing -= self._actuals[heard[0]] is None
        self._actuals[heard[0]] = heard[1]
        if self._missing <= 0:
            self._step()

    @staticmethod
    def _meet(family: Cia402Family, frame: Frame) -> None:
        """A node that answers SYNC was started up by the old controller."""
        if frame.identifier & 0x780 == cobid.tpdo(1, 0):
            family.answers(frame.identifier & 0x7F, Mode.CSP)

    def _sync(self, stamp: Ns) -> None:
        if self._open:
            self._step()  # some drive did not answer the last one
        self.syncs += 1
        self._silent, self._open, self._in_vain = False, True, 0
        self._actuals = [None] * len(self.core.plans)
        self._missing = sum(link.family.expected for link in self.buses)
        self.comparison.settle(stamp)

    def _nothing_heard(self) -> None:
        """No SYNC: report what a control with lost drives would; the path halts, because no set value would reach a drive."""
        self._open = False
        if not self._silent:
            self._silent = True
            self.silences += 1
            self.core.drives_lost()
        self._actuals = [None] * len(self.core.plans)
        self._think()

    def _step(self) -> None:
        self._open = False
        self._think()

    def _think(self) -> None:
        core, now = self.core, time.monotonic_ns()
        for bus, family in self.with_io:
            family.exchange(self._inputs(), core.outputs, now, up=bus.port is not None)
            family.take_news()
        self._take_pieces()
        services_ns = now if self.links.life[1] else 0  # lateness is due to this computer, not to the cell
        values = core.step(self._actuals, self._inputs(), self._take_orders(), services_ns, now)
        self._would_send(values, now)
        core.state.compute_ns = time.monotonic_ns() - now
        state = pack_cell_state(core.state)
        self.axes.write(state, now)
        self.outputs.write(core.outputs, now)
        self.scope.put(pack_scope(state, core.outputs, self._image.values))
        if self.wake is not None:
            os.eventfd_write(self.wake, 1)

    def _would_send(self, values: Sequence[SetRecord], now: Ns) -> None:
        """The burst of the next SYNC: compared, never sent."""
        for bus in self.buses:
            sets = self._sets[bus.number]
            for frame in bus.family.burst(values):
                if frame.identifier == sets.sync or not (sets.whole or sets.drive(frame) is not None):
                    continue
                key = (bus.number, frame.identifier)
                if key not in self.comparison.blocks:
                    self._declare(bus, key, frame)
                self.comparison.ours(key, self._compared(bus, frame), now)

    def _declare(self, bus: BusLink, key: tuple[int, int], frame: Frame) -> None:
        name, sets = f"bus {bus.url}, telegram {frame.identifier}", self._sets[bus.number]
        axis = self._drives.get((self._names[bus.number], sets.drive(frame)))
        if axis is not None:
            per_unit = scaling_of(axis).sent_per_unit * to_si(1.0, axis.unit)
            self.comparison.declare(key, f"{name} (set value)", sets.places(axis.name, per_unit, self._tolerances[axis.name]))
        else:
            self.comparison.declare(key, name, [Place(f"byte {n}", "", n, b"\xff") for n in range(len(frame.data))])

    def _compared(self, bus: BusLink, frame: Frame) -> bytes:
        """Compared part: commands and position of a set value, whatever the layout; any other telegram completely."""
        sets = self._sets[bus.number]
        return frame.data if sets.drive(frame) is None else sets.content(frame)

    def _keep(self, now: Ns) -> None:
        found = {
            "pid": os.getpid(),
            "syncs": self.syncs,
            "silences": self.silences,
            "foreign": sum(bus.foreign for bus in self.buses),
            "buses": [bus.url for bus in self.buses],
            "telegrams": as_data(self.comparison, self._began, now),
        }
        keep(self._folder / BUSES, found)


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate shadow cycle", description="started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    ShadowCycle(load_plan(arguments.plan), fds_from_text(arguments.fds)).run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
