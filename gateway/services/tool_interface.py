"""The command source for commissioning tools: commands and SDO through the services' socket, under the same rules as every other command
source.

Control belongs to the connection that requested it and ends with it: another one gets "not owner" (AX-611).  Commands, SDO and "alive"
of that connection are its life; reading is not.  After a second of silence it counts as dead: the axes stop on the path.  A tool never has
more rights than a PLC; only in a full simulation it may set the enabling inputs, because no PLC is there to do it (AX-312).
"""

import threading

from drivers.drives.canopen_steps import Refused
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job, OnLoss
from gateway.pure.controllers.rho3.signals.modes import AUTO_MN
from gateway.pure.image.reasons import CommandState, Reason, Refusal
from gateway.pure.image.records.cell import Motion, Quality
from gateway.registry import CONTROLLERS
from gateway.services.canopen import CanopenServices
from gateway.services.context import RunContext
from gateway.services.shared_image import SharedImage
from gateway.services.tool_streams import ToolStreams
from protocols.base.machine import Ns, ms

TOOL_SOURCE = 90
SILENCE: Ns = ms(1000)
ENABLING_BITS, ENABLING_BYTE = range(24, 29), 3
PERMIT_BYTES = (AUTO_MN >> 3, ENABLING_BYTE)
LIFE = ("alive", "tool", "pace", "sdo", "permit", "stream")  # requests that show that the connection in control lives
MOST_SDO, TICKETS_KEPT = 8, 64  # SDO requests under way at a time, each in a thread; answers that wait to be fetched


class ToolInterface:
    """Requests of one tool at a time; the page has its own interface (gateway.services.page_interface)."""

    def __init__(
        self,
        run: RunContext,
        image: SharedImage,
        dispatcher: CommandDispatcher,
        canopen: CanopenServices,
        source: int = TOOL_SOURCE,
        name: str = "commissioning tool",
    ) -> None:
        self._run, self._image, self._dispatcher, self._canopen = run, image, dispatcher, canopen
        self._source, self._name = source, name
        self._heard: Ns = 0
        self.alive = False
        self.permits = False  # the tool has set the enabling inputs of a simulated cell
        self._jobs: dict[int, Job] = {}
        self._tickets: dict[int, dict[str, object]] = {}
        self._under_way, self._sdo_lock, self._next_ticket = 0, threading.Lock(), 1
        self._streams = ToolStreams(dispatcher, image.statements)
        self._holder: object | None = None  # connection in control
        self._permitting: tuple[object, Ns] | None = None  # connection that set the enabling inputs, last heard
        self._leaving = False  # the connection in control is lost: control ends as soon as the axes rest
        dispatcher.control.link(source, alive=False)

    def wake(self, now: Ns) -> None:
        """A silent tool is dead; its control ends at rest."""
        if self.alive and now - self._heard > SILENCE:
            self._lost()
        if self._permitting is not None and now - self._permitting[1] > SILENCE:
            self._permitting, self.permits = None, False
        if self._leaving and self._at_rest:
            self._leaving = False
            if self._dispatcher.owns(self._source):
                self._dispatcher.control.release(self._source, at_rest=True)

    def heard(self) -> None:
        """The connection in control is alive."""
        self._heard = self._run.clock()
        if not self.alive:
            self.alive = True
            self._dispatcher.link(self._source, OnLoss.STOP, alive=True)

    def holds(self, connection: object) -> bool:
        """This connection is in control."""
        return self._holder is connection and self._dispatcher.owns(self._source)

    def held_by_another(self, connection: object) -> bool:
        """A living connection other than this one is in control."""
        return self.alive and self._holder is not None and self._holder is not connection

    def closed(self, connection: object) -> None:
        """A connection has ended, and its control with it."""
        if self._permitting is not None and self._permitting[0] is connection:
            self._permitting, self.permits = None, False
        self.leave(connection)

    def leave(self, connection: object) -> None:
        """Give up control whatever moves: the axes stop on the path, and control is free at rest."""
        if self._holder is connection:
            self._holder, self._leaving = None, True
            if self.alive:
                self._lost()
            self._image.pass_on()

    def _lost(self) -> None:
        self.alive = False
        self._dispatcher.link(self._source, OnLoss.STOP, alive=False)
        self._run.journal.write("link", f"{self._name}: gone", source=self._source)

    @property
    def _at_rest(self) -> bool:
        return self._image.state.motion_of(self._dispatcher.control.axes_of(self._source)) in (Motion.IDLE, Motion.STOPPED)

    def answer(self, request: dict[str, object], connection: object = "") -> dict[str, object] | None:
        """None: not for this part.  KeyError, ValueError: reported to the tool as an error."""
        operation = request.get("op")
        if operation not in ("alive", "leave", "tool", "pace", "job", "axes", "sdo", "ticket", "permit", "programs", "stream"):
            return None
        if self._permitting is not None and self._permitting[0] is connection:
            self._permitting = (connection, self._run.clock())
        if operation in LIFE and self._holder is connection:
            self.heard()
        match operation:
            case "alive":
                return {"ok": True, "holds": self.holds(connection)}
            case "leave":
                self.leave(connection)
                return {"ok": True}
            case "tool":
                return self._command(request, connection)
            case "job" | "pace":
                number = int(str(request["job"]))
                return self._job(number) if operation == "job" else self._pace(number, float(str(request["share"])), connection)
            case "sdo":
                return self._sdo(request, connection)
            case "ticket":
                return self._tickets.get(int(str(request["ticket"])), {"error": "no such ticket"})
            case "permit":
                return self._permit(connection)
            case "programs":
                return self._programs()
            case _:
                return self._stream(request, connection) if operation == "stream" else self._axes()

    def _command(self, request: dict[str, object], connection: object) -> dict[str, object]:
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
        job = self._given(command, connection, first_try=bool(request.get("first_try")))
        if "share" in request and job.open:
            self._dispatcher.slow_move(job, _share(float(str(request["share"]))))
        self._jobs = {key: old for key, old in self._jobs.items() if old.open}
        self._jobs[job.id] = job
        self._image.pass_on()
        return {"job": job.id, **_job_row(job)}

    def _pace(self, number: int, share: float, connection: object) -> dict[str, object]:
        """A move of this connection goes at another share, 0 .. 1, of the speed it was planned with; one that is over stays so."""
        if self._holder is not connection or not self._dispatcher.owns(self._source):
            return {"error": f"not owner: only the {self._name} in control may change the pace of its move"}
        job = self._jobs.get(number)
        if job is not None and job.open:
            self._dispatcher.slow_move(job, _share(share))
            self._image.pass_on()
        return {"ok": True}

    def _given(self, command: Command, connection: object, *, first_try: bool) -> Job:
        """Pass a command to the dispatcher if this connection may send it."""
        dispatcher = self._dispatcher
        try:
            self._demand(Code(command.code), connection)
        except Refusal as refusal:
            return dispatcher.refuse(self._source, Code(command.code), refusal.reason, refusal.detail)
        job = dispatcher.command(self._source, command, self._run.clock(), first_try=first_try)
        if command.code == Code.REQUEST_CONTROL and job.state is not CommandState.REFUSED:
            self._holder, self._leaving = connection, False
            self.heard()
        elif command.code == Code.RELEASE_CONTROL and job.state is CommandState.DONE:
            self._holder = None
        return job

    def _demand(self, code: Code, connection: object) -> None:
        """Refusal: another connection has control, or this one has not requested it.  A stop is always permitted."""
        if code is Code.STOP or self._holder is connection:
            return
        if self.held_by_another(connection):
            raise Refusal(Reason.NOT_OWNER, f"another {self._name} has it")
        if code is not Code.REQUEST_CONTROL:
            raise Refusal(Reason.NOT_OWNER, "request it first")
        if self._dispatcher.owns(self._source):  # left over from a lost or silent connection
            self._dispatcher.control.release(self._source, at_rest=self._at_rest)

    def _job(self, number: int) -> dict[str, object]:
        job = self._jobs.get(number) or next((job for job in self._jobs.values() if job.watch == number), None)
        return {"error": f"no job {number}"} if job is None else {"job": job.id, **_job_row(job)}

    def _axes(self) -> dict[str, object]:
        """The cycle's last publication, in the axes' own units."""
        state, dispatcher = self._image.state, self._dispatcher
        rows: list[dict[str, object]] = []
        for n, (fact, axis) in enumerate(zip(dispatcher.axes, state.axes, strict=False)):
            places = {"actual": axis.actual / fact.si, "set": axis.set / fact.si, "lag": axis.lag / fact.si, "torque": axis.torque}
            if state.measured_mask >> n & 1:
                places["measured"] = axis.measured / fact.si  # @MPOS
            words = self._canopen.fault(n, axis.fault_code) if axis.fault_code else ""
            planner = dispatcher.planner
            placed = planner is not None and bool(planner.placed >> n & 1)
            state_row = {
                "flags": int(axis.flags),
                "fault": axis.fault_code,
                "words": words,
                "why": self._canopen.why_not(n),
                "placed": placed,
            }
            rows.append({"name": fact.name, "unit": fact.unit, **places, **state_row})
        return {"axes": rows, "cycle": state.cycle, "ready": state.ready, "motion": int(state.motion), "permits": state.permits,
                "cause": state.stop_cause, "override": state.override, "simulated": self._run.plan.simulated,
                "p5_ms": self._run.plan.p5_ms}  # fmt: skip

    def _programs(self) -> dict[str, object]:
        """Programs of the cell by number, and how far the planner is; op "tool", code "program", mask = number orders one."""
        dispatcher = self._dispatcher
        planner, state = dispatcher.planner, self._image.state
        shown = None if planner is None else planner.under_way
        way = {} if shown is None else {"block": shown.block, "share": shown.share, "waiting": shown.waiting}
        return {
            "programs": {str(number): program.name for number, program in sorted(dispatcher.programs.items())},
            "planner": planner is not None,
            "running": state.job,
            **way,
        }

    def _stream(self, request: dict[str, object], connection: object) -> dict[str, object]:
        """A stream of blocks of this connection: begin, say, look."""
        if request.get("do") == "begin":
            mask, robot = int(str(request["mask"])), int(str(request.get("robot", 1)))
            try:
                self._demand(Code.PROGRAM, connection)
            except Refusal as refusal:
                return _job_row(self._dispatcher.refuse(self._source, Code.PROGRAM, refusal.reason, refusal.detail))
            job = self._dispatcher.order_stream(self._source, robot, mask)
            self._jobs[job.id] = job
            self._streams.begin(job)
        else:
            number = int(str(request["job"]))
            if number not in self._jobs:
                raise ValueError(f"no stream {number}: begin one")
            job = self._jobs[number]
            if request.get("do") != "look":
                if self._holder is not connection:
                    raise ValueError("not owner: the connection that began the stream sends its blocks and orders")
                self._ordered(job, request)
        self._image.pass_on()
        return {"job": job.id, **_job_row(job), **self._streams.answer(job)}

    def _ordered(self, job: Job, request: dict[str, object]) -> None:
        """Blocks of a stream, or an order to it."""
        what, lines, block = str(request.get("do", "")), request.get("lines"), request.get("block")
        if what == "say":
            texts = [] if lines is None else lines
            if not isinstance(texts, list):
                raise ValueError("say: lines is a list of statements")
            self._streams.say(job, [str(line) for line in texts], str(request.get("then", "")))
            return
        if block is not None and not isinstance(block, int):
            raise ValueError(f"{what}: block {block!r} is not a number")
        try:
            self._streams.order(job, what, block, on=request.get("on", True) is not False)
        except Refusal as refusal:
            raise ValueError(f"{what}: {refusal.reason.name} {refusal.detail}".rstrip()) from refusal

    def _permit(self, connection: object) -> dict[str, object]:
        if not self._run.plan.simulated:
            return {"error": "enabling inputs are set by their command source; a tool may do it in a simulation only"}
        self.permits, self._permitting = True, (connection, self._run.clock())
        controller = self._run.cell.controller
        automatic = (
            (AUTO_MN,) if controller is not None and (CONTROLLERS[controller.kind].parameters or controller.memory) else ()
            # programs run in automatic alone
        )
        for bit in (*ENABLING_BITS, *automatic):
            self._image.put_bit(bit, True)
            self._image.judge((bit >> 3,), Quality.GOOD, self._run.clock())
        self._image.pass_on()
        return {"ok": True}

    def _sdo(self, request: dict[str, object], connection: object) -> dict[str, object]:
        """In a thread: command sources do not wait for a node; `ticket` returns the outcome."""
        master, node = self._canopen.place(str(request["axis"]))
        index, sub = int(str(request["index"])), int(str(request.get("sub", 0)))
        raw = request.get("data")
        data = None if raw is None else bytes.fromhex(str(raw))
        if data is not None and self.held_by_another(connection):
            raise ValueError(f"not owner: another {self._name} has control; only it may write objects")
        with self._sdo_lock:
            if self._under_way >= MOST_SDO:
                raise ValueError(f"{MOST_SDO} SDO requests are under way; wait for one of them, then ask again")
            self._under_way += 1
            number, self._next_ticket = self._next_ticket, self._next_ticket + 1
            self._tickets[number] = {"pending": True}
            for old in [each for each, outcome in self._tickets.items() if "pending" not in outcome][
                : max(len(self._tickets) - TICKETS_KEPT, 0)
            ]:
                del self._tickets[old]

        def work() -> None:
            outcome: dict[str, object] = {"error": "no answer"}
            try:
                with master.nodes[node].lock:
                    answer = master.upload(node, index, sub) if data is None else master.download(node, index, sub, data)
                if isinstance(answer, bytes):
                    outcome = {"data": answer.hex()}
                elif isinstance(answer, Refused):
                    outcome = {"error": str(answer)}
            finally:
                with self._sdo_lock:
                    self._under_way -= 1
                    self._tickets[number] = outcome

        threading.Thread(target=work, name="sdo of a tool", daemon=True).start()
        return {"ticket": number}


def _share(value: float) -> float:
    if not 0.0 < value <= 1.0:
        raise ValueError(f"share {value:g}: above 0, at most 1")
    return value


def _job_row(job: Job) -> dict[str, object]:
    return {"state": job.state.name, "reason": int(job.reason), "words": job.reason.name, "detail": job.detail, "open": job.open}
