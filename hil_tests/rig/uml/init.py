"""Process 1 in the guest: load kernel modules, set up lo and vcan0, run the command, write its exit code, power off.

Needs no module tools: the kernel takes the module's bytes by system call.
"""

import contextlib
import ctypes
import json
import os
import pathlib
import platform
import subprocess
import sys
import termios
import traceback

from hil_tests.rig.uml.guest import BEGIN, END

INIT_MODULE = {"x86_64": 175, "aarch64": 105, "i686": 128}  # system call numbers, Linux
POWER_OFF = 0x4321FEDC  # reboot(2)
NEEDED = ("net/can/can", "net/can/can-raw", "drivers/net/can/dev/can-dev", "drivers/net/can/vcan")  # in this order
WELCOME = ("net/can/can-bcm", "net/can/can-gw")


def insert_module(path: pathlib.Path) -> None:
    image = path.read_bytes()
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.syscall(INIT_MODULE[platform.machine()], image, ctypes.c_ulong(len(image)), b""):
        error = ctypes.get_errno()
        if error != 17:  # EEXIST: already there
            raise OSError(error, f"{path}: {os.strerror(error)}")


def set_up(modules: pathlib.Path | None) -> None:
    """`modules`: None where the kernel has all of them built in."""
    if modules is not None:
        insert_modules(modules)
    for words in ("link set lo up", "link add dev vcan0 type vcan", "link set vcan0 txqueuelen 1000", "link set vcan0 up"):
        subprocess.run(["ip", *words.split()], check=True)


def insert_modules(modules: pathlib.Path) -> None:
    for name in NEEDED:
        insert_module(modules / "kernel" / f"{name}.ko")
    for name in WELCOME:
        with contextlib.suppress(OSError):
            insert_module(modules / "kernel" / f"{name}.ko")


def run(order: dict[str, object]) -> int:
    command, environment = order["command"], order["environment"]
    assert isinstance(command, list) and isinstance(environment, dict)
    child = subprocess.Popen(command, cwd=str(order["cwd"]), env=environment, stdin=subprocess.DEVNULL)
    while True:
        pid, status = os.wait()  # process 1 also reaps orphans
        if pid == child.pid:
            return os.waitstatus_to_exitcode(status)


def main() -> None:
    order = json.loads(pathlib.Path(sys.argv[1]).read_text())
    code = 125
    try:
        set_up(pathlib.Path(order["modules"]) if order["modules"] else None)
        print(BEGIN, flush=True)
        code = run(order)
    except Exception:
        print(BEGIN)
        traceback.print_exc()
    finally:
        pathlib.Path(order["exit_code"]).write_text(str(code))
        print(f"\n{END}", flush=True)
        with contextlib.suppress(termios.error):
            termios.tcdrain(1)  # the console's last lines would die with the kernel
        os.sync()
        ctypes.CDLL(None).reboot(POWER_OFF)


if __name__ == "__main__":
    main()
