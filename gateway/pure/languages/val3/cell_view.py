"""What the dashboard shows of an application in a cell, and what an operator does there (AX-993).  Pure."""

import json
from collections.abc import Mapping

from gateway.pure.image.records.interpreter import Fact
from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.pages import EVENTS
from gateway.pure.languages.val3.virtual import shown_container
from gateway.pure.languages.val3.virtual_events import Event, EventFault, put

MOST_VARIABLES = 200
LONGEST = 160  # characters of a value that are shown
MOST_SHOWN = 300  # attributes of a user page
POPUPS = 10
MODES = {1: "manual", 2: "test", 3: "local", 4: "remote"}

DIGITS = 4  # after the decimal point: a tenth of a micrometre
PLACES = ("j1", "x", "shoulder")  # first fields of joint, trsf and config, whose values are written without names

Seen = dict[str, object]


def seen(machine: Machine, own: Instance, popups: list[str]) -> Seen:
    """Return the view with lists only at the top: they are shortened at their ends to fit into the report."""
    moves, robot = machine.moves_or_none, machine.robot
    state = {
        "application": own.loaded.app.name,
        "mode": MODES.get(robot.mode, ""),
        "powered": robot.powered,
        "speed": robot.speed,
        "hold": robot.hold,
        "move": round(moves.stack.get_move_id(), 3) if moves is not None else 0.0,
        "empty": moves.stack.is_empty() if moves is not None else True,
        "connect": moves is not None and moves.connecting,
        "page": machine.pages.current,
        "folder": machine.pages.folder,
        "title": machine.screen.title,
        "prompt": machine.prompts[0].text if machine.prompts else "",
        "kind": machine.prompts[0].kind if machine.prompts else "",
    }
    attributes = [[name, attribute, text[:LONGEST]] for name, attribute, text in machine.pages.rows(machine.pages.current)]
    lines = [line.rstrip() for line in machine.screen.lines]
    while lines and not lines[-1]:
        lines.pop()
    return {
        "val3": [state],
        "variables": _variables(machine, own),
        "shown": attributes[:MOST_SHOWN],
        "popups": popups[-POPUPS:],
        "screen": lines,
    }


def _variables(machine: Machine, own: Instance) -> list[list[str]]:
    """Name, type, value as VAL 3 writes it."""
    found = []
    for name in sorted(own.data)[:MOST_VARIABLES]:
        declared = own.loaded.app.data[name]
        try:
            text = written(shown_container(machine, own.data[name]))
        except (RuntimeFault, Rte):  # an input in fault
            text = "?"
        found.append([name, str(declared.type), text[:LONGEST]])
    return found


def written(value: object) -> str:
    """As VAL 3 writes it: `{0, 20, 100, 0, 60, 0}`; other structures with the names of their fields, arrays in brackets."""
    match value:
        case bool():
            return str(value).lower()
        case float():
            return f"{round(value, DIGITS) + 0.0:.{DIGITS}f}".rstrip("0").rstrip(".")
        case list():
            return f"[{', '.join(map(written, value))}]"
        case dict():
            plain = next(iter(value), "") in PLACES
            return f"{{{', '.join(f'{_bare(each)}' if plain else f'{name} = {written(each)}' for name, each in value.items())}}}"
        case None:
            return ""
    return json.dumps(value, ensure_ascii=False)


def _bare(value: object) -> str:
    """Words of a configuration have no quotes."""
    return value if isinstance(value, str) else written(value)


def act(machine: Machine, own: Instance, order: Mapping[str, Fact]) -> str:
    """An operator's click, entry, answer or value; why it is not carried out, "" where it is."""
    what, value = str(order["what"]), str(order.get("value", ""))
    try:
        match order["act"]:
            case "event":
                if value not in EVENTS:
                    return f"{value}: there are {', '.join(EVENTS)}"
                return machine.pages.happen(machine.pages.current, what, value)
            case "enter":
                if not machine.pages.enter(machine.pages.current, what, str(order.get("attribute") or "value"), value):
                    return f"{what}: {value!r} is not taken"
            case "answer":
                if not machine.prompts:
                    return "no prompt waits for an answer"
                machine.answers.append(value)
            case "key":
                if not machine.screen.press(value):
                    return f"{value!r} is not a key: one character or the number of a key is expected"
            case "set":
                put(machine, own, Event(0, what, value))
    except (EventFault, Rte, RuntimeFault) as fault:
        return str(fault)
    return ""
