"""Where labels are and what has to be translated to jumps: Python has none, so a body with labels becomes a row of parts."""

from collections.abc import Iterator

from gateway.pure.languages.baps2.tree import Block, Case, Exclusive, If, Jump, Label, Move, Repeat, Statement, WaitUntil
from gateway.pure.languages.base.faults import Faults

Path = tuple[int, ...]
HOLDERS = (Block, Repeat, Exclusive, If, Case, Move, WaitUntil)  # statements with others inside

CLOSED = (Repeat, Exclusive, Case)  # no jump leads into them


def children(statement: Statement) -> tuple[tuple[Statement, ...], ...]:
    """The bodies inside of a statement; those of PARALLEL are functions of their own and not among them."""
    if not isinstance(statement, HOLDERS):  # most statements of a program
        return ()
    match statement:
        case Block(body=body) | Repeat(body=body) | Exclusive(body=body):
            return (body,)
        case If(then=then, otherwise=otherwise):
            return ((then,), (otherwise,)) if otherwise is not None else ((then,),)
        case Case(choices=choices, otherwise=otherwise):
            return (*((choice.body,) for choice in choices), *(((otherwise,),) if otherwise is not None else ()))
        case Move(otherwise=otherwise) | WaitUntil(otherwise=otherwise):
            return ((otherwise,),) if otherwise is not None else ()


def inside(statement: Statement) -> Iterator[Statement]:
    """The statement and all in it, but not branches."""
    yield statement
    for body in children(statement):
        for each in body:
            yield from inside(each)


def needs_jumps(statement: Statement) -> bool:
    """Whether it has to be taken apart: a label inside, or a jump out of a loop."""
    if isinstance(statement, Label) or (isinstance(statement, Repeat) and any(isinstance(each, Jump) for each in inside(statement))):
        return True
    return any(needs_jumps(each) for body in children(statement) for each in body)


def label_paths(body: tuple[Statement, ...], faults: Faults) -> dict[str, Path]:
    """Label -> enclosing part that may not be jumped into."""
    found: dict[str, Path] = {}

    def walk(statements: tuple[Statement, ...], path: Path) -> None:
        for each in statements:
            if isinstance(each, Label):
                if each.name in found:
                    faults.error("label-twice", each.at, f"label {each.name} is defined twice")
                found[each.name] = path
            for part in children(each):
                walk(part, (*path, id(each)) if isinstance(each, CLOSED) else path)

    walk(body, ())
    return found
