// What goes over the lines, in words.
import { Table, chip, h, mark, put, text } from "../dom.js";
import { say } from "../texts.js";

export function mount(root, { t, cell }) {
  const boxes = new Map();
  let held = false;
  const pause = h("button", { type: "button", id: "pause", "aria-pressed": "false", onclick: () => { held = !held; pause.setAttribute("aria-pressed", String(held)); put(pause, held ? t("Continue") : t("Freeze the list")); } }, t("Freeze the list"));
  const dull = h("input", { type: "checkbox", id: "dull" });
  root.append(h("div", { class: "bar" }, pause, h("label", { style: "flex-direction:row;align-items:center;gap:.4rem" }, dull, t("show STX, DLE and NAK too"))));
  if (!cell.lines.length && !cell.modbus.length) root.append(h("p", { class: "soft" }, t("The cell has no serial line.")));
  for (const line of cell.lines) {
    const state = chip("plain", "");
    const counters = h("p", { class: "small mono" });
    const body = h("tbody");
    boxes.set(line.name, { state, counters, body });
    root.append(h("section", { class: "card", style: "margin-bottom:.9rem" },
      h("div", { class: "bar" }, h("h2", { style: "margin:0" }, `${line.name}: ${line.protocol} ${line.layer}`), state, h("span", { class: "soft" }, `${line.format}   ${line.profile}   ${t("priority")} ${t(line.priority)}   ${line.port}`)),
      counters,
      h("div", { class: "scroll", style: "max-height:46vh", tabindex: "0", role: "region", "aria-label": `${t("Lines")} ${line.name}` },
        h("table", {}, h("thead", {}, h("tr", {}, [t("time"), t("side"), t("what"), t("in words"), t("bytes")].map((title) => h("th", { scope: "col" }, title)))), body))));
  }
  for (const server of cell.modbus.filter((each) => cell.command_sources.some((source) => source.kind === "modbus" && source.name === each.name))) {
    const state = chip("plain", "");
    const counters = h("p", { class: "small mono" });
    const body = h("tbody", { "data-modbus": server.name });
    boxes.set(server.name, { state, counters, body, modbus: true });
    root.append(h("section", { class: "card", style: "margin-bottom:.9rem" },
      h("div", { class: "bar" }, h("h2", { style: "margin:0" }, `${server.name}: Modbus`), state, h("span", { class: "soft" }, `${server.bind}   ${t("unit")} ${server.unit}`)), counters,
      h("div", { class: "scroll", style: "max-height:46vh", tabindex: "0", role: "region", "aria-label": `Modbus ${server.name}` },
        h("table", {}, h("thead", {}, h("tr", {}, [t("time"), t("client"), t("function"), t("asked"), t("answered"), t("bytes")].map((title) => h("th", { scope: "col" }, title)))), body))));
  }
  // Devices this cell asks: one row a device, below it what they refuse.
  const asked = new Table([
    { title: t("link"), free: true, cell: text((row) => row.link) },
    { title: t("address"), free: true, cell: text((row) => row.url) },
    { title: t("device"), cell: text((row) => row.device) },
    { title: t("unit"), n: true, cell: text((row) => row.unit) },
    { title: t("state"), free: true, cell: (row, td) => { if (!td.firstChild) td.append(chip("plain", "")); mark(td.firstChild, `chip ${row.alive ? "good" : "bad"}`); put(td.firstChild, row.alive ? t("answers") : !row.connected ? t("no connection") : row.asked ? t("does not answer") : t("not polled yet")); } },
    { title: t("refused reads and writes"), free: true, cell: text((row) => row.words) },
    { title: t("requests"), n: true, cell: text((row) => row.requests) },
    { title: t("time-outs"), n: true, cell: text((row) => row.timeouts) },
    { title: t("losses"), n: true, cell: text((row) => row.losses) },
  ], (row) => `${row.link} ${row.device}`, { label: t("Modbus devices polled by this cell"), row: (row) => (row.words ? "badq" : "") });
  const devices = h("section", { class: "card", id: "asked", hidden: true }, h("h2", {}, t("Modbus devices polled by this cell")), asked.element);
  root.append(devices);
  function links(found) {
    devices.hidden = !found.length;
    asked.update(found.flatMap((link) => Object.entries(link.devices).map(([device, seen]) => {
      const refused = link.refused.filter((each) => each[0].startsWith(`${device}, `)).map((each) => say(each).slice(device.length + 2));
      return { ...seen, link: link.name, url: link.url, device, connected: link.connected, asked: seen.requests, words: [link.connected ? "" : say(link.why), ...refused].filter(Boolean).join("; ") };
    })));
  }
  // The time of day at the browser, to the millisecond.
  function clock(ms, offset) {
    const at = new Date(ms + offset);
    return `${at.toLocaleTimeString("de-DE", { hour12: false })}.${String(at.getMilliseconds()).padStart(3, "0")}`;
  }
  function exchange(row, offset) {
    return h("tr", { class: row.ok ? "" : "badq" }, h("td", { class: "n" }, clock(row.ms, offset)), h("td", {}, `${row.client} / ${row.unit}`), h("td", { class: "n" }, `FC ${row.function}`),
      h("td", { class: "free" }, say(row.asked)), h("td", { class: "free mono small" }, say(row.answered)), h("td", { class: "free mono small" }, row.hex.replace(/(..)(?=.)/g, "$1 ")));
  }
  const SIDES = { A: t("partner"), B: "axisgate" };
  return {
    update(page) {
      if (!page || page.gone) return;
      links(page.asked);
      for (const source of page.command_sources) {
        const box = boxes.get(source.name);
        if (!box) continue;
        put(box.state, source.alive ? t("alive") : source.connected === false ? t("port not available") : t("silent"));
        mark(box.state, `chip ${source.alive ? "good" : "bad"}`);
        const known = ["sends", "fetches", "refused", "bad_blocks", "own_jobs", "own_faults", "same_priority", "received", "sent", "unknown", "requests", "losses"];
        put(box.counters, [...known.filter((name) => name in source).map((name) => `${t(name.replace("_", " "))} ${source[name]}`), say(source.advice), say(source.why)].filter(Boolean).join("   "));
      }
      if (held) return;
      for (const [name, reply] of Object.entries(page.lines)) {
        const box = boxes.get(name);
        if (!box) continue;
        if (box.modbus) { box.body.replaceChildren(...reply.slice(-60).reverse().map((row) => exchange(row, page.clock_ms))); continue; }
        const rows = reply.filter((row) => dull.checked || row.kind.length > 3).slice(-60).reverse();
        box.body.replaceChildren(...rows.map((row) => h("tr", { class: row.ok === false || ["BROKEN", "DAMAGED", "STRAY"].includes(row.kind) ? "badq" : "" },
          h("td", { class: "n" }, clock(row.ms, page.clock_ms)), h("td", {}, SIDES[row.side]), h("td", {}, row.kind), h("td", { class: "free" }, say(row.say)), h("td", { class: "free mono small" }, row.hex))));
      }
    },
  };
}
