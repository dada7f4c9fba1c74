/**
 * Exact ray queries on triangles, in WebAssembly: the same hits, bit for bit, on every machine and for every kind of
 * index.
 *
 * Triangles are numbered from 0 in the order in which they are given. Both sides of a triangle are hit. Every function
 * may throw an {@link ArboledaError}.
 *
 * These types need TypeScript 5.7 or later, for `Uint8Array<ArrayBuffer>`.
 */

/** Kind of an index. All give the same answers; they differ in time and memory. `"wide-bvh"` is the fastest. */
export type Kind =
    | "linear"
    | "octree"
    | "octree-hierarchy"
    | "octree-r"
    | "octree-r-hierarchy"
    | "uniform-grid"
    | "grid-hierarchy"
    | "kd-tree"
    | "kd-tree-hierarchy"
    | "bsp-tree"
    | "bsp-tree-hierarchy"
    | "bvh"
    | "bvh-hierarchy"
    | "wide-bvh"
    | "wide-bvh-hierarchy"
    | "compact-bvh"
    | "compact-bvh-hierarchy"
    | "lean-bvh"
    | "lean-bvh-hierarchy";

/** Code of an {@link ArboledaError}: a status of the C interface, or one of the first four. */
export type Code =
    /** An argument that the function does not take; the message names it. */
    | "INVALID_ARGUMENT"
    /** The memory cannot grow by what is needed. */
    | "OUT_OF_MEMORY"
    /** The module could not be read, fetched, compiled or started, or is not one of this package. */
    | "NOT_LOADED"
    /** The index was freed. */
    | "NOT_OPEN"
    | "NULL_POINTER"
    | "MISALIGNED_POINTER"
    | "LENGTH_OVERFLOW"
    | "OVERLAP"
    | "OTHER_ABI"
    | "UNKNOWN_KIND"
    | "KIND_LEFT_OUT"
    | "INVALID_OPTION"
    | "TWO_MESHES"
    | "NOT_BEGUN"
    | "INDEX_MEMORY_TOO_SMALL"
    | "SCRATCH_TOO_SMALL"
    | "NON_FINITE_VERTEX"
    | "CORNER_OUT_OF_RANGE"
    | "TOO_MANY_TRIANGLES"
    | "HOLDS_TRIANGLES"
    | "INDEX_TOO_LARGE"
    | "TOO_MUCH_WORK"
    | "OBJECT_OUT_OF_RANGE"
    | "NOT_IN_PIECES"
    | "TRUNCATED"
    | "NOT_AN_INDEX"
    | "OTHER_BYTE_ORDER"
    | "OTHER_FORMAT"
    | "MALFORMED"
    | "MESH_MISSING"
    | "MESH_NOT_WANTED"
    | "OTHER_MESH"
    | "RAY_ORIGIN_NOT_FINITE"
    | "RAY_DIRECTION_NOT_FINITE"
    | "RAY_DIRECTION_ZERO"
    | "RAY_INTERVAL_NAN"
    | "RAY_INTERVAL_EMPTY"
    | "OTHER_REASON";

/** Reason why a function failed. Only `code` and `element` decide; the message may change. */
export class ArboledaError extends Error {
    readonly name: "ArboledaError";
    readonly code: Code;
    /**
     * What is wrong, counted from 0: the triangle of `NON_FINITE_VERTEX`, `CORNER_OUT_OF_RANGE` and
     * `OBJECT_OUT_OF_RANGE`; the ray of a code that begins with `RAY_`, 0 if there is only one; the version of
     * `OTHER_FORMAT`; the place in the part of `MALFORMED`. Of all other codes `null`.
     */
    readonly element: number | null;
}

/** Three numbers: x, y, z. */
export type Vector = readonly [number, number, number] | Float32Array | Float64Array;

/** Hit of a ray: exact results, rounded once. */
export interface Hit {
    /** The triangle; of several that are hit at the same `t`, the one with the lowest number. */
    readonly triangle: number;
    /** The hit is at origin + t * direction. */
    readonly t: number;
    /** The weight of the second corner, 0 to 1. */
    readonly u: number;
    /** The weight of the third corner, 0 to 1. */
    readonly v: number;
}

/** Closest hits of a batch, one for each ray in each array. */
export interface Hits {
    readonly count: number;
    /** The triangles; `0xffffffff` where a ray hits nothing. */
    readonly triangles: Uint32Array;
    /** Infinity where a ray hits nothing. */
    readonly t: Float32Array;
    readonly u: Float32Array;
    readonly v: Float32Array;
}

/** Work of a query. The same for an index on every machine. */
export interface Counters {
    /** Nodes that the ray entered. */
    readonly nodesVisited: number;
    /** Triangles that were tested. */
    readonly triangleTests: number;
}

/** Options of a build. The defaults suit most scenes. An unknown name is an error. */
export interface Options {
    /** The number of triangles up to which a cell or node is not divided: 1 or more; default 12. */
    leafCapacity?: number;
    /** The highest level of a tree: found (default), or 0 to 20. */
    level?: "automatic" | number;
    /** The least side of an octree's cell that is halved, as a share of the longest: 0 to 1; default 1/3. */
    leastSide?: number;
    /** The largest gap within a cluster, in median box diagonals of triangles of like size; default 0.5. */
    proximity?: number;
    /** The largest number of size classes of clusters: 1 to 4; default 4. */
    sizeClasses?: number;
    /** The cells of a uniform grid; found by default. */
    resolution?: "automatic" | { cellsPerTriangle: number } | { cells: [number, number, number] };
    bvhBuild?: "binned" | "insertion";
    /** The cost of a step and of a triangle test, in one unit; by default what was measured for each kind. */
    cost?: { traversal: number; intersection: number };
    /** The largest number of steps of a build; by default there is none. */
    workLimit?: number;
    /**
     * True to build the index beside the mesh: it reads the triangles in a copy that stays in the memory, has none of
     * its own, and is opened with the same mesh. Not for the wide and the compact BVH.
     */
    beside?: boolean;
    /** The object of each triangle. A hierarchy never divides an object between clusters. */
    objects?: Uint32Array;
}

/** Options of a build in steps. */
export interface StepOptions extends Options {
    /**
     * Milliseconds that the build goes on before the event loop has its turn: 0 or more; default 8, half of a picture of
     * 60 a second. 0 for a turn after each step.
     */
    millisecondsPerTurn?: number;
    /**
     * The number of looks at triangles between two looks at the clock: 1 or more; default 4000, which take 0.02 to 0.1
     * ms. A step takes up to 20,000 more, because little parts are not divided.
     */
    looksPerStep?: number;
    /** Called before each turn, and at the end with 1: the share of the build that is done. It is estimated, and never falls. */
    onProgress?: (share: number) => void;
    /** Ends the build before its next turn: the promise is rejected with the signal's reason. */
    signal?: AbortSignal;
}

/** Cluster tree: the clusters first, a join after what it joins, the root last. */
export interface ClusterTree {
    readonly count: number;
    /** Six numbers a node: the lower corner, the upper corner. */
    readonly bounds: Float32Array;
    /** The parent of each node; -1 for the root. */
    readonly parents: Int32Array;
    /** Two a node; -1 for a cluster. */
    readonly children: Int32Array;
}

/** Cells of octrees. */
export interface Cells {
    /** The number of cells in the arrays. */
    readonly count: number;
    /** The number of cells that there are. */
    readonly total: number;
    /** Six numbers a cell: the lower corner, the upper corner. */
    readonly bounds: Float32Array;
    /** The cluster of each cell. */
    readonly clusters: Uint32Array;
    readonly levels: Uint32Array;
    /** The number of triangles that are filed in each cell; -1 if it is divided further. */
    readonly triangles: Int32Array;
}

/** Node that a ray enters. */
export interface Step {
    /** A join of the cluster tree, a cluster, a cell that is divided, or a leaf. */
    readonly what: "join" | "cluster" | "inner" | "leaf";
    /** In the cluster tree, the number of the node; in an octree, the offset of its words. */
    readonly id: number;
    /** Below the root of the cluster tree, or of the octree. */
    readonly level: number;
    /** The first test in {@link Path.tests}. */
    readonly firstTest: number;
    readonly testCount: number;
    /** The lower corner, the upper corner. */
    readonly bounds: Float32Array;
}

/** Way of a ray. There are as many steps and tests as the counters of the query say. */
export interface Path {
    readonly hit: Hit | null;
    readonly steps: Step[];
    /** The triangles that were tested, in their order. */
    readonly tests: Uint32Array;
}

/**
 * Index that answers queries. It lies in the module's memory until {@link Index.free}; the garbage collector does not
 * free it.
 *
 * A ray has an origin, a direction of any length but zero, and an interval of `t`, both ends included: 0 to Infinity
 * unless it is given. `t` counts in lengths of the direction. Numbers are rounded to 32 bits.
 */
export class Index {
    private constructor();
    readonly kind: Kind;
    readonly triangleCount: number;
    /** 1 for a kind without clusters, 0 without triangles. */
    readonly clusterCount: number;
    /** The length of what {@link Index.save} returns. */
    readonly byteCount: number;
    readonly beside: boolean;
    readonly isFree: boolean;

    /** Finds the closest hit; `null` if nothing is hit. */
    closestHit(origin: Vector, direction: Vector, tMin?: number, tMax?: number): Hit | null;
    /** Tells whether anything is hit: for shadow rays. */
    occluded(origin: Vector, direction: Vector, tMin?: number, tMax?: number): boolean;
    /** Finds all hits, in the order of `t`, of the same `t` in that of the triangles. */
    allHits(origin: Vector, direction: Vector, tMin?: number, tMax?: number): Hit[];
    closestHitCounted(origin: Vector, direction: Vector, tMin?: number, tMax?: number): Counters & { hit: Hit | null };
    occludedCounted(origin: Vector, direction: Vector, tMin?: number, tMax?: number): Counters & { occluded: boolean };

    /**
     * Finds the closest hit of each ray: the fastest way to ask about many.
     *
     * `rays` has eight numbers a ray: origin, direction, smallest `t`, largest `t`. If a ray is invalid, its number is
     * the `element` of the error.
     */
    closestHits(rays: Float32Array): Hits;
    /** Tells for each ray whether anything is hit: 1 or 0. `rays` as in {@link Index.closestHits}. */
    occludedEach(rays: Float32Array): Uint8Array;

    /** The tree that joins the clusters. */
    clusterTree(): ClusterTree;
    /**
     * The cells of an octree or octree-R, down to a level, at most `limit` of them. Both are whole numbers from 0 to
     * 2^32 - 1; by default there is no limit.
     */
    cells(level: number, limit?: number): Cells;
    /** The nodes that a ray enters in an octree or octree-R, and the triangles that it tests. */
    path(origin: Vector, direction: Vector, tMin?: number, tMax?: number): Path;

    /** A copy of the bytes of the index, for a file. They are the same as a native build's. */
    save(): Uint8Array<ArrayBuffer>;
    /**
     * Gives the memory back, to be used by later indices. Every later query throws `NOT_OPEN`. Freeing twice does
     * nothing. A memory of WebAssembly does not shrink: to give it back to the system, drop the module and its memory.
     */
    free(): void;
}

/** Module with its memory. Modules share nothing; use one in each worker. */
export interface Arboleda {
    /** The memory in which everything lies: the caller's, or one of the module's own. */
    readonly memory: WebAssembly.Memory;
    /** True if the module uses simd128: what it says itself, wherever it came from. */
    readonly simd: boolean;
    readonly kinds: readonly Kind[];
    /** The number of bytes of the memory that are in use. */
    readonly usedBytes: number;

    /**
     * Builds an index.
     *
     * `positions` has three numbers a vertex. `corners` has three vertices a triangle; without it, each three vertices
     * are a triangle. Both are copied, and free for other use after the call. Cost: n log n for n triangles, and twice
     * that in the rare case that an index needs more than 80 bytes a triangle.
     */
    build(kind: Kind, positions: Float32Array, corners?: Uint32Array | Uint16Array | null, options?: Options): Index;
    /**
     * Builds an index in steps, and lets the event loop have its turns between them: a page goes on answering. The index
     * is the one that {@link Arboleda.build} makes, byte for byte, and takes as long.
     *
     * `"wide-bvh"` is the kind that can be built so. The arrays are copied at once, and free for other use when the call
     * returns. The module answers queries and builds other indices meanwhile. Where the build fails or is aborted, its
     * memory is given back. All errors reject the promise.
     */
    buildInSteps(
        kind: "wide-bvh",
        positions: Float32Array,
        corners?: Uint32Array | Uint16Array | null,
        options?: StepOptions,
    ): Promise<Index>;
    /**
     * Opens an index from its bytes, which are copied; with its mesh, if it was built beside one. Any bytes are safe:
     * all that queries rely on is checked. Forged bytes can give wrong answers.
     */
    open(bytes: Uint8Array | ArrayBuffer, positions?: Float32Array, corners?: Uint32Array | Uint16Array | null): Index;
    /** Finds the cluster of each triangle: those of every hierarchy that is built of the same mesh and options. */
    clusters(
        positions: Float32Array,
        corners?: Uint32Array | Uint16Array | null,
        options?: Options,
    ): { count: number; clusterOf: Uint32Array };
}

export interface LoadOptions {
    /** Which module of the package: by default what {@link hasSimd128} says. Not used if `wasm` is given. */
    simd?: boolean;
    /**
     * A memory of the caller's, of at least 32 pages, not shared. The module uses all of it, and grows it; so give each
     * module its own. A memory that a module has is refused.
     */
    memory?: WebAssembly.Memory;
    /**
     * The module, its bytes, or where it is; by default the file of this package. A string without a scheme is relative
     * to the folder of `arboleda.js`, not to the page; for the page's own: `new URL("arboleda.wasm", location.href)`.
     */
    wasm?: URL | string | BufferSource | WebAssembly.Module;
}

/** Loads the module. */
export function load(options?: LoadOptions): Promise<Arboleda>;

/** Tells whether this machine runs simd128, by `WebAssembly.validate`. */
export function hasSimd128(): boolean;
