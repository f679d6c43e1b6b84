// The user page of a VAL 3 application in its sandboxed frame: draws attributes, reports presses, clicks and entries (AX-993, AX-1761).
import { h, put } from "./dom.js";

const TEXTS = /^(value|className|selectedIndex|min|max|step|target|title|placeholder|alt)$/;
const SWITCHES = /^(disabled|checked|readOnly)$/;
const ENTERED = /^(value|selectedIndex|options|checked)$/; // left alone while the operator is in the object
const PLAIN = /^[A-Za-z]\w*$/;
const TYPED = "input:not([type=button]):not([type=submit]):not([type=reset]):not([type=image]), select, textarea";
const CLICKED = "button, a[href], input, select, textarea, summary"; // the browser makes a click of Enter and Space itself

// options: act(order) -> promise, image(file) -> promise of a data URL, allowed() -> whether the person operates
export class UserPage {
  constructor(title, options) {
    this.element = h("iframe", { id: "val3-page", sandbox: "allow-same-origin", title, style: "width:100%;height:26rem;border:0;background:#fff", hidden: true });
    this.options = options;
    this.pressed = new Map(); // pointer or key -> object
    this.images = new Map(); // file -> promise
    this.sources = new WeakMap(); // image -> file
    this.orders = Promise.resolve(); // presses and releases arrive in their order
    this.rows = [];
    for (const kind of ["pointerup", "pointercancel"]) window.addEventListener(kind, (event) => this.free(event.pointerId));
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.release(); });
  }

  show(html) {
    this.hide();
    this.element.hidden = false;
    this.element.onload = () => this.listen();
    this.element.srcdoc = html;
  }

  hide() {
    this.release();
    this.images.clear();
    this.element.hidden = true;
  }

  send(order) {
    this.orders = this.orders.then(() => this.options.act(order)).catch(() => {});
  }

  press(by, what) {
    if (!what || this.pressed.has(by) || !this.options.allowed()) return;
    this.pressed.set(by, what);
    this.send({ act: "event", what, value: "mousedown" });
  }

  // Wherever the pointer is by now: the object that was pressed is released.
  free(by) {
    const what = this.pressed.get(by);
    if (this.pressed.delete(by)) this.send({ act: "event", what, value: "mouseup" });
  }

  release() {
    for (const by of [...this.pressed.keys()]) this.free(by);
  }

  click(what) {
    if (what && this.options.allowed()) this.send({ act: "event", what, value: "click" });
  }

  listen() {
    const inside = this.element.contentDocument;
    if (!inside) return;
    const around = (event) => event.target?.closest?.("[id]")?.id;
    const key = (event) => (event.key === " " || event.key === "Enter") && !event.target?.matches?.(TYPED);
    inside.addEventListener("pointerdown", (event) => { if (event.button === 0) this.press(event.pointerId, around(event)); });
    for (const kind of ["pointerup", "pointercancel"]) inside.addEventListener(kind, (event) => this.free(event.pointerId));
    inside.addEventListener("click", (event) => this.click(around(event)));
    inside.addEventListener("keydown", (event) => { if (key(event) && !event.repeat) this.press(event.key, around(event)); });
    inside.addEventListener("keyup", (event) => {
      const own = this.pressed.has(event.key) && !event.target?.matches?.(CLICKED);
      this.free(event.key);
      if (own) this.click(around(event));
    });
    inside.addEventListener("change", (event) => { const what = event.target?.id; if (what && this.options.allowed()) this.send({ act: "enter", what, attribute: "value", value: String(event.target.value) }); });
    inside.addEventListener("submit", (event) => event.preventDefault());
    inside.defaultView?.addEventListener("blur", () => this.release());
    this.draw(this.rows);
  }

  draw(rows) {
    this.rows = rows;
    const inside = this.element.contentDocument;
    if (!inside || this.element.hidden) return;
    const lists = new Map();
    for (const [what, attribute, words] of rows) {
      const element = inside.getElementById(what);
      if (!element || (ENTERED.test(attribute) && inside.activeElement === element)) continue;
      if (attribute === "options") lists.set(element, [...(lists.get(element) || []), words]);
    }
    for (const [element, texts] of lists) options(inside, element, texts);
    for (const [what, attribute, words] of rows) {
      const element = inside.getElementById(what);
      if (element && !(ENTERED.test(attribute) && inside.activeElement === element)) this.attribute(element, attribute, words);
    }
  }

  attribute(element, attribute, words) {
    const [group, inner = ""] = attribute.split(".");
    if (attribute === "innerHTML" || attribute === "textContent") put(element, words);
    else if (group === "style") { if (PLAIN.test(inner) && inner !== "cssText" && !/url\(|image-set\(/i.test(words)) element.style[inner] = words; }
    else if (group === "dataset") { if (PLAIN.test(inner)) element.dataset[inner] = words; }
    else if (attribute === "src") this.source(element, words);
    else if (attribute === "href") { if (words.startsWith("#")) element.setAttribute("href", words); }
    else if (SWITCHES.test(attribute)) element[attribute] = !["", "0", "false"].includes(words);
    else if (TEXTS.test(attribute) && String(element[attribute]) !== words) element[attribute] = attribute === "selectedIndex" ? Number(words) : words;
  }

  async source(element, file) {
    if (element.tagName !== "IMG" || this.sources.get(element) === file) return;
    this.sources.set(element, file);
    if (!this.images.has(file)) this.images.set(file, file.startsWith("data:image/") ? file : this.options.image(file));
    try {
      const data = await this.images.get(file);
      if (this.sources.get(element) === file) element.src = data;
    } catch { if (this.sources.get(element) === file) element.removeAttribute("src"); }
  }
}

function options(inside, element, texts) {
  if (element.tagName !== "SELECT" || (element.options.length === texts.length && texts.every((each, at) => element.options[at].text === each))) return;
  element.replaceChildren(...texts.map((each) => { const option = inside.createElement("option"); option.textContent = each; return option; }));
}
