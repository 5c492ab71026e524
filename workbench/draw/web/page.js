// The turnable pictures of a page: each takes the place of its still picture when it comes near
// the window, and gives the place back when it has gone far, since a browser keeps few contexts.

import { Panel } from "./panel.js";
import { readPage, sceneOf } from "./wire.js";

const MOST = 4; // pictures that are alive at one time
const NEAR = "300px";

const panels = new Map();

async function begin() {
  const data = document.getElementById("views-data");
  const places = [...document.querySelectorAll(".turn[data-view]")];
  if (!data || !places.length) return;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let page;
  try {
    if (!document.createElement("canvas").getContext("webgl2")) {
      throw new Error("this browser has no WebGL 2 here");
    }
    page = await readPage(data.textContent);
  } catch (error) {
    for (const place of places) explain(place, error);
    return;
  }
  const open = (place) => {
    const index = Number(place.dataset.view);
    if (panels.has(index)) return panels.get(index);
    try {
      for (const [key, panel] of panels) {
        if (panels.size < MOST) break;
        if (!isNear(panel.place)) close(key);
      }
      panels.set(index, new Panel(place, sceneOf(page, index), dark.matches));
    } catch (error) {
      explain(place, error);
    }
    return panels.get(index);
  };
  const watch = new IntersectionObserver(
    (seen) => seen.filter((entry) => entry.isIntersecting).forEach((entry) => open(entry.target)),
    { rootMargin: NEAR },
  );
  for (const place of places) watch.observe(place);
  dark.addEventListener("change", () => panels.forEach((panel) => panel.viewer.theme(dark.matches)));
  document.addEventListener("click", (event) => {
    const link = event.target.closest?.("a.look");
    const place = link && document.querySelector(link.getAttribute("href"));
    const panel = place && open(place);
    if (!panel) return;
    event.preventDefault();
    place.scrollIntoView({ block: "center" });
    panel.lookAt(link.dataset.at.split(" ").map((value) => Number(value) / 1000), link.dataset.time);
    panel.say(link.dataset.said || link.textContent);
  });
  document.addEventListener("case", (event) => {
    const here = places.findIndex((place) => place === event.target);
    const next = places[here + event.detail];
    if (!next) return;
    next.scrollIntoView({ block: "center" });
    open(next)?.viewer.canvas.focus({ preventScroll: true });
  });
}

function isNear(place) {
  const box = place.getBoundingClientRect();
  return box.bottom > -300 && box.top < innerHeight + 300;
}

function close(index) {
  panels.get(index).end();
  panels.delete(index);
}

// The still picture stays, with the reason in words.
function explain(place, error) {
  const why = place.querySelector(".said");
  why.textContent = `This picture can be turned where there is WebGL 2: ${error.message}.`;
}

begin();
