"use strict";

const figures = JSON.parse(document.getElementById("figures").textContent);
const config = { displaylogo: false, responsive: true, showSendToCloud: false };
const dark = window.matchMedia("(prefers-color-scheme: dark)");

// The colors of the theme, for all that the style sheet does not reach.
function theme(layout) {
  const style = getComputedStyle(document.documentElement);
  const [ink, paper, line] = ["--ink", "--paper", "--line"].map((name) =>
    style.getPropertyValue(name).trim()
  );
  const axis = { gridcolor: line, linecolor: line, backgroundcolor: paper, color: ink };
  const themed = { ...layout, paper_bgcolor: paper, plot_bgcolor: paper };
  themed.font = { ...layout.font, color: ink };
  for (const name of ["xaxis", "yaxis"]) {
    if (layout[name]) themed[name] = { ...layout[name], gridcolor: line, linecolor: line };
  }
  if (layout.scene) {
    themed.scene = { ...layout.scene };
    for (const name of ["xaxis", "yaxis", "zaxis"]) {
      themed.scene[name] = { ...layout.scene[name], ...axis, showbackground: false };
    }
  }
  return themed;
}

// On a narrow page the legend of the view lies below it, and the viewer is farther away.
const narrow = document.body.clientWidth < 640;
if (narrow) {
  const { scene } = figures.view.layout;
  for (const name of "xyz") {
    scene.camera.eye[name] *= 1.5;
    scene[`${name}axis`].tickfont = { size: 10 };
  }
}

function fit(data) {
  const below = { orientation: "h", x: 0.5, y: -0.02, yanchor: "top", len: 0.95 };
  for (const { marker } of data) {
    if (narrow && marker?.colorbar) {
      const title = { ...marker.colorbar.title, side: "bottom" };
      marker.colorbar = { ...marker.colorbar, ...below, title };
    }
  }
  return data;
}

for (const [name, figure] of Object.entries(figures)) {
  const place = document.getElementById(name);
  if (figure.data.length) {
    Plotly.newPlot(place, fit(figure.data), theme(figure.layout), config);
  } else {
    place.className = "note";
    place.textContent = "The job reported no steps.";
  }
}

dark.addEventListener("change", () => {
  for (const [name, figure] of Object.entries(figures)) {
    const place = document.getElementById(name);
    if (!place.data) continue;
    const layout = theme(figure.layout);
    // The view stays as it was turned.
    if (layout.scene) layout.scene.camera = place.layout.scene.camera;
    Plotly.react(place, place.data, layout, config);
  }
});

for (const box of document.querySelectorAll("[data-switches]")) {
  box.addEventListener("change", () => {
    const view = document.getElementById("view");
    const traces = view.data.map((trace, index) => [trace.meta, index]);
    const switched = traces.filter(([name]) => name === box.dataset.switches);
    Plotly.restyle(view, { visible: box.checked }, switched.map(([, index]) => index));
  });
}
