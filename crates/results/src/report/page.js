/* Starts the players of the page, keeps them at the same time, and draws that time into the figures.

   Each player has the clock of its run. Players are kept together by simulated time or, if the box `since-opening` is ticked, by the time
   since their doors opened. The player that the reader used last leads, and the others are paused. */
(async () => {
  "use strict";
  const boxes = [...document.querySelectorAll("[data-frames]")];
  const choice = document.getElementById("since-opening");
  const openings = boxes.map((box) => Number(box.dataset.opening ?? NaN));
  const players = await Promise.all(boxes.map((box) => siloflowPlayer(box, box.dataset.frames)));
  const works = (player) => player.times.length > 0;
  let leader = players.findIndex(works);
  let time = leader < 0 ? NaN : players[leader].times[0];

  /* The time of a run at the present moment of the leader. */
  const timeOf = (number) => {
    const isSinceOpening = choice?.checked && Number.isFinite(openings[number]) && Number.isFinite(openings[leader]);
    return isSinceOpening ? time - openings[leader] + openings[number] : time;
  };

  const svgName = "http://www.w3.org/2000/svg";
  const panels = [...document.querySelectorAll(".plot [data-from]")].map((group) => {
    const { left, right, top, bottom, from, to } = group.dataset;
    return {
      group, lines: [], numbers: [left, right, top, bottom, from, to].map(Number),
      isSinceOpening: group.dataset.clock === "opening",
    };
  });

  /* Draws the times of all runs into the figures: one line where they agree. */
  const drawCursors = () => {
    for (const { group, lines, numbers: [left, right, top, bottom, from, to], isSinceOpening } of panels) {
      const times = players.map((player, number) => works(player) && timeOf(number) - (isSinceOpening ? openings[number] : 0));
      const places = [...new Set(times.filter(Number.isFinite))].filter((at) => at >= from && at <= to && to > from);
      while (lines.length < places.length) {
        const line = document.createElementNS(svgName, "line");
        line.setAttribute("class", "cursor");
        group.append(line);
        lines.push(line);
      }
      lines.forEach((line, number) => {
        const isShown = number < places.length;
        line.setAttribute("visibility", isShown ? "visible" : "hidden");
        if (!isShown) return;
        const x = left + (right - left) * (places[number] - from) / (to - from);
        for (const [name, value] of [["x1", x], ["x2", x], ["y1", top], ["y2", bottom]]) line.setAttribute(name, value);
      });
    }
  };

  const follow = () => {
    players.forEach((player, number) => {
      if (number !== leader) player.setTime(timeOf(number));
    });
    drawCursors();
  };

  players.forEach((player, number) => player.onTime((now) => {
    if (number !== leader) players[leader].pause();
    leader = number;
    time = now;
    follow();
  }));
  choice?.addEventListener("change", follow);
  if (leader >= 0) {
    // The page begins where the silo is full, if it opens at all.
    const { times } = players[leader];
    if (openings[leader] >= times[0] && openings[leader] <= times.at(-1)) time = openings[leader];
    players[leader].setTime(time);
    follow();
  }

  /* A click on a figure sets the time. */
  for (const panel of panels) {
    panel.group.ownerSVGElement?.addEventListener("click", (event) => {
      const matrix = panel.group.getScreenCTM();
      if (leader < 0 || !matrix) return;
      const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
      const [left, right, top, bottom, from, to] = panel.numbers;
      if (x < left || x > right || y < Math.min(top, bottom) || y > Math.max(top, bottom)) return;
      const at = from + (to - from) * (x - left) / (right - left);
      time = panel.isSinceOpening ? at + openings[leader] : at;
      players[leader].setTime(time);
      follow();
    });
  }
})();
