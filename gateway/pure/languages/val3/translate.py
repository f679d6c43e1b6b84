"""Checks a program line by line and writes each line as one Python function that returns the number of the next one.

So a task can be stopped, resumed or moved between any two lines, and an error leaves it on its line.  A line that can wait is a
generator: it yields the moment before which asking again is of no use, None: its next turn.
"""

import re
from collections.abc import Callable

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.val3.block_words import CLOSERS, OPENERS, end_in_two_words, meant_word, shown
from gateway.pure.languages.val3.expressions import Translator
from gateway.pure.languages.val3.model import Application, Parameter, ProgramText
from gateway.pure.languages.val3.program_code import Block, Code, Instruction
from gateway.pure.languages.val3.scope import Scope, Value, slots_of
from gateway.pure.languages.val3.syntax import Assign, CompileFault, Consequence, Expressions, Invoke, Node, Number
from gateway.pure.languages.val3.typing_rules import EQUAL

TARGET = re.compile(r"@(\d+)@")
NO_SERVER = "opcuaexport"  # s8: variables for clients of OPC UA
COMPLIANCE = ("movejf", "movelf", "iscompliant")  # instructions of an option of s7
CONDITIONS = ("if", "elseif", "while", "until")


class ProgramTranslator:
    """One program."""

    def __init__(self, app: Application, program: ProgramText, faults: Faults, axes: int, *, strict: bool = False) -> None:
        slots, size = slots_of(program)
        self.scope = Scope(app, program, slots, size, axes)
        self.app, self.program, self.faults, self.strict = app, program, faults, strict
        self.instructions: list[Instruction] = []
        self.missing = ""  # add-on of the line
        self.labels: dict[int, int] = {}
        self.label_count = 0
        self.temps = 0
        self.blocks: list[Block] = []
        self.line = 0
        self.crossed: Block | None = None  # a word in it closes another block
        self.spoilt = False  # a line uses what cannot be read

    # ---- the whole -------------------------------------------------------------------------------------------------------
    def translate(self) -> Code | None:
        """None where there are faults."""
        before = self.faults.errors
        lines = self.program.lines or ["begin", "end"]
        while lines and not lines[-1].strip():
            lines = lines[:-1]
        closing = next((at for at in range(len(lines) - 1, 0, -1) if lines[at].strip().lower() == "end"), 0)
        if closing and closing + 1 < len(lines):
            self._fault(closing + 2, "text after end")
            lines = lines[: closing + 1]
        if not lines or lines[0].strip().lower() != "begin":
            self._fault(1, "begin expected")
            return None
        if lines[-1].strip().lower() != "end" or len(lines) < 2:
            self._fault(len(lines), "end expected")
        for number, line in enumerate(lines[1:-1], start=2):
            self.line = number
            if not line.strip() or line.lstrip().startswith("//"):
                continue
            try:
                self._statement(line)
            except CompileFault as fault:
                if isinstance(fault, Consequence):
                    self.spoilt = True
                else:
                    self._fault(number, fault.text, fault.column)
                self._keep_blocks(line)
            except RecursionError:
                self._fault(number, "expression nested too deeply")
        for block in reversed(self.blocks if self.crossed is None else []):  # where closing words are mixed up, that is named already
            if block.spare:
                continue
            self._fault(
                block.line,
                f"{shown(OPENERS[block.kind])} does not match for" if block.kind == "for" else f"{shown(OPENERS[block.kind])} expected",
                block.column,
            )
        self.line = len(lines)
        self._emit(["return -1"])
        return self._code(len(lines)) if self.faults.errors == before and not self.spoilt else None

    def _fault(self, line: int, text: str, column: int = 1) -> None:
        self.faults.error("val3", Position(self.program.file, line, column), text)

    def _keep_blocks(self, line: str) -> None:
        """A faulty line still opens or closes its block, so that one fault is one fault."""
        word, certain = meant_word(line)
        if word in OPENERS and (not self.blocks or self.blocks[-1].line != self.line):
            self._open(word).spare = not certain
        elif word in CLOSERS and self.blocks and self.blocks[-1].kind == CLOSERS[word]:
            self._place(self.blocks.pop().end)

    def _code(self, last: int) -> Code:
        targets = [self._follow(at) for at in range(len(self.instructions))]
        parts = []
        for at, step in enumerate(self.instructions):
            if step.alias is not None:
                continue
            body = "\n ".join(TARGET.sub(lambda match: str(targets[self.labels[int(match.group(1))]]), text) for text in step.body)
            body = body.replace("@next@", str(targets[at + 1]) if at + 1 < len(targets) else "-1")
            if step.waits:
                parts.append(f"def H{at}(v):\n {body}\ndef L{at}(v):\n M.gen = H{at}(v)\n return -3\n")
            else:
                parts.append(f"def L{at}(v):\n {body}\n")
        lines = [step.line for step in self.instructions]
        return Code("".join(parts), len(lines), lines, targets[0], targets, self.scope.size, self.temps, last)

    def _follow(self, at: int) -> int:
        for _ in range(len(self.instructions) + 1):
            alias = self.instructions[at].alias
            if alias is None:
                return at
            at = self.labels[alias]
        return at

    # ---- steps and labels ------------------------------------------------------------------------------------------------
    def _label(self) -> int:
        self.label_count += 1
        return self.label_count

    def _place(self, label: int) -> None:
        self.labels[label] = len(self.instructions)

    def _emit(self, body: list[str], waits: bool = False) -> None:
        self.instructions.append(Instruction(self.line, body, waits))

    def _way(self, label: int) -> None:
        self.instructions.append(Instruction(self.line, alias=label))

    def _open(self, kind: str, column: int = 1) -> Block:
        block = Block(kind, self.line, self._label(), self._label(), column=column)
        self._place(block.end)  # moved when it is closed; never missing
        self._place(block.again)
        self.blocks.append(block)
        return block

    def _close(self, closer: str, parser: Expressions) -> Block:
        if not self._innermost(CLOSERS[closer]):
            raise CompileFault(f"{shown(closer)} does not match {CLOSERS[closer]}", parser.tokens[0].start + 1)
        block = self.blocks[-1]
        if block.spare and self.blocks[-2:-1] and self.blocks[-2].kind == block.kind:
            self.blocks[-2].spare = True
        return block

    def _innermost(self, kind: str) -> bool:
        """Whether the innermost open block is of this kind.  One that a closing word has crossed before lacks its own: it is over."""
        while len(self.blocks) > 1 and self.blocks[-1].kind != kind and (self.blocks[-1].spare or self.blocks[-1] is self.crossed):
            self._place(self.blocks.pop().end)
        if self.blocks and self.blocks[-1].kind == kind:
            return True
        self.crossed = self.blocks[-1] if self.blocks else self.crossed
        return False

    # ---- statements ------------------------------------------------------------------------------------------------------
    def _statement(self, line: str) -> None:
        parser = Expressions(line, strict=self.strict)
        first = parser.next
        word = first.text.lower() if first.kind == "name" and parser.tokens[1].text not in ("=", "[", ".") else ""  # do[1] is a variable
        translator = Translator(self.scope, line)
        handler: Callable[[Expressions, Translator], None] | None = getattr(self, f"_do_{word}", None) if word in STATEMENTS else None
        early = self._before_case(word)
        self.missing = self._add_ons(parser)
        if self.missing and word not in CONDITIONS:
            self._emit([f"raise Rte(250, {self.missing!r})"])
            if word in OPENERS:
                self._open(word, first.start + 1).step = "0 num" if word == "switch" else ""
            return
        if handler is not None:
            parser.take()
            handler(parser, translator)
            parser.finish()
            return
        node = parser.expression()
        parser.finish()
        if early:
            raise translator.fault(node, "case expected")
        if isinstance(node, Assign):
            code, waits = translator.assignment(node)
            self._emit([code, "return @next@"], waits)
        elif isinstance(node, Invoke):
            value = translator.invoke(node)
            self._emit([value.code, "return @next@"], value.waits)
        else:
            raise translator.fault(node, "instruction expected")

    def _before_case(self, word: str) -> bool:
        """Whether a line that belongs to no branch follows a switch (L812); one of them is reported."""
        block = self.blocks[-1] if self.blocks else None
        if block is None or block.kind != "switch" or block.branches:
            return False
        block.branches = True
        return word not in ("case", "default", "endswitch")

    def _add_ons(self, parser: Expressions) -> str:
        """Warn of each call of an add-on in a line; return the first one, at which the line stops its task."""
        first = ""
        for token, after in zip(parser.tokens, parser.tokens[1:], strict=False):
            name = f"${after.text}" if token.text == "$" and after.kind == "name" else ""
            if token.text.lower() in COMPLIANCE and after.text == "(" and token.text not in self.app.programs:
                name = token.text
            place = Position(self.program.file, self.line, token.start + 1)
            if token.text.lower() == NO_SERVER and after.text == "(":
                self.faults.warning("val3-add-on", place, f"'{token.text}' : there is no OPC UA server, it has no effect")
            if name:
                self.faults.warning("val3-add-on", place, f"'{name}' : add-on not installed")
                first = first or name
        return first

    def _do_begin(self, parser: Expressions, translator: Translator) -> None:
        if closer := end_in_two_words(translator.line):
            raise CompileFault(f"'{' '.join(translator.line.split())}' : {shown(closer)} expected", parser.tokens[0].start + 1)
        raise CompileFault(f"'{parser.tokens[0].text}' : instruction expected")

    _do_end = _do_begin

    def _do_return(self, parser: Expressions, translator: Translator) -> None:
        self._emit(["return -1"])

    def _condition(self, parser: Expressions, translator: Translator) -> Value:
        if self.missing:
            parser.at = len(parser.tokens) - 1
            return Value(f"add_on({self.missing!r})", "bool", Node(0, 0))
        node = parser.expression()
        value = translator.assign(node) if isinstance(node, Assign) else translator.value(node)
        return translator.need(value, "bool")

    # ---- if --------------------------------------------------------------------------------------------------------------
    def _do_if(self, parser: Expressions, translator: Translator) -> None:
        condition = self._condition(parser, translator)
        block = self._open("if", parser.tokens[0].start + 1)
        self._emit([f"if {condition.code}: return @next@", f"return @{block.again}@"], condition.waits)

    def _branch(self, word: str, parser: Expressions) -> Block:
        while len(self.blocks) > 1 and self.blocks[-1].spare and self.blocks[-2].kind == "if":
            self._place(self.blocks.pop().end)
        if not self.blocks or self.blocks[-1].kind != "if":
            raise CompileFault(f"{word} does not match if", parser.tokens[0].start + 1)
        block = self.blocks[-1]
        if block.step == "else":
            raise CompileFault(f"{word} after else", parser.tokens[0].start + 1)
        self._way(block.end)
        self._place(block.again)
        block.again = self._label()
        self._place(block.again)
        return block

    def _do_elseif(self, parser: Expressions, translator: Translator) -> None:
        block = self._branch("elseIf", parser)
        condition = self._condition(parser, translator)
        self._emit([f"if {condition.code}: return @next@", f"return @{block.again}@"], condition.waits)

    def _do_else(self, parser: Expressions, translator: Translator) -> None:
        block = self._branch("else", parser)
        block.step = "else"
        if parser.next.text.lower() == "if":  # with one endIf it was meant as elseIf, with two as an if of its own: one fault either way
            block.spare = True
            self._open("if", parser.next.start + 1)
            raise CompileFault("'else if' : elseIf expected", parser.tokens[0].start + 1)

    def _do_endif(self, parser: Expressions, translator: Translator) -> None:
        block = self._close("endif", parser)
        self._place(block.again)
        self._place(block.end)
        self.blocks.pop()

    # ---- loops -----------------------------------------------------------------------------------------------------------
    def _do_while(self, parser: Expressions, translator: Translator) -> None:
        condition = self._condition(parser, translator)
        block = self._open("while", parser.tokens[0].start + 1)
        self._emit([f"if {condition.code}: return @next@", f"return @{block.end}@"], condition.waits)

    def _do_endwhile(self, parser: Expressions, translator: Translator) -> None:
        block = self._close("endwhile", parser)
        self._way(block.again)
        self._place(block.end)
        self.blocks.pop()

    def _do_do(self, parser: Expressions, translator: Translator) -> None:
        self._open("do", parser.tokens[0].start + 1)

    def _do_until(self, parser: Expressions, translator: Translator) -> None:
        block = self._close("until", parser)
        condition = self._condition(parser, translator)
        self._emit([f"if {condition.code}: return @next@", f"return @{block.again}@"], condition.waits)
        self._place(block.end)
        self.blocks.pop()

    def _do_for(self, parser: Expressions, translator: Translator) -> None:
        target = translator.variable(parser._postfix(parser._operand()))
        if target.type != "num":
            raise translator.fault(target.node, "invalid type")
        parser.demand("=")
        begin = translator.of(parser.expression(), "num")
        parser.demand("to")
        end = translator.of(parser.expression(), "num")
        stepped: Node | None = parser.expression() if parser.meets("step") else None
        step = translator.of(stepped, "num") if stepped is not None else None
        slot = self._temp()
        block = self._open("for", parser.tokens[0].start + 1)
        plain = step is None or (isinstance(stepped, Number) and stepped.value > 0)
        test = f"{target.code} <= v[{slot}][0]"
        if not plain:
            test = f"({target.code} <= v[{slot}][0] if v[{slot}][1] > 0.0 else {target.code} >= v[{slot}][0])"
        made = step.code if step is not None else "1.0"
        body = [f"{target.code} = {begin.code}", f"v[{slot}] = ({end.code}, step_of({made}))"]
        waits = any(value.waits for value in (target, begin, end, *([step] if step else [])))
        self._emit([*body, f"if {test}: return @next@", f"return @{block.end}@"], waits)
        self._place(block.again)
        block.step = f"{target.code} = {target.code} + v[{slot}][1]\n if {test}: return @{block.again}@\n return @{block.end}@"

    def _do_endfor(self, parser: Expressions, translator: Translator) -> None:
        block = self._close("endfor", parser)
        self._emit([block.step or "return @next@"])
        self._place(block.end)
        self.blocks.pop()

    def _temp(self) -> int:
        self.temps += 1
        return self.scope.size + self.temps - 1

    # ---- switch ----------------------------------------------------------------------------------------------------------
    def _do_switch(self, parser: Expressions, translator: Translator) -> None:
        node = parser.expression()
        value = translator.value(node)
        value = translator.need(value, "bool" if value.type == "dio" else value.type)
        if value.type not in EQUAL:  # cases are compared with == (L826)
            raise translator.fault(node, "invalid type")
        slot = self._temp()
        block = self._open("switch", parser.tokens[0].start + 1)
        block.step = f"{slot} {value.type}"
        self._emit([f"v[{slot}] = copied({value.code})", f"return @{block.again}@"], value.waits)

    def _inside(self, word: str, parser: Expressions) -> Block:
        if not self._innermost("switch"):
            raise CompileFault(f"{word} does not match switch", parser.tokens[0].start + 1)
        return self.blocks[-1]

    def _do_case(self, parser: Expressions, translator: Translator) -> None:
        block = self._inside("case", parser)
        slot, _, kind = block.step.partition(" ")
        body = self._label()
        self._way(body)  # without break the branch before runs on into this one
        self._place(block.again)
        block.again = self._label()
        self._place(block.again)
        tests, waits = [], False
        while True:
            node = parser.expression()
            value = translator.of(node, kind) if kind else translator.value(node)  # no kind: the line of the switch has a fault
            waits = waits or value.waits
            tests.append(f"equal(v[{slot}], {value.code})")
            if not parser.meets(","):
                break
        self._emit([f"if {' or '.join(tests)}: return @next@", f"return @{block.again}@"], waits)
        self._place(body)

    def _do_default(self, parser: Expressions, translator: Translator) -> None:
        block = self._inside("default", parser)
        if block.default:
            raise CompileFault("'default' occurs twice", parser.tokens[0].start + 1)
        block.default = self._label()
        self._place(block.default)  # where no case fits, wherever the branch is (L828)

    def _do_break(self, parser: Expressions, translator: Translator) -> None:
        block = next((each for each in reversed(self.blocks) if each.kind == "switch"), None)
        if block is None:
            raise CompileFault("break does not match switch", parser.tokens[0].start + 1)
        self._way(block.end)

    def _do_endswitch(self, parser: Expressions, translator: Translator) -> None:
        block = self._close("endswitch", parser)
        self._place(block.again)
        if block.default:
            self.labels[block.again] = self.labels[block.default]
        self._place(block.end)
        self.blocks.pop()

    # ---- programs and tasks ----------------------------------------------------------------------------------------------
    def _do_call(self, parser: Expressions, translator: Translator) -> None:
        node = self._program_call(parser, translator)
        target, wanted = self._target(node)
        code, waits = translator.parameters(node, wanted)
        self._emit([f"M.call = ({target}, {code}, @next@)", "return -2"], waits)

    def _program_call(self, parser: Expressions, translator: Translator) -> Invoke:
        node = parser._named(program=True)
        if not isinstance(node, Invoke):
            raise parser.fault("'(' expected")
        return node

    def _target(self, node: Invoke) -> tuple[str, list[Parameter]]:
        if not node.library:
            program = self.app.programs.get(node.name)
            if program.lost if program is not None else self.app.lost_programs:
                raise Consequence
            if program is None:
                raise CompileFault(f"'{node.name}' : undefined program", node.start + 1)
            return f"programs[{node.name!r}]", program.parameters
        if node.library not in self.app.libraries:
            raise CompileFault(f"'{node.library}' : undefined library", node.start + 1)
        interface = self.app.interfaces.get(node.library)
        program = interface.programs.get(node.name) if interface is not None else None
        if node.library in self.app.lost_libraries or (program is None and interface is not None and interface.lost_programs):
            raise Consequence
        if program is None or not program.public:
            raise CompileFault(f"'{node.library}:{node.name}' : undefined program", node.start + 1)
        return f"lib_program({node.library!r}, {node.name!r})", program.parameters

    def _do_taskcreate(self, parser: Expressions, translator: Translator) -> None:
        name = translator.of(parser.expression(), "string")
        parser.demand(",")
        priority = translator.of(parser.expression(), "num")
        parser.demand(",")
        self._create(parser, translator, f"f_task_create({name.code}, {priority.code}", name.waits or priority.waits)

    def _do_taskcreatesync(self, parser: Expressions, translator: Translator) -> None:
        name = translator.of(parser.expression(), "string")
        parser.demand(",")
        period = translator.of(parser.expression(), "num")
        parser.demand(",")
        overrun = translator.variable(parser.expression(), "variable expected as parameter")
        if overrun.type != "bool":
            raise translator.fault(overrun.node, "invalid type")
        if overrun.local:
            raise translator.fault(overrun.node, "local variable not allowed as a reference parameter of a task")
        parser.demand(",")
        head = f"f_task_create_sync({name.code}, {period.code}, ({overrun.c}, {overrun.k})"
        self._create(parser, translator, head, name.waits or period.waits)

    def _create(self, parser: Expressions, translator: Translator, head: str, waits: bool) -> None:
        node = self._program_call(parser, translator)
        target, wanted = self._target(node)
        code, more = translator.parameters(node, wanted, task=True)
        self._emit([f"{head}, {target}, {code})", "return @next@"], waits or more)


STATEMENTS = frozenset(name[4:] for name in dir(ProgramTranslator) if name.startswith("_do_"))
