"use strict";
// What the plots of a study look like.
const STRIP = 30;   // px, above the legend, for the buttons
// Named one by one: others would send the plot to a server.
const BUTTONS = ["zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d", "toImage"];
const CONFIGURATION = { responsive: true, displaylogo: false, plotlyServerURL: "", modeBarButtons: [BUTTONS] };

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

function coarsePointer() {
  return window.matchMedia("(pointer: coarse)").matches;
}

function axisStyle() {
  return { gridcolor: colour("line"), zerolinecolor: colour("line"), linecolor: colour("faint"), automargin: true };
}

/** What every plot looks like. */
function commonLayout(height) {
  return {
    paper_bgcolor: colour("paper"), plot_bgcolor: colour("paper"), font: { color: colour("text"), size: 12 },
    margin: { l: 60, r: 14, t: STRIP, b: 40 }, hovermode: "closest", uirevision: "kept",
    dragmode: coarsePointer() ? false : "zoom",   // on a touch screen dragging scrolls the page
    // Below the strip of buttons; it pushes the panels down by as many lines as it needs.
    legend: { orientation: "h", x: 0, xanchor: "left", yref: "container", y: 1 - STRIP / height, yanchor: "top",
      bgcolor: "rgba(0,0,0,0)" },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("faint"), activecolor: colour("text") },
    hoverlabel: { namelength: -1 },
  };
}
