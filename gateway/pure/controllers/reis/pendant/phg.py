"""The PHG of a ROBOTstar V: 20 lines, modes and menus; keys come in, orders go out.  Pure.

Line 1 has the override, line 2 step, place and operating mode, lines 3 to 18 the directory or the program with its windows, lines 19 and
20 the menu of the function keys.  Source: robotstar 8.2 (L1019-1548), 1.6 (L1552-1558); AX-1660.
"""

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gateway.pure.controllers.reis.access import Codes, Level, Operation, Pendant
from gateway.pure.controllers.reis.pendant.entry import QUESTIONS, Entry
from gateway.pure.controllers.reis.pendant.listing import HIGH, Listing
from gateway.pure.controllers.reis.pendant.menus import LEVELS, MENUS, MOVE, TEST, Item
from gateway.pure.controllers.reis.pendant.unit import CHARACTERS, COLUMNS, FUNCTION_KEYS, LINES, MODE_KEYS, MOVEMENT
from gateway.pure.controllers.reis.pendant.view import Order, View, window
from gateway.pure.controllers.reis.pendant.words import say

CONTENT = LINES - 4
CELL = 6  # characters of a function key's label
BAR = 24
NEEDED = {Level.SETTER: "needs code word 1", Level.PROGRAMMER: "needs code word 2", Level.MANUFACTURER: "needs the PIN"}
ROOT = "DIR /"
NO_PROGRAM = "open a program first"


@dataclass(slots=True)
class Overlay:
    """What lies over directory and program: the menu's level, a window and its first line, an entry, a sentence, SHIFT or ALT."""

    menu: int = 0
    window: str = ""
    first: int = 0
    entry: Entry | None = None
    notice: str = ""
    shift: str = ""
    status: bool = True


class Phg:
    """`press` for each key; `orders` are taken by who can carry them out."""

    def __init__(self, codes: Codes, language: str = "en") -> None:
        self.language = language
        self.access = Pendant(codes)
        self.locked = codes != Codes()  # without code words in the cell the lock could not be opened (AX-1660)
        if not self.locked:
            self.access.level = Level.MANUFACTURER
        self.mode = "dir"
        self.directory = Listing("", (ROOT, "END"), names=("", ""))
        self.program: Listing | None = None
        self.overlay = Overlay()
        self.orders: list[Order] = [Order("list")]
        self.view = View()
        self._folders: Mapping[str, Sequence[tuple[str, str]]] = {}
        self._seen = ("", 0)  # program and step of the control that the cursor followed last
        self._chosen = False  # another program or step than the control's: START selects it

    # ---- inputs -----------------------------------------------------------------------------------------------------------
    def see(self, view: View) -> None:
        """The cell now: the cursor follows the program that is executed (L1206)."""
        self.view = view
        place = (view.program.upper(), view.step)
        if self.program is not None and place != self._seen and self._is_shown(place[0]):
            self.program.go(view.step)
            self._chosen = False
        self._seen = place

    def _is_shown(self, name: str) -> bool:
        return self.program is not None and bool(name) and name in (_key(self.program.path), _key(self.program.path).rpartition("/")[2])

    def listed(self, folders: Mapping[str, Sequence[tuple[str, str]]]) -> None:
        """Directories: path -> name and line of each entry, in their order (L1039-1056)."""
        self._folders = folders
        self._enter(self.directory.path if self.directory.path in folders else "", self.directory.cursor)

    def opened(self, path: str, rows: Sequence[str], step: int = 0) -> None:
        """The steps of a program that was asked for; `step`: it was changed, START begins here (L209)."""
        self.program = Listing(path, tuple(rows), program=True)
        self._chosen = _key(path) != self.view.selected or bool(step)
        if step:
            self.program.go(step)
        elif not self._chosen and self._is_shown(self.view.program.upper()):
            self.program.go(self.view.step)
        self._to("edit")

    def says(self, words: str) -> None:
        """A sentence until the next key."""
        self.overlay.notice = say(words, self.language)

    def _enter(self, path: str, cursor: int = 1) -> None:
        found = self._folders.get(path, ())
        head = [(f"DIR {path.rpartition('/')[2]}" if path else ROOT, "")] + ([("..  <DIR>", "..")] if path else [])
        rows = [*head, *((line, f"{path}/{name}".lstrip("/")) for name, line in found), ("END", "")]
        self.directory = Listing(path, tuple(row for row, _ in rows), names=tuple(name for _, name in rows))
        self.directory.go(cursor)

    # ---- keys --------------------------------------------------------------------------------------------------------------
    def press(self, key: str) -> None:
        """A key by its name; one that the pendant does not have changes nothing."""
        overlay = self.overlay
        shift, overlay.notice = overlay.shift, ""
        overlay.shift = key if key in ("SHIFT", "ALT") and key != shift else ""
        if key in MODE_KEYS:
            overlay.entry = None
            self._to(MODE_KEYS[key])
        elif key in ("START", "STOP", "EXEC"):
            self._run(key)
        elif key == "QUIT":
            self._quit()
        elif key in ("OV-", "OV+", "PC-I", "PC-O"):
            self._regulate(key)
        elif overlay.entry is not None:
            self._type(overlay.entry, key, shift)
        elif key in FUNCTION_KEYS:
            self._function(FUNCTION_KEYS.index(key))
        elif key in ("MENU-", "MENU+"):
            overlay.menu = (overlay.menu + (1 if key == "MENU+" else -1)) % len(MENUS[self.mode])
        elif key in ("UP", "DOWN", "LEFT", "RIGHT"):
            self._arrow(key, shift)
        elif key == "STEP":
            overlay.entry = Entry("step")
        elif key == "ENTER":
            self._choose()
        elif key in MOVEMENT:
            self.moves(key)

    def moves(self, key: str) -> bool:
        """Return whether a movement key may act now; otherwise show the reason."""
        if self.access.may(MOVE) and not self.view.mode:
            self.says("hold the movement key: it moves for as long as it is held")
            return True
        if not self._denied(MOVE):
            self.says("movement keys act in HAND")
        return False

    def _to(self, mode: str) -> None:
        self.mode, self.overlay.menu, self.overlay.window, self.overlay.first = mode, 0, "", 0
        if mode == "dir":
            self.orders.append(Order("list"))
        if mode == "coor":
            self.overlay.window = _window_of(self.view.coor)

    def _denied(self, operation: Operation | None) -> bool:
        """Return whether the access level is too low; if so show the required one."""
        if operation is None or self.access.may(operation):
            return False
        self.says(NEEDED[operation.level])
        return True

    def _quit(self) -> None:
        """Closes the entry, then the window (L1347); else it acknowledges and leads back to the program."""
        if self.overlay.entry is not None:
            self.overlay.entry = None
        elif self.overlay.window:
            self.overlay.window = ""
        else:
            self.orders.append(Order("quit"))
            if self.mode != "dir" and self.program is not None:
                self._to("edit")

    def _run(self, key: str) -> None:
        """START begins at the cursor of the program that is open (L1260); choosing another place is selecting it."""
        shown = self.program
        if key == "STOP" or shown is None or not self._chosen or self.mode == "dir":
            self.orders.append(Order(key.lower()))
        elif not self._denied(TEST):
            self._chosen = False
            self.orders.append(Order(key.lower(), _key(shown.path), shown.cursor))

    def _regulate(self, key: str) -> None:
        """The override regulator; with I its number becomes mm a turn, with O % again (L187-193)."""
        if key == "PC-O":
            self.orders.append(Order("position"))
        elif key == "PC-I":
            wrong = "Position Control needs tXYZ or tUVW" if self.view.coor not in (1, 2) else ""
            wrong = wrong or ("" if self.view.override else "set the override above 0 first")
            if wrong:
                self.says(wrong)
            elif not self._denied(MOVE):
                self.orders.append(Order("position", number=self.view.override))
        else:
            self.orders.append(Order("wheel" if self.view.position else "override", number=1 if key == "OV+" else -1))

    def _arrow(self, key: str, shift: str) -> None:
        """Scrolls the window that is open, else directory or program."""
        if self.overlay.window and key in ("UP", "DOWN"):
            far = (HIGH if shift == "SHIFT" else 1) * (1 if key == "DOWN" else -1)
            rows = len(window(self.overlay.window, self.view, 0, self.language))
            self.overlay.first = min(max(self.overlay.first + far, 0), max(rows - 1, 0))
        else:
            self.listing.move(key, shift, COLUMNS)
            self._moved()

    def _moved(self) -> None:
        """The cursor may be at another step than the control (L1209)."""
        if self.mode != "dir" and self.program is not None:
            own = _key(self.program.path) == self.view.selected and self._is_shown(self.view.program.upper())
            self._chosen = not own or self.program.cursor != self.view.step

    @property
    def listing(self) -> Listing:
        """What the cursor is in."""
        return self.directory if self.mode == "dir" or self.program is None else self.program

    def _choose(self) -> None:
        """ENTER: a directory is entered, a program opened (L1082-1086)."""
        if self.mode != "dir":
            return
        name = self.directory.names[self.directory.cursor - 1]
        if name == "..":
            self._enter(self.directory.path.rpartition("/")[0])
        elif name in self._folders:
            self._enter(name)
        elif name:
            self.orders.append(Order("open", name))

    # ---- function keys -----------------------------------------------------------------------------------------------------
    @property
    def menu(self) -> tuple[Item, ...]:
        """Of the function keys now."""
        return LEVELS if self.view.waits == "F1 or F2" else MENUS[self.mode][self.overlay.menu]

    def _function(self, number: int) -> None:
        menu = self.menu
        if number >= len(menu):
            return
        item = menu[number]
        if item.absent:
            self.says(item.absent)
        elif not self._denied(item.needs):
            self._act(item)

    def _act(self, item: Item) -> None:
        match item.act:
            case "ask":
                self._ask(item.value)
            case "show":
                self.overlay.window, self.overlay.first = item.value, 0
            case "status":
                self.overlay.status = not self.overlay.status
            case "auto" if self.view.mode != "auto":
                self.says("AUTO is RC input 23")
            case "test" if self.view.mode == "auto":
                self.says("in AUTO: RC input 23 ends it")
            case "suppress":
                self.orders.append(Order("suppress"))
                self.says("messages that stay are hidden until the drives are on")
            case "coor":
                self.overlay.window = _window_of(int(item.value))
                self.orders.append(Order("coor", number=int(item.value)))
            case "change" if self.program is not None:
                self.orders.append(Order("change", self.program.path, more=f"{item.value} {self.program.cursor}"))
            case "change":
                self.says(NO_PROGRAM)
            case "test" | "plc" | "mouse" | "macro" | "level":
                self.orders.append(Order(item.act, item.value))

    def _ask(self, what: str) -> None:
        if what == "code" and not self.locked:
            self.says("this cell has no code words")
            return
        if what == "edit":
            if self.program is None:
                self.says(NO_PROGRAM)
            else:
                self.overlay.entry = Entry(what, self.program.now.lstrip("\\"))
            return
        name = self.directory.names[self.directory.cursor - 1] if self.mode == "dir" else ""
        given = name if what in ("delete", "copy", "rename", "protect") and name not in self._folders and name != ".." else ""
        self.overlay.entry = Entry(what, given)

    # ---- entries -----------------------------------------------------------------------------------------------------------
    def _type(self, entry: Entry, key: str, shift: str) -> None:
        if key == "ENTER":
            self.overlay.entry = None
            self._entered(entry)
        elif key in CHARACTERS or key == "DELETE":
            entry.type(key)
        elif key in ("LEFT", "RIGHT") or (key in ("SHIFT", "ALT")):
            entry.move(key, shift)
        else:
            self.says("close the entry first: ENTER or QUIT")

    def _entered(self, entry: Entry) -> None:
        words = entry.text.strip()
        match entry.what:
            case "code":
                known = self.access.enter(words)
                self.overlay.notice = f"{say('access level', self.language)} {self.access.level.value}"
                if not known:
                    self.says("unknown code word")
            case "step" if not words.isdecimal() or not 1 <= int(words) <= len(self.listing.rows):
                self.says("no such step")
            case "step":
                self.listing.go(int(words))
                self._moved()
            case "find" if not words or not self.listing.find(words):
                self.says("not found")
            case "find":
                self._moved()
            case "program" if words.strip("/").upper() in {path.upper() for path in self._folders}:
                self._to("dir")
                self._enter(next(path for path in self._folders if path.upper() == words.strip("/").upper()))
            case "program":
                self.orders.append(Order("open", words.strip("/")))
            case "edit" if self.program is not None:
                self.orders.append(Order("change", self.program.path, more=f"edit {self.program.cursor} {words}"))
            case "variable":
                self.overlay.window, self.overlay.first = "variable", 0
                self.orders.append(Order("look", words.upper()))
            case "copy" | "rename" | "protect" if not entry.first:
                self.overlay.entry = Entry(entry.what, first=words)
            case "delete" | "copy" | "rename" | "protect":
                self.orders.append(Order(entry.what, entry.first or words, more=words))

    # ---- the display -------------------------------------------------------------------------------------------------------
    def lines(self) -> list[str]:
        """20 lines of 40 characters."""
        below = self._below()
        height = CONTENT - len(below)
        content = self._content(height)
        shown = [self._bar(), self._place(), *content[:height], *[""] * (height - len(content)), *below, *self._labels()]
        return [line[:COLUMNS].ljust(COLUMNS) for line in shown]

    def _bar(self) -> str:
        view = self.view
        share = min(max((view.position or view.override) / 100.0, 0.0), 1.0)
        return f"{view.position or view.override:6.2f} {'mm' if view.position else '% '} " + "█" * round(share * BAR)

    def _place(self) -> str:
        listing = self.listing
        mode = self.view.operating
        left = f"{listing.cursor:>4} S:/{listing.path}"
        return f"{left[: COLUMNS - len(mode) - 1]:<{COLUMNS - len(mode)}}{mode}"

    def _content(self, height: int) -> list[str]:
        halted = self.mode != "dir" and self._is_shown(self.view.program.upper()) and self.view.state not in ("running", "waiting")
        done = self.view.done if halted else 0
        if not self.overlay.window:
            return self.listing.shown(height, COLUMNS, done)
        rows = window(self.overlay.window, self.view, self.overlay.first, self.language)[:height]
        left = height - len(rows) - 1
        return [*(self.listing.shown(left, COLUMNS, done) if left > 0 else []), *(["─" * COLUMNS] if left >= 0 else []), *rows]

    def _below(self) -> list[str]:
        """Entry or sentence, then the status window; its last line has the mode (L1252)."""
        rows: list[str] = []
        if self.overlay.entry is not None:
            question = say(QUESTIONS[self.overlay.entry.asks], self.language)
            rows += [question, self.overlay.entry.shown(COLUMNS)]
        rows += textwrap.wrap(self.overlay.notice, COLUMNS)[:3]
        if self.overlay.status:
            view = self.view
            state = f"{view.program} {view.step} {view.state}" if view.program else ""
            state = state if view.synchronous else say("not synchronous", self.language)
            mode = "EXEC" if view.mode == "test5" else view.operating
            rows += ["─" * COLUMNS, *(textwrap.wrap(view.message, COLUMNS)[:2] or [""]), f"{mode:<8}{state}"]
        return rows

    def _labels(self) -> list[str]:
        menu, levels = self.menu, len(MENUS[self.mode])
        words = [[*item.label.split(" ", 1), ""][:2] for item in menu]
        ends = [("◀", "▶"), (f"{self.overlay.menu + 1}", f"{levels}")] if levels > 1 else [(" ", " "), (" ", " ")]
        rows = ["".join(f"{word[row][: CELL - 1]:<{CELL}}" for word in words) for row in (0, 1)]
        return [f"{ends[row][0]} {rows[row]:<{COLUMNS - 3}}{ends[row][1]}" for row in (0, 1)]


def _key(path: str) -> str:
    """Return the name of a program in the memory: without its kind."""
    return path.rpartition(".")[0].upper() if "." in path.rpartition("/")[2] else path.upper()


def _window_of(coor: int) -> str:
    """What is indicated during movement (L1313, L1326)."""
    return "pose" if coor in (1, 2) else "axes"
