// Set, actual, lag, torque, state, limits; jog and reference while a key is held.
import { Table, chip, grey, h, mark, number, put, trendValue, trended } from "../dom.js";
import { FLAG, drive } from "../parts.js";
import { Trend } from "../trend.js";

const FROZEN_MS = 600;

export function mount(root, { t, cell, live, login, may, me, post, changeControl, unable }) {
  const info = new Map(cell.axes.map((axis, n) => [axis.name, { ...axis, n }]));
  const everything = 2 ** cell.axes.length - 1;
  let chosen = cell.axes[0]?.name;
  const speed = h("input", { type: "number", id: "jog-speed", min: "0.1", max: "10", step: "0.1", value: "5" });
  const held = new Map();
  let reported = true; // that the key pressed last was refused

  function order(code, mask = everything, more = {}) {
    return post("/api/command", { code, mask, ...more });
  }
  function press(button, what) {
    if (!may("operator") || held.has(button)) return;
    reported = false;
    let last = Date.now();
    const say = (first) => {
      if (Date.now() - last > FROZEN_MS) { release(button); return; } // the browser stood still: the finger may be long gone
      last = Date.now();
      live.send({ ...what(), first, at: live.at });
    };
    held.set(button, setInterval(say, 150, false));
    button.classList.add("down");
    say(true);
  }
  function release(button) {
    if (!held.has(button)) return;
    clearInterval(held.get(button));
    held.delete(button);
    button.classList.remove("down");
    live.send({ t: "release" });
  }
  // A key that acts while it is held: mouse, finger, space bar; whatever takes it away ends it.
  function key(attributes, title, what) {
    const button = h("button", { type: "button", class: "hold", ...attributes }, title);
    button.addEventListener("pointerdown", (event) => { event.preventDefault(); button.setPointerCapture(event.pointerId); button.focus(); press(button, what); });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) button.addEventListener(end, () => release(button));
    button.addEventListener("contextmenu", (event) => event.preventDefault());
    button.addEventListener("keydown", (event) => { if ((event.key === " " || event.key === "Enter") && !event.repeat) { event.preventDefault(); press(button, what); } });
    button.addEventListener("keyup", (event) => { if (event.key === " " || event.key === "Enter") release(button); });
    return button;
  }
  const jog = (axis, direction) => key({ "data-jog": `${axis}${direction > 0 ? "+" : "-"}`, "aria-label": `${t("jog")} ${cell.axes[axis].name} ${direction > 0 ? "plus" : "minus"}` }, direction > 0 ? "+" : "\u2212",
    () => ({ t: "jog", axis, direction, percent: Number(speed.value) || 5 }));
  const reference = (mask, attributes, title) => key({ title: t("hold until it is done"), ...attributes }, title, () => ({ t: "reference", mask }));
  const all = () => { for (const button of [...held.keys()]) release(button); };
  for (const end of ["visibilitychange", "freeze"]) document.addEventListener(end, all);
  for (const end of ["blur", "pagehide"]) window.addEventListener(end, all);

  const table = new Table([
    { title: t("axis"), cell: (row, td) => { if (!td.firstChild) td.append(h("button", { type: "button", class: "tiny", onclick: () => { chosen = row.name; trend.clear(chosen); } }, row.name)); } },
    { title: t("state"), cell: (row, td) => { const [kind, words] = drive(row, t); const c = td.firstChild || td.appendChild(chip(kind, words)); put(c, words); mark(c, `chip ${kind}`); } },
    { title: t("set"), n: true, cell: trended((row) => `axis.${row.name}.set`, (row) => row.set, 3) },
    { title: t("actual"), n: true, cell: trended((row) => `axis.${row.name}.actual`, (row) => row.actual, 3) },
    { title: t("lag"), n: true, cell: (row, td) => { trendValue(td, `axis.${row.name}.lag`, number(row.lag, 3)); const a = info.get(row.name); td.classList.toggle("badq", a.warn !== null && Math.abs(row.lag) > a.warn); } },
    { title: t("torque %"), n: true, cell: trended((row) => `axis.${row.name}.torque`, (row) => row.torque, 1) },
    { title: t("limits"), cell: place },
    { title: t("reference, hold"), cell: (row, td) => {
      const n = info.get(row.name).n;
      if (!td.firstChild) td.append(h("span", { class: "bar", style: "margin:0;flex-wrap:nowrap" }, h("span", { "data-referenced": row.name }), reference(2 ** n, { "data-ref": row.name }, t("reference"))));
      put(td.firstChild.firstChild, row.flags & FLAG.REFERENCED ? t("yes") : t("no"));
    } },
    { title: t("jog, hold"), cell: (row, td) => { if (!td.firstChild) { const n = info.get(row.name).n; td.append(h("span", { class: "bar", style: "margin:0;flex-wrap:nowrap" }, jog(n, -1), jog(n, 1))); } } },
  ], (row) => row.name, { label: t("Axes") });
  table.element.classList.add("axes");

  function place(row, td) {
    const a = info.get(row.name);
    if (!td.firstChild) td.append(h("div", { class: "meter" }, h("i")), h("div", { class: "small soft mono" }, `${a.min} .. ${a.max} ${a.unit}`));
    td.firstChild.firstChild.style.left = `${Math.min(98, Math.max(0, (100 * (row.actual - a.min)) / (a.max - a.min)))}%`;
  }

  const trend = new Trend(t);
  const control = h("button", { type: "button", id: "control", class: "main", onclick: async () => {
    if (!may("operator") && guest()) { login(); return; }
    await changeControl();
  } });
  const guest = () => !me.read_only && (me.name === "local" || me.name === "nobody");
  const next = h("p", { class: "next", id: "next", role: "status" });
  const holder = h("span", { class: "soft", id: "holder" });
  const buttons = [
    ["enable", "Drives on"], ["disable", "Drives off"], ["fault_reset", "Reset faults"], ["resume", "Resume"], ["abandon", "Abandon rest"],
  ].map(([code, title]) => h("button", { type: "button", "data-code": code, onclick: () => order(code) }, t(title)));
  buttons.splice(2, 0, reference(everything, { "data-ref": "" }, t("Reference all, hold")));
  const permit = cell.simulated ? h("button", { type: "button", id: "permit", "aria-pressed": "false", onclick: () => post("/api/permit", { on: !permitted }, permitted ? "Enabling inputs are cleared" : "Enabling inputs are set") }, t("Set enabling inputs (simulation)")) : null;
  let permitted = false; // as the services say, not as the key was pressed
  let turning = 0; // the slider is in somebody's hand until then
  const override = h("input", { type: "range", id: "override", min: "0", max: "100", step: "1", value: "100", "aria-label": t("override"), oninput: () => { turning = Date.now() + 1500; put(overridden, `${override.value} %`); }, onchange: () => order("override", 0, { velocity: Number(override.value) / 100 }) });
  const overridden = h("output", { id: "override-value" });
  // What is between this person and a moving axis; "": nothing.
  function step(head) {
    const unfit = unable("operator");
    if (unfit) return unfit;
    if (!me.holds) return head.holder || head.owner ? `${t("Another command source is in control")}: ${head.holder || `${t("command source")} ${head.owner}`}.` : t("Request control.");
    if (head.missing.length) return `${t("Enabling inputs missing")}: ${head.missing.map((each) => t(`permit ${each}`)).join(", ")}.${cell.simulated && !head.permits ? ` ${t("In this simulation the page sets them.")}` : ""}`;
    if (head.emergency) return t("The emergency stop is latched: reset faults.");
    if (!head.enabled) return t("The drives are off: switch them on.");
    if (!head.override) return t("The override is 0 %: raise it.");
    return "";
  }
  root.append(
    h("div", { class: "bar low" }, control, holder, permit, ...buttons, h("label", {}, h("span", {}, `${t("override")} `, overridden), override),
      h("label", {}, t("jog speed, % (10 at most)"), speed)),
    next,
    h("p", { class: "small soft" }, t("Jog and reference keys act while they are held: released, or with the connection lost, the axis stops on the path. The speed limit is not safety-rated.")),
    h("section", { class: "card" }, table.element),
    h("section", { class: "card", style: "margin-top:.9rem" }, trend.element));
  return {
    update(page, head) {
      if (page && !page.gone) table.update(page.axes); // first: its keys are greyed below
      put(control, me.holds ? t("Release control") : t("Request control"));
      put(holder, head.holder ? `${t("in control")}: ${head.holder}` : head.owner ? `${t("in control")}: ${t("command source")} ${head.owner}` : t("control is free"));
      const why = unable("operator") || (me.holds ? "" : step(head));
      const words = step(head);
      put(next, words ? `${t("Next step")}: ${words}` : t("Ready: hold a jog key to move its axis."));
      mark(next, words ? "next" : "next good");
      for (const button of [...buttons, override]) if (!button.classList.contains("down")) grey(button, why);
      root.querySelectorAll("[data-jog],[data-ref]").forEach((button) => { if (!button.classList.contains("down")) grey(button, why); });
      if (Date.now() > turning) { override.value = String(Math.round(head.override)); put(overridden, `${head.override} %`); }
      if (permit) {
        permitted = Boolean(head.permits);
        grey(permit, may("setter") || (me.local && guest()) ? "" : unable("setter"));
        put(permit, permitted ? t("Clear enabling inputs (simulation)") : t("Set enabling inputs (simulation)"));
        permit.setAttribute("aria-pressed", String(permitted));
      }
      if (!may("operator") && guest()) put(control, me.fresh ? t("Set password") : t("Log in"));
      grey(control, may("operator") || guest() ? "" : unable("operator"));
      if (!page || page.gone) return;
      const row = page.axes.find((each) => each.name === chosen);
      if (row) trend.add(page.ns / 1e9, row, info.get(chosen));
    },
    theme: () => trend.theme(),
    lift: all, // what was held counts as released: the key is to be pressed anew
    refused() { all(); const first = !reported; reported = true; return first; }, // once for each press
    unmount() {
      all();
      for (const end of ["visibilitychange", "freeze"]) document.removeEventListener(end, all);
      for (const end of ["blur", "pagehide"]) window.removeEventListener(end, all);
      trend.close();
    },
  };
}
