"""The line process of the serial rig."""

from hil_tests.rig.serial.conftest import line, runtime

__all__ = ["line", "runtime"]
