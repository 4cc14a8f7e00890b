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

// On a narrow page the legend of the view lies below it.
const narrow = document.body.clientWidth < 640;
if (narrow) {
  const { scene } = figures.view.layout;
  for (const name of "xyz") scene[`${name}axis`].tickfont = { size: 10 };
}

// Pixels for the labels at the left, at the right and below the box, and for the legend.
const view = document.getElementById("view");
const labels = Math.min(Math.max(view.clientWidth / 12, 60), 75);
const above = 15;
const legend = narrow ? [0, 90] : [150, 0];

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((part) => part / Math.hypot(...a));

// The camera in this direction whose picture of the box, with its labels, fills the view.
function camera(ratio, direction, width, height) {
  const half = Math.tan(Math.PI / 8); // Half the angle of view of plotly.js.
  const room = [width - 2 * labels, height - above - labels].map((side) => Math.max(side, 90));
  const limits = room.map((side) => (2 * half * side) / height);
  const right = unit([-direction[1], direction[0], 0]);
  const up = [-direction[2] * right[1], direction[2] * right[0]];
  up.push(direction[0] * right[1] - direction[1] * right[0]);
  const sides = [-0.5, 0.5];
  const corners = sides.flatMap((x) => sides.flatMap((y) => sides.map((z) =>
    [x * ratio.x, y * ratio.y, z * ratio.z])));
  let [center, distance] = [[0, 0, 0], 3];
  // Each round corrects the perspective of the one before.
  for (let round = 0; round < 20; round++) {
    const extents = [right, up].map((axis) => {
      const seen = corners.map((corner) => {
        const place = corner.map((part, k) => part - center[k]);
        return dot(place, axis) / (distance - dot(place, direction));
      });
      return [Math.min(...seen), Math.max(...seen)];
    });
    const shifts = extents.map(([low, high]) => ((low + high) / 2) * distance);
    center = center.map((part, k) => part + shifts[0] * right[k] + shifts[1] * up[k]);
    const shares = extents.map(([low, high], k) => (high - low) / limits[k]);
    distance = Math.max(distance * Math.max(...shares), Math.hypot(...Object.values(ratio)) / 2);
  }
  const lower = ((labels - above) * half * distance) / height;
  const [x, y, z] = (center = center.map((part, k) => part - lower * up[k]));
  const eye = center.map((part, k) => part + distance * direction[k]);
  return { center: { x, y, z }, eye: { x: eye[0], y: eye[1], z: eye[2] } };
}

{
  const { scene } = figures.view.layout;
  const { x, y, z } = scene.camera.eye;
  const sides = [view.clientWidth - legend[0], view.clientHeight - legend[1]];
  scene.camera = camera(scene.aspectratio, unit([x, y, z]), ...sides);
}

function fit(data) {
  const below = { orientation: "h", x: 0.5, y: -0.02, yanchor: "top", len: 0.95 };
  for (const { marker } of data) {
    if (!marker?.colorbar) continue;
    const { title } = marker.colorbar;
    if (narrow) {
      marker.colorbar = { ...marker.colorbar, ...below, title: { ...title, side: "bottom" } };
    } else {
      // plotly.js draws the title over long numbers.
      title.text = `<br>${title.text}`;
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
    const traces = view.data.map((trace, index) => [trace.meta, index]);
    const switched = traces.filter(([name]) => name === box.dataset.switches);
    Plotly.restyle(view, { visible: box.checked }, switched.map(([, index]) => index));
  });
}
