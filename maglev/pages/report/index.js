"use strict";
// The index that stays in view: search, stage and verdict choose which claims, figures and tables are shown.
{
  const search = document.getElementById("index-search");
  const stage = document.getElementById("index-stage");
  const verdict = document.getElementById("index-verdict");
  const index = document.getElementById("index-details");
  const result = document.getElementById("filter-result");
  const texts = new Map();   // of elements that were searched, in lower case

  function textOf(element) {
    if (!texts.has(element)) texts.set(element, element.textContent.toLowerCase());
    return texts.get(element);
  }

  // Every word, in whatever order.
  const has = (text, words) => words.every((word) => text.includes(word));
  const ofStage = (element) => !stage.value || !element.dataset.stage || element.dataset.stage.split(" ").includes(stage.value);

  function showClaims(words) {
    let count = 0;
    for (const body of document.querySelectorAll("table.claims tbody:not(.part)")) {
      const heading = textOf(body.rows[0]);
      let visible = 0;
      for (const row of body.querySelectorAll("tr[data-verdict]")) {
        row.hidden = !(ofStage(body) && (!verdict.value || row.dataset.verdict === verdict.value)
          && has(`${heading} ${textOf(row)}`, words));
        visible += row.hidden ? 0 : 1;
      }
      // A folded part opens for a search.
      const folded = body.querySelector(".bounds");
      if (folded) {
        folded.hidden = !folded.querySelector("tr[data-verdict]:not([hidden])");
        folded.querySelector("details").open = !folded.hidden && Boolean(verdict.value || words.length);
      }
      // A run without claims is worth a line only where no verdict is asked for.
      body.hidden = visible === 0 && !(!verdict.value && ofStage(body) && has(heading, words));
      count += visible;
    }
    return count;
  }

  function showFigures(words) {
    let count = 0;
    for (const part of document.querySelectorAll("#figures figure, main article")) {
      const figure = part.tagName === "FIGURE";
      const text = figure ? `${textOf(part.querySelector("figcaption"))} ${textOf(part.querySelector("ul.claims") ?? part.querySelector("h3"))}`
        : textOf(part);
      part.hidden = !(ofStage(part) && has(text, words)
        && (!verdict.value || (figure && part.querySelector(`li[data-verdict="${verdict.value}"]`))));
      count += figure && !part.hidden ? 1 : 0;
      const entry = document.querySelector(`#index-figures [href="#${part.id}"]`);
      if (entry) entry.parentElement.hidden = part.hidden;
    }
    return count;
  }

  function update() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const [claims, figures] = [showClaims(words), showFigures(words)];
    result.textContent = words.length || stage.value || verdict.value ? `${claims} claims, ${figures} figures` : "";
  }

  let waiting = 0;
  search.addEventListener("input", () => {
    clearTimeout(waiting);
    waiting = setTimeout(update, 120);
  });
  for (const choice of [stage, verdict]) choice.addEventListener("change", update);

  // A link to a filtered element removes the filters first.
  function reveal() {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    const folded = target.closest(".bounds details"), hidden = target.closest("[hidden]");
    if (hidden) {
      [search.value, stage.value, verdict.value] = ["", "", ""];
      update();
    }
    if (folded) folded.open = true;
    if (hidden || folded) target.scrollIntoView();
  }
  reveal();
  window.addEventListener("hashchange", reveal);

  // The page above a link's target grows while it begins; the target stays in its place until the reader moves.
  const settled = new ResizeObserver(() => document.getElementById(decodeURIComponent(location.hash.slice(1)))?.scrollIntoView());
  if (location.hash) settled.observe(document.querySelector("header"));
  for (const moved of ["wheel", "touchstart", "pointerdown", "keydown"]) window.addEventListener(moved, () => settled.disconnect(), { once: true, passive: true });

  // On a narrow screen the index is a bar that opens, and closes when something is chosen.
  const narrow = window.matchMedia("(max-width: 70rem)");
  narrow.addEventListener("change", () => { index.open = !narrow.matches; });
  index.addEventListener("click", (event) => {
    if (event.target.closest("a") && narrow.matches) index.open = false;
  });

  // Mark the reader's place in the index.
  const links = new Map([...index.querySelectorAll("a")].map((link) => [link.getAttribute("href").slice(1), link]));
  const here = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      const link = links.get(target.id);
      if (isIntersecting) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
  }, { rootMargin: "-10% 0px -60% 0px" });
  for (const figure of document.querySelectorAll("#figures figure")) if (links.has(figure.id)) here.observe(figure);

  // On paper nothing is folded.
  let unfolded = [];
  window.addEventListener("beforeprint", () => {
    unfolded = [...document.querySelectorAll(".bounds details:not([open]), details.reading:not([open]), table details.why:not([open])")];
    for (const details of unfolded) details.open = true;
  });
  window.addEventListener("afterprint", () => {
    for (const details of unfolded) details.open = false;
  });
}
