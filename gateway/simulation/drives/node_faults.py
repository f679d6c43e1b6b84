"""Commands to the CiA 402 drives of an emulator process; socket and form as in gateway.simulation.drives.control.

    {"do": "state"}                                       every node, counters
    {"do": "stuck_encoder", "node": 5}                    also wrong_sign, true_encoder, power_off, power_on, reset_node, bus_off, bus_on
    {"do": "drop_actual", "node": 5, "count": 3}          also drop_set
    {"do": "jump_encoder", "node": 5, "increments": 4096}
    {"do": "force_fault", "node": 5, "code": 65280}       any code of 603Fh
    {"do": "load_torque", "node": 5, "torque_nm": 2.5}
    {"do": "undervoltage", "node": 5, "on": true}         also overvoltage, phase_loss, over_temperature, motor_over_temperature,
                                                          encoder_fault, short_circuit, motor_blocked, stick_brake, local_control,
                                                          memory_broken
    {"do": "refuse", "node": 5, "index": 24698, "sub": 0, "code": 134217728, "count": 1}   the next SDO accesses end in this abort code

"axis" may replace "node".
"""

from collections.abc import Callable
from functools import partial

from drivers.emulator.cia402.errors import CAUSES
from drivers.emulator.cia402.slave import Cia402Slave
from gateway.simulation.control_requests import Answer, BadCommandError, Command, switched, torque_nm, whole

MOST = 1_000_000


def carry_out_node(slave: Cia402Slave, command: Command) -> Answer:
    """One fault to trigger, or the state.  Raises BadCommandError."""
    what = str(command.get("do"))
    if what == "state":
        return slave.state()
    node = whole(command, "node" if "node" in command else "axis", 1, 127)
    orders = _orders(slave, node, command)
    if what not in orders:
        raise BadCommandError(f"{what!r} is not a command; known: {', '.join(['state', 'quit', 'flush', *orders])}")
    try:
        orders[what]()
    except KeyError as error:
        raise BadCommandError(str(error.args[0])) from None
    return {"bus_time_ns": slave.state()["bus_time_ns"]}


def _orders(slave: Cia402Slave, node: int, command: Command) -> dict[str, Callable[[], None]]:
    orders: dict[str, Callable[[], None]] = {}
    for name in ("stuck_encoder", "wrong_sign", "true_encoder", "power_off", "power_on", "reset_node", "bus_off", "bus_on"):
        plain: Callable[[int], None] = getattr(slave, name)
        orders[name] = partial(plain, node)
    for name in ("drop_actual", "drop_set"):
        counted: Callable[[int, int], None] = getattr(slave, name)
        orders[name] = partial(_count, partial(counted, node), command)
    for name in CAUSES:
        orders[name] = partial(_switch, partial(slave.cause, node, name), command)
    for name in ("stick_brake", "local_control", "memory_broken"):
        switched: Callable[[int, bool], None] = getattr(slave, name)
        orders[name] = partial(_switch, partial(switched, node), command)
    orders["jump_encoder"] = lambda: slave.jump_encoder(node, whole(command, "increments", -(1 << 31), (1 << 31) - 1))
    orders["force_fault"] = lambda: slave.force_fault(node, whole(command, "code", 1, 0xFFFF) if "code" in command else 0xFF00)
    orders["load_torque"] = lambda: slave.load_torque(node, torque_nm(command))
    orders["refuse"] = lambda: slave.refuse(
        node,
        whole(command, "index", 0, 0xFFFF),
        whole(command, "sub", 0, 255),
        whole(command, "code", 1, 0xFFFFFFFF),
        whole(command, "count", 1, MOST) if "count" in command else 1,
    )
    return orders


def _switch(act: Callable[[bool], None], command: Command) -> None:
    act(switched(command))


def _count(act: Callable[[int], None], command: Command) -> None:
    act(whole(command, "count", 0, MOST))
