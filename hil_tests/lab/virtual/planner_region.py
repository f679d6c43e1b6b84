"""The planner's region of a virtual cell: packed and unpacked once for each record."""

from gateway.pure.image.records.planner import PlannerState, pack_planner, unpack_planner


class PlannerRegion:
    """What readers have of the record that the planner published last."""

    def __init__(self) -> None:
        self._said: PlannerState | None = None
        self._read = PlannerState()

    def through(self, said: PlannerState) -> PlannerState:
        """Return `said` as its readers see it."""
        if said is not self._said and said != self._said:
            self._read = unpack_planner(pack_planner(said))
        self._said = said
        return self._read
