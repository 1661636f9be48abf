"use strict";
(() => {
  // A long column: 16-bit steps from its lowest value, in base64; the last code is a gap.
  const unpack = ({ low, step, packed }) => {
    const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
    return Array.from(new Uint16Array(bytes.buffer), (code) => (code === 65535 ? null : low + code * step));
  };

  const draw = (figure) => {
    if (figure.ready) return;
    const { data, layout } = JSON.parse(figure.querySelector("script").textContent);
    for (const trace of data) {
      for (const axis of ["x", "y"]) {
        const column = trace[axis];
        if (column?.packed) trace[axis] = unpack(column);
        else if (column?.axis) trace[axis] = data[column.trace][column.axis]; // An earlier column, unpacked by now.
      }
    }
    layout.showlegend = false; // The names above the chart are the legend.
    const config = {
      responsive: true,
      displaylogo: false,
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
      toImageButtonOptions: { format: "svg", filename: figure.dataset.name },
    };
    const plot = figure.querySelector(".plot");
    figure.ready = Plotly.newPlot(plot, data, layout, config);
    figure.classList.add("drawn");
  };

  const toggle = (figure, key) => {
    const on = key.getAttribute("aria-pressed") !== "true";
    key.setAttribute("aria-pressed", String(on));
    draw(figure);
    figure.ready.then((plot) => {
      if (key.dataset.kind === "trace") {
        Plotly.restyle(plot, { visible: on }, [Number(key.dataset.at)]);
        return;
      }
      const [first, count] = key.dataset.at.split(",").map(Number);
      const change = {};
      for (let i = first; i < first + count; i++) change[`shapes[${i}].visible`] = on;
      Plotly.relayout(plot, change);
    });
  };

  // Charts are drawn when they come near the window, so that long reports open at once. The first ones are drawn now.
  const near = 800;
  const figures = document.querySelectorAll("figure.chart");
  const watch = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) draw(entry.target);
  }, { rootMargin: `${near}px` });
  for (const figure of figures) {
    for (const key of figure.querySelectorAll(".key")) key.addEventListener("click", () => toggle(figure, key));
    const { top, height } = figure.getBoundingClientRect();
    if (height > 0 && top < innerHeight + near) draw(figure);
    else watch.observe(figure);
  }

  // On paper all unfolded charts stand, scaled from their size on the screen to the width of the sheet.
  addEventListener("beforeprint", () => {
    for (const figure of figures) {
      if (figure.closest("details:not([open])")) continue;
      draw(figure);
      const plot = figure.querySelector(".plot");
      for (const svg of plot.querySelectorAll(".main-svg")) {
        const [width, height] = ["width", "height"].map((side) => svg.getAttribute(side));
        svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
        plot.style.setProperty("--shape", `${width} / ${height}`);
      }
    }
  });
  addEventListener("afterprint", () => {
    for (const svg of document.querySelectorAll(".main-svg[viewBox]")) svg.removeAttribute("viewBox");
  });
})();
