// The list of events: a button each, with the referee's reasons below the chosen one.
import { before } from "./data.js";
import { el, minutes } from "./dom.js";

const FILTERS = [
  ["Decisions", (kind) => !["kick", "fall", "got_up", "dive"].includes(kind)],
  ["Goals", (kind) => ["goal", "goal_disallowed", "shot", "half_begins", "final_whistle"].includes(kind)],
  ["Penalties", (kind) => ["penalty", "caution", "penalty_over", "placed_by_hand"].includes(kind)],
  ["All", () => true],
];

export class EventPanel {
  constructor(box, page) {
    this.page = page;
    this.list = el("ol", { className: "events" });
    const filters = FILTERS.map(([name, isIn], index) => {
      const button = el("button", { type: "button", "aria-pressed": index === 0 }, name);
      button.addEventListener("click", () => {
        for (const other of filters) other.setAttribute("aria-pressed", other === button);
        this.fill(isIn);
      });
      return button;
    });
    box.append(el("div", { className: "chips", role: "group", "aria-label": "Which events" }, ...filters), this.list);
    this.fill(FILTERS[0][1]);
  }

  fill(isIn) {
    const { match } = this.page;
    const shown = match.events.filter((event) => isIn(event.kind.split(" ")[0]));
    this.rows = shown.map((event) => {
      const button = el("button", { type: "button", data: { kind: event.kind.split(" ")[0], team: event.team ?? "" } }, el("time", {}, minutes(event.timeS)), el("i", { "aria-hidden": "true" }), el("span", {}, event.words));
      button.addEventListener("click", () => this.page.goTo(event));
      const why = event.why.length ? el("ul", { className: "why", hidden: true }, ...event.why.map((line) => el("li", {}, line))) : null;
      return { event, button, why, row: el("li", {}, button, why) };
    });
    this.times = this.rows.map(({ event }) => event.timeS);
    this.current = null;
    this.list.replaceChildren(...(this.rows.length ? this.rows.map(({ row }) => row) : [el("li", { className: "none" }, this.none())]));
    this.show(this.page.timeS);
  }

  none() {
    const { fields } = this.page.match.head;
    const isRecorded = !fields?.length || fields.some((name) => name.split(".")[0] === "events");
    return isRecorded ? "There are no such events." : "Events were not recorded.";
  }

  /** Marks the last event up to a time. */
  show(timeS) {
    const current = this.pointed?.event.timeS === timeS ? this.pointed : this.rows[before(this.times, timeS)];
    if (current === this.current) return;
    this.mark(this.current, false);
    this.mark(current, true);
    this.current = current;
  }

  mark(row, isCurrent) {
    if (!row) return;
    if (isCurrent) row.button.setAttribute("aria-current", "true");
    else row.button.removeAttribute("aria-current");
    if (row.why) row.why.hidden = !isCurrent;
    if (!isCurrent) return;
    // Only the list scrolls, never the page.
    const { list } = this;
    const box = list.parentElement;
    const [top, bottom] = [row.row.offsetTop - list.offsetTop, row.row.offsetTop - list.offsetTop + row.row.offsetHeight];
    if (top < box.scrollTop || bottom > box.scrollTop + box.clientHeight - 60) box.scrollTop = top - box.clientHeight / 3;
  }

  point(event) {
    this.pointed = this.rows.find((row) => row.event === event);
    this.show(event.timeS);
  }
}
