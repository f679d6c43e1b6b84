"""Objects of the drive profile by name.  Source: CiA 402-2 and 402-3 (IEC 61800-7-201); 2000h.. are axisgate's own (AX-285)."""

from protocols.canopen.dictionary import Key


def _whole(index: int) -> Key:
    return index, 0


ABORT_CONNECTION, ERROR_CODE = _whole(0x6007), _whole(0x603F)
CONTROLWORD, STATUSWORD = _whole(0x6040), _whole(0x6041)
QUICK_STOP_OPTION, SHUTDOWN_OPTION, DISABLE_OPTION = _whole(0x605A), _whole(0x605B), _whole(0x605C)
HALT_OPTION, FAULT_OPTION = _whole(0x605D), _whole(0x605E)
MODE, MODE_DISPLAY, MODES_SUPPORTED = _whole(0x6060), _whole(0x6061), _whole(0x6502)
POSITION_DEMAND, POSITION_COUNTER, POSITION, FOLLOWING_ERROR = _whole(0x6062), _whole(0x6063), _whole(0x6064), _whole(0x60F4)
FOLLOWING_WINDOW, FOLLOWING_TIME = _whole(0x6065), _whole(0x6066)
POSITION_WINDOW, POSITION_TIME = _whole(0x6067), _whole(0x6068)
SPEED_DEMAND, SPEED = _whole(0x606B), _whole(0x606C)
SPEED_WINDOW, SPEED_TIME, SPEED_THRESHOLD, SPEED_THRESHOLD_TIME = _whole(0x606D), _whole(0x606E), _whole(0x606F), _whole(0x6070)
TARGET_TORQUE, MAX_TORQUE, TORQUE_DEMAND, TORQUE, RATED_TORQUE = (
    *(_whole(0x6071), _whole(0x6072), _whole(0x6074), _whole(0x6077)),
    _whole(0x6076),
)
DC_LINK = _whole(0x6079)
TARGET_POSITION, HOME_OFFSET, LIMIT_MIN, LIMIT_MAX = _whole(0x607A), _whole(0x607C), (0x607D, 1), (0x607D, 2)
MAX_PROFILE_SPEED, MAX_MOTOR_RPM, PROFILE_SPEED = _whole(0x607F), _whole(0x6080), _whole(0x6081)
ACCELERATION, DECELERATION, QUICK_STOP_DECELERATION = _whole(0x6083), _whole(0x6084), _whole(0x6085)
MAX_ACCELERATION, MAX_DECELERATION = _whole(0x60C5), _whole(0x60C6)
HOMING_METHOD, HOMING_FAST, HOMING_SLOW, HOMING_ACCELERATION = _whole(0x6098), (0x6099, 1), (0x6099, 2), _whole(0x609A)
SPEED_OFFSET = _whole(0x60B1)
PROBE_FUNCTION, PROBE_STATUS = _whole(0x60B8), _whole(0x60B9)
PROBE_VALUES = (_whole(0x60BA), _whole(0x60BB), _whole(0x60BC), _whole(0x60BD))  # 1 rising, 1 falling, 2 rising, 2 falling
INTERPOLATED, PERIOD_VALUE, PERIOD_EXPONENT = (0x60C1, 1), (0x60C2, 1), (0x60C2, 2)
INPUTS, TARGET_SPEED = _whole(0x60FD), _whole(0x60FF)
CYCLE_PERIOD = _whole(0x1006)  # microseconds
SERIAL = (0x1018, 4)

SYNC_TOLERANCE, SYNC_FAULTS, SYNC_ERROR, SYNC_WORST, SYNC_LOCKED, SYNC_OUTSIDE = tuple((0x2001, sub) for sub in range(1, 7))
WINDING_TEMPERATURE, LOAD_LEVEL, REFERENCED, CLEAR_COUNTERS = _whole(0x2003), _whole(0x2004), _whole(0x2005), _whole(0x2010)

SUPPORTED_MODES = 0x3E5  # PP, PV, HM, IP, CSP, CSV, CST
