"""A cell that commands move by programs or streams: running, or simulated for this; referenced."""

import argparse
import contextlib
from collections.abc import Iterator

from gateway.assembly.run import slug_of
from gateway.pure.cell.cell import Cell
from gateway.tools.client import ToolClient, mask_of, running, simulated


@contextlib.contextmanager
def client_of(options: argparse.Namespace, cell: Cell) -> Iterator[ToolClient]:
    """Options: sim, cell, name."""
    if options.sim:
        with simulated(options.cell) as (client, _):
            client.wait_ready()
            yield client
    else:
        with running(options.name or slug_of(cell)) as client:
            yield client


def reference(client: ToolClient, cell: Cell) -> None:
    """All axes that are searched."""
    searched = mask_of(cell, [axis.name for axis in cell.axis if axis.home.by != "none"])
    if searched:
        client.command("reference", searched, timeout_s=120.0)
