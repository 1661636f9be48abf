"use strict";
(() => {
  if (!window.Plotly) return; // The still pictures stay.

  const draw = (figure) => {
    if (figure.ready) return figure.ready;
    const { data, layout } = JSON.parse(figure.querySelector("script").textContent);
    layout.showlegend = false; // The names above the chart are the legend.
    const config = {
      responsive: true,
      displaylogo: false,
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
      toImageButtonOptions: { format: "svg", filename: figure.dataset.name },
    };
    const live = figure.querySelector(".live");
    figure.ready = Plotly.newPlot(live, data, layout, config).then(() => {
      figure.classList.add("drawn");
      return live;
    });
    return figure.ready;
  };

  const toggle = (figure, key) => {
    const on = key.getAttribute("aria-pressed") !== "true";
    key.setAttribute("aria-pressed", String(on));
    draw(figure).then((live) => {
      if (key.dataset.kind === "trace") {
        Plotly.restyle(live, { visible: on }, [Number(key.dataset.at)]);
        return;
      }
      const [first, count] = key.dataset.at.split(",").map(Number);
      const change = {};
      for (let i = first; i < first + count; i++) change[`shapes[${i}].visible`] = on;
      Plotly.relayout(live, change);
    });
  };

  // Charts are drawn when they come near the window, so that long reports open at once.
  const figures = document.querySelectorAll("figure.chart");
  const watch = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      watch.unobserve(entry.target);
      draw(entry.target);
    }
  }, { rootMargin: "800px" });
  for (const figure of figures) {
    watch.observe(figure);
    for (const key of figure.querySelectorAll(".key")) key.addEventListener("click", () => toggle(figure, key));
  }
})();
