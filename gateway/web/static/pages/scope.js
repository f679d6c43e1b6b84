// Any values at the rate of the cycle: trigger with what was before it, cursors, one over another; kept, reopened, taken away.
import { Table, chip, h, mark, put, text } from "../dom.js";
import { Plot, colour, drawXy, parse } from "../plot.js";

const MOST = 16;
const FORMS = [["", "at once"], [">", "passes upwards"], ["<", "passes downwards"], ["rises", "rises"], ["falls", "falls"], ["changes", "changes"], ["error", "an error appears"]];

export function mount(root, { t, get, post, cell, may, toast }) {
  const first = cell.axes[0]?.name;
  const remembered = () => { try { return JSON.parse(localStorage.getItem("scope") || "null"); } catch { return null; } };
  const set = { channels: first ? [`axis.${first}.set`, `axis.${first}.actual`, `axis.${first}.lag`] : ["cell.compute_us"], seconds: 5, pre: 1, form: "", at: "", level: "0", ...remembered() };
  let recording = null;
  let drawn = -1;
  let state = {};
  let hidden = new Set();
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
  const running = () => state.state === "running" || state.state === "waiting";
  function words() {
    if (!form.value) return "";
    if (form.value === "error") return "error";
    return ["<", ">"].includes(form.value) ? `${at.value.trim()} ${form.value} ${Number(level.value)}` : `${at.value.trim()} ${form.value}`;
  }
  async function toggle() {
    if (running()) { await post("/api/scope/stop"); return; }
    Object.assign(set, { seconds: Number(seconds.value) || 1, pre: Number(pre.value) || 0, form: form.value, at: at.value.trim(), level: level.value });
    try { localStorage.setItem("scope", JSON.stringify(set)); } catch { /* no storage */ }
    await post("/api/scope/start", { channels: set.channels, seconds: set.seconds, pre: set.form ? set.pre : 0, trigger: words() });
  }

  // ---- what is shown ----------------------------------------------------------------------------------------------------
  const about = h("p", { class: "soft small", id: "scope-about" });
  const box = h("div", { class: "plot", id: "scope-plot" });
  const xy = h("canvas", { class: "xy", id: "scope-xy", hidden: true, role: "img" });
  const plot = new Plot(box, (which, value) => cursor(which, value));
  const times = [0, 1].map((which) => h("input", { type: "number", step: "any", id: `cursor-${"ab"[which]}`, style: "width:8rem", onchange: (event) => cursor(which, event.target.value === "" ? null : Number(event.target.value)) }));
  const pick = (id) => h("select", { id, "aria-label": id, onchange: draw });
  const [xAxis, yAxis] = [pick("xy-x"), pick("xy-y")];
  const swap = h("button", { type: "button", id: "xy", "aria-pressed": "false", onclick: () => { over = !over; swap.setAttribute("aria-pressed", String(over)); draw(); } }, t("One over another"));
  const table = new Table([
    { title: t("channel"), cell: (row, td) => {
      if (!td.firstChild) td.append(h("label", { class: "legend" }, h("input", { type: "checkbox", checked: true, onchange: (event) => { if (event.target.checked) hidden.delete(row.name); else hidden.add(row.name); draw(); } }), h("i"), h("span", {}, row.name)));
      td.querySelector("i").style.background = colour(row.n);
    } },
    { title: t("unit"), cell: text((row) => row.unit) },
    { title: "A", n: true, cell: text((row) => row.a) }, { title: "B", n: true, cell: text((row) => row.b) }, { title: "B \u2212 A", n: true, cell: text((row) => row.difference) },
    { title: t("least"), n: true, cell: text((row) => row.low) }, { title: t("greatest"), n: true, cell: text((row) => row.high) },
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
  function take(told) {
    recording = told;
    recording.ranges = told.columns.map((column) => { let low = Infinity; let high = -Infinity; for (const value of column) { if (value < low) low = value; if (value > high) high = value; } return [low, high]; });
    for (const each of [xAxis, yAxis]) { const was = each.value; each.replaceChildren(...told.channels.map(([title]) => h("option", { selected: title === was }, title))); }
    if (told.channels.length > 1 && yAxis.value === xAxis.value) yAxis.selectedIndex = 1;
    plot.cursors = [null, null];
    times.forEach((each) => { each.value = ""; });
    const period = told.period_s ? `${(told.period_s * 1e3).toFixed(0)} ms` : "";
    put(about, `${told.cell}, ${told.started.replace("T", " ").slice(0, 19)}, ${told.time.length} ${t("records")}, ${period}, ${told.trigger ? `${t("trigger")} ${told.trigger}` : t("no trigger")}, ${told.lost ? `${told.lost} ${t("lost")}` : t("no record lost")}`);
    draw();
    values();
  }
  function draw() {
    if (!recording) return;
    box.hidden = over; xy.hidden = !over;
    xAxis.hidden = yAxis.hidden = !over;
    if (!over) { plot.show(recording.channels, recording.time, recording.columns, recording.channels.map(([title]) => !hidden.has(title))).catch((error) => put(about, error.message)); return; }
    const [x, y] = [xAxis.selectedIndex, yAxis.selectedIndex];
    drawXy(xy, recording.columns[x], recording.columns[y], recording.channels[x].join(" "), recording.channels[y].join(" "));
    xy.setAttribute("aria-label", `${recording.channels[y][0]} / ${recording.channels[x][0]}`);
  }
  async function fetched() {
    const answer = await fetch("/api/scope/file?as=scope");
    if (!answer.ok) return;
    take(parse(await answer.arrayBuffer()));
    box.dataset.records = String(recording.time.length);
  }

  // ---- files --------------------------------------------------------------------------------------------------------------
  const kept = h("select", { id: "kept", "aria-label": t("kept recordings") });
  const label = h("input", { id: "scope-name", maxlength: "60", pattern: "[A-Za-z0-9][A-Za-z0-9_+\\-]*", placeholder: t("name"), "aria-label": t("name"), style: "width:11rem" });
  const keep = h("button", { type: "button", id: "keep", onclick: async () => { if (!label.reportValidity() || !label.value) { label.focus(); return; } const told = await post("/api/scope/save", { name: label.value }, "The recording is kept"); if (told) list(told.saved); } }, t("Keep"));
  const reopen = h("button", { type: "button", id: "reopen", onclick: () => post("/api/scope/open", { name: kept.value }) }, t("Reopen"));
  const file = h("input", { type: "file", accept: ".scope", id: "scope-file", hidden: true, onchange: async () => { try { take(parse(await file.files[0].arrayBuffer())); } catch { toast(t("This is no recording"), "bad"); } } });
  const taken = ["scope", "csv", "mf4"].map((kind) => h("a", { class: "button", href: `/api/scope/file?as=${kind}`, download: "", id: `take-${kind}` }, kind.toUpperCase()));
  function list(saved) { kept.replaceChildren(...saved.map(({ name: each }) => h("option", {}, each))); reopen.disabled = !saved.length; }
  get("/api/scope/names").then((told) => {
    known.replaceChildren(...[...told.channels, ...told.signals].map((each) => h("option", { value: each })));
    list(told.saved);
  }).catch((error) => put(about, error.message));

  root.append(known, h("section", { class: "card" },
    h("div", { class: "bar low" }, h("label", {}, t("channel"), name), h("button", { type: "button", id: "add-channel", onclick: add }, t("Add")), chosen),
    h("div", { class: "bar low" }, h("label", {}, t("trigger"), form), h("label", {}, t("trigger channel"), at), h("label", {}, t("trigger level"), level),
      h("label", {}, t("before the trigger, s"), pre), h("label", {}, t("from it on, s"), seconds), start, chips)),
  h("section", { class: "card", style: "margin-top:.9rem" },
    h("div", { class: "bar low" }, swap, xAxis, yAxis, h("label", {}, `${t("cursor")} A, s`, times[0]), h("label", {}, `${t("cursor")} B, s`, times[1])),
    box, xy, about, h("p", { class: "soft small" }, t("Click sets cursor A, Shift and click cursor B; drag to come nearer, double click for all of it.")), table.element),
  h("section", { class: "card", style: "margin-top:.9rem" }, h("div", { class: "bar", style: "margin:0" }, label, keep, kept, reopen, h("button", { type: "button", onclick: () => file.click() }, t("Open a file")), file, h("span", { class: "soft" }, t("take away as")), ...taken)));
  chips_();
  forms();
  return {
    update(page) {
      if (!page || page.gone) return;
      const was = running();
      state = page;
      if (was !== running()) chips_();
      put(start, running() ? t("End the recording") : t("Record"));
      mark(start, running() ? "danger" : "main");
      const share = page.wanted ? `${Math.min(100, Math.round((100 * page.records) / page.wanted))} %` : "";
      const [kind, told] = { running: ["warn", `${t("recording")} ${share}`], waiting: ["warn", `${t("waiting for")} ${page.trigger}`], done: ["good", `${page.records} ${t("records")}`], none: ["plain", t("nothing recorded yet")] }[page.state];
      chips.replaceChildren(chip(kind, told), ...(page.lost ? [chip("bad", `${page.lost} ${t("lost")}`)] : []), ...(page.why ? [chip("warn", t(page.why))] : []));
      keep.disabled = page.state !== "done" || !may("operator");
      for (const each of taken) each.classList.toggle("off", page.state !== "done");
      if (page.tail?.t.length > 1 && !over) { drawn = -1; plot.show(page.names.map((each) => [each, "1"]), page.tail.t, page.tail.values, page.names.map(() => true)); put(about, ""); } 
      if (page.state === "done" && page.number !== drawn) { drawn = page.number; fetched(); }
    },
    theme: draw,
    unmount() { plot.close(); },
  };
}
