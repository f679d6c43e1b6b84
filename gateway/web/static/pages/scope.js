// Any values at the rate of the cycle, each on a scale of its own: rolling, or by a trigger with what was before it, cursors, one over another; kept, reopened, taken away.
import { Table, chip, grey, h, mark, put, text } from "../dom.js";
import { Plot, colour, drawXy, parse } from "../plot.js";
import { Kept } from "../watch.js";

const MOST = 16;
const FORMS = [["", "at once"], [">", "rises above"], ["<", "falls below"], ["rises", "rises"], ["falls", "falls"], ["changes", "changes"], ["error", "an error appears"]];

export function mount(root, { t, get, post, cell, toast, unable }) {
  const first = cell.axes[0]?.name;
  const remembered = () => { try { return JSON.parse(localStorage.getItem("scope") || "null"); } catch { return null; } };
  const set = { channels: first ? [`axis.${first}.set`, `axis.${first}.actual`, `axis.${first}.lag`] : ["cell.compute_us"], seconds: 5, pre: 1, form: "", at: "", level: "0", window: 10, joint: false, ranges: {}, ...remembered() };
  let recording = null;
  let drawn = -1;
  let state = {};
  let live = null; // what was shown last of a recording that runs
  let hidden = new Set(Array.isArray(set.hidden) ? set.hidden : []);
  let over = false;

  // ---- what is wanted ---------------------------------------------------------------------------------------------------
  const known = h("datalist", { id: "channels-known" });
  const chosen = h("div", { class: "bar", id: "channels" });
  const name = h("input", { list: "channels-known", id: "channel", placeholder: "axis.A1.lag, rc_in.24", "aria-label": t("channel"), onkeydown: (event) => { if (event.key === "Enter") { event.preventDefault(); add(); } } });
  const seconds = h("input", { type: "number", id: "scope-seconds", min: "0.1", max: "600", step: "0.1", value: String(set.seconds), style: "width:6rem" });
  const pre = h("input", { type: "number", id: "scope-pre", min: "0", max: "60", step: "0.1", value: String(set.pre), style: "width:6rem" });
  const form = h("select", { id: "trigger-form", onchange: forms }, FORMS.map(([value, title]) => h("option", { value, selected: value === set.form }, t(title))));
  const at = h("input", { list: "channels-known", id: "trigger-at", value: set.at, placeholder: `axis.${first}.lag`, "aria-label": t("trigger channel") });
  const level = h("input", { type: "number", id: "trigger-level", step: "any", value: String(set.level), style: "width:7rem", "aria-label": t("trigger level") });
  const start = h("button", { type: "button", class: "main", id: "record", onclick: toggle }, t("Record"));
  const view = h("input", { type: "number", id: "scope-window", min: "1", max: "60", step: "1", value: String(set.window), style: "width:5rem" });
  const roll = h("button", { type: "button", id: "roll", onclick: rolls }, t("Roll"));
  const chips = h("span", { role: "status", id: "scope-state", class: "bar", style: "margin:0" });
  function chips_() {
    chosen.replaceChildren(...set.channels.map((each) => h("button", { type: "button", class: "tiny", "data-channel": each, title: t("remove"), disabled: running(), onclick: () => { set.channels = set.channels.filter((other) => other !== each); chips_(); } }, `${each}  \u00d7`)));
  }
  function add() {
    const wanted = name.value.trim();
    if (!wanted || set.channels.includes(wanted)) return;
    if (set.channels.length >= MOST) { toast(t("16 channels at most"), "bad"); return; }
    set.channels.push(wanted);
    name.value = "";
    chips_();
  }
  function forms() {
    at.parentElement.hidden = !form.value || form.value === "error";
    level.parentElement.hidden = !["<", ">"].includes(form.value);
  }
  // A layout: channels with their scales, trigger and times; the last one is the browser's, others are kept on the gateway.
  function layout() {
    Object.assign(set, { seconds: Number(seconds.value) || 1, pre: Number(pre.value) || 0, form: form.value, at: at.value.trim(), level: level.value, window: Number(view.value) || 10, hidden: [...hidden] });
    try { localStorage.setItem("scope", JSON.stringify(set)); } catch { /* no storage */ }
    return set;
  }
  function lay(kept) {
    if (!kept || !Array.isArray(kept.channels)) return;
    Object.assign(set, { joint: false, ranges: {}, hidden: [], window: 10 }, kept, { channels: kept.channels.slice(0, MOST) });
    hidden = new Set(set.hidden);
    for (const [element, value] of [[seconds, set.seconds], [pre, set.pre], [form, set.form], [at, set.at], [level, set.level], [view, set.window]]) element.value = String(value ?? "");
    joint.setAttribute("aria-pressed", String(set.joint));
    chips_(); forms(); layout(); draw(); values();
  }
  const layouts = new Kept({ t, get, post, unable }, "scope", { made: layout, chosen: (kept) => { if (!running()) lay(kept); } });
  const running = () => state.state === "running" || state.state === "waiting";
  function words() {
    if (!form.value) return "";
    if (form.value === "error") return "error";
    return ["<", ">"].includes(form.value) ? `${at.value.trim()} ${form.value} ${Number(level.value)}` : `${at.value.trim()} ${form.value}`;
  }
  async function toggle() {
    if (running()) { await post("/api/scope/stop"); return; }
    layout();
    await post("/api/scope/start", { channels: set.channels, seconds: set.seconds, pre: set.form ? set.pre : 0, trigger: words() });
  }

  async function rolls() {
    if (running()) { await post("/api/scope/stop"); return; }
    layout();
    await post("/api/scope/start", { channels: set.channels, seconds: set.window, rolling: true });
  }

  // ---- what is shown ----------------------------------------------------------------------------------------------------
  const about = h("p", { class: "soft small", id: "scope-about" });
  const box = h("div", { class: "plot", id: "scope-plot" });
  const xy = h("canvas", { class: "xy", id: "scope-xy", hidden: true, role: "img" });
  const plot = new Plot(box, (which, value) => cursor(which, value));
  const times = [0, 1].map((which) => h("input", { type: "number", step: "any", id: `cursor-${"ab"[which]}`, style: "width:8rem", onchange: (event) => cursor(which, event.target.value === "" ? null : Number(event.target.value)) }));
  const pick = (id) => h("select", { id, "aria-label": t(id === "xy-x" ? "across" : "upwards"), onchange: draw });
  const [xAxis, yAxis] = [pick("xy-x"), pick("xy-y")];
  const swap = h("button", { type: "button", id: "xy", "aria-pressed": "false", onclick: () => { over = !over; swap.setAttribute("aria-pressed", String(over)); draw(); } }, t("X-Y plot"));
  const joint = h("button", { type: "button", id: "joint", "aria-pressed": String(set.joint), onclick: () => { set.joint = !set.joint; joint.setAttribute("aria-pressed", String(set.joint)); layout(); draw(); } }, t("One scale for each unit"));
  // Ends of a channel's own scale; empty: those of its values.
  function end(name, which) {
    const input = h("input", { type: "number", step: "any", class: "end", "data-end": `${name} ${which}`, placeholder: t("auto"), "aria-label": `${name}: ${t(which ? "scale to" : "scale from")}`, value: String(set.ranges[name]?.[which] ?? ""), onchange: () => {
      const ends = set.ranges[name] || [null, null];
      ends[which] = input.value === "" || !Number.isFinite(Number(input.value)) ? null : Number(input.value);
      if (ends.every((each) => each === null)) delete set.ranges[name]; else set.ranges[name] = ends;
      layout(); draw();
    } });
    return input;
  }
  const ends = (which) => (row, td) => { if (!td.firstChild) td.append(end(row.name, which)); const wanted = String(set.ranges[row.name]?.[which] ?? ""); if (document.activeElement !== td.firstChild && td.firstChild.value !== wanted) td.firstChild.value = wanted; };
  const table = new Table([
    { title: t("channel"), cell: (row, td) => {
      if (!td.firstChild) td.append(h("label", { class: "legend" }, h("input", { type: "checkbox", checked: !hidden.has(row.name), onchange: (event) => { if (event.target.checked) hidden.delete(row.name); else hidden.add(row.name); layout(); draw(); } }), h("i"), h("span", {}, row.name)));
      td.querySelector("i").style.background = colour(row.n);
    } },
    { title: t("unit"), cell: text((row) => row.unit) },
    { title: "A", n: true, cell: text((row) => row.a) }, { title: "B", n: true, cell: text((row) => row.b) }, { title: "B \u2212 A", n: true, cell: text((row) => row.difference) },
    { title: t("minimum"), n: true, cell: text((row) => row.low) }, { title: t("maximum"), n: true, cell: text((row) => row.high) },
    { title: t("scale from"), cell: ends(0) }, { title: t("scale to"), cell: ends(1) },
  ], (row) => row.name, { label: t("Channels") });

  function cursor(which, value) {
    plot.setCursor(which, value);
    times[which].value = value === null ? "" : value.toFixed(4);
    values();
  }
  const short = (value) => (value === undefined ? "" : Number(value.toPrecision(7)).toString());
  function values() {
    if (!recording?.time.length) return;
    plot.time = recording.time;
    const [a, b] = plot.cursors.map((seconds_) => (seconds_ === null ? null : plot.place(seconds_)));
    table.update(recording.channels.map(([title, unit], n) => {
      const column = recording.columns[n];
      const [va, vb] = [a === null ? undefined : column[a], b === null ? undefined : column[b]];
      return { name: title, unit, n, a: short(va), b: short(vb), difference: a === null || b === null ? "" : short(vb - va), low: short(recording.ranges[n][0]), high: short(recording.ranges[n][1]) };
    }));
  }
  function take(reply) {
    recording = reply;
    recording.ranges = reply.columns.map((column) => { let low = Infinity; let high = -Infinity; for (const value of column) { if (value < low) low = value; if (value > high) high = value; } return [low, high]; });
    for (const each of [xAxis, yAxis]) { const was = each.value; each.replaceChildren(...reply.channels.map(([title]) => h("option", { selected: title === was }, title))); }
    if (reply.channels.length > 1 && yAxis.value === xAxis.value) yAxis.selectedIndex = 1;
    plot.cursors = [null, null];
    times.forEach((each) => { each.value = ""; });
    const period = reply.period_s ? `${(reply.period_s * 1e3).toFixed(0)} ms` : "";
    put(about, `${reply.cell}, ${reply.started.replace("T", " ").slice(0, 19)}, ${reply.time.length} ${t("records")}, ${period}, ${reply.trigger ? `${t("trigger")} ${reply.trigger}` : t("no trigger")}, ${reply.lost ? `${reply.lost} ${t("lost")}` : t("no record lost")}`);
    draw();
    values();
  }
  function draw() {
    if (running() && live) { shown(); return; }
    if (!recording) return;
    plot.rolls = false;
    box.hidden = over; xy.hidden = !over;
    xAxis.hidden = yAxis.hidden = !over;
    if (!over) { plot.show(recording.channels, recording.time, recording.columns, recording.channels.map(([title]) => !hidden.has(title)), set).catch((error) => put(about, error.message)); return; }
    const [x, y] = [xAxis.selectedIndex, yAxis.selectedIndex];
    drawXy(xy, recording.columns[x], recording.columns[y], recording.channels[x].join(" "), recording.channels[y].join(" "));
    xy.setAttribute("aria-label", `${recording.channels[y][0]} / ${recording.channels[x][0]}`);
  }
  // What is there of a recording that runs.
  function shown() {
    const names = live.names.map((each, n) => [each, live.units[n]]);
    plot.rolls = true;
    box.hidden = false; xy.hidden = true;
    plot.show(names, live.tail.t, live.tail.values, names.map(([each]) => !hidden.has(each)), set).catch((error) => put(about, error.message));
    table.update(names.map(([each, unit], n) => ({ name: each, unit, n, a: "", b: "", difference: "", low: short(Math.min(...live.tail.values[n])), high: short(Math.max(...live.tail.values[n])) })));
    put(about, live.rolling ? t("The last seconds before now; ended, they are a recording like any other.") : "");
    box.dataset.rolling = live.rolling ? String(live.tail.t.length) : "";
  }
  async function fetched() {
    const answer = await fetch("/api/scope/file?as=scope");
    if (!answer.ok) return;
    take(parse(await answer.arrayBuffer()));
    box.dataset.records = String(recording.time.length);
  }

  // ---- files --------------------------------------------------------------------------------------------------------------
  const kept = h("select", { id: "kept", "aria-label": t("saved recordings") });
  const label = h("input", { id: "recording-name", maxlength: "60", pattern: "[A-Za-z0-9][A-Za-z0-9_+\\-]*", placeholder: t("name"), "aria-label": t("name"), style: "width:11rem" });
  const keep = h("button", { type: "button", id: "keep", onclick: async () => { if (!label.reportValidity() || !label.value) { label.focus(); return; } const reply = await post("/api/scope/save", { name: label.value }, "The recording is saved"); if (reply) list(reply.saved); } }, t("Save"));
  const reopen = h("button", { type: "button", id: "reopen", onclick: () => post("/api/scope/open", { name: kept.value }) }, t("Reopen"));
  const file = h("input", { type: "file", accept: ".scope", id: "scope-file", hidden: true, onchange: async () => { try { take(parse(await file.files[0].arrayBuffer())); } catch { toast(t("This file is not a recording"), "bad"); } } });
  const taken = ["scope", "csv", "mf4"].map((kind) => h("a", { class: "button", href: `/api/scope/file?as=${kind}`, download: "", id: `take-${kind}` }, kind.toUpperCase()));
  function list(saved) { kept.replaceChildren(...saved.map(({ name: each }) => h("option", {}, each))); openable(); }
  function openable() { grey(reopen, unable("operator") || (kept.value ? "" : t("nothing saved yet"))); } // the names may come behind the last update
  get("/api/scope/names").then((reply) => {
    known.replaceChildren(...[...reply.channels, ...reply.signals].map((each) => h("option", { value: each })));
    list(reply.saved);
  }).catch((error) => put(about, error.message));

  root.append(known, h("section", { class: "card" },
    h("div", { class: "bar low" }, h("label", {}, t("channel"), name), h("button", { type: "button", id: "add-channel", onclick: add }, t("Add")), chosen),
    h("div", { class: "bar low" }, h("label", {}, t("trigger"), form), h("label", {}, t("trigger channel"), at), h("label", {}, t("trigger level"), level),
      h("label", {}, t("before the trigger, s"), pre), h("label", {}, t("after the trigger, s"), seconds), start, h("label", {}, t("window, s"), view), roll, chips),
    h("div", { class: "bar" }, layouts.element)),
  h("section", { class: "card", style: "margin-top:.9rem" },
    h("div", { class: "bar low" }, joint, swap, xAxis, yAxis, h("label", {}, `${t("cursor")} A, s`, times[0]), h("label", {}, `${t("cursor")} B, s`, times[1])),
    box, xy, about, h("p", { class: "soft small" }, t("Click sets cursor A, Shift and click cursor B; drag to zoom, double click to show everything.")), table.element),
  h("section", { class: "card", style: "margin-top:.9rem" }, h("div", { class: "bar", style: "margin:0" }, label, keep, kept, reopen, h("button", { type: "button", onclick: () => file.click() }, t("Open a file")), file, h("span", { class: "soft" }, t("download as")), ...taken)));
  chips_();
  forms();
  return {
    update(page) {
      if (!page || page.gone) return;
      const was = running();
      state = page;
      if (was !== running()) chips_();
      const rolling = running() && page.rolling;
      put(start, running() && !rolling ? t("End the recording") : t("Record"));
      mark(start, running() && !rolling ? "danger" : "main");
      put(roll, rolling ? t("Stop rolling") : t("Roll"));
      mark(roll, rolling ? "danger" : "");
      const unfit = unable("operator");
      grey(start, unfit || (rolling ? t("The scope is rolling: stop it first.") : ""));
      grey(roll, unfit || (running() && !rolling ? t("A recording runs: end it first.") : ""));
      openable();
      grey(keep, unfit || (page.state === "done" ? "" : t("nothing recorded yet")));
      layouts.update();
      const share = page.wanted ? `${Math.min(100, Math.round((100 * page.records) / page.wanted))} %` : "";
      const [kind, reply] = { running: ["warn", page.rolling ? t("rolling") : `${t("recording")} ${share}`], waiting: ["warn", `${t("waiting for")} ${page.trigger}`], done: ["good", `${page.records} ${t("records")}`], none: ["plain", t("nothing recorded yet")] }[page.state];
      chips.replaceChildren(chip(kind, reply), ...(page.lost ? [chip("bad", `${page.lost} ${t("lost")}`)] : []), ...(page.why ? [chip("warn", t(page.why))] : []));
      for (const each of taken) each.classList.toggle("off", page.state !== "done");
      live = running() && page.tail?.t.length > 1 ? page : null;
      if (live && !over) { drawn = -1; shown(); }
      if (page.state === "done" && page.number !== drawn) { drawn = page.number; fetched(); }
    },
    theme: draw,
    unmount() { plot.close(); },
  };
}
