/** A block of uniforms that is written by name: the driver says where each is. */

export class UniformBlock {
  #gl;
  #buffer;
  #bytes;
  /** Offset of each member and whether it is of whole numbers. @type {Map<string, { offset: number, isWhole: boolean }>} */
  #members = new Map();

  /** @param {import('./gl.js').GL} gl @param {WebGLProgram} program @param {string} name */
  constructor(gl, program, name) {
    this.#gl = gl;
    const block = gl.getUniformBlockIndex(program, name);
    const indices = gl.getActiveUniformBlockParameter(program, block, gl.UNIFORM_BLOCK_ACTIVE_UNIFORM_INDICES) ?? [];
    const offsets = gl.getActiveUniforms(program, [...indices], gl.UNIFORM_OFFSET) ?? [];
    for (const [at, index] of [...indices].entries()) {
      const info = gl.getActiveUniform(program, index);
      const isWhole = info?.type === gl.UNSIGNED_INT || info?.type === gl.UNSIGNED_INT_VEC3;
      // the last part of a name, without what naga appends to names that end in a digit
      if (info) this.#members.set(info.name.replace(/^.*\./, '').replace(/_$/, ''), { offset: offsets[at], isWhole });
    }
    const size = gl.getActiveUniformBlockParameter(program, block, gl.UNIFORM_BLOCK_DATA_SIZE) ?? 0;
    this.#bytes = new DataView(new ArrayBuffer(size));
    this.#buffer = gl.createBuffer();
    gl.uniformBlockBinding(program, block, 0);
  }

  /** Writes all members and binds the block. @param {Record<string, number | number[]>} values @param {{ isFine: boolean }} flags */
  write(values, { isFine }) {
    for (const [name, value] of Object.entries({ ...values, is_fine: isFine ? 1 : 0 })) {
      const member = this.#members.get(name);
      if (!member) throw new Error(`the kernel has no "${name}"`);
      for (const [at, number] of [value].flat().entries()) {
        if (member.isWhole) this.#bytes.setUint32(member.offset + 4 * at, number, true);
        else this.#bytes.setFloat32(member.offset + 4 * at, number, true);
      }
    }
    const gl = this.#gl;
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, this.#buffer);
    gl.bufferData(gl.UNIFORM_BUFFER, this.#bytes, gl.DYNAMIC_DRAW);
  }
}
