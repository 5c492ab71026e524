// GLSL of the picture. Each program is a vertex and a fragment shader.

const HEAD = `#version 300 es
precision highp float;
precision highp int;
uniform mat4 view, proj;
uniform vec4 section; // plane in view coordinates; what is on its positive side is cut away
bool cut(vec3 p) { return dot(section.xyz, p) + section.w > 0.; }
`;

const LIGHT = `
const vec3 KEY = normalize(vec3(.35, .55, .75));
float light(vec3 n) { return .40 + .16 * n.y + .48 * max(0., dot(n, KEY)); }
`;

// Two texels a part: colour and opacity; how far it is moved.
const PART = `
uniform highp sampler2D parts;
vec4 look(int k) { return texelFetch(parts, ivec2(0, k), 0); }
vec3 shift(int k) { return texelFetch(parts, ivec2(1, k), 0).xyz; }
const vec4 NOWHERE = vec4(2., 2., 2., 1.);
`;

// A sphere is a square that faces the eye; its depth is that of the sphere, to the last pixel.
export const SPHERE = [
  `${HEAD}
layout(location=0) in vec3 at;
layout(location=1) in float radius;
layout(location=2) in vec4 tint;
out vec3 seen;
flat out vec3 centre;
flat out float size;
flat out vec3 colour;
void main() {
  vec2 q = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.3 - 1.15;
  vec4 v = view * vec4(at, 1.);
  centre = v.xyz;
  size = radius;
  colour = tint.rgb;
  vec3 z = normalize(-v.xyz), x = normalize(cross(vec3(0, 1, 0), z)), y = cross(z, x);
  v.xyz += (x * q.x + y * q.y + z) * radius;
  seen = v.xyz;
  gl_Position = tint.a == 0. ? vec4(2., 2., 2., 1.) : proj * v;
}`,
  `${HEAD}${LIGHT}
in vec3 seen;
flat in vec3 centre;
flat in float size;
flat in vec3 colour;
uniform bool ghost;
out vec4 o;
void main() {
  if (ghost && ((int(gl_FragCoord.x) + int(gl_FragCoord.y)) & 1) == 0) discard;
  vec3 d = normalize(seen);
  float b = dot(d, centre), k = b * b - dot(centre, centre) + size * size;
  if (k < 0.) discard;
  vec3 p = d * (b - sqrt(k)), n = (p - centre) / size;
  float l = light(n);
  if (cut(p)) {
    p = d * (b + sqrt(k));
    if (cut(p)) discard;
    l = .5;
  }
  vec4 c = proj * vec4(ghost ? p + 5e-4 * d : p, 1.); // a ghost lies behind a body in the same place
  gl_FragDepth = .5 * c.z / c.w + .5;
  o = vec4(colour * l, 1.);
}`,
];

// `pass`: 0 opaque parts, 1 see-through parts, 2 opaque parts that stand before a body
export const MESH = [
  `${HEAD}${PART}
layout(location=0) in vec3 at;
layout(location=1) in uint part;
uniform int pass;
flat out vec4 tint;
out vec3 seen;
void main() {
  int k = int(part);
  tint = look(k);
  vec4 v = view * vec4(at + shift(k), 1.);
  seen = v.xyz;
  bool glass = tint.a < 1.;
  gl_Position = tint.a == 0. || glass != (pass == 1) ? NOWHERE : proj * v;
}`,
  `${HEAD}${LIGHT}
flat in vec4 tint;
in vec3 seen;
uniform int pass;
uniform float veil;
out vec4 o;
void main() {
  if (cut(seen)) discard;
  vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
  o = vec4(tint.rgb * (.18 + .92 * light(n)), pass == 2 ? veil : tint.a);
}`,
];

export const LINE = [
  `${HEAD}${PART}
layout(location=0) in vec3 at;
layout(location=1) in uint part;
flat out float opacity;
out vec3 seen;
void main() {
  int k = int(part);
  opacity = look(k).a;
  vec4 v = view * vec4(at + shift(k), 1.);
  seen = v.xyz;
  v.xyz *= .9985;
  gl_Position = opacity == 0. ? NOWHERE : proj * v;
}`,
  `${HEAD}
flat in float opacity;
in vec3 seen;
uniform vec4 ink;
out vec4 o;
void main() {
  if (cut(seen)) discard;
  o = vec4(ink.rgb, ink.a * (opacity < 1. ? .5 : 1.));
}`,
];

// Lines of a width in pixels between two points: dimension lines.
export const MARK = [
  `${HEAD}
layout(location=0) in vec3 a;
layout(location=1) in vec3 b;
layout(location=2) in vec3 tint;
uniform vec2 size;
uniform float width;
flat out vec3 colour;
void main() {
  vec4 p = proj * view * vec4(a, 1.), q = proj * view * vec4(b, 1.);
  vec2 d = normalize((q.xy / q.w - p.xy / p.w) * size + 1e-6), n = vec2(-d.y, d.x);
  bool first = (gl_VertexID & 2) == 0;
  vec4 e = first ? p : q;
  float side = (gl_VertexID & 1) == 0 ? -1. : 1.;
  e.xy += (n * side + (first ? -d : d)) * width / size * e.w;
  colour = tint;
  gl_Position = e;
}`,
  `${HEAD}
flat in vec3 colour;
out vec4 o;
void main() { o = vec4(colour, 1.); }`,
];
