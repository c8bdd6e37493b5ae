// Strict CBOR (RFC 8949) with typed arrays (RFC 8746), as the bus carries it.
//
// Refused, by CborError: indefinite lengths, duplicate or non-text keys, unknown tags, arrays that
// do not fill their dimensions, deep nesting, trailing bytes. 64-bit integers become Numbers:
// stamps in ns lose less than a microsecond. The host is taken to be little-endian, as all are.

const MAX_DEPTH = 16;
const ROW_MAJOR = 40;

const TYPED = {
  64: [Uint8Array, 1],
  72: [Int8Array, 1],
  69: [Uint16Array, 2],
  70: [Uint32Array, 4],
  77: [Int16Array, 2],
  78: [Int32Array, 4],
  85: [Float32Array, 4],
  86: [Float64Array, 8],
};

export class CborError extends Error {}

/** Returns the one value that `bytes` (Uint8Array) holds; a matrix is {shape, data}. */
export function decode(bytes) {
  const reader = new Reader(bytes);
  const value = reader.value(0);
  if (reader.at !== bytes.length) throw new CborError("bytes are left over");
  return value;
}

class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  value(depth) {
    if (depth > MAX_DEPTH) throw new CborError("nested too deeply");
    const head = this.take(1)[0];
    const kind = head >> 5;
    if (kind === 7) return this.simple(head & 31);
    const count = this.count(head & 31);
    switch (kind) {
      case 0:
        return count;
      case 1:
        return -1 - count;
      case 2:
        return this.take(count);
      case 3:
        return this.text(count);
      case 4:
        return this.list(count, depth);
      case 5:
        return this.map(count, depth);
      default:
        return tagged(count, this.value(depth + 1));
    }
  }

  count(info) {
    if (info < 24) return info;
    if (info > 27) throw new CborError("indefinite lengths have no place here");
    const width = 1 << (info - 24);
    const at = this.at;
    this.take(width);
    if (width === 1) return this.view.getUint8(at);
    if (width === 2) return this.view.getUint16(at);
    if (width === 4) return this.view.getUint32(at);
    return Number(this.view.getBigUint64(at));
  }

  simple(info) {
    const at = this.at;
    if (info === 20 || info === 21) return info === 21;
    if (info === 22) return null;
    if (info === 25) return half(new DataView(this.take(2).slice().buffer).getUint16(0));
    if (info === 26) return this.take(4) && this.view.getFloat32(at);
    if (info === 27) return this.take(8) && this.view.getFloat64(at);
    throw new CborError(`simple value ${info} has no place here`);
  }

  take(length) {
    if (this.at + length > this.bytes.length) throw new CborError("the message is cut short");
    this.at += length;
    return this.bytes.subarray(this.at - length, this.at);
  }

  text(length) {
    try {
      return new TextDecoder("utf-8", { fatal: true }).decode(this.take(length));
    } catch (error) {
      throw error instanceof CborError ? error : new CborError("text is not UTF-8");
    }
  }

  list(length, depth) {
    if (length > this.bytes.length - this.at) throw new CborError("the message is cut short");
    const list = [];
    for (let i = 0; i < length; i++) list.push(this.value(depth + 1));
    return list;
  }

  map(length, depth) {
    const map = Object.create(null);
    for (let i = 0; i < length; i++) {
      const key = this.value(depth + 1);
      if (typeof key !== "string") throw new CborError("keys are text");
      if (key in map) throw new CborError(`key '${key}' appears twice`);
      map[key] = this.value(depth + 1);
    }
    return map;
  }
}

function tagged(tag, content) {
  if (tag === ROW_MAJOR) return shaped(content);
  if (!(content instanceof Uint8Array)) throw new CborError(`tag ${tag} has no place here`);
  // A copy begins where its type may begin; in the message it need not.
  if (tag === 84) return Float32Array.from(new Uint16Array(content.slice().buffer), half);
  if (tag === 79) return Float64Array.from(new BigInt64Array(content.slice().buffer), Number);
  const typed = TYPED[tag];
  if (!typed) throw new CborError(`tag ${tag} has no place here`);
  const [Kind, width] = typed;
  if (content.length % width) throw new CborError("a typed array is cut short");
  return new Kind(content.slice().buffer);
}

function shaped(content) {
  const [shape, data] = Array.isArray(content) && content.length === 2 ? content : [];
  if (!Array.isArray(shape) || !ArrayBuffer.isView(data)) {
    throw new CborError("a matrix is [[dimensions], typed array]");
  }
  const size = shape.reduce((product, length) => product * length, 1);
  if (size !== data.length) throw new CborError(`the data do not fill ${shape}`);
  return { shape, data };
}

function half(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 0x3ff;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}
