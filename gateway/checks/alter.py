"""[alter]: six full words that a command source writes, a life byte next to them, two answer words without another writer."""

from gateway.assembly.axis_signals import rc_numbers
from gateway.checks.context import Context
from gateway.pure.cell.alter import Alter
from gateway.pure.cycle.enabling_inputs import free_outputs

WORD, BITS = 16, 1024


def alter(check: Context) -> None:
    """Checks beyond the table itself."""
    table = check.cell.alter
    if table is None:
        return
    if not check.cell.robot or not check.cell.robot[0].model:
        check.fault("alter", "", "a correction acts on the path of a robot: [robot] with a model is missing")
    size = 6 * WORD * (2 if table.type == "REAL" else 1)
    if table.input % WORD or table.input + size > BITS:
        check.fault(
            "alter.input", table.input, f"six {table.type} from here: whole words of the image", f"0..{BITS - size}, a multiple of {WORD}"
        )
        return
    if table.source == "application":
        _application(check, table, size)
        return
    octets = set(range(table.input >> 3, (table.input + size) >> 3))
    if table.life is not None:
        if table.life % 8 or table.life >> 3 in octets:
            check.fault("alter.life", table.life, "the first RC input of a byte outside the correction", f"0..{BITS - 8}, a multiple of 8")
        else:
            octets.add(table.life >> 3)
    numbers = rc_numbers(check.cell)
    own = {number >> 3 for number in (numbers.chain, numbers.control, numbers.feed, numbers.run, numbers.travel, numbers.reset)}
    for octet in sorted(octets & own):
        check.fault("alter.input", table.input, f"RC input byte {octet} holds enabling inputs")
    missing = sorted(octets - set(check.cell.rc_inputs.owner))
    if missing and not check.cell.route:
        check.fault(
            "alter.input",
            table.input,
            f"RC input byte {missing[0]} has no writer: name a command source in [rc_inputs] owner, or add a [[route]] to it",
        )
    if table.life is None and check.cell.route and missing:
        check.fault(
            "alter.life",
            "",
            "a [[route]] writes changes only: a life byte is needed to distinguish a constant correction from a silent partner",
        )
    _status(check, table)


def _application(check: Context, table: Alter, size: int) -> None:
    """The interpreter writes it: 25 bytes that nothing else writes, and the answer for it."""
    for key, wrong, what in (
        ("alter.source", check.cell.val3 is None, "application: an application of [val3] is needed"),
        ("alter.type", table.type != "REAL", "an application corrects with six REAL"),
        ("alter.life", table.life is not None, "an application has no life byte: its calls are the sign of life"),
        ("alter.status", table.status is None, "an application needs the two answer words: status = the first of 32 free RC outputs"),
    ):
        if wrong:
            check.fault(key, "", what)
    octets = set(range(table.input >> 3, (table.input + size) // 8 + 1))
    numbers = rc_numbers(check.cell)
    own = {number >> 3 for number in (numbers.chain, numbers.control, numbers.feed, numbers.run, numbers.travel, numbers.reset)}
    points = check.cell.controller.point if check.cell.controller is not None else ()
    own |= {(point.bit or 0) >> 3 for point in points if not point.output and point.bit is not None}
    if max(octets) >= BITS // 8 or octets & own:
        check.fault("alter.input", table.input, "25 bytes of RC inputs are needed that hold no enabling inputs and no points")
    _status(check, table)


def _status(check: Context, table: Alter) -> None:
    if table.status is None:
        return
    cell, bits = check.cell, set(range(table.status, table.status + 2 * WORD))
    taken = {each.output + n for each in cell.path_output for n in range(each.bits if each.kind == "ppo" else 1)}
    if table.status % WORD or max(bits) >= BITS:
        check.fault("alter.status", table.status, "two whole words of the image", f"0..{BITS - 2 * WORD}, a multiple of {WORD}")
    elif not bits <= free_outputs(rc_numbers(cell), len(cell.axis)) - taken:
        check.fault("alter.status", table.status, "axisgate itself, or a [[path_output]], writes one of these outputs")


CHECKS = (alter,)
