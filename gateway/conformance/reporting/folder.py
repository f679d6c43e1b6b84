"""The report folder: page, JSON, JUnit, traces, and a list of check sums by which any changed byte is found; two reports compared."""

import hashlib
import json
import pathlib
from collections.abc import Collection, Mapping, Sequence

from gateway.conformance.framework.result import Result
from gateway.conformance.reporting.document import FORMAT, KIND, Json, cases_of, checksum, trace
from gateway.conformance.reporting.junit import to_junit
from gateway.conformance.reporting.page import to_html
from gateway.pure.lines.pcapng import can_pcapng, pcapng
from gateway.pure.lines.turns import Kind, Turn
from protocols.base.machine import Frame

SUMS = "SHA256SUMS"
JSON, PAGE, JUNIT = "report.json", "report.html", "junit.xml"
WORSE = {verdict: weight for weight, verdict in enumerate(("N/A", "PASS", "WARN", "INCONC", "FAIL", "ERROR"))}


class BadReport(Exception):
    """Fault of a report, in one sentence."""


def write_folder(folder: pathlib.Path, found: Json, results: Sequence[Result], language: str) -> list[pathlib.Path]:
    """All files; OSError where the disk is full or the folder cannot be written."""
    traces = folder / "traces"
    traces.mkdir(parents=True, exist_ok=True)
    files: dict[pathlib.Path, bytes] = {
        folder / JSON: (json.dumps(found, indent=1, ensure_ascii=False) + "\n").encode(),
        folder / PAGE: to_html(found, language).encode(),
        folder / JUNIT: to_junit(found).encode(),
    }
    for result in results:
        if result.notes.trace:
            files[traces / f"{result.purpose.id}.txt"] = _text(result).encode()
            files[traces / f"{result.purpose.id}.pcapng"] = _capture(result)
    sums = "".join(f"{hashlib.sha256(content).hexdigest()}  {path.relative_to(folder).as_posix()}\n" for path, content in files.items())
    _forget(folder, files)
    for path, content in (*files.items(), (folder / SUMS, sums.encode())):
        _written(path, content)
    return list(files)


def _forget(folder: pathlib.Path, files: Collection[pathlib.Path]) -> None:
    """The list of an earlier report in this folder goes, and its traces that this report lacks: `verify` would call them added."""
    (folder / SUMS).unlink(missing_ok=True)
    for path in (folder / "traces").iterdir():
        if path.suffix in (".txt", ".pcapng") and path not in files:
            path.unlink()


def _written(path: pathlib.Path, content: bytes) -> None:
    """Write completely or not at all: half a report would look like one."""
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(content)
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise


def _capture(result: Result) -> bytes:
    """Runs of one side as packets; the dissector of configs/wireshark shows them as characters."""
    frames = [one for one in result.notes.trace if one.identifier is not None]
    if frames:
        return can_pcapng((Frame(one.identifier or 0, one.data, one.ns) for one in frames), "conformance")
    turns: list[Turn] = []
    for one in result.notes.trace:
        side = "A" if one.side == "tester" else "B"
        if not turns or turns[-1].side != side:
            turns.append(Turn(one.ns, one.ns, side, Kind.STRAY, bytearray()))
        turns[-1].data += one.data
        turns[-1].last_ns = one.ns
        if one.note:
            turns[-1].remarks.append(one.note)
    return pcapng(turns, "conformance", f"{result.purpose.id} {result.verdict.value}: A is the tester, B the device")


def _text(result: Result) -> str:
    lines = [f"# {result.purpose.id} {result.verdict.value} {result.reason}", f"# {trace(result)}"]
    lines += [f"{one.ns / 1e6:14.3f} ms {one.side:7} {one.note or one.shown()}" for one in result.notes.trace]
    return "\n".join(lines) + "\n"


def _reason(error: OSError | UnicodeDecodeError) -> str:
    return (error.strerror or str(error)) if isinstance(error, OSError) else "no text"


def verify(folder: pathlib.Path) -> list[str]:
    """Every changed, missing or added file; [] where nothing is."""
    try:
        rows = (folder / SUMS).read_bytes().decode("utf-8").split("\n")  # a line ends with LF alone: another end is a changed byte
    except (OSError, UnicodeDecodeError) as error:
        raise BadReport(f"{folder / SUMS}: cannot be read ({_reason(error)}); is this the folder of --report?") from error
    faults, listed = [], {SUMS}
    if rows.pop():
        faults.append(f"{SUMS}: its last line does not end")
    for number, row in enumerate(rows, 1):
        digest, space, name = row.partition("  ")
        if not space or len(digest) != 64:
            faults.append(f"{SUMS}: line {number} is not a checksum")
            continue
        listed.add(name)
        if ".." in pathlib.PurePosixPath(name).parts or pathlib.PurePosixPath(name).is_absolute():
            faults.append(f"{SUMS}: line {number} names a file outside the folder")
            continue
        try:
            content = (folder / name).read_bytes()
        except OSError:
            faults.append(f"{name}: is missing")
            continue
        if hashlib.sha256(content).hexdigest() != digest:
            faults.append(f"{name}: was changed")
    faults += [
        f"{path.relative_to(folder).as_posix()}: was added"
        for path in sorted(folder.rglob("*"))
        if (path.is_file() or path.is_symlink()) and path.relative_to(folder).as_posix() not in listed
    ]
    for name in (JSON, PAGE, JUNIT):
        if name not in listed:
            faults.append(f"{name}: is not in {SUMS}")
    return faults + _own_sum(folder)


def _own_sum(folder: pathlib.Path) -> list[str]:
    """The checksum inside the document: it is also on page 1, so a regenerated list is detected."""
    try:
        found = load(folder)
        page = (folder / PAGE).read_text(encoding="utf-8")
    except (BadReport, OSError, UnicodeDecodeError) as error:
        return [str(error)]
    faults = [] if checksum(found) == found.get("sha256") else [f"{JSON}: its own check sum does not fit its content"]
    return faults if str(found.get("sha256")) in page else [*faults, f"{PAGE}: shows another check sum than {JSON}"]


def load(path: pathlib.Path) -> Json:
    """Load a report by its folder or file; BadReport names the reason if it is not a report."""
    file = path / JSON if path.is_dir() else path
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadReport(f"{file}: cannot be read ({error.strerror or error})") from error
    except (ValueError, RecursionError) as error:
        raise BadReport(f"{file}: is not JSON ({error})") from error
    if not isinstance(found, dict) or found.get("kind") != KIND or not isinstance(found.get("cases"), list):
        raise BadReport(f"{file}: is not a report of axisgate conformance")
    if found.get("format") != FORMAT:
        raise BadReport(f"{file}: format {FORMAT} expected, found {found.get('format')}; read it with the axisgate that wrote it")
    for at, case in enumerate(found["cases"]):
        if not isinstance(case, dict) or not isinstance(case.get("id"), str) or case.get("verdict") not in WORSE:
            raise BadReport(f"{file}: cases[{at}]: a case with id and verdict ({', '.join(WORSE)}) expected")
    return found


def suite_of(found: Mapping[str, object]) -> str:
    """The name of the suite that a report is of."""
    suite = found.get("suite")
    return str(suite.get("name", "?")) if isinstance(suite, dict) else "?"


def version_of(found: Mapping[str, object]) -> str:
    """The version of the suite that a report is of."""
    suite = found.get("suite")
    return str(suite.get("version", "?")) if isinstance(suite, dict) else "?"


def compare(old: Mapping[str, object], new: Mapping[str, object]) -> list[tuple[str, str, str]]:
    """Cases whose verdict differs: id, before, now ("-": is not there)."""
    before = {str(case["id"]): str(case["verdict"]) for case in cases_of(old)}
    now = {str(case["id"]): str(case["verdict"]) for case in cases_of(new)}
    return [(name, before.get(name, "-"), now.get(name, "-")) for name in {**before, **now} if before.get(name) != now.get(name)]


def is_worse(before: str, now: str) -> bool:
    return WORSE.get(now, 0) > max(WORSE.get(before, 0), WORSE["PASS"])
