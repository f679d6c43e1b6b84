// The integrated PLC of a Reis: state, start and stop, message, listing with its test display, forced inputs and markers by hand.
import { Table, chip, grey, h, mark, put, text } from "../dom.js";

const STEPS = 500; // of a listing at once
const EVERY_MS = 300;
const SHOWS = { dec: (n) => n, hex: (n) => `${(n >>> 0).toString(16).toUpperCase()}H`, bin: (n) => (n >>> 0).toString(2).padStart(32, "0").replace(/(.{8})(?=.)/g, "$1 ") };

export function mount(root, { t, get, post, unable }) {
  let page = null;
  let name = "";
  let first = 1;
  let listing = null;
  let shown = new Map();
  let asking = false;
  let form = "dec";
  const state = h("span", { class: "chip", id: "plc-state" });
  const scans = h("span", { class: "soft", id: "plc-scans" });
  const message = h("p", { class: "badq", id: "plc-message", role: "status" });
  const choose = h("select", { id: "plc-program", "aria-label": t("program"), onchange: () => open(choose.value) });
  const start = h("button", { type: "button", id: "plc-start", onclick: () => post("/api/plc/start", { name: "" }, "The PLC is started") }, t("Start PLC"));
  const stop = h("button", { type: "button", id: "plc-stop", onclick: () => post("/api/plc/stop", undefined, "The PLC is stopped") }, t("Stop PLC"));
  const ack = h("button", { type: "button", id: "plc-ack", onclick: () => post("/api/plc/ack", undefined, "The message is acknowledged") }, t("Acknowledge"));
  const before = h("button", { type: "button", onclick: () => open(name, Math.max(1, first - STEPS)) }, t("Previous steps"));
  const after = h("button", { type: "button", onclick: () => open(name, first + STEPS) }, t("Next steps"));
  const note = h("p", { class: "soft small", id: "plc-note", role: "status" });
  const numbers = h("select", { id: "plc-numbers", "aria-label": t("numbers"), onchange: () => { form = numbers.value; draw(); } }, Object.keys(SHOWS).map((each) => h("option", { value: each }, each)));
  const operand = h("input", { id: "plc-operand", placeholder: "M10.0, M10, MD10, E0.6", size: "12", "aria-label": t("operand") });
  const value = h("input", { id: "plc-value", placeholder: "0, 255, 1FH", size: "10", "aria-label": t("value") });
  const write = h("button", { type: "button", id: "plc-write", onclick: () => give(false) }, t("Write"));
  const free = h("button", { type: "button", id: "plc-free", onclick: () => give(true) }, t("Stop forcing"));
  const seen = (row) => (row.valid ? shown.get(row.step) : undefined);
  const number = (n) => SHOWS[form](n);
  const table = new Table([
    { title: t("step"), n: true, cell: text((row) => row.step) },
    { title: t("command"), cell: (row, td) => {
      if (td.dataset.text === row.text) return;
      td.dataset.text = row.text;
      const found = row.text.match(/^[A-Z=]+\s*\(?\s*([EM]\s*\d+(?:\.\d)?)/i);
      td.className = "whole";
      td.replaceChildren(found ? h("button", { type: "button", class: "link", onclick: () => { operand.value = found[1].replace(/\s/g, "").toUpperCase(); value.focus(); } }, row.text) : row.text);
    } },
    { title: t("state"), n: true, cell: text((row) => { const at = seen(row); return at ? Number(at[1]) : listing.on && row.command ? "NOP" : ""; }) },
    { title: "VKE", n: true, cell: text((row) => { const at = seen(row); return at ? Number(at[2]) : ""; }) },
    { title: "ACCU1", n: true, cell: text((row) => { const at = seen(row); return at ? number(at[3]) : ""; }) },
    { title: "ACCU2", n: true, cell: text((row) => { const at = seen(row); return at ? number(at[4]) : ""; }) },
  ], (row) => row.step, { tall: true, label: t("Listing"), row: (row) => (!listing.on || !row.command || seen(row) ? "" : "badq nop") });

  async function open(wanted, from = 1) {
    try {
      const reply = await get(`/api/plc/listing?name=${encodeURIComponent(wanted)}&first=${from}`);
      name = reply.name; first = from; shown = new Map();
      listing = { ...reply, on: false, rows: reply.rows.map(([step, words, valid]) => ({ step, text: valid ? words : `\\${words}`, valid, command: step > 1 && !/^(;|END|M\s+[^\d\s])/i.test(words) })) };
      put(note, "");
    } catch (error) { listing = null; put(note, t(error.message)); }
    draw();
  }
  async function look() {
    if (!listing || asking || document.hidden) return;
    asking = true;
    try {
      const reply = await get(`/api/plc/shown?name=${encodeURIComponent(name)}&first=${first}`);
      const same = reply.on && reply.text === listing.text;
      if (reply.on && !same) put(note, t("The test display is off: the file differs from the program that runs. Start the PLC."));
      else put(note, reply.on ? "" : `${t("The test display is off.")} ${reply.why ? t(reply.why) : t("The program does not run, or was edited.")}`);
      listing.on = same;
      shown = new Map(same ? reply.rows.map((row) => [row[0], row]) : []);
      draw();
    } catch (error) { put(note, t(error.message)); } finally { asking = false; }
  }
  function draw() { table.update(listing ? listing.rows : []); grey(before, first > 1 ? "" : t("These are the first steps.")); grey(after, listing && first + STEPS <= listing.steps ? "" : t("These are the last steps.")); }
  function give(end) {
    const words = operand.value.trim().toUpperCase();
    const input = words.match(/^[EI]\s*(\d+)\.([0-7])$/);
    if (!input) return post("/api/plc/write", { operand: words, value: value.value.trim() || "0" }, "The marker is written");
    const bit = 8 * (page.first_byte + Number(input[1])) + Number(input[2]);
    return end ? post("/api/unforce", { bit }, "Forcing has stopped") : post("/api/force", { bit, value: Number(value.value) ? 1 : 0 }, "The input is forced");
  }
  const timer = setInterval(look, EVERY_MS);
  root.append(h("div", { class: "grid" },
    h("section", { class: "card w12" },
      h("div", { class: "bar" }, state, scans, start, stop, ack), message,
      h("div", { class: "bar" }, choose, h("button", { type: "button", onclick: () => name && open(name, first) }, t("Read again")), before, after, h("label", {}, `${t("numbers")} `, numbers)),
      note, table.element,
      h("div", { class: "bar" }, operand, value, write, free),
      h("p", { class: "soft small" }, t("Inputs stay forced until you stop forcing; a marker is written once, between two scans. Click a command to select its operand.")))));
  return {
    update(reply) {
      if (!reply) return;
      page = reply;
      if (reply.gone) { put(note, reply.gone); return; }
      const kind = reply.state === "RUN" ? "good" : reply.state === "STOP" ? "warn" : "bad";
      mark(state, `chip ${kind}`); put(state, `${t("PLC")} ${reply.state}`);
      put(scans, `${reply.scans} ${t("scans")}, ${reply.load === null ? t("a whole scan each period") : `${reply.load} ${t("commands a period")}`}`);
      const red = reply.message && Number(reply.message.reaction) & 15;
      put(message, reply.message ? `${reply.message.text}${reply.message.program ? ` (${reply.message.program} ${t("step")} ${reply.message.step})` : ""}` : "");
      mark(message, reply.message && !red ? "goodq" : "badq");
      grey(start, unable("operator")); grey(stop, unable("operator")); grey(ack, unable("operator") || (reply.message ? "" : t("There is no message.")));
      grey(write, unable("setter")); grey(free, unable("setter"));
      if (choose.options.length !== reply.programs.length || [...choose.options].some((each, n) => each.value !== reply.programs[n])) choose.replaceChildren(...reply.programs.map((each) => h("option", { value: each }, each)));
      if (!name && reply.programs.length) open(reply.programs.includes(reply.start.toUpperCase()) ? reply.start : reply.programs[0]);
      if (name && choose.value !== name) choose.value = name;
    },
    unmount() { clearInterval(timer); },
  };
}
