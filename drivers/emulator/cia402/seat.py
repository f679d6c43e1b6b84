"""One node on its emulated bus: its device, its drive, and the bus' effect on its frames."""

from dataclasses import dataclass

from drivers.emulator.canopen.node import CanopenNode
from drivers.emulator.cia402.orders import OrderedAxis
from protocols.base.machine import Ns

SPREAD = 2147483647  # Park and Miller, as the servo's disturbance


@dataclass(frozen=True, slots=True)
class NodeFault:
    node: int
    code: int
    stamp_ns: Ns


Event = NodeFault


@dataclass(slots=True)
class Counters:
    frames: int = 0  # that some node listens to
    syncs: int = 0
    out_of_order: int = 0
    late: int = 0  # SYNCs passed in more than a cycle after their stamp
    dropped: int = 0  # telegrams swallowed to order
    error_frames: int = 0


@dataclass(slots=True)
class Seat:
    """One node of the bus and the bus' effect on its frames."""

    number: int  # in the settings; its node number may be changed by LSS
    node: CanopenNode
    axis: OrderedAxis
    delay_ns: Ns = 0
    spread_ns: Ns = 0
    random: int = 1
    drop_actual: int = 0
    drop_set: int = 0
    bus_off: bool = False  # with the complete interface: the next frame received ends it

    def seen(self) -> dict[str, object]:
        """State of the node for a tester, as plain JSON values."""
        axis, servo = self.axis, self.axis.servo
        return {
            "node": self.node.number,
            "nmt": self.node.state.name.lower(),
            "silent": self.node.silent,
            "state": axis.state.name.lower(),
            "statusword": axis.statusword,
            "mode": axis.mode.code,
            "error_code": axis.value((0x603F, 0)),
            "brake_open": axis.brake_open,
            "warning": axis.warning,
            "homed": axis.place.homed,
            "position_inc": int(servo.counter_inc // 1.0) + axis.place.shift,
            "position_rad": servo.position_rad,
            "speed_rad_s": servo.speed_rad_s,
            "torque_nm": servo.torque_nm,
            "inputs": axis.switches.inputs(servo.position_rad),
            "i2t": servo.i2t,
            "winding_c": servo.winding_c,
            "sync_worst_us": axis.sync_watch.worst // 1000,
            "sync_outside": axis.sync_watch.outside,
        }
