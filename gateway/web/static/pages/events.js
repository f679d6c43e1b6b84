// What happened, and what every number means.
import { Table, facts, h, put, text } from "../dom.js";
import { errors } from "../parts.js";
import { language } from "../texts.js";

export function mount(root, { t, get }) {
  const standing = h("div");
  const filter = h("input", { type: "search", placeholder: t("filter"), "aria-label": t("filter"), oninput: () => fill() });
  const kinds = h("select", { "aria-label": t("kind"), onchange: () => fill() }, ["all", "command", "link", "line", "process", "alarm", "force", "output"].map((kind) => h("option", { value: kind === "all" ? "" : kind }, t(kind))));
  let last = [];
  const table = new Table([
    { title: t("time"), n: true, cell: text((row) => (row.wall || "").slice(11, 23)) },
    { title: t("process"), cell: text((row) => row.process) },
    { title: t("kind"), cell: text((row) => t(row.kind)) },
    { title: t("event"), free: true, cell: text((row) => row.text) },
  ], (row) => row.n, { tall: true, label: t("Events"), row: (row) => (row.kind === "alarm" || row.kind === "force" ? "badq" : "") });
  const i = () => (language() === "de" ? 1 : 0);
  const known = new Table([
    { title: t("number"), n: true, cell: text((row) => `${row.family} ${row.code}`) },
    { title: t("text"), free: true, cell: text((row) => row.text[i()]) },
    { title: t("What to do"), free: true, cell: (row, td) => {
      if (td.firstChild) return;
      td.append(h("div", {}, row.do[i()]), h("details", { class: "small" }, h("summary", {}, t("more")),
        facts([[t("Cause"), row.cause[i()]], [t("Goes away"), row.reset[i()]], [t("The partner sees"), row.shown[i()]], [t("Source"), row.source]])));
    } },
  ], (row) => `${row.family} ${row.code}`, { tall: true, label: t("Error catalogue") });
  let wait = 0;
  const wanted = h("input", { type: "search", id: "catalogue", placeholder: t("number or word"), "aria-label": t("Error catalogue"), oninput: () => { clearTimeout(wait); wait = setTimeout(know, 150); } });
  const know = () => get(`/api/errors?q=${encodeURIComponent(wanted.value)}`).then((told) => known.update(told.errors)).catch(() => {});
  const fill = () => table.update(last.filter((row) => (!kinds.value || row.kind === kinds.value) && row.text.toLowerCase().includes(filter.value.toLowerCase())).slice(-150).reverse());
  know();
  const gone = h("p", { class: "badq" });
  root.append(h("div", { class: "grid" },
    h("section", { class: "card w12" }, h("h2", {}, t("Errors, first one first")), standing),
    h("section", { class: "card w6" }, h("div", { class: "bar" }, h("h2", { style: "margin:0" }, t("Events")), kinds, filter), gone, table.element),
    h("section", { class: "card w6" }, h("div", { class: "bar" }, h("h2", { style: "margin:0" }, t("Error catalogue")), wanted), known.element)));
  return {
    update(page, head) {
      errors(standing, head, t, language());
      put(gone, page?.gone || "");
      if (page?.events) { last = page.events; fill(); }
    },
  };
}
