// A link that carries a scene: its text, compressed, in the fragment, which a browser sends to no server.

/** Most characters of a scene that is unpacked. */
const LONGEST_SCENE = 1_000_000;

/** A name of a scene as a file name. */
function safeName(name) {
  const safe = String(name).replace(/[^A-Za-z0-9_-]+/g, "-").replace(/^-+|-+$/g, "").slice(0, 60);
  return safe || "scene";
}

async function toFragment(scene) {
  const stream = new Blob([JSON.stringify(scene)]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let letters = "";
  for (const byte of bytes) letters += String.fromCharCode(byte);
  return `#s=${btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
}

/** The scene of a fragment; null if there is none. Throws if it is damaged, too long, or no scene. */
async function fromFragment(fragment) {
  const packed = /^#s=([A-Za-z0-9_-]+)$/.exec(fragment)?.[1];
  if (!packed) {
    if (fragment.startsWith("#s=")) throw new Error("the link is damaged");
    return null;
  }
  const letters = atob(packed.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
  const decoder = new TextDecoder("utf-8", { fatal: true });
  let text = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) break;
    text += decoder.decode(value, { stream: true });
    if (text.length > LONGEST_SCENE) {
      reader.cancel();
      throw new Error("the link holds more than a scene");
    }
  }
  const scene = JSON.parse(text + decoder.decode());
  if (typeof scene?.text !== "string") throw new Error("the link holds no scene");
  return { name: safeName(scene.name ?? "scene"), from: typeof scene.from === "string" ? scene.from : null, text: scene.text };
}
