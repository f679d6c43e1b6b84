// Programs of the old controller: what there is, what runs and in which line, the listing of one.
import { Table, chip, grey, h, mark, put, text } from "../dom.js";
import { asked, sure } from "../parts.js";

const NOT_STARTED = ["subroutine", "PAL"]; // kinds of programs that others use
const LOOK_MS = 1000; // variables are shown for three seconds after they were asked for

export function mount(root, { t, cell, get, me, post, unable }) {
  const listing = h("ol", { class: "listing", id: "listing", tabindex: "0", role: "region", "aria-label": t("Listing") });
  const title = h("h2", { style: "margin:0" }, t("Listing"));
  const follow = h("input", { type: "checkbox", checked: true, id: "follow" });
  const note = h("p", { class: "soft small", id: "listing-note", role: "status" });
  let shown = "";
  let rows = [];
  let processes = [];
  let version = 0;
  let statements = new Set();
  let points = [];
  let breaks = null; // breakpoints of a control without a test system; null: it has none
  let test = null; // of the test system; null: programs of this control have none
  let watched = 0; // run whose variables are shown
  const order = (what, name, done) => post(`/api/program/${what}`, { name }, done);
  const open = async (name, again = false) => {
    if (name === shown && !again) return;
    shown = name;
    put(title, name);
    try {
      const reply = await get(`/api/program?name=${encodeURIComponent(name)}`);
      if (name !== shown) return;
      const faults = new Map(reply.faults.map(([line, severity, words]) => [line, [severity, words]]));
      statements = new Set(reply.statements || []);
      points = (reply.points || []).map(([point, value]) => ({ point, value }));
      rows = reply.lines.map((line, n) => {
        const fault = faults.get(n + 1);
        const stop = statements.has(n + 1) ? h("button", { type: "button", class: "stop", "data-line": String(n + 1), "aria-label": `${t("breakpoint in line")} ${n + 1}`, "aria-pressed": "false", onclick: () => toggle(n + 1) }) : null;
        return h("li", { class: fault ? (fault[0] === "error" ? "wrong" : "doubt") : "" }, stop, h("code", {}, line || " "), fault ? h("span", { class: "fault" }, fault[1]) : null);
      });
      listing.classList.toggle("numbered", reply.lines.every((line, n) => !line || line.trim().startsWith(`${n + 1} `)));
      listing.replaceChildren(...rows);
      put(note, reply.faults.length ? `${reply.file}, ${t("faults")}: ${reply.faults.length}` : reply.file);
    } catch (error) {
      rows = [];
      points = [];
      listing.replaceChildren();
      put(note, t(error.message));
    }
    table.update(points);
    marks();
  };
  const stops = () => ((test ? test.breakpoints : breaks)?.[shown.toUpperCase()] || []);
  const toggle = (line) => ordered("breakpoints", { name: shown, lines: stops().includes(line) ? stops().filter((each) => each !== line) : [...stops(), line].sort((a, b) => a - b) });
  const ordered = (what, body, done) => post(`/api/program/${what}`, body, done);
  function marks() {
    const at = new Set(processes.filter((row) => (row.external || row.program) === shown).map((row) => row.line));
    const held = new Set(stops());
    const done = new Set(processes.filter((row) => row.program === shown && row.done && !["running", "waiting"].includes(row.state)).map((row) => row.done));
    rows.forEach((row, n) => {
      const stop = row.querySelector(".stop");
      if (stop) {
        stop.setAttribute("aria-pressed", String(held.has(n + 1)));
        grey(stop, unable("operator") || (test || breaks ? "" : t("The interpreter does not run.")));
      }
      const last = done.has(n + 1); // executed last before the program was stopped
      if (row.classList.contains("done") !== last) { row.classList.toggle("done", last); row.title = last ? t("executed last") : ""; }
      const now = at.has(n + 1);
      if (row.classList.contains("now") === now) return;
      row.classList.toggle("now", now);
      if (now) { row.setAttribute("aria-current", "step"); if (follow.checked) listing.scrollTop = row.offsetTop - listing.clientHeight / 2; } else row.removeAttribute("aria-current");
    });
  }
  const button = (td, id, words, press) => td.querySelector(`[data-do=${id}]`) || td.appendChild(h("button", { type: "button", "data-do": id, onclick: press }, words));
  const waiting = (row) => { // what another process has, and which one: semaphore ZONE, held by PICK line 12
    if (!row.holder) return t(row.waits);
    const [what, name] = row.held.split(" ");
    const reply = `${t(what)} ${name}, ${t("held by")} ${row.holder.replace(" line ", ` ${t("line")} `).replace("(branch)", `(${t("branch")})`)}`;
    return row.stuck ? `${t("blocked, they wait for each other")}: ${reply}` : reply;
  };
  const programs = new Table([
    { title: t("program"), free: true, cell: (row, td) => { const link = td.firstElementChild || td.appendChild(h("button", { type: "button", class: "value", onclick: () => open(row.name) })); put(link, row.name); } },
    { title: "", cell: (row, td) => {
      if (NOT_STARTED.includes(row.kind)) return;
      const start = button(td, "start", t("Start"), () => order("start", row.name, "The program is started"));
      start.setAttribute("data-program", row.name);
      grey(start, unable("operator") || (row.fault ? t("The program has errors.") : ""));
      if (!test) return;
      const tested = button(td, "test", t("Test"), () => ordered("test", { name: row.name, hold: !(test.breakpoints[row.name] || []).length }, "The program is started in test"));
      tested.setAttribute("data-program", row.name);
      grey(tested, unable("operator") || (row.fault ? t("The program has errors.") : ""));
    } },
    { title: t("kind"), cell: text((row) => t(row.kind)) },
    { title: t("state"), free: true, cell: (row, td) => {
      const states = processes.filter((each) => each.program === row.name).map((each) => each.state);
      const rests = states.length && states.every((each) => ["stopped", "held"].includes(each));
      const words = row.fault ? `${t("faults")}: ${row.errors}` : rests ? t(states.includes("held") ? "held" : "stopped") : states.length ? t("running") : t("can run");
      const kind = row.fault ? "bad" : states.length && !rests ? "good" : "";
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
      if (!test || row.branch) return;
      const see = button(td, "see", t("Variables"), () => { watched = watched === row.run ? 0 : row.run; look(); });
      see.setAttribute("aria-pressed", String(watched === row.run));
    } },
    { title: t("kind"), cell: text((row) => (tested(row) ? `${t(row.kind)}, ${t("test")}` : t(row.kind))) },
    { title: t("line"), n: true, cell: text((row) => row.line) },
    { title: t("waits for"), free: true, cell: text((row) => (row.state === "held" ? t("held") : waiting(row))) },
  ], (row) => `${row.run} ${row.program} ${row.kind}`, { label: t("Processes"), row: (row) => (row.program === shown ? "chosen" : "") });
  const whose = h("p", { class: "soft small", id: "whose" });
  const gone = h("p", { class: "badq", id: "programs-gone" });
  const tested = (row) => Boolean(test?.tested.some((each) => each.run === row.run));

  // ---- test: one process at a time, the one whose variables are shown, or else the first
  const subject = () => processes.find((row) => row.run === watched && !row.branch && tested(row)) || processes.find((row) => !row.branch && tested(row));
  const step = (how) => { const row = subject(); if (row) ordered("step", { run: row.run, how }); };
  const steps = [["run", "Continue"], ["into", "Step"], ["over", "Step over calls"], ["out", "Step out"], ["hold", "Hold"]].map(([how, words]) => h("button", { type: "button", "data-step": how, onclick: () => step(how) }, t(words)));
  const movement = h("input", { type: "checkbox", id: "movement", checked: true, onchange: async () => { if (!(await ordered("movement", { on: movement.checked }))) movement.checked = test?.movement !== false; } });
  const tests = h("p", { class: "soft small", id: "tests" });
  const variables = new Table([
    { title: t("in"), cell: text((row) => row.where) },
    { title: t("name"), cell: text((row) => row.name) },
    { title: t("type"), cell: text((row) => row.kind) },
    { title: t("value"), free: true, cell: (row, td) => {
      const set = button(td, "set", "", (event) => change(event.currentTarget.row));
      set.setAttribute("data-name", row.name);
      if (!set.classList.contains("value")) set.className = "value";
      put(set, row.value === "" ? t("not defined") : row.value);
      set.row = row;
      grey(set, unable("setter") || (row.settable ? "" : t("Variables of the program are set while its process is held.")));
    } },
  ], (row) => `${row.where} ${row.name}`, { tall: true, label: t("Variables") });
  async function change(row) {
    const value = await asked(t, `${row.name} (${row.kind})`, row.value, "store", 200);
    if (value !== null) ordered("variable", { run: watched, program: row.where, name: row.name, value }, "The variable is set");
  }
  async function look() {
    if (watched && !document.hidden) await get(`/api/program/look?run=${watched}`).catch(() => {});
  }
  const timer = setInterval(look, LOOK_MS);

  // ---- points of the program that is shown
  const table = new Table([
    { title: t("point"), cell: text((row) => row.point) },
    { title: t("value"), free: true, cell: (row, td) => {
      const set = button(td, "define", "", () => define(row.point));
      set.className = "value";
      set.setAttribute("data-point", row.point);
      put(set, row.value === "" ? t("not defined") : row.value);
      grey(set, unable("setter"));
    } },
    { title: "", cell: (row, td) => {
      const teach = button(td, "teach", t("Teach"), () => take(row.point));
      teach.setAttribute("data-point", row.point);
      grey(teach, unable("setter"));
    } },
  ], (row) => row.point, { tall: true, label: t("Points") });
  const stored = (point) => points.find((row) => row.point === point)?.value || "";
  async function take(point) {
    if (stored(point) && !(await sure(t, `${point} = ${stored(point)}: ${t("overwrite with the actual position?")}`, "overwrite"))) return;
    if (await ordered("teach", { name: shown, point }, "The point is taught")) await points_again();
  }
  async function define(point) {
    const value = await asked(t, `${point}`, stored(point), "store", 200);
    if (value !== null && (await ordered("define", { name: shown, point, value }, "The point is set"))) await points_again();
  }
  async function points_again() {
    const reply = await get(`/api/program?name=${encodeURIComponent(shown)}`).catch(() => null);
    if (reply && reply.points) { points = reply.points.map(([point, value]) => ({ point, value })); table.update(points); }
  }
  const looked = h("h2", {}, t("Variables"));
  const system = h("section", { class: "card w5", id: "test-system", hidden: true }, h("h2", {}, t("Test system")), tests,
    h("div", { class: "bar" }, steps, h("label", { class: "legend" }, movement, ` ${t("with movement")}`)), looked, variables.element);
  const places = h("section", { class: "card w7", id: "points", hidden: true }, h("h2", {}, t("Points")), table.element,
    h("p", { class: "soft small" }, t("Teach stores the actual position; the kinematic is in manual then.")));
  // ---- a variable by its name, in three notations
  const wanted = h("input", { type: "text", id: "variable", maxlength: "64", autocomplete: "off", "aria-label": t("variable"), placeholder: "I_N, V1.X, _SPS[6]" });
  const answer = h("dl", { id: "value", class: "facts" });
  const ask = async (event) => { event?.preventDefault(); const name = wanted.value.trim(); if (name) await get(`/api/program/value?name=${encodeURIComponent(name)}`).catch(() => {}); };
  const strides = [["into", "Step"], ["over", "Step over calls"], ["out", "Step out"]].map(([how, words]) => h("button", { type: "button", "data-stride": how, onclick: () => ordered("step", { name: processes.length ? "" : shown, how }) }, t(words)));
  const single = h("section", { class: "card w5", id: "single", hidden: true }, h("h2", {}, t("Single step")), h("div", { class: "bar" }, strides), h("h2", {}, t("Variables")),
    h("form", { class: "bar", onsubmit: ask }, wanted, h("button", { type: "submit" }, t("Show"))), answer,
    h("p", { class: "soft small" }, t("A breakpoint stops the program in front of its step; Start continues. Single steps need one of the modes Test 1 to 6 (page Pendant). A step over calls executes a sub-program or macro to its end.")));
  const looking = setInterval(() => { if (!document.hidden && !single.hidden) ask(); }, LOOK_MS);
  function one(value) {
    const name = wanted.value.trim().toUpperCase();
    if (!value || !name || value.name !== name) { answer.replaceChildren(); return; }
    const whole = Number.isInteger(value.value);
    const bits = whole ? value.value >>> 0 : 0;
    const rows = value.text ? [["", value.text]] : whole ? [["dec", String(value.value)], ["hex", `${bits.toString(16).toUpperCase()}H`], ["bin", `${bits.toString(2)}B`]] : [["", value.value === null ? t("no value") : String(value.value)]];
    if (answer.dataset.shown === JSON.stringify(rows) && answer.childElementCount) return;
    answer.dataset.shown = JSON.stringify(rows);
    answer.replaceChildren(...rows.flatMap(([term, words]) => [h("dt", {}, term || value.name), h("dd", {}, words)]));
  }
  root.append(h("div", { class: "grid" },
    h("section", { class: "card w5" }, h("h2", {}, `${t("Programs")}: ${cell.programs}`), gone, programs.element, whose, h("h2", {}, t("Processes")), running.element),
    h("section", { class: "card w7" }, h("div", { class: "bar" }, title, h("label", { class: "legend" }, follow, ` ${t("follow the current line")}`), h("button", { type: "button", id: "reread", onclick: () => shown && open(shown, true) }, t("Read again"))), note, listing),
    single, system, places));
  return {
    update(page) {
      put(whose, me.holds ? t("A started program moves under the control of this page and stops when the page is closed.") : t("A started program moves when the PLC has control; to move it from here, request control on the page Axes."));
      if (!page) return;
      put(gone, page.gone || (page.id ? "" : t("The interpreter does not run.")));
      if (page.gone) return;
      processes = page.processes;
      test = page.test || null;
      breaks = page.breaks || null;
      single.hidden = !breaks;
      one(page.value);
      for (const each of strides) grey(each, unable("operator") || (processes.some((row) => row.run) ? t("The program runs.") : ""));
      if (watched && !processes.some((row) => row.run === watched)) watched = 0;
      if (!watched && subject()) { watched = subject().run; look(); }
      draw(page);
      const system = (row) => row.name.startsWith("$"); // those that the control brings follow the plant's
      const listed = [...page.programs.filter((row) => !system(row)), ...page.programs.filter(system)];
      programs.update(listed);
      running.update(processes);
      if (!shown && listed.length) open((listed.find((row) => row.name === processes[0]?.program) || listed.find((row) => row.kind === "MPR") || listed[0]).name);
      if (page.id !== version) { if (version && shown) open(shown, true); version = page.id; }
      marks();
    },
    unmount() { clearInterval(timer); clearInterval(looking); },
  };

  function draw(page) {
    system.hidden = !test;
    places.hidden = !test;
    if (!test) return;
    if (document.activeElement !== movement && movement.checked !== test.movement) movement.checked = test.movement;
    movement.disabled = Boolean(unable("setter"));
    const row = subject();
    put(tests, row ? `${row.program}, ${t("line")} ${row.line}: ${row.state === "held" ? t("held") : t("running")}` : t("No process is in test. Breakpoints hold processes that were started in test."));
    for (const each of steps) grey(each, unable("operator") || (!row ? t("No process is in test.") : (each.dataset.step === "hold") === (row.state === "held") ? t(row.state === "held" ? "The process is held." : "The process runs.") : ""));
    const seen = page.looked === watched && watched ? (page.variables || []).map(([where, name, kind, value, settable]) => ({ where, name, kind, value, settable })) : [];
    put(looked, watched ? `${t("Variables")}: ${processes.find((each) => each.run === watched)?.program || ""}` : t("Variables"));
    variables.update(seen);
  }
}
