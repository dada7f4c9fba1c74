// Exact ray queries on triangles, in WebAssembly. `arboleda.d.ts` says what each function takes and gives.
//
//     load -> Arboleda -- build, open --> Index -- closestHits, occludedEach, ... --> typed arrays
//
// The C interface answers; this module owns the memory, copies typed arrays in and out, and turns statuses into errors.

import { ArboledaError, invalid } from "./errors.js";
import { Index } from "./index.js";
import { SIZE, check, measureMesh, textAt, writeMesh, writeOptions } from "./layout.js";
import { Heap } from "./memory.js";
import { hasSimd128, instantiate } from "./module.js";
import { Pace } from "./steps.js";

export { ArboledaError, Index, hasSimd128 };

/** `ARB_ABI_VERSION` of the header that this module was written for. */
const ABI_VERSION = 65537;
/** Bytes that are enough for most indices. If they are not, the build says how many are, and runs again. */
const likelyBytes = (triangleCount) => 80 * triangleCount + 65536;

/** The bytes that are enough for an index, of a build that failed with `given` bytes. Another error is thrown on. */
const enoughBytes = (error, given) => {
    if (error?.code !== "INDEX_MEMORY_TOO_SMALL" || error.neededBytes <= given) throw error;
    return error.neededBytes;
};

/** Loads the module, with simd128 where the machine has it. */
export const load = async (options) => instantiate(options ?? {}, (exports, memory) => new Arboleda(exports, memory));

/** A module with its memory. */
class Arboleda {
    #exports;
    #heap;
    /** Addresses of room for each struct. All calls share it: none begins before the one before has ended. */
    #room = {};

    constructor(exports, memory) {
        this.#exports = exports;
        this.#heap = new Heap(memory, exports.__heap_base.value >>> 0);
        this.memory = memory;
        this.simd = exports.arb_uses_simd128() !== 0;
        if (exports.arb_check_abi(ABI_VERSION) !== 0) {
            throw new ArboledaError(
                "OTHER_ABI",
                `the module has version ${exports.arb_abi_version()} of the interface`,
            );
        }
        const { handle: _, ...parts } = SIZE;
        // Multiples of 16 bytes, which suits every struct.
        const room = (bytes) => Math.ceil(bytes / 16) * 16;
        let next = this.#heap.take(Object.values(parts).reduce((sum, bytes) => sum + room(bytes), 0));
        for (const [part, bytes] of Object.entries(parts)) {
            this.#room[part] = next;
            next += room(bytes);
        }
        const kinds = [];
        for (let name; (name = textAt(this.#heap, exports.arb_kind_name(kinds.length))) !== "unknown";)
            kinds.push(name);
        this.kinds = Object.freeze(kinds);
    }

    /** The number of bytes of the memory that are in use by indices and by work that is under way. */
    get usedBytes() {
        return this.#heap.usedBytes;
    }

    /** Builds an index of a mesh. */
    build(kind, positions, corners, options = {}) {
        const number = this.#number(kind);
        const { triangleCount } = measureMesh(positions, corners, options.objects);
        this.#fill(options);
        // The index first: what is above it is free again after the build, as one block.
        let bytes = likelyBytes(triangleCount);
        for (;;) {
            const block = this.#heap.take(SIZE.handle + bytes);
            try {
                return this.#shrunk(block, this.#buildAt(block, bytes, number, positions, corners, options));
            } catch (error) {
                this.#heap.give(block);
                bytes = enoughBytes(error, bytes);
            }
        }
    }

    /** Builds a wide BVH in slices of time, between which the event loop has its turns. */
    async buildInSteps(kind, positions, corners, options = {}) {
        this.#number(kind);
        if (kind !== "wide-bvh") throw invalid(`only "wide-bvh" is built in steps, and ${kind} is not`);
        const [pace, chosen] = Pace.of(options);
        const { triangleCount } = measureMesh(positions, corners, chosen.objects);
        // The structs are not in the room that all calls share: others are made between the steps.
        const structs = this.#heap.take(SIZE.mesh + SIZE.options);
        const blocks = [structs];
        try {
            this.#fill(chosen, structs + SIZE.mesh);
            blocks.push(...writeMesh(this.#heap, structs, positions, corners, chosen.objects));
            let bytes = likelyBytes(triangleCount);
            for (;;) {
                const block = this.#heap.take(SIZE.handle + bytes);
                try {
                    await this.#stepsAt(block, bytes, structs, triangleCount, pace);
                    return this.#shrunk(block, []);
                } catch (error) {
                    this.#heap.give(block);
                    bytes = enoughBytes(error, bytes);
                }
            }
        } finally {
            for (const block of blocks) this.#heap.give(block);
        }
    }

    /** Opens an index from its bytes, and beside a mesh. */
    open(bytes, positions, corners) {
        const source = bytes instanceof ArrayBuffer ? new Uint8Array(bytes) : bytes;
        if (!(source instanceof Uint8Array)) throw invalid("bytes must be a Uint8Array or an ArrayBuffer");
        const block = this.#heap.take(SIZE.handle + source.length);
        let mesh = [];
        try {
            this.#heap.views.u8.set(source, block + SIZE.handle);
            const { error, mesh: struct } = this.#room;
            if (positions) mesh = writeMesh(this.#heap, struct, positions, corners);
            const given = positions ? struct : 0;
            const { arb_open } = this.#exports;
            // Of no bytes there would be no address: one byte is too few just as well.
            const length = Math.max(source.length, 1);
            check(this.#heap, arb_open(block, block + SIZE.handle, length, given, error), error);
            return this.#opened(block, mesh);
        } catch (error) {
            for (const part of [block, ...mesh]) this.#heap.give(part);
            throw error;
        }
    }

    /** Finds the cluster of each triangle. */
    clusters(positions, corners, options = {}) {
        const { triangleCount } = measureMesh(positions, corners, options.objects);
        this.#fill(options);
        const { mesh, options: chosen, words, error } = this.#room;
        const { arb_clusters, arb_clusters_scratch_bytes } = this.#exports;
        const bytes = arb_clusters_scratch_bytes(triangleCount) >>> 0;
        const blocks = writeMesh(this.#heap, mesh, positions, corners, options.objects);
        try {
            return this.#heap.borrow([bytes, 4 * triangleCount], (scratch, to) => {
                check(this.#heap, arb_clusters(mesh, chosen, scratch, bytes, to, words, error), error);
                const { u32 } = this.#heap.views;
                return { count: u32[words / 4], clusterOf: u32.slice(to / 4, to / 4 + triangleCount) };
            });
        } finally {
            for (const block of blocks) this.#heap.give(block);
        }
    }

    #number(kind) {
        const number = this.kinds.indexOf(kind);
        if (number < 0) {
            throw new ArboledaError(
                "UNKNOWN_KIND",
                `no kind of index is called ${kind}; there are ${this.kinds.join(", ")}`,
            );
        }
        return number;
    }

    /** Writes the options, where all calls have them unless another place is given. */
    #fill(options, at = this.#room.options) {
        this.#exports.arb_options_default(at, SIZE.options);
        writeOptions(this.#heap, at, options);
    }

    /** Builds into a block. Returns the blocks of the mesh, if the index lies beside it. */
    #buildAt(block, bytes, kind, positions, corners, options) {
        const { mesh, options: chosen, words, error } = this.#room;
        const { arb_build, arb_scratch_bytes } = this.#exports;
        const blocks = writeMesh(this.#heap, mesh, positions, corners, options.objects);
        let keeps = false;
        try {
            const count = this.#heap.views.u32[mesh / 4 + 4];
            check(this.#heap, arb_scratch_bytes(kind, count, chosen, words, error), error);
            const needed = this.#heap.views.u32[words / 4];
            this.#heap.borrow([needed], (scratch) => {
                const at = block + SIZE.handle;
                check(this.#heap, arb_build(block, kind, mesh, chosen, at, bytes, scratch, needed, error), error);
            });
            keeps = Boolean(options.beside);
            return keeps ? blocks : [];
        } finally {
            if (!keeps) for (const part of blocks) this.#heap.give(part);
        }
    }

    /** Builds into a block in slices. The memory may grow, and other calls be made, whenever it pauses. */
    async #stepsAt(block, bytes, structs, triangleCount, pace) {
        const { words, error } = this.#room;
        const { arb_sliced_begin, arb_sliced_finish, arb_sliced_scratch_bytes, arb_sliced_step } = this.#exports;
        const scratchBytes = arb_sliced_scratch_bytes(triangleCount) >>> 0;
        const scratch = this.#heap.take(scratchBytes);
        const run = (status) => check(this.#heap, status, error);
        try {
            const room = [block + SIZE.handle, bytes, scratch, scratchBytes];
            run(arb_sliced_begin(words, structs, structs + SIZE.mesh, ...room, error));
            const build = this.#heap.views.u32[words / 4];
            await pace.run(triangleCount, (looks) => {
                run(arb_sliced_step(build, looks, words, error));
                return this.#heap.views.u8[words] === 1;
            });
            run(arb_sliced_finish(build, block, error));
        } finally {
            this.#heap.give(scratch);
        }
    }

    /** The index that was built in a block, whose end it does not need. */
    #shrunk(block, mesh) {
        const index = this.#opened(block, mesh);
        this.#heap.shrink(block, SIZE.handle + index.byteCount);
        return index;
    }

    #opened(block, mesh) {
        return new Index(this.#exports, this.#heap, [block, ...mesh], this.#room, this.kinds);
    }
}
