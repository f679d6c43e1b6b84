"""The language server of `axisgate lsp`: faults while typing, outline, hover, definition.  Source: LSP 3.17, by pygls."""

import asyncio
import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from urllib.parse import unquote, urlparse

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer
from pygls.workspace import TextDocument

from gateway.pure.languages.base.faults import Severity, SourceFault
from gateway.tools.editor.baps2 import Baps2
from gateway.tools.editor.robotstar import Robotstar
from gateway.tools.editor.symbols import EditedLanguage, Look, Symbol, name_at
from gateway.tools.editor.val3 import Val3

LANGUAGES: tuple[EditedLanguage, ...] = (Baps2(), Robotstar(), Val3())
KINDS = {
    "module": lsp.SymbolKind.Module,
    "routine": lsp.SymbolKind.Function,
    "variable": lsp.SymbolKind.Variable,
    "constant": lsp.SymbolKind.Constant,
    "channel": lsp.SymbolKind.Event,
    "point": lsp.SymbolKind.Struct,
    "type": lsp.SymbolKind.Class,
    "label": lsp.SymbolKind.Key,
}
QUIET_S = 0.3  # pause after the last key
SEVERITIES = {Severity.ERROR: lsp.DiagnosticSeverity.Error, Severity.WARNING: lsp.DiagnosticSeverity.Warning}


class Looks:
    """Results for each open document; recomputed when a text has changed."""

    def __init__(self, server: LanguageServer) -> None:
        self._server = server
        self._looks: dict[tuple[str, int | None], Look] = {}
        self.took_s = 0.0  # of the last reading

    def of(self, uri: str) -> Look:
        """The look of a document; an empty one where no language has its suffix or it cannot be read."""
        document = self._server.workspace.get_text_document(uri)
        key = (uri, document.version)
        if key not in self._looks:
            begun = time.perf_counter()
            self._looks = {each: look for each, look in self._looks.items() if each[0] != uri}
            self._looks[key] = self._read(document)
            self.took_s = time.perf_counter() - begun
        return self._looks[key]

    def forget_others(self, uri: str) -> None:
        """A text has changed: results for other documents may depend on it."""
        self._looks = {each: look for each, look in self._looks.items() if each[0] == uri}

    def _read(self, document: TextDocument) -> Look:
        path = path_of(document.uri)
        language = next((each for each in LANGUAGES if path.suffix.lower() in each.suffixes), None)
        if language is None:
            return Look()
        workspace = self._server.workspace
        texts = {path_of(uri).resolve(): each.source for uri, each in workspace.text_documents.items()}
        root = Path(workspace.root_path).resolve() if workspace.root_path else path.resolve().parent
        try:
            return language.look(path, texts, root)
        except (OSError, ValueError) as error:
            self._server.window_show_message(lsp.ShowMessageParams(lsp.MessageType.Warning, f"{path.name}: {error}"))
            return Look()


class OtherDocuments:
    """Open documents without edits: they may include, import or call the edited one, and are checked after the last key."""

    def __init__(self, publish: Callable[[str], None]) -> None:
        self._publish = publish
        self._timer: asyncio.TimerHandle | None = None

    def later(self, uris: Sequence[str], seconds: float = QUIET_S) -> None:
        """In sequence: a key pressed in between is served first, and restarts it."""
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(seconds, self._next, uris) if uris else None

    def _next(self, uris: Sequence[str]) -> None:
        self._publish(uris[0])
        self.later(uris[1:], 0.0)


def made_server() -> LanguageServer:
    """The server with all it answers."""
    server = LanguageServer("axisgate", version("axisgate"), text_document_sync_kind=lsp.TextDocumentSyncKind.Incremental)
    looks = Looks(server)

    def publish(uri: str) -> None:
        document = server.workspace.get_text_document(uri)
        path = path_of(uri).resolve()
        found = [_diagnostic(each.line, each.column, document, each.fault) for each in looks.of(uri).faults if each.path.resolve() == path]
        server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, found, version=document.version))

    others = OtherDocuments(publish)

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    def opened(params: lsp.DidOpenTextDocumentParams) -> None:
        publish(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def changed(params: lsp.DidChangeTextDocumentParams) -> None:
        looks.forget_others(params.text_document.uri)
        publish(params.text_document.uri)
        others.later([each for each in server.workspace.text_documents if each != params.text_document.uri])

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    def saved(params: lsp.DidSaveTextDocumentParams) -> None:
        looks.forget_others(params.text_document.uri)
        for uri in server.workspace.text_documents:
            publish(uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def closed(params: lsp.DidCloseTextDocumentParams) -> None:
        server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(params.text_document.uri, []))
        looks.forget_others("")  # the file on the disk counts again
        for uri in server.workspace.text_documents:
            publish(uri)

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def outline(params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        uri = params.text_document.uri
        own = [each for each in looks.of(uri).symbols if each.path.resolve() == path_of(uri).resolve()]
        return _outline(own, server.workspace.get_text_document(uri))

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    def hover(params: lsp.HoverParams) -> lsp.Hover | None:
        name, line = _asked(server, params)
        shown = looks.of(params.text_document.uri).hover(name, line) if name else ""
        return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, shown)) if shown else None

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def definition(params: lsp.DefinitionParams) -> lsp.Location | None:
        name, line = _asked(server, params)
        symbol = looks.of(params.text_document.uri).named(name, line) if name else None
        if symbol is None:
            return None
        uri = symbol.path.resolve().as_uri()
        opened = next((each for each in server.workspace.text_documents if path_of(each).resolve() == symbol.path.resolve()), uri)
        document = server.workspace.get_text_document(opened)
        return lsp.Location(document.uri, _range(document, symbol.line, symbol.column, len(symbol.name)))

    return server


def path_of(uri: str) -> Path:
    """The file of a `file:` address."""
    return Path(unquote(urlparse(uri).path))


def _asked(server: LanguageServer, params: lsp.HoverParams | lsp.DefinitionParams) -> tuple[str, int]:
    """The name at a place, and its line from 1; "" where the document is neither open nor on the disk."""
    document = server.workspace.get_text_document(params.text_document.uri)
    line = params.position.line + 1
    rows = _rows(document)
    if line > len(rows):
        return "", line
    column = document.position_codec.position_from_client_units(rows, params.position).character + 1
    return name_at(rows[line - 1], 1, column), line


def _rows(document: TextDocument) -> Sequence[str]:
    """The lines of a document; none where it cannot be read."""
    try:
        return document.lines
    except (OSError, ValueError):
        return []


def _range(document: TextDocument, line: int, column: int, length: int) -> lsp.Range:
    """A range in the units of the editor: a character beyond 16 bits counts as two."""
    start = lsp.Position(max(line - 1, 0), max(column - 1, 0))
    whole = lsp.Range(start, lsp.Position(start.line, start.character + length))
    rows = _rows(document)
    return document.position_codec.range_to_client_units(rows, whole) if start.line < len(rows) else whole


def _diagnostic(line: int, column: int, document: TextDocument, fault: SourceFault) -> lsp.Diagnostic:
    rows = _rows(document)
    row = rows[line - 1] if 0 < line <= len(rows) else ""
    name = name_at(row, 1, column)
    length = len(name) if name and row[column - 1 : column - 1 + len(name)] == name else max(len(row.rstrip()) - column + 1, 1)
    text = f"{fault.text}; {fault.hint}" if fault.hint else fault.text
    return lsp.Diagnostic(
        _range(document, line, column, length), text, severity=SEVERITIES[fault.severity], code=fault.id, source="axisgate"
    )


def _outline(symbols: Sequence[Symbol], document: TextDocument) -> list[lsp.DocumentSymbol]:
    """Nest symbols in the routines that declare them."""
    routines: dict[str, list[lsp.DocumentSymbol]] = {}
    top: list[lsp.DocumentSymbol] = []
    for each in sorted(symbols, key=lambda one: (one.inside != "", one.line, one.column)):
        place = _range(document, each.line, each.column, len(each.name))
        whole = lsp.Range(place.start, lsp.Position(max(each.end - 1, place.end.line), 1_000)) if each.end else place
        inside: list[lsp.DocumentSymbol] = []
        made = lsp.DocumentSymbol(each.name, KINDS[each.kind], whole, place, detail=each.detail, children=inside)
        routines.get(each.inside, top).append(made)
        if each.kind == "routine":
            routines[each.name] = inside
    return top
