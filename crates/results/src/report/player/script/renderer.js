// Draws a frame with WebGL 2.

class Renderer {
  constructor(canvas, run) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, powerPreference: "high-performance" });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    this.run = run;
    this.isSolid = run.dimension === 3;
    // As pairs of triangles, and as points.
    this.grains = [false, true].map((isPoints) => compile(gl, grainVertex(isPoints), (this.isSolid ? sphereFragment : discFragment)(isPoints)));
    this.lines = compile(gl, LINE_VERTEX, LINE_FRAGMENT);
    this.faces = compile(gl, FACE_VERTEX, FACE_FRAGMENT);
    this.palette = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.palette);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    this.grainBuffers = Object.fromEntries(["x", "y", "z", "radius", "colour"].map((name) => [name, gl.createBuffer()]));
    this.grainArrays = this.grains.map((program, isPoints) => this.instances(program, isPoints ? 0 : 1));
    this.order = gl.createBuffer();
    this.bondArray = this.lineArray();
    this.wallArray = this.lineArray();
    this.faceArray = this.strided(this.faces, { from: [3, 0], kind: [1, 12] }, 16, 0);
    this.count = 0;
  }

  /** An array with a buffer for each attribute of grains. */
  instances(program, divisor) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    for (const [name, buffer] of Object.entries(this.grainBuffers)) {
      const place = program.attribute(name);
      // In the plane z is 0, the value of an attribute without an array.
      if (name === "z" && !this.isSolid) continue;
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 1, name === "radius" ? gl.FLOAT : gl.UNSIGNED_SHORT, false, 0, 0);
      gl.vertexAttribDivisor(place, divisor);
    }
    return array;
  }

  /** An array of floats in one buffer; `names` has the count and the first byte of each attribute. */
  strided(program, names, stride, divisor) {
    const { gl } = this;
    const [array, buffer] = [gl.createVertexArray(), gl.createBuffer()];
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    for (const [name, [count, start]] of Object.entries(names)) {
      const place = program.attribute(name);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, count, gl.FLOAT, false, stride, start);
      gl.vertexAttribDivisor(place, divisor);
    }
    return { array, buffer, count: 0 };
  }

  lineArray() {
    return this.strided(this.lines, { from: [3, 0], to: [3, 12], width: [1, 24], kind: [1, 28] }, 32, 1);
  }

  fill(buffer, numbers) {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, buffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, numbers, this.gl.DYNAMIC_DRAW);
  }

  /** Sets the grains: columns of places, radii (m) and places in the palette. */
  setGrains(places, radii, colours) {
    const buffers = this.grainBuffers;
    this.places = places;
    this.radii = radii;
    ["x", "y", "z"].forEach((axis, number) => places[number] && this.fill(buffers[axis], places[number]));
    this.largest = radii.reduce((most, radius) => Math.max(most, radius), 0);
    this.fill(buffers.radius, radii);
    this.fill(buffers.colour, colours);
    this.count = colours.length;
  }

  setPalette(palette) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.palette);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, palette.length / 4, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, palette);
  }

  setBonds(lines) {
    this.fill(this.bondArray.buffer, lines);
    this.bondArray.count = lines.length / 8;
  }

  setWalls({ faces, lines }) {
    this.fill(this.faceArray.buffer, faces);
    this.faceArray.count = faces.length / 4;
    this.fill(this.wallArray.buffer, lines);
    this.wallArray.count = lines.length / 8;
  }

  /** Selects a program and gives it the projection. */
  use({ program, uniforms }, camera) {
    const { gl } = this;
    const half = camera.halfHeight;
    gl.useProgram(program);
    for (const name of ["right", "up", "toward", "centre"]) gl.uniform3fv(uniforms(name), camera[name]);
    gl.uniform3f(uniforms("scale"), 1 / (half * camera.aspect), 1 / half, 1 / camera.halfDepth);
    gl.uniform1f(uniforms("pixel"), (2 * half) / gl.drawingBufferHeight);
    return uniforms;
  }

  /** Draws with a camera; `look` has colours of the page, what is shown, and the cut. */
  draw(camera, look) {
    const { gl } = this;
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(...look.paper, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.setEnabled(gl.DEPTH_TEST, this.isSolid);
    this.drawGrains(camera, look);
    if (look.bonds) this.drawLines(this.bondArray, camera, look.bonds, look);
    if (look.walls && this.isSolid) this.drawFaces(camera, look);
    if (look.walls) this.drawLines(this.wallArray, camera, look.walls, look);
  }

  setEnabled(what, isOn) {
    if (isOn) this.gl.enable(what);
    else this.gl.disable(what);
  }

  drawGrains(camera, look) {
    const { gl } = this;
    // A point is not drawn if its centre is outside of the viewport, so the viewport has a margin of the largest radius.
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const margin = Math.ceil((this.largest * look.shrink * height) / (2 * camera.halfHeight)) + 2;
    const isPoints = 2 * margin <= Math.min(gl.getParameter(gl.ALIASED_POINT_SIZE_RANGE)[1], 256);
    const uniforms = this.use(this.grains[Number(isPoints)], camera);
    if (isPoints) {
      const half = camera.halfHeight;
      gl.viewport(-margin, -margin, width + 2 * margin, height + 2 * margin);
      gl.uniform3f(uniforms("scale"), width / (half * camera.aspect * (width + 2 * margin)), height / (half * (height + 2 * margin)), 1 / camera.halfDepth);
    }
    this.setEnabled(gl.BLEND, !this.isSolid);
    gl.uniform1f(uniforms("gridStep"), this.run.step);
    gl.uniform1f(uniforms("shrink"), look.shrink);
    gl.uniform4fv(uniforms("cut"), look.cut);
    gl.bindTexture(gl.TEXTURE_2D, this.palette);
    gl.bindVertexArray(this.grainArrays[Number(isPoints)]);
    if (isPoints && this.isSolid) this.drawVisible(camera, look, (2 * camera.halfHeight) / height, [width, height]);
    else if (isPoints) gl.drawArrays(gl.POINTS, 0, this.count);
    else gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
    gl.viewport(0, 0, width, height);
  }

  /** Draws spheres as points, those that can be seen. */
  drawVisible(camera, look, pixel, size) {
    const { gl } = this;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.order);
    const radii = look.shrink === 1 ? this.radii : this.radii.map((radius) => radius * look.shrink);
    const cell = look.shrink * look.middleRadius;
    const rows = visibleRows(this.places, radii, this.run.step, camera, pixel, size, look.cut, cell);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, rows, gl.DYNAMIC_DRAW);
    gl.drawElements(gl.POINTS, rows.length, gl.UNSIGNED_INT, 0);
  }

  drawLines(array, camera, style, look) {
    const { gl } = this;
    const uniforms = this.use(this.lines, camera);
    gl.enable(gl.BLEND);
    gl.uniform1f(uniforms("metres"), style.metres);
    gl.uniform1f(uniforms("pixels"), style.pixels * look.density);
    gl.uniform1f(uniforms("casing"), style.casing * look.density);
    gl.uniform3fv(uniforms("background"), look.paper);
    gl.uniform4fv(uniforms("colours"), style.colours.flat());
    gl.uniform3fv(uniforms("low"), style.box[0]);
    gl.uniform3fv(uniforms("high"), style.box[1]);
    gl.bindVertexArray(array.array);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, array.count);
  }

  drawFaces(camera, look) {
    const { gl } = this;
    const uniforms = this.use(this.faces, camera);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.uniform4fv(uniforms("colours"), look.faces.flat());
    gl.uniform3fv(uniforms("low"), look.walls.box[0]);
    gl.uniform3fv(uniforms("high"), look.walls.box[1]);
    gl.bindVertexArray(this.faceArray.array);
    gl.drawArrays(gl.TRIANGLES, 0, this.faceArray.count);
  }
}
