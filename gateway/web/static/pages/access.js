// Who may do what; tokens for scripts; the chained audit.
import { Table, chip, h, put, text } from "../dom.js";
import { language } from "../texts.js";

export function mount(root, { t, get, post, me, may, login }) {
  const own = h("section", { class: "card w12" }, h("h2", {}, t("You")), h("p", {}, `${me.name}: ${t(me.role)}${me.local ? `, ${t("at the gateway itself")}` : ""}`),
    me.read_only ? h("p", { class: "badq" }, t("The page is read-only; stop on the path remains available.")) : null,
    h("p", { class: "soft" }, t("Viewing and stopping need no password. Operators move axes, setters force signals and simulate, administrators manage access.")),
    may("viewer") && me.name !== "local" ? null : h("button", { type: "button", class: "main", onclick: login }, me.fresh ? t("Set the first password") : t("Log in")));
  const grid = h("div", { class: "grid" }, own);
  root.append(grid);
  if (!may("admin")) return {};
  const roles = () => h("select", { name: "role" }, ["viewer", "operator", "setter", "admin"].map((role) => h("option", { value: role }, t(role))));
  const form = (title, path, fields, done) => {
    const made = h("form", { class: "bar low", onsubmit: async (event) => { event.preventDefault(); const reply = await post(path, Object.fromEntries(new FormData(made)), done); if (reply) { made.reset(); if (reply.token) put(secret, `${t("The token, shown once")}: ${reply.token}`); fill(); } } }, fields, h("button", { class: "main" }, title));
    return made;
  };
  const input = (title, attributes) => h("label", {}, title, h("input", { required: true, maxlength: "64", ...attributes }));
  const secret = h("p", { class: "mono", id: "token" });
  const users = new Table([
    { title: t("Name"), cell: text((row) => row.name) }, { title: t("role"), cell: text((row) => t(row.role)) },
    { title: "", cell: (row, td) => { if (!td.firstChild) td.append(h("button", { type: "button", class: "tiny danger", onclick: async () => { await post("/api/users/drop", { name: row.name }, "The user is removed"); fill(); } }, t("remove"))); } },
  ], (row) => row.name, { label: t("Users") });
  const tokens = new Table([
    { title: t("label"), cell: text((row) => row.label) }, { title: t("role"), cell: text((row) => t(row.role)) }, { title: t("since"), cell: text((row) => row.made.slice(0, 16)) },
    { title: "", cell: (row, td) => { if (!td.firstChild) td.append(h("button", { type: "button", class: "tiny danger", onclick: async () => { await post("/api/tokens/drop", { name: row.label }, "The token is revoked"); fill(); } }, t("remove"))); } },
  ], (row) => row.label, { label: t("Tokens") });
  const audit = new Table([
    { title: t("number"), n: true, cell: text((row) => row.number) }, { title: t("time"), cell: (row, td) => { put(td, moment(row.wall)); td.style.whiteSpace = "nowrap"; } }, { title: t("who"), cell: text((row) => row.who) },
    { title: t("origin"), cell: text((row) => row.source) }, { title: t("what"), free: true, cell: text((row) => row.say[language() === "de" ? 1 : 0]) },
    { title: t("details"), cell: (row, td) => { if (!td.firstChild) td.append(h("details", { class: "small" }, h("summary", {}, t("more")), h("div", { class: "mono kept" }, `${row.what} ${row.detail}`), h("div", { class: "mono kept" }, `${t("hash")} ${row.hash}`))); } },
  ], (row) => row.number, { tall: true, label: t("Audit") });
  const moment = (wall) => new Date(wall).toLocaleString(language() === "de" ? "de-DE" : "sv-SE");
  const words = h("input", { type: "search", id: "audit-words", placeholder: t("filter"), "aria-label": t("filter"), oninput: () => sift() });
  let entries = [];
  const sift = () => audit.update(entries.filter((row) => [row.who, row.source, row.what, row.detail, ...row.say].join(" ").toLowerCase().includes(words.value.toLowerCase())));
  const chain = h("span");
  grid.append(
    h("section", { class: "card w6" }, h("h2", {}, t("Users")), users.element, form(t("Save"), "/api/users", [input(t("Name"), { name: "name", autocomplete: "off" }), h("label", {}, t("role"), roles()), input(t("Password"), { name: "password", type: "password", minlength: "10", autocomplete: "new-password" })], "The user is saved")),
    h("section", { class: "card w6" }, h("h2", {}, t("Tokens for scripts")), tokens.element, form(t("Create"), "/api/tokens", [input(t("label"), { name: "label" }), h("label", {}, t("role"), roles())]), secret),
    h("section", { class: "card w12" }, h("div", { class: "bar" }, h("h2", { style: "margin:0" }, t("Audit")), chain, words), audit.element));
  async function fill() {
    const [reply, kept] = await Promise.all([get("/api/users"), get("/api/audit")]);
    users.update(reply.users);
    tokens.update(reply.tokens);
    entries = kept.entries;
    sift();
    chain.replaceChildren(kept.broken_at === null ? chip("good", t("the chain is intact")) : chip("bad", `${t("the chain is broken at entry")} ${kept.broken_at}`));
  }
  fill().catch((error) => put(secret, error.message));
  return {};
}
