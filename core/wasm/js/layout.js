// Structs of the C interface as they lie in a memory of 32 bits, and the checks of what JavaScript gives.

import { ArboledaError, codeOf, invalid } from "./errors.js";

/** Bytes of the structs; and of two words. */
export const SIZE = {
    handle: 256,
    mesh: 24,
    options: 80,
    error: 176,
    description: 24,
    ray: 32,
    hit: 16,
    counters: 16,
    words: 8,
};
/** `ARB_NO_TRIANGLE`, and the word that stands for what is not there. */
export const NONE = 0xffffffff;

const text = (u8, first) => {
    let end = first;
    while (u8[end] !== 0) end += 1;
    return String.fromCharCode(...u8.subarray(first, end));
};

/** The string that begins at an address. */
export const textAt = (heap, first) => text(heap.views.u8, first >>> 0);

/** Throws the error that a function has reported. */
export const check = (heap, status, error) => {
    if (status === 0) return;
    const { u8, u32 } = heap.views;
    const [element] = u32.subarray(error / 4 + 1);
    const thrown = new ArboledaError(codeOf(status), text(u8, error + 16), element);
    thrown.neededBytes = u32[error / 4 + 2];
    throw thrown;
};

const isWhole = (value, most) => Number.isInteger(value) && value >= 0 && value <= most;

/** Checks a whole number. WebAssembly takes any number modulo 2^32, so one out of range would become another. */
export const whole = (name, value, most = NONE) => {
    if (!isWhole(value, most))
        throw invalid(`${name} must be a whole number from 0 to ${most}, and is ${String(value)}`);
    return value;
};

const number = (name, value) => {
    if (typeof value !== "number") throw invalid(`${name} must be a number, and is ${String(value)}`);
    return value;
};

/** Writers of the options, by name. The rest of the checks are the core's. */
const OPTIONS = {
    leafCapacity: (data, at, value) => data.setUint32(at + 4, whole("leafCapacity", value), true),
    level: (data, at, value) => {
        const level = value === "automatic" ? -1 : whole("level", value, 0x7fffffff);
        data.setInt32(at + 8, level, true);
    },
    leastSide: (data, at, value) => data.setFloat32(at + 12, number("leastSide", value), true),
    proximity: (data, at, value) => data.setFloat32(at + 16, number("proximity", value), true),
    sizeClasses: (data, at, value) => data.setUint32(at + 20, whole("sizeClasses", value), true),
    resolution: (data, at, value) => {
        if (value === "automatic") return;
        if (Array.isArray(value?.cells) && value.cells.length === 3) {
            data.setUint32(at + 24, 2, true);
            value.cells.forEach((cells, axis) =>
                data.setUint32(at + 32 + 4 * axis, whole("resolution.cells", cells), true),
            );
        } else if (value?.cellsPerTriangle !== undefined) {
            data.setUint32(at + 24, 1, true);
            data.setFloat32(at + 28, number("resolution.cellsPerTriangle", value.cellsPerTriangle), true);
        } else {
            throw invalid('resolution must be "automatic", { cells: [x, y, z] } or { cellsPerTriangle }');
        }
    },
    bvhBuild: (data, at, value) => {
        const method = ["binned", "insertion"].indexOf(value);
        if (method < 0) throw invalid(`bvhBuild must be "binned" or "insertion", and is ${value}`);
        data.setUint32(at + 44, method, true);
    },
    cost: (data, at, value) => {
        data.setFloat64(at + 48, number("cost.traversal", value?.traversal), true);
        data.setFloat64(at + 56, number("cost.intersection", value?.intersection), true);
    },
    workLimit: (data, at, value) => {
        data.setBigUint64(at + 64, BigInt(whole("workLimit", value, Number.MAX_SAFE_INTEGER)), true);
    },
    beside: (data, at, value) => data.setUint32(at + 72, value ? 1 : 0, true),
    // Part of the mesh.
    objects: () => {},
};

/** Writes options over the defaults that lie at an address. */
export const writeOptions = (heap, at, options) => {
    for (const [name, value] of Object.entries(options)) {
        const write = Object.hasOwn(OPTIONS, name) ? OPTIONS[name] : null;
        if (!write) throw invalid(`there is no option ${name}; there are ${Object.keys(OPTIONS).join(", ")}`);
        if (value !== undefined) write(heap.views.data, at, value);
    }
};

/** Checks the arrays of a mesh, and says how long they are. */
export const measureMesh = (positions, corners, objects) => {
    if (!(positions instanceof Float32Array)) throw invalid("positions must be a Float32Array");
    const indexed = corners !== undefined && corners !== null;
    if (indexed && !(corners instanceof Uint32Array || corners instanceof Uint16Array)) {
        throw invalid("corners must be a Uint32Array or a Uint16Array");
    }
    const [array, length, of] = indexed
        ? ["corners", corners.length, 3]
        : ["positions without corners", positions.length, 9];
    if (length % of !== 0) throw invalid(`${array} must have ${of} numbers for each triangle, and has ${length}`);
    if (positions.length % 3 !== 0) {
        throw invalid(`positions must have 3 numbers for each vertex, and has ${positions.length}`);
    }
    const triangleCount = length / of;
    if (objects !== undefined && !(objects instanceof Uint32Array && objects.length === triangleCount)) {
        throw invalid(`objects must be a Uint32Array with a number for each of the ${triangleCount} triangles`);
    }
    return { indexed, triangleCount, vertexCount: positions.length / 3 };
};

/** Copies a mesh into memory, and writes the struct. Returns the blocks that it takes. */
export const writeMesh = (heap, at, positions, corners, objects) => {
    const { indexed, triangleCount, vertexCount } = measureMesh(positions, corners, objects);
    const blocks = [];
    const copy = (values, view) => {
        if (!values || values.length === 0) return 0;
        const block = heap.take(4 * values.length);
        blocks.push(block);
        heap.views[view].set(values, block / 4);
        return block;
    };
    try {
        const [vertices, triangles] = [copy(positions, "f32"), copy(indexed ? corners : null, "u32")];
        const words = indexed
            ? [0, vertices, triangles, copy(objects, "u32"), triangleCount, vertexCount]
            : [vertices, 0, 0, copy(objects, "u32"), triangleCount, 0];
        heap.views.u32.set(words, at / 4);
    } catch (error) {
        for (const block of blocks) heap.give(block);
        throw error;
    }
    return blocks;
};

/** Writes a ray from its parts. */
export const writeRay = (heap, at, origin, direction, tMin, tMax) => {
    if (origin?.length !== 3 || direction?.length !== 3) {
        throw invalid("origin and direction must have three numbers each");
    }
    const { f32 } = heap.views;
    const first = at / 4;
    for (let axis = 0; axis < 3; axis += 1) {
        f32[first + axis] = number("origin", origin[axis]);
        f32[first + 3 + axis] = number("direction", direction[axis]);
    }
    f32[first + 6] = number("tMin", tMin);
    f32[first + 7] = number("tMax", tMax);
};

/** Reads a hit; `null` if nothing is hit. */
export const readHit = (heap, at) => {
    const { u32, f32 } = heap.views;
    const first = at / 4;
    if (u32[first] === NONE) return null;
    return { triangle: u32[first], t: f32[first + 1], u: f32[first + 2], v: f32[first + 3] };
};
