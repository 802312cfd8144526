"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const columns = data.columns, by = Object.fromEntries(columns.map(c => [c.name, c]));
  const PAGE = 50;
  const all = Array.from({length: data.count}, (_, i) => i);
  const controls = document.querySelector(".controls"), table = document.querySelector(".rows");
  const [axis, status] = controls.querySelectorAll("select"), [back, on, save] = controls.querySelectorAll("button");
  const search = controls.querySelector("input"), count = controls.querySelector(".count");
  const texts = all.map(i => columns.filter(c => c.text).map(c => c.values[i]).join("\n").toLowerCase());
  let sorted = null, rising = true, first = 0;

  const element = (name, text, kind) => {
    const made = document.createElement(name);
    made.textContent = text;
    if (kind) made.className = kind;
    return made;
  };
  const number = (value, deviation) => {
    if (value === null) return "";
    if (!deviation) return String(+value.toPrecision(5));
    const size = Math.max(Math.abs(value), deviation), large = size >= 1e6 || size < 1e-3;
    const power = large ? Math.floor(Math.log10(size)) : 0, scale = 10 ** power;
    const places = Math.min(Math.max(1 - Math.floor(Math.log10(deviation / scale)), 0), 12);
    const both = `${(value / scale).toFixed(places)} ± ${(deviation / scale).toFixed(places)}`;
    return power ? `(${both})e${power}` : both;
  };
  // Names of logs without the folder that holds all of them; names of axes and logs are as they are, others are words.
  const folder = (by.log.values[0] || "").replace(/[^/]*$/, ""), parts = folder.split(/(?<=\/)/);
  while (parts.length && by.log.values.some(name => !name.startsWith(parts.join("")))) parts.pop();
  const prefix = parts.join("").length;
  const text = (column, value) => column.name === "log" ? value.slice(prefix)
    : ["axis", "message"].includes(column.name) ? value : value.replaceAll("_", " ");
  const cell = (column, i) => column.text ? text(column, column.values[i]) : number(column.values[i], column.deviations && column.deviations[i]);

  const chosen = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const rows = all.filter(i => (!axis.value || by.axis.values[i] === axis.value)
      && (!status.value || by.status.values[i] === status.value) && words.every(word => texts[i].includes(word)));
    if (sorted) {
      const values = sorted.values, sign = rising ? 1 : -1;
      rows.sort((a, b) => {
        const x = values[a], y = values[b];
        if (x === y) return a - b;
        if (x === null || x === "") return 1;
        if (y === null || y === "") return -1;
        return x < y ? -sign : sign;
      });
    }
    return rows;
  };

  const show = () => {
    const rows = chosen();
    first = Math.min(first, Math.max(0, Math.floor((rows.length - 1) / PAGE) * PAGE));
    const part = rows.slice(first, first + PAGE);
    const held = columns.filter(c => rows.some(i => c.values[i] !== null && c.values[i] !== "")
      && (c.name !== "axis" || new Set(c.values).size > 1));
    const rank = c => ["log", "status"].includes(c.name) ? 0 : c.deviations ? 1 : 2;  // parameters first on a phone
    if (matchMedia("(max-width: 520px)").matches) held.sort((a, b) => rank(a) - rank(b));
    const head = document.createElement("tr");
    for (const column of held) {
      const heading = element("th", "", column.text ? "text" : ""), button = element("button", column.name.replaceAll("_", " ") + (column.unit ? ` [${column.unit}]` : ""));
      if (column === sorted) {
        button.textContent += rising ? " ▲" : " ▼";
        heading.setAttribute("aria-sort", rising ? "ascending" : "descending");
      }
      button.addEventListener("click", () => {
        rising = column === sorted ? !rising : true;
        sorted = column;
        first = 0;
        show();
      });
      heading.append(button);
      head.append(heading);
    }
    const body = document.createElement("tbody");
    for (const i of part) {
      const row = element("tr", "", by.status.values[i] === "ok" ? "" : "bad");
      for (const column of held) {
        const made = element("td", cell(column, i), column.text ? "text" : "");
        if (column.text) made.title = column.values[i];
        row.append(made);
      }
      body.append(row);
    }
    const top = document.createElement("thead");
    top.append(head);
    table.replaceChildren(top, body);
    count.textContent = rows.length ? `${first + 1}–${first + part.length} of ${rows.length} logs` : "no log";
    back.disabled = first === 0;
    on.disabled = first + PAGE >= rows.length;
  };

  const fill = (select, name, every) => {
    select.append(new Option(every, ""));
    for (const value of [...new Set(by[name].values)].sort()) select.append(new Option(value.replaceAll("_", " "), value));
    select.addEventListener("change", () => { first = 0; show(); });
  };
  // Text that a spreadsheet would take for a formula begins with an apostrophe, as in the files of results.
  const quoted = value => value === null || value === undefined ? ""
    : typeof value === "number" ? String(value) : `"${value.replace(/^('*[=+\-@\t\r])/, "'$1").replaceAll('"', '""')}"`;
  const saved = (name, heads, rows) => {
    const text = [heads, ...rows].map(row => row.map(quoted).join(",")).join("\n") + "\n";
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], {type: "text/csv"}));
    link.download = `${name}.csv`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  save.addEventListener("click", () => {
    const heads = columns.flatMap(c => c.deviations ? [c.name, `${c.name}_std`] : [c.name]);
    saved("logs", heads, chosen().map(i => columns.flatMap(c => c.deviations ? [c.values[i], c.deviations[i]] : [c.values[i]])));
  });
  fill(axis, "axis", "all axes");
  fill(status, "status", "every status");
  search.addEventListener("input", () => { first = 0; show(); });
  back.addEventListener("click", () => { first -= PAGE; show(); });
  on.addEventListener("click", () => { first += PAGE; show(); });
  controls.hidden = false;
  show();

  const hint = document.getElementById("hint"), read = new WeakMap();
  const points = chart => {
    if (!read.has(chart)) {
      const paths = [...chart.querySelectorAll(".runs, .outside")].map(path => path.getAttribute("d")).join("");
      const places = [...paths.matchAll(/M([\d.]+) ([\d.]+)h0/g)].map(found => [+found[1], +found[2]]);
      const rows = chart.dataset.rows.split(" ").map(Number);
      read.set(chart, places.map((place, k) => ({x: place[0], y: place[1], row: rows[k]})));
    }
    return read.get(chart);
  };
  const nearest = (chart, event) => {
    const box = chart.getBoundingClientRect(), scale = chart.viewBox.baseVal.width / box.width;
    const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
    let best = null, least = 14 ** 2;
    for (const point of points(chart)) {
      const away = (point.x - x) ** 2 + (point.y - y) ** 2;
      if (away < least) [best, least] = [point, away];
    }
    return best;
  };
  for (const chart of document.querySelectorAll(".chart")) {
    const button = element("button", "Save the data as CSV", "save"), name = chart.dataset.parameter;
    button.type = "button";
    button.addEventListener("click", () => {
      const of = by[name], when = by.recorded ? ["recorded"] : [], [levels, limits] = ["levels", "limits"]
        .map(which => chart.dataset[which].trim().split(" ").map(value => Number.isFinite(+value) ? +value : null));
      const heads = ["log", ...when, name, `${name}_std`, "level", "limit"];
      saved(name, heads, chart.dataset.rows.split(" ").map((i, k) => [by.log.values[i],
        ...when.map(() => by.recorded.values[i]), of.values[i], of.deviations[i], levels[k], limits[k]]));
    });
    chart.after(button);
    chart.addEventListener("mousemove", event => {
      const point = nearest(chart, event);
      hint.hidden = !point;
      if (!point) return;
      const when = by.recorded ? `${by.recorded.values[point.row]}\n` : "";
      hint.textContent = `${by.log.values[point.row]}\n${when}${chart.dataset.parameter} ${cell(by[chart.dataset.parameter], point.row)}`;
      hint.style.left = `${Math.min(event.pageX + 12, innerWidth - 300)}px`;
      hint.style.top = `${event.pageY + 14}px`;
    });
    chart.addEventListener("mouseleave", () => { hint.hidden = true; });
    chart.addEventListener("click", event => {
      const point = nearest(chart, event);
      if (!point) return;
      search.value = by.log.values[point.row];
      axis.value = status.value = "";
      first = 0;
      show();
      document.getElementById("logs").scrollIntoView();
    });
  }
})();
