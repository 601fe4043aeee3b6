"use strict";
// Draws every chart of the page from the data inside it; nothing is fetched.
const charts = JSON.parse(document.getElementById("charts").textContent);
const config = { responsive: true, displaylogo: false, displayModeBar: false };
for (const [name, figure] of Object.entries(charts)) {
  Plotly.newPlot(name, figure.data, figure.layout, config);
}
