// Frames decoded, rates, load, error counters.
import { Table, chip, h, mark, put, text } from "../dom.js";
import { say } from "../texts.js";

export function mount(root, { t, cell }) {
  const boxes = new Map();
  if (!cell.buses.length) root.append(h("p", { class: "soft" }, t("The cell has no bus.")));
  for (const bus of cell.buses) {
    const state = chip("plain", t("opening"));
    const load = h("div", { class: "meter", style: "width:12rem" }, h("b", { style: "left:0;width:0" }));
    const figures = h("span", { class: "mono" });
    const table = new Table([
      { title: t("identifier"), n: true, cell: text((row) => row.id) },
      { title: t("rate /s"), n: true, cell: text((row) => row.rate, 1) },
      { title: t("frames"), n: true, cell: text((row) => row.count) },
      { title: t("shortest ms"), n: true, cell: text((row) => row.min_ms, 2) },
      { title: t("longest ms"), n: true, cell: text((row) => row.max_ms, 2) },
      { title: t("bytes"), cell: (row, td) => { put(td, row.data); mark(td, "whole"); } },
      { title: t("decoded"), cell: (row, td) => { put(td, say(row.say)); mark(td, "mono small"); } },
    ], (row) => row.id, { label: `${t("Bus")} ${bus.name}` });
    const list = h("pre", { class: "scroll", style: "max-height:16rem", tabindex: "0" });
    boxes.set(bus.name, { state, load, figures, table, list });
    root.append(h("section", { class: "card bus", style: "margin-bottom:.9rem" },
      h("div", { class: "bar" }, h("h2", { style: "margin:0" }, `${bus.name}: ${bus.protocol}`), state, h("span", { class: "soft" }, `${bus.bitrate}   ${bus.played}`), bus.listens ? chip("warn", t("listens only")) : null, load, figures),
      table.element, h("details", {}, h("summary", {}, t("The last frames one by one")), list)));
  }
  const cycle = h("p", { class: "mono small" });
  root.append(cycle);
  return {
    update(page) {
      if (!page || page.gone) return;
      for (const bus of page.buses) {
        const box = boxes.get(bus.name);
        if (!box) continue;
        put(box.state, bus.open ? t("listening") : say(bus.why));
        mark(box.state, `chip ${bus.open ? "good" : "bad"}`);
        box.load.firstChild.style.width = `${Math.min(100, bus.load)}%`;
        box.load.title = `${t("load")} ${bus.load} %`;
        put(box.figures, `${t("load")} ${bus.load} %   ${bus.rate} ${t("frames/s")}   ${t("error frames")} ${bus.faults}`);
        box.table.update(bus.rows);
        put(box.list, bus.frames.map(([ms, id, data, words]) => `${ms.toFixed(3).padStart(9)} ms ${id.padStart(14)}  ${data.padEnd(24)} ${say(words)}`).join("\n"));
      }
      const c = page.cycle;
      put(cycle, `${t("cycle")}: ${t("skipped")} ${c.skipped}   ${t("incomplete")} ${c.incomplete}   ${t("late")} ${c.late}`);
    },
  };
}
