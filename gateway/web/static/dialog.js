// A question that everything but STOP waits for.  A modal dialog of the browser would make STOP inert as well: this one lies below the top bar.
const BEHIND = ["nav", "page", "trend"];

export function opened(dialog) {
  const veil = document.getElementById("veil");
  const behind = (waits) => {
    for (const id of BEHIND) { const part = document.getElementById(id); if (part) part.inert = waits; }
    veil.hidden = !waits;
  };
  behind(true);
  dialog.addEventListener("close", () => behind(false), { once: true });
  dialog.show();
}

// Escape leaves the question, wherever the focus is; Shift and Escape are STOP.
addEventListener("keydown", (event) => {
  const dialog = document.getElementById("dialog");
  if (event.key === "Escape" && !event.shiftKey && dialog.open) { event.stopPropagation(); dialog.close(); }
}, true);
