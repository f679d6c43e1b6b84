"""Takes over what the cycle publishes, and invalidates it when the cycle is gone."""

from gateway.assembly.axis_zeros import torn_lines
from gateway.assembly.last_positions import LastPlaces, judge
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.image.records.cell import CELL_STATE_LAYOUT, AxisFlag, AxisState, CellState, unpack_cell_state
from gateway.pure.reports.late_machine import LateMachine
from gateway.runtime.regions import RegionReader
from gateway.services.canopen import CanopenServices
from gateway.services.cell_values import CellValues
from gateway.services.context import RunContext
from gateway.services.part import Part
from gateway.services.planner_link import PlannerLink
from gateway.services.shared_image import SharedImage
from protocols.base.machine import Ns, ms

CYCLE_GONE_NS: Ns = ms(250)  # a cycle silent for this long is reported to the command sources; restarts at once are quicker only on a fast
# machine
STRETCHED_GONE_NS: Ns = ms(2_000)  # in a stretched simulation it waits for its drives and modules as long as that
PLACES_EVERY = 200  # ticks


class CycleWatch(Part):
    """Sets the state of the shared image; keeps where the axes are for the next start."""

    def __init__(
        self,
        run: RunContext,
        image: SharedImage,
        values: CellValues,
        dispatcher: CommandDispatcher,
        canopen: CanopenServices,
        planner: PlannerLink,
        fds: dict[str, int],
    ) -> None:
        self._run, self._image, self._values, self._dispatcher, self._canopen, self._planner = (
            run,
            image,
            values,
            dispatcher,
            canopen,
            planner,
        )
        self.axes = RegionReader(fds["axes"], "axes", CELL_STATE_LAYOUT)
        self.late_machine = LateMachine(simulated=run.plan.simulated)
        self._gone_ns = STRETCHED_GONE_NS if run.plan.stretched else CYCLE_GONE_NS
        self._index, self._judged, self._ticks = -1, False, 0
        self._places = LastPlaces(run.cell)

    def lives(self, now: Ns) -> bool:
        """The cycle's published state is recent."""
        return now - self.axes.life[1] < self._gone_ns

    def step(self, now: Ns) -> None:
        """A new state, or none for too long."""
        payload = self.axes.read()
        if payload is None or self.axes.index == self._index:
            if self._image.state.generation and now - self.axes.life[1] > self._gone_ns:
                self._gone(now)
            return
        self._index = self.axes.index
        state = self._image.state = unpack_cell_state(payload)
        self.late_machine.observe(state, now)
        self._canopen.observe(state)
        if not self._judged and not self._run.plan.simulated and not any(axis.flags & AxisFlag.LOST for axis in state.axes):
            self._judged = True
            for sentence in (*judge(self._run.cell, state), *torn_lines(self._run.cell)):
                self._run.journal.write("alarm", sentence)
        self._values.life += 1
        self._dispatcher.planner = self._planner.state()
        self._dispatcher.observe(state, now)

    def _gone(self, now: Ns) -> None:
        """Positions stay as last seen (the life word stops); nothing is enabled, referenced or ready, no command waits for it."""
        places = [AxisState(axis.actual, axis.set, flags=AxisFlag.LOST) for axis in self._image.state.axes]
        self._image.state = CellState(axes=places)
        self._dispatcher.observe(self._image.state, now)

    # ---- where the axes are ------------------------------------------------------------------------------------------
    def _placed(self) -> int:
        planner = self._dispatcher.planner
        return planner.placed if planner is not None else 0

    def keep_places(self) -> None:
        """Call it in each tick after everything else: the places are kept once per second."""
        self._ticks += 1
        if self._ticks % PLACES_EVERY == 0 and self._judged:
            self._places.look(self._image.state, self._placed())

    async def close(self) -> None:
        if not self._run.plan.simulated:
            self._places.stop(self._image.state, self._placed())
