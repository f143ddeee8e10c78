// The pointer moves, turns and zooms the view, and points at grains.

/**
 * Drags and the wheel: they move the plane, and turn solid space. The wheel zooms if the picture has the focus. `point` is called with the place
 * under the pointer, in parts of the half height from the middle, and whether it was clicked; with null when the pointer leaves.
 */
function listenToPointer(canvas, view, redraw, point = () => {}) {
  const { camera } = view;
  let last = null;
  let way = 0;
  const placeOf = (event) => {
    const box = canvas.getBoundingClientRect();
    const half = box.height / 2;
    return [(event.clientX - box.left - box.width / 2) / half, (half - event.clientY + box.top) / half];
  };
  // The page may scroll to the picture between the press, which focuses it, and the click.
  let pressed = null;
  canvas.addEventListener("click", () => pressed && way < 4 && point(pressed, true));
  canvas.addEventListener("pointerleave", () => point(null, false));
  canvas.addEventListener("pointerdown", (event) => {
    last = event;
    pressed = placeOf(event);
    way = 0;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last) point(placeOf(event), false);
    if (!last || event.pointerId !== last.pointerId) return;
    const [x, y] = [event.clientX - last.clientX, event.clientY - last.clientY];
    way += Math.abs(x) + Math.abs(y);
    last = event;
    const isTurn = view.isSolid && !event.shiftKey && !(event.buttons & 2);
    if (isTurn) camera.turnTo(camera.turn - 0.4 * x, camera.tilt + 0.4 * y);
    else camera.pan((2 * x) / canvas.clientHeight, (-2 * y) / canvas.clientHeight);
    redraw();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (last = null));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    camera.zoomBy(Math.exp(-0.0015 * event.deltaY), ...placeOf(event));
    redraw();
  }, { passive: false });
}

