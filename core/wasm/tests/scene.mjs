// The scene of the digests, as `tests/native/scene.rs` makes it, and digests.

/** x -> 1664525 x + 1013904223 modulo 2^32 (Numerical Recipes). */
class Numbers {
    constructor(state) {
        this.state = state;
    }

    /** A number in -1 to 1. */
    signed() {
        this.state = (Math.imul(this.state, 1664525) + 1013904223) >>> 0;
        return ((this.state >>> 8) - 8388608) / 8388608;
    }

    point(scale) {
        return [0, 0, 0].map(() => Math.fround(this.signed() * scale));
    }
}

const sum = (a, b) => a.map((x, axis) => Math.fround(x + b[axis]));

/** Positions of 1,202 triangles, nine numbers each. */
export const positions = () => {
    const numbers = new Numbers(1);
    const all = [];
    for (let group = 0; group < 6; group += 1) {
        const middle = numbers.point(64);
        for (let triangle = 0; triangle < 200; triangle += 1) {
            const a = sum(middle, numbers.point(4));
            all.push(...a, ...sum(a, numbers.point(1)), ...sum(a, numbers.point(1)));
        }
    }
    const at = (x, z) => [x, -70, z];
    all.push(...at(-80, -80), ...at(80, -80), ...at(80, 80), ...at(-80, -80), ...at(80, 80), ...at(-80, 80));
    return new Float32Array(all);
};

/** Rays, eight numbers each. */
export const rays = (count) => {
    const numbers = new Numbers(7);
    const all = [];
    for (let ray = 0; ray < count; ray += 1) {
        const [from, to] = [numbers.point(128), numbers.point(64)];
        all.push(...from, ...to.map((x, axis) => Math.fround(x - from[axis])), 0, Infinity);
    }
    return new Float32Array(all);
};

/** FNV-1a of 32 bits. */
export const digest = (bytes) => {
    let sum = 0x811c9dc5;
    for (const byte of bytes) sum = Math.imul(sum ^ byte, 0x01000193);
    return (sum >>> 0).toString(16).padStart(8, "0");
};

/** The lines of `digests.txt`, for all kinds of a module. */
export const digests = (arboleda) => {
    const [mesh, batch] = [positions(), rays(2000)];
    return arboleda.kinds.map((kind) => {
        const index = arboleda.build(kind, mesh);
        const { count, triangles, t, u, v } = index.closestHits(batch);
        const hits = new Uint32Array(4 * count);
        const floats = new Float32Array(hits.buffer);
        let [nodes, tests] = [0, 0];
        for (let ray = 0; ray < count; ray += 1) {
            hits[4 * ray] = triangles[ray];
            floats.set([t[ray], u[ray], v[ray]], 4 * ray + 1);
            const at = 8 * ray;
            const counted = index.closestHitCounted(batch.subarray(at, at + 3), batch.subarray(at + 3, at + 6));
            nodes += counted.nodesVisited;
            tests += counted.triangleTests;
        }
        const bytes = index.save();
        index.free();
        return `${kind} ${bytes.length} ${digest(bytes)} ${digest(new Uint8Array(hits.buffer))} ${nodes} ${tests}`;
    });
};
