// English is the key; what has no German stays English, and a test finds it.
import { DE } from "./texts_de.js";

const SAFETY = {
  en: "axisgate is not a safety device. It has no safety function, no performance level and no certificate. Emergency stop, safe torque off, guards, enabling devices and speed monitoring must be realised in certified hardware that works without axisgate. Speed, torque and position limits in axisgate protect parts, not people.",
  de: "axisgate ist keine Sicherheitseinrichtung. Not-Halt, STO, Schutztüren, Zustimmung und sichere Geschwindigkeit sind in zertifizierter Hardware auszuführen, die ohne axisgate wirkt. Grenzwerte in axisgate schützen Teile, nicht Personen.",
};
const ENGLISH = { "kept: watch": "saved lists", "kept: scope": "saved layouts" };
let now = "en";
try { now = localStorage.getItem("language") || "en"; } catch { /* no storage */ }

export function language() { return now; }

export function setLanguage(wanted, passing = false) {
  now = wanted === "de" ? "de" : "en";
  if (!passing) try { localStorage.setItem("language", now); } catch { /* no storage */ }
}

// What the gateway says in both languages: [English, German].
export function say(words) {
  return Array.isArray(words) ? words[now === "de" ? 1 : 0] : words ?? "";
}

export function t(words) {
  if (words === "SAFETY") return SAFETY[now];
  if (now === "de") return DE[words] ?? words;
  return ENGLISH[words] ?? words.replace(/^permit /, "");
}
