"use strict";

const figures = JSON.parse(document.getElementById("figures").textContent);
const config = { displaylogo: false, responsive: true, showSendToCloud: false };

for (const [name, figure] of Object.entries(figures)) {
  const place = document.getElementById(name);
  if (figure.data.length) {
    Plotly.newPlot(place, figure.data, figure.layout, config);
  } else {
    place.textContent = "The job reported no steps.";
  }
}

for (const box of document.querySelectorAll("[data-switches]")) {
  box.addEventListener("change", () => {
    const view = document.getElementById("view");
    const traces = view.data.map((trace, index) => [trace.meta, index]);
    const switched = traces.filter(([name]) => name === box.dataset.switches);
    Plotly.restyle(view, { visible: box.checked }, switched.map(([, index]) => index));
  });
}
