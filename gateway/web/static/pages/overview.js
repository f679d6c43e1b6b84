// Is everything there, and if not: what came first, and what to do.
import { Table, chip, h, mark, put, text, trended } from "../dom.js";
import { drive, errors, age } from "../parts.js";
import { language, say } from "../texts.js";

export function mount(root, { t, cell }) {
  let old = false;
  const first = h("div", { id: "first-out" });
  const processes = new Table([
    { title: t("process"), cell: text((row) => row.name) },
    { title: t("state"), cell: (row, td) => state(td, row.state === "up" ? "good" : "bad", t(row.state)) },
    { title: t("restarts"), n: true, cell: text((row) => row.restarts) },
    { title: t("life"), n: true, cell: text((row) => age(row.life_age_ms)) },
  ], (row) => row.name, { label: t("Processes") });
  const links = new Table([
    { title: t("link"), cell: text((row) => `${row.number} ${row.name}`) },
    { title: t("state"), cell: (row, td) => state(td, old ? "warn" : row.alive ? "good" : "bad", old ? t("not known") : row.alive ? t("alive") : t("silent")) },
    { title: t("losses"), n: true, cell: text((row) => row.losses) },
    { title: t("last command"), cell: text((row) => `${row.state === "NONE" ? "" : t(row.state.toLowerCase())}${row.reason === "NONE" ? "" : `: ${say(row.because)}`}`) },
    { title: t("advice"), cell: text((row) => [say(row.why), say(row.advice)].filter(Boolean).join("; ")) },
  ], (row) => row.number, { label: t("Links"), row: () => (old ? "stale" : "") });
  const drives = new Table([
    { title: t("axis"), cell: text((row) => row.name) },
    { title: t("drive"), cell: (row, td) => { const [kind, words] = drive(row, t); state(td, kind, words); } },
    { title: t("actual"), n: true, cell: trended((row) => `axis.${row.name}.actual`, (row) => row.actual, 3) },
    { title: t("lag"), n: true, cell: trended((row) => `axis.${row.name}.lag`, (row) => row.lag, 3) },
  ], (row) => row.name, { label: t("Drives") });
  const cycle = h("div", { class: "small mono", id: "cycle" });
  const evidence = new Table([
    { title: t("what"), cell: text((row) => say(row.what)) },
    { title: t("level"), cell: (row, td) => state(td, row.level === "plant" || row.level === "bench" ? "good" : "warn", t(row.level)) },
    { title: t("by"), cell: text((row) => say(row.why)) },
  ], (row) => `${row.what[0]} ${row.why[0]}`, { label: t("Evidence") });
  evidence.update(cell.evidence);
  root.append(h("div", { class: "grid" },
    h("section", { class: "card w12" }, h("h2", {}, t("Errors, first one first")), first),
    h("section", { class: "card w6" }, h("h2", {}, t("Links")), links.element),
    h("section", { class: "card w6" }, h("h2", {}, t("Drives")), drives.element),
    h("section", { class: "card w6" }, h("h2", {}, t("Processes")), processes.element, cycle),
    h("section", { class: "card w6" }, h("h2", {}, t("Evidence")), evidence.element)));
  return {
    update(page, head) {
      errors(first, head, t, language());
      old = !head.services_alive;
      if (!page || page.gone) return;
      processes.update(page.processes);
      links.update(page.command_sources);
      drives.update(page.drives);
      const c = page.cycle;
      put(cycle, `P5 ${c.p5_ms} ms   ${t("cycles")} ${c.cycles}   ${t("skipped")} ${c.skipped}   ${t("incomplete")} ${c.incomplete}   ${t("late")} ${c.late}   ${t("computing")} ${c.compute_us} us`);
    },
  };
}

function state(td, kind, words) {
  let child = td.firstChild;
  if (!child) { child = chip(kind, words); td.append(child); }
  put(child, words);
  mark(child, `chip ${kind}`);
}
