"""The services of a shadow: command sources that only listen, and their findings, every second into a file (AX-493)."""

import argparse
import asyncio
import contextlib
import os
import signal
import time
from dataclasses import replace

from gateway.assembly.run import RunPlan, load_plan
from gateway.pure.cell.cell import Line
from gateway.pure.cell.modbus import Modbus
from gateway.runtime.realtime import die_with_parent
from gateway.runtime.regions import fds_from_text
from gateway.services.canopen import CanopenServices
from gateway.services.loop import Services
from gateway.services.sources.base import BaseSource, SourceContext
from gateway.shadow.log_writer import keep
from gateway.shadow.modbus_source import ShadowModbusSource
from gateway.shadow.plan import LINES
from gateway.shadow.source import ShadowSource
from protocols.base.machine import Ns, ms

KEEP_EVERY: Ns = ms(1_000)


class ShadowServices(Services):
    """All command sources of one shadow."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        self._keep_next: Ns = 0
        super().__init__(plan, fds)

    def _line(self, post: SourceContext, line: Line) -> BaseSource:
        return ShadowSource(post, line)

    def _server(self, post: SourceContext, settings: Modbus) -> BaseSource:
        made = ShadowModbusSource(post)
        made.follow(settings, post.run.plan.taps[settings.name])
        made.listen(settings)
        return made

    def _masters(self, fds: dict[str, int]) -> CanopenServices:
        """None: nodes are started up by the old controller."""
        return CanopenServices(replace(self.run_context.plan, buses={}), fds, self.run_context.journal.write)

    def tick(self) -> None:
        """Also read the captures, and keep the findings."""
        tapped = [source for source in self.sources if isinstance(source, ShadowModbusSource)]
        for source in tapped:
            source.take(time.monotonic_ns())
        super().tick()
        now = time.monotonic_ns()
        for source in tapped:
            source.compare(now)
        if now >= self._keep_next:
            self._keep_next = now + KEEP_EVERY
            self.keep(now)

    def keep(self, now: Ns) -> None:
        """For the report, whatever becomes of this process."""
        lines = [source.result(now) for source in self.sources if isinstance(source, ShadowSource | ShadowModbusSource)]
        heard_s = round((now - self.started_ns) / 1e9, 3)
        keep(self.run_context.plan.folder / LINES, {"pid": os.getpid(), "heard_s": heard_s, "lines": lines})

    async def run(self) -> None:
        """Until SIGTERM; judge the rest at the end."""
        await super().run()
        for source in self.sources:
            if isinstance(source, ShadowSource | ShadowModbusSource):
                source.comparison.finish()
        self.keep(time.monotonic_ns())


async def _run(plan: RunPlan, fds: dict[str, int]) -> None:
    await ShadowServices(plan, fds).run()


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate shadow services", description="started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_run(load_plan(arguments.plan), fds_from_text(arguments.fds)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
