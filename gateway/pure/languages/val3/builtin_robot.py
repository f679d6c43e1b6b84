"""Instructions on the robot itself.  Source: VAL 3 reference 8 and 11-13, L4163-4470, L6062-6597."""

import math
from collections.abc import Generator, Sequence

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.builtin_geometry import joint_out
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.numbers import Place
from gateway.pure.languages.val3.robot_state import NO_DATA, REMOTE
from gateway.pure.languages.val3.values import Container, DioV, Grid, JointV, ToolV, TrsfV
from gateway.pure.languages.val3.virtual_io import last_name
from motion.kinematics.arm6 import Arm6
from motion.kinematics.dh import default_dh

Waiting = Generator[Ns | None, None, object]
Matrix = tuple[Container, bool]  # whether it is a local one
FAST = ("fin0", "fin1")
BRAKE_NS: Ns = 100_000_000  # test of one brake
BRAKE_FAILED, KILLED = 2, -13
BRAKE_NEAR = 0.1  # degrees or mm from the position of the brake test


def f_disable_power(own: Instance) -> Waiting:
    """Stops on the path, cuts the power, waits until it is off."""
    machine = own.machine
    machine.robot.disable()
    if not machine.current_is_synchronous:
        yield machine.now
    moves = machine.moves_or_none
    while machine.robot.powered or (moves is not None and moves.braking):
        yield None
    return None


def f_enable_power(own: Instance) -> None:
    """Only in remote mode; leaves an entry in the log."""
    if own.machine.robot.enable():
        own.machine.note("power on by program", "SYS")


def f_is_powered(own: Instance) -> bool:
    """Whether the arm has power."""
    return own.machine.robot.powered


def f_is_calibrated(own: Instance) -> bool:
    """A virtual arm always is."""
    return True


def f_working_mode(own: Instance, status: Place | None = None) -> float:
    """1 manual, 2 test, 3 local, 4 remote; status 0 programmed move, 1 connection move, hold by mode."""
    robot, moves = own.machine.robot, own.machine.moves_or_none
    if status is not None:
        held = {1: 6, 2: 3}.get(robot.mode, 2)
        connects = moves is not None and moves.connecting
        status[0][status[1]] = float(held if robot.hold or not robot.powered else connects)
    return float(robot.mode)


def f_es_status(own: Instance) -> float:
    """0 .. 3."""
    return float(own.machine.robot.estop)


def f_set_safety_restart(own: Instance) -> None:
    """Ends the wait for a safe restart (AX-1841)."""
    own.machine.robot.restart()


def f_get_monitor_speed(own: Instance) -> float:
    """0 .. 100."""
    return own.machine.robot.speed


def f_set_monitor_speed(own: Instance, speed: float) -> float:
    """0, -1, -2, -3."""
    return float(own.machine.robot.set_speed(speed))


def f_get_version(own: Instance, component: str) -> str:
    """ "" for an unknown component."""
    robot = own.machine.robot
    known = {
        "system": robot.version,
        "val3": robot.version.split("cs")[0].rstrip("."),
        "system date": "Jun  1 2016",
        "system time": "11:59:29",
        "arm type": robot.arm_type,
        "arm tuning": "R3",
        "arm mounting": "floor",
        "arm s/n": "virtual",
        "controller s/n": "virtual",
        "configuration version": "c2.009",
    }
    wanted = component.strip().lower()
    return robot.components.get(wanted, known.get(wanted, ""))


def f_get_jnt_ref(own: Instance, name: str) -> JointV:
    """70: no reference of that name."""
    found = own.machine.references.get(name)
    if found is None:
        raise Rte(70, f"joint reference {name!r}")
    return joint_out(own, found)


def f_hibernate_robot(own: Instance) -> float:
    """-3 while power is on, else what the drives and the safety board answer."""
    robot = own.machine.robot
    return -3.0 if robot.powered else float(robot.service.hibernate)


def f_wake_up_robot(own: Instance) -> float:
    """What the encoders and the safety board answer; 0 without hibernateRobot, too."""
    return float(own.machine.robot.service.wake)


def f_has_cpu_ext_power_supply(own: Instance) -> bool:
    """The controller itself reacts to a power failure (D11)."""
    return True


def f_prepare_cpu_shutdown(own: Instance) -> None:
    """Nothing is open."""


def f_brake_test(own: Instance, status: Place) -> Waiting:
    """0 all brakes hold, 1 one does not, below 0 the procedure failed; axes that were not tested get that code."""
    machine = own.machine
    values, first, axes = status[0], status[1], machine.axes
    if len(values) - first < axes:
        raise Rte(70, f"{axes} elements are needed")
    results = machine.robot.service.brakes or (0,) * axes
    tested, code = 0, KILLED
    try:
        while tested < axes and not (code := _no_brake_test(own, results)):
            end, code = machine.now + BRAKE_NS, KILLED
            while machine.now < end:
                yield end
            values[first + tested] = float(results[tested])
            tested += 1
    finally:  # also where the task is killed
        values[first + tested : first + axes] = [float(code)] * (axes - tested)
    return float(code) if tested < axes else float(any(result == BRAKE_FAILED for result in results))


def _no_brake_test(own: Instance, results: Sequence[int]) -> int:
    """-1 not remote, -2 moving, -3 not in its position, -5 powered, -14 no data; 0: it can be made."""
    machine = own.machine
    if machine.robot.mode != REMOTE:
        return -1
    if machine.arm is not None and not machine.moves.resting:
        return -2
    if machine.robot.powered:
        return -5
    place = machine.robot.service.brake_position
    if machine.arm is not None and any(abs(a - b) > BRAKE_NEAR for a, b in zip(place, machine.moves.joints(), strict=False)):
        return -3
    if len(results) < machine.axes or min(results) < 0:
        return NO_DATA
    return 0


def f_set_latch(own: Instance, source: DioV) -> None:
    """Only fIn0 and fIn1; 70."""
    point = own.machine.io.usable(source.link)
    if last_name(point.path).lower() not in FAST:
        raise Rte(70, f"{point.path} is not a fast input")
    own.machine.latch.arm(point)


def f_get_latch(own: Instance, joint: JointV) -> bool:
    """The position of the edge, once there was one."""
    found = own.machine.latch.position
    if found is None:
        return False
    joint.set(joint_out(own, found))
    return True


def f_set_payload(own: Instance, tool: ToolV, mass: float, centre: TrsfV, inertia: Matrix) -> float:
    """0, -4, -5; 70 for a matrix of another size."""
    numbers = inertia[0].flat if isinstance(inertia[0], Grid) else inertia[0]
    if isinstance(numbers, dict) or len(numbers) not in (1, 3, 9):
        raise Rte(70, "an inertia matrix of 1, 3 or 9 elements is needed")
    if mass < 0:
        return -4.0
    if len(numbers) == 9 and any(numbers[3 * i + j] != numbers[3 * j + i] for i in range(3) for j in range(i)):
        return -5.0
    own.machine.payload = (mass, centre.numbers(), tuple(value for value in numbers if isinstance(value, float)))
    return 0.0


def f_get_payload(own: Instance, tool: ToolV, mass: Place, centre: TrsfV, inertia: Matrix) -> float:
    """The array gets 9 elements, or stays at 3 where the matrix is diagonal; 71 for a local one of another size (L6123)."""
    kilograms, place, matrix = own.machine.payload
    container, local = inertia
    if isinstance(container, dict):
        raise Rte(70, "an array is needed")
    full = _full(matrix)
    short = not isinstance(container, Grid) and len(container) == 3 and all(full[k] == 0 for k in (1, 2, 3, 5, 6, 7))
    size = container.dims if isinstance(container, Grid) else (len(container),)
    if (local or (isinstance(container, Grid) and container.local)) and not short and size not in ((3, 3), (9,)):
        raise Rte(71, f"a matrix of {' x '.join(map(str, size))}")
    mass[0][mass[1]] = kilograms
    centre.set(TrsfV(*place))
    if isinstance(container, Grid):
        container.dims, container.flat[:] = (3, 3), list(full)
    else:
        container[:] = [full[0], full[4], full[8]] if short else list(full)
    return 0.0


def _full(matrix: tuple[float, ...]) -> tuple[float, ...]:
    if len(matrix) == 9:
        return matrix
    if len(matrix) == 3:
        return (matrix[0], 0.0, 0.0, 0.0, matrix[1], 0.0, 0.0, 0.0, matrix[2])
    return (0.0,) * 9


def f_get_ids(own: Instance, ids: Place) -> None:
    """Newest first, 20 at most."""
    newest = [float(event.id) for event in reversed(own.machine.events)]
    for at in range(ids[1], len(ids[0])):
        if at - ids[1] < len(newest):
            ids[0][at] = newest[at - ids[1]]


def f_get_events(own: Instance, number: Place, ids: Place, types: Place, infos: Place) -> float:
    """Oldest first from a number on; the last number read."""
    events = own.machine.events
    wanted = number[0][number[1]]
    assert isinstance(wanted, float)
    start = math.floor(wanted + 0.5)
    last = own.machine.event_count
    if start > last or not events:
        return float(last)
    start = max(start, last - len(events) + 1)
    room = min(*(len(array[0]) - array[1] for array in (ids, types, infos)), 20)
    read = events[start - (last - len(events) + 1) :][:room]
    for at, event in enumerate(read):
        ids[0][ids[1] + at], types[0][types[1] + at], infos[0][infos[1] + at] = float(event.id), float(event.type), event.info
    number[0][number[1]] = float(start)
    return float(start + len(read) - 1)


def f_get_licence(own: Instance, name: str, password: str) -> str:
    """ "" : not installed; oemLicenceDisabled: the controller has not the option to test one."""
    machine = own.machine
    tested = machine.licences or machine.robot.components.get("oemlicence")
    return machine.licences.get(name, "") if tested else "oemLicenceDisabled"


def f_get_default_dh(own: Instance, *arrays: Place) -> None:
    """theta, d, a[, b], alpha, beta of the arm as built (D16), mm and degrees; 570 for an arm without that chain, 70 for small arrays."""
    kinematics = own.machine.arm.kinematics if own.machine.arm is not None else None
    if not isinstance(kinematics, Arm6):
        raise Rte(570, "the arm has no such chain")
    chain = default_dh(kinematics.geometry)
    rows = [chain.theta, chain.d, chain.a, chain.b, chain.alpha, chain.beta]
    if len(arrays) == len(rows) - 1:
        del rows[3]
    for array, row in zip(arrays, rows, strict=True):
        if len(array[0]) - array[1] < len(row):
            raise Rte(70, f"{len(row)} elements are needed")
        array[0][array[1] : array[1] + len(row)] = list(row)


def f_get_dh(own: Instance, *arrays: Place) -> None:
    """As built: nothing else is in force in a virtual run."""
    f_get_default_dh(own, *arrays)


def f_set_dh(own: Instance, *arrays: Place) -> bool:
    """250: the option absolute robot is not installed."""
    raise Rte(250, "absolute robot")
