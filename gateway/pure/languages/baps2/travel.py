"""Translates what moves or waits: MOVE, WAIT UNTIL, SYNC, SYNCHRON."""

from collections.abc import Iterator
from dataclasses import replace

from gateway.pure.languages.baps2 import standard
from gateway.pure.languages.baps2.output import Writer
from gateway.pure.languages.baps2.scope import Symbol
from gateway.pure.languages.baps2.tree import Binary, Expression, Leg, Move, Name, Sync, Synchron, Unary, WaitUntil
from gateway.pure.languages.baps2.types import NONE

FAST = range(600, 800)  # inputs of servo boards (spec 0.3)
WAYS = {"": "ptp", "PTP": "ptp", "LINEAR": "linear", "CIRCULAR": "circular"}


def move(bodies: Writer, statement: Move) -> str:
    """All targets of a MOVE; the Python name of whether UNTIL was met."""
    typing = bodies.typing
    kinematic = statement.kinematic or typing.kinematic
    for name, value in statement.factors:
        if name not in standard.FACTORS:
            bodies.names.faults.error("factor-unknown", statement.at, f"WITH {name}: not a speed, acceleration or factor")
        typing.number(value, f"WITH {name}")
    until = _until(bodies, statement)
    met = bodies.new("m") if until else ""
    depth = bodies.out.indent
    pairs = WAYS[statement.way or bodies.way] == "circular" and len(statement.legs) % 2 == 0  # the way and the end of circles
    for number, leg in enumerate(statement.legs):
        if pairs and number % 2 == 0:
            request = _block(bodies, statement, replace(leg, through=True), kinematic, "")
        else:
            request = _block(bodies, statement, leg, kinematic, until)
        if met and number:
            bodies.out.add(f"if not {met}:")
            bodies.out.indent += 1
        bodies.out.add(f"{met} = yield {request}" if met else f"yield {request}")
    bodies.out.indent = depth
    return met


def _block(bodies: Writer, statement: Move, leg: Leg, kinematic: str, until: str) -> str:
    known = not statement.kinematic or statement.kinematic in bodies.names.head.kinematics  # else it is reported
    point = bodies.typing.point(leg.point, kinematic, target=True) if known else bodies.typing.of(leg.point)
    way = WAYS[statement.way or bodies.way]
    joint = point.type.base == "JC_POINT"
    target = f"point({point.code})" if point.type is not NONE else "()"
    factors = "".join(f"({name!r}, h.checked_factor({name!r}, {bodies.typing.of(value).code})), " for name, value in statement.factors)
    more = f", {until or None}, ({factors})" if factors else f", {until}" if until else ""
    return f"MoveTo({kinematic!r}, {way!r}, {leg.through}, {joint}, {statement.relative}, {target}{more})"


def _until(bodies: Writer, statement: Move) -> str:
    """Python text of the condition that ends the movement."""
    if statement.until is None:
        return ""
    name = _input_of(statement.until)
    channel, symbol = _channel(bodies, name), bodies.names.find(name)
    condition = _direct(bodies, statement.until, "the condition after UNTIL")
    reported = bool(name) if symbol is None else symbol.misread
    if not channel and not reported:
        bodies.names.faults.error("until-condition", statement.until.at, "UNTIL of a MOVE takes one binary input, = or <>, and 0 or 1")
    limit = "None" if statement.until_time is None else bodies.typing.number(statement.until_time, "MAX_TIME").code
    return f"Until({channel or 0}, lambda: {condition}, {limit}, {_level(bodies, statement.until)})"


def _level(bodies: Writer, tree: Expression) -> bool:
    """The value of the input with which the condition holds."""
    if isinstance(tree, Unary) and tree.sign == "NOT":
        return not _level(bodies, tree.value)
    if isinstance(tree, Binary):
        return bool(bodies.typing.of(tree.right).constant) == (tree.sign == "=")
    return True


def _input_of(tree: Expression) -> str:
    if isinstance(tree, Binary) and tree.sign in ("=", "<>") and isinstance(tree.left, Name):
        return tree.left.name
    if isinstance(tree, Unary) and tree.sign == "NOT":
        return _input_of(tree.value)
    return tree.name if isinstance(tree, Name) else ""


def _channel(bodies: Writer, name: str) -> str:
    """Python text of the channel of an input; "": it is none."""
    symbol = bodies.names.find(name)
    if symbol is None or symbol.kind != "input":
        return ""
    return symbol.python if symbol.reference else str(symbol.channel)


def _direct(bodies: Writer, tree: Expression, what: str) -> str:
    """A condition that looks values up and asks nothing."""
    outer, bodies.typing.direct = bodies.typing.direct, True
    try:
        return bodies.typing.truth(tree, what).code
    finally:
        bodies.typing.direct = outer


def wait(bodies: Writer, statement: WaitUntil) -> str:
    """WAIT UNTIL; the Python name of whether the condition held in time."""
    condition = _direct(bodies, statement.condition, "the condition after WAIT UNTIL")
    limit = "None" if statement.max_time is None else bodies.typing.number(statement.max_time, "MAX_TIME").code
    symbol = bodies.names.find(_input_of(statement.condition))
    fast = symbol is not None and _is_fast(symbol) and statement.otherwise is None
    name = bodies.new("m")
    if fast and not bodies.before_move:  # what follows comes in its order, from TO04 on (L4752-4764)
        bodies.out.add(f"{name} = yield WaitFor(lambda: {condition})")
        if statement.max_time is not None:
            bodies.out.add(f"yield Dwell({limit})")
        bodies.out.add("yield Late()")
        return name
    asked = f", {symbol.channel}, {_level(bodies, statement.condition)}" if fast and symbol is not None else ""
    bodies.out.add(f"{name} = yield WaitFor(lambda: {condition}, {limit}, {fast}{asked})")
    return name


def _is_fast(symbol: Symbol) -> bool:
    return symbol.kind == "input" and not symbol.reference and symbol.channel in FAST and symbol.channel % 10 != 0


def _belt(bodies: Writer, statement: Sync | Synchron) -> int | None:
    symbol = bodies.names.find(statement.belt)
    if symbol is None or symbol.kind != "belt":
        if symbol is None or not symbol.misread:
            bodies.names.once(
                "belt-unknown", statement.belt, statement.at, f"{statement.belt} is not a belt", bodies.names.like(statement.belt)
            )
        return None
    return symbol.channel


def sync(bodies: Writer, statement: Sync) -> None:
    """SYNC with an input or with a value of the belt."""
    channel = _belt(bodies, statement)
    if channel is None:
        return
    condition = statement.condition
    if isinstance(condition, Binary) and isinstance(condition.left, Name) and condition.left.name == statement.belt:
        value = bodies.typing.number(condition.right, "the value of the belt").code
        if condition.sign not in (">=", "<=", ">", "<"):
            bodies.names.faults.error("sync", statement.at, "SYNC takes an input, or the belt with >= or <=")
        bodies.out.add(f"yield SyncBelt({channel}, None, {condition.sign!r}, {value})")
        return
    test = _direct(bodies, condition, "the condition of SYNC")
    constant = not isinstance(condition, Binary) or bodies.typing.of(condition.right).constant is not None
    asked = _channel(bodies, _input_of(condition)) if constant else ""
    level = _level(bodies, condition) if asked else True
    bodies.out.add(f"yield SyncBelt({channel}, lambda: {test}, input={asked or 0}, level={level})")


def synchron(bodies: Writer, statement: Synchron) -> None:
    """SYNCHRON; nothing is asked but that the belt is one."""
    channel = _belt(bodies, statement)
    if channel is not None:
        bodies.out.add(f"yield Synchronise({statement.kinematic or bodies.typing.kinematic!r}, {channel})")


def targets(statement: Move) -> Iterator[Name]:
    """Names in the targets that are points if nothing declares them (L1387-1408, 1657-1684, 7979)."""
    for leg in statement.legs:
        yield from _points(leg.point)


def _points(tree: Expression) -> Iterator[Name]:
    match tree:
        case Name():
            yield tree
        case Binary(sign="+" | "-", left=left, right=right):
            yield from _points(left)
            yield from _points(right)
