// What lies over a scene and is no part of it: ghosts of bodies, and see-through surfaces.

const NOTHING = { ghosts: [], veils: [] };

export class Over {
  constructor(card) {
    Object.assign(this, { card, given: NOTHING, ghosts: [], veils: [] });
  }

  // ghosts: [{ of, centres, radius, tint }], each shown while the body `of` of the scene is; veils: surfaces with
  // lines on them, { vertices, part (the index of a look), triangles, edges, looks: [[r, g, b, opacity]], ink }.
  set(given) {
    this.given = given;
    this.build();
  }

  build() {
    const { card, given } = this;
    this.ghosts = given.ghosts.map((ghost) => ({ ...card.buildBody(ghost), of: ghost.of, count: ghost.radius.length }));
    this.veils = given.veils.map(({ vertices, part, triangles, edges, looks, ink }) => {
      const texture = card.gl.createTexture();
      card.setLooks(texture, new Float32Array(looks.flatMap((look) => [...look, 0, 0, 0, 0])));
      const [faces, lines] = [triangles, edges].map((index) => card.buildMesh(vertices, part, index));
      return { faces, lines, looks: texture, ink };
    });
  }

  // Every other pixel of a ghost is there.
  paintGhosts(at, { bodies }) {
    const { gl } = this.card;
    gl.uniform1i(at.ghost, 1);
    for (const { vao, of, count } of this.ghosts) {
      if (!bodies[of]) continue;
      gl.bindVertexArray(vao);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    }
  }

  paintVeils(use) {
    if (!this.veils.length) return;
    const { gl } = this.card;
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    for (const veil of this.veils) {
      for (const [name, kind] of [["MESH", gl.TRIANGLES], ["LINE", gl.LINES]]) {
        const at = use(name);
        const mesh = veil[kind === gl.LINES ? "lines" : "faces"];
        gl.bindTexture(gl.TEXTURE_2D, veil.looks);
        if (at.pass) gl.uniform1i(at.pass, 1);
        if (at.ink) gl.uniform4fv(at.ink, veil.ink);
        gl.bindVertexArray(mesh.vao);
        gl.drawElements(kind, mesh.count, gl.UNSIGNED_INT, 0);
      }
    }
    gl.depthMask(true);
  }
}
