"""[[shared_output]]: axes that are there, each on one output alone, on RC outputs without another writer."""

from gateway.assembly.axis_signals import rc_numbers
from gateway.checks.context import Context, twice
from gateway.pure.cell.shared_outputs import SharedOutput
from gateway.pure.cycle.enabling_inputs import free_outputs

WORD, BITS = 16, 1024


def shared(check: Context) -> None:
    """Which axes may share: those that never move at a time; whether they do is seen when they move (rho 3 L6468)."""
    cell = check.cell
    for name, _, _ in twice((each.name, str(n)) for n, each in enumerate(cell.shared_output)):
        check.fault(f"shared_output.{name}.name", name, "another table has this name")
    owners: dict[str, str] = {}
    taken = {each.output + n for each in cell.path_output for n in range(each.bits if each.kind == "ppo" else 1)}
    if cell.alter is not None and cell.alter.status is not None:
        taken |= set(range(cell.alter.status, cell.alter.status + 2 * WORD))
    for table in cell.shared_output:
        for name in table.axes:
            if check.unknown(f"shared_output.{table.name}.axes", name, "axis"):
                continue
            if name in owners:
                check.fault(
                    f"shared_output.{table.name}.axes", name, f"is on set-point output {owners[name]} already; an axis has only one"
                )
            owners[name] = table.name
        taken |= _places(check, table, taken)


def _places(check: Context, table: SharedOutput, taken: set[int]) -> set[int]:
    """RC outputs of one table."""
    where, free = f"shared_output.{table.name}", free_outputs(rc_numbers(check.cell), len(check.cell.axis)) - taken
    word = set(range(table.output, table.output + WORD))
    if table.output % WORD:
        check.fault(
            f"{where}.output", table.output, "the set point is a whole word of the image", f"0..{BITS - WORD}, a multiple of {WORD}"
        )
    elif not word <= free:
        check.fault(f"{where}.output", table.output, "axisgate itself, or another table, writes one of these outputs")
    if table.select is None:
        return word
    bits = set(range(table.select, table.select + len(table.axes)))
    if not bits <= free - word:
        check.fault(f"{where}.select", table.select, f"axisgate itself, or another table, writes one of these {len(table.axes)} outputs")
    return word | bits


CHECKS = (shared,)
