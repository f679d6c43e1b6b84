"""Place of the retained data of a run; loads no writer."""

import pathlib

from gateway.assembly.run import RunPlan


def file_of(plan: RunPlan) -> pathlib.Path | None:
    """Next to the cell file on a machine; in the folder of the run in a simulation, and only if the cell has [retain]."""
    if plan.simulated:
        return plan.folder / "retain.sqlite" if plan.cell.retain else None
    from gateway.runtime.retained.writer import path_of  # only needed by a run on a machine

    return path_of(plan.cell)
