// Programs of the graphics card, and what they are given.

const GLASS = 0.22; // opacity

// A plane [a, b, c, d] of the world in view coordinates.
export function inView([a, b, c, d], v) {
  const n = [0, 1, 2].map((row) => v[row] * a + v[4 + row] * b + v[8 + row] * c);
  return [...n, d - (n[0] * v[12] + n[1] * v[13] + n[2] * v[14])];
}

// A program with the places of its uniforms, of the sources of its two shaders.
export function program(gl, [vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, source] of [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(gl.getProgramInfoLog(made));
  }
  const at = {};
  for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
    const { name } = gl.getActiveUniform(made, k);
    at[name] = gl.getUniformLocation(made, name);
  }
  return { made, at };
}

// Colour, opacity and displacement of the parts of a place, eight numbers each.
export function looksOf(parts, isShown, dim) {
  const looks = new Float32Array(8 * parts.length);
  parts.forEach((part, k) => {
    const colour = part.colour.map((c) => (c / 255) * dim);
    const opacity = !isShown(k) ? 0 : part.glass ? GLASS : 1;
    looks.set([...colour, opacity, ...(part.shift || [0, 0, 0]), 0], 8 * k);
  });
  return looks;
}

// A line from point to point as nine numbers: { from, to, colour }.
export function lineNumbers({ from, to, colour }) {
  return [...from, ...to, ...colour.map((c) => c / 255)];
}
