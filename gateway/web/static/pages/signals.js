// Every value by any name or address: live, with age and quality, where it is used; forced inputs are marked.
import { Table, h, put, text, trendValue } from "../dom.js";
import { age, asked } from "../parts.js";
import { WatchList } from "../watch.js";

export function mount(root, { t, get, post, may, live, unable }) {
  let rows = [];
  let values = {};
  let group = "";
  let chosen = "";
  let wait = 0;
  const search = h("input", { type: "search", id: "search", placeholder: t("name, address, text: DB10.DW2, O3.0, 40001, feed"), "aria-label": t("Search"), oninput: () => { list.close(); clearTimeout(wait); wait = setTimeout(find, 60); } });
  const found = h("span", { class: "soft", id: "found", role: "status" });
  const tree = h("div", { class: "tree" });
  const detail = h("section", { class: "card", id: "detail" }, h("p", { class: "soft" }, t("Choose a row to see where the value is used.")));
  const unforce = h("button", { type: "button", id: "unforce-all", class: "danger", onclick: () => post("/api/unforce", {}, "No input is forced now") }, t("Stop all forcing"));
  const list = new WatchList({ t, get, post, unable, find: () => find() }, () => { if (list.open) find(); else table.update(rows); });
  const table = new Table([
    { title: t("name"), cell: (row, td) => { if (!td.firstChild) td.append(h("span", { class: "bar", style: "margin:0;flex-wrap:nowrap" }, list.star(row.id), h("button", { type: "button", class: "link", "data-row": row.id, onclick: () => show(row) }, row.name))); list.mark(td.querySelector(".star"), row.id); } },
    { title: t("value"), n: true, cell: (row, td) => { if (row.kind === "text" && Number.isNaN(Number(values[row.id]?.[0]))) put(td, shown(row)); else trendValue(td, row.id, shown(row)); td.dataset.id = row.id; } },
    { title: t("unit"), cell: text((row) => row.unit) },
    { title: t("quality"), cell: text((row) => quality(row)) },
    { title: t("age"), n: true, cell: text((row) => age(values[row.id]?.[2])) },
    { title: t("force"), cell: force },
    { title: t("address"), cell: text((row) => row.addresses.slice(0, 3).join("  ")) },
    { title: t("type"), cell: text((row) => row.type) },
    { title: "KF / DH", n: true, cell: text((row) => columns(row).KF) },
    { title: "KH", n: true, cell: text((row) => columns(row).KH) },
    { title: "KM", n: true, cell: text((row) => columns(row).KM) },
    { title: "KG", n: true, cell: text((row) => columns(row).KG) },
  ], (row) => row.id, { tall: true, label: t("Signals"), row: (row) => { const v = values[row.id]; return v?.[3] ? "forced" : !v || v[1] === 2 ? "" : v[1] === 1 ? "stale" : "badq"; } });

  const isDouble = (row) => ["DH", "KG", "REAL"].includes(row.type);
  function raw(row) { const v = values[row.id]?.[0]; return row.kind === "word" && typeof v === "string" ? v : null; }
  function columns(row) {
    const hex = raw(row);
    if (!hex) return { KF: "", KH: "", KM: "", KG: "" };
    const word = parseInt(hex.slice(0, 4), 16);
    const long = parseInt(hex.slice(0, 8).padEnd(8, "0"), 16);
    const double = isDouble(row);
    return {
      KF: double ? long | 0 : (word << 16) >> 16, KH: (double ? hex.slice(0, 8) : hex.slice(0, 4)).toUpperCase(),
      KM: double ? "" : word.toString(2).padStart(16, "0").replace(/(.{8})/, "$1 "), KG: double ? kg(long).toPrecision(6) : "",
    };
  }
  // S5 float: exponent and 24-bit mantissa, both two's complement.
  function kg(long) { const exponent = long >> 24; const mantissa = (long << 8) >> 8; return (mantissa / 2 ** 23) * 2 ** exponent; }
  function shown(row) {
    const v = values[row.id];
    if (!v || v[0] === null) return "";
    const hex = raw(row);
    if (!hex) return typeof v[0] === "number" && !Number.isInteger(v[0]) ? v[0].toFixed(3) : v[0];
    if (row.id.endsWith("DL")) return parseInt(hex.slice(0, 2), 16);
    if (row.id.endsWith("DR")) return parseInt(hex.slice(2, 4), 16);
    if (row.type === "KG") return kg(parseInt(hex, 16)).toPrecision(6);
    if (row.type === "REAL") { const view = new DataView(new ArrayBuffer(4)); view.setUint32(0, parseInt(hex.padEnd(8, "0"), 16)); return view.getFloat32(0).toPrecision(6); }
    const c = columns(row);
    const count = Number.parseFloat(row.unit);
    return row.type === "KF" && count && count !== 1 ? (c.KF * count).toFixed(1) : c.KF;
  }
  function quality(row) {
    const v = values[row.id];
    if (!v) return "";
    return v[3] ? t("forced") : [t("bad"), t("stale"), t("good")][v[1]];
  }
  // A data word takes a value of its own type and unit; a bit, like an RC input, 0 or 1.
  function forceWord(row, td) {
    const forced = Boolean(values[row.id]?.[3]);
    if (td.dataset.forced === String(forced)) return;
    td.dataset.forced = String(forced);
    const lay = (value) => post("/api/force/word", { id: row.id, value }, "The word is forced");
    const attributes = (what) => ({ type: "button", class: "tiny", disabled: !may("setter"), "data-force": `${row.id}=${what}` });
    const keys = row.kind === "bit" ? ["0", "1"].map((value) => h("button", { ...attributes(value), onclick: () => lay(value) }, value))
      : [h("button", { ...attributes("value"), onclick: async () => { const value = await asked(t, `${row.addresses[0]} ${row.name}, ${row.type} ${row.unit}`, shown(row)); if (value) lay(value); } }, t("force"))];
    td.replaceChildren(h("span", { class: "bar", style: "margin:0;flex-wrap:nowrap" }, keys, forced ? h("button", { ...attributes("end"), onclick: () => post("/api/unforce/word", { id: row.id }, "Forcing has stopped") }, t("end")) : null));
  }
  function force(row, td) {
    if (row.id.startsWith("db:")) { forceWord(row, td); return; }
    if (!row.forcible) return;
    const forced = Boolean(values[row.id]?.[3]);
    if (td.dataset.forced === String(forced)) return;
    td.dataset.forced = String(forced);
    const bit = Number(row.id.slice(3));
    const key = (title, path, body, done) => h("button", { type: "button", class: "tiny", disabled: !may("setter"), "data-force": `${row.id}=${body.value ?? "end"}`, onclick: () => post(path, body, done) }, title);
    td.replaceChildren(h("span", { class: "bar", style: "margin:0;flex-wrap:nowrap" }, key("0", "/api/force", { bit, value: 0 }, "The input is forced"), key("1", "/api/force", { bit, value: 1 }, "The input is forced"),
      forced ? key(t("end"), "/api/unforce", { bit }, "Forcing has stopped") : null));
  }
  function show(row) {
    chosen = row.id;
    const parts = [h("h2", {}, row.name), h("p", {}, row.en ? t("en") === "de" ? row.de : row.en : ""),
      h("p", { class: "mono small" }, row.addresses.join("   ")),
      row.source === "axisgate" ? h("p", { class: "soft" }, t("The number is axisgate's own (AX-002).")) : null,
      h("p", {}, `${t("written by")}: ${row.writer || "-"}`),
      h("h2", {}, t("Where used")), row.used.length ? h("ul", {}, row.used.map((use) => h("li", {}, use)), row.used_more ? h("li", { class: "soft" }, `${t("and more")}: ${row.used_more}`) : null) : h("p", { class: "soft" }, t("nowhere in this cell"))];
    detail.replaceChildren(...parts.filter(Boolean));
  }
  async function find() {
    try {
      const ids = list.open ? list.ids.map((id) => `&id=${encodeURIComponent(id)}`).join("") : "";
      if (list.open && !ids) { rows = []; table.update(rows); live.page("signals", []); put(found, t("The watch list is empty: the stars beside the names put values into it.")); return; }
      const reply = await get(`/api/signals?q=${encodeURIComponent(list.open ? "" : search.value)}&group=${encodeURIComponent(list.open ? "" : group)}${ids}`);
      rows = reply.rows;
      put(found, `${t("found")}: ${reply.total}${reply.total > rows.length ? `, ${rows.length} ${t("shown")}` : ""}`);
      table.update(rows);
      table.element.classList.toggle("nowords", rows.filter((row) => row.kind === "word").length * 2 < rows.length);
      live.page("signals", rows.map((row) => row.id));
      if (rows.length && !rows.some((row) => row.id === chosen)) show(rows[0]);
    } catch (error) { put(found, error.message); }
  }
  async function plant() {
    const reply = await get("/api/tree");
    const branches = new Map();
    for (const { group: name, count } of reply.tree) {
      const [top] = name.split(" / ");
      if (!branches.has(top)) branches.set(top, []);
      branches.get(top).push([name, count]);
    }
    const leaf = (name, title, count) => h("button", { type: "button", "aria-pressed": "false", "data-group": name, onclick: (event) => choose(event.currentTarget, name) }, h("span", {}, title), h("span", { class: "soft" }, String(count)));
    tree.append(leaf("", t("everything"), reply.total));
    for (const [top, leaves] of branches) {
      if (leaves.length === 1 && leaves[0][0] === top) tree.append(leaf(top, t(top), leaves[0][1]));
      else tree.append(h("details", {}, h("summary", {}, t(top)), leaf(top, t("all"), leaves.reduce((sum, [, count]) => sum + count, 0)), leaves.map(([name, count]) => leaf(name, name.slice(top.length + 3), count))));
    }
    tree.querySelector("button").setAttribute("aria-pressed", "true");
  }
  function choose(button, name) {
    group = name;
    list.close();
    tree.querySelectorAll("[aria-pressed]").forEach((each) => each.setAttribute("aria-pressed", String(each === button)));
    find();
  }
  root.append(h("div", { class: "grid" },
    h("section", { class: "card side" }, h("h2", {}, t("Tree")), tree),
    h("div", { class: "w9" }, h("section", { class: "card" }, h("div", { class: "bar", style: "flex-wrap:nowrap" }, search), list.element, h("div", { class: "bar spread" }, found, unforce), table.element),
      h("div", { style: "height:.9rem" }), detail)));
  plant().then(find);
  return {
    update(page, head, fresh) {
      values = fresh;
      unforce.disabled = !head.forced || !may("setter");
      list.update();
      table.update(rows);
    },
    watch: () => [],
  };
}
