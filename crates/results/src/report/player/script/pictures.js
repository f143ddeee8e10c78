// A run as a series of pictures, in place of a view that draws grains.

/** Unpacks the steps and the pictures of a run (crates/results/src/report/player/pictures.rs). */
function decodePictures(run, facts, pictures) {
  run.times = facts.column(Float64Array, run.frames);
  const lengths = facts.column(Uint32Array, run.frames);
  run.frameList = Array.from(lengths, (length, number) => ({ number, time: run.times[number], svg: pictures.take(length) }));
  return run;
}

class PictureView {
  /** Shows pictures in an image; `onShape` is told width over height of the first. */
  constructor(image, onShape) {
    this.image = image;
    image.addEventListener("load", () => onShape(image.naturalWidth / image.naturalHeight), { once: true });
  }

  show(frame) {
    const before = this.url;
    this.url = URL.createObjectURL(new Blob([frame.svg], { type: "image/svg+xml" }));
    this.image.src = this.url;
    // The picture before is shown until the new one has been read.
    if (before) this.image.decode().catch(() => {}).finally(() => URL.revokeObjectURL(before));
  }

  redraw() {}
}
