// The pointer moves, turns and zooms the view.

/** Drags and the wheel: they move the plane, and turn solid space. The wheel zooms if the picture has the focus. */
function listenToPointer(canvas, view, redraw) {
  const { camera } = view;
  let last = null;
  canvas.addEventListener("pointerdown", (event) => {
    last = event;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last || event.pointerId !== last.pointerId) return;
    const [x, y] = [event.clientX - last.clientX, event.clientY - last.clientY];
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
    const box = canvas.getBoundingClientRect();
    const half = box.height / 2;
    camera.zoomBy(Math.exp(-0.0015 * event.deltaY), (event.clientX - box.left - box.width / 2) / half, (half - event.clientY + box.top) / half);
    redraw();
  }, { passive: false });
}

