// Scene files to triangles, by the loaders of three.js.

import { OBJLoader } from "./three/OBJLoader.js";
import { PLYLoader } from "./three/PLYLoader.js";
import { STLLoader } from "./three/STLLoader.js";

/** Geometries of a file, by the end of its name. */
const FORMATS = {
    obj: (bytes) => {
        const geometries = [];
        new OBJLoader().parse(new TextDecoder().decode(bytes)).traverse((part) => {
            if (part.isMesh) geometries.push(part.geometry);
        });
        return geometries;
    },
    ply: (bytes) => [new PLYLoader().parse(bytes)],
    stl: (bytes) => [new STLLoader().parse(bytes)],
};

/** The format of a file; an error if it has none that can be read. */
export const formatOf = (name) => {
    const format = name.split(".").at(-1).toLowerCase();
    if (!Object.hasOwn(FORMATS, format)) throw new Error(`${name}: only OBJ, PLY and STL files can be read`);
    return format;
};

/** Reads a file, and says how many of its bytes are read. */
export const read = async (file, progress) => {
    const bytes = new Uint8Array(file.size);
    let done = 0;
    const reader = file.stream().getReader();
    for (;;) {
        const { done: isDone, value } = await reader.read();
        if (isDone) return bytes.buffer;
        bytes.set(value, done);
        done += value.length;
        progress(done);
    }
};

/** The triangles of a file, nine numbers each. */
export const parse = (name, bytes) => {
    let geometries;
    try {
        geometries = FORMATS[formatOf(name)](bytes);
    } catch (error) {
        throw new Error(`${name} could not be read: ${error.message}`);
    }
    const arrays = geometries.map(({ index, attributes: { position } }) => {
        if (!position) return new Float32Array(0);
        // A PLY file without faces is a cloud of points.
        if (!index) return /\.ply$/i.test(name) ? new Float32Array(0) : floats(position);
        const positions = new Float32Array(3 * index.count);
        for (let corner = 0; corner < index.count; corner += 1) {
            const vertex = index.getX(corner);
            positions[3 * corner] = position.getX(vertex);
            positions[3 * corner + 1] = position.getY(vertex);
            positions[3 * corner + 2] = position.getZ(vertex);
        }
        return positions;
    });
    const length = arrays.reduce((sum, array) => sum + array.length, 0);
    if (length === 0) throw new Error(`${name} has no triangles`);
    const all = new Float32Array(length);
    let first = 0;
    for (const array of arrays) {
        all.set(array, first);
        first += array.length;
    }
    return all;
};

const floats = (position) =>
    position.array instanceof Float32Array ? position.array : Float32Array.from(position.array);
