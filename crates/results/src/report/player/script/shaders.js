// The programs that run on the graphics card.

/** The projection, in all programs. Lengths in m from the corner of the grid; z = 0 in the plane. */
const PROJECTION = `#version 300 es
precision highp float;
precision highp int;
uniform vec3 right, up, toward, centre;
uniform vec3 scale;      // over m: of x, y and depth
uniform float pixel;     // m
vec4 project(vec3 p) {
  vec3 d = p - centre;
  return vec4(dot(d, right) * scale.x, dot(d, up) * scale.y, -dot(d, toward) * scale.z, 1.0);
}
`;

/**
 * Grains as squares towards the viewer, on which the fragment program draws a disc or a sphere. Points are drawn faster than pairs of
 * triangles where a program takes the place of a graphics card, but they have a largest size.
 */
const grainVertex = (isPoints) => `${PROJECTION}
#define POINTS ${isPoints}
uniform float gridStep, shrink;
uniform vec4 cut;        // grains with dot(cut.xyz, p) > cut.w are not drawn
uniform sampler2D palette;
in float x, y, z, radius, colour;
out vec2 local;          // from the centre, in radii
flat out vec3 fill;
flat out float pixels;
void main() {
  vec3 p = vec3(x, y, z) * gridStep;
  float r = max(radius * shrink, 1e-30);
  gl_Position = project(p);
  if (POINTS) {
    gl_PointSize = 2.0 * (r / pixel + 1.0);
  } else {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    local = corner * (1.0 + pixel / r);
    gl_Position.xy += local * r * scale.xy;
  }
  if (dot(cut.xyz, p) > cut.w) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  fill = texelFetch(palette, ivec2(int(colour), 0), 0).rgb;
  pixels = r / pixel;
}`;

/** The beginning of a program for the pixels of a grain: their places from its centre, in radii. */
const grainFragment = (isPoints) => `#version 300 es
precision highp float;
in vec2 local;
flat in vec3 fill;
flat in float pixels;
out vec4 result;
vec2 place() {
  return ${isPoints} ? (gl_PointCoord * 2.0 - 1.0) * vec2(1.0, -1.0) * (1.0 + 1.0 / pixels) : local;
}`;

/** A disc with an outline; the outline of a disc of few pixels fades. */
const discFragment = (isPoints) => `${grainFragment(isPoints)}
void main() {
  float fromCentre = length(place()) * pixels;
  float cover = clamp(pixels - fromCentre + 0.5, 0.0, 1.0);
  if (cover <= 0.0) discard;
  float line = clamp(0.1 * pixels, 0.6, 1.6);
  float outside = 1.0 - clamp(pixels - line - fromCentre + 0.5, 0.0, 1.0);
  result = vec4(mix(fill, 0.25 * fill, outside * smoothstep(1.0, 4.0, pixels)), cover);
}`;

/**
 * A sphere with light from above the left shoulder, its rim darker. All its pixels have the depth of its centre: of two spheres that do
 * not intersect, the one whose centre is nearer is in front of the other, and the same holds for a plane that touches a sphere.
 */
const sphereFragment = (isPoints) => `${grainFragment(isPoints)}
void main() {
  vec2 from = place();
  float square = dot(from, from);
  if (square > 1.0) discard;
  float height = sqrt(1.0 - square);
  float light = 0.45 + 0.6 * max(dot(vec3(from, height), vec3(-0.35, 0.52, 0.78)), 0.0);
  result = vec4(fill * light * mix(0.45, 1.0, smoothstep(0.15, 0.4, height)), 1.0);
}`;

/** Lines with a width, as rectangles towards the viewer. */
const LINE_VERTEX = `${PROJECTION}
uniform float metres, pixels, casing;   // width: metres times the line's width, at least so many pixels; casing in pixels on each side
in vec3 from, to;
in float width, kind;
out float across;        // pixels from the axis
out vec3 place;
flat out float halfWidth, kindOf, strength;
void main() {
  vec4 a = project(from), b = project(to);
  vec2 size = vec2(1.0) / (scale.xy * pixel);
  vec2 along = (b.xy - a.xy) * size;
  float distance = length(along);
  vec2 unit = distance > 1e-6 ? along / distance : vec2(1.0, 0.0);
  halfWidth = 0.5 * max(metres * width / pixel, pixels);
  float side = float(gl_VertexID & 1) * 2.0 - 1.0;
  float end = float(gl_VertexID >> 1);
  across = side * (halfWidth + casing + 1.0);
  place = mix(from, to, end);
  gl_Position = mix(a, b, end);
  gl_Position.xy += (vec2(-unit.y, unit.x) * across) / size;
  kindOf = kind;
  // Weak forces are faint.
  strength = 0.3 + 0.7 * sqrt(clamp(width, 0.0, 1.0));
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
uniform vec4 colours[2];
uniform vec3 background, low, high;     // lines of kinds 2 and 3 end at the box from low to high
uniform float casing;
in float across;
in vec3 place;
flat in float halfWidth, kindOf, strength;
out vec4 result;
void main() {
  bool isOutside = any(lessThan(place, low)) || any(greaterThan(place, high));
  if (isOutside && kindOf >= 2.0) discard;
  float distance = abs(across);
  float cover = clamp(halfWidth + casing - distance + 0.5, 0.0, 1.0);
  float core = clamp(halfWidth - distance + 0.5, 0.0, 1.0);
  vec4 colour = colours[int(kindOf) & 1];
  result = vec4(casing > 0.0 ? mix(background, colour.rgb, core) : colour.rgb, colour.a * cover * strength);
  if (result.a <= 0.01) discard;
}`;

/** Faces of walls, translucent. */
const FACE_VERTEX = `${PROJECTION}
in vec3 from;
in float kind;
out vec3 place;
flat out float kindOf;
void main() {
  place = from;
  kindOf = kind;
  gl_Position = project(from);
}`;

const FACE_FRAGMENT = `#version 300 es
precision highp float;
uniform vec4 colours[2];
uniform vec3 low, high;
in vec3 place;
flat in float kindOf;
out vec4 result;
void main() {
  bool isOutside = any(lessThan(place, low)) || any(greaterThan(place, high));
  if (isOutside && kindOf >= 2.0) discard;
  result = colours[int(kindOf) & 1];
}`;

/** Compiles a program; `uniforms` finds the places of its parameters. */
function compile(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const shaders = gl.getAttachedShaders(program).map((shader) => gl.getShaderInfoLog(shader));
    throw new Error(`WebGL: ${[gl.getProgramInfoLog(program), ...shaders].join(" ")}`);
  }
  const found = new Map();
  const uniforms = (name) => {
    if (!found.has(name)) found.set(name, gl.getUniformLocation(program, name));
    return found.get(name);
  };
  return { program, uniforms, attribute: (name) => gl.getAttribLocation(program, name) };
}
