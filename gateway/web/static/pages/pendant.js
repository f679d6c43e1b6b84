// The hand-held unit of the old controller: its display and its keys, as the services describe them.
import { grey, h, put } from "../dom.js";

const SAID_MS = 150;
const FROZEN_MS = 600;
const ARROWS = { UP: "\u2191", DOWN: "\u2193", LEFT: "\u2190", RIGHT: "\u2192" };
const NAMES = { Enter: "enter", Backspace: "backspace", Delete: "delete", Escape: "escape", ArrowUp: "up", ArrowDown: "down", ArrowLeft: "left", ArrowRight: "right", PageUp: "pageup", PageDown: "pagedown",
  ".": "full_stop", ",": "comma", "-": "minus", "/": "slash", _: "underscore", $: "dollar_sign", "[": "left_square_bracket", "]": "right_square_bracket", ":": "colon", " ": "space" };

export function mount(root, { t, live, may, me, changeControl, unable }) {
  let unit = null;
  const held = new Map();
  const screen = h("pre", { class: "phg", id: "phg-screen", tabindex: "0", "aria-label": t("Display of the pendant") });
  const state = h("p", { class: "soft small", id: "phg-state", role: "status" });
  const keys = h("div", { class: "phg-keys", id: "phg-keys", role: "group", "aria-label": t("Keys of the pendant") });
  const typed = h("input", { id: "phg-typed", size: "12", autocomplete: "off", autocapitalize: "characters", placeholder: t("Type here"), "aria-label": t("Type here") });
  const control = h("button", { type: "button", id: "phg-control", onclick: changeControl }, t("Request control"));

  function press(name) {
    if (may("operator")) live.send({ t: "panel", act: "key", key: name });
  }
  function hold(button, name) {
    if (!may("operator") || held.has(name)) return;
    let last = Date.now();
    const say = (first) => {
      if (Date.now() - last > FROZEN_MS) { release(name); return; } // the browser stood still: the finger may be long gone
      last = Date.now();
      live.send({ t: "panel", act: "hold", key: name, first, at: live.at });
    };
    held.set(name, [setInterval(say, SAID_MS, false), button]);
    button.classList.add("down");
    say(true);
  }
  function release(name) {
    if (!held.has(name)) return;
    const [timer, button] = held.get(name);
    clearInterval(timer);
    held.delete(name);
    button.classList.remove("down");
    live.send({ t: "panel", act: "release", key: name });
  }
  const all = () => { for (const name of [...held.keys()]) release(name); };

  function key(name) {
    if (!name) return h("span", {});
    const holds = unit.held.includes(name);
    const face = unit.faces[name] || ARROWS[name] || name;
    const button = h("button", { type: "button", "data-key": name, "aria-label": name, class: holds ? "hold" : "", title: holds ? t("acts while it is held") : undefined }, face);
    if (!holds) { button.addEventListener("click", () => press(name)); return button; }
    button.addEventListener("pointerdown", (event) => { event.preventDefault(); button.setPointerCapture(event.pointerId); button.focus(); hold(button, name); });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) button.addEventListener(end, () => release(name));
    button.addEventListener("contextmenu", (event) => event.preventDefault());
    button.addEventListener("keydown", (event) => { if ((event.key === " " || event.key === "Enter") && !event.repeat) { event.preventDefault(); hold(button, name); } });
    button.addEventListener("keyup", (event) => { if (event.key === " " || event.key === "Enter") release(name); });
    return button;
  }
  function layOut(reply) {
    unit = reply;
    const across = Math.max(...unit.keypad.map((row) => row.length));
    keys.style.gridTemplateColumns = `repeat(${across}, minmax(0, 1fr))`;
    keys.replaceChildren(...unit.keypad.flatMap((row) => [...row, ...Array(across - row.length).fill("")].map(key)));
  }
  function known(name) { return unit.more.includes(name) || unit.keypad.some((row) => row.includes(name)); }
  function type(event) {
    if (!unit || event.ctrlKey || event.altKey || event.metaKey) return;
    const name = /^F[1-6]$/.test(event.key) ? event.key : unit.typed[NAMES[event.key] || event.key] || event.key.toUpperCase();
    if (!known(name) || unit.held.includes(name)) return;
    event.preventDefault();
    press(name);
  }
  screen.addEventListener("keydown", type);
  typed.addEventListener("keydown", type);
  typed.addEventListener("input", () => { for (const letter of typed.value.toUpperCase()) { const name = unit?.typed[NAMES[letter]] || letter; if (unit && known(name)) press(name); } typed.value = ""; }); // a keyboard on the screen says no keys
  for (const end of ["visibilitychange", "freeze"]) document.addEventListener(end, all);
  for (const end of ["blur", "pagehide"]) window.addEventListener(end, all);
  root.append(h("div", { class: "grid" }, h("section", { class: "card w12" }, screen, state, h("div", { class: "bar" }, typed, control), keys,
    h("p", { class: "soft small", id: "phg-held" }, t("Keys with a thick frame act while they are held; movement keys need control. This is not an enabling device.")))));
  return {
    update(reply) {
      put(control, me.holds ? t("Release control") : t("Request control"));
      if (!reply) return;
      if (reply.gone || !reply.unit) { put(state, reply.gone || ""); return; }
      if (!unit) layOut(reply.unit);
      put(screen, reply.screen.map((line) => line.padEnd(unit.columns)).join("\n"));
      put(state, `${unit.title}, ${t("operating mode")} ${reply.mode}${reply.lost_keys ? `, ${reply.lost_keys} ${t("keys lost")}` : ""}`);
      document.getElementById("phg-held").hidden = !unit.held.length;
      control.hidden = !unit.held.length;
      grey(control, unable("operator"));
      for (const button of keys.querySelectorAll("button")) grey(button, unable("operator"));
    },
    lift: all,
    unmount() {
      all();
      for (const end of ["visibilitychange", "freeze"]) document.removeEventListener(end, all);
      for (const end of ["blur", "pagehide"]) window.removeEventListener(end, all);
    },
  };
}
