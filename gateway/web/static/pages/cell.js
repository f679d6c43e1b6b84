// What hangs where, how it is wired, what `check` says.
import { Table, chip, facts, h, text } from "../dom.js";
import { say } from "../texts.js";

export function mount(root, { t, cell }) {
  const made = (columns, rows, key) => { const table = new Table(columns, key, {}); table.update(rows); return table.element; };
  const plain = (names) => names.map(([name, title, n]) => ({ title: t(title), n, free: ["text", "why", "comment"].includes(name), cell: text((row) => say(row[name])) }));
  let number = 0;
  const counted = (rows) => rows.map((row) => ({ ...row, number: row.number ?? (number += 1) }));
  const level = { title: t("level"), cell: (row, td) => td.append(chip(row.level === "warning" ? "warn" : "plain", t(row.level))) };
  const notices = counted(cell.notices.map((notice, i) => ({ ...notice, i })));
  root.append(h("div", { class: "grid" },
    h("section", { class: "card w5" }, h("h2", {}, t("Cell")), facts([[t("name"), cell.name], [t("file"), say(cell.file)], [t("replaces"), cell.replaces || "-"], [t("target"), t(cell.target)], [t("clock"), `${cell.p5_ms} ms`], [t("command sources"), cell.command_sources.map((source) => `${source.number} ${source.name}`).join(", ") || "-"],
      ...cell.safety.map(([name, value]) => [say(name), say(value)])])),
    h("section", { class: "card w7" }, h("h2", {}, t("Results of check")), notices.length ? made([level, ...plain([["where", "where"], ["text", "text"]])], notices, (row) => row.i) : h("p", { class: "none" }, t("no findings"))),
    h("section", { class: "card w12" }, h("h2", {}, t("Axes")), made(plain([["name", "axis"], ["drive", "drive"], ["bus", "bus"], ["node", "address", true], ["unit", "unit"], ["min", "min", true], ["max", "max", true], ["speed", "speed", true], ["accel", "acceleration", true], ["gear", "gear"], ["home", "reference by"]]), cell.axes, (row) => row.name)),
    h("section", { class: "card w6" }, h("h2", {}, t("Lines")), made(plain([["name", "name"], ["port", "port"], ["format", "format"], ["profile", "profile"], ["layer", "layer"], ["role", "role"]]), cell.lines, (row) => row.name),
      h("h2", { style: "margin-top:.8rem" }, t("Buses")), made(plain([["name", "name"], ["port", "port"], ["protocol", "protocol"], ["bitrate", "bit rate"], ["cycle_ms", "cycle ms", true]]), cell.buses, (row) => row.name),
      h("h2", { style: "margin-top:.8rem" }, "Modbus"), made(plain([["name", "name"], ["bind", "address"], ["unit", "unit", true]]), cell.modbus, (row) => row.name)),
    h("section", { class: "card w6" }, h("h2", {}, t("Data blocks")), made(plain([["number", "number", true], ["kind", "type"], ["words", "words", true], ["writer", "writer"], ["line", "line"], ["comment", "comment"]]), cell.blocks.map((row, i) => ({ ...row, i })), (row) => row.i),
      cell.routes?.length ? h("h2", { style: "margin-top:.8rem" }, t("Routes")) : null, cell.routes?.length ? made(plain([["name", "name"], ["from", "from"], ["to", "to"], ["edge", "edge"], ["on_loss", "on loss"]]), cell.routes.map((row, i) => ({ ...row, i })), (row) => row.i) : null,
      h("h2", { style: "margin-top:.8rem" }, t("Evidence")), made([{ title: t("what"), cell: text((row) => say(row.what)) }, { title: t("level"), cell: (row, td) => td.append(chip("warn", t(row.level))) }, { title: t("by"), cell: text((row) => say(row.why)) }], cell.evidence, (row) => `${row.what[0]} ${row.why[0]}`)),
    h("section", { class: "card w12" }, h("div", { class: "bar spread" }, h("h2", { style: "margin:0" }, t("Wiring table")), h("button", { type: "button", onclick: () => print() }, t("Print"))), made(plain([["from", "from"], ["to", "to"], ["how", "how"], ["signal", "signal"]]), cell.wiring.map((row, i) => ({ ...row, i })), (row) => row.i))));
  for (const table of root.querySelectorAll("td")) if (table.childNodes.length > 1) table.replaceChildren(table.firstChild);
  return {};
}
