// Results to download: single files, and the whole run directory as a tar archive.

function download(name, parts, type = "application/octet-stream") {
  const address = URL.createObjectURL(new Blob(parts, { type }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** The header of a file in a tar archive (ustar). */
function tarHeader(path, size) {
  const header = new Uint8Array(512);
  const put = (at, text) => header.set(new TextEncoder().encode(text), at);
  const octal = (number, digits) => `${number.toString(8).padStart(digits, "0")}\0`;
  // A path that is longer than 100 bytes is cut at a slash.
  const cut = path.length > 100 ? path.lastIndexOf("/", 154) : -1;
  put(0, path.slice(cut + 1));
  put(100, octal(0o644, 7));
  put(108, octal(0, 7));
  put(116, octal(0, 7));
  put(124, octal(size, 11));
  put(136, octal(Math.floor(Date.now() / 1000), 11));
  put(148, "        0");
  put(257, "ustar\u000000");
  if (cut > 0) put(345, path.slice(0, cut));
  put(148, `${header.reduce((sum, byte) => sum + byte, 0).toString(8).padStart(6, "0")}\0 `);
  return header;
}

/** Files (path and bytes) as a tar archive, in parts. */
function tar(directory, files) {
  const parts = files.flatMap(([path, bytes]) => [tarHeader(`${directory}/${path}`, bytes.length), bytes, new Uint8Array(-bytes.length & 511)]);
  return [...parts, new Uint8Array(1024)];
}
