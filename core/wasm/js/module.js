// The module: which file, whether this machine runs it, and the memory that it is given.

import { ArboledaError, invalid } from "./errors.js";

/** Bytes of a page of a memory, and the fewest pages: the stack, the constants and some room. */
const PAGE = 65536;
const LEAST_PAGES = 32;
/** Pages of a memory that is made here: 4 MiB. */
const FIRST_PAGES = 64;

/** A function that uses instructions of simd128: (func (result v128) i32.const 0 i8x16.splat i8x16.popcnt). */
const SIMD128 = new Uint8Array([
    0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

/** What a module exports if it is one of this package. The version of the interface is checked later. */
const EXPORTS = ["__heap_base", "arb_abi_version", "arb_check_abi", "arb_uses_simd128"];

/** Memories that a module has. Two modules in one memory would write over each other's blocks. */
const taken = new WeakSet();

/** Tells whether this machine runs the module with simd128. */
export const hasSimd128 = () => WebAssembly.validate(SIMD128);

/** Runs `body`; what it throws becomes an error of the package. */
const orNotLoaded = async (what, body) => {
    try {
        return await body();
    } catch (cause) {
        const thrown = new ArboledaError("NOT_LOADED", `${what}: ${cause?.message ?? cause}`);
        thrown.cause = cause;
        throw thrown;
    }
};

/** The bytes at a URL: in Node.js of a file, else by `fetch`. */
const bytesAt = async (wasm) => {
    if (typeof (wasm?.href ?? wasm) !== "string") {
        throw invalid("wasm must be a URL, a string, bytes or a WebAssembly.Module");
    }
    const url = await orNotLoaded(`${wasm} is not a URL`, () => new URL(wasm, import.meta.url));
    if (url.protocol === "file:" && globalThis.process?.versions?.node) {
        const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ "node:fs/promises");
        return orNotLoaded(`${url} could not be read`, () => readFile(url));
    }
    const response = await orNotLoaded(`${url} could not be fetched`, () => fetch(url));
    if (!response.ok) throw new ArboledaError("NOT_LOADED", `${url} answers ${response.status}`);
    return orNotLoaded(`${url} could not be fetched`, () => response.arrayBuffer());
};

/** The compiled module: the caller's, or the one of the package with or without simd128. */
const compiled = async (wasm, simd) => {
    if (wasm instanceof WebAssembly.Module) return wasm;
    let from = wasm;
    if (wasm === undefined || wasm === null) {
        if (simd && !hasSimd128()) throw new ArboledaError("NOT_LOADED", "this machine does not run simd128");
        from = simd
            ? new URL("../wasm/arboleda-simd128.wasm", import.meta.url)
            : new URL("../wasm/arboleda.wasm", import.meta.url);
    }
    const bytes = from instanceof ArrayBuffer || ArrayBuffer.isView(from) ? from : await bytesAt(from);
    return orNotLoaded("the module does not compile", () => WebAssembly.compile(bytes));
};

/** What kind of object a value is, also if it comes from another window. */
const kindOf = (value) => Object.prototype.toString.call(value).slice(8, -1);

const checkMemory = (memory) => {
    if (kindOf(memory) !== "WebAssembly.Memory") throw invalid("memory must be a WebAssembly.Memory");
    if (kindOf(memory.buffer) !== "ArrayBuffer") {
        throw invalid("memory must not be shared: a module is used by one thread");
    }
    const { byteLength } = memory.buffer;
    if (byteLength < LEAST_PAGES * PAGE) {
        throw invalid(`memory must have ${LEAST_PAGES} pages or more, and has ${byteLength / PAGE}`);
    }
    if (taken.has(memory)) throw invalid("memory has a module already: give each module its own; it uses all of it");
};

const newMemory = () => {
    try {
        return new WebAssembly.Memory({ initial: FIRST_PAGES });
    } catch (error) {
        throw new ArboledaError("OUT_OF_MEMORY", `there is no room for ${FIRST_PAGES} pages: ${error.message}`);
    }
};

/** Makes an instance of the module. Returns what `use` makes of its exports and its memory. */
export const instantiate = async ({ simd = hasSimd128(), memory, wasm }, use) => {
    const ours = memory ?? newMemory();
    checkMemory(ours);
    // Before anything is awaited, so that of two calls at the same time one is refused.
    taken.add(ours);
    try {
        const module = await compiled(wasm, simd);
        const imports = { env: { memory: ours } };
        const { exports } = await orNotLoaded("the module does not start", () =>
            WebAssembly.instantiate(module, imports),
        );
        const missing = EXPORTS.filter((name) => !(name in exports));
        if (missing.length > 0) {
            throw new ArboledaError("NOT_LOADED", `the module is not of this package: it has no ${missing.join(", ")}`);
        }
        return use(exports, ours);
    } catch (error) {
        taken.delete(ours);
        throw error;
    }
};
