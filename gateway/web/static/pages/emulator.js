// Pull the plug, fault a drive: only where everything is simulated.
import { Table, chip, h, mark, put, text } from "../dom.js";

export function mount(root, { t, cell, post }) {
  if (!cell.simulated) { root.append(h("p", {}, t("This cell runs on real ports; there is nothing to emulate."))); return {}; }
  const plugs = new Map();
  const cables = h("div", { class: "grid" }, cell.lines.map((line) => cable(line.name)));
  function cable(name) {
    const plug = h("button", { type: "button", class: "plug danger", "data-plug": name, onclick: () => post("/api/cable", { line: name, do: plug.dataset.plugged === "1" ? "unplug" : "plug" }) }, t("Pull the plug"));
    const state = chip("plain", "");
    const link = chip("plain", "");
    const facts = h("p", { class: "small mono" });
    const damage = h("button", { type: "button", class: "tiny", onclick: () => post("/api/cable", { line: name, do: "damage", side: "A", kind: "parity", probability: 0.01 }, "One character in a hundred is corrupted") }, t("Corrupt 1 % of the characters"));
    const calm = h("button", { type: "button", class: "tiny", onclick: () => post("/api/cable", { line: name, do: "calm" }, "The disturbance has ended") }, t("End the disturbance"));
    plugs.set(name, { plug, state, link, facts });
    return h("section", { class: "card w6" }, h("h2", {}, `${t("Cable of line")} ${name}`), h("div", { class: "bar" }, plug, state, link), facts, h("div", { class: "bar" }, damage, calm));
  }
  const rows = new Map();
  const drives = new Table([
    { title: t("axis"), cell: text((row) => row.axis) },
    { title: t("emulated drive"), cell: text((row) => row.emulator) },
    { title: t("state"), cell: (row, td) => {
      const bad = row.fault && row.fault !== 0;
      const words = `${row.state ?? "?"}${bad ? ` ${t("fault")} ${row.fault}` : ""}`;
      const c = td.firstChild || td.appendChild(chip("plain", words));
      put(c, words); mark(c, `chip ${bad ? "bad" : "plain"}`);
    } },
    { title: t("torque Nm"), n: true, cell: text((row) => row.torque, 2) },
    { title: t("fault to trigger"), cell: orders },
  ], (row) => row.axis, { label: t("Drives") });
  function orders(row, td) {
    if (td.firstChild) return;
    const known = cell.faults.find((each) => each.axis === row.axis);
    const choice = h("select", { "data-fault": row.axis, "aria-label": `${t("fault to trigger")} ${row.axis}` },
      [...known.switched.flatMap((name) => [`${name} on`, `${name} off`]), ...known.faults].map((name) => h("option", {}, name)));
    td.append(h("span", { class: "bar", style: "margin:0" }, choice, h("button", { type: "button", class: "tiny", "data-inject": row.axis, onclick: () => {
      const [name, on] = choice.value.split(" ");
      post("/api/fault", { emulator: known.emulator, do: name, ...known.key, ...(on ? { on: on === "on" } : {}) }, "The fault is triggered");
    } }, t("Trigger the fault"))));
  }
  root.append(h("p", {}, t("Everything here is emulated: pull cables, inject drive faults and watch the cell recover.")), cables,
    h("section", { class: "card", style: "margin-top:.9rem" }, h("h2", {}, t("Emulated drives")), drives.element));
  return {
    update(page, head) {
      for (const [link, alive] of head.links) {
        const own = plugs.get(link);
        if (own) { put(own.link, alive ? t("link alive") : alive === null ? t("not known") : t("link silent")); mark(own.link, `chip ${alive ? "good" : "bad"}`); }
      }
      if (!page || page.gone) return;
      for (const [name, reply] of Object.entries(page.cables)) {
        const own = plugs.get(name);
        if (!own) continue;
        const plugged = reply.plugged !== false;
        own.plug.dataset.plugged = plugged ? "1" : "0";
        put(own.plug, plugged ? t("Pull the plug") : t("Plug in again"));
        mark(own.plug, `plug ${plugged ? "danger" : "main"}`);
        put(own.state, reply.why || (plugged ? t("plugged") : t("unplugged")));
        mark(own.state, `chip ${plugged && !reply.why ? "good" : "bad"}`);
        if (reply.characters) put(own.facts, `${reply.baud} Bd   ${t("characters")} A ${reply.characters.A}  B ${reply.characters.B}   ${t("lost")} ${reply.lost}   ${t("spoiled")} ${reply.damaged}`);
      }
      drives.update(cell.faults.map((each) => {
        const reply = page.emulators[each.emulator] || {};
        const own = (reply.axes || reply.nodes || {})[String(each.key.axis ?? each.key.node)] || {};
        return { ...each, state: own.state ?? reply.why, fault: own.fault ?? own.error ?? own.error_code ?? 0, torque: own.torque_nm };
      }));
    },
  };
}
