// A button below each plot saves the numbers that it shows as CSV: one table for each source, an empty line between two.
(() => {
  const sources = plot => {
    const root = plot.querySelector("[data-root-id]").dataset.rootId;
    const model = Bokeh.documents.map(one => one.get_model_by_id(root)).find(Boolean);
    return [...model.references()].filter(one => one.type === "ColumnDataSource");
  };
  const cell = value => (Number.isFinite(value) ? String(Number(value.toPrecision(8))) : "");
  const table = source => {
    const columns = source.data instanceof Map ? [...source.data] : Object.entries(source.data);
    const count = Math.max(...columns.map(([, values]) => values.length));
    const rows = Array.from({ length: count }, (_, row) => columns.map(([, values]) => cell(values[row])).join(","));
    return [columns.map(([name]) => name).join(","), ...rows].join("\n") + "\n";
  };
  for (const plot of document.querySelectorAll(".plot")) {
    const button = document.createElement("button");
    button.className = "save";
    button.textContent = "Save the data as CSV";
    button.addEventListener("click", () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([sources(plot).map(table).join("\n")], { type: "text/csv" }));
      link.download = `${plot.closest("section").id}.csv`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
    plot.after(button);
  }
})();
