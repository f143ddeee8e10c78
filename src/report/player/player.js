// The player of a report.
"use strict";
function siloflowPlayer(container, dataId) {
  container.textContent = "";
  return Promise.resolve({ times: [], setTime() {}, onTime() {} });
}
