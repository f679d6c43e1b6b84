// The frame around the pages: navigation, state, stop, language, theme, login.
import { Live, get, may, me, post, unable, whoami } from "./net.js";
import { opened } from "./dialog.js";
import { chip, h, mark, put, toast } from "./dom.js";
import { language, say, setLanguage, t } from "./texts.js";

const PAGES = [
  ["overview", "Overview"], ["axes", "Axes"], ["motion", "Motion"], ["programs", "Programs"], ["val3", "VAL 3"], ["plc", "PLC"], ["pendant", "Pendant"], ["signals", "Signals"], ["scope", "Scope"], ["lines", "Lines"], ["bus", "Bus"],
  ["events", "Events"], ["cell", "Cell"], ["emulator", "Emulator"], ["access", "Access"],
];
const MOTION = ["at rest", "moving", "stopping", "stopped on the path", "referencing"];
const ctx = { cell: null, head: null, t, get, post: order, may, unable, me, changeControl, live: null, toast, login, refresh };
const FIRST = /^\/api\/(command|program|force|unforce|set|users|tokens)/;
let view = null;
let name = "";

async function order(path, body, done) {
  if (me.fresh && !path.endsWith("/stop")) await whoami().catch(() => {});
  if (me.fresh && me.local && !may("operator") && FIRST.test(path)) { login(); return null; } // before the first change, not after its refusal
  try {
    const reply = await post(path, body);
    if (reply.state === "REFUSED" || reply.state === "ABORTED") toast(`${t("refused")}: ${said(reply)}`, "bad");
    else if (done) toast(t(done), "good");
    return reply;
  } catch (error) {
    toast(t(error.message), "bad");
    if (error.status === 401) login();
    return null;
  }
}

// Requests control, or releases it; only a page that knows it is in control reports that it is alive.
async function changeControl() {
  await order("/api/command", { code: me.holds ? "release_control" : "request_control" });
  await whoami();
}

// A refusal in the words of the page's language.
function said(reply) {
  return reply.say?.[language() === "de" ? 1 : 0] || reply.detail || reply.words;
}

function nav() {
  const links = PAGES.filter(([page]) => (page !== "emulator" || ctx.cell?.simulated) && (page !== "programs" || ctx.cell?.programs) && (page !== "val3" || ctx.cell?.val3) && (page !== "plc" || ctx.cell?.plc) && (page !== "pendant" || ctx.cell?.pendant)).map(([page, title]) =>
    h("a", { href: `/${page}`, id: `nav-${page}`, "aria-current": page === name ? "page" : undefined, onclick: (event) => go(event, page) },
      h("span", {}, t(title)), page === "events" ? h("span", { class: "count", id: "errors", hidden: true }) : page === "signals" ? h("span", { class: "count f", id: "forces", hidden: true }) : null));
  const dark = document.documentElement.dataset.theme === "dark";
  const more = h("div", { class: "more" },
    h("button", { type: "button", id: "language", lang: language() === "de" ? "en" : "de", onclick: () => { setLanguage(language() === "de" ? "en" : "de"); whole(); } }, language() === "de" ? "English" : "Deutsch"),
    h("button", { type: "button", id: "theme", onclick: theme }, dark ? t("Light") : t("Dark")),
    me.name === "local" || me.name === "nobody"
      ? h("button", { type: "button", id: "login", onclick: login }, me.fresh ? t("Set password") : t("Log in"))
      : h("button", { type: "button", id: "logout", onclick: logout }, `${t("Log out")} ${me.name}`));
  document.getElementById("nav").replaceChildren(...links, more);
  document.querySelector("#nav a[aria-current]")?.scrollIntoView({ inline: "center", block: "nearest" });
}

function theme() {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  document.documentElement.dataset.theme = next;
  try { localStorage.setItem("theme", next); } catch { /* no storage */ }
  nav();
  view?.theme?.();
}

function go(event, page) {
  if (event.ctrlKey || event.metaKey || event.shiftKey) return;
  event.preventDefault();
  history.pushState(null, "", `/${page}`);
  show();
}

async function show() {
  const wanted = location.pathname.slice(1) || "overview";
  name = PAGES.some(([page]) => page === wanted) ? wanted : "overview";
  view?.unmount?.();
  view = null;
  nav();
  const mine = name;
  const module = await import(`./pages/${name}.js`);
  if (mine !== name) return;
  const root = document.getElementById("page");
  root.replaceChildren(h("h1", {}, t(PAGES.find(([page]) => page === name)[1])));
  document.title = `${t(PAGES.find(([page]) => page === name)[1])} - axisgate`;
  view = module.mount(root, ctx);
  ctx.live.page(name, view.watch?.() || []);
  document.body.dataset.page = name;
}

function head(state) {
  ctx.head = state;
  const chips = [];
  if (ctx.cell?.simulated) chips.push(chip("plain", t("simulation")));
  if (!state.cycle_alive) chips.push(chip("bad", t("cycle does not run")));
  if (!state.services_alive) chips.push(chip("bad", t("services start again")));
  if (state.emergency) chips.push(chip("bad", t("emergency stop latched")));
  for (const [link, alive] of state.links) chips.push(alive === null ? chip("warn", `${link} ${t("not known")}`) : chip(alive ? "good" : "bad", `${link} ${alive ? t("alive") : t("silent")}`));
  const fresh = state.cycle_alive && state.services_alive; // what a dead process said last is no state
  chips.push(chip(state.ready && fresh ? "good" : "warn", fresh ? (state.ready ? t("ready") : t("not ready")) : `${t("ready")}: ${t("not known")}`));
  chips.push(chip(state.enabled ? "good" : "plain", `${t("drives on")} ${state.enabled}/${state.axes}`));
  chips.push(chip(state.motion ? "warn" : "plain", t(MOTION[state.motion])));
  chips.push(chip("plain", `${t("override")} ${state.override} %`));
  if (state.forced) chips.push(chip("forced", `${state.forced} ${t("forced")}`));
  const words = chips.map((each) => each.className + each.textContent).join();
  const bar = document.getElementById("state");
  if (bar.dataset.words !== words) { bar.dataset.words = words; bar.replaceChildren(...chips); }
  badge("errors", state.errors.length);
  badge("forces", state.forced);
}

function badge(id, count) {
  const element = document.getElementById(id);
  if (!element) return;
  element.hidden = !count;
  put(element, count);
}

function take(message) {
  if (message.t === "live") {
    if (message.head) head(message.head);
    if (me.holds && message.head && message.head.holder !== me.name) whoami().catch(() => {});
    if (message.name === name) view?.update?.(message.page, message.head, message.values);
  } else if (message.t === "answer") {
    const refused = message.error ? say(message.say) || t(message.error) : ["REFUSED", "ABORTED", "ENDED"].includes(message.held?.state) ? said(message.held) : "";
    if (refused && (view?.refused ? view.refused() : true)) toast(refused, "bad");
  }
}

function connected(up, reason, code) {
  let bar = document.getElementById("lost");
  if (up) {
    document.body.classList.remove("gone");
    if (bar) { bar.remove(); whoami().then(nav).catch(() => {}); }
    return;
  }
  document.body.classList.add("gone");
  view?.lift?.();
  document.getElementById("state").replaceChildren(chip("bad", t("no connection")));
  document.getElementById("state").dataset.words = "";
  if (code === 4403) login();
  if (!bar) { bar = h("div", { class: "lost", id: "lost", role: "alert" }); document.body.append(bar); }
  put(bar, reason || t("Connection lost: values are stale. The page reconnects automatically."));
}

function field(label, attributes) {
  return h("label", {}, label, h("input", { required: true, ...attributes }));
}

async function login() {
  const dialog = document.getElementById("dialog");
  if (dialog.open) return;
  await whoami().catch(() => {}); // somebody else may have set the first password meanwhile
  const fresh = me.fresh;
  const form = h("form", { method: "dialog", onsubmit: async (event) => {
    event.preventDefault();
    const data = Object.fromEntries(new FormData(form));
    try {
      await post(fresh ? "/api/setup" : "/api/login", data);
      dialog.close();
      await refresh();
      toast(`${t("Logged in as")} ${me.name} (${t(me.role)})`, "good");
    } catch (error) { put(form.querySelector(".wrong"), error.message); }
  } },
  h("h2", {}, fresh ? t("Set the first password") : t("Log in")),
  fresh ? h("p", { class: "soft" }, t("Until then, nothing can be changed. The first user is the administrator; 10 characters or more.")) : null,
  field(t("Name"), { name: "name", autocomplete: "username", autofocus: true, pattern: "[A-Za-z0-9_.@\\-]+", maxlength: "64" }),
  field(t("Password"), { name: "password", type: "password", autocomplete: fresh ? "new-password" : "current-password", minlength: fresh ? "10" : "1" }),
  h("p", { class: "wrong badq", role: "alert" }),
  h("div", { class: "bar" }, h("button", { class: "main", id: "send" }, fresh ? t("Set password") : t("Log in")),
    h("button", { type: "button", onclick: () => dialog.close() }, t("Cancel"))));
  dialog.replaceChildren(form);
  opened(dialog);
}

async function logout() {
  await order("/api/logout");
  await refresh();
}

async function refresh() {
  await whoami();
  ctx.live.renew();
  whole();
}

function whole() {
  document.documentElement.lang = language();
  put(document.getElementById("skip"), t("To the content"));
  put(document.getElementById("stop"), t("STOP"));
  document.getElementById("stop").title = t("Stops all axes on the path. Not an emergency stop.");
  put(document.getElementById("foot"), t("SAFETY"));
  show();
}

function stop() {
  view?.lift?.(); // a key that is held moves nothing before it was released
  order("/api/stop", undefined, "Stop requested");
}

document.getElementById("stop").addEventListener("click", stop);
addEventListener("popstate", show);
addEventListener("click", (event) => { const value = event.target.closest?.("[data-trend]"); if (value) import("./hours.js").then(({ hours }) => hours(value.dataset.trend)).catch((error) => toast(error.message, "bad")); });
addEventListener("keydown", (event) => {
  if (event.key === "Escape" && event.shiftKey) stop();
  if (event.altKey && /^[0-9]$/.test(event.key)) document.querySelectorAll("#nav a")[(Number(event.key) + 9) % 10]?.click();
  if (event.key === "/" && !/INPUT|SELECT|TEXTAREA/.test(event.target.tagName)) { const search = document.querySelector("input[type=search]"); if (search) { event.preventDefault(); search.focus(); } }
});

(async () => {
  document.documentElement.lang = language();
  put(document.getElementById("foot"), t("SAFETY"));
  try {
    await whoami();
    ctx.cell = await get("/api/cell");
    if (!localStorage.getItem("language")) setLanguage(ctx.cell.language, true);
    put(document.getElementById("cell"), ctx.cell.name);
  } catch (error) {
    ctx.cell = { axes: [], command_sources: [], lines: [], buses: [], faults: [], evidence: [], notices: [], wiring: [], blocks: [], robot: {}, simulated: false };
    if (error.status !== 401) toast(error.message, "bad");
  }
  ctx.live = new Live(take, connected);
  whole();
  if (me.role === "nobody") login();
})();
export { mark };
