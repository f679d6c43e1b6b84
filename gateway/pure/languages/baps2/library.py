"""The programs of a user memory: read and checked when first asked for."""

from collections.abc import Iterable, Sequence

from gateway.pure.languages.baps2.blocks import blocks
from gateway.pure.languages.baps2.commented import Commented
from gateway.pure.languages.baps2.expansion import expanded
from gateway.pure.languages.baps2.reader import read
from gateway.pure.languages.baps2.repair import Repair, repairs_of
from gateway.pure.languages.baps2.translation import Unit, check
from gateway.pure.languages.baps2.tree import Program
from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.collecting import uncollected
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import SourceFile, base_name
from gateway.pure.languages.base.store import ProgramStore


class _Noted:
    """The store, which notes what a program includes."""

    def __init__(self, store: ProgramStore, uses: set[str]) -> None:
        self._uses, self.names, self.age = uses, store.names, store.age
        self._text = store.text

    def text(self, name: str) -> str | None:
        """An included file."""
        self._uses.add(name.upper().partition(".")[0])
        return self._text(name)


class Library:
    """Programs by name, without extension and in any case."""

    def __init__(self, words: Words, store: ProgramStore, *, watched: bool = False) -> None:
        """`watched`: programs ask the debugger before each line."""
        self._words, self._store, self._watched = words, store, watched
        self._trees: dict[str, Program | None] = {}
        self._units: dict[str, tuple[Unit | None, Faults]] = {}
        self._uses: dict[str, set[str]] = {}  # program -> files and programs that it was read and checked with
        self._twin: Library | None = None

    def watched(self) -> "Library":
        """The same programs, which ask the debugger before each line."""
        if self._twin is None:
            self._twin = Library(self._words, self._store, watched=True)
        return self._twin

    def names(self) -> Iterable[str]:
        """All programs there are, also those with a translation alone."""
        files = list(self._store.names())
        return list(dict.fromkeys(name[:-4] for name in files if name.endswith((".QLL", ".IRD"))))

    def has(self, name: str) -> bool:
        """Whether there is a source."""
        return self._store.text(f"{name}.QLL") is not None

    def file_of(self, program: str) -> str:
        """Name of the source of a program without its ending: PROGRAM A may lie in B.QLL, its points in B.PKT (L668)."""
        if self.has(program):
            return program
        units = [*self._units.values(), *(self._twin._units.values() if self._twin is not None else ())]
        return next((unit.file for unit, _ in units if unit is not None and unit.name == program), program)

    def tree(self, name: str) -> Program | None:
        """The tree of a program, its faults left to its own check."""
        name = name.upper()
        if name not in self._trees:
            text = self._store.text(f"{name}.QLL")
            uses = self._uses.setdefault(name, set())
            self._trees[name] = None if text is None else self._read(SourceFile(f"{name}.QLL", text), Faults(), uses)
        return self._trees[name]

    def _read(self, source: SourceFile, faults: Faults, uses: set[str], repairs: Sequence[Repair] = ()) -> Program | None:
        for each in repairs:
            report = faults.apart if each.swap else faults.error
            report(each.id, each.position, each.text, each.hint)
        try:
            return read(source, self._words, _Noted(self._store, uses), faults, [each.apply for each in repairs])
        except RecursionError:
            faults.error("too-complex", source.at(1), f"{source.name} is nested too deeply")
            return None

    def check(self, file: str, text: str) -> tuple[Unit | None, Faults]:
        """Reads and checks one source; a file without PROGRAM that others include (only subroutines, for example), with these."""
        program, unit, faults = self.examined(file, text)
        if (program is None or program.external_subroutine) and (found := self._included(file)) is not None:
            return None, found
        return unit, faults

    def _included(self, file: str) -> Faults | None:
        """What the programs that include the file have in it; None: none does."""
        name, found, included = base_name(file), Faults(), False
        for other in self._store.names():
            text = self._store.text(other) or ""
            if other == name or not other.endswith(".QLL") or "INCLUDE" not in text.upper():
                continue
            uses = set[str]()
            program, _, faults = self._examined(other, text, uses)
            if program is None or name.partition(".")[0] not in uses:
                continue
            included = True
            for each in faults:
                if each.position.file == name:
                    found.add(each)
        return found if included else None

    def examined(self, file: str, text: str) -> tuple[Program | None, Unit | None, Faults]:
        """Reads and checks one source; its tree too, also where it has errors."""
        return self._examined(file, text, set())

    def _examined(self, file: str, text: str, uses: set[str]) -> tuple[Program | None, Unit | None, Faults]:
        source = SourceFile(file, text)
        with uncollected():
            found = self._checked(source, uses)
            if found[2].errors > 1:
                found = self._repaired(source, uses, found)
        return found

    def _checked(self, source: SourceFile, uses: set[str], repairs: Sequence[Repair] = ()) -> tuple[Program | None, Unit | None, Faults]:
        def other(name: str) -> Program | None:
            uses.add(name.upper())
            return self.tree(name)

        faults = Faults()
        program = self._read(source, faults, uses, repairs)
        if program is None:
            return None, None, faults
        unit = check(program, faults, other)
        faults.alone_in_line("text-without-end")
        return program, (unit if not faults.errors else None), faults

    def _repaired(
        self, source: SourceFile, uses: set[str], found: tuple[Program | None, Unit | None, Faults]
    ) -> tuple[Program | None, Unit | None, Faults]:
        """Return the same with the missing parts inserted, if it has fewer faults."""
        results: dict[tuple[Repair, ...], tuple[Program | None, Unit | None, Faults]] = {(): found}

        def trial(repairs: Sequence[Repair]) -> Faults:
            key = tuple(repairs)
            if key not in results:
                results[key] = self._checked(source, uses, key)
            return results[key][2]

        tokens, rows = expanded(source, self._words, self._store, Faults())
        return results[repairs_of(tokens, trial, (blocks, Commented(rows, self._words)))]

    def unit(self, name: str) -> tuple[Unit | None, Faults]:
        """Return a program that can run, or None with its faults; None without faults means that the source is missing."""
        name = name.upper()
        if name not in self._units:
            text = self._store.text(f"{name}.QLL")
            if text is None:
                unit, faults = None, self._without_source(name)
            else:
                _, unit, faults = self._examined(f"{name}.QLL", text, self._uses.setdefault(name, set()))
            if unit is not None:
                unit.file = name
            self._units[name] = (unit if unit is not None and unit.load(faults, watched=self._watched) else None), faults
        return self._units[name]

    def _without_source(self, name: str) -> Faults:
        faults = Faults()
        if self._store.text(f"{name}.IRD") is not None:
            place = SourceFile(f"{name}.IRD", "").at(1)
            faults.error("no-source", place, f"{name}.IRD is a translation; axisgate runs sources", f"put {name}.QLL into its folder")
        return faults

    def forget(self, name: str) -> None:
        """A source was replaced, added or deleted: it is read again, and so is what includes it or refers to it."""
        gone, more = {name.upper()}, {name.upper()}
        while more:
            more = {user for user, used in self._uses.items() if used & more} - gone
            gone |= more
        for each in gone:
            self._trees.pop(each, None)
            self._units.pop(each, None)
            self._uses.pop(each, None)
        if self._twin is not None:
            self._twin.forget(name)
