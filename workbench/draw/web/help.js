// What a picture says of how it is used.

export const HELP =
  "Drag turns, shift and drag moves, wheel zooms once clicked. A click takes what is seen through a part, a second one " +
  "there the part. Arrows turn, + and - zoom, 1 to 6 views, 0 fits, F looks at what was clicked, H hides it, I shows it " +
  "alone, X walls, C section, [ ] other cases, space plays, Esc undoes.";

// What the sliders below a picture do; not said on paper.
export function sliders({ states, times }) {
  if (!states) return times ? "scrub or play" : "";
  return times
    ? "the upper slider moves the line between the two, the lower one the time"
    : "the slider moves the line between the two";
}
