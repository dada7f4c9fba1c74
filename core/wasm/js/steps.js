// Builds in slices of time: what a caller may say about them, and the turns of the event loop between them.
//
//     step, step, ... step | turn | step, step, ... step | turn | ...      as many steps as a turn has milliseconds

import { invalid } from "./errors.js";
import { whole } from "./layout.js";

/** Looks at triangles between two looks at the clock: 0.02 to 0.1 ms. */
const LOOKS_PER_STEP = 4000;
/** Half of what a page has for a picture, at 60 a second. */
const MILLISECONDS_PER_TURN = 8;

/** Lets the event loop have its turn: input, messages, timers, pictures. */
const turn = () =>
    new Promise((resolve) => {
        // Node.js has this. A timer instead would wait 4 ms in a browser, and a second in a tab that is not seen.
        if (typeof setImmediate === "function") return setImmediate(resolve);
        const { port1, port2 } = new MessageChannel();
        port1.onmessage = () => {
            port1.close();
            resolve();
        };
        port2.postMessage(null);
    });

/**
 * About how many looks a build takes, in steps of `LOOKS_PER_STEP`. Measured: 31.3 a triangle for 31,736 triangles, 37.5
 * for 144,872, 44.6 for 1,000,188; so 2.7 for each level of a binary tree, but for the lowest, which are not divided.
 */
const expectedLooks = (triangleCount) => triangleCount * Math.max(2.7 * Math.log2(triangleCount) - 9, 10);

/** How a build is divided into steps, and who is told. */
export class Pace {
    #looksPerStep;
    #millisecondsPerTurn;
    #onProgress;
    #signal;
    /** When the build was asked for: what comes before its first step belongs to its first turn. */
    #begun = performance.now();
    /** The share that was told last. It never falls, also if a build has to begin again. */
    #told = 0;

    /** Takes what is about the steps out of the options of a build. Returns it, and the other options. */
    static of({ looksPerStep, millisecondsPerTurn, onProgress, signal, ...options }) {
        return [new Pace(looksPerStep, millisecondsPerTurn, onProgress, signal), options];
    }

    constructor(looksPerStep = LOOKS_PER_STEP, millisecondsPerTurn = MILLISECONDS_PER_TURN, onProgress, signal) {
        if (whole("looksPerStep", looksPerStep) === 0) throw invalid("looksPerStep must be 1 or more, and is 0");
        if (typeof millisecondsPerTurn !== "number" || !(millisecondsPerTurn >= 0)) {
            throw invalid(`millisecondsPerTurn must be a number from 0, and is ${String(millisecondsPerTurn)}`);
        }
        if (onProgress && typeof onProgress !== "function") throw invalid("onProgress must be a function");
        if (signal && typeof signal.throwIfAborted !== "function") throw invalid("signal must be an AbortSignal");
        this.#looksPerStep = looksPerStep;
        this.#millisecondsPerTurn = millisecondsPerTurn;
        this.#onProgress = onProgress;
        this.#signal = signal;
    }

    /** Calls `step` with a number of looks until it returns true, with turns of the event loop between the calls. */
    async run(triangleCount, step) {
        const expected = expectedLooks(triangleCount);
        let looks = 0;
        for (let from = this.#begun; ; from = performance.now()) {
            this.#signal?.throwIfAborted();
            const end = from + this.#millisecondsPerTurn;
            do {
                if (step(this.#looksPerStep)) {
                    this.#onProgress?.(1);
                    return;
                }
                looks += this.#looksPerStep;
            } while (performance.now() < end);
            // 1 is said at the end, and only there.
            this.#told = Math.max(this.#told, Math.min(looks / expected, 0.99));
            this.#onProgress?.(this.#told);
            await turn();
        }
    }
}
