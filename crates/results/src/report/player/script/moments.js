// Times of frames, and words about them.

/** The last frame at or before a time. */
function frameAt(times, time) {
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const half = Math.ceil((low + high) / 2);
    if (times[half] <= time * (1 + 1e-12)) low = half;
    else high = half - 1;
  }
  return low;
}

/** The time of a frame with as many digits as the times of the first frames have. */
function timeOf(run, number) {
  run.digits ??= [0, 1, 2, 3, 4, 5, 6, 7, 8].find((digits) =>
    run.times.subarray(0, 3).every((time) => Math.abs(time * 10 ** digits - Math.round(time * 10 ** digits)) < 1e-4)) ?? 9;
  return run.times[number].toFixed(run.digits);
}

/** The time of a frame with its unit. */
function momentOf(run, number) {
  return run.is_pictures ? `step ${run.times[number]}` : `${timeOf(run, number)} s`;
}

function speedUnit(run) {
  return run.is_pictures ? "steps per second" : "× real time";
}

/** What the player leaves out. */
function noteOf(run) {
  const frames = run.frames < run.frames_of_run
    ? `Shown are ${run.frames} of the ${run.frames_of_run} ${run.is_pictures ? "pictures" : "frames"} of the run, evenly spaced, to keep this page small. `
    : "";
  if (run.is_pictures) return `${frames}These are the pictures in frames/ of the run directory.`;
  const finest = run.step * 1000;
  const resolution = finest < 1 ? `${shortNumber(finest * 1000, 2)} µm` : `${shortNumber(finest, 2)} mm`;
  return `${frames}Positions here are rounded to ${resolution}, colours to ${run.top + 1} levels; frames.bin has all digits.`;
}

