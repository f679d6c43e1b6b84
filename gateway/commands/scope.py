"""Record any values at the rate of the cycle with a trigger; reopen, export, draw."""

import argparse
import contextlib
import json
import pathlib
import sys
from collections.abc import Iterator

from gateway.assembly.run import slug_of
from gateway.pure.cell.cell import Cell
from gateway.pure.scope.channels import ChannelError, all_names
from gateway.pure.scope.trigger import Capture, TriggerError
from gateway.scope.live import ScopeError, attached, capture, facts_of, named_channels, named_trigger, recording_of
from gateway.scope.plots import at_cursors, page, picture
from gateway.scope.recording import Recording, RecordingError, export, save
from gateway.scope.recording import load as reopen
from gateway.tools.cell_argument import load
from gateway.tools.client import ToolError, simulated
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate scope record demo --channels axis.A1.set,axis.A1.actual,axis.A1.lag --for 5 -o move.scope
  axisgate scope record cell.toml --channels axis.A1.lag,CTRL_ALLOW_RCI --trigger "axis.A1.lag > 2.0" --pre 0.5 --for 2 -o trip.scope
  axisgate scope plot move.scope -o move.png --cursor 0.5 --cursor 1.25      also .html; --xy axis.A1.actual axis.A2.actual
  axisgate scope export move.scope -o move.mf4                               also .csv
  axisgate scope channels demo                                               what can be recorded
Ctrl-C ends a recording early and keeps what was recorded.
exit code: 0 done, 1 nothing triggered or the cycle no longer ran, 2 unknown channel, trigger or file, 3 no such run"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate scope", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    tools = parser.add_subparsers(dest="tool", required=True, metavar="TOOL")
    _record_options(tools.add_parser("record", help="from a running cell into a file"))
    names = tools.add_parser("channels", help="names of channels of a cell")
    names.add_argument("cell", metavar="CELL")
    names.add_argument("--json", action="store_true")
    for tool, text in (("plot", "a recording as .html or .png"), ("export", "a recording as .csv or .mf4")):
        made = tools.add_parser(tool, help=text)
        made.add_argument("file", metavar="FILE", type=pathlib.Path)
        made.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar="FILE")
        if tool == "plot":
            made.add_argument(
                "--cursor", type=float, action="append", default=[], metavar="S", help="values at this time; two give their difference"
            )
            made.add_argument("--xy", nargs=2, metavar=("X", "Y"), help="one channel over another")
            made.add_argument("--json", action="store_true", help="values at the cursors as JSON")
    options = parser.parse_args(argv)
    try:
        return {"record": _record, "channels": _channels, "plot": _plot, "export": _export}[options.tool](options)
    except (ChannelError, TriggerError, RecordingError) as error:
        return _said(error, USAGE)
    except (ScopeError, ToolError) as error:
        return _said(error, ENVIRONMENT)
    except OSError as error:
        return _said(f"{error.filename}: {error.strerror}", ENVIRONMENT)


def _record_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
    parser.add_argument("--channels", required=True, metavar="A,B,..", help="axisgate scope channels CELL lists them")
    parser.add_argument("--for", dest="seconds", type=float, default=10.0, metavar="S", help="from the trigger on (default 10)")
    parser.add_argument("--trigger", default="", metavar="WORDS", help='"NAME > LEVEL", "NAME rises", "error"; none: at once')
    parser.add_argument("--pre", type=float, default=0.0, metavar="S", help="kept from before the trigger")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar="FILE")
    parser.add_argument("--sim", action="store_true", help="run the cell under simulation for this")
    parser.add_argument("--name", help="name of the run, if it differs from the file")
    parser.add_argument("--json", action="store_true", help="what was kept as JSON")


def _said(error: object, code: int) -> int:
    complain("scope", error)
    return code


def _record(options: argparse.Namespace) -> int:
    cell = load(options.cell)
    if isinstance(cell, int):
        return cell
    if not 0.0 < options.seconds <= 86_400 or not 0.0 <= options.pre <= 60.0:
        return _said(f"--for {options.seconds:g}, --pre {options.pre:g}: up to 86400 s, and 0 to 60 s before the trigger", USAGE)
    channels = named_channels([name.strip() for name in options.channels.split(",") if name.strip()], cell)
    trigger = named_trigger(options.trigger, cell)
    with _run(options, cell) as run, attached(run) as ring, _interruptible() as pressed:
        period = _period(cell, run)
        progress = _progress(options.seconds)
        kept = capture(
            ring, channels, seconds=options.seconds, pre_s=options.pre, period_s=period, trigger=trigger, stop=pressed, said=progress
        )
    recording = recording_of(kept, channels, cell, period, options.trigger)
    if kept.triggered_at is None:
        return _said(f"{options.trigger!r} was never true; nothing was recorded", FINDING)
    save(recording, options.output)
    found = {"file": str(options.output), "records": len(recording.time), "lost": recording.lost, "channels": list(recording.names)}
    sentence = f"{options.output}: {len(recording.time)} records of {len(channels)} channels, {recording.lost} lost"
    print(json.dumps(found) if options.json else f"{sentence}.  next: axisgate scope plot {options.output} -o {options.output.stem}.html")
    return DONE


@contextlib.contextmanager
def _run(options: argparse.Namespace, cell: Cell) -> Iterator[str]:
    if options.sim:
        with simulated(options.cell) as (client, _):
            yield client.run
    else:
        yield options.name or slug_of(cell)


def _period(cell: Cell, run: str) -> float:
    """Period of the run, which may have been started with another clock than the cell's."""
    from gateway.runtime.supervisor_client import ask

    with ask(run, "status") as connection:
        status = json.loads(connection.makefile().readline())
    return float(status.get("p5_ms", cell.cycle_ms)) / 1000.0


@contextlib.contextmanager
def _interruptible() -> Iterator["Pressed"]:
    import signal

    pressed = Pressed()
    before = signal.signal(signal.SIGINT, lambda number, frame: setattr(pressed, "set", True))
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, before)


class Pressed:
    """Whether Ctrl-C came."""

    def __init__(self) -> None:
        self.set = False

    def __call__(self) -> bool:
        return self.set


def _progress(seconds: float) -> "Progress":
    return Progress(seconds) if sys.stderr.isatty() else Progress(0.0)


class Progress:
    """One line on a terminal, none in a pipe."""

    def __init__(self, seconds: float) -> None:
        self._seconds, self._shown = seconds, -1

    def __call__(self, kept: Capture) -> None:
        if not self._seconds:
            return
        share = len(kept.rows) if kept.triggered_at is not None else 0
        if share // 100 != self._shown:
            self._shown = share // 100
            words = f"{share} records" if kept.triggered_at is not None else "waiting for the trigger"
            print(f"\r{words:40}", end="", file=sys.stderr, flush=True)


def _channels(options: argparse.Namespace) -> int:
    cell = load(options.cell)
    if isinstance(cell, int):
        return cell
    names = all_names(facts_of(cell))
    print(
        json.dumps(names)
        if options.json
        else "\n".join([*names, "rc_in.0 .. rc_in.1023, rc_out.0 .. rc_out.1023, or the name of a signal"])
    )
    return DONE


def _plot(options: argparse.Namespace) -> int:
    recording = reopen(options.file)
    xy = (options.xy[0], options.xy[1]) if options.xy else None
    rows = at_cursors(recording, options.cursor)
    suffix = options.output.suffix.lower()
    if suffix == ".png":
        picture(recording, options.output, options.cursor, xy)
    elif suffix == ".html":
        options.output.write_text(page(recording, options.cursor, xy), encoding="utf-8")
    else:
        raise RecordingError(f"{options.output}: .html or .png is drawn")
    _report(recording, options, rows)
    return DONE


def _report(recording: Recording, options: argparse.Namespace, rows: list[list[float]]) -> None:
    if options.json:
        cursors = [dict(zip(["t", *recording.names], row, strict=True)) for row in rows]
        print(json.dumps({"file": str(options.output), "cursors": cursors}))
        return
    print(f"{options.output} written")
    for row in rows:
        values = ", ".join(
            f"{name} {value:.6g} {unit}".rstrip() for name, unit, value in zip(recording.names, recording.units, row[1:], strict=True)
        )
        print(f"  {row[0]:.4f} s: {values}")


def _export(options: argparse.Namespace) -> int:
    export(reopen(options.file), options.output)
    print(f"{options.output} written")
    return DONE
