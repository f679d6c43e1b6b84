"""What a page of the browser has to look like: filled, and readable."""

FILLED = {  # what stands there when a page has something to show
    "overview": "td:has-text('A6')",
    "axes": ".uplot canvas",
    "motion": "[data-drawn]",
    "signals": "[data-id='cell.life']:not(:empty)",
    "scope": "#scope-plot canvas",
    "lines": "td:has-text('SEND')",
    "bus": "tr:has-text('SYNC') td:nth-child(2):not(:text-is('0.0'))",
    "events": "td:has-text('services started')",
    "emulator": "td:has-text('A6')",
    "access": "td:has-text('logged in')",
}

CONTRAST = """() => {
  const rgb = (text) => { const m = text.match(/[\\d.]+/g).map(Number); return m.length > 3 ? m : [...m, 1]; };
  const light = ([r, g, b]) => { const f = (c) => { c /= 255; return c <= .03928 ? c / 12.92 : ((c + .055) / 1.055) ** 2.4; };
    return .2126 * f(r) + .7152 * f(g) + .0722 * f(b); };
  const ground = (e) => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor); if (c[3] > .5) return c; }
    return [255, 255, 255]; };
  const low = new Set();
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const e = walk.currentNode.parentElement;
    if (!walk.currentNode.textContent.trim() || e.closest('canvas,.uplot,.skip') || e.closest(':disabled') || !e.checkVisibility()) continue;
    const [a, b] = [light(rgb(getComputedStyle(e).color)), light(ground(e))].sort((x, y) => y - x);
    if ((a + .05) / (b + .05) < 4.5) low.add(`${e.tagName}.${e.className}: ${walk.currentNode.textContent.slice(0, 30)} ${((a + .05) / (b + .05)).toFixed(2)}`);
  }
  return [...low];
}"""  # noqa: E501
