// An index that answers queries.

import { ArboledaError, codeOf, invalid } from "./errors.js";
import { SIZE, check, readHit, textAt, whole, writeRay } from "./layout.js";

/** Rays of a batch that are in the memory at once: 6 MiB of rays and hits. */
const BATCH = 131072;
/** Hits that are asked for at first. */
const FIRST_HITS = 64;
/** Words of the records of `arboleda-wasm`. */
const NODE_WORDS = 9;
const CELL_WORDS = 9;
const STEP_WORDS = 11;
const STEPS = ["join", "cluster", "inner", "leaf"];

export class Index {
    #exports;
    #heap;
    /** The block of the handle and the index, then those of the mesh beside it; none after `free`. */
    #blocks;
    /** The module's room for structs. */
    #room;

    constructor(exports, heap, blocks, room, kinds) {
        this.#exports = exports;
        this.#heap = heap;
        this.#blocks = blocks;
        this.#room = room;
        const { description } = room;
        exports.arb_describe(blocks[0], description);
        const [, byteCount, kind, triangleCount, clusterCount, beside] = heap.views.u32.subarray(description / 4);
        const facts = { kind: kinds[kind], byteCount, triangleCount, clusterCount, beside: beside === 1 };
        // Not writable: queries take their room from them.
        for (const [name, value] of Object.entries(facts))
            Object.defineProperty(this, name, { value, enumerable: true });
    }

    get isFree() {
        return this.#blocks.length === 0;
    }

    closestHit(origin, direction, tMin = 0, tMax = Infinity) {
        const { ray, hit } = this.#given(origin, direction, tMin, tMax);
        this.#checkRay(this.#exports.arb_closest(this.#handle, ray, hit));
        return readHit(this.#heap, hit);
    }

    occluded(origin, direction, tMin = 0, tMax = Infinity) {
        const { ray, hit } = this.#given(origin, direction, tMin, tMax);
        this.#checkRay(this.#exports.arb_occluded(this.#handle, ray, hit));
        return this.#heap.views.u8[hit] === 1;
    }

    closestHitCounted(origin, direction, tMin = 0, tMax = Infinity) {
        const { ray, hit, counters } = this.#given(origin, direction, tMin, tMax);
        this.#heap.views.u8.fill(0, counters, counters + SIZE.counters);
        this.#checkRay(this.#exports.arb_closest_counted(this.#handle, ray, hit, counters));
        return { hit: readHit(this.#heap, hit), ...this.#counted(counters) };
    }

    occludedCounted(origin, direction, tMin = 0, tMax = Infinity) {
        const { ray, hit, counters } = this.#given(origin, direction, tMin, tMax);
        this.#heap.views.u8.fill(0, counters, counters + SIZE.counters);
        this.#checkRay(this.#exports.arb_occluded_counted(this.#handle, ray, hit, counters));
        return { occluded: this.#heap.views.u8[hit] === 1, ...this.#counted(counters) };
    }

    allHits(origin, direction, tMin = 0, tMax = Infinity) {
        const { ray, words } = this.#given(origin, direction, tMin, tMax);
        const { arb_all_hits } = this.#exports;
        for (let room = FIRST_HITS; ; room *= 4) {
            const found = this.#heap.borrow([room * SIZE.hit], (hits) => {
                this.#checkRay(arb_all_hits(this.#handle, ray, hits, room, words, words + 4));
                if (this.#heap.views.u8[words + 4] === 1) return null;
                const count = this.#heap.views.u32[words / 4];
                return Array.from({ length: count }, (_, at) => readHit(this.#heap, hits + at * SIZE.hit));
            });
            if (found) return found;
        }
    }

    closestHits(rays) {
        const count = this.#countOf(rays);
        const triangles = new Uint32Array(count);
        const [t, u, v] = [new Float32Array(count), new Float32Array(count), new Float32Array(count)];
        this.#each("arb_closest_each", rays, SIZE.hit, ({ u32, f32 }, hits, first, length) => {
            for (let ray = 0, from = hits / 4; ray < length; ray += 1, from += 4) {
                const to = first + ray;
                triangles[to] = u32[from];
                t[to] = f32[from + 1];
                u[to] = f32[from + 2];
                v[to] = f32[from + 3];
            }
        });
        return { count, triangles, t, u, v };
    }

    occludedEach(rays) {
        const occluded = new Uint8Array(this.#countOf(rays));
        this.#each("arb_occluded_each", rays, 1, ({ u8 }, answers, first, length) => {
            occluded.set(u8.subarray(answers, answers + length), first);
        });
        return occluded;
    }

    clusterTree() {
        const { count, u32, f32 } = this.#records(NODE_WORDS, 2 * this.clusterCount, (to, room, total, error) =>
            this.#exports.arb_cluster_tree(this.#handle, to, room, total, error),
        );
        const [bounds, parents] = [new Float32Array(6 * count), new Int32Array(count)];
        const children = new Int32Array(2 * count);
        for (let node = 0, at = 0; node < count; node += 1, at += NODE_WORDS) {
            bounds.set(f32.subarray(at, at + 6), 6 * node);
            // What is not there becomes -1.
            parents[node] = u32[at + 6];
            children.set(u32.subarray(at + 7, at + 9), 2 * node);
        }
        return { count, bounds, parents, children };
    }

    cells(level, limit = Infinity) {
        whole("level", level);
        if (limit !== Infinity) whole("limit", limit);
        const ask = (to, room, total, error) =>
            this.#exports.arb_octree_cells(this.#handle, level, to, room, total, error);
        const { total } = this.#records(CELL_WORDS, 0, ask);
        const { count, u32, f32 } = this.#records(CELL_WORDS, Math.min(total, limit), ask);
        const bounds = new Float32Array(6 * count);
        const [clusters, levels, triangles] = [new Uint32Array(count), new Uint32Array(count), new Int32Array(count)];
        for (let cell = 0, at = 0; cell < count; cell += 1, at += CELL_WORDS) {
            bounds.set(f32.subarray(at, at + 6), 6 * cell);
            clusters[cell] = u32[at + 6];
            levels[cell] = u32[at + 7];
            triangles[cell] = u32[at + 8];
        }
        return { count, total, bounds, clusters, levels, triangles };
    }

    path(origin, direction, tMin = 0, tMax = Infinity) {
        // The counters say how much room the path takes.
        const { nodesVisited, triangleTests } = this.closestHitCounted(origin, direction, tMin, tMax);
        const { ray, hit, words, error } = this.#given(origin, direction, tMin, tMax);
        const lengths = [4 * STEP_WORDS * nodesVisited, 4 * triangleTests];
        return this.#heap.borrow(lengths, (steps, tests) => {
            const { arb_path } = this.#exports;
            const rooms = [steps, nodesVisited, tests, triangleTests];
            check(this.#heap, arb_path(this.#handle, ray, ...rooms, words, hit, error), error);
            const { u32, f32 } = this.#heap.views;
            const [stepCount, testCount] = u32.subarray(words / 4);
            const step = (number) => {
                const at = steps / 4 + number * STEP_WORDS;
                const [what, id, level, firstTest, count] = u32.subarray(at);
                return {
                    what: STEPS[what],
                    id,
                    level,
                    firstTest,
                    testCount: count,
                    bounds: f32.slice(at + 5, at + 11),
                };
            };
            return {
                hit: readHit(this.#heap, hit),
                steps: Array.from({ length: stepCount }, (_, number) => step(number)),
                tests: u32.slice(tests / 4, tests / 4 + testCount),
            };
        });
    }

    save() {
        const first = this.#handle + SIZE.handle;
        return this.#heap.views.u8.slice(first, first + this.byteCount);
    }

    free() {
        for (const block of this.#blocks) this.#heap.give(block);
        this.#blocks = [];
    }

    get #handle() {
        if (this.isFree) throw new ArboledaError("NOT_OPEN", "the index was freed");
        return this.#blocks[0];
    }

    /** Writes a ray; the places of it and of what is answered. */
    #given(origin, direction, tMin, tMax) {
        if (this.isFree) throw new ArboledaError("NOT_OPEN", "the index was freed");
        writeRay(this.#heap, this.#room.ray, origin, direction, tMin, tMax);
        return this.#room;
    }

    #checkRay(status) {
        if (status === 0) return;
        throw new ArboledaError(codeOf(status), textAt(this.#heap, this.#exports.arb_status_text(status)), 0);
    }

    #counted(counters) {
        const { data } = this.#heap.views;
        return {
            nodesVisited: Number(data.getBigUint64(counters, true)),
            triangleTests: Number(data.getBigUint64(counters + 8, true)),
        };
    }

    #countOf(rays) {
        if (!(rays instanceof Float32Array)) throw invalid("rays must be a Float32Array");
        if (rays.length % 8 !== 0) throw invalid(`rays must have 8 numbers for each ray, and has ${rays.length}`);
        return rays.length / 8;
    }

    /** Answers a batch, some rays at a time. `take` reads the answers. */
    #each(query, rays, answerBytes, take) {
        const count = rays.length / 8;
        const most = Math.min(count, BATCH);
        const { error } = this.#room;
        const handle = this.#handle;
        const scratchBytes = this.#exports.arb_batch_scratch_bytes() >>> 0;
        this.#heap.borrow([most * SIZE.ray, most * answerBytes, scratchBytes], (from, to, scratch) => {
            for (let first = 0; first < count; first += most) {
                const length = Math.min(most, count - first);
                this.#heap.views.f32.set(rays.subarray(8 * first, 8 * (first + length)), from / 4);
                const status = this.#exports[query](handle, from, length, to, scratch, scratchBytes, error);
                try {
                    check(this.#heap, status, error);
                } catch (thrown) {
                    // The element and the text count from the first ray of this part.
                    if (thrown.code.startsWith("RAY_")) {
                        thrown.message = thrown.message.replace(/^ray \d+/, `ray ${first + thrown.element}`);
                        thrown.element += first;
                    }
                    throw thrown;
                }
                take(this.#heap.views, to, first, length);
            }
        });
    }

    /** Reads at most `room` records. `total` is the number of them that there are. */
    #records(words, room, ask) {
        const { words: total, error } = this.#room;
        return this.#heap.borrow([4 * words * room], (to) => {
            check(this.#heap, ask(to, room, total, error), error);
            const { u32, f32 } = this.#heap.views;
            const found = u32[total / 4];
            const count = Math.min(found, room);
            const [first, end] = [to / 4, to / 4 + words * count];
            return { total: found, count, u32: u32.slice(first, end), f32: f32.slice(first, end) };
        });
    }
}
