"""A commented cell file from a few answers: it passes `check` and plays under `run --sim` as it is.

Nothing in it moves a real drive: `target` is "simulation" until its owner has filled [safety] and set "machine".
"""

from collections.abc import Mapping

from gateway.tools.new_cell.axes import axes_text, blocks_of_axes

REPLACES = {
    "s5-rk512": "positioning behind a communication processor",
    "rho3": "rho3.1",
    "reis": "ROBOTstar V",
    "modbus": "positioning of an older PLC",
}


def cell_text(kind: str, answers: Mapping[str, str], language: str = "en") -> str:
    """The complete file; `answers` as gateway.tools.new_cell.questions checked them."""
    count = int(answers["axes"])
    parts = [_head(kind, answers, language), _safety(kind)]
    if kind == "reis":
        parts.append(REIS)
    if "port" in answers:
        parts += [_line(kind, answers), _blocks(int(answers.get("db", "10")), count)]
    if "bind" in answers:
        parts.append(_modbus(kind, answers))
    family = answers.get("drives", "servodyn" if kind == "rho3" else "cia402")
    parts += [_bus(family, count), axes_text(family, count)]
    return "\n".join(parts)


def _head(kind: str, answers: Mapping[str, str], language: str) -> str:
    software = (
        f'software = "{answers["software"]}"               # decides numbers that changed between versions\n'
        if "software" in answers
        else ""
    )
    return f"""\
# Written by `axisgate new --from {kind}`.  Next: axisgate check FILE, then axisgate run FILE --sim
# Every number below is an example until it was checked on the machine.
format = 1

[cell]
name     = "{answers["name"]}"
replaces = "{REPLACES[kind]}"
{software}language = "{language}"                  # texts for operator and PLC: de | en
target   = "simulation"          # "machine" when [safety] is filled and the drives are real
"""


def _safety(kind: str) -> str:
    """The fields a machine needs; empty ones are refused by `run` on target "machine"."""
    source = "plc" if kind != "modbus" else "plc2"
    return f"""\
# ---- what the plant guarantees in hardware; `run` on target "machine" refuses to start while one is empty ----
# [safety]
# emergency_stop  = ""           # which relay, what it cuts
# sto_wired       = true
# guard           = ""
# limit_switches  = ""
# risk_assessment = ""           # your document; axisgate only prints it
# last_stop_test  = 2026-01-01   # written by `axisgate drive loss-test`

# Byte 3 of the RC inputs: emergency-stop chain closed, control allow, feed allow, feed hold not, travel allow.
# No contact is wired here yet, so they are taken as 1; name an owner or an [[io]] contact before real axes move.
[rc_inputs]
owner  = {{ "3" = "{source}" }}
assume = ["EMSTOP_OK_RCI", "CTRL_ALLOW_RCI", "FEED_ALLOW_RCI", "FEED_HOLD_N_RCI", "TRAVEL_ALLOW_RCI"]
"""


REIS = """\
# ---- the signals of the old controller: 40 bytes of _IBIN_IN and _IBIN_OUT, markers M0 .. M2047 ----
[controller]
kind = "reis"
command_source = "plc"           # markers command for this command source
"""


def _line(kind: str, answers: Mapping[str, str]) -> str:
    profile = answers.get("profile", "rho3" if kind == "rho3" else "siemens-cp525")
    return f"""\
# ---- the serial line to the PLC ----
[[line]]
name     = "plc"
port     = "{answers["port"]}"   # "sim" is a simulated cable at character time
format   = "9600 8E1"
protocol = "3964R"
profile  = "{profile}"           # times and attempts; axisgate explain QVZ
priority = "low"                 # the old processor is usually high
layer    = "rk512"
role     = "passive"             # the PLC sends and fetches

[line.supervision]               # independent of QVZ x attempts
max_silence_ms = 1000
life_word      = "DB{answers.get("db", "10")}.DW31"      # counts up in every SEND of the PLC
on_loss        = "stop_on_path"  # hold | finish_move | stop_on_path | quick_stop
restart        = "new_command"   # nothing moves on its own when the link returns
"""


def _blocks(commands: int, count: int) -> str:
    status = commands + 1
    targets, actuals = blocks_of_axes(count)
    return f"""\
# ---- data blocks in STEP 5 words; every entry names its type: bit KF(16) DH(32) KH KG(S5 float) REAL(IEEE) ... ----
[[db]]
number  = {commands}
comment = "commands, PLC -> axes"
words   = 32
writer  = "plc"
line    = "plc"
entries = [
  {{ at = "D 0.0",  type = "bit", to = "drives.on" }},                            # rising: asks for control, then drives on
  {{ at = "D 0.2",  type = "bit", to = "cell.reset",       edge = "rising" }},
  {{ at = "D 0.3",  type = "bit", to = "axis.*.reference", edge = "rising" }},
  {{ at = "D 0.4",  type = "bit", to = "cell.stop",        edge = "rising" }},    # on the path
  {{ at = "D 0.5",  type = "bit", to = "cell.resume",      edge = "rising" }},
  {{ at = "D 0.8",  type = "bit", to = "move.start" }},
  {{ at = "DR 1",   type = "KH",  to = "cell.override",    unit = "1 %", min = 0, max = 100 }},
{targets}
  {{ at = "DW 8",   type = "KF",  to = "move.speed",       unit = "1 %", min = 1, max = 100 }},
  {{ at = "DW 31",  type = "KF",  to = "line.plc.life" }},
]

[[db]]
number  = {status}
comment = "status, axes -> PLC"
words   = 32
writer  = "axisgate"
line    = "plc"
entries = [
  {{ at = "D 0.0",  type = "bit", from = "cell.ready" }},
  {{ at = "D 0.1",  type = "bit", from = "axis.*.referenced" }},
  {{ at = "D 0.2",  type = "bit", from = "axis.*.in_position" }},
  {{ at = "D 0.3",  type = "bit", from = "cell.drives_on" }},
  {{ at = "D 0.4",  type = "bit", from = "cell.control" }},                       # this command source owns the kinematic
  {{ at = "D 0.8",  type = "bit", from = "move.busy" }},
  {{ at = "D 0.9",  type = "bit", from = "move.done" }},
  {{ at = "D 0.15", type = "bit", from = "cell.error" }},
  {{ at = "DW 1",   type = "KH",  from = "error.first.code" }},
{actuals}
  {{ at = "DW 31",  type = "KF",  from = "cell.life" }},
]

[handshake.move]
pattern  = "start-busy-done"     # level-ack | toggle | strobe-parity | start-busy-done | number-select
start    = "DB{commands}.D0.8"           # 0 -> 1 takes the targets of the same telegram
busy     = "DB{status}.D0.8"
done     = "DB{status}.D0.9"             # stays until start falls
refused  = "DB{status}.D0.15"
"""


def _modbus(kind: str, answers: Mapping[str, str]) -> str:
    return f"""\
# ---- Modbus TCP: coil N = RC input bit N, discrete input N = RC output bit N, command block at 1000 ----
[[modbus]]
name           = "plc2"
role           = "server"
bind           = "{answers["bind"]}"
allow          = ["{answers["plc"]}"]         # writes only from here; all others read
unit           = 1
view           = "rho3"
command_block  = true
max_silence_ms = {answers.get("silence", "500")}
on_loss        = "stop_on_path"
"""


SERVODYN = """\
protocol = "servodyn"
layout   = "servodyn_gc.dbc"     # axisgate's own layout (AX-001), not verified on hardware
axes     = "1..{count}"
"""
CIA402 = """\
protocol = "canopen"
heartbeat_ms = 50                # of the gateway; drives must stop by themselves after three missing ones
"""


def _bus(family: str, count: int) -> str:
    own = SERVODYN.format(count=count) if family == "servodyn" else CIA402
    return f"""\
# ---- drives ----
[[bus]]
name     = "drives"
port     = "sim"                 # a real one: "socketcan:can0"
cycle_ms = 4
{own}
[defaults.axis]                  # for every axis that does not set its own
stop_on_bus_loss = "quick_stop"
brake            = "drive"
first_enable     = {{ torque = "20 %", speed = "5 %", travel = 2.0 }}
"""
