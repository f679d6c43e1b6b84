// Programs of the old control: what there is, what runs and in which line, the listing of one.
import { Table, chip, grey, h, mark, put, text } from "../dom.js";

export function mount(root, { t, cell, get, me, post, unable }) {
  const listing = h("ol", { class: "listing", id: "listing", tabindex: "0", role: "region", "aria-label": t("Listing") });
  const title = h("h2", { style: "margin:0" }, t("Listing"));
  const follow = h("input", { type: "checkbox", checked: true, id: "follow" });
  const note = h("p", { class: "soft small", id: "listing-note", role: "status" });
  let shown = "";
  let rows = [];
  let processes = [];
  let version = 0;
  const order = (what, name, done) => post(`/api/program/${what}`, { name }, done);
  const open = async (name, again = false) => {
    if (name === shown && !again) return;
    shown = name;
    put(title, name);
    try {
      const told = await get(`/api/program?name=${encodeURIComponent(name)}`);
      if (name !== shown) return;
      const faults = new Map(told.faults.map(([line, severity, words]) => [line, [severity, words]]));
      rows = told.lines.map((line, n) => {
        const fault = faults.get(n + 1);
        return h("li", { class: fault ? (fault[0] === "error" ? "wrong" : "doubt") : "" }, h("code", {}, line || " "), fault ? h("span", { class: "fault" }, fault[1]) : null);
      });
      listing.replaceChildren(...rows);
      put(note, told.faults.length ? `${told.file}, ${t("faults")}: ${told.faults.length}` : told.file);
    } catch (error) {
      rows = [];
      listing.replaceChildren();
      put(note, t(error.message));
    }
    marks();
  };
  function marks() {
    const at = new Set(processes.filter((row) => row.program === shown).map((row) => row.line));
    rows.forEach((row, n) => {
      const now = at.has(n + 1);
      if (row.classList.contains("now") === now) return;
      row.classList.toggle("now", now);
      if (now) { row.setAttribute("aria-current", "step"); if (follow.checked) listing.scrollTop = row.offsetTop - listing.clientHeight / 2; } else row.removeAttribute("aria-current");
    });
  }
  const button = (td, id, words, press) => td.querySelector(`[data-do=${id}]`) || td.appendChild(h("button", { type: "button", "data-do": id, onclick: press }, words));
  const programs = new Table([
    { title: t("program"), cell: (row, td) => { const link = td.firstElementChild || td.appendChild(h("button", { type: "button", class: "value", onclick: () => open(row.name) })); put(link, row.name); } },
    { title: "", cell: (row, td) => {
      const start = button(td, "start", t("Start"), () => order("start", row.name, "The program is started"));
      start.setAttribute("data-program", row.name);
      grey(start, unable("operator") || (row.fault ? t("The program has errors.") : ""));
    } },
    { title: t("kind"), cell: text((row) => t(row.kind)) },
    { title: t("state"), free: true, cell: (row, td) => {
      const runs = processes.some((each) => each.program === row.name);
      const words = row.fault ? `${t("faults")}: ${row.errors}` : runs ? t("running") : t("can run");
      const kind = row.fault ? "bad" : runs ? "good" : "";
      const box = td.firstElementChild || td.appendChild(chip(kind, words));
      mark(box, `chip ${kind}`); put(box, words); if (box.title !== row.fault) box.title = row.fault;
    } },
  ], (row) => row.name, { tall: true, label: t("Programs") });
  const running = new Table([
    { title: t("process"), cell: (row, td) => { const link = td.firstElementChild || td.appendChild(h("button", { type: "button", class: "value", onclick: () => open(row.program) })); put(link, row.program); } },
    { title: "", cell: (row, td) => {
      const stop = button(td, "stop", t("Stop"), () => order("stop", row.program, "The program is stopped"));
      stop.setAttribute("data-program", row.program);
      grey(stop, unable("operator"));
    } },
    { title: t("kind"), cell: text((row) => t(row.kind)) },
    { title: t("line"), n: true, cell: text((row) => row.line) },
    { title: t("waits for"), free: true, cell: text((row) => row.waits) },
  ], (row) => `${row.run} ${row.program} ${row.kind}`, { label: t("Processes"), row: (row) => (row.program === shown ? "chosen" : "") });
  const whose = h("p", { class: "soft small", id: "whose" });
  const gone = h("p", { class: "badq", id: "programs-gone" });
  root.append(h("div", { class: "grid" },
    h("section", { class: "card w5" }, h("h2", {}, `${t("Programs")}: ${cell.programs}`), gone, programs.element, whose, h("h2", {}, t("Processes")), running.element),
    h("section", { class: "card w7" }, h("div", { class: "bar" }, title, h("label", { class: "legend" }, follow, ` ${t("follow the current line")}`), h("button", { type: "button", id: "reread", onclick: () => shown && open(shown, true) }, t("Read again"))), note, listing)));
  return {
    update(page) {
      put(whose, me.holds ? t("A started program moves as the page, and stops when this page is closed.") : t("A started program moves when the PLC has control; to move it from here, request control on the page Axes."));
      if (!page) return;
      put(gone, page.gone || (page.id ? "" : t("The interpreter does not run.")));
      if (page.gone) return;
      processes = page.processes;
      programs.update(page.programs);
      running.update(processes);
      if (!shown && page.programs.length) open((processes[0]?.program && page.programs.some((row) => row.name === processes[0].program)) ? processes[0].program : page.programs[0].name);
      if (page.id !== version) { if (version && shown) open(shown, true); version = page.id; }
      marks();
    },
  };
}
