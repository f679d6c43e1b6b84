"""The keys of the pendant of a rho 3.  Source: rho3 7.4 (L10486-10576)."""

from gateway.pure.controllers.unit import LETTERS, HandUnit

KEYPAD = (
    ("MODE", "INFO", "UP", "DELETE"),
    ("7", "8", "9", "LEFT"),
    ("4", "5", "6", "RIGHT"),
    ("1", "2", "3", "DOWN"),
    ("0", ".", "-", "ENTER"),
)
TYPED = {
    "m": "MODE", "i": "INFO", "enter": "ENTER", "backspace": "DELETE", "delete": "DELETE", "full_stop": ".", "comma": ".", "minus": "-",
    "up": "UP", "down": "DOWN", "left": "LEFT", "right": "RIGHT",
}  # fmt: skip
# by their place: KEY.BNR defines the function
PLACES = tuple(f"{level}K{number}" for level in ("", "SHIFT+", "ALT+") for number in range(1, 37))
BACKUP = "ALT+MODE+DELETE+PERMISSION"  # pressed together: EPROM backup, whatever KEY.BNR makes of the keys (L10386, L11553)
UNIT = HandUnit("rho 3", 20, 4, KEYPAD, TYPED, (*LETTERS, *PLACES, BACKUP))
