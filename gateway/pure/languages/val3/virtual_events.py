"""What happens from outside in a virtual run: WHAT=VALUE at a moment."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.boards import UserBoards
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.named_values import NOWHERE, place_of
from gateway.pure.languages.val3.pages import EVENTS
from gateway.pure.languages.val3.robot_state import LOCAL, MANUAL, NO_DATA, REMOTE, TEST
from gateway.pure.languages.val3.screen import code_of
from gateway.pure.languages.val3.strings import finite
from gateway.pure.languages.val3.values import AioV, DioV, LinkV, places
from gateway.pure.languages.val3.virtual_io import Status

STATES = {"works": Status.WORKS, "locked": Status.LOCKED, "simulated": Status.SIMULATED, "fault": Status.FAULT, "unknown": Status.UNKNOWN}
MODES = {"manual": MANUAL, "test": TEST, "local": LOCAL, "remote": REMOTE}
REFRESH = ("default", "nojitter")
MOST_RATIO, MOST_US = 250, 1e6
PUSHED = "one number a joint inside its travel, and an arm at rest without power or on hold, are expected"
WORDS = {"true": 1.0, "on": 1.0, "false": 0.0, "off": 0.0}


class EventFault(Exception):
    """An event that cannot be carried out; one sentence."""


@dataclass(frozen=True, slots=True)
class Event:
    """WHAT=VALUE at a moment."""

    at: Ns
    what: str
    value: str


def event_of(seconds: str, text: str) -> Event:
    """From the command line.  EventFault names the fault."""
    try:
        at = float(seconds)
    except ValueError:
        raise EventFault(f"--at {seconds}: a number of seconds is expected") from None
    what, separator, value = text.partition("=")
    if not separator or not what or not 0 <= at < 1e9:
        raise EventFault(f"--at {seconds} {text}: seconds from 0 and WHAT=VALUE are expected")
    return Event(round(at * 1e9), what.strip(), value.strip())


def number(event: Event) -> float:
    """The value as a number."""
    value = WORDS.get(event.value.lower(), finite(event.value))
    if value is None:
        raise EventFault(f"{event.what}={event.value}: a number, true or false is expected")
    return value


def happen(machine: Machine, own: Instance, event: Event) -> None:
    """What the operator, the plant or the safety board does."""
    kind, _, name = event.what.partition(".")
    if kind in PLANT and name:
        PLANT[kind](machine, linked(machine, own, name) if kind in LINKED else name, event)
    elif event.what in OPERATOR:
        OPERATOR[event.what](machine, event)
    else:
        put(machine, own, event)


def check_events(machine: Machine, own: Instance, events: Iterable[Event]) -> None:
    """Raise EventFault for an unknown name or an invalid value, also of an event after the end of the run."""
    for event in events:
        kind, _, name = event.what.partition(".")
        if (kind in PLANT and name) or event.what in OPERATOR:
            CHECKS.get(kind, _anything)(machine, event)
        else:
            _known(own, event)
            if (found := _found(own, event.what)) is not None:  # else it may be there by then
                _value_for(found, event)


def _found(own: Instance, name: str) -> object:
    """The value of a global; None: it is not there now."""
    try:
        container, place = place_of(own.data, name)
        return places(container)[place]
    except NOWHERE:
        return None


def _known(own: Instance, event: Event) -> None:
    if event.what.partition(".")[0].partition("[")[0] not in own.data:
        raise EventFault(
            f"{event.what}: there is no global of that name; dio., aio., io., sio., page., board., mode, power, speed, estop, hold, "
            "joints, connect, refresh, ratio, brakes, hibernate, wakeup, profile, answer, key and app are known, too"
        )


def linked(machine: Machine, own: Instance, name: str) -> str:
    """What a variable of the application is linked to; the name itself where it is that of an input, output or channel."""
    plain, dot, last = name.rpartition(".")
    if dot and last.isdecimal():  # a connection of a server
        return f"{linked(machine, own, plain)}.{last}"
    if machine.io.find(name) is None and not machine.sio.knows(name):
        found = _found(own, name)
        if isinstance(found, LinkV) and found.link:
            return found.link
    return name


def signal(machine: Machine, name: str, event: Event) -> None:
    """dio.NAME=0 or 1, aio.NAME=value."""
    value = number(event)
    if machine.io.find(name) is None:
        machine.note(f"{event.what}: no data are linked to {name} so far", "SYS")
    machine.io.arrive(machine.io.declare(name), value if event.what.startswith("aio") else float(value != 0))


def state(machine: Machine, name: str, event: Event) -> None:
    """io.NAME=locked: what ioStatus shows."""
    machine.io.declare(name).status = _state_of(machine, event)


def _state_of(_: Machine, event: Event) -> Status:
    return STATES[_one_of(event, STATES)]


def _one_of(event: Event, words: Iterable[str]) -> str:
    if event.value.lower() not in words:
        raise EventFault(f"{event.what}={event.value}: {', '.join(words)} are expected")
    return event.value.lower()


def mode(machine: Machine, event: Event) -> None:
    """The key switch."""
    machine.robot.mode = _mode_of(machine, event)


def _mode_of(_: Machine, event: Event) -> int:
    return MODES[_one_of(event, MODES)]


def speed(machine: Machine, event: Event) -> None:
    """The monitor speed, by the operator."""
    machine.robot.speed = _percent(machine, event)


def _percent(_: Machine, event: Event) -> float:
    value = number(event)
    if not 0 <= value <= 100:
        raise EventFault(f"speed={event.value}: 0 to 100 is expected")
    return value


def estop(machine: Machine, event: Event) -> None:
    """The safety chain."""
    machine.robot.stop(_chain(machine, event))


def _chain(_: Machine, event: Event) -> int:
    value = number(event)
    if value not in (0, 1, 2, 3):
        raise EventFault(f"estop={event.value}: 0, 1, 2, 3 are expected")
    return round(value)


def hold(machine: Machine, event: Event) -> None:
    """The button hold."""
    machine.robot.hold = number(event) != 0


def joints(machine: Machine, event: Event) -> None:
    """joints=J1,J2,..: the arm is jogged or pushed while its power is off or it is held."""
    moves = machine.moves_or_none
    if moves is None or not moves.push(_joints_of(machine, event)):
        raise EventFault(f"joints={event.value}: {PUSHED}")


def _joints_of(machine: Machine, event: Event) -> list[float]:
    values = [finite(part) for part in event.value.split(",")]
    found = [value for value in values if value is not None]
    if len(found) != len(values) or len(found) != machine.axes:
        raise EventFault(f"joints={event.value}: {PUSHED}")
    return found


def ratio(machine: Machine, event: Event) -> None:
    """ratio=N: system cycles from one refresh of the user boards to the next, as set at the pendant."""
    _boards(machine).ratio = _cycles(machine, event)


def _cycles(_: Machine, event: Event) -> int:
    value = number(event)
    if value != -1 and not (value.is_integer() and 1 <= value <= MOST_RATIO):
        raise EventFault(f"ratio={event.value}: -1 or a whole number 1 to {MOST_RATIO} is expected")
    return 1 if value == -1 else int(value)


def board(machine: Machine, name: str, event: Event) -> None:
    """board.NAME=US: duration of one refresh of a user board."""
    _boards(machine).times[name.lower()] = _nanoseconds(machine, event)


def _nanoseconds(_: Machine, event: Event) -> int:
    value = number(event)
    if not 0 <= value <= MOST_US:
        raise EventFault(f"{event.what}={event.value}: 0 to {MOST_US:g} us are expected")
    return round(value * 1000)


def _boards(machine: Machine) -> UserBoards:
    if machine.io.boards is None:
        machine.io.boards = UserBoards()
    return machine.io.boards


def refresh(machine: Machine, event: Event) -> None:
    """refresh=default or noJitter: the mode of the user boards in cell.cfx."""
    _boards(machine).no_jitter = _without_jitter(machine, event)


def _without_jitter(_: Machine, event: Event) -> bool:
    return _one_of(event, REFRESH) == "nojitter"


def brakes(machine: Machine, event: Event) -> None:
    """brakes=R1,R2,..: what brakeTest finds of each axis, 0, 1 or 2; none: no data; at:J1,J2,..: the position in which it is made."""
    service, values = machine.robot.service, _results(machine, event)
    if ":" in event.value:
        service.brake_position = values
    else:
        service.brakes = tuple(int(value) for value in values)


def _results(machine: Machine, event: Event) -> tuple[float, ...]:
    """Return results of the axes, or the position after at:."""
    word, separator, rest = event.value.partition(":")
    if event.value.lower() == "none":
        return (NO_DATA,)
    try:
        values = tuple(float(part) for part in (rest if separator else event.value).split(","))
    except ValueError:
        values = ()
    if len(values) != machine.axes or (word.lower() != "at" if separator else any(value not in (0, 1, 2) for value in values)):
        raise EventFault(f"brakes={event.value}: none, 0, 1 or 2 for each of {machine.axes} axes, or at: and a position are expected")
    return values


def hibernate(machine: Machine, event: Event) -> None:
    """hibernate=CODE: what hibernateRobot answers without power."""
    machine.robot.service.hibernate = _hibernated(machine, event)


def _hibernated(_: Machine, event: Event) -> int:
    return _code(event, (0, -1, -2, -4))


def wake(machine: Machine, event: Event) -> None:
    """wakeup=CODE: what wakeUpRobot answers."""
    machine.robot.service.wake = _woken(machine, event)


def _woken(_: Machine, event: Event) -> int:
    return _code(event, (0, -1, -2, -3))


def profile(machine: Machine, event: Event) -> None:
    """profile=NAME: another user has logged in at the pendant; profile=NAME:PASSWORD is one that setProfile can choose."""
    name, separator, password = event.value.partition(":")
    if separator:
        machine.profiles = {**machine.profiles, name: password}
    else:
        machine.robot.profile = name


def _code(event: Event, codes: tuple[int, ...]) -> int:
    value = number(event)
    if value not in codes:
        raise EventFault(f"{event.what}={event.value}: one of {', '.join(map(str, codes))} is expected")
    return int(value)


def connect(machine: Machine, event: Event) -> None:
    """connect=1: the operator lets the connection move run."""
    if number(event) and machine.moves_or_none is not None:
        machine.moves_or_none.confirm()


def app(machine: Machine, event: Event) -> None:
    """app=stop."""
    _stopped(machine, event)
    machine.stop()


def _stopped(_: Machine, event: Event) -> str:
    return _one_of(event, ("stop",))


def channel(machine: Machine, name: str, event: Event) -> None:
    """The partner of a socket or serial line: connect, disconnect, hex:.. or text, in which \\r and \\n are control characters."""
    machine.sio.now, value = machine.clock, event.value
    plain, _, last = name.rpartition(".")
    which = int(last) if plain and last.isdecimal() else 0
    name = plain if which else name
    match value:
        case "connect":
            machine.sio.connect(name)
        case "disconnect":
            machine.sio.disconnect(name)
        case _:
            data = _telegram(machine, event)
            if not machine.sio.hear(name, data, which):
                machine.note(f"sio {name}: no connection is open, {len(data)} bytes are lost", "SYS")


def _telegram(_: Machine, event: Event) -> bytes:
    try:
        return bytes.fromhex(event.value[4:]) if event.value.startswith("hex:") else text_bytes(event.value)
    except ValueError:
        raise EventFault(f"{event.what}={event.value}: pairs of hexadecimal digits are expected") from None


def text_bytes(text: str) -> bytes:
    """UTF-8 with \\r, \\n and \\t."""
    return text.replace("\\r", "\r").replace("\\n", "\n").replace("\\t", "\t").encode()


def page(machine: Machine, name: str, event: Event) -> None:
    """page.PAGE.OBJECT=click, mousedown, mouseup; page.PAGE.OBJECT.ATTRIBUTE=VALUE is an entry."""
    parts = _object(machine, event)
    if len(parts) == 2:
        if fault := machine.pages.happen(parts[0], parts[1], event.value.lower()):
            machine.note(fault, "PAGE")
    elif not machine.pages.enter(parts[0], parts[1], parts[2], event.value):
        machine.note(f"page {parts[0]}, {parts[1]}.{parts[2]}: the entry {event.value!r} is not taken", "PAGE")


def _object(_: Machine, event: Event) -> list[str]:
    """Page, object, and attribute where it is an entry."""
    parts = event.what.split(".", 3)[1:]
    if len(parts) != 3 and not (len(parts) == 2 and event.value.lower() in EVENTS):
        raise EventFault(f"{event.what}={event.value}: page.PAGE.OBJECT={'|'.join(EVENTS)} or page.PAGE.OBJECT.ATTRIBUTE=VALUE")
    return parts


def put(machine: Machine, own: Instance, event: Event) -> None:
    """A global: name, name[3], name[key], name.field."""
    _known(own, event)
    try:
        container, place = place_of(own.data, event.what)
        old = places(container)[place]
    except NOWHERE:
        raise EventFault(f"{event.what}: there is no such value") from None
    value = _value_for(old, event)
    if isinstance(old, DioV | AioV):
        if not old.link:
            raise EventFault(f"{event.what}: it has no link")
        machine.io.declare(old.link).value = float(value)
    else:
        places(container)[place] = value


def _value_for(old: object, event: Event) -> float | bool | str:
    """The value of the event in the type of what it sets."""
    match old:
        case bool():
            return number(event) != 0
        case str():
            return event.value
        case float() | DioV() | AioV():
            return number(event)
    raise EventFault(f"{event.what}: only numbers, bools, strings, dio and aio are set")


def key(machine: Machine, event: Event) -> None:
    """key=A or key=271: a key of the pendant, for getKey and get."""
    machine.screen.press(_key_of(machine, event))


def _key_of(_: Machine, event: Event) -> str:
    if code_of(event.value) is None:
        raise EventFault(f"key={event.value}: one character or the number of a key is expected")
    return event.value


def _number_of(_: Machine, event: Event) -> float:
    return number(event)


def _anything(_: Machine, event: Event) -> str:
    return event.value


LINKED = ("dio", "aio", "io", "sio")  # a variable's name means its link
PLANT: dict[str, Callable[[Machine, str, Event], None]] = {
    "dio": signal,
    "aio": signal,
    "io": state,
    "sio": channel,
    "page": page,
    "board": board,
}
OPERATOR: dict[str, Callable[[Machine, Event], None]] = {
    "mode": mode,
    "power": lambda machine, event: machine.robot.switch(number(event) != 0),
    "speed": speed,
    "estop": estop,
    "hold": hold,
    "answer": lambda machine, event: machine.answers.append(event.value),
    "key": key,
    "joints": joints,
    "connect": connect,
    "refresh": refresh,
    "ratio": ratio,
    "brakes": brakes,
    "hibernate": hibernate,
    "wakeup": wake,
    "profile": profile,
    "app": app,
}
CHECKS: dict[str, Callable[[Machine, Event], object]] = {  # what a value means, or EventFault
    "dio": _number_of,
    "aio": _number_of,
    "io": _state_of,
    "sio": _telegram,
    "page": _object,
    "board": _nanoseconds,
    "mode": _mode_of,
    "power": _number_of,
    "speed": _percent,
    "estop": _chain,
    "hold": _number_of,
    "key": _key_of,
    "joints": _joints_of,
    "connect": _number_of,
    "refresh": _without_jitter,
    "ratio": _cycles,
    "brakes": _results,
    "hibernate": _hibernated,
    "wakeup": _woken,
    "app": _stopped,
}
