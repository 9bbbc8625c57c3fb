"use strict";
// Sorting: a click on a header sorts by it, numbers as numbers; a second click turns it round.
const value = (row, i) => row.cells[i].textContent.trim();
const before = (a, b) => {
  const [x, y] = [parseFloat(a), parseFloat(b)];
  if (isNaN(x) !== isNaN(y)) return isNaN(x) ? 1 : -1;
  return isNaN(x) ? a.localeCompare(b) : x - y;
};
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const sign = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
      const rows = [...table.tBodies[0].rows];
      rows.sort((a, b) => sign * before(value(a, i), value(b, i)));
      table.tBodies[0].append(...rows);
    });
  });
}
// Toggles: a button shows or hides one series in all figures of its section.
for (const group of document.querySelectorAll(".toggles")) {
  group.hidden = false;
  group.addEventListener("click", (event) => {
    const button = event.target.closest("button");
    if (!button) return;
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(on));
    for (const part of group.closest("section").querySelectorAll(`svg .${button.dataset.series}`)) {
      part.classList.toggle("off", !on);
    }
  });
}
// Paper has no clicks: where the numbers come from is printed.
addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details.print")) details.open = true;
});
