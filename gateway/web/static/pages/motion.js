// The robot and its path in three dimensions; override, feed hold, what waits.
import { Table, facts, grey, h, put, text, trended } from "../dom.js";
import { say } from "../texts.js";

const TRAIL = 600;

export function mount(root, { t, cell, me, post, changeControl, unable }) {
  const canvas = h("div", { class: "canvas", id: "robot", role: "img", "aria-label": t("robot and path") });
  const order = (code, more = {}) => post("/api/command", { code, mask: 2 ** cell.axes.length - 1, ...more });
  const override = h("input", { type: "range", min: "0", max: "100", step: "1", value: "100", style: "width:14rem", "aria-label": t("override"), oninput: () => { turning = Date.now() + 1500; }, onchange: () => order("override", { velocity: Number(override.value) / 100 }) });
  const hold = h("button", { type: "button", id: "hold", onclick: () => post("/api/stop", undefined, "Stop requested") }, t("Feed hold"));
  const resume = h("button", { type: "button", onclick: () => order("resume") }, t("Resume"));
  const abandon = h("button", { type: "button", onclick: () => order("abandon") }, t("Abandon rest"));
  const control = h("button", { type: "button", class: "main", onclick: changeControl });
  const wipe = h("button", { type: "button", onclick: () => { trail.length = 0; } }, t("Clear the trace"));
  const names = h("button", { type: "button", id: "names", "aria-pressed": "true", onclick: () => { named = !named; names.setAttribute("aria-pressed", String(named)); scene?.name(named); } }, t("Names and frames"));
  let named = true;
  const queue = h("div");
  const table = new Table([
    { title: t("axis"), cell: text((row) => row.name) }, { title: t("actual"), n: true, cell: trended((row) => `axis.${row.name}.actual`, (row) => row.actual, 3) }, { title: t("set"), n: true, cell: trended((row) => `axis.${row.name}.set`, (row) => row.set, 3) }, { title: t("speed"), n: true, cell: trended((row) => `axis.${row.name}.speed`, (row) => row.speed, 1) },
  ], (row) => row.name, { label: t("Axes") });
  const trail = [];
  let scene = null;
  let gone = false;
  let turning = 0; // the slider is in somebody's hand until then
  let marked = [];
  let lines = null; // a robot at rest is sent once: the drawing may be made later
  root.append(h("div", { class: "bar low" }, control, hold, resume, abandon, h("label", {}, `${t("override")} %`, override), wipe, names),
    h("div", { class: "grid" },
      h("section", { class: "card w8" }, canvas, h("p", { class: "soft small" }, t(cell.robot.why) || `${cell.robot.kind} ${cell.robot.model}`), h("p", { class: "soft small" }, t("Drag or use the arrow keys to rotate; use the wheel or + and - to zoom.")), h("p", { class: "soft small" }, t("Frames: x red, y green, z blue."))),
      h("section", { class: "card w4" }, h("h2", {}, t("Motion")), queue, h("div", { style: "height:.7rem" }), table.element)));
  import("../robot3d.js").then(({ Robot3d }) => { if (gone) return; scene = new Robot3d(canvas, cell.robot.reach || 1, t); if (!named) scene.name(false); if (lines) scene.show(lines, trail, ...marked); })
    .catch((error) => canvas.append(h("p", { class: "badq", style: "padding:1rem" }, `${t("This browser does not support 3D graphics")}: ${error.message}`)));
  return {
    update(page, head) {
      put(control, me.holds ? t("Release control") : t("Request control"));
      grey(control, unable("operator"));
      for (const button of [resume, abandon, override]) grey(button, unable("operator") || (me.holds ? "" : t("Request control.")));
      if (Date.now() > turning) override.value = String(Math.round(head.override));
      if (!page || page.gone) return;
      table.update(page.axes);
      const words = [[t("state"), t(["at rest", "moving", "stopping", "stopped on the path", "referencing"][head.motion])], [t("override"), `${head.override} %`], [t("order"), page.job || "-"], [t("progress"), page.job ? `${Math.round(page.progress * 100)} %` : "-"]];
      const q = page.queue;
      if ("waiting" in q) words.push([t("program"), q.job || "-"], [t("block"), q.block || "-"], [t("blocks waiting"), q.waiting], [t("pieces passed on"), q.handed], [t("fault"), say(q.fault) || "-"], [t("warning"), say(q.warning) || "-"]);
      else words.push([t("queue"), t("no planner in this cell: one move at a time")]);
      const key = JSON.stringify(words);
      if (queue.dataset.key !== key) { queue.dataset.key = key; queue.replaceChildren(facts(words)); }
      const tip = page.lines[0]?.at(-1);
      const last = trail.at(-1);
      if (tip && (!last || Math.hypot(tip[0] - last[0], tip[1] - last[1], tip[2] - last[2]) > 5e-4)) { trail.push(tip); if (trail.length > TRAIL) trail.shift(); }
      lines = page.lines;
      marked = [page.frames, page.marks];
      scene?.show(lines, trail, ...marked);
    },
    theme: () => scene?.theme(),
    unmount() { gone = true; scene?.close(); },
  };
}
