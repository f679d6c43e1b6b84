"""The text form of programs, written: what motion.program.text.reader reads back to the same program.

Numbers to 1e-12 of their size, orientations to 1e-9 rad.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import fields

from motion.errors import MotionError
from motion.geometry.conventions import Convention, convention
from motion.geometry.frames import Pose
from motion.geometry.units import from_si
from motion.kinematics.base import FREE, Configuration
from motion.program.blocks import (
    MEASURED,
    Act,
    Alteration,
    BeltCall,
    Blend,
    Block,
    Frame,
    JointTarget,
    MachinePoint,
    Program,
    Shift,
    Synchron,
    Tool,
)
from motion.program.text import alter as textalter
from motion.program.text import files as textfiles
from motion.program.text import keys as textkeys
from motion.program.text.inputs import called
from motion.program.text.systems import chosen, declared
from motion.program.text.values import CALLED
from motion.rho3.wc import WcFrame


def write(program: Program, angles: str = "val3") -> str:
    """The text of a program; raises MotionError where one name is used for two tools or frames, or a place has none."""
    ways = convention(angles)
    units = program.units or ("deg",) * len(program.start)
    lines = [f"program {program.name}" if program.name else "", f"robot {program.robot}" if program.robot else ""]
    lines += heading(program.start, units, angles)
    references = [block.alteration.reference for block in program.blocks if block.alteration is not None]
    lines += places_of(program.blocks, ways, references)
    lines += declared([*(block.system for block in program.blocks), program.system])
    lines += _moves(program, ways, units)
    return "\n".join(line for line in lines if line) + "\n"


def heading(start: tuple[float, ...], units: tuple[str, ...], angles: str) -> list[str]:
    """Return the statements about the axes of a robot."""
    units = units or ("deg",) * len(start)
    return [f"angles {angles}", f"axes {' '.join(units)}", f"start {_joints(start, units)}"]


def places_of(blocks: Sequence[Block], ways: Convention, references: Sequence[Tool | Frame] = ()) -> list[str]:
    """Lines of the tools and frames that blocks name."""
    tools = _places([*(block.tool for block in blocks), *(each for each in references if isinstance(each, Tool))])
    frames = _places([*(block.frame for block in blocks), *(each for each in references if isinstance(each, Frame))])
    found = [("tool", *each) for each in tools.items()] + [("frame", *each) for each in frames.items()]
    return [f"{word} {name} {_pose(pose, ways)}" for word, name, pose in found]


def _moves(program: Program, ways: Convention, units: tuple[str, ...]) -> list[str]:
    """Return one line per block and the lines before it; belt values as mm, whatever the belt's unit."""
    lines: list[str] = []
    blocks: Sequence[Block] = program.blocks
    part: Synchron | None = None
    altered: Alteration | None = None
    files: dict[str, int] = {}
    system: WcFrame | None = None
    ahead = 0
    for block in blocks:
        if block.ahead != ahead:
            ahead = block.ahead
            lines.append(f"block_search {ahead or '-'}")
        if block.system != system:
            lines.append(chosen(block.system))
            system = block.system
        ends, begin = parted(part, altered, block)
        part, altered = block.synchron, block.alteration
        lines += ends
        lines += [f"label {block.label}"] if block.label else []
        lines += [acted(each, units) for each in block.acts if not each.inside]
        lines += [*begin, *(acted(each, units) for each in block.acts if each.inside)]
        lines += [called(each) for each in block.functions]
        lines += [written_move(block, ways, units)] if block.file is None else textfiles.written(block.file, files)
    asked = {block.goes_on_at for block in blocks}
    named = asked - {block.label for block in blocks} - {""}
    if program.acts and part is not None:
        lines.append("synchron_end")
    lines += [chosen(program.system)] if program.system != system else []
    return [*lines, *(f"label {name}" for name in sorted(named)), *(acted(each, units) for each in program.acts)]


def parted(part: Synchron | None, altered: Alteration | None, block: Block) -> tuple[list[str], list[str]]:
    """Lines that end the parts before a block, and those that begin its own."""
    ends, begin = [], []
    if block.synchron != part:
        ends += ["synchron_end"] if part is not None else []
        now = block.synchron
        at = f" at={_plain(now.at * 1e3)}mm" if now is not None and now.at is not None else ""
        begin += [f"synchron {now.belt}{at}"] if now is not None else []
    if block.alteration != altered:
        ends += ["alter_end"] if altered is not None else []
        begin += [textalter.written(block.alteration)] if block.alteration is not None else []
    return ends, begin


def _places(places: Iterable[Tool | Frame]) -> dict[str, Pose]:
    found: dict[str, Pose] = {}
    for place in places:
        if place.name:
            if found.setdefault(place.name, place.pose) != place.pose:
                raise MotionError(f"{place.name!r} names two places in one program")
        elif place.pose != Tool().pose:
            raise MotionError("a tool or frame without a name cannot be written")
    return found


def written_move(block: Block, ways: Convention, units: tuple[str, ...]) -> str:
    """Return kind, target and keys of a block, without the lines before it."""
    words = [block.kind.value]
    if block.via is not None:
        words += ["via", f"pose {_pose(block.via.pose, ways)}", "to"]
    target = block.target
    keys = _keys(block, units)
    if block.shift is not None:
        words.append(_shift(block.shift, ways, units))
        keys += _extra(block.shift.extra, units)
    elif block.recorded:
        words.append(f"recorded {block.recorded}")
    elif target == MEASURED:
        words.append("mpos")
    elif isinstance(target, JointTarget):
        words.append(f"joints {_joints(target.q, units)}")
    else:
        words.append(f"pose {_pose(target.pose, ways)}")
        flags = target.configuration
        if flags != FREE:
            keys.append(f"config={','.join(str(getattr(flags, f.name).value) for f in fields(Configuration))}")
        keys += _extra(target.extra, units)
    return " ".join([*words, *keys])


def _extra(values: tuple[float, ...], units: tuple[str, ...]) -> list[str]:
    own = units[len(units) - len(values) :]
    return [f"extra={','.join(_plain(from_si(v, unit)) + unit for v, unit in zip(values, own, strict=True))}"] if values else []


def _shift(shift: Shift, ways: Convention, units: tuple[str, ...]) -> str:
    if shift.angles is None:
        return f"rel joints {_joints(shift.values, units)}"
    if shift.angles != ways:
        raise MotionError(f"a relative pose in angles of the {shift.angles.control} cannot be written in those of the {ways.control}")
    return f"rel pose {_joints(shift.values, ('mm',) * 3 + ('deg',) * 3)}"


def acted(act: Act, units: tuple[str, ...]) -> str:
    """Belt values as mm, whatever the belt's unit."""
    if isinstance(act, MachinePoint):
        return f"mach_pos joints {_joints(act.q, units)}"
    if isinstance(act, BeltCall):
        return " ".join([CALLED[act.function], *map(_plain, (act.belt, *act.values))])
    if act.input is not None:
        return f"sync {act.belt} input={'' if act.level else '!'}{act.input}"
    return f"sync {act.belt} {'>=' if act.at_least else '<='} {_plain(act.limit * 1e3)}mm"


def _keys(block: Block, units: tuple[str, ...]) -> list[str]:
    found = []
    plain = Block(block.kind, block.target)
    for key in textkeys.KEYS:
        value = getattr(textkeys.part_of(block, key.part), key.field)
        if value is not None and value != getattr(textkeys.part_of(plain, key.part), key.field):
            found.append(f"{key.name}={_plain(value / key.si)}")
    for choice in textkeys.CHOICES:
        word = getattr(textkeys.part_of(block, choice.part), choice.field)
        if word is not getattr(textkeys.part_of(plain, choice.part), choice.field) or (choice.name == "blend" and block.blend != Blend()):
            found.append(f"{choice.name}={word.value}")
    if block.blend.axes:
        found.append(f"zone={','.join(_plain(from_si(v, unit)) for v, unit in zip(block.blend.axes, units, strict=True))}")
    if block.blend.past_circles:
        found.append("arcs=yes")
    if block.pace.lead:
        found.append("lead=yes")
    found += [f"{word}={place.name}" for word, place in (("tool", block.tool), ("frame", block.frame)) if place.name]
    for name, corner in (("limitmin", block.lowest), ("limitmax", block.highest)):
        if corner is not None:
            found.append(f"{name}={','.join(_plain(value * 1e3) for value in corner)}")
    if block.outputs:
        outs = (f"{o.number}:{_plain(o.value)}{f'@{_plain(o.before * 1e3)}' if o.before else ''}" for o in block.outputs)
        found.append(f"out={','.join(outs)}")
    if block.on_belt is not None:
        named = zip(("belt", "camin", "camout"), (block.on_belt.value, block.on_belt.first, block.on_belt.third), strict=True)
        found += [f"{name}={_plain(value * 1e3)}mm" for name, value in named if value or name == "belt"]
    found += ["freeze=yes"] if block.freeze else []
    if block.until is not None:
        until = block.until
        found.append(f"until={'' if until.value else '!'}{f'ch{until.channel}' if until.channel else until.number}")
        found += [] if until.within is None else [f"within={_plain(until.within)}"]
        found += [f"error={until.error}"] if until.error else []
    found += [f"error={block.otherwise}"] if block.otherwise else []
    if block.wait is not None:
        wait = block.wait
        found.append(f"wait={'' if wait.value else '!'}{f'ch{wait.channel}' if wait.channel else wait.number}")
        found += [f"delay={_plain(wait.delay)}"] if wait.delay else []
    return found


def _joints(values: tuple[float, ...], units: tuple[str, ...]) -> str:
    return " ".join(_plain(from_si(value, unit)) for value, unit in zip(values, units, strict=True))


def _pose(pose: Pose, ways: Convention) -> str:
    return " ".join(_plain(value) for value in ways.values(pose))


def _plain(value: float) -> str:
    """Thirteen digits, without the dust of unit conversion."""
    rounded = float(f"{value:.13g}")
    if rounded == 0.0 or math.isclose(rounded, 0.0, abs_tol=1e-13):
        return "0"
    return str(int(rounded)) if rounded.is_integer() and abs(rounded) < 1e12 else repr(rounded)
