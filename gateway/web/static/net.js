// Requests and the live connection, which comes back by itself.
import { say, t } from "./texts.js";

const SILENT_MS = 2200; // ten looks a second come: so long without one is a lost connection, whatever the socket says
const OPEN_MS = 4000; // a hung process takes a connection and never answers
const STOP_MS = 3000;
const ANSWER_MS = 15000;
export const me = { name: "", role: "nobody", csrf: "", holds: false };
const ROLES = ["nobody", "viewer", "operator", "setter", "admin"];

export function may(role) {
  return !me.read_only && ROLES.indexOf(me.role) >= ROLES.indexOf(role);
}

// Why this person may not do what takes the role; "": may.
export function unable(role) {
  if (may(role)) return "";
  if (me.read_only) return t("The page is read-only; stop on the path remains available.");
  if (me.fresh) return t("Set the first password.");
  if (me.name === "local" || me.name === "nobody") return `${t("Log in first; role required:")} ${t(role)}.`;
  return `${t("Role required:")} ${t(role)}; ${me.name}: ${t(me.role)}.`;
}

export async function get(path) {
  return answer(await fetch(path));
}

export async function post(path, body) {
  const headers = { "x-axisgate": "1", "x-axisgate-csrf": me.csrf };
  if (body !== undefined) headers["content-type"] = "application/json";
  const limit = AbortSignal.timeout(path === "/api/stop" ? STOP_MS : ANSWER_MS);
  const response = await fetch(path, { method: "POST", headers, body: body === undefined ? undefined : JSON.stringify(body), signal: limit }).catch(() => { throw new Error(path === "/api/stop" ? t("STOP did not arrive: use the emergency stop.") : t("The gateway does not answer.")); });
  return answer(response);
}

async function answer(response) {
  const reply = await response.json().catch(() => ({}));
  if (!response.ok) throw Object.assign(new Error(say(reply.say) || reply.error || `HTTP ${response.status}`), { status: response.status });
  return reply;
}

export async function whoami() {
  Object.assign(me, await get("/api/me"));
  return me;
}

export class Live {
  constructor(take, state) {
    this.take = take;
    this.state = state;
    this.wanted = { t: "page", name: "overview", watch: [] };
    this.wait = 200;
    this.connect();
    setInterval(() => { if (me.holds) this.send({ t: "alive" }); }, 300);
    setInterval(() => this.look(), 250);
  }

  // A socket to a black hole closes itself after half a minute only: it is left, and another one tried.
  look() {
    const limit = this.open ? SILENT_MS : OPEN_MS;
    if (!this.socket || Date.now() - this.heard <= limit) return;
    const old = this.socket;
    this.socket = null;
    this.ended("", 0);
    old.close();
  }

  ended(reason, code) {
    this.open = false;
    this.at = undefined;
    this.state(false, reason, code);
    clearTimeout(this.again);
    this.again = setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(2000, this.wait * 1.6);
  }

  connect() {
    clearTimeout(this.again);
    this.heard = Date.now();
    const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
    this.socket = socket;
    socket.onopen = () => { this.open = true; this.wait = 200; this.heard = Date.now(); socket.send(JSON.stringify(this.wanted)); };
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      this.heard = Date.now();
      const message = JSON.parse(event.data);
      if (message.t === "live") { this.at = message.at; this.state(true, ""); }
      this.take(message);
    };
    socket.onclose = (event) => {
      if (socket !== this.socket) return;
      this.ended(event.reason, event.code);
    };
  }

  renew() {
    const old = this.socket;
    this.socket = null;
    old?.close();
    this.connect();
  }

  page(name, watch = []) {
    this.wanted = { t: "page", name, watch };
    this.send(this.wanted);
  }

  send(message) {
    if (this.open && this.socket && this.socket.readyState === 1) this.socket.send(JSON.stringify(message));
  }
}
