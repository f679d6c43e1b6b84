"""Values by the ids of gateway.observer.names, from the regions and from the last report of the services; for the page and `axisgate
monitor`."""

from collections.abc import Iterable
from typing import Any

from gateway.observer.names import AXIS_FIELDS
from gateway.observer.regions import Regions
from gateway.observer.tool_link import Gone, Refused, ServicesLink
from gateway.pure.image.records.cell import RC_BYTES, Quality

Row = dict[str, Any]


class Watched:
    """Call `look` for values that only the services have; values from the regions are equally fresh."""

    def __init__(self, regions: Regions) -> None:
        self.regions = regions
        self.looked: Row = {"blocks": {}, "named": {}, "contacts": {}, "forced": {}, "forced_words": {}}
        self.fresh = False

    async def look(self, services_link: ServicesLink) -> None:
        """Data blocks, named values, forces; services that do not answer leave the last ones, marked old."""
        try:
            self.looked = await services_link.ask("look")
            self.fresh = True
        except (Gone, Refused):
            self.fresh = False

    def values(self, names: Iterable[str]) -> Row:
        """Those that exist."""
        rows = {row["name"]: row for row in self.regions.drives()}
        return {name: value for name in names if (value := self.value(name, rows)) is not None}

    def value(self, name: str, rows: dict[str, Row]) -> list[object] | None:
        """[value, quality 0..2, age ms, forced]; None: no such value."""
        kind, _, rest = name.partition(":")
        match kind:
            case "in":
                forced = rest in self.looked["forced"]
                return [*self.regions.input_bit(int(rest)), forced]
            case "out":
                return [*self.regions.output_bit(int(rest)), False]
            case "inw" | "outw":
                return self._image_word(kind, rest)
            case "db":
                return self._word(rest)
            case "io":
                contact = self.looked["contacts"].get(rest)
                return None if contact is None else [contact[0], contact[1] if self.fresh else int(Quality.STALE), None, contact[2]]
            case "named":
                found = self.looked["named"].get(rest)
                return None if found is None else [found[0], found[1] if self.fresh else int(Quality.STALE), found[2], False]
        return self._own(name, rows)

    def _image_word(self, kind: str, rest: str) -> list[object] | None:
        """Bytes of the process image: as good and as fresh as the worst of them."""
        byte, _, size = rest.partition(":")
        if not (byte.isdecimal() and size.isdecimal() and 0 < int(size) <= 4 and int(byte) + int(size) <= RC_BYTES):
            return None
        octets = range(int(byte), int(byte) + int(size))
        image, look = (
            (self.regions.inputs.values, self.regions.input_bit) if kind == "inw" else (self.regions.outputs, self.regions.output_bit)
        )
        samples = [look(8 * octet) for octet in octets]
        ages = [age for _, _, age in samples]
        bits = {str(bit) for octet in octets for bit in range(8 * octet, 8 * octet + 8)}
        forced = kind == "inw" and not bits.isdisjoint(self.looked["forced"])
        oldest = None if None in ages else max(age for age in ages if age is not None)
        return [bytes(image[octet] for octet in octets).hex(), min(quality for _, quality, _ in samples), oldest, forced]

    def _word(self, rest: str) -> list[object] | None:
        """Data blocks: four bytes from the word on, or a bit."""
        block, _, where = rest.partition(":")
        found = self.looked["blocks"].get(block)
        if found is None:
            return None
        data = bytes.fromhex(found["hex"])
        quality = int(Quality.GOOD if self.fresh and found["alive"] else Quality.STALE)
        word, dot, bit = where.partition(".")
        number = int("".join(c for c in word if c.isdigit()))
        forced = self.looked["forced_words"].get(f"{block}:{number}", 0)
        if dot:
            value = int.from_bytes(data[2 * number : 2 * number + 2], "big") >> int(bit) & 1
            return [value, quality, None, bool(forced >> int(bit) & 1)]
        mask = {"DL": 0xFF00, "DR": 0x00FF}.get(word[-2:], 0xFFFF)
        return [data[2 * number : 2 * number + 4].hex(), quality, None, bool(forced & mask)]

    def _own(self, name: str, rows: dict[str, Row]) -> list[object] | None:
        age = self.regions.ages()[0]
        quality = int(Quality.GOOD if age < 250 else Quality.STALE)
        shown = None if age == float("inf") else round(age)
        match name.split("."):
            case ["axis", axis, key] if axis in rows and key in AXIS_FIELDS:
                row = rows[axis]
                flags = {"enabled": 1, "referenced": 2, "in_position": 4, "fault": 24}
                return [int(bool(row["flags"] & flags[key])) if key in flags else row[key], quality, shown, False]
            case ["cell", key]:
                state = self.regions.state
                values: dict[str, object] = {
                    "ready": int(state.ready),
                    "drives_on": int(all(row["flags"] & 1 for row in rows.values())),
                    "emergency_stop": int(state.emergency),
                    "error": int(bool(self.regions.status.get("errors"))),
                    "life": state.cycle & 0x7FFF,
                    "override": round(state.override * 100.0, 1),
                    "motion": int(state.motion),
                }
                return [values[key], quality, shown, False] if key in values else None
        return None
