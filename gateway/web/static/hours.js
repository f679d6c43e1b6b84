// The trend of one value over the last hours, opened by a click on it; times are those of the clock.
import { h, put } from "./dom.js";
import { get } from "./net.js";
import { colour, load } from "./plot.js";
import { t } from "./texts.js";

const SPANS = [[600, "10 min"], [3600, "1 h"], [8 * 3600, "8 h"], [24 * 3600, "24 h"]];
const two = (number) => String(number).padStart(2, "0");
export const clock = (seconds, long = true) => { const at = new Date(seconds * 1e3); return `${two(at.getHours())}:${two(at.getMinutes())}${long ? `:${two(at.getSeconds())}` : ""}`; };

export function hours(id) {
  document.getElementById("trend")?.close();
  let span = 3600;
  try { span = Number(localStorage.getItem("trend")) || span; } catch { /* no storage */ }
  let plot = null;
  let wait = 0;
  const title = h("h2", {}, id);
  const reply = h("p", { class: "soft small", role: "status", id: "trend-about" });
  const box = h("div", { class: "plot", id: "trend-plot" });
  const spans = SPANS.map(([seconds, words]) => h("button", { type: "button", class: "tiny", "data-span": seconds, "aria-pressed": String(seconds === span), onclick: () => choose(seconds) }, words));
  const dialog = h("dialog", { class: "trend", id: "trend", "aria-label": t("trend"), onclose: () => { clearTimeout(wait); watch.disconnect(); plot?.destroy(); plot = null; dialog.remove(); } },
    h("div", { class: "bar spread" }, title, h("div", { class: "bar", style: "margin:0" }, spans, h("button", { type: "button", id: "trend-close", onclick: () => dialog.close() }, t("Close")))), box, reply);
  const width = () => box.clientWidth || 320;
  const height = () => Math.max(180, Math.min(420, Math.round(innerHeight * 0.5)));
  const watch = new ResizeObserver(() => plot?.setSize({ width: width(), height: height() }));
  function choose(seconds) {
    span = seconds;
    try { localStorage.setItem("trend", String(seconds)); } catch { /* no storage */ }
    for (const button of spans) button.setAttribute("aria-pressed", String(Number(button.dataset.span) === span));
    look();
  }
  async function look() {
    clearTimeout(wait);
    try {
      const found = await get(`/api/trend?id=${encodeURIComponent(id)}&seconds=${span}`);
      const uPlot = await load();
      if (dialog.isConnected) show(uPlot, found);
    } catch (error) { put(reply, t(error.message)); }
    if (dialog.isConnected) wait = setTimeout(look, span > 3600 ? 10000 : 2000);
  }
  function show(uPlot, found) {
    const now = found.wall_ms / 1e3;
    const data = [found.ms.map((ms) => now + ms / 1e3), found.values];
    const known = found.values.filter((value) => value !== null);
    put(title, `${found.name}${found.unit ? `, ${found.unit}` : ""}`);
    const short = (value) => Number(value.toPrecision(6)).toString();
    const since = found.since_s === null || found.since_s >= span ? "" : `, ${t("recorded since")} ${clock(now - found.since_s)}`;
    put(reply, known.length ? `${t("now")} ${found.values.at(-1) === null ? t("not known") : short(found.values.at(-1))}, ${t("minimum")} ${short(Math.min(...known))}, ${t("maximum")} ${short(Math.max(...known))}${since}` : t("No numeric value is known for this period."));
    box.dataset.points = String(data[0].length);
    const range = [now - Math.min(span, Math.max(60, found.since_s ?? 60)), now];
    if (plot) { plot.batch(() => { plot.setData(data, false); plot.setScale("x", { min: range[0], max: range[1] }); }); return; }
    const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    const axis = { stroke: style("--text"), grid: { stroke: style("--line") }, ticks: { stroke: style("--line") }, font: "12px system-ui, sans-serif" };
    plot = new uPlot({
      width: width(), height: height(), scales: { x: { time: true, range: (u, min, max) => [min ?? range[0], max ?? range[1]] }, y: { range: (u, low, high) => (found.bit ? [-0.1, 1.1] : low === null || low === high ? [(low ?? 0) - 1, (low ?? 0) + 1] : [low - 0.05 * (high - low), high + 0.05 * (high - low)]) } },
      series: [{ label: t("time"), value: (u, value) => (value === null ? "" : clock(value)) }, { label: found.unit || t("value"), stroke: colour(0), width: 1.6, points: { show: false }, paths: uPlot.paths.stepped({ align: 1 }), value: (u, value) => (value === null || value === undefined ? "" : short(value)) }],
      axes: [{ ...axis, values: (u, places) => places.map((place) => clock(place, u.scales.x.max - u.scales.x.min <= 900)) }, { ...axis, size: 64 }],
    }, data, box);
    plot.setScale("x", { min: range[0], max: range[1] });
  }
  document.body.append(dialog);
  dialog.show(); // beside the page, not over it: STOP is always within reach
  dialog.addEventListener("keydown", (event) => { if (event.key === "Escape" && !event.shiftKey) dialog.close(); });
  watch.observe(box);
  look();
}
