"use strict";
// The page of a sweep: what became of the cases over what was swept, a table to sort and to filter, and one case.
(() => {
  const { axes, grid, columns, curves, results, folder } = DATA.sweep;
  const PAGE = 50, CURVES = 8, SHARE = 40, LONG = 90;
  const by = Object.fromEntries(columns.map((c) => [c.name, c]));
  const count = by.case.numbers.length, all = [...Array(count).keys()];
  const find = (id) => document.getElementById(id);
  const isSolved = (row) => by.solved.numbers[row] === 1;
  const raw = (column, row) => column.numbers ? column.numbers[row] : column.texts[column.of[row]];
  const text = (column, row) => column.numbers ? Charts.shown(raw(column, row), 7) : raw(column, row);

  function made(kind, attributes = {}, ...inner) {
    const element = document.createElement(kind);
    for (const [name, value] of Object.entries(attributes))
      if (name === "onclick") element.addEventListener("click", value); else if (value !== null) element.setAttribute(name, value);
    element.append(...inner);
    return element;
  }
  const option = (value, label) => made("option", { value }, label);

  // -- one case -----------------------------------------------------------------------------------------------------

  let chosen = null, ownCharts = [];
  const said = (row) => axes.map((axis) => `${axis.path} = ${axis.texts[axis.of[row]]}`).join(", ");

  function choose(row) {
    chosen = row;
    const panel = find("case"), number = by.case.numbers[row];
    ownCharts.forEach(Charts.remove);
    ownCharts = [];
    const facts = made("dl", { class: "facts" });
    for (const column of columns)
      if (column.name !== "solved" && raw(column, row) !== null && raw(column, row) !== "")
        facts.append(made("div", {}, made("dt", {}, column.name), made("dd", {}, text(column, row) + (column.unit ? ` ${column.unit}` : ""))));
    const charts = made("div", { class: "charts" });
    const close = made("button", { type: "button", onclick: () => { panel.hidden = true; chosen = null; marked(); } }, "Close");
    panel.replaceChildren(made("h2", { tabindex: "-1" }, `Case ${number}: ${said(row)}`), close, facts, charts);
    if (results.includes(number)) {
      const command = made("code", {}, `trajopt report ${folder}/results/${raw(by.key, row)}.h5`);
      panel.insertBefore(made("p", {}, "Its full result is kept: ", command), charts);
    }
    panel.hidden = false;
    drawCase(row, charts);
    marked();
    panel.querySelector("h2").focus();
  }

  function drawCase(row, place) {
    if (!curves) { place.append(made("p", { class: "quiet" }, "There are too many cases for their curves to be on this page.")); return; }
    const phases = curves.cases[row], names = [...new Set(phases.flatMap((phase) => Object.keys(phase.values)))];
    if (!names.length) place.append(made("p", { class: "quiet" }, "No curves are kept of a case that failed."));
    for (const name of names) {
      const x = [], y = [];
      for (const phase of phases.filter((own) => name in own.values)) {
        if (x.length) { x.push(x[x.length - 1]); y.push(null); }
        x.push(...curves.grids[phase.grid].map((s) => phase.from + s * (phase.to - phase.from)));
        y.push(...phase.values[name]);
      }
      const figure = made("figure", { class: "chart" }, made("figcaption", {}, made("span", { class: "title" }, name)));
      place.append(figure);
      const chart = { title: name, x: { label: "time", values: x, sync: "time" }, log: false, bounds: [], marks: [], phases: [],
                      series: [{ label: name, kind: "line", colour: "state", values: y }] };
      ownCharts.push(Charts.draw(figure, chart));
    }
  }

  function marked() {
    for (const element of document.querySelectorAll("[data-row]")) element.classList.toggle("chosen", Number(element.dataset.row) === chosen);
  }

  // -- over what was swept ------------------------------------------------------------------------------------------

  const numeric = columns.filter((c) => c.numbers && !["case", "solved"].includes(c.name) && !axes.some((a) => a.path === c.name));
  numeric.forEach((c) => find("quantity").append(option(c.name, c.unit ? `${c.name} [${c.unit}]` : c.name)));
  axes.forEach((axis, i) => find("across").append(option(i, axis.path)));
  find("each").append(option("", "none"));
  axes.forEach((axis, i) => find("each").append(option(i, axis.path)));
  // The longest axis along, and a curve for each value of the shortest of the others.
  const order = axes.map((_, i) => i).sort((a, b) => axes[b].texts.length - axes[a].texts.length);
  const preferred = order.find((i) => axes[i].numbers) ?? 0;
  find("across").value = preferred;
  const others = order.filter((i) => i !== preferred && axes[i].texts.length <= CURVES);
  if (grid && others.length) find("each").value = others[others.length - 1];
  find("each").parentElement.hidden = axes.length < 2;

  let overChart = null, shownRows = all;

  function overSwept() {
    const quantity = by[find("quantity").value], axis = axes[find("across").value];
    const each = find("each").value === "" || find("each").value === find("across").value ? null : axes[find("each").value];
    const at = (row) => axis.numbers ? axis.numbers[axis.of[row]] : axis.of[row];
    const good = shownRows.filter((row) => isSolved(row) && raw(quantity, row) !== null);
    const lines = new Map();
    for (const row of good) {
      const key = each ? each.of[row] : 0;
      if (!lines.has(key)) lines.set(key, []);
      lines.get(key).push(row);
    }
    const few = [...lines.keys()].sort((a, b) => a - b).slice(0, CURVES);
    const bad = shownRows.filter((row) => !isSolved(row));
    const rows = [...few.flatMap((key) => lines.get(key)), ...bad].sort((a, b) => at(a) - at(b));
    // A curve where each case has a place of its own; else points, which stand one above the other.
    const curve = few.every((key) => lines.get(key).length > 1 && new Set(lines.get(key).map(at)).size === lines.get(key).length);
    const places = curve ? [...new Set(rows.map(at))] : rows.map(at);
    const valuesOf = (key) => {
      const own = new Map(lines.get(key).map((row) => [curve ? at(row) : row, raw(quantity, row)]));
      return (curve ? places : rows).map((place) => own.get(place) ?? null);
    };
    const series = few.map((key, i) => ({ label: each ? `${each.name} = ${each.texts[key]}` : quantity.name, kind: curve ? "marked" : "points",
                                          colour: "line" + i, values: valuesOf(key) }));
    if (overChart) { Charts.remove(overChart); overChart = null; }
    const title = quantity.name + (quantity.unit ? ` [${quantity.unit}]` : "");
    const figure = made("figure", { class: "chart", id: "over" }, made("figcaption", {}, made("span", { class: "title" }, `${title} of the solved cases`)));
    document.querySelector("#outcome .charts").replaceChildren(figure);
    if (!good.length) { figure.append(made("p", { class: "quiet" }, "No case that is shown is solved.")); return; }
    const left = lines.size - few.length;
    if (left) figure.querySelector("figcaption").append(made("span", { class: "quiet" }, ` and ${left} curves more: filter the cases below`));
    const failed = [...new Set(bad.map(at))];
    const chart = { title, x: { label: axis.path, values: places, names: axis.numbers ? null : axis.texts }, series, log: false, bounds: [], marks: failed,
                    markColour: "bad", phases: [] };
    overChart = Charts.draw(figure, chart);
    if (failed.length) figure.append(made("p", { class: "hint" }, "Strokes on the axis: cases that failed."));
    overChart.plot.over.addEventListener("click", () => {
      const { idx, top } = overChart.plot.cursor;
      if (idx === null || idx === undefined) return;
      const same = rows.filter((row) => at(row) === places[idx]);
      const height = overChart.plot.over.clientHeight;  // a case that failed stands on the axis
      const away = (row) => Math.abs((isSolved(row) ? overChart.plot.valToPos(raw(quantity, row), "y") : height) - top);
      choose(same.sort((a, b) => away(a) - away(b))[0]);
    });
  }

  // A map of two axes of a grid; the others are held at a value each.
  const fixed = {};
  function map() {
    const place = find("map");
    place.replaceChildren();
    if (!grid || axes.length < 2) return;
    const across = Number(find("across").value);
    const down = find("each").value !== "" && Number(find("each").value) !== across ? Number(find("each").value) : axes.findIndex((_, i) => i !== across);
    const quantity = by[find("quantity").value];
    const held = axes.map((_, i) => i).filter((i) => i !== across && i !== down);
    const choices = made("div", { class: "filters" });
    for (const i of held) {
      const select = made("select", { "data-held": i }, ...axes[i].texts.map((value, k) => option(k, value)));
      select.value = fixed[i] ?? 0;
      select.addEventListener("change", () => { fixed[i] = Number(select.value); map(); });
      choices.append(made("label", {}, axes[i].path, select));
    }
    const here = all.filter((row) => held.every((i) => axes[i].of[row] === (fixed[i] ?? 0)));
    const cell = new Map(here.map((row) => [`${axes[across].of[row]} ${axes[down].of[row]}`, row]));
    const values = here.filter(isSolved).map((row) => raw(quantity, row)).filter((v) => v !== null);
    const least = values.reduce((a, b) => Math.min(a, b), Infinity), most = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const head = made("tr", {}, made("th", { scope: "col" }, `${axes[down].name} \\ ${axes[across].name}`), ...axes[across].texts.map((t) => made("th", { scope: "col" }, t)));
    const body = axes[down].texts.map((label, k) => made("tr", {}, made("th", { scope: "row" }, label),
      ...axes[across].texts.map((_, i) => made("td", {}, ...one(cell.get(`${i} ${k}`), quantity, least, most)))));
    const table = made("table", { class: "outcome" }, made("thead", {}, head), made("tbody", {}, ...body));
    place.append(made("h3", {}, `${quantity.name} over both`), choices, made("div", { class: "wide", role: "region", "aria-label": "Map of the cases", tabindex: "0" }, table));
    marked();
  }

  function one(row, quantity, least, most) {
    if (row === undefined) return [made("span", { class: "quiet" }, "–")];
    const value = raw(quantity, row), name = `case ${by.case.numbers[row]}, ${said(row)}`;
    const button = made("button", { type: "button", "data-row": row, onclick: () => choose(row) });
    if (!isSolved(row)) {
      button.className = "failed-case";
      button.textContent = raw(by.status, row);
      button.setAttribute("aria-label", `${name}: ${raw(by.status, row)}`);
      button.title = raw(by.message, row);
      return [button];
    }
    const share = value === null || most === least ? 0 : (value - least) / (most - least);
    button.style.background = `color-mix(in srgb, var(--state) ${Math.round(SHARE * share)}%, var(--paper))`;
    button.textContent = Charts.shown(value, 4);
    button.setAttribute("aria-label", `${name}: ${quantity.name} ${Charts.shown(value, 6)}`);
    return [button];
  }

  // -- the table ----------------------------------------------------------------------------------------------------

  let sorted = { name: "case", up: true }, page = 0, more = false;
  const filters = {};
  const visible = () => columns.filter((c) => c.name !== "solved" && (more || c.main));

  // What a filter asks of a value: a comparison, a range, a number, or a part of the text.
  function meets(asked, column, row) {
    const wanted = asked.trim(), value = raw(column, row);
    if (!wanted) return true;
    const compared = /^(<=|>=|<|>|=)\s*(-?[\d.]+(?:e[+-]?\d+)?)$/i.exec(wanted), span = /^(-?[\d.]+(?:e[+-]?\d+)?)\s*\.\.\s*(-?[\d.]+(?:e[+-]?\d+)?)$/i.exec(wanted);
    if (column.numbers && span) return value !== null && value >= Number(span[1]) && value <= Number(span[2]);
    if (column.numbers && compared) {
      const limit = Number(compared[2]);
      return value !== null && { "<": value < limit, ">": value > limit, "<=": value <= limit, ">=": value >= limit, "=": value === limit }[compared[1]];
    }
    if (column.numbers && wanted !== "" && isFinite(Number(wanted))) return value === Number(wanted);
    return text(column, row).toLowerCase().includes(wanted.toLowerCase());
  }

  function rowsShown() {
    const asked = Object.entries(filters).filter(([, wanted]) => wanted.trim());
    const outcome = find("solved").value;
    return all.filter((row) => (outcome === "" || String(by.solved.numbers[row]) === outcome) && asked.every(([name, wanted]) => meets(wanted, by[name], row)));
  }

  function compare(column, up) {
    return (a, b) => {
      const [x, y] = [raw(column, a), raw(column, b)];
      if (x === null || y === null) return (x === null) - (y === null);  // what is missing comes last either way
      const order = column.numbers ? x - y : x.localeCompare(y);
      return (up ? order : -order) || a - b;
    };
  }

  function heads() {
    const names = made("tr"), fields = made("tr");
    for (const column of visible()) {
      const state = sorted.name === column.name ? (sorted.up ? "ascending" : "descending") : "none";
      const button = made("button", { type: "button", onclick: () => sortBy(column.name) }, column.name);
      if (column.unit) button.append(made("span", { class: "unit" }, ` [${column.unit}]`));
      names.append(made("th", { scope: "col", "aria-sort": state, "data-column": column.name, class: column.numbers ? "number" : null }, button));
      const field = made("input", { type: "text", size: column.numbers ? 6 : 10, "aria-label": `filter ${column.name}`, "data-filter": column.name });
      field.value = filters[column.name] || "";
      field.addEventListener("input", () => { filters[column.name] = field.value; page = 0; update(); });
      fields.append(made("td", { class: column.numbers ? "number" : null }, field));
    }
    document.querySelector("#table thead").replaceChildren(names, fields);
  }

  function sortBy(name) {
    sorted = { name, up: sorted.name === name ? !sorted.up : true };
    page = 0;
    heads();
    document.querySelector(`#table th[data-column="${CSS.escape(name)}"] button`).focus();
    body();
  }

  function body() {
    const rows = [...shownRows].sort(compare(by[sorted.name], sorted.up)), pages = Math.max(Math.ceil(rows.length / PAGE), 1);
    page = Math.min(page, pages - 1);
    const part = rows.slice(page * PAGE, (page + 1) * PAGE).map((row) => made("tr", { "data-row": row }, ...visible().map((column) => {
      const cell = made("td", { class: column.numbers ? "number" : column.name === "message" ? "long" : null });
      if (column.name === "case") cell.append(made("button", { type: "button", class: "case", "aria-label": `Show case ${text(column, row)}`, onclick: () => choose(row) }, text(column, row)));
      else cell.textContent = text(column, row).length > LONG ? text(column, row).slice(0, LONG) + " …" : text(column, row);
      if (column.name === "status") cell.classList.add(isSolved(row) ? "good" : "bad");
      return cell;
    })));
    document.querySelector("#table tbody").replaceChildren(...part);
    find("count").textContent = `${rows.length} of ${count} cases`;
    find("place").textContent = `page ${page + 1} of ${pages}`;
    find("pages").hidden = pages < 2;
    find("before").disabled = page === 0;
    find("after").disabled = page === pages - 1;
    marked();
  }

  function update() { shownRows = rowsShown(); body(); overSwept(); }

  find("solved").addEventListener("change", () => { page = 0; update(); });
  find("clear").addEventListener("click", () => { for (const name in filters) delete filters[name]; find("solved").value = ""; page = 0; heads(); update(); });
  find("more").addEventListener("click", () => { more = !more; find("more").setAttribute("aria-pressed", String(more)); find("more").textContent = more ? "Fewer columns" : "All columns"; heads(); body(); });
  find("before").addEventListener("click", () => { page -= 1; body(); });
  find("after").addEventListener("click", () => { page += 1; body(); });
  for (const id of ["quantity", "across", "each"]) find(id).addEventListener("change", () => { overSwept(); map(); });
  heads();
  update();
  map();
})();
