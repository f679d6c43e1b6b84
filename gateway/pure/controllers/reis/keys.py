"""The keys of the pendant of a Reis control, as command sources, wires and tools press them.  Pure."""

from dataclasses import dataclass, field

from gateway.pure.controllers.reis.hand_keys import HandKeys

KEYS = ("start", "stop", "f1", "f2", "exec", "quit")


@dataclass(slots=True)
class Keys:
    """Of the pendant, as levels; a command source, a wire or a tool presses them."""

    test: int = 0  # operating mode while it is not AUTO: 0 HAND, 1..6 Test
    middle: bool = False  # the key selector is at Cal/Sync: START is held while the robot moves (L1214)
    hand: HandKeys = field(default_factory=HandKeys)
    levels: dict[str, bool] = field(default_factory=lambda: dict.fromkeys(KEYS, False))
    before: dict[str, bool] = field(default_factory=lambda: dict.fromkeys(KEYS, False))

    def edges(self) -> dict[str, bool]:
        """Keys that were pressed (True) or released since the last call."""
        found = {key: level for key, level in self.levels.items() if level is not self.before[key]}
        self.before = dict(self.levels)
        return found

    def put(self, name: str, value: float) -> None:
        """mode, selector, key.NAME or of the hand; KeyError, ValueError."""
        if self.hand.put(name, value):
            return
        if name == "mode":
            if value not in range(7):
                raise ValueError(f"reis.mode {value:g}: 0 HAND, 1..6 Test")
            self.test = int(value)
        elif name == "selector":
            self.middle = bool(value)
        else:
            key = name.removeprefix("key.")
            if key not in self.levels:
                raise KeyError(name)
            self.levels[key] = bool(value)

    def value(self, name: str) -> float:
        """The same, read; KeyError."""
        if (found := self.hand.value(name)) is not None:
            return found
        if name in ("mode", "selector"):
            return float(self.test if name == "mode" else self.middle)
        return float(self.levels[name.removeprefix("key.")])

    @staticmethod
    def names() -> list[str]:
        """Behind `reis.`."""
        return ["mode", "selector", *(f"key.{key}" for key in KEYS), *HandKeys.names()]
