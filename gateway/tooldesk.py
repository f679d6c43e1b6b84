"""The door for commissioning tools: commands and SDO through the services' socket, under the same rules as every other door.

A tool that falls silent for a second counts as dead: the axes stop on the path.  It never has more rights than a PLC; only where
everything is simulated it may set the enabling inputs, because nobody else is there to do it (AX-312).
"""

import threading
import time
from typing import TYPE_CHECKING

from drivers.drives.canopen_steps import Refused
from gateway.pure.command_block import Code, Command
from gateway.pure.jobs import Job, OnLoss
from gateway.pure.records import Quality, set_bit
from protocols.base.machine import Ns, ms

if TYPE_CHECKING:
    from gateway.processes.services import Services

TOOL_DOOR = 90
SILENCE: Ns = ms(1000)
ENABLING_BITS, ENABLING_BYTE = range(24, 29), 3


class ToolDesk:
    """Requests of one tool at a time; the page has a desk of its own (gateway.pagedesk)."""

    def __init__(self, services: "Services", door: int = TOOL_DOOR, name: str = "commissioning tool") -> None:
        self._services, self._door, self._name = services, door, name
        self._heard: Ns = 0
        self.alive = False
        self.permits = False  # the tool has set the enabling inputs of a simulated cell
        self._jobs: dict[int, Job] = {}
        self._tickets: dict[int, dict[str, object]] = {}
        services.office.control.link(door, alive=False)

    def wake(self, now: Ns) -> None:
        """A silent tool is a dead one."""
        if self.alive and now - self._heard > SILENCE:
            self.alive = self.permits = False
            self._services.office.link(self._door, OnLoss.STOP, alive=False)
            self._services.journal.write("link", f"{self._name}: gone", door=self._door)

    def heard(self) -> None:
        """It is there."""
        self._heard = time.monotonic_ns()
        if not self.alive:
            self.alive = True
            self._services.office.link(self._door, OnLoss.STOP, alive=True)

    def answer(self, request: dict[str, object]) -> dict[str, object] | None:
        """None: not for us.  KeyError, ValueError: told to the tool as an error."""
        operation = request.get("op")
        if operation not in ("tool", "job", "axes", "sdo", "ticket", "permit", "programs"):
            return None
        self.heard()
        match operation:
            case "tool":
                return self._command(request)
            case "job":
                return self._job(int(str(request["job"])))
            case "sdo":
                return self._sdo(request)
            case "ticket":
                return self._tickets.get(int(str(request["ticket"])), {"error": "no such ticket"})
            case "permit":
                return self._permit()
            case "programs":
                return self._programs()
            case _:
                return self._axes()

    def _command(self, request: dict[str, object]) -> dict[str, object]:
        targets = request.get("targets") or []
        if not isinstance(targets, list):
            raise ValueError("targets: a list of numbers")
        values = [float(target) for target in targets]
        command = Command(
            Code[str(request["code"]).upper()],
            int(str(request.get("mask", 0))),
            float(str(request.get("velocity", 1.0))),
            float(str(request.get("acceleration", 1.0))),
            tuple(values),
        )
        job = self._services.office.command(self._door, command, time.monotonic_ns(), first_try=bool(request.get("first_try")))
        self._jobs = {key: old for key, old in self._jobs.items() if old.open}
        self._jobs[job.id] = job
        self._services.flush()
        return {"job": job.id, **_told(job)}

    def _job(self, number: int) -> dict[str, object]:
        job = self._jobs.get(number) or next((job for job in self._jobs.values() if job.watch == number), None)
        return {"error": f"no job {number}"} if job is None else {"job": job.id, **_told(job)}

    def _axes(self) -> dict[str, object]:
        """What the cycle published last, in the axes' own units."""
        services, state = self._services, self._services.values.state
        rows: list[dict[str, object]] = []
        for n, (fact, axis) in enumerate(zip(services.office.axes, state.axes, strict=False)):
            places = {"actual": axis.actual / fact.si, "set": axis.set / fact.si, "lag": axis.lag / fact.si, "torque": axis.torque}
            if state.measured_mask >> n & 1:
                places["measured"] = axis.measured / fact.si  # @MPOS
            words = services.canopen.fault(n, axis.fault_code) if axis.fault_code else ""
            planner = services.office.planner
            placed = planner is not None and bool(planner.placed >> n & 1)
            told = {
                "flags": int(axis.flags),
                "fault": axis.fault_code,
                "words": words,
                "why": services.canopen.why_not(n),
                "placed": placed,
            }
            rows.append({"name": fact.name, "unit": fact.unit, **places, **told})
        return {"axes": rows, "cycle": state.cycle, "ready": state.ready, "motion": int(state.motion), "permits": state.permits,
                "cause": state.stop_cause, "override": state.override, "simulated": services.plan.simulated,
                "p5_ms": services.plan.p5_ms}  # fmt: skip

    def _programs(self) -> dict[str, object]:
        """Programs of the cell by number, and how far the planner is; op "tool", code "program", mask = number orders one."""
        office = self._services.office
        planner, state = office.planner, self._services.values.state
        way = {} if planner is None else {"block": planner.block, "share": planner.share, "waiting": planner.waiting}
        return {
            "programs": {str(number): program.name for number, program in sorted(office.programs.items())},
            "planner": planner is not None,
            "running": state.job,
            **way,
        }

    def _permit(self) -> dict[str, object]:
        services = self._services
        if not services.plan.simulated:
            return {"error": "enabling inputs are set by their door; a tool may do it in a simulation only"}
        self.permits = True
        for bit in ENABLING_BITS:
            set_bit(services.inputs.values, bit, True)
        services.inputs.quality[ENABLING_BYTE] = Quality.GOOD
        services.inputs.stamps[ENABLING_BYTE] = time.monotonic_ns()
        services.flush()
        return {"ok": True}

    def _sdo(self, request: dict[str, object]) -> dict[str, object]:
        """In a thread: doors do not wait for a node; `ticket` tells the outcome."""
        master, node = self._services.canopen.place(str(request["axis"]))
        index, sub = int(str(request["index"])), int(str(request.get("sub", 0)))
        raw = request.get("data")
        number = len(self._tickets) + 1
        self._tickets[number] = {"pending": True}

        def work() -> None:
            with master.nodes[node].lock:
                answer = master.upload(node, index, sub) if raw is None else master.download(node, index, sub, bytes.fromhex(str(raw)))
            if isinstance(answer, bytes):
                self._tickets[number] = {"data": answer.hex()}
            else:
                self._tickets[number] = {"error": str(answer) if isinstance(answer, Refused) else "no answer"}

        threading.Thread(target=work, name="sdo of a tool", daemon=True).start()
        return {"ticket": number}


def _told(job: Job) -> dict[str, object]:
    return {"state": job.state.name, "reason": int(job.reason), "words": job.reason.name, "detail": job.detail, "open": job.open}
