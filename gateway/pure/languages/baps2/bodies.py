"""Translates statements to the text of Python generator functions, with checks and faults in one pass (AX-694)."""

from collections.abc import Iterable

from gateway.pure.languages.baps2 import calls, exchange, travel
from gateway.pure.languages.baps2.flow import label_paths, needs_jumps
from gateway.pure.languages.baps2.output import Function, Lines
from gateway.pure.languages.baps2.scope import Names
from gateway.pure.languages.baps2.standard import DEVICES
from gateway.pure.languages.baps2.tree import (
    Block,
    CallStatement,
    Case,
    Exclusive,
    Expression,
    FileOrder,
    If,
    Instruction,
    Jump,
    Label,
    Move,
    Name,
    Parallel,
    PointValue,
    Read,
    Repeat,
    Set,
    Simple,
    StartStop,
    Statement,
    Sync,
    Synchron,
    Wait,
    WaitUntil,
    Write,
)
from gateway.pure.languages.baps2.typed import Typed
from gateway.pure.languages.baps2.types import BINARY, CHAR, INTEGER, NONE, POINTS, TEXT, Type, fits
from gateway.pure.languages.baps2.typing import Typing, with_article
from gateway.pure.languages.base.near import hint_of
from gateway.pure.languages.base.source import Position

REAL_CHECKED = "(t if -3.4028235e+38 <= (t := {}) <= 3.4028235e+38 else real_overflow())"
MARKS = (Label, Instruction)
WITHOUT_LINE = (*MARKS, Block)
FREQUENT = (Set, Move, Wait)  # that hold no other statements
MOST_LOOPS = 16  # Python takes 20


class Bodies:
    """Translates bodies; the text grows in `out`."""

    def __init__(self, names: Names, typing: Typing, way: str) -> None:
        self.names, self.typing, self.way = names, typing, way
        self.out = Lines()
        self.function = Function({}, False)
        self._temporary = self._loops = 0
        self._parts: list[tuple[str, int]] = []  # EXCLUSIVE parts around the statement: semaphore, line
        self._by_main: dict[str, int] = {}  # of those around the PARALLEL whose branch it is in
        self.before_move = False
        self.included = False  # some statements are in included files
        self._at: Position | None = None  # of the statement under translation

    def new(self, letter: str) -> str:
        """A Python name that nothing else has."""
        self._temporary += 1
        return f"{letter}{self._temporary}"

    def body(self, statements: tuple[Statement, ...], after: Iterable[str], own: Iterable[str] = ()) -> None:
        """Write the complete body of a function without its head.  `after`: lines at the end; `own`: variables of this function."""
        labels = label_paths(statements, self.names.faults)
        outer, self.function = self.function, Function(labels, bool(labels))
        written, self.typing.written = self.typing.written, set()
        place = len(self.out.rows)
        self.out.add("")  # the place of nonlocal
        if labels:
            self._apart(statements)
        else:
            self.several(statements)
        for row in after:
            self.out.add(row)
        outside = sorted(self.typing.written - set(own))
        self.out.rows[place] = "    " * self.out.indent + (f"nonlocal {', '.join(outside)}" if outside else "pass")
        self.function, self.typing.written = outer, written

    def _apart(self, statements: tuple[Statement, ...]) -> None:
        self.function.numbers = {label: self.function.part() for label in self.function.labels}
        self.out.add("at = 0")
        self.out.add("while True:")
        self.out.indent += 1
        self.out.add("if at == 0:")
        self.out.indent += 1
        self.out.add("pass")
        self.several(statements)
        self.out.indent -= 1
        self.out.add("break")
        self.out.indent -= 1

    def _begin_part(self, number: int) -> None:
        """Ends the part before, which runs on into this one."""
        self.out.add(f"at = {number}")
        self.out.indent -= 1
        self.out.add(f"if at == {number}:")
        self.out.indent += 1
        self.out.add("pass")
        self.function.line = 0

    def _go(self, number: int) -> None:
        self.out.add(f"at = {number}")
        self.out.add("continue")

    def several(self, statements: Iterable[Statement]) -> None:
        """Write statements in sequence."""
        rows = tuple(statements)
        followed, before = [False] * len(rows), False
        for place in range(len(rows) - 1, -1, -1):
            followed[place] = before
            before = before if isinstance(rows[place], MARKS) else isinstance(rows[place], Move)
        for statement, self.before_move in zip(rows, followed, strict=True):
            self.one(statement)

    def _nested(self, *statements: Statement) -> None:
        """A body one level deeper."""
        self.out.indent += 1
        self.out.add("pass")
        self.function.line = 0
        self.several(statements)
        self.function.line = 0
        self.out.indent -= 1

    def one(self, statement: Statement) -> None:
        """One statement."""
        if self.out.too_deep:
            self._look()
        outer, self._at = self._at, statement.at
        try:
            self._one(statement)
        except RecursionError:
            self._too_complex()
        if self.out.too_deep:
            self._look()
        self._at = outer

    def _look(self) -> None:
        """Reports a statement whose text Python cannot take."""
        self.out.too_deep = False
        self._too_complex()

    def _too_complex(self) -> None:
        if self._at is not None:
            self.names.faults.error("too-complex", self._at, "this is nested too deeply", "divide its expressions into smaller ones")

    def _one(self, statement: Statement) -> None:
        self.function.count += 1
        if not isinstance(statement, WITHOUT_LINE) and (statement.at.line != self.function.line or self.included):
            self.function.line = statement.at.line
            self.out.add(f"p.line = {statement.at.line}")
            if self.included:
                *above, root = statement.at.stack()
                within = (root.file, root.line) if above else None
                self.out.add(f"p.file, p.within = {statement.at.file!r}, {within!r}")
        if self._flow(statement):
            return
        match statement:
            case Set():
                self._set(statement)
            case Move():
                self.otherwise(travel.move(self, statement), statement.otherwise)
            case Wait(seconds=seconds):
                self.out.add(f"yield Dwell({self.typing.number(seconds, 'a time').code})")
            case WaitUntil():
                self.otherwise(travel.wait(self, statement), statement.otherwise)
            case StartStop(word=word, program=program):
                self._startstop(statement, "StartProgram" if word == "START" else "StopProgram", program)
            case Simple():
                self._simple(statement)
            case CallStatement():
                calls.call(self, statement)
            case _:
                self._exchange(statement)

    def _exchange(self, statement: Statement) -> None:
        """Statements about belts, devices and files."""
        match statement:
            case Sync():
                travel.sync(self, statement)
            case Synchron():
                travel.synchron(self, statement)
            case Read():
                exchange.read(self, statement)
            case Write():
                exchange.write(self, statement)
            case FileOrder():
                exchange.file_order(self, statement)

    def _flow(self, statement: Statement) -> bool:
        """Statements that hold others or jump; False: it is none of them."""
        if isinstance(statement, FREQUENT):
            return False
        match statement:
            case Label(name=name):
                self.function.counted[name] = self.function.count
                self._begin_part(self.function.numbers[name])
            case Instruction(word=word, value=value):
                if word == "KINEMATICS":
                    self.typing.kinematic = value
                else:
                    self.way = value
            case Block(body=body):
                self.several(body)
            case Jump():
                self._jump(statement)
            case If():
                self._if(self.typing.truth(statement.condition, "the condition").code, statement.then, statement.otherwise)
            case Case():
                self._case(statement)
            case Repeat():
                self._repeat(statement)
            case Parallel():
                self._parallel(statement)
            case Exclusive():
                self._exclusive(statement)
            case _:
                return False
        return True

    # ---- flow

    def otherwise(self, answer: str, statement: Statement | None) -> None:
        """The ERROR part of a statement whose answer is in `answer`."""
        if statement is not None and answer:
            self._if(f"not {answer}", statement, None)

    def _if(self, condition: str, then: Statement, otherwise: Statement | None) -> None:
        if needs_jumps(then) or (otherwise is not None and needs_jumps(otherwise)):
            other, end = self.function.part(), self.function.part()
            self.out.add(f"if not ({condition}):")
            self.out.indent += 1
            self._go(other)
            self.out.indent -= 1
            self.several((then,))
            self._go(end)
            self._begin_part(other)
            self.several(() if otherwise is None else (otherwise,))
            self._begin_part(end)
            return
        self.out.add(f"if {condition}:")
        self._nested(then)
        if otherwise is not None:
            self.out.add("else:")
            self._nested(otherwise)

    def _jump(self, statement: Jump) -> None:
        number = self.function.numbers.get(statement.label)
        if number is None:
            hint = hint_of(statement.label, self.function.labels) or "a jump must stay in its program, subroutine or branch of PARALLEL"
            self.names.once("label-missing", statement.label, statement.at, f"label {statement.label} does not exist", hint)
            return
        path = self.function.labels[statement.label]
        if path != tuple(self.function.path[: len(path)]):
            self.names.faults.error("jump-into", statement.at, f"label {statement.label} is inside a loop, a choice or an EXCLUSIVE")
        for key, semaphore in reversed(self.function.exclusives):
            if key not in path:
                self.out.add(f"yield Leave({semaphore})")
        self.turn(max(1, self.function.count - self.function.counted.get(statement.label, self.function.count)))
        self._go(number)

    def turn(self, statements: int) -> None:
        """Count statements and yield the processor when the budget is used up."""
        self.out.add(f"p.left -= {statements}")
        self.out.add("if p.left < 0:")
        self.out.add("    yield TURN")

    def _case(self, statement: Case) -> None:
        selector = self.typing.of(statement.selector)
        if selector.type not in (NONE, BINARY, INTEGER, CHAR, TEXT):
            self.names.faults.error("type", statement.at, f"CASE takes BINARY, INTEGER, CHAR or TEXT, not {selector.type}")
            selector = Typed(NONE, selector.code)
        name = self.new("c")
        self.out.add(f"{name} = {selector.code}")
        self.function.path.append(id(statement))
        seen: set[object] = set()
        end = self.function.part() if needs_jumps(statement) else 0
        word = "if"
        for choice in statement.choices:
            texts = [self._constant(value, selector.type, seen) for value in choice.values]
            condition = f"{name} in ({' '.join(f'{text},' for text in texts)})"
            if end:
                self._if(condition, choice.body, None)
                continue
            self.out.add(f"{word} {condition}:")
            self._nested(choice.body)
            word = "elif"
        self._default(statement, name, seen, end, word)
        self.function.path.pop()

    def _default(self, statement: Case, name: str, seen: set[object], end: int, word: str) -> None:
        if statement.otherwise is None:
            return
        if end:
            self._if(f"{name} not in ({' '.join(f'{each!r},' for each in sorted(seen, key=repr))})", statement.otherwise, None)
        elif word == "if":
            self.several((statement.otherwise,))
        else:
            self.out.add("else:")
            self._nested(statement.otherwise)

    def _constant(self, tree: Expression, kind: Type, seen: set[object]) -> str:
        """A constant of a CASE: of the type of the selector, and there only once."""
        found = self.typing.of(tree)
        if found.type is NONE or kind is NONE:
            return "None"
        if found.constant is None:
            self.names.faults.error("no-constant", tree.at, "a constant is expected after EQUAL")
        elif not fits(kind, found.type, found.constant) or found.type.base == "REAL":
            self.names.faults.error("type", tree.at, f"{found.type} does not fit {kind}")
        elif found.constant in seen:
            self.names.faults.error("case-twice", tree.at, f"{found.constant!r} is used twice in this CASE")
        seen.add(found.constant)
        return repr(found.constant)

    def _repeat(self, statement: Repeat) -> None:
        times = self.typing.whole(statement.times, "the number of repetitions").code
        self.function.path.append(id(statement))
        before = self.function.count
        if needs_jumps(statement):
            name, begin, end = self.new("c"), self.function.part(), self.function.part()
            self.out.add(f"{name} = {times}")
            self._begin_part(begin)
            self.out.add(f"if {name} <= 0:")
            self.out.indent += 1
            self._go(end)
            self.out.indent -= 1
            self.out.add(f"{name} -= 1")
            self.several(statement.body)
            self.turn(self.function.count - before + 1)
            self._go(begin)
            self._begin_part(end)
        else:
            self._loops += 1
            if self._loops > MOST_LOOPS:
                self.names.once("nesting-too-deep", "(REPEAT)", statement.at, f"more than {MOST_LOOPS} nested REPEAT")
            self.out.add(f"for _ in range({times}):")
            self._nested(*statement.body)
            self.out.indent += 1
            self.turn(self.function.count - before + 1)
            self.out.indent -= 1
            self._loops -= 1
        self.function.path.pop()

    def _parallel(self, statement: Parallel) -> None:
        found, before, self._by_main = [], self._by_main, dict(self._parts)
        for branch in statement.branches:
            name = self.new("b")
            found.append(name)
            self.out.add(f"def {name}(p):")
            self.out.indent += 1
            self.body(branch, ("yield Drain()",))
            self.out.indent -= 1
        self._by_main = before
        self.out.add(f"yield Branches(({' '.join(f'{name},' for name in found)}))")

    def _exclusive(self, statement: Exclusive) -> None:
        symbol = self.names.find(statement.semaphore)
        if statement.semaphore and (symbol is None or (symbol.kind != "semaphore" and not symbol.misread)):
            self.names.once("semaphore", statement.semaphore, statement.at, f"{statement.semaphore} is not a semaphore")
        key = f"{(symbol.owner if symbol is not None else '', statement.semaphore)!r}"
        self.out.add(f"yield Enter({key})")
        self.function.path.append(id(statement))
        self.function.exclusives.append((id(statement), key))
        if (line := self._by_main.get(key)) is not None:
            text = f"this branch waits for {statement.semaphore} forever: the program holds it from line {line} until its branches are over"
            self.names.faults.warning("semaphore-held", statement.at, text)
        self._parts.append((key, statement.at.line))
        self.several(statement.body)
        self._parts.pop()
        self.function.exclusives.pop()
        self.function.path.pop()
        self.out.add(f"yield Leave({key})")

    # ---- simple statements

    def _simple(self, statement: Simple) -> None:
        match statement.word:
            case "BREAK":
                self.out.add("yield GiveUp()")
            case "HALT":
                self.out.add("yield Halt()")
            case "REF_PNT":
                self.out.add(f"yield Reference({statement.name or self.typing.kinematic!r})")
            case _:
                symbol = self.names.find(statement.name) if statement.name else None
                self.out.add(f"yield Synchronise('', 0, {symbol.channel if symbol is not None else 0})")

    def _startstop(self, statement: StartStop, request: str, program: str) -> None:
        symbol = self.names.find(program)
        if symbol is not None and symbol.kind != "program" and not symbol.misread:
            self.names.faults.error("no-program", statement.at, f"{program} is {with_article(symbol.kind)}, not a program")
        self.out.add(f"yield {request}({program!r})")

    def _set(self, statement: Set) -> None:
        target = self.target(statement.target)
        if target.type is NONE and isinstance(statement.value, PointValue):
            for each in statement.value.values:
                self.typing.of(each)
            return
        if target.type.base in POINTS and not target.type.is_array:
            value = self.typing.point(statement.value, target.type.kinematic or self.typing.kinematic)
        else:
            value = self.typing.of(statement.value)
        if target.type is NONE:
            return
        self.store(statement.target, target.type, value)

    def target(self, tree: Expression) -> Typed:
        """What is set; the value is not read, so nothing is asked."""
        if isinstance(tree, Name):
            symbol = self.names.find(tree.name)
            if symbol is not None and symbol.kind in ("input", "constant", "belt", "semaphore", "file", "program", "special", "subroutine"):
                self.typing.assigned(tree, "")
                return Typed(NONE, "")
            if symbol is None and tree.name in DEVICES:
                self.names.faults.error("not-assignable", tree.at, f"{tree.name} cannot be assigned to")
                return Typed(NONE, "")
        return self.typing.of(tree)

    def store(self, tree: Expression, kind: Type, value: Typed) -> None:
        """Sets a variable of a type to a value, if it fits."""
        if not fits(kind, value.type, value.constant):
            hint = "use ROUND or TRUNC" if (kind, value.type.base) == (INTEGER, "REAL") else ""
            self.names.faults.error("type", tree.at, f"{value.type} cannot be assigned to {kind}", hint)
            return
        if row := self.typing.assigned(tree, converted(kind, value)):
            self.out.add(row)


def converted(kind: Type, value: Typed) -> str:
    """Python text of a value as a variable of the type keeps it."""
    if kind.is_array or value.type is NONE:
        return value.code
    if kind.base == "REAL" and value.constant is None:
        return REAL_CHECKED.format(value.code) if value.type.base == "REAL" else f"float({value.code})"
    if kind.base == "REAL" and isinstance(value.constant, int):
        return repr(float(value.constant))
    if kind.base == "TEXT" and value.constant is None:
        return f"text({value.code})"
    if kind.base in POINTS and not value.code.startswith("("):
        return f"point({value.code})"
    return value.value
