// Draws a frame of the plane without WebGL, more slowly.

class FlatRenderer {
  constructor(canvas, run) {
    this.context = canvas.getContext("2d", { alpha: false });
    if (!this.context || run.dimension === 3) throw new Error("this browser has no WebGL 2, which the view of solid space needs");
    this.run = run;
    this.bonds = new Float32Array();
    this.walls = { lines: new Float32Array() };
  }

  setGrains(places, radii, colours) {
    this.grains = { places, radii, colours };
  }

  setPalette(palette) {
    this.palette = palette;
  }

  setBonds(lines) {
    this.bonds = lines;
  }

  setWalls(walls) {
    this.walls = walls;
  }

  draw(camera, look) {
    const { context, run } = this;
    const { width, height } = context.canvas;
    const perMetre = height / 2 / camera.halfHeight;
    const x = (metres) => width / 2 + (metres - camera.centre[0]) * perMetre;
    const y = (metres) => height / 2 - (metres - camera.centre[1]) * perMetre;
    context.fillStyle = toCss(look.paper);
    context.fillRect(0, 0, width, height);
    this.drawGrains(x, y, perMetre, run.step);
    const line = (from, style, fixed) => {
      context.lineWidth = fixed ? style.pixels * look.density : Math.max(style.metres * from[6] * perMetre, style.pixels);
      context.strokeStyle = toCss(style.colours[from[7] & 1]);
      context.beginPath();
      context.moveTo(x(from[0]), y(from[1]));
      context.lineTo(x(from[3]), y(from[4]));
      context.stroke();
    };
    const all = (lines, style, fixed) => {
      for (let i = 0; i < lines.length; i += 8) line(lines.subarray(i, i + 8), style, fixed);
    };
    if (look.bonds) all(this.bonds, look.bonds, false);
    if (look.walls) all(this.walls.lines, look.walls, true);
  }

  /** Draws all grains of a colour as one path. */
  drawGrains(x, y, perMetre, step) {
    const { context } = this;
    const { places, radii, colours } = this.grains;
    const rows = Array.from(colours.keys()).sort((a, b) => colours[a] - colours[b]);
    context.strokeStyle = "#0009";
    context.lineWidth = 0.7;
    for (let first = 0; first < rows.length; ) {
      const colour = colours[rows[first]];
      context.beginPath();
      for (; first < rows.length && colours[rows[first]] === colour; first++) {
        const row = rows[first];
        const [a, b, r] = [x(places[0][row] * step), y(places[1][row] * step), radii[row] * perMetre];
        context.moveTo(a + r, b);
        context.arc(a, b, r, 0, 2 * Math.PI);
      }
      context.fillStyle = `rgb(${this.palette.slice(4 * colour, 4 * colour + 3).join(" ")})`;
      context.fill();
      context.stroke();
    }
  }
}

function toCss(colour) {
  return `rgb(${colour.slice(0, 3).map((share) => Math.round(255 * share)).join(" ")})`;
}
