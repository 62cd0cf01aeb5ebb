"use strict";
// Units and light or dark, as chosen by the reader and kept for all pages; elements with `data-written` tell when the file was written.
const root = document.documentElement;

function remembered(name) {
  try { return localStorage.getItem(`drillid-${name}`); } catch { return null; }
}

function remember(name, value) {
  try { localStorage.setItem(`drillid-${name}`, value); } catch { /* pages from a file may have no storage */ }
}

function show(setting, value) {
  root.dataset[setting] = value;
  for (const button of document.querySelectorAll(`button[data-sets="${setting}"]`)) {
    button.setAttribute("aria-pressed", String(value === button.dataset.pressed));
  }
  document.dispatchEvent(new CustomEvent("drillid-look"));
}

function flip(event) {
  const { sets, pressed, otherwise } = event.currentTarget.dataset;
  const value = root.dataset[sets] === pressed ? otherwise : pressed;
  remember(sets, value);
  show(sets, value);
}

root.dataset.units = remembered("units") ?? "metric";
root.dataset.theme = remembered("theme") ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");

document.addEventListener("DOMContentLoaded", () => {
  for (const button of document.querySelectorAll("button[data-sets]")) {
    button.addEventListener("click", flip);
    show(button.dataset.sets, root.dataset[button.dataset.sets]);
  }
  for (const place of document.querySelectorAll("[data-written]")) {
    place.textContent = `, written ${new Date(document.lastModified).toLocaleString([], { dateStyle: "medium", timeStyle: "short" })}`;
  }
});

// what is printed is light
window.addEventListener("beforeprint", () => { root.dataset.before = root.dataset.theme; show("theme", "light"); });
window.addEventListener("afterprint", () => show("theme", root.dataset.before));
