"""Keys of the pendant: their names at the services' panel, and what types them on a keyboard.  Source: rho3 7.4 (L10486-10576)."""

KEYPAD = (
    ("MODE", "INFO", "UP", "DELETE"),
    ("7", "8", "9", "LEFT"),
    ("4", "5", "6", "RIGHT"),
    ("1", "2", "3", "DOWN"),
    ("0", ".", "-", "ENTER"),
)
ARROWS = {"UP": "↑", "DOWN": "↓", "LEFT": "←", "RIGHT": "→"}
TYPED = {
    "m": "MODE", "i": "INFO", "enter": "ENTER", "backspace": "DELETE", "delete": "DELETE", "full_stop": ".", "comma": ".", "minus": "-",
    "up": "UP", "down": "DOWN", "left": "LEFT", "right": "RIGHT",
}  # fmt: skip
PLACES = frozenset(f"{level}K{number}" for level in ("SHIFT+", "ALT+") for number in range(1, 37)) | frozenset(
    f"K{number}" for number in range(1, 37)
)  # keys by their place: KEY.BNR says what they are
NAMES = frozenset(name for row in KEYPAD for name in row) | frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZ") | PLACES


def key_of(typed: str, character: str | None) -> str | None:
    """The pendant's key for one of the keyboard; letters are those of READ PHG, M and I with shift.  None: no key of the pendant."""
    if typed in TYPED:
        return TYPED[typed]
    name = (character or "").upper()
    return name if name in NAMES else None


def keys_of(words: str) -> list[str]:
    """`MODE 7.3.2 ENTER`: names and characters as they are pressed.  ValueError names what is no key."""
    keys: list[str] = []
    for word in words.upper().split():
        parts = [word] if word in NAMES else list(word)
        wrong = [part for part in parts if part not in NAMES]
        if wrong:
            raise ValueError(
                f"{wrong[0]!r} in {word!r} is no key; keys are {', '.join(name for row in KEYPAD for name in row)} and letters"
            )
        keys += parts
    return keys
