"""The pendant of a Reis in the services: keys in, 20 lines out; its orders take the path of every other command source (AX-1660)."""

from collections.abc import Sequence
from pathlib import Path

from gateway.assembly.program_memory import memory_folder
from gateway.files.texts import read_texts
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.controller import Controller
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.reis.access import Codes
from gateway.pure.controllers.reis.binary import Area
from gateway.pure.controllers.reis.control import ReisControl
from gateway.pure.controllers.reis.pendant.phg import Phg
from gateway.pure.controllers.reis.pendant.unit import MOVEMENT, UNIT
from gateway.pure.controllers.reis.pendant.view import Order, View
from gateway.pure.image.reasons import CommandState, text
from gateway.pure.reports.spoken import Spoken
from gateway.services.reis_memory import ReisMemory
from protocols.base.machine import Ns, ms

HELD_NS = ms(500)  # a held key without a repeat for so long is released
PULSE_NS = ms(100)  # a key that is only pressed
OVERRIDE_STEP = 0.05
TURN = 0.1  # of the wheel in Position Control
RESOLUTION = 4096  # increments of a resolver per motor turn (L1357)
LEVELS = {"START": "start", "EXEC": "exec"}
NO_MEMORY = "no memory: [controller] memory names its folder"


class ReisPanel:
    """turns: motor turns for a mm or degree of each axis; folder: of the memory, where there is one."""

    def __init__(
        self, control: ReisControl, dispatcher: CommandDispatcher, codes: Codes, language: str, turns: Sequence[float], folder: Path | None
    ) -> None:
        self._control, self._dispatcher, self._language = control, dispatcher, language
        self._turns = turns
        self.memory = None if folder is None else ReisMemory(folder)
        self.phg = Phg(codes, language)
        self._spoken = Spoken(read_texts("robotstar").pairs() if language == "de" else ())
        self._held: dict[str, Ns] = {}  # key -> when it is released
        self._unseen: set[str] = set()  # pressed since the last step of the control: released only after it (a short click counts)
        self._source = 0  # who pressed last

    def _says(self, words: str) -> None:
        """In the language of the cell."""
        self.phg.says(self._spoken.german(words))

    # ---- one cycle ---------------------------------------------------------------------------------------------------------
    def look(self, now: Ns) -> None:
        """Before a step of the control: released keys, a refused START, answers of the memory."""
        for key in [key for key, end in self._held.items() if now >= end and key not in self._unseen]:
            self._release(key)
        self._unseen.clear()
        programs = self._control.robot.programs
        if programs is not None and programs.refused:
            self._says(programs.refused)
            programs.refused = ""
        while self.memory is not None and (answer := self.memory.take()) is not None:
            if answer.folders:
                self.phg.listed(answer.folders)
            if answer.rows:
                self.phg.opened(answer.path, answer.rows, answer.step)
            if answer.words:
                self._says(answer.words)

    def judge_reset(self, now: Ns) -> str:
        """No reset is chosen here: QUIT acknowledges, and the drives are the command sources'."""
        return ""

    def answer(self, request: dict[str, object], source: int, now: Ns) -> dict[str, object]:
        """Return the display; with `key` after a key, with `hold` while one is held, with `release` when it is released."""
        self.phg.see(self._view())
        key = str(request.get("key") or request.get("hold") or request.get("release") or "").upper()
        if key and key not in UNIT.names:
            return {"error": f"{key}: not a key of the pendant"}
        if "release" in request and key in self._unseen:
            self._held[key] = now
        elif "release" in request:
            self._release(key)
        elif key:
            self._source = source
            self._press(key, now, held="hold" in request, first=request.get("first") is not False)
        else:
            self._obeyed(now)
        self.phg.see(self._view())
        mode = self.phg.view.operating
        return {"screen": self.phg.lines(), "mode": mode, "lost_keys": 0, "unit": UNIT.facts(), "held": sorted(self._held)}

    def _press(self, key: str, now: Ns, *, held: bool, first: bool) -> None:
        if held and not first and key not in self._held:
            return  # it was released in between: a held key begins once (AX-641)
        if held and key in MOVEMENT:
            self._move(key, now)
        elif held and key in self._held:
            self._held[key] = now + HELD_NS
        else:
            self.phg.press(key)
            if self._obeyed(now) and key in LEVELS:
                self._control.robot.keys.put(f"key.{LEVELS[key]}", 1)
                self._unseen.add(key)
                self._held[key] = now + (HELD_NS if held else PULSE_NS)

    def _move(self, key: str, now: Ns) -> None:
        """A movement key is held: it moves for who has control, and no longer than he holds it (L175)."""
        wrong = "" if self._dispatcher.owns(self._source) else "movement keys need control: request it first"
        wrong = wrong if self._control.robot.programs is not None else NO_MEMORY
        if wrong or not (key in self._held or self.phg.moves(key)):
            self._release(key)
            if wrong:
                self.phg.says(wrong)
            return
        number, way = MOVEMENT[key]
        if key not in self._held:  # messages shown while it is held stay
            self.phg.says("")
        self._control.robot.keys.hand.put(f"jog.{number}", way)
        self._held[key] = now + HELD_NS

    def _obeyed(self, now: Ns) -> bool:
        """Carry out the pendant's orders; False: one was refused."""
        orders, self.phg.orders = self.phg.orders, []
        refused = [wrong for order in orders if (wrong := self._obey(order, now))]
        for wrong in refused:
            self._says(wrong)
        return bool(orders) and not refused

    def _release(self, key: str) -> None:
        self._held.pop(key, None)
        keys = self._control.robot.keys
        if key in LEVELS:
            keys.put(f"key.{LEVELS[key]}", 0)
        elif key in MOVEMENT and keys.hand.ways[MOVEMENT[key][0] - 1] == MOVEMENT[key][1]:
            keys.hand.put(f"jog.{MOVEMENT[key][0]}", 0)

    # ---- orders ------------------------------------------------------------------------------------------------------------
    def _obey(self, order: Order, now: Ns) -> str:
        """Carries it out; "" or why not."""
        if order.do in ("list", "open", "delete", "copy", "rename", "protect", "change"):
            if self.memory is None:
                return NO_MEMORY if order.do != "list" else ""
            return "" if self.memory.ask(order.do, order.text, order.more) else "too many orders wait"
        if order.do in ("start", "exec", "stop", "quit", "level", "macro", "look"):
            return self._program(order, now)
        return self._state(order, now)

    def _program(self, order: Order, now: Ns) -> str:
        programs = self._control.robot.programs
        if programs is None:
            return NO_MEMORY
        mover = self._source if self._dispatcher.owns(self._source) else 0
        match order.do:
            case "start" | "exec":
                programs.moves_for(mover)
                return programs.select(order.text, int(order.number)) if order.text else ""
            case "stop":
                programs.stop(now)
            case "quit":
                programs.acknowledge()
                if self._control.plc is not None:
                    self._control.plc.acknowledge()
            case "level":
                programs.orders.append({"do": "key", "key": order.text.upper()})
            case "macro":
                return programs.start(self._named(order.text), mover)
            case "look":
                programs.orders.append({"do": "look", "name": order.text})
        return ""

    def _named(self, name: str) -> str:
        """A program anywhere in the memory by its name alone."""
        programs = self._control.robot.programs
        keys = [str(row["name"]) for row in programs.programs] if programs is not None else []
        return next((key for key in keys if key.rpartition("/")[2] == name), name)

    def _state(self, order: Order, now: Ns) -> str:
        robot, hand = self._control.robot, self._control.robot.keys.hand
        match order.do:
            case "test" | "coor" | "mouse" | "position" | "wheel" if robot.programs is None:
                return NO_MEMORY
            case "test":
                robot.keys.put("mode", int(order.text))
            case "coor":
                hand.put("coord", order.number)
            case "mouse":
                hand.put(f"mouse.{order.text}", not (hand.moves if order.text == "t" else hand.turns))
            case "position":
                hand.put("position", min(order.number, 100.0))
            case "wheel":
                hand.put("wheel", hand.wheel + order.number * TURN)
            case "suppress":
                robot.suppress()
            case "plc" if self._control.plc is None:
                return "this cell has no integrated PLC"
            case "plc" if self._control.plc is not None:
                self._control.plc.orders.append({"do": "start", "name": ""})
                self.phg.says("the PLC is started")
            case "override":
                return self._override(order.number, now)
        return ""

    def _override(self, ways: float, now: Ns) -> str:
        """The regulator is a command like everybody's, and needs control."""
        wanted = min(max(self._control.cell.override + ways * OVERRIDE_STEP, 0.0), 1.0)
        job = self._dispatcher.command(self._source, Command(Code.OVERRIDE, velocity=round(wanted, 4)), now)
        return text(job.reason, self._language, job.detail) if job.state is CommandState.REFUSED else ""

    # ---- the cell ----------------------------------------------------------------------------------------------------------
    def _view(self) -> View:
        control, setup = self._control, self._control.setup
        robot, cell, hand = control.robot, control.cell, control.robot.keys.hand
        programs = robot.programs
        axes = [
            (name, state.actual * factor, "mm" if factor == 1000.0 else "deg")
            for name, state, factor in zip(setup.axes, cell.axes, setup.unit_per_si, strict=False)
        ]
        row = next(iter(programs.rows), {}) if programs is not None else {}
        status, plc = control.status(), control.plc
        message = str(status["message"]) or (str(plc.shown["text"]) if plc is not None and plc.shown is not None else "")
        mode = ("auto" if control.automatic else "") if programs is None else programs.mode
        return View(
            cell.override * 100.0, mode, programs.selected if programs is not None else "", str(row.get("program", "")),
            int(str(row.get("line", 0))), str(row.get("state", "")), str(row.get("waits", "")), self._spoken.german(message), tuple(axes),
            programs.tcp([place for _, place, _ in axes]) if programs is not None else (),
            tuple(round(place * turns * RESOLUTION) for (_, place, _), turns in zip(axes, self._turns, strict=False)),
            control.io.content(Area.INPUT), control.io.content(Area.OUTPUT), control.flag_bytes(), bool(status["synchronous"]), hand.coord,
            hand.moves, hand.turns, hand.position, programs.looked if programs is not None else ("", None, ""),
            int(str(row.get("done", 0))),
        )  # fmt: skip


def reis_panel(cell: Cell, control: Control, dispatcher: CommandDispatcher) -> ReisPanel:
    """The panel of a checked cell."""
    assert isinstance(control, ReisControl) and cell.controller is not None  # as the row of the registry has it
    turns = tuple(axis.mechanics.ratio / axis.mechanics.feed_per_turn for axis in cell.axis)
    return ReisPanel(control, dispatcher, codes_of(cell.controller), cell.cell.language, turns, memory_folder(cell))


def codes_of(controller: Controller) -> Codes:
    """Code words 1 and 2 and the PIN, in capitals as the keys of the pendant type them."""
    first, second = (*controller.code_words, "", "")[:2]
    return Codes(first.upper(), second.upper(), controller.pin.upper())
