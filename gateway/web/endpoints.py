"""The interface as a table: method, path, role, body, handler.  Routes and /api/openapi.json are made of the same rows."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from gateway.observer.tool_link import Gone, Refused
from gateway.web.access import Access, Denied, Person
from gateway.web.german import says
from gateway.web.operator_control import NotYours
from gateway.web.store import Role, StoreError

BODY_LIMIT = 16384
ALWAYS = ("/stop", "/setup", "/login", "/logout")  # also in read-only mode: a visitor from elsewhere must log in
Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Call:
    """One request as a handler sees it."""

    person: Person
    body: Any  # model of the endpoint, validated; None without one
    query: dict[str, str]
    path: dict[str, str]
    request: Request


Handler = Callable[[Call], Awaitable[Row | Response]]


@dataclass(frozen=True, slots=True)
class Endpoint:
    """One row.  `NOBODY`: no login needed; `changes`: guarded against other pages, refused in read-only mode, audited."""

    method: str
    path: str
    role: Role
    does: str
    handler: Handler
    body: type[BaseModel] | None = None
    changes: bool = False
    query: tuple[tuple[str, str], ...] = ()  # name, type in the schema
    plant: bool = False  # the emulator panel's: no machine moves, so on loopback a viewer may use it


def routes(endpoints: list[Endpoint], access: Access) -> list[Route]:
    """For Starlette."""
    return [Route(each.path, _answerer(each, access), methods=[each.method]) for each in endpoints]


def _answerer(endpoint: Endpoint, access: Access) -> Callable[[Request], Awaitable[Response]]:
    async def answer(request: Request) -> Response:
        try:
            person = _judge(endpoint, access, request)
            body = await _body(endpoint, request)
            result = await endpoint.handler(Call(person, body, dict(request.query_params), request.path_params, request))
        except ClientDisconnect:
            return Response(status_code=400)  # the client is gone
        except Denied as denied:
            return _no(denied.status, denied.words)
        except ValidationError as error:
            faults = "; ".join(f"{'.'.join(map(str, each['loc']))}: {each['msg']}" for each in error.errors(include_url=False))
            return _no(422, faults or "not valid")
        except NotYours as error:
            return _no(409, str(error))
        except Refused as error:
            return _no(409, str(error))
        except StoreError as error:
            return _no(409, str(error))
        except Gone as error:
            return _no(503, str(error))
        except (KeyError, ValueError) as error:
            return _no(404 if isinstance(error, KeyError) else 400, str(error.args[0]) if error.args else "not valid")
        if endpoint.changes:
            access.store.note(person.name, person.source, f"{endpoint.method} {endpoint.path}", _kept(body))
        return result if isinstance(result, Response) else JSONResponse(result)

    return answer


def _judge(endpoint: Endpoint, access: Access, request: Request) -> Person:
    access.host(request)
    person = access.person(request)
    if not endpoint.changes:
        access.role(person, endpoint.role)
        return person
    if access.web.read_only and not endpoint.path.endswith(ALWAYS):
        raise Denied(403, "the page is read-only ([web] read_only = true)")
    guest = person.local and not person.key  # a user who logged in as viewer changes nothing, in a simulation neither
    role = Role.VIEWER if endpoint.plant and access.simulated and guest else endpoint.role
    access.may(request, person, role)
    return person


async def _body(endpoint: Endpoint, request: Request) -> BaseModel | None:
    if endpoint.body is None:
        return None
    empty = "content-type" not in request.headers and request.headers.get("content-length", "0") == "0"
    if empty and not any(field.is_required() for field in endpoint.body.model_fields.values()):
        return endpoint.body()  # everything in it has a default
    if request.headers.get("content-type", "").partition(";")[0].strip() != "application/json":
        raise Denied(415, "content-type: application/json is expected")
    data = bytearray()
    async for part in request.stream():
        data += part
        if len(data) > BODY_LIMIT:
            raise Denied(413, f"a body has {BODY_LIMIT} bytes at most")
    try:
        data.decode()
    except UnicodeDecodeError:
        raise Denied(400, "the body is not UTF-8") from None
    return endpoint.body.model_validate_json(bytes(data))


def _kept(body: BaseModel | None) -> Row:
    """The audited part of a body: no password."""
    return {} if body is None else {key: value for key, value in body.model_dump().items() if key != "password"}


def _no(status: int, words: str) -> JSONResponse:
    headers = {"retry-after": words.rpartition(" ")[0].rpartition(" ")[2]} if status == 429 else None
    return JSONResponse({"error": words, "say": says(words)}, status, headers=headers)


def openapi(endpoints: list[Endpoint], version: str) -> Row:
    """The description scripts and fuzzers read."""
    paths: Row = {}
    for each in endpoints:
        answers: Row = {"200": {"description": "done", "content": {"application/json": {"schema": {"type": "object"}}}}}
        codes = {400: "not understood", 401: "login needed", 403: "not allowed", 404: "no such thing", 405: "not with this method",
                 409: "refused, in words", 413: "too long", 415: "not JSON", 421: "not our name", 422: "not valid", 429: "too often",
                 503: "services or simulation do not answer"}  # fmt: skip
        answers |= {str(code): {"description": words} for code, words in codes.items()}
        said: Row = {
            "summary": each.does,
            "operationId": f"{each.method.lower()}{each.path.replace('/', '_').replace('{', '').replace('}', '')}",
        }
        said |= {"responses": answers, "x-role": each.role.name.lower()}
        parameters = [{"name": name, "in": "query", "schema": {"type": kind}, "required": False} for name, kind in each.query]
        parameters += [
            {
                "name": part[1:-1].partition(":")[0],
                "in": "path",
                "required": True,
                "schema": {"type": "integer", "minimum": 0, "maximum": 1 << 53},
            }
            for part in each.path.split("/")
            if part.startswith("{")
        ]
        if parameters:
            said["parameters"] = parameters
        if each.body is not None:
            schema = each.body.model_json_schema(ref_template="#/components/schemas/{model}")
            said["requestBody"] = {"required": True, "content": {"application/json": {"schema": schema}}}
        paths.setdefault(each.path.replace(":int", ""), {})[each.method.lower()] = said
    return {"openapi": "3.0.3", "info": {"title": "axisgate", "version": version}, "paths": paths}
