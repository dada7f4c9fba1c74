// The memory, and what lies where in it.
//
//     | stack | constants | blocks, each a multiple of 64 bytes: mesh, scratch, indices, rays, hits ... |
//                         ^ __heap_base                                                  end of memory ^
//
// The module takes no memory itself. Blocks are handed out by first fit; neighbours that are free are joined.

import { ArboledaError } from "./errors.js";

/** `ARB_ALIGNMENT`: of an index and of the scratch of a build. */
const ALIGNMENT = 64;
const PAGE = 65536;

const aligned = (bytes) => Math.ceil(bytes / ALIGNMENT) * ALIGNMENT;

export class Heap {
    #memory;
    /** Free blocks `[first, end]`, by address. */
    #free = [];
    /** Used blocks: the length of each by its address. */
    #used = new Map();
    #views = null;

    constructor(memory, base) {
        this.#memory = memory;
        const end = memory.buffer.byteLength;
        const first = aligned(base);
        if (first < end) this.#free.push([first, end]);
    }

    /** The number of bytes that are in use. */
    get usedBytes() {
        let sum = 0;
        for (const bytes of this.#used.values()) sum += bytes;
        return sum;
    }

    /** Typed arrays over the whole memory. Growing the memory detaches them, so they are asked for at each use. */
    get views() {
        const { buffer } = this.#memory;
        if (this.#views?.u8.buffer !== buffer) {
            this.#views = {
                u8: new Uint8Array(buffer),
                u32: new Uint32Array(buffer),
                f32: new Float32Array(buffer),
                data: new DataView(buffer),
            };
        }
        return this.#views;
    }

    /** Takes a block of at least one byte, and grows the memory if there is none. */
    take(bytes) {
        const length = aligned(Math.max(bytes, 1));
        let at = this.#free.findIndex(([first, end]) => end - first >= length);
        if (at < 0) {
            this.#grow(length);
            at = this.#free.length - 1;
        }
        const block = this.#free[at];
        const [first] = block;
        block[0] += length;
        if (block[0] === block[1]) this.#free.splice(at, 1);
        this.#used.set(first, length);
        return first;
    }

    /** Gives a block back. */
    give(first) {
        const length = this.#used.get(first);
        if (length === undefined) throw new ArboledaError("NOT_OPEN", `no block begins at ${first}`);
        this.#used.delete(first);
        this.#release(first, first + length);
    }

    /** Gives back what of a block is beyond `bytes`. */
    shrink(first, bytes) {
        const length = this.#used.get(first);
        const kept = aligned(Math.max(bytes, 1));
        if (kept >= length) return;
        this.#used.set(first, kept);
        this.#release(first + kept, first + length);
    }

    /** Runs `body` with blocks of these lengths, and gives them back whatever happens. */
    borrow(lengths, body) {
        const blocks = [];
        try {
            for (const bytes of lengths) blocks.push(this.take(bytes));
            return body(...blocks);
        } finally {
            for (const block of blocks) this.give(block);
        }
    }

    #release(first, end) {
        let at = this.#free.findIndex((block) => block[0] > first);
        if (at < 0) at = this.#free.length;
        const before = this.#free[at - 1];
        const after = this.#free[at];
        const joinsBefore = before?.[1] === first;
        const joinsAfter = after?.[0] === end;
        if (joinsBefore && joinsAfter) {
            before[1] = after[1];
            this.#free.splice(at, 1);
        } else if (joinsBefore) {
            before[1] = end;
        } else if (joinsAfter) {
            after[0] = first;
        } else {
            this.#free.splice(at, 0, [first, end]);
        }
    }

    /** Grows the memory until its last block has `length` bytes. */
    #grow(length) {
        const end = this.#memory.buffer.byteLength;
        const last = this.#free.at(-1);
        const have = last?.[1] === end ? end - last[0] : 0;
        const needed = Math.ceil((length - have) / PAGE);
        // An eighth more, so that many small blocks do not grow it as many times; exactly, if there is not as much.
        const ample = Math.max(needed, Math.ceil(end / PAGE / 8));
        for (const pages of [ample, needed]) {
            try {
                this.#memory.grow(pages);
                this.#release(end, this.#memory.buffer.byteLength);
                return;
            } catch (error) {
                if (!(error instanceof RangeError)) throw error;
            }
        }
        throw new ArboledaError(
            "OUT_OF_MEMORY",
            `the memory has ${end} bytes and cannot grow by the ${needed * PAGE} that are needed`,
        );
    }
}
