// Values somebody wants to see together: starred in the list of signals, kept on the gateway under a name; the last one also in the browser.
import { grey, h, mark } from "./dom.js";

const MOST = 200;

// What is kept of one kind (watch, scope): choose, keep under a name, remove.
export class Kept {
  constructor({ t, get, post, unable }, kind, { made, chosen }) {
    Object.assign(this, { t, get, post, unable, kind, chosen });
    this.rows = [];
    this.select = h("select", { id: `${kind}-kept`, "aria-label": t(`kept: ${kind}`), onchange: () => this.choose() });
    this.name = h("input", { id: `${kind}-name`, maxlength: "60", placeholder: t("name"), "aria-label": t("name"), style: "width:9rem" });
    this.keep = h("button", { type: "button", id: `${kind}-keep`, onclick: async () => { if (!this.name.value.trim()) { this.name.focus(); return; } await this.order("/api/kept", { name: this.name.value.trim(), value: JSON.stringify(made()) }, "Saved"); } }, t("Save"));
    this.drop = h("button", { type: "button", class: "danger", id: `${kind}-drop`, onclick: () => this.order("/api/kept/drop", { name: this.select.value }, "Removed") }, t("remove"));
    this.element = h("span", { class: "bar kept", style: "margin:0" }, this.select, this.name, this.keep, this.drop);
    this.fill([]);
    get(`/api/kept?kind=${kind}`).then((reply) => this.fill(reply.kept)).catch(() => {});
  }

  async order(path, body, done) {
    const reply = await this.post(path, { kind: this.kind, ...body }, done);
    if (reply) this.fill(reply.kept, body.value ? body.name : "");
  }

  fill(rows, name = this.select.value) {
    this.rows = rows;
    this.select.replaceChildren(h("option", { value: "" }, this.t(`kept: ${this.kind}`)), ...rows.map((row) => h("option", { value: row.name, selected: row.name === name }, row.name)));
    this.update();
  }

  choose() {
    const row = this.rows.find((each) => each.name === this.select.value);
    this.name.value = row ? row.name : "";
    this.update();
    if (!row) return;
    try { this.chosen(JSON.parse(row.value)); } catch { /* what another page wrote */ }
  }

  update() {
    const why = this.unable("operator");
    grey(this.keep, why);
    grey(this.drop, why || (this.select.value ? "" : this.t("Choose one first.")));
  }
}

export class WatchList {
  constructor(ctx, changed) {
    this.t = ctx.t;
    this.changed = changed;
    this.open = false;
    try { this.ids = JSON.parse(localStorage.getItem("watch") || "[]"); } catch { this.ids = []; }
    if (!Array.isArray(this.ids)) this.ids = [];
    this.button = h("button", { type: "button", id: "watch", "aria-pressed": "false", onclick: () => { this.open = !this.open; this.show(); ctx.find(); } });
    this.kept = new Kept(ctx, "watch", { made: () => this.ids, chosen: (ids) => { this.set(Array.isArray(ids) ? ids.filter((id) => typeof id === "string").slice(0, MOST) : []); this.open = true; this.show(); ctx.find(); } });
    this.element = h("div", { class: "bar" }, this.button, this.kept.element);
    this.show();
  }

  set(ids) {
    this.ids = ids;
    try { localStorage.setItem("watch", JSON.stringify(ids)); } catch { /* no storage */ }
    this.show();
  }

  show() {
    this.button.textContent = `\u2605 ${this.t("Watch list")} (${this.ids.length})`;
    this.button.setAttribute("aria-pressed", String(this.open));
  }

  close() { if (this.open) { this.open = false; this.show(); } }

  star(id) {
    return h("button", { type: "button", class: "star", "data-star": id, onclick: () => { const there = this.ids.includes(id); if (!there && this.ids.length >= MOST) return; this.set(there ? this.ids.filter((each) => each !== id) : [...this.ids, id]); this.changed(); } });
  }

  mark(button, id) {
    const there = this.ids.includes(id);
    mark(button, there ? "star on" : "star");
    const words = there ? "\u2605" : "\u2606";
    if (button.textContent !== words) { button.textContent = words; button.setAttribute("aria-pressed", String(there)); button.setAttribute("aria-label", `${this.t("Watch list")}: ${id}`); }
  }

  update() { this.kept.update(); }
}
