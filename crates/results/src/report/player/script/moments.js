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

/** The time of a frame, with the digits that tell neighbouring frames apart. */
function timeOf(run, number) {
  const apart = (run.times[run.frames - 1] - run.times[0]) / Math.max(run.frames - 1, 1);
  run.digits ??= apart > 0 ? Math.min(Math.max(Math.ceil(-Math.log10(apart) - 1e-9), 0), 9) : 3;
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
    ? `Shown are ${run.frames} of the ${run.frames_of_run} ${run.is_pictures ? "pictures" : "frames"} of the run, to keep this page small. `
    : "";
  if (run.is_pictures) return `${frames}These are the pictures in frames/ of the run directory.`;
  const finest = run.step * 1000;
  const resolution = finest < 1 ? `${shortNumber(finest * 1000, 2)} µm` : `${shortNumber(finest, 2)} mm`;
  return `${frames}Positions here are rounded to ${resolution}, colours to ${run.top + 1} levels; frames.bin has all digits.`;
}

