"""Inject a fault into emulated drives or their frames while a cell runs, or show the state of every drive. Emulated drives only."""

import argparse
import json

from drivers.ports.base import PortError, runtime_dir
from gateway.simulation.control_requests import BadCommandError
from gateway.simulation.drives.control import EmulatorControl
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.usage_language import complain

PREFIX, SUFFIX = "emulator-", ".sock"
EXAMPLES = """examples:
  axisgate fault state                                 what every emulated drive does
  axisgate fault stuck_encoder axis=1                  also wrong_sign, true_encoder, power_off, power_on, force_fault code=99
  axisgate fault phase_loss node=3 on=true             CiA 402 drives; also undervoltage, over_temperature, stick_brake, bus_off ...
  axisgate fault drop way=in id=100 count=3            frames: drop, delay (ms=), duplicate, corrupt (byte= bits=), quiet ms=500
  axisgate fault --emulator demo-drives load_torque axis=2 torque_nm=2.5
exit code: 0 done, 1 the emulator refused it (and lists what it accepts), 2 command line, 3 no emulator runs"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate fault", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", help="fault, or state")
    parser.add_argument("arguments", nargs="*", metavar="KEY=VALUE", help="numbers, true, false or a word")
    parser.add_argument("--emulator", help="name of the emulator, if several run")
    arguments = parser.parse_args(argv)
    try:
        values = dict(pair(text) for text in arguments.arguments)
    except ValueError as error:
        complain("fault", error)
        return USAGE
    running = emulators()
    wanted = [name for name in running if arguments.emulator in (None, name)]
    if len(wanted) != 1:
        several = f"several emulators are active: {', '.join(running)}; choose one: --emulator NAME"
        none = "no emulator is active; start one with: axisgate run CELL --sim"
        missing = f"no emulator {arguments.emulator!r} is active; active: {', '.join(running)}; choose one: --emulator NAME"
        complain("fault", (missing if arguments.emulator else several) if running else none)
        return ENVIRONMENT
    return order(wanted[0], arguments.what, values)


def order(name: str, what: str, values: dict[str, object]) -> int:
    try:
        control = EmulatorControl(name)
    except PortError as error:
        complain("fault", error)
        return ENVIRONMENT
    try:
        print(json.dumps(control.ask(what, **values), indent=1))
    except BadCommandError as error:
        complain("fault", error)
        return FINDING
    except PortError as error:
        complain("fault", error)
        return ENVIRONMENT
    finally:
        control.close()
    return DONE


def emulators() -> list[str]:
    """Names of the emulators that answer; a socket without a listener is left from a killed one."""
    found = []
    for path in sorted(runtime_dir().glob(f"{PREFIX}*{SUFFIX}")):
        name = path.name.removeprefix(PREFIX).removesuffix(SUFFIX)
        try:
            EmulatorControl(name, 1.0).close()
        except PortError:
            continue
        found.append(name)
    return found


def pair(text: str) -> tuple[str, object]:
    """ "count=3" -> ("count", 3).  Raises ValueError."""
    key, mark, value = text.partition("=")
    if not (mark and key.isidentifier()):
        raise ValueError(f"{text!r}: arguments are KEY=VALUE, e.g. axis=1")
    try:
        return key, json.loads(value)
    except json.JSONDecodeError:
        return key, value
