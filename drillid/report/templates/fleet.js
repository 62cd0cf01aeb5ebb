"use strict";
// Search, filter and order of what needs attention and of the wells.
function matches(element, words, kind) {
  const text = element.dataset.text.toLowerCase();
  return words.every((word) => text.includes(word)) && (!kind || !element.dataset.kind || element.dataset.kind === kind);
}

function filter() {
  const words = document.getElementById("search").value.toLowerCase().split(/\s+/).filter(Boolean);
  const kind = document.getElementById("kind").value;
  const level = Number(document.getElementById("level").value);
  let shown = 0;
  for (const item of document.querySelectorAll(".items .item")) {
    item.hidden = !matches(item, words, kind) || Number(item.dataset.level) > level;
    shown += item.hidden ? 0 : 1;
  }
  let wells = 0;
  for (const row of document.querySelectorAll("#wells tbody tr")) {
    row.hidden = !matches(row, words, "") || (kind && !row.dataset.kinds.split("|").includes(kind));
    wells += row.hidden ? 0 : 1;
  }
  document.getElementById("count").textContent = `${shown} item${shown === 1 ? "" : "s"} and ${wells} well${wells === 1 ? "" : "s"} shown`;
}

function valueOf(row, column) {
  const cell = row.cells[column];
  const value = cell.dataset.value ?? cell.textContent.trim();
  return value === "" || Number.isNaN(Number(value)) ? value : Number(value);
}

function order(header) {
  const column = header.cellIndex;
  const down = header.getAttribute("aria-sort") === "ascending";
  for (const other of header.parentElement.cells) other.removeAttribute("aria-sort");
  header.setAttribute("aria-sort", down ? "descending" : "ascending");
  const body = header.closest("table").tBodies[0];
  const sign = down ? -1 : 1;
  const rows = [...body.rows].sort((one, other) => {
    const [first, second] = [valueOf(one, column), valueOf(other, column)];
    if (typeof first === "number" && typeof second === "number") return sign * (first - second);
    return sign * String(first).localeCompare(String(second), undefined, { numeric: true });
  });
  body.append(...rows);
}

document.addEventListener("DOMContentLoaded", () => {
  // a page without wells has nothing to filter
  if (!document.getElementById("wells")) return;
  for (const name of ["search", "kind", "level"]) document.getElementById(name).addEventListener("input", filter);
  for (const button of document.querySelectorAll("#wells th button")) {
    button.addEventListener("click", () => order(button.closest("th")));
  }
  filter();
});
