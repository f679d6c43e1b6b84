// The VAL 3 application of a cell: state, start and stop, tasks, variables, popups, prompts, text page, user page.
import { Table, chip, grey, h, mark, put, text } from "../dom.js";
import { UserPage } from "../userpage.js";

export function mount(root, { t, get, post, unable }) {
  const state = h("span", { class: "chip", id: "val3-state" });
  const facts = h("p", { class: "soft small", id: "val3-facts" });
  const start = h("button", { type: "button", id: "val3-start", onclick: () => post("/api/program/start", { name }, "The program is started") }, t("Start"));
  const stop = h("button", { type: "button", id: "val3-stop", onclick: () => post("/api/program/stop", { name }, "The program is stopped") }, t("Stop"));
  const hold = h("button", { type: "button", id: "val3-hold", onclick: () => act({ act: "hold", on: !seen.hold }) });
  const connect = h("button", { type: "button", id: "val3-connect", onclick: () => act({ act: "connect" }) }, t("Connection move"));
  const mode = h("select", { id: "val3-mode", "aria-label": t("mode"), onchange: () => act({ act: "mode", value: mode.value }) }, ...["manual", "test", "local", "remote"].map((each) => h("option", { value: each }, t(each))));
  const speed = h("input", { id: "val3-speed", type: "number", min: "0", max: "100", "aria-label": t("monitor speed"), style: "width:5rem", onchange: () => act({ act: "speed", value: speed.value }) });
  const gone = h("p", { class: "badq", id: "val3-gone", role: "status" });
  const ask = h("form", { class: "card", id: "val3-prompt", hidden: true, onsubmit: (event) => { event.preventDefault(); answer(seen.kind === "prompt" ? `ok:${entry.value}` : "ok"); } });
  const question = h("p", {});
  const entry = h("input", { id: "val3-entry", "aria-label": t("entry"), maxlength: "128" });
  const cancel = h("button", { type: "button", id: "val3-cancel", onclick: () => answer("cancel") }, t("Cancel"));
  ask.append(question, entry, h("button", { type: "submit", id: "val3-ok" }, "OK"), cancel);
  // Keys of the pendant, while the text page has the focus: codes of s7.
  const codes = { Enter: "270", Escape: "255", ...Object.fromEntries([1, 2, 3, 4, 5, 6, 7, 8].map((n) => [`F${n}`, `${270 + n}`])) };
  const press = (event) => {
    const key = codes[event.key] || (event.key.length === 1 && !event.ctrlKey && !event.altKey && !event.metaKey ? event.key : "");
    if (!key || unable("operator")) return;
    event.preventDefault();
    act({ act: "key", value: key });
  };
  const screen = h("pre", { id: "val3-screen", "aria-label": t("Text page"), tabindex: "0", onkeydown: press });
  const popups = h("ul", { id: "val3-popups" });
  const popupsHead = h("h2", { hidden: true }, t("Popups"));
  const screenHead = h("h2", { hidden: true }, t("Text page"));
  const user = new UserPage(t("User page"), { act: (order) => act(order), image: async (file) => (await get(`${address(page)}&image=${encodeURIComponent(file)}`)).data, allowed: () => !unable("operator") });
  const variable = h("input", { id: "val3-name", "aria-label": t("variable"), placeholder: "nCount, sPart[2]", size: "14" });
  const value = h("input", { id: "val3-value", "aria-label": t("value"), size: "10" });
  const write = h("button", { type: "button", id: "val3-write", onclick: () => act({ act: "set", what: variable.value, value: value.value }) }, t("Write"));
  let name = "";
  let seen = {};
  let page = { name: "", folder: "" };
  const address = (of) => `/api/val3/page?folder=${encodeURIComponent(of.folder)}&name=${encodeURIComponent(of.name)}`;
  const act = (order) => post("/api/val3/act", order, "");
  const answer = (words) => { entry.value = ""; act({ act: "answer", value: words }); };
  const tasks = new Table([
    { title: t("task"), cell: text((row) => row.task) },
    { title: t("program"), cell: text((row) => row.program) },
    { title: t("line"), n: true, cell: text((row) => row.line) },
    { title: t("state"), free: true, cell: (row, td) => {
      const kind = row.error ? "bad" : row.state === "running" ? "good" : "";
      const box = td.firstElementChild || td.appendChild(chip(kind, t(row.state)));
      mark(box, `chip ${kind}`); put(box, row.error || t(row.state));
    } },
  ], (row) => row.task, { label: t("Tasks") });
  const variables = new Table([
    { title: t("variable"), cell: (row, td) => { const link = td.firstElementChild || td.appendChild(h("button", { type: "button", class: "value", onclick: () => { variable.value = row[0]; value.focus(); } })); put(link, row[0]); } },
    { title: t("type"), cell: text((row) => row[1]) },
    { title: t("value"), free: true, cell: text((row) => row[2]) },
  ], (row) => row[0], { tall: true, label: t("Variables") });

  async function load(wanted) {
    page = wanted;
    user.hide();
    if (!wanted.name) return;
    try {
      const reply = await get(address(wanted));
      if (wanted === page) user.show(reply.html);
    } catch (error) { put(gone, t(error.message)); }
  }

  root.append(h("div", { class: "grid" },
    h("section", { class: "card w5" }, h("div", { class: "bar" }, h("h2", { style: "margin:0", id: "val3-application" }, "VAL 3"), state, start, stop, hold, connect, mode, speed, "%"), gone, facts, ask, tasks.element, popupsHead, popups, screenHead, screen),
    h("section", { class: "card w7" }, user.element, h("h2", {}, t("Variables")), h("div", { class: "bar" }, variable, value, write), variables.element)));
  return {
    update(reply) {
      if (!reply) return;
      put(gone, reply.gone || (reply.id ? "" : t("The interpreter does not run.")));
      if (reply.gone) return;
      name = reply.programs[0]?.name || "";
      seen = { ...(reply.val3?.[0] || {}) };
      const fault = reply.programs[0]?.fault || "";
      const wrong = reply.processes.some((row) => row.error);
      put(document.getElementById("val3-application"), name || "VAL 3");
      mark(state, `chip ${fault || wrong ? "bad" : reply.run ? "good" : ""}`);
      put(state, fault ? `${t("faults")}: ${fault}` : reply.run ? t("running") : t("can run"));
      grey(start, unable("operator") || (fault ? t("The program has errors.") : reply.run ? t("running") : ""));
      grey(stop, unable("operator") || (reply.run ? "" : t("No application runs.")));
      put(hold, seen.hold ? t("Continue") : t("Hold"));
      if (seen.mode && document.activeElement !== mode) mode.value = seen.mode;
      if (seen.speed !== undefined && document.activeElement !== speed) speed.value = String(Math.round(seen.speed));
      for (const button of [hold, write, mode, speed]) grey(button, unable("operator") || (reply.run ? "" : t("No application runs.")));
      grey(connect, unable("operator") || (seen.connect ? "" : t("No connection move waits.")));
      put(facts, reply.run && seen.mode ? `${t("mode")} ${t(seen.mode)}, ${t("monitor speed")} ${Math.round(seen.speed)} %, ${t("move")} ${seen.move}, ${seen.powered ? t("powered") : t("no power")}` : "");
      ask.hidden = !seen.kind;
      put(question, seen.prompt || t("An entry is expected."));
      entry.hidden = seen.kind !== "prompt";
      cancel.hidden = seen.kind === "alert";
      put(screen, [seen.title, ...(reply.screen || [])].filter((line) => line !== undefined).join("\n"));
      popupsHead.hidden = !reply.popups?.length;
      screenHead.hidden = !screen.textContent.trim();
      popups.replaceChildren(...(reply.popups || []).map((words) => h("li", {}, words)));
      tasks.update(reply.processes);
      variables.update(reply.variables || []);
      const wanted = { name: seen.page || "", folder: seen.page ? seen.folder || "" : "" };
      if (wanted.name !== page.name || wanted.folder !== page.folder) load(wanted);
      user.draw(reply.shown || []);
    },
  };
}
