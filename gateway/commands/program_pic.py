"""axisgate program trace of a PIC program: scanned in virtual time, with inputs set at their times."""

import json
import pathlib
import tomllib
from collections.abc import Callable

from gateway.files.find import read_text
from gateway.files.program_memory import folder_memory
from gateway.files.signal_lists import signal_list
from gateway.pure.controllers.rho3.signals.timers import TimersAndCounters
from gateway.pure.image.addresses import Direction, RcBit
from gateway.pure.image.signals import SignalList
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.pic.cell_pic import read_pic
from gateway.pure.languages.pic.symbols import Area, Bit, Symbols, named_in, symbols_of
from gateway.pure.languages.pic.virtual import PicFeedFault, VirtualPic, pic_feed_of


class PicTraceFault(Exception):
    """It cannot run.  faults: of its source; without them the sentence is the reason."""

    def __init__(self, text: str, faults: Faults | None = None) -> None:
        super().__init__(text)
        self.faults = faults


def pic_trace(folder: pathlib.Path, name: str, feed: pathlib.Path | None) -> VirtualPic:
    """A program NAME.QLS of the folder after its run.  PicTraceFault, OSError."""
    memory, listed, faults = folder_memory(folder), signal_list(), Faults()
    program = read_pic(memory, name, named_in(listed), faults)
    if program is None:
        raise PicTraceFault(f"{name}.QLS has errors and does not run", faults)
    symbols = symbols_of(memory.text(f"{name}.SYM") or "", f"{name}.SYM", named_in(listed), Faults())
    try:
        given = pic_feed_of(tomllib.loads(read_text(feed)) if feed else {}, symbols, program)
        timers = TimersAndCounters(given.p3, given.timers, given.counters, given.period)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise PicTraceFault(f"{feed}: no TOML: {error}") from error
    except PicFeedFault as error:
        raise PicTraceFault(f"{feed}: {error}") from error
    run = VirtualPic(name, program, timers, given, _named(symbols, listed))
    run.run()
    return run


def _named(symbols: Symbols, listed: SignalList) -> Callable[[Bit], str]:
    """Own symbols, then signals of the interface."""
    own = {place: name for name, place in reversed(list(symbols.own.items()))}

    def named(place: Bit) -> str:
        if place in own:
            return own[place]
        if place.area is Area.FLAG:
            return ""
        way = Direction.OUTPUT if place.area is Area.INPUT else Direction.INPUT
        found = listed.at(RcBit(way, 8 * place.byte + place.bit))
        return "" if found is None else found.name

    return named


def event_line(event: dict[str, object], as_json: bool) -> str:
    """For a program, or for people."""
    if as_json:
        return json.dumps(event)
    what = f"{event['channel']} = {event['value']} {event.get('name', '')}" if "channel" in event else f"{event['code']} {event['text']}"
    return f"{event['t']:>10} {event['process']} {event['event']:<5} {what}".rstrip()
