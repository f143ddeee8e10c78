// Curves that grow while a run goes on.

/** Most points of a curve: beyond them every second one is left out. */
const MOST_POINTS = 2000;

class Curves {
  /** `charts` are lists of a title, a unit, and curves: name and value of a sample. */
  constructor(container, charts, timeUnit) {
    this.timeUnit = timeUnit;
    this.times = [];
    this.charts = charts.map((chart) => ({ ...chart, columns: chart.curves.map(() => []), canvas: make("canvas", { role: "img" }) }));
    const caption = (chart) => make("figcaption", {}, [chart.title + (chart.unit ? ` (${chart.unit})` : ""), ...chart.curves.filter((curve) => curve.name).flatMap((curve, place) => {
      const mark = make("i");
      mark.style.setProperty("--mark", `var(--${place ? "second" : "first"})`);
      return [mark, curve.name];
    })]);
    container.replaceChildren(...this.charts.map((chart) => make("figure", {}, [caption(chart), chart.canvas])));
    new ResizeObserver(() => this.draw()).observe(container);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  add(sample) {
    if (sample.time <= this.times.at(-1)) return;
    this.times.push(sample.time);
    for (const chart of this.charts) chart.columns.forEach((column, place) => column.push(chart.curves[place].of(sample)));
    if (this.times.length > MOST_POINTS) {
      const half = (column) => column.filter((_, place) => place % 2 === 0);
      this.times = half(this.times);
      for (const chart of this.charts) chart.columns = chart.columns.map(half);
    }
    this.request ??= requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.request = null;
    this.charts.forEach((chart) => this.drawChart(chart));
  }

  drawChart({ canvas, columns, curves, title }) {
    const density = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width) return;
    Object.assign(canvas, { width: width * density, height: height * density });
    const context = canvas.getContext("2d");
    const style = getComputedStyle(canvas);
    const colour = (name) => style.getPropertyValue(name).trim();
    context.scale(density, density);
    context.font = `11px ${style.fontFamily}`;
    const last = Math.max(this.times.at(-1) ?? 0, 1e-300);
    const high = columns.reduce((most, column) => column.reduce((a, b) => Math.max(a, b), most), 0) || 1;
    const [left, right, top, bottom] = [46, width - 8, 8, height - 18];
    const x = (time) => left + ((right - left) * time) / last;
    const y = (value) => bottom - ((bottom - top) * value) / (1.05 * high);
    context.strokeStyle = colour("--line");
    context.fillStyle = colour("--muted");
    context.lineWidth = 1;
    const line = (x1, y1, x2, y2) => {
      context.beginPath();
      context.moveTo(x1, y1);
      context.lineTo(x2, y2);
      context.stroke();
    };
    context.textAlign = "right";
    for (const tick of ticks(0, high, 3)) {
      line(left, y(tick), right, y(tick));
      context.fillText(shortNumber(tick), left - 4, y(tick) + 4);
    }
    context.textAlign = "center";
    const of = ticks(0, last, 4);
    of.forEach((tick, place) => {
      const isEdge = x(tick) > right - 12;
      context.textAlign = isEdge ? "right" : "center";
      context.fillText(`${shortNumber(tick)}${place === of.length - 1 ? ` ${this.timeUnit}` : ""}`, isEdge ? right : x(tick), height - 4);
    });
    columns.forEach((column, place) => {
      context.strokeStyle = colour(place ? "--second" : "--first");
      context.lineWidth = 1.8;
      context.beginPath();
      column.forEach((value, number) => context.lineTo(x(this.times[number]), y(value)));
      context.stroke();
    });
    const now = curves.map((curve, place) => `${curve.name || title} ${shortNumber(columns[place].at(-1) ?? 0)}`).join(", ");
    canvas.setAttribute("aria-label", `${title} over time; now ${now}`);
  }
}
