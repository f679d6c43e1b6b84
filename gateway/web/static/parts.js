// What several pages show.
import { opened } from "./dialog.js";
import { h, put } from "./dom.js";

// One value out of a dialog; null when it is left.
export function asked(t, title, value, verb = "force", most = 24) {
  return new Promise((resolve) => {
    const dialog = document.getElementById("dialog");
    const input = h("input", { id: "asked", value: String(value), maxlength: String(most), autofocus: true, required: true, "aria-label": title });
    const done = (reply) => { dialog.onclose = null; dialog.close(); resolve(reply); };
    dialog.onclose = () => done(null);
    dialog.replaceChildren(h("form", { method: "dialog", onsubmit: (event) => { event.preventDefault(); done(input.value.trim()); } },
      h("h2", {}, title), input, h("div", { class: "bar" }, h("button", { class: "main", id: "send" }, t(verb)), h("button", { type: "button", onclick: () => done(null) }, t("Cancel")))));
    opened(dialog);
    input.select();
  });
}

// A question to be answered with yes; false when it is left.
export function sure(t, title, verb) {
  return new Promise((resolve) => {
    const dialog = document.getElementById("dialog");
    const done = (reply) => { dialog.onclose = null; dialog.close(); resolve(reply); };
    dialog.onclose = () => done(false);
    dialog.replaceChildren(h("form", { method: "dialog", onsubmit: (event) => { event.preventDefault(); done(true); } },
      h("h2", {}, title), h("div", { class: "bar" }, h("button", { class: "main", id: "send", autofocus: true }, t(verb)), h("button", { type: "button", onclick: () => done(false) }, t("Cancel")))));
    opened(dialog);
  });
}

export const FLAG = { ENABLED: 1, REFERENCED: 2, IN_POSITION: 4, FAULT: 8, LOST: 16, HOMING: 32, WARNING: 64, ON: 128, UNCONFIGURED: 256 };

export function drive(row, t) {
  const f = row.flags;
  if (f & FLAG.LOST) return ["bad", t("no telegram")];
  if (f & FLAG.FAULT) return ["bad", `${t("fault")} ${row.fault}`];
  if (f & FLAG.UNCONFIGURED) return ["warn", t("starting up")];
  if (f & FLAG.HOMING) return ["warn", t("referencing")];
  if (f & FLAG.ENABLED) return [f & FLAG.WARNING ? "warn" : "good", t("on")];
  return ["plain", t("off")];
}

export function age(ms) {
  if (ms === null || ms === undefined) return "";
  return ms < 1000 ? `${Math.round(ms)} ms` : ms < 60000 ? `${(ms / 1000).toFixed(1)} s` : `${Math.round(ms / 60000)} min`;
}

// First-out: the error that came first, large, with what to do; the others below it.
export function errors(box, head, t, language) {
  const i = language === "de" ? 1 : 0;
  const list = head.errors.map((error) => ({ code: error.code, text: error.say?.[i] || error.text, do: error.do?.[i], cause: error.cause?.[i], reset: error.reset?.[i] }));
  const missing = [...head.missing.map((each) => t(`permit ${each}`)), ...head.withheld.filter(([, which]) => which.length).map(([robot, which]) => `${robot}: ${which.map((each) => t(`permit ${each}`)).join(", ")}`)];
  const words = JSON.stringify([list, missing, head.stop_text[i], head.ready, i]);
  if (box.dataset.words === words) return;
  box.dataset.words = words;
  const rows = list.map((error, n) => h("div", { class: n ? "later" : "first" },
    h("strong", {}, `${error.code}  ${error.text}`), error.do ? h("p", {}, `${t("What to do")}: ${error.do}`) : null, !n && error.cause ? h("p", { class: "small" }, `${t("Cause")}: ${error.cause}`) : null, !n && error.reset ? h("p", { class: "small" }, `${t("Reset")}: ${error.reset}`) : null));
  if (!rows.length && head.stop_text[i]) rows.push(h("div", { class: "later" }, h("strong", {}, head.stop_text[i])));
  if (!rows.length) rows.push(h("p", { class: "none" }, t("No error is pending.")));
  if (missing.length) rows.push(h("p", { class: "soft" }, `${t("Enabling inputs missing")}: ${missing.join(", ")}`));
  box.replaceChildren(...rows);
}

export function setText(root, selector, words) {
  const element = root.querySelector(selector);
  if (element) put(element, words);
}
