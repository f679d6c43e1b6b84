"""P113, P114, P128 of [rho3]: speeds and slopes of the page's jog keys, for every axis."""

from gateway.checks.context import Context


def jogging(check: Context) -> None:
    """Slow not above fast, fast not above the limit of the axis."""
    others = check.cell.rho3.others if check.cell.rho3 else {}
    if "P113" not in others:
        return
    from gateway.assembly.jog import jog_of
    from motion.errors import MotionError

    try:
        jog_of(check.cell)
    except MotionError as error:
        name = str(error)[:4]
        check.fault(f"rho3.{name}", others.get(name, ""), str(error))


CHECKS = (jogging,)
