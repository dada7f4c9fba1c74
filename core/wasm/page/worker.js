// The core, in a worker: reads a scene, builds an index, and answers the page. The page is never blocked.
//
//     page --{ id, call, argument }--> here --{ progress } ..., { id, value } or { id, error }--> page

import { load } from "./js/arboleda.js";
import { coloursOf } from "./colours.js";
import { parse, read } from "./files.js";
import { shoot } from "./photons.js";
import { make } from "./scenes.js";

let arboleda;
let positions;
let box;
let index;
/** Aborted if the page wants no more rows of a comparison. */
let stopping = new AbortController();

const progress = (stage, detail = "") => postMessage({ progress: { stage, detail } });
const seconds = (since) => (performance.now() - since) / 1000;

/** Runs a stage, and says how long it took. */
const stage = async (times, name, body) => {
    progress(name);
    const since = performance.now();
    const value = await body();
    times.push({ stage: name, seconds: seconds(since) });
    return value;
};

/** Builds an index; the wide BVH in steps, between which messages come in. */
const built = (kind, options) =>
    kind === "wide-bvh" ? arboleda.buildInSteps(kind, positions, null, options) : arboleda.build(kind, positions);

/** Builds the index that the page shows, and says how far it has come. */
const buildShown = (times, kind) => {
    const onProgress = (share) => progress("build", `${Math.floor(100 * share)} %`);
    return stage(times, "build", () => built(kind, { onProgress }));
};

/** The box of all triangles. */
const boxOf = (positions) => {
    const [lo, hi] = [
        [Infinity, Infinity, Infinity],
        [-Infinity, -Infinity, -Infinity],
    ];
    for (let at = 0; at < positions.length; at += 3) {
        for (let axis = 0; axis < 3; axis += 1) {
            const x = positions[at + axis];
            if (x < lo[axis]) lo[axis] = x;
            if (x > hi[axis]) hi[axis] = x;
        }
    }
    return [lo, hi];
};

/** What the page shows of the index. */
const described = () => ({
    kind: index.kind,
    triangleCount: index.triangleCount,
    clusterCount: index.clusterCount,
    byteCount: index.byteCount,
    memoryBytes: arboleda.memory.buffer.byteLength,
    simd: arboleda.simd,
    tree: index.clusterTree(),
});

const CALLS = {
    /** Reads or makes a scene, finds its clusters and builds an index. */
    async open({ scene, file, kind }) {
        const times = [];
        arboleda ??= await load();
        if (file) {
            const megabytes = (bytes) => (bytes / 1e6).toFixed(1);
            const bytes = await stage(times, "read", () =>
                read(file, (done) => progress("read", `${megabytes(done)} of ${megabytes(file.size)} MB`)),
            );
            positions = await stage(times, "parse", () => parse(file.name, bytes));
        } else {
            positions = await stage(times, "make", () => make(scene));
        }
        const count = positions.length / 9;
        progress("clusters", `${count.toLocaleString("en")} triangles`);
        const { clusterOf } = await stage(times, "clusters", () => arboleda.clusters(positions));
        index?.free();
        index = await buildShown(times, kind);
        const drawn = await stage(times, "draw", () => {
            box = boxOf(positions);
            const middle = box[0].map((x, axis) => (x + box[1][axis]) / 2);
            // Drawn around the middle: 32 bits on a graphics card are few, far from 0.
            const around = positions.map((x, at) => x - middle[at % 3]);
            return { middle, positions: around, colours: coloursOf(clusterOf) };
        });
        return { ...described(), kinds: arboleda.kinds, times, box, drawn };
    },

    /** Builds another index of the same scene. */
    async build({ kind }) {
        const times = [];
        index.free();
        index = await buildShown(times, kind);
        return { ...described(), times };
    },

    /** The path of a ray, if the index has one to show; else its hit and counters. */
    ray({ origin, direction }) {
        const counted = index.closestHitCounted(origin, direction);
        const shows = index.kind.startsWith("octree");
        const { steps, tests } = shows ? index.path(origin, direction) : { steps: [], tests: [] };
        const corners = [];
        for (const triangle of tests) corners.push(...positions.subarray(9 * triangle, 9 * triangle + 9));
        const { hit } = counted;
        const hitCorners = hit ? positions.slice(9 * hit.triangle, 9 * hit.triangle + 9) : null;
        return { ...counted, steps, tests: [...tests], corners: new Float32Array(corners), hitCorners };
    },

    cells: ({ level, limit }) => index.cells(level, limit),

    /** The same ray through every kind of index, built one after the other, until the page says stop. */
    async compare({ origin, direction }) {
        const rows = [];
        stopping = new AbortController();
        for (const kind of arboleda.kinds) {
            progress("compare", `${kind}, ${rows.length + 1} of ${arboleda.kinds.length}`);
            // Between two builds, messages come in.
            await new Promise((resolve) => setTimeout(resolve));
            if (stopping.signal.aborted) break;
            const since = performance.now();
            let other;
            try {
                other = await built(kind, { signal: stopping.signal });
            } catch (error) {
                if (stopping.signal.aborted) break;
                throw error;
            }
            const took = seconds(since);
            try {
                rows.push({
                    kind,
                    seconds: took,
                    byteCount: other.byteCount,
                    ...other.closestHitCounted(origin, direction),
                });
            } finally {
                other.free();
            }
        }
        return rows;
    },

    /** Shoots photons; the points of their hits, and their bounces. */
    photons({ count, lamp, seed }) {
        const [points, bounces] = [[], []];
        const since = performance.now();
        const found = (x, y, z, bounce) => {
            points.push(x, y, z);
            bounces.push(bounce);
        };
        const sum = shoot(index, positions, { lamp, box, count, seed }, found, (done, all) =>
            progress("photons", `${done.toLocaleString("en")} of ${all.toLocaleString("en")}`),
        );
        return { sum, seconds: seconds(since), points: new Float32Array(points), bounces: new Uint8Array(bounces) };
    },
};

/** The buffers of large arrays in a value, which are handed over instead of copied. */
const buffersOf = (value, found = new Set()) => {
    if (ArrayBuffer.isView(value)) {
        if (value.buffer.byteLength > 4096) found.add(value.buffer);
    } else if (value && typeof value === "object" && !Array.isArray(value)) {
        for (const part of Object.values(value)) buffersOf(part, found);
    }
    return found;
};

const answer = async ({ id, call, argument }) => {
    try {
        const value = await CALLS[call](argument);
        postMessage({ id, value }, [...buffersOf(value)]);
    } catch (error) {
        // An error of the core names a triangle, and not the file that it is from.
        const name = argument?.file?.name;
        const message = name && !error.message.startsWith(name) ? `${name}: ${error.message}` : error.message;
        postMessage({ id, error: { message, code: error.code ?? null } });
    }
};

/** Calls are answered one after the other, as they come: what a build that pauses replaces is not asked meanwhile. */
let answered = Promise.resolve();
onmessage = ({ data }) => {
    if (data.call === "stop") {
        stopping.abort();
        postMessage({ id: data.id, value: null });
    } else {
        answered = answered.then(() => answer(data));
    }
};
