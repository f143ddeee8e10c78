// The view: an orthographic projection.

/** Named views of solid space: angle around the vertical, and elevation, in degrees. */
const VIEWS = { front: [0, 0], side: [90, 0], top: [0, 90], oblique: [30, 20] };

class Camera {
  /** Shows a box; all lengths in m from the corner of the grid. */
  constructor(box, isSolid) {
    this.box = box;
    this.isSolid = isSolid;
    this.aspect = 1;
    this.turnTo(...(isSolid ? VIEWS.oblique : [0, 0]));
    this.fit();
  }

  turnTo(turn, tilt) {
    this.turn = ((turn % 360) + 360) % 360;
    this.tilt = Math.min(Math.max(tilt, -90), 90);
    const [a, b] = [(this.turn * Math.PI) / 180, (this.tilt * Math.PI) / 180];
    if (!this.isSolid) {
      [this.right, this.up, this.toward] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
      return;
    }
    this.right = [Math.cos(a), Math.sin(a), 0];
    this.toward = [Math.sin(a) * Math.cos(b), -Math.cos(a) * Math.cos(b), Math.sin(b)];
    const [r, t] = [this.right, this.toward];
    this.up = [t[1] * r[2] - t[2] * r[1], t[2] * r[0] - t[0] * r[2], t[0] * r[1] - t[1] * r[0]];
  }

  /** Shows the whole box. */
  fit() {
    this.zoom = 1;
    this.centre = [0, 1, 2].map((axis) => (this.box[0][axis] + this.box[1][axis]) / 2);
  }

  /** Half the extent of the box along a direction. */
  reach(direction) {
    return direction.reduce((sum, share, axis) => sum + (Math.abs(share) * (this.box[1][axis] - this.box[0][axis])) / 2, 0);
  }

  /** Half the height of the view, m. */
  get halfHeight() {
    const whole = Math.max(this.reach(this.up), this.reach(this.right) / this.aspect);
    return (1.04 * (whole || 1)) / this.zoom;
  }

  /** Moves the picture by parts of the half height. */
  pan(x, y) {
    const length = this.halfHeight;
    this.centre = this.centre.map((c, axis) => c - length * (x * this.right[axis] + y * this.up[axis]));
  }

  /** Zooms around a point of the view, given in parts of the half height from its middle. */
  zoomBy(factor, x = 0, y = 0) {
    const before = this.halfHeight;
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.2), 400);
    const change = before - this.halfHeight;
    this.centre = this.centre.map((c, axis) => c + change * (x * this.right[axis] + y * this.up[axis]));
  }

  /** Half the depth that is drawn, m. */
  get halfDepth() {
    const size = Math.hypot(...[0, 1, 2].map((axis) => this.box[1][axis] - this.box[0][axis]));
    const offset = Math.hypot(...this.centre.map((c, axis) => c - (this.box[0][axis] + this.box[1][axis]) / 2));
    return 4 * (size + offset) || 1;
  }
}
