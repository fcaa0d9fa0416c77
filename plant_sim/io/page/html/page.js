// SPDX-License-Identifier: Apache-2.0
// What every report's scripts share: the page's data, colours of the theme, numbers as text, small parts of pages.
"use strict";

const voltlap = (() => {
  const root = document.documentElement;
  const dark = window.matchMedia("(prefers-color-scheme: dark)");

  /** Value of a colour of page.css by its name. */
  const color = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();

  /** Calls back when the reader's system changes between light and dark. */
  const onThemeChange = (redraw) => dark.addEventListener("change", redraw);

  /** Seconds as min:s, with so many digits behind the second. */
  const clock = (seconds, digits = 0) => {
    const scale = 10 ** digits;
    const whole = Math.round(seconds * scale);
    const minutes = Math.floor(whole / (60 * scale));
    const rest = (whole - minutes * 60 * scale) / scale;
    return `${minutes}:${rest.toFixed(digits).padStart(digits ? digits + 3 : 2, "0")}`;
  };

  /** A number with its unit, and a minus sign that is one. */
  const quantity = (value, digits, unit) => `${value.toFixed(digits).replace("-", "−")} ${unit}`;

  /** So many significant digits, never with an exponent. */
  const sensible = (value, digits) => {
    if (!Number.isFinite(value)) return "not settled";
    const size = value === 0 ? 0 : Math.floor(Math.log10(Math.abs(value)));
    const places = digits - 1 - size;
    const whole = places < 0 ? Math.round(value * 10 ** places) * 10 ** -places : value;
    return String(Number(whole.toFixed(Math.min(6, Math.max(0, places))))).replace("-", "−");
  };

  /** element("p", {class: "note"}, "text", child, ...) */
  const element = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  };

  /** The font that canvas text is drawn with. */
  const font = () => getComputedStyle(document.body).fontFamily;

  /** Rows of a table that do not hold every word of the input are hidden. */
  const searchable = (input, table, found) => {
    const rows = [...table.tBodies[0].rows];
    const texts = rows.map((row) => row.textContent.toLowerCase());
    const apply = () => {
      const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      let shown = 0;
      rows.forEach((row, i) => {
        row.hidden = !words.every((word) => texts[i].includes(word));
        if (!row.hidden) shown += 1;
      });
      found.textContent = `${shown} of ${rows.length}`;
    };
    input.addEventListener("input", apply);
    input.parentElement.hidden = false;
    apply();
  };

  /** Two frames later everything that was drawn is on the screen. */
  const tellReady = () =>
    requestAnimationFrame(() =>
      requestAnimationFrame(() => {
        performance.mark("voltlap-ready");
        root.dataset.ready = performance.now().toFixed(0);
      }),
    );

  const data = JSON.parse(document.getElementById("voltlap-data").textContent);
  return { data, color, onThemeChange, clock, quantity, sensible, element, font, searchable, tellReady };
})();
