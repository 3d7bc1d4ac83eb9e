"use strict";
// Buttons above the table of claims: show those of one verdict, or all.
{
  const buttons = [...document.querySelectorAll(".filter button")];
  const bodies = [...document.querySelectorAll("table.claims tbody")];
  const result = document.getElementById("filter-result");

  function show(verdict) {
    let count = 0;
    for (const body of bodies) {
      let visible = 0;
      for (const row of body.querySelectorAll("tr[data-verdict]")) {
        row.hidden = verdict !== "" && row.dataset.verdict !== verdict;
        visible += row.hidden ? 0 : 1;
      }
      // A run without claims is worth a line only where everything is shown.
      body.hidden = verdict !== "" && visible === 0;
      count += visible;
    }
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset.verdict === verdict));
    result.textContent = verdict === "" ? "" : `${count} claims ${verdict}`;
  }
  for (const button of buttons) button.addEventListener("click", () => show(button.dataset.verdict));

  // A link to a claim that the filter hides shows all claims first.
  function reveal() {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (target && target.closest("[hidden]")) {
      show("");
      target.scrollIntoView();
    }
  }
  window.addEventListener("hashchange", reveal);
}
