"""Where the retained data of a run are; loads nothing of what keeps them."""

import pathlib

from gateway.assembly.run import RunPlan


def file_of(plan: RunPlan) -> pathlib.Path | None:
    """Beside the cell file on a machine; in the folder of the run in a simulation, and only where the cell has [retain]."""
    if plan.simulated:
        return plan.folder / "retain.sqlite" if plan.cell.retain else None
    from gateway.runtime.retained.writer import path_of  # only a run on a machine asks for it

    return path_of(plan.cell)
