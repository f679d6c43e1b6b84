"""`axisgate lsp` beside an editor: a client written by others types, asks for the outline, a hover text and a definition."""

import asyncio
import pathlib
import shutil
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager

import pytest
from lsprotocol import types as lsp
from pytest_lsp import LanguageClient, client_capabilities, make_test_lsp_client

import gateway

VECTORS = pathlib.Path(gateway.__file__).parents[1] / "hil_tests/vectors"
PICK = """PROGRAM PICK
EXTERNAL PLACE : height
INPUT : 1 = ready
POINT : above
CONST : wait_s = 2
BEGIN
  again:
  WAIT UNTIL ready = 1
  MOVE LINEAR TO above
  grip(wait_s)
  JUMP again
PROGRAM_END
SUBROUTINE grip (VALUE INTEGER : seconds)
BEGIN
  WAIT seconds
SUB_END
"""
PLACE = "PROGRAM PLACE\nPUBLIC REAL : height\nBEGIN\n  height = 5.0\nPROGRAM_END\n"
PATIENCE_S = 30.0


@asynccontextmanager
async def editor(folder: pathlib.Path) -> AsyncIterator[LanguageClient]:
    client = make_test_lsp_client()
    await client.start_io(sys.executable, "-m", "gateway", "lsp", "--log", str(folder / "lsp.log"))
    await client.initialize_session(
        lsp.InitializeParams(client_capabilities("visual_studio_code"), root_uri=folder.as_uri(), workspace_folders=[])
    )
    try:
        yield client
    finally:
        await client.shutdown_session()
        await getattr(client, "stop")()  # noqa: B009  # pygls gives it no types


def plays(folder: pathlib.Path, steps: Callable[[LanguageClient], Awaitable[None]]) -> None:
    async def play() -> None:
        async with editor(folder) as client:
            await asyncio.wait_for(steps(client), PATIENCE_S)

    asyncio.run(play())


async def opened(client: LanguageClient, path: pathlib.Path, language: str) -> list[lsp.Diagnostic]:
    """Opens a file; its faults."""
    document = lsp.TextDocumentItem(path.as_uri(), language, 1, path.read_text(encoding="utf-8"))
    waits = asyncio.create_task(client.wait_for_notification(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS))
    await asyncio.sleep(0)
    client.text_document_did_open(lsp.DidOpenTextDocumentParams(document))
    await waits
    return list(client.diagnostics[path.as_uri()])


async def typed(client: LanguageClient, path: pathlib.Path, version: int, text: str) -> list[lsp.Diagnostic]:
    waits = asyncio.create_task(client.wait_for_notification(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS))
    await asyncio.sleep(0)
    change = lsp.TextDocumentContentChangeWholeDocument(text)
    client.text_document_did_change(lsp.DidChangeTextDocumentParams(lsp.VersionedTextDocumentIdentifier(version, path.as_uri()), [change]))
    await waits
    return list(client.diagnostics[path.as_uri()])


def place(text: str, word: str, nth: int = 1) -> lsp.Position:
    """The middle of the nth occurrence of a word."""
    at = -1
    for _ in range(nth):
        at = text.index(word, at + 1)
    return lsp.Position(text.count("\n", 0, at), at - text.rfind("\n", 0, at) - 1 + len(word) // 2)


async def target(client: LanguageClient, path: pathlib.Path, where: lsp.Position) -> tuple[str, int]:
    """File and line (from 1) a definition leads to."""
    found = await client.text_document_definition_async(lsp.DefinitionParams(lsp.TextDocumentIdentifier(path.as_uri()), where))
    assert isinstance(found, lsp.Location)
    return found.uri.rpartition("/")[2], found.range.start.line + 1


async def hover(client: LanguageClient, path: pathlib.Path, where: lsp.Position) -> str:
    found = await client.text_document_hover_async(lsp.HoverParams(lsp.TextDocumentIdentifier(path.as_uri()), where))
    assert found is not None and isinstance(found.contents, lsp.MarkupContent)
    return found.contents.value


async def outline(client: LanguageClient, path: pathlib.Path) -> dict[str, list[str]]:
    found = await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(lsp.TextDocumentIdentifier(path.as_uri())))
    assert found is not None
    return {each.name: [one.name for one in each.children or ()] for each in found if isinstance(each, lsp.DocumentSymbol)}


def test_a_baps2_program_is_checked_while_it_is_typed_and_its_names_are_found(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "PICK.QLL"
    path.write_text(PICK)
    (tmp_path / "PLACE.QLL").write_text(PLACE)

    async def steps(client: LanguageClient) -> None:
        assert await opened(client, path, "baps2") == []
        spoilt = PICK.replace("JUMP again", "JUMP agian")
        (fault,) = await typed(client, path, 2, spoilt)
        line = spoilt.splitlines()[fault.range.start.line]
        assert line[fault.range.start.character : fault.range.end.character] == "JUMP" and "AGIAN" in fault.message
        assert fault.severity == lsp.DiagnosticSeverity.Error
        assert await typed(client, path, 3, PICK) == []
        found = await outline(client, path)
        assert found["GRIP"] == ["SECONDS"] and {"PICK", "READY", "ABOVE", "WAIT_S", "AGAIN", "GRIP"} <= set(found)
        assert await target(client, path, place(PICK, "grip")) == ("PICK.QLL", 13)
        assert await target(client, path, place(PICK, "seconds", 2)) == ("PICK.QLL", 13)
        assert await target(client, path, place(PICK, "height")) == ("PLACE.QLL", 2), "what another program makes public"
        assert "channel" in await hover(client, path, place(PICK, "ready", 2))
        assert "L1100" in await hover(client, path, place(PICK, "MOVE")), "the manual's line of a word"

    plays(tmp_path, steps)
    assert "publishDiagnostics" in (tmp_path / "lsp.log").read_text(encoding="utf-8")


def test_places_count_in_utf_16_and_an_included_file_is_checked_with_its_program(tmp_path: pathlib.Path) -> None:
    text = "PROGRAM PICK\n;;INCLUDE PARTS\nBEGIN\nWRITE '\U0001f600', COUNT, WRONG\nPROGRAM_END\n"
    path, parts = tmp_path / "PICK.QLL", tmp_path / "parts.qll"
    path.write_text(text, encoding="utf-8")
    parts.write_text("INTEGER : COUNT\n")

    async def steps(client: LanguageClient) -> None:
        (fault,) = await opened(client, path, "baps2")
        assert (fault.range.start.character, fault.range.end.character) == (19, 24), "the sign in front is two units"
        assert await target(client, path, lsp.Position(3, 17)) == ("parts.qll", 1)
        assert await opened(client, parts, "baps2") == []
        gone = lsp.TextDocumentIdentifier((tmp_path / "gone.qll").as_uri())
        assert await client.text_document_hover_async(lsp.HoverParams(gone, lsp.Position(0, 0))) is None

    plays(tmp_path, steps)


def test_a_memory_of_a_robotstar_is_one(tmp_path: pathlib.Path) -> None:
    main, sub = tmp_path / "MAIN.MPR", tmp_path / "PART.SPR"
    text = "1 MPR MAIN\n2 VAR Name:I_COUNT\n3 LABEL ROUND\n4 CALL PART\n5 BRANCH ROUND\n6 END\n"
    main.write_text(text)
    sub.write_text("1 SPR PART\n2 ADD 1, I_COUNT\n3 END\n")

    async def steps(client: LanguageClient) -> None:
        assert await opened(client, main, "robotstar") == []
        (fault,) = await typed(client, main, 2, text.replace("BRANCH ROUND", "BRANCH RUOND"))
        assert fault.range.start.line == 4 and "RUOND" in fault.message
        assert await typed(client, main, 3, text) == []
        assert await target(client, main, place(text, "ROUND", 2)) == ("MAIN.MPR", 3)
        assert await target(client, main, place(text, "PART")) == ("PART.SPR", 1)
        assert await opened(client, sub, "robotstar") == []
        assert await target(client, sub, place(sub.read_text(), "I_COUNT")) == ("MAIN.MPR", 2)
        assert "label" in await hover(client, main, place(text, "BRANCH"))

    plays(tmp_path, steps)


def test_a_val3_program_has_its_faults_at_the_lines_of_its_file(tmp_path: pathlib.Path) -> None:
    shutil.copytree(VECTORS / "val3/rotating_axis_1/rotate", tmp_path / "rotate")
    path = tmp_path / "rotate/start.pgx"
    text = path.read_text(encoding="utf-8")

    async def steps(client: LanguageClient) -> None:
        assert await opened(client, path, "val3") == []
        spoilt = text.replace("jDest.j1 = nPos", "jDest.j1 = nPoss")
        (fault,) = await typed(client, path, 2, spoilt)
        assert spoilt.splitlines()[fault.range.start.line].strip() == "jDest.j1 = nPoss"
        assert await typed(client, path, 3, text) == []
        assert "start" in await outline(client, path)
        assert (await target(client, path, place(text, "mNomSpeed")))[0].endswith(".dtx")
        assert "movej(joint, tool, mdesc)" in await hover(client, path, place(text, "movej"))

    plays(tmp_path, steps)


@pytest.mark.parametrize("name", ["PICK.QLL", "start.pgx", "notes.txt"])
def test_what_cannot_be_read_ends_nothing(tmp_path: pathlib.Path, name: str) -> None:
    path = tmp_path / name
    path.write_text("\x00(((" * 2000)

    async def steps(client: LanguageClient) -> None:
        await opened(client, path, "text")
        await typed(client, path, 2, ")))" * 2000)
        assert await outline(client, path) == {} or name == "PICK.QLL"

    plays(tmp_path, steps)


def test_a_program_is_checked_again_while_the_file_it_includes_is_typed(tmp_path: pathlib.Path) -> None:
    """Also one that imports: MAIN was checked again only when it was typed in itself, or the other file was saved."""
    files = {"MAIN": "PROGRAM MAIN\n;;INCLUDE HEAD\nEXTERNAL PLACE : height\nBEGIN\n  N = 1\n  height = 2.0\nPROGRAM_END\n"}
    files |= {"HEAD": "INTEGER : N\n", "PLACE": PLACE}
    paths = {name: tmp_path / f"{name}.QLL" for name in files}
    for name, text in files.items():
        paths[name].write_text(text)

    async def steps(client: LanguageClient) -> None:
        for path in paths.values():
            await opened(client, path, "baps2")
        for version, (name, text, said) in enumerate(
            [("HEAD", "INTEGER : M\n", "N is not declared"), ("HEAD", "INTEGER : N\n", ""), ("PLACE", "", "HEIGHT is not PUBLIC in PLACE")],
            2,
        ):
            await typed(client, paths[name], version, text or PLACE.replace("PUBLIC ", ""))
            await soon(client, paths["MAIN"], said)

    plays(tmp_path, steps)


async def soon(client: LanguageClient, path: pathlib.Path, said: str) -> None:
    """The faults of a file that nobody types in become these: one with these words, or none."""
    for _ in range(200):
        found = client.diagnostics[path.as_uri()]
        if [said in each.message for each in found] == ([True] if said else []):
            return
        await asyncio.sleep(0.05)
    raise AssertionError(client.diagnostics[path.as_uri()])
