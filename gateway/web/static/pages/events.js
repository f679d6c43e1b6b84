// What happened, and what every number means.
import { Table, chip, facts, h, put, text } from "../dom.js";
import { errors } from "../parts.js";
import { language, say } from "../texts.js";

const FILES = "csv json".split(" ");

export function mount(root, { t, get }) {
  const active = h("div");
  const filter = h("input", { type: "search", placeholder: t("filter"), "aria-label": t("filter"), oninput: () => fill() });
  const kinds = h("select", { "aria-label": t("kind"), onchange: () => fill() }, ["all", "command", "link", "line", "process", "alarm", "force", "output"].map((kind) => h("option", { value: kind === "all" ? "" : kind }, t(kind))));
  let last = [];
  const table = new Table([
    { title: t("time"), n: true, cell: text((row) => (row.wall || "").slice(11, 23)) },
    { title: t("process"), cell: text((row) => row.process) },
    { title: t("kind"), cell: text((row) => t(row.kind)) },
    { title: t("event"), free: true, cell: text((row) => say(row.say)) },
  ], (row) => row.n, { tall: true, label: t("Events"), row: (row) => (row.kind === "alarm" || row.kind === "force" ? "badq" : "") });
  const i = () => (language() === "de" ? 1 : 0);
  const known = new Table([
    { title: t("number"), n: true, cell: text((row) => `${row.family} ${row.code}`) },
    { title: t("text"), free: true, cell: text((row) => row.text[i()]) },
    { title: t("What to do"), free: true, cell: (row, td) => {
      if (td.firstChild) return;
      td.append(h("div", {}, row.do[i()]), h("details", { class: "small" }, h("summary", {}, t("more")),
        facts([[t("Cause"), row.cause[i()]], [t("Reset"), row.reset[i()]], [t("The partner sees"), row.shown[i()]], [t("Source"), row.source]])));
    } },
  ], (row) => `${row.family} ${row.code}`, { tall: true, label: t("Error catalogue") });
  // Alarms over time, kept over restarts.
  const when = (wall) => (wall || "").slice(0, 19).replace("T", " ");
  const alarms = new Table([
    { title: t("raised"), cell: text((row) => when(row.came)) },
    { title: t("acknowledged"), cell: text((row) => (row.acknowledged ? `${when(row.acknowledged)}  ${row.by}` : "")) },
    { title: t("cleared"), cell: (row, td) => { if (row.gone) { put(td, when(row.gone)); return; } if (!td.querySelector(".chip")) td.replaceChildren(chip("bad", t("active"))); } },
    { title: t("number"), n: true, cell: text((row) => row.code) },
    { title: t("Source"), cell: text((row) => row.source) },
    { title: t("text"), free: true, cell: text((row) => row.say?.[i()] || row.text) },
  ], (row) => row.number, { tall: true, label: t("Alarm history"), row: (row) => (row.gone ? (row.acknowledged ? "" : "stale") : "badq") });
  const choice = (id, label, values) => h("select", { id, "aria-label": label, onchange: () => history() }, values.map(([value, title]) => h("option", { value }, title)));
  const word = h("input", { type: "search", id: "alarm-words", placeholder: t("axis, number or word"), "aria-label": t("filter"), oninput: () => { clearTimeout(wait); wait = setTimeout(history, 200); } });
  const state = choice("alarm-state", t("state"), [["", t("all")], ["active", t("active")], ["open", t("not acknowledged")], ["gone", t("cleared")]]);
  const source = choice("alarm-source", t("Source"), [["", t("all sources")]]);
  const from = h("input", { type: "date", id: "alarm-from", "aria-label": t("from day"), onchange: () => history() });
  const to = h("input", { type: "date", id: "alarm-to", "aria-label": t("to day"), onchange: () => history() });
  const count = h("span", { class: "soft", id: "alarm-count", role: "status" });
  const files = FILES.map((kind) => h("a", { class: "button", id: `alarms-${kind}`, download: "" }, kind.toUpperCase()));
  let version = null;
  async function history() {
    const query = new URLSearchParams({ q: word.value, state: state.value, source: source.value, from: from.value, to: to.value });
    files.forEach((file, n) => { file.href = `/api/alarms/file?as=${FILES[n]}&${query}`; });
    try {
      const reply = await get(`/api/alarms?${query}`);
      const was = source.value;
      source.replaceChildren(h("option", { value: "" }, t("all sources")), ...reply.sources.map((each) => h("option", { value: each, selected: each === was }, each)));
      put(count, `${reply.total} ${t("alarms")}`);
      alarms.update(reply.alarms.slice(0, 300));
    } catch (error) { put(count, t(error.message)); }
  }
  let wait = 0;
  const wanted = h("input", { type: "search", id: "catalogue", placeholder: t("number or word"), "aria-label": t("Error catalogue"), oninput: () => { clearTimeout(wait); wait = setTimeout(know, 150); } });
  const know = () => get(`/api/errors?q=${encodeURIComponent(wanted.value)}`).then((reply) => known.update(reply.errors)).catch(() => {});
  const fill = () => table.update(last.filter((row) => (!kinds.value || row.kind === kinds.value) && say(row.say).toLowerCase().includes(filter.value.toLowerCase())).slice(-150).reverse());
  know();
  const gone = h("p", { class: "badq" });
  root.append(h("div", { class: "grid" },
    h("section", { class: "card w12" }, h("h2", {}, t("Errors, first one first")), active),
    h("section", { class: "card w12", id: "alarms" }, h("div", { class: "bar" }, h("h2", { style: "margin:0" }, t("Alarm history")), state, source, from, to, count, h("span", { class: "soft" }, t("download as")), ...files), h("div", { class: "bar" }, word), alarms.element),
    h("section", { class: "card w6" }, h("div", { class: "bar" }, h("h2", { style: "margin:0" }, t("Events")), kinds, filter), gone, table.element),
    h("section", { class: "card w6" }, h("div", { class: "bar" }, h("h2", { style: "margin:0" }, t("Error catalogue")), wanted), known.element)));
  return {
    update(page, head) {
      errors(active, head, t, language());
      put(gone, page?.gone || "");
      if (page && "alarms" in page && page.alarms !== version) { version = page.alarms; history(); }
      if (page?.events) { last = page.events; fill(); }
    },
  };
}
