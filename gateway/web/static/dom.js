// Small helpers: elements, numbers, tables whose rows live on and only change their texts.
import { t } from "./texts.js";

export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "class") element.className = value;
    else if (name in element && typeof value !== "string") element[name] = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

export function put(element, text) {
  const words = String(text);
  if (element.textContent !== words) element.textContent = words;
}

export function mark(element, name) {
  if (element.className !== name) element.className = name;
}

export function number(value, digits = 3) {
  return value === null || value === undefined ? "" : Number(value).toFixed(digits);
}

// A button that cannot be used now, and why: the reason is its tooltip, and what a screen reader says.
export function grey(button, why) {
  if (button.disabled !== Boolean(why)) button.disabled = Boolean(why);
  if (button.dataset.plain === undefined) button.dataset.plain = button.title;
  const words = why || button.dataset.plain;
  if (button.title !== words) button.title = words;
}

export function chip(kind, text) {
  return h("span", { class: `chip ${kind}` }, text);
}

export function facts(pairs) {
  return h("dl", { class: "facts" }, pairs.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value instanceof Node ? value : String(value))]));
}

// columns: [{ title, n: right-aligned, free: may break anywhere, cell: (row, td) => writes into td }]; rows are known by key(row).
export class Table {
  constructor(columns, key, options = {}) {
    this.columns = columns;
    this.key = key;
    this.options = options;
    this.rows = new Map();
    this.body = h("tbody");
    const heads = columns.map((column) => h("th", { class: column.n ? "n" : "", scope: "col" }, column.title));
    this.element = h("div", { class: `scroll ${options.tall ? "tall" : ""}`, tabindex: options.tall ? "0" : undefined, role: "region", "aria-label": options.label },
      h("table", {}, h("thead", {}, h("tr", {}, heads)), this.body));
  }

  update(rows) {
    const wanted = new Set(rows.map((row) => String(this.key(row))));
    for (const [key, tr] of this.rows) if (!wanted.has(key)) { tr.remove(); this.rows.delete(key); }
    let before = null;
    for (const row of rows) {
      const key = String(this.key(row));
      let tr = this.rows.get(key);
      if (!tr) {
        tr = h("tr", {}, this.columns.map((column) => h("td", { class: column.n ? "n" : column.free ? "free" : "" })));
        this.rows.set(key, tr);
      }
      const place = before ? before.nextSibling : this.body.firstChild;
      if (place !== tr) this.body.insertBefore(tr, place);
      this.columns.forEach((column, i) => column.cell(row, tr.children[i]));
      if (this.options.row) mark(tr, this.options.row(row) || "");
      before = tr;
    }
  }
}

export const text = (get, digits) => (row, td) => put(td, digits === undefined ? get(row) ?? "" : number(get(row), digits));

// A value whose trend over hours is one click away; id: what the page watches it by.
export const trended = (id, get, digits) => (row, td) => trendValue(td, id(row), digits === undefined ? get(row) ?? "" : number(get(row), digits));

export function trendValue(td, id, words) {
  const button = td.firstElementChild || td.appendChild(h("button", { type: "button", class: "value", title: t("trend over hours") }));
  if (button.dataset.trend !== id) button.dataset.trend = id;
  put(button, words);
}

const MOST_TOASTS = 3; // more would grow over the page, and over STOP

export function toast(words, kind = "") {
  const toasts = document.getElementById("toasts");
  for (const other of [...toasts.children]) if (other.textContent === words) other.remove();
  while (toasts.children.length >= MOST_TOASTS) toasts.firstChild.remove();
  const box = h("div", { class: `toast ${kind}` }, words);
  toasts.append(box);
  setTimeout(() => box.remove(), kind === "bad" ? 9000 : 4000);
}
