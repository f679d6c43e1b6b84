"""Handlers of the interface; the table of `endpoints` has the rights."""

import math
import time
from typing import Any

from starlette.responses import Response

from gateway.observer.names import MOST, Entry, Names
from gateway.web.access import Access
from gateway.web.accounts import Accounts, account_endpoints
from gateway.web.audit_words import sentences_of
from gateway.web.bodies import (
    Cable,
    Command,
    Fault,
    FileName,
    Force,
    ForceWord,
    Keep,
    Kept,
    Marker,
    Permit,
    PlcStart,
    ProgramName,
    Put,
    Record,
    Unforce,
    UnforceWord,
    Val3Act,
)
from gateway.web.catalogue import found, said
from gateway.web.endpoints import Call, Endpoint
from gateway.web.live import Live
from gateway.web.operator_control import OperatorControl
from gateway.web.program_test import ProgramTests, program_test_endpoints
from gateway.web.scope import Wanted
from gateway.web.store import Role, Store, StoreError
from gateway.web.trends import LEAST_S, MOST_S
from gateway.web.word_forces import forced_words

Row = dict[str, Any]
VAL3_PAGE = (("folder", "string"), ("name", "string"), ("image", "string"))
PLC_STEPS = (("name", "string"), ("first", "number"))
ALARM_FILTER = (("q", "string"), ("state", "string"), ("source", "string"), ("from", "string"), ("to", "string"))
SEARCH = (("q", "string"), ("group", "string"), ("id", "string"))
LISTS = ("watch", "scope")
KINDS = {"scope": "application/octet-stream", "csv": "text/csv", "mf4": "application/octet-stream"}


class Api:
    """Requests and orders of the page."""

    def __init__(self, live: Live, names: Names, access: Access, cell: Row) -> None:
        self.live, self.names, self.access, self.cell = live, names, access, cell
        self.store: Store = access.store
        self.operator_control: OperatorControl = live.operator_control
        self.accounts = Accounts(access, live.operator_control)

    # ---- looking --------------------------------------------------------------------------------------------------------
    async def me(self, call: Call) -> Row:
        person = call.person
        return {
            "name": person.name,
            "role": person.role.name.lower(),
            "local": person.local,
            "csrf": person.csrf,
            "fresh": self.store.fresh,
            "read_only": self.access.web.read_only,
            "simulated": self.access.simulated,
            "holds": bool(person.key) and person.key == self.operator_control.holder,
        }

    async def show_cell(self, call: Call) -> Row:
        return self.cell

    async def search(self, call: Call) -> Row:
        wanted = call.request.query_params.getlist("id")[:MOST]
        if wanted:  # a watch list; names missing in this cell are left out
            found = [entry for id_ in wanted if (entry := self._known(id_[:100])) is not None]
            return {"total": len(found), "rows": [entry.row() for entry in found]}
        total, found = self.names.search(call.query.get("q", "")[:200], call.query.get("group", "")[:100])
        return {"total": total, "rows": [entry.row() for entry in found]}

    def _known(self, id_: str) -> Entry | None:
        try:
            return self.names.entry(id_)
        except KeyError:
            return None

    async def value(self, call: Call) -> Row:
        return await self.operator_control.services_link.ask("get", address=call.query.get("address", "")[:100])

    async def tree(self, call: Call) -> Row:
        return {"tree": self.names.tree(), "total": len(self.names.all)}

    async def trend(self, call: Call) -> Row:
        """The last seconds of one value; `wall_ms` is the moment its times count back from."""
        now = time.monotonic()
        points = self.live.trends.points(call.query.get("id", "")[:100], seconds_of(call.query.get("seconds", "3600")), now)
        return {**points, "wall_ms": round(time.time() * 1e3)}

    # ---- watch lists and layouts of the scope -----------------------------------------------------------------------------
    async def kept(self, call: Call) -> Row:
        kind = call.query.get("kind", "")
        if kind not in LISTS:
            raise ValueError(f"kind: {', '.join(LISTS)}")
        return {"kept": self.store.kept(kind)}

    async def keep(self, call: Call) -> Row:
        body: Keep = call.body
        self.store.keep(body.kind, body.name, body.value)
        return {"kept": self.store.kept(body.kind)}

    async def drop_kept(self, call: Call) -> Row:
        body: Kept = call.body
        if not self.store.drop_kept(body.kind, body.name):
            raise StoreError(f"nothing is stored under {body.name}")
        return {"kept": self.store.kept(body.kind)}

    async def errors(self, call: Call) -> Row:
        return {"errors": found(call.query.get("q", "")[:100])}

    async def alarms(self, call: Call) -> Row:
        return await self.live.alarms.found(call.query)

    async def alarms_file(self, call: Call) -> Response:
        return await self.live.alarms.file(call.query)

    async def job(self, call: Call) -> Row:
        return await self.operator_control.job(int(call.path["number"]))

    async def health(self, call: Call) -> Row:
        cycle, services = self.live.regions.ages()
        return {"cycle": cycle < 250, "services": services < 250}

    # ---- the machine ------------------------------------------------------------------------------------------------------
    async def stop(self, call: Call) -> Row:
        """Stop is open to all users."""
        return await self.operator_control.command(call.person.key, call.person.name, "stop")

    async def command(self, call: Call) -> Row:
        body: Command = call.body
        rest: Row = {"velocity": body.velocity, "acceleration": body.acceleration, "targets": body.targets}
        return said(await self.operator_control.command(call.person.key, call.person.name, body.code, body.mask, **rest))

    async def permit(self, call: Call) -> Row:
        body: Permit = call.body
        return await self.operator_control.services_link.ask("permit", on=body.on)

    async def force(self, call: Call) -> Row:
        body: Force = call.body
        return await self.operator_control.services_link.ask("force_input", bit=body.bit, value=body.value, who=call.person.name)

    async def unforce(self, call: Call) -> Row:
        body: Unforce = call.body
        return await self.operator_control.services_link.ask("unforce_input", bit=body.bit, who=call.person.name)

    async def force_word(self, call: Call) -> Row:
        body: ForceWord = call.body
        block, words = forced_words(self._entry(body.id), body.value)
        return await self.operator_control.services_link.ask("force_words", block=block, words=words, who=call.person.name)

    async def unforce_word(self, call: Call) -> Row:
        body: UnforceWord = call.body
        block, words = forced_words(self._entry(body.id), None)
        return await self.operator_control.services_link.ask("unforce_words", block=block, words=words, who=call.person.name)

    def _entry(self, id_: str) -> Entry:
        found = self.names.by_id.get(id_)
        if found is None:
            raise KeyError(f"no value {id_}")
        return found

    async def put(self, call: Call) -> Row:
        body: Put = call.body
        return await self.operator_control.services_link.ask("set", address=body.address, value=body.value)

    # ---- programs of the old controller ------------------------------------------------------------------------------------
    async def program_text(self, call: Call) -> Row:
        try:
            return await self.live.programs.text(call.query.get("name", "")[:128])
        except OSError as error:
            raise KeyError(f"{error.filename}: {error.strerror}") from None

    async def program_start(self, call: Call) -> Row:
        body: ProgramName = call.body
        return await self.operator_control.start_program(call.person.key, body.name)

    async def program_stop(self, call: Call) -> Row:
        body: ProgramName = call.body
        return await self.operator_control.services_link.ask("process", do="stop", name=body.name)

    # ---- the integrated PLC ---------------------------------------------------------------------------------------------
    async def plc_listing(self, call: Call) -> Row:
        return await self.live.plc.listing(call.query.get("name", "")[:256], _first(call))

    async def plc_shown(self, call: Call) -> Row:
        return await self.live.plc.shown(call.query.get("name", "")[:256], _first(call))

    async def val3_page(self, call: Call) -> Row:
        try:
            folder, name, image = (call.query.get(key, "")[:256] for key in ("folder", "name", "image"))
            return await (self.live.val3.image(folder, name, image) if image else self.live.val3.page(folder, name))
        except OSError as error:
            raise KeyError(str(error)) from None

    async def val3_act(self, call: Call) -> Row:
        body: Val3Act = call.body
        return await self.live.val3.act(act=body.act, what=body.what, attribute=body.attribute, value=body.value, on=body.on)

    async def plc_start(self, call: Call) -> Row:
        body: PlcStart = call.body
        return await self.operator_control.services_link.ask("plc", do="start", name=body.name)

    async def plc_stop(self, call: Call) -> Row:
        return await self.operator_control.services_link.ask("plc", do="stop")

    async def plc_ack(self, call: Call) -> Row:
        return await self.operator_control.services_link.ask("plc", do="ack")

    async def plc_write(self, call: Call) -> Row:
        body: Marker = call.body
        return await self.operator_control.services_link.ask(
            "plc", do="write", operand=body.operand, value=body.value, who=call.person.name
        )

    # ---- the scope --------------------------------------------------------------------------------------------------------
    async def scope_names(self, call: Call) -> Row:
        return {**self.live.scope.names(), "saved": self.live.scope.saved()}

    async def scope_start(self, call: Call) -> Row:
        body: Record = call.body
        self.live.scope.start(Wanted(tuple(body.channels), body.seconds, body.pre, body.trigger, call.person.name, body.rolling))
        return {"ok": True}

    async def scope_stop(self, call: Call) -> Row:
        await self.live.scope.stop()
        return {"ok": True}

    async def scope_file(self, call: Call) -> Response:
        """The recording that is shown, as a file."""
        kind = call.query.get("as", "scope")
        if kind not in KINDS:
            raise ValueError(f"as: {', '.join(KINDS)}")
        data = await self.live.scope.export(kind)
        name = f"{self.live.scope.name or 'recording'}.{kind}"
        return Response(data, media_type=KINDS[kind], headers={"content-disposition": f'attachment; filename="{name}"'})

    async def scope_save(self, call: Call) -> Row:
        body: FileName = call.body
        self.live.scope.save(body.name)
        return {"saved": self.live.scope.saved()}

    async def scope_open(self, call: Call) -> Row:
        body: FileName = call.body
        self.live.scope.open(body.name)
        return {"ok": True}

    # ---- the simulation ---------------------------------------------------------------------------------------------------
    async def cable(self, call: Call) -> Row:
        body: Cable = call.body
        match body.do:
            case "damage":
                damage: Row = {"from": body.side, "kind": body.kind, "probability": body.probability}
                return await self.live.plant.cable(body.line, "damage", **damage)
            case "remove" | "insert":
                return await self.live.plant.cable(body.line, body.do, side=body.side)
        return await self.live.plant.cable(body.line, body.do)

    async def fault(self, call: Call) -> Row:
        body: Fault = call.body
        if body.do in ("quit", "flush"):
            raise ValueError(f"{body.do} is not for the page")
        given = body.model_dump(exclude={"emulator", "do"}, exclude_none=True)
        return await self.live.plant.fault(body.emulator, body.do, **given)

    # ---- the audit log ----------------------------------------------------------------------------------------------------
    async def audit(self, call: Call) -> Row:
        axes = [axis["name"] for axis in self.cell["axes"]]
        rows = [{**row, "say": sentences_of(str(row["what"]), str(row["detail"]), axes)} for row in self.store.audit()]
        return {"entries": rows, "broken_at": self.store.verify()}


def _first(call: Call) -> int:
    text = call.query.get("first", "1")
    if not text.isascii() or not text.isdigit() or len(text) > 9:
        raise ValueError("first: the number of a step")
    return int(text)


def seconds_of(text: str) -> float:
    """ValueError: no number of seconds."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not LEAST_S <= seconds <= MOST_S:
        raise ValueError(f"seconds: {LEAST_S:.0f}..{MOST_S:.0f}")
    return seconds


def plc_endpoints(api: Api) -> list[Endpoint]:
    """Endpoints of the integrated PLC and of a VAL 3 application."""
    v, o, s = Role.VIEWER, Role.OPERATOR, Role.SETTER
    row = Endpoint
    return [
        row(
            "GET",
            "/api/val3/page",
            v,
            "a user page of the VAL 3 application, without scripts, or an image next to it",
            api.val3_page,
            query=VAL3_PAGE,
        ),
        row("POST", "/api/val3/act", o, "click, entry, answer, value, hold or connection move of it", api.val3_act, Val3Act, True),
        row("GET", "/api/plc/listing", v, "steps of a program of the integrated PLC", api.plc_listing, query=PLC_STEPS),
        row("GET", "/api/plc/shown", v, "its test display: state, VKE and accumulators after each step", api.plc_shown, query=PLC_STEPS),
        row("POST", "/api/plc/start", o, "translate and start it, as Start PLC does", api.plc_start, PlcStart, True),
        row("POST", "/api/plc/stop", o, "end its cyclic treatment; all outputs are 0", api.plc_stop, None, True),
        row("POST", "/api/plc/ack", o, "acknowledge its message", api.plc_ack, None, True),
        row("POST", "/api/plc/write", s, "write a marker between two scans", api.plc_write, Marker, True),
    ]


def endpoints(api: Api) -> list[Endpoint]:
    """All of them."""
    v, o, s, a, n = Role.VIEWER, Role.OPERATOR, Role.SETTER, Role.ADMIN, Role.NOBODY
    row = Endpoint
    return [
        row("GET", "/api/health", n, "whether cycle and services live", api.health),
        row("GET", "/api/me", n, "who am I, and what may I", api.me),
        row("GET", "/api/cell", v, "devices, wiring, check results, evidence", api.show_cell),
        row(
            "GET",
            "/api/signals",
            v,
            "search values by name or address",
            api.search,
            query=(("q", "string"), ("group", "string"), ("id", "string")),
        ),
        row("GET", "/api/value", v, "one value by name or address, also phg.33282.1.2", api.value, query=(("address", "string"),)),
        row("GET", "/api/trend", v, "the last hours of one value", api.trend, query=(("id", "string"), ("seconds", "number"))),
        row("GET", "/api/kept", v, "kept watch lists, or layouts of the scope", api.kept, query=(("kind", "string"),)),
        row("POST", "/api/kept", o, "keep one under a name", api.keep, Keep, True),
        row("POST", "/api/kept/drop", o, "remove one", api.drop_kept, Kept, True),
        row("GET", "/api/tree", v, "branches of all values", api.tree),
        row("GET", "/api/errors", v, "the error catalogue by number, family and number, or words", api.errors, query=(("q", "string"),)),
        row("GET", "/api/alarms", v, "alarms that occurred, were acknowledged and cleared", api.alarms, query=ALARM_FILTER),
        row("GET", "/api/alarms/file", v, "the same as csv or json", api.alarms_file, query=(("as", "string"), *ALARM_FILTER)),
        row("GET", "/api/jobs/{number:int}", v, "what became of a command", api.job),
        row("POST", "/api/stop", v, "stop on the path", api.stop, changes=True),
        row("POST", "/api/command", o, "one command of the command block", api.command, Command, True),
        row("GET", "/api/program", v, "the listing of a program, with its faults", api.program_text, query=(("name", "string"),)),
        row("POST", "/api/program/start", o, "start a program of the old controller", api.program_start, ProgramName, True),
        row("POST", "/api/program/stop", o, "stop it", api.program_stop, ProgramName, True),
        *program_test_endpoints(ProgramTests(lambda: api.operator_control)),
        *plc_endpoints(api),
        row("POST", "/api/permit", s, "set or clear the enabling inputs of a simulation", api.permit, Permit, True, plant=True),
        row("POST", "/api/force", s, "force an RC input", api.force, Force, True),
        row("POST", "/api/unforce", s, "end a force, or all of them", api.unforce, Unforce, True),
        row("POST", "/api/force/word", s, "force a data word or bit", api.force_word, ForceWord, True),
        row("POST", "/api/unforce/word", s, "end its force", api.unforce_word, UnforceWord, True),
        row("GET", "/api/scope/names", v, "what the scope can record, and what is kept", api.scope_names),
        row("GET", "/api/scope/file", v, "the recording, as scope, csv or mf4", api.scope_file, query=(("as", "string"),)),
        row("POST", "/api/scope/start", o, "record", api.scope_start, Record, True),
        row("POST", "/api/scope/stop", o, "end the recording", api.scope_stop, None, True),
        row("POST", "/api/scope/open", o, "show a kept recording to all users", api.scope_open, FileName, True),
        row("POST", "/api/scope/save", o, "keep the recording on the gateway", api.scope_save, FileName, True),
        row("POST", "/api/set", s, "write a value as the PLC would (simulation)", api.put, Put, True),
        row("POST", "/api/cable", s, "pull a simulated cable", api.cable, Cable, True, plant=True),
        row("POST", "/api/fault", s, "fault an emulated drive", api.fault, Fault, True, plant=True),
        *account_endpoints(api.accounts),
        row("GET", "/api/audit", a, "who changed what, and whether the chain is intact", api.audit),
    ]
