// Requests and the live connection, which comes back by itself.
export const me = { name: "", role: "nobody", csrf: "", holds: false };
const ROLES = ["nobody", "viewer", "operator", "setter", "admin"];

export function may(role) {
  return !me.read_only && ROLES.indexOf(me.role) >= ROLES.indexOf(role);
}

export async function get(path) {
  return answer(await fetch(path));
}

export async function post(path, body) {
  const headers = { "x-axisgate": "1", "x-axisgate-csrf": me.csrf };
  if (body !== undefined) headers["content-type"] = "application/json";
  return answer(await fetch(path, { method: "POST", headers, body: body === undefined ? undefined : JSON.stringify(body) }));
}

async function answer(response) {
  const told = await response.json().catch(() => ({}));
  if (!response.ok) throw Object.assign(new Error(told.error || `HTTP ${response.status}`), { status: response.status });
  return told;
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
    setInterval(() => { if (this.open && Date.now() - this.heard > 3000) this.socket.close(); }, 1000);
  }

  connect() {
    clearTimeout(this.again);
    const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
    this.socket = socket;
    socket.onopen = () => { this.open = true; this.wait = 200; this.heard = Date.now(); socket.send(JSON.stringify(this.wanted)); };
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      this.heard = Date.now();
      const message = JSON.parse(event.data);
      if (message.t === "live") this.state(true, "");
      this.take(message);
    };
    socket.onclose = (event) => {
      if (socket !== this.socket) return;
      this.open = false;
      this.state(false, event.reason, event.code);
      this.again = setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(2000, this.wait * 1.6);
    };
  }

  renew() {
    const old = this.socket;
    this.socket = null;
    old.close();
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
