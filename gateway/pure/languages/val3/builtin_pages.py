"""Popups, log, user pages, screens, profile, language, date.  Source: VAL 3 reference 4, L2810-3313; what a page shows goes to the log."""

import math
from collections.abc import Generator

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.disk import PathFault
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.numbers import Place
from gateway.pure.languages.val3.page_bindings import bind_from_file
from gateway.pure.languages.val3.page_catalogue import doubt, objects_of, page_place
from gateway.pure.languages.val3.pages import MOST, Prompt, Where
from gateway.pure.languages.val3.strings import f_to_string, finite
from gateway.pure.languages.val3.values import ScreenV, cut

Waiting = Generator[Ns | None, None, object]
LANGUAGES = ("francais", "english", "deutsch", "italiano", "espanol")
DATES = ("%y", "%Y", "%m", "%d", "%H", "%I", "%p", "%M", "%S")
SEVERITIES = (1, 2, 3, 4)
KEY_ESC, KEY_RETURN = 255.0, 270.0  # codes of keys of the text page


def _severity(value: float) -> int:
    if value not in SEVERITIES:
        raise Rte(70, f"severity {value:g}, 1 to 4")
    return int(value)


def f_pop_up_msg(own: Instance, text: str, severity: float = 1.0) -> None:
    """A popup of the operator."""
    _severity(severity)
    own.machine.popup(text)


def f_log_msg(own: Instance, text: str, severity: float = 1.0) -> bool:
    """A line of the log."""
    _severity(severity)
    return own.machine.note(text, "USR")


def f_user_page(own: Instance, name: str) -> float:
    """0; -1: the page is not there."""
    if _page_file(own, name) is None:
        return -1.0
    own.machine.note(f"user page {name}", "PAGE")
    for text in bind_from_file(own, name):
        own.machine.note(text, "PAGE")
    own.machine.pages.load(name, own.loaded.app.path)
    return 0.0


def _page_file(own: Instance, name: str) -> bytes | None:
    try:
        inside, file = page_place(own.loaded.app.path, name)
    except PathFault:
        return None
    return own.machine.disk.read(f"{inside}/{file}" if inside else file)


def f_user_page_none(own: Instance) -> float:
    """s7: the text page."""
    own.machine.pages.current = ""
    return 0.0


def f_user_page_text(own: Instance, which: object) -> float:
    """s7: the text page of a screen, or whether it stays."""
    return 0.0


def f_page_bind(own: Instance, page: str, name: str, attribute: str, where: Where, size: float, way: str, refresh: float = 1.0) -> None:
    """userPageBind; 70."""
    warning = own.machine.pages.bind(page, name, attribute, where, size, way, refresh)
    if warning:
        own.machine.note(warning, "PAGE")
    _judge(own, page, name, attribute)


def _judge(own: Instance, page: str, name: str, attribute: str) -> None:
    """What may not work as it should is a line of the log, once for each attribute."""
    pages, folder = own.machine.pages, own.loaded.app.path
    if (folder, page, name, attribute) in pages.judged or len(pages.judged) >= MOST:
        return
    pages.judged.add((folder, page, name, attribute))
    if (folder, page) not in pages.objects:
        pages.objects[folder, page] = objects_of(_page_file(own, page))
    if text := doubt(pages.objects[folder, page], page, name, attribute):
        own.machine.note(text, "PAGE")


def f_page_unbind(own: Instance, page: str, name: str, attribute: str) -> bool:
    """userPageUnbind."""
    return own.machine.pages.unbind(page, name, attribute)


def f_page_bind_event(own: Instance, page: str, name: str, event: str, where: Where, value: object = None) -> None:
    """userPageBindClick, ..Mouseup, ..Mousedown."""
    own.machine.pages.react(page, name, event, where, value)


def f_page_unbind_event(own: Instance, page: str, name: str, event: str, where: Where) -> bool:
    """userPageUnbindClick, ..Mouseup, ..Mousedown."""
    return own.machine.pages.ignore(page, name, event, where)


def f_page_set(own: Instance, page: str, name: str, attribute: str, value: object) -> None:
    """userPageSet; 70."""
    own.machine.pages.put(page, name, attribute, value)
    _judge(own, page, name, attribute)


def _asked(own: Instance, text: str, kind: str, *, key: bool = False) -> Generator[Ns | None, None, str | None]:
    """The operator's answer to this prompt, asked in its turn; None at once where a run has no operator.  key: a key ends it, too."""
    machine, asked = own.machine, Prompt(text, kind)
    machine.prompts.append(asked)
    try:
        while (machine.operator or (key and machine.keyed)) and not (machine.answers and machine.prompts[0] is asked):
            if key and machine.screen.keys:
                return None
            yield None
        return machine.answers.pop(0) if machine.answers else None
    finally:
        machine.prompts[:] = [each for each in machine.prompts if each is not asked]


def _answer(own: Instance, text: str, otherwise: str, kind: str) -> Generator[Ns | None, None, str]:
    """The operator's answer; `otherwise` at once where a run has no operator."""
    own.machine.popup(text)
    answer = yield from _asked(own, text, kind)
    return otherwise if answer is None else answer


def f_user_page_alert(own: Instance, text: str) -> Waiting:
    """Until OK."""
    yield from _answer(own, text, "ok", "alert")
    return None


def f_user_page_confirm(own: Instance, text: str) -> Waiting:
    """OK true, CANCEL false."""
    answer = yield from _answer(own, text, "ok", "confirm")
    return not answer.lower().startswith("cancel")


def f_user_page_prompt(own: Instance, text: str, entry: Place) -> Waiting:
    """OK true and the entry, CANCEL false; an entry that is not a number is requested again."""
    while True:
        answer = yield from _answer(own, text, "cancel", "prompt")
        word, separator, given = answer.partition(":")
        if word.lower() == "cancel":
            return False
        old = entry[0][entry[1]]
        if not separator:
            return True
        value = finite(given) if isinstance(old, float) else cut(given)
        if value is None:
            continue
        entry[0][entry[1]] = value
        return True


def f_get_profile(own: Instance) -> str:
    """The current profile."""
    return own.machine.robot.profile


def f_set_profile(own: Instance, name: str, password: str) -> Waiting:
    """0, -1, -2, -3, -4."""
    machine = own.machine
    if not machine.current_is_synchronous:
        yield machine.now
    if machine.robot.profile == "staubli":
        return -4.0
    if name == "staubli":
        return -3.0
    if name not in machine.profiles:
        return -1.0
    if machine.profiles[name] != password:
        return -2.0
    machine.robot.profile = name
    return 0.0


def f_get_language(own: Instance) -> str:
    """The language of the controller."""
    return own.machine.robot.language


def f_set_language(own: Instance, name: str) -> bool:
    """Set the language; false: the translation does not exist."""
    if name not in LANGUAGES:
        return False
    own.machine.robot.language = name
    return True


def f_get_date(own: Instance, form: str) -> str:
    """%y %Y %m %d %H %I %p %M %S inside any text."""
    now = own.machine.date
    for code in DATES:
        form = form.replace(code, now.strftime(code))
    return cut(form)


# ---- text page of s7: 14 lines of 40 characters (assumed) ---------------------------------------------------------------------


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f_to_string(".6", value).rstrip()


def f_screen_cls(own: Instance, screen: ScreenV | None = None) -> None:
    """Empties the page."""
    own.machine.screen.clear()


def f_screen_gotoxy(own: Instance, column: float, line: float) -> None:
    """70 outside the page."""
    own.machine.screen.go(math.floor(column + 0.5), math.floor(line + 0.5))


def f_screen_gotoxy_of(own: Instance, screen: ScreenV, column: float, line: float) -> None:
    """As gotoxy."""
    f_screen_gotoxy(own, column, line)


def f_screen_put(own: Instance, value: str | float) -> None:
    """At the cursor."""
    own.machine.screen.put(_text(value))


def f_screen_put_of(own: Instance, screen: ScreenV, value: str | float) -> None:
    """As put."""
    f_screen_put(own, value)


def f_screen_putln(own: Instance, value: str | float) -> None:
    """And a new line."""
    screen = own.machine.screen
    screen.put(_text(value))
    own.machine.note(screen.said, "SCREEN")
    screen.newline()
    screen.said = ""


def f_screen_putln_of(own: Instance, screen: ScreenV, value: str | float) -> None:
    """As putln."""
    f_screen_putln(own, value)


def f_screen_title(own: Instance, text: str) -> None:
    """The title."""
    own.machine.screen.title = text


def f_screen_title_of(own: Instance, screen: ScreenV, text: str) -> None:
    """As title."""
    f_screen_title(own, text)


def _entered(own: Instance, *, key: bool = False) -> Generator[Ns | None, None, tuple[float, str | None]]:
    """Key that ended an entry, and what was entered; Esc at once where a run has no operator."""
    yield own.machine.now
    answer = yield from _asked(own, "", "prompt", key=key)
    word, separator, text = (answer or "cancel").partition(":")
    return (KEY_ESC, None) if word.lower() == "cancel" else (KEY_RETURN, text if separator else "")


def f_screen_get(own: Instance, entry: Place) -> Waiting:
    """An entry: the key that ended it; Esc leaves the variable as it is."""
    old = entry[0][entry[1]]
    while True:
        key, text = yield from _entered(own)
        if text is None:
            return key
        value = finite(text or "0") if isinstance(old, float) else cut(text)
        if value is None:
            continue  # no number: it is asked for again
        entry[0][entry[1]] = value
        return key


def f_screen_get_of(own: Instance, screen: ScreenV, entry: Place) -> Waiting:
    """As get."""
    return (yield from f_screen_get(own, entry))


def f_screen_get_key(own: Instance, screen: ScreenV | None = None) -> Waiting:
    """The next key: the code of a character, or of Return and Esc."""
    keys = own.machine.screen.keys
    if keys:
        return keys.popleft()
    key, text = yield from _entered(own, key=True)
    return float(ord(text[0])) if text else keys.popleft() if keys and text is None else key


def f_screen_key(own: Instance, screen: ScreenV | None = None) -> float:
    """The code of the next key that was pressed; -1: none was."""
    keys = own.machine.screen.keys
    return keys.popleft() if keys else -1.0


def f_screen_pressed(own: Instance, key: float) -> bool:
    """Whether it waits to be read: how long a key is held is not known."""
    return key in own.machine.screen.keys


def f_screen_pressed_of(own: Instance, screen: ScreenV, key: float) -> bool:
    """As isKeyPressed."""
    return f_screen_pressed(own, key)


def f_screen_mode(own: Instance, mode: float) -> None:
    """Inverse or blinking text: a text page has none."""


def f_screen_mode_of(own: Instance, screen: ScreenV, mode: float) -> None:
    """As setTextMode."""
