/*
 * Arboleda: exact ray queries on triangles, in memory that the caller provides. C99 and C++17.
 *
 * An index is built from a mesh, or opened from bytes that were built before; then it answers rays:
 *
 *     arb_scratch_bytes, arb_measure    how much memory a build needs
 *     arb_build, arb_open               fill an arb_index
 *     arb_sliced_begin, ..._step, ..._finish                     build in slices of time
 *     arb_piecewise_begin, ..._join, ..._next                    build in pieces, for storage larger than the memory
 *     arb_closest, arb_occluded, arb_all_hits                    one ray
 *     arb_closest_each, arb_occluded_each                        many rays, the fastest way
 *     arb_describe                      the bytes of an index, to be written to a file
 *
 * An index that was built elsewhere, and a ray downwards from (x, y, z), whose direction has length 1:
 *
 *     static arb_index index;
 *     arb_error error;
 *     if (arb_open(&index, bytes, byte_count, NULL, &error) != ARB_OK) {
 *         puts(error.message);
 *         return 1;
 *     }
 *     arb_ray ray = {{x, y, z}, {0, 0, -1}, 0, INFINITY};
 *     arb_hit hit;
 *     if (arb_closest(&index, &ray, &hit) == ARB_OK && hit.triangle != ARB_NO_TRIANGLE) {
 *         printf("triangle %lu at distance %g\n", (unsigned long)hit.triangle, hit.t);
 *     }
 *
 * What holds for all functions:
 *
 * - Memory is the caller's. The library allocates nothing and starts no threads. All that it keeps is which vector
 *   instructions the processor has.
 * - A function returns ARB_OK or the reason why not. Only the number decides; texts may change.
 * - A pointer is NULL where that is said to be allowed; else memory of the stated length and type lies there. NULL where
 *   it is not allowed, a pointer that is not aligned for its type, a length that no memory has, and outputs that overlap
 *   other arguments are errors. An array of no elements may be NULL.
 * - Structs that a function fills need not be initialised. After an error, outputs are as they were, unless it is said
 *   otherwise.
 * - Any values of numbers are safe, and so are any bytes that are opened. What the library cannot see is undefined, as
 *   everywhere in C: memory that is shorter than stated, freed, or written to by another thread during a call; bytes or a
 *   mesh that are changed while a handle borrows them; and memory or a mesh of a build that takes several calls, if it is
 *   touched before the build is over.
 * - Threads may use one open arb_index at once, each with outputs and scratch of its own.
 * - Stack: nothing recurses without a bound. On a Cortex-M4, queries and arb_open take at most 8 KiB; a build takes up to
 *   14 KiB for some hundred triangles, and a frame more for each level of a deeper tree. On x86-64, a query takes at
 *   most 9 KiB, a batch 14 KiB with a scratch and 26 KiB without.
 * - Sizes are bytes in size_t, numbers of things are size_t or uint32_t, coordinates are float in any one unit. Strings
 *   are ASCII. The processor must not flush subnormal numbers to zero.
 *
 * Generated from the comments in src/; not to be edited.
 */


#ifndef ARBOLEDA_H
#define ARBOLEDA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * Version of the interface that this header describes: 65536 * major + minor.
 *
 * Names, numbers and layouts stay as they are within a major version. A higher minor version only adds to them.
 */
#define ARB_ABI_VERSION 65537

/**
 * Room for a message in arb_error, its final zero included.
 */
#define ARB_MESSAGE_BYTES 160

/**
 * Value of arb_options.level: the level is found.
 */
#define ARB_AUTOMATIC (0 - 1)

/**
 * Value of arb_options.resolution: the number of cells is found.
 */
#define ARB_RESOLUTION_AUTOMATIC 0

/**
 * Value of arb_options.resolution: arb_options.cells_per_triangle says how many cells.
 */
#define ARB_CELLS_PER_TRIANGLE 1

/**
 * Value of arb_options.resolution: arb_options.cells says how many cells.
 */
#define ARB_CELLS 2

/**
 * Value of arb_options.bvh_build: top-down, by the binned surface area heuristic.
 */
#define ARB_BVH_BINNED 0

/**
 * Value of arb_options.bvh_build: by insertion, each triangle where the surfaces of the boxes grow least.
 */
#define ARB_BVH_INSERTION 1

/**
 * Alignment in bytes of the memory of an index and of the scratch of a build.
 */
#define ARB_ALIGNMENT 64

/**
 * Words of 64 bits in an arb_index: 256 bytes on every target.
 */
#define ARB_INDEX_WORDS 32

/**
 * Value of arb_hit.triangle for a ray that hits nothing.
 */
#define ARB_NO_TRIANGLE 4294967295

/**
 * Result of a function. The numbers are stable: none is ever used again for another reason. A later library of the
 * same major version may return numbers that this header does not name.
 */
enum arb_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * The function did what it says. The only status that is not an error.
     */
    ARB_OK = 0,
    /**
     * A pointer is NULL that must not be.
     */
    ARB_NULL_POINTER = 1,
    /**
     * A pointer is not aligned for its type; or memory of an index, or scratch of a build, does not start at a multiple
     * of ARB_ALIGNMENT bytes.
     */
    ARB_MISALIGNED_POINTER = 2,
    /**
     * A length is larger than any memory.
     */
    ARB_LENGTH_OVERFLOW = 3,
    /**
     * Memory that is written overlaps memory of another argument, of the index, or of the mesh beside it.
     */
    ARB_OVERLAP = 4,
    /**
     * The library does not have all of the header's interface: it has another major version, or a lower minor one.
     */
    ARB_OTHER_ABI = 5,
    /**
     * The arb_index was not filled by arb_build or arb_open, or was closed.
     */
    ARB_NOT_OPEN = 6,
    /**
     * No kind of index has this number.
     */
    ARB_UNKNOWN_KIND = 7,
    /**
     * The library was built without this kind of index.
     */
    ARB_KIND_LEFT_OUT = 8,
    /**
     * An option is out of range; the message names it.
     */
    ARB_INVALID_OPTION = 9,
    /**
     * The arb_mesh has both forms of triangles.
     */
    ARB_TWO_MESHES = 10,
    /**
     * There is no such build: it was not begun, it is over, or its memory was moved; or another call comes first.
     */
    ARB_NOT_BEGUN = 11,
    /**
     * The memory for the index is too small; arb_error.needed_bytes are enough.
     */
    ARB_INDEX_MEMORY_TOO_SMALL = 20,
    /**
     * The scratch is too small; arb_error.needed_bytes are enough.
     */
    ARB_SCRATCH_TOO_SMALL = 21,
    /**
     * A coordinate of a triangle is infinite or NaN; arb_error.element is the triangle.
     */
    ARB_NON_FINITE_VERTEX = 22,
    /**
     * A triangle names a vertex that does not exist; arb_error.element is the triangle.
     */
    ARB_CORNER_OUT_OF_RANGE = 23,
    /**
     * There are more than 2^30 triangles.
     */
    ARB_TOO_MANY_TRIANGLES = 24,
    /**
     * An index of this kind holds the triangles in a form of its own, and is not built beside a mesh.
     */
    ARB_HOLDS_TRIANGLES = 25,
    /**
     * The index outgrows its 32-bit links: lower the level.
     */
    ARB_INDEX_TOO_LARGE = 26,
    /**
     * The build takes more steps than arb_options.work_limit.
     */
    ARB_TOO_MUCH_WORK = 27,
    /**
     * An object number is not below the number of triangles; arb_error.element is the triangle.
     */
    ARB_OBJECT_OUT_OF_RANGE = 28,
    /**
     * An index of this kind cannot be built in pieces: only a hierarchy that has one index for each cluster can.
     */
    ARB_NOT_IN_PIECES = 29,
    /**
     * The bytes of the index are cut short.
     */
    ARB_TRUNCATED = 40,
    /**
     * The bytes are not an index.
     */
    ARB_NOT_AN_INDEX = 41,
    /**
     * The index was written on a machine of the other byte order.
     */
    ARB_OTHER_BYTE_ORDER = 42,
    /**
     * The index has a version of the format that the library does not read; arb_error.element is that version.
     */
    ARB_OTHER_FORMAT = 43,
    /**
     * A part of the index contradicts another; arb_error.element is the place in that part.
     */
    ARB_MALFORMED = 44,
    /**
     * The index was built beside a mesh, and none was given.
     */
    ARB_MESH_MISSING = 45,
    /**
     * The index has its own triangles, and a mesh was given.
     */
    ARB_MESH_NOT_WANTED = 46,
    /**
     * The index was built beside another mesh.
     */
    ARB_OTHER_MESH = 47,
    /**
     * A coordinate of a ray's origin is infinite or NaN. Of these five, arb_error.element is the ray's number.
     */
    ARB_RAY_ORIGIN_NOT_FINITE = 60,
    /**
     * A coordinate of a ray's direction is infinite or NaN.
     */
    ARB_RAY_DIRECTION_NOT_FINITE = 61,
    /**
     * A ray's direction is zero.
     */
    ARB_RAY_DIRECTION_ZERO = 62,
    /**
     * A ray's t_min or t_max is NaN.
     */
    ARB_RAY_INTERVAL_NAN = 63,
    /**
     * A ray's t_min is greater than its t_max.
     */
    ARB_RAY_INTERVAL_EMPTY = 64,
    /**
     * A reason that this version of the interface has no number for; the message says what.
     */
    ARB_OTHER_REASON = 99,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum arb_status arb_status;
#else
typedef int32_t arb_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Kind of an index. The numbers are stable: none is ever used again for another kind.
 *
 * If in doubt: ARB_WIDE_BVH for speed, ARB_BVH on a small device, ARB_LEAN_BVH beside a mesh that is kept anyway.
 *
 * All kinds give the same hits, bit for bit; they differ in time and memory. A "hierarchy" divides the scene into
 * clusters first, and has one index for each. A library may be built without some kinds; see ARB_KIND_LEFT_OUT.
 */
enum arb_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Every triangle, one after the other: for some dozen triangles. 40 bytes a triangle.
     */
    ARB_LINEAR = 0,
    /**
     * Octree.
     */
    ARB_OCTREE = 1,
    /**
     * One octree for each cluster: few nodes a ray if groups are far apart. About 41 bytes a triangle.
     */
    ARB_OCTREE_HIERARCHY = 2,
    /**
     * Octree whose cells are divided where it costs least.
     */
    ARB_OCTREE_R = 3,
    /**
     * One octree-R for each cluster.
     */
    ARB_OCTREE_R_HIERARCHY = 4,
    /**
     * Grid of equal cells.
     */
    ARB_UNIFORM_GRID = 5,
    /**
     * One grid for each cluster.
     */
    ARB_GRID_HIERARCHY = 6,
    /**
     * Kd-tree.
     */
    ARB_KD_TREE = 7,
    /**
     * One kd-tree for each cluster.
     */
    ARB_KD_TREE_HIERARCHY = 8,
    /**
     * Tree of halved cells.
     */
    ARB_BSP_TREE = 9,
    /**
     * One such tree for each cluster.
     */
    ARB_BSP_TREE_HIERARCHY = 10,
    /**
     * Binary tree of boxes: the least code, for a small device. About 45 bytes a triangle.
     */
    ARB_BVH = 11,
    /**
     * One binary tree of boxes for each cluster.
     */
    ARB_BVH_HIERARCHY = 12,
    /**
     * Tree of eight boxes a node: the fastest. 50 to 55 bytes a triangle. It holds the triangles in a form of its own,
     * and is not built beside a mesh.
     */
    ARB_WIDE_BVH = 13,
    /**
     * The same, over clusters.
     */
    ARB_WIDE_BVH_HIERARCHY = 14,
    /**
     * The same tree in 16-bit numbers: fast in little memory. 25 to 30 bytes a triangle. Not built beside a mesh.
     */
    ARB_COMPACT_BVH = 15,
    /**
     * The same, over clusters.
     */
    ARB_COMPACT_BVH_HIERARCHY = 16,
    /**
     * The same tree without triangles: the least memory beside a mesh, 7 to 10 bytes a triangle. Without a mesh beside
     * it, the index has a copy of the triangles, 36 bytes each.
     */
    ARB_LEAN_BVH = 17,
    /**
     * The same, over clusters.
     */
    ARB_LEAN_BVH_HIERARCHY = 18,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum arb_kind arb_kind;
#else
typedef uint32_t arb_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Build of a hierarchy one cluster at a time: for storage that holds the index and memory that does not, such as flash
 * that is written page by page. Each piece is some bytes and where they belong. The index has the bytes of arb_build, if
 * arb_options.work_limit is 0.
 *
 *     size_t bytes = arb_piecewise_scratch_bytes(mesh.triangle_count), memory_bytes;
 *     arb_piecewise_build *build;
 *     arb_piece piece;
 *     arb_piecewise_begin(&build, ARB_BVH_HIERARCHY, &mesh, NULL, scratch, bytes, &memory_bytes, &error);
 *     arb_piecewise_join(build, memory, memory_bytes, &error);
 *     while (arb_piecewise_next(build, room, room_bytes, &piece, &error) == ARB_OK && piece.byte_count != 0) {
 *         write_at(piece.offset, piece.bytes, piece.byte_count);
 *     }
 *
 * The storage has piece.index_bytes of the last piece; bytes that no piece has are 0. The header comes last, so what is
 * written before is no index yet.
 *
 * The build lies in the first bytes of its scratch. Until it is over, the caller keeps alive, where and as they are: the
 * arrays of the mesh, the scratch, and the memory. Nobody reads or writes the last two meanwhile, but for the pieces that
 * lie there. The arb_mesh and the arb_options are free after arb_piecewise_begin, the room after each piece. A copy of
 * the scratch elsewhere is refused as ARB_NOT_BEGUN. One thread at a time calls functions for it. To give a build up,
 * call none any more: it owns nothing.
 */
typedef struct arb_piecewise_build arb_piecewise_build;

/**
 * Build of a wide BVH (ARB_WIDE_BVH) in slices: for a program that must not wait for a whole build, such as a game
 * between two frames, or firmware with a watchdog. The index has the bytes of arb_build, wherever the build pauses.
 *
 *     size_t bytes = arb_sliced_scratch_bytes(mesh.triangle_count);
 *     arb_sliced_build *build;
 *     bool is_done = false;
 *     arb_sliced_begin(&build, &mesh, NULL, memory, memory_bytes, scratch, bytes, &error);
 *     while (arb_sliced_step(build, 1000, &is_done, &error) == ARB_OK && !is_done) {
 *         draw_a_frame();
 *     }
 *     arb_sliced_finish(build, &index, &error);
 *
 * The build lies in the first bytes of its scratch. Until it is over, the caller keeps alive, where and as they are: the
 * arrays of the mesh, the memory of the index, and the scratch. Nobody reads or writes the last two meanwhile. The
 * arb_mesh and the arb_options are free after arb_sliced_begin. A copy of the scratch elsewhere is refused as
 * ARB_NOT_BEGUN. One thread at a time calls functions for it. To give a build up, call none any more: it owns nothing.
 */
typedef struct arb_sliced_build arb_sliced_build;

/**
 * Options of a build. Fill it with arb_options_default, then change what you need. The defaults suit most scenes.
 *
 * Each kind of index reads some of the options. All are checked by every build.
 *
 * Later versions may add fields at the end. `size` tells which of them the caller knows: a library fills those that
 * are missing with defaults, and refuses those that it does not know unless they are 0.
 */
typedef struct arb_options {
    /**
     * sizeof(arb_options), as arb_options_default has set it.
     */
    uint32_t size;
    /**
     * The number of triangles up to which a cell or node is not divided: 1 or more; default 12. Read by octrees, BSP
     * trees, binned BVHs, and by kd-trees if the level is given.
     */
    uint32_t leaf_capacity;
    /**
     * The highest level of a tree: ARB_AUTOMATIC (default), or 0 to 20. Read by octrees, kd-trees, BSP trees, binned
     * BVHs.
     */
    int32_t level;
    /**
     * The least side of an octree's cell that is halved, as a share of the cell's longest side: 0 to 1; default 1/3.
     */
    float least_side;
    /**
     * The largest gap within a cluster, in median box diagonals of triangles of like size: finite, 0 or more; default
     * 0.5. Read by every hierarchy.
     */
    float proximity;
    /**
     * The largest number of size classes of clusters: 1 to 4; default 4. Read by every hierarchy.
     */
    uint32_t size_classes;
    /**
     * Choice of the number of cells of a uniform grid: ARB_RESOLUTION_AUTOMATIC (default),
     * ARB_CELLS_PER_TRIANGLE or ARB_CELLS.
     */
    uint32_t resolution;
    /**
     * Cells for each triangle: above 0, at most 1024. Read if resolution is ARB_CELLS_PER_TRIANGLE.
     */
    float cells_per_triangle;
    /**
     * Cells along x, y and z: 1 to 65536 each. Read if resolution is ARB_CELLS.
     */
    uint32_t cells[3];
    /**
     * Method by which a BVH is built: ARB_BVH_BINNED (default) or ARB_BVH_INSERTION.
     */
    uint32_t bvh_build;
    /**
     * Cost of a traversal step: finite, above 0, in the unit of intersection_cost. 0 in both (default) takes costs that
     * were measured for each kind. Read by builds that estimate.
     */
    double traversal_cost;
    /**
     * Cost of a triangle test, in the unit of traversal_cost.
     */
    double intersection_cost;
    /**
     * The largest number of steps of a build, in looks at a triangle; 0 (default) for no limit. arb_capacity.steps says
     * how many a build takes; the number is the same on every machine.
     */
    uint64_t work_limit;
    /**
     * 1 to build the index beside the mesh: it has no copy of the triangles, but reads them where the caller keeps them,
     * and is opened with the same mesh. Default 0. Not for the wide and the compact BVH.
     */
    uint32_t beside;
    /**
     * Must be 0.
     */
    uint32_t reserved;
} arb_options;

/**
 * More about an error. A function that takes one accepts NULL too. It fills the struct also where it succeeds, with
 * ARB_OK, zeros and an empty message.
 */
typedef struct arb_error {
    /**
     * The status that the function returned.
     */
    arb_status status;
    /**
     * The number of the triangle, ray or part that is wrong, counted from 0, where the status says so; else 0.
     */
    size_t element;
    /**
     * Bytes that would be enough, of ARB_INDEX_MEMORY_TOO_SMALL and ARB_SCRATCH_TOO_SMALL; else 0.
     */
    size_t needed_bytes;
    /**
     * Bytes that were given, of the same two; else 0.
     */
    size_t given_bytes;
    /**
     * Description of the error, with names and numbers: English, in ASCII, ended by a zero.
     */
    char message[ARB_MESSAGE_BYTES];
} arb_error;

/**
 * Triangles, in one of two forms. The id of a triangle is its number in this order, from 0. Set the struct to zeros
 * first, then what you use; with neither form, and a triangle_count of 0, it is a mesh without triangles.
 *
 * Coordinates are finite. Both sides of a triangle are hit; one without area is never hit.
 */
typedef struct arb_mesh {
    /**
     * Form 1: triangle_count times 9 floats, x y z of the corners a, b and c. NULL for form 2.
     */
    const float *triangles;
    /**
     * Form 2: vertex_count times 3 floats, x y z of a vertex. NULL for form 1.
     */
    const float *vertices;
    /**
     * Form 2: triangle_count times 3 numbers of vertices, from 0, of the corners a, b and c. NULL for form 1.
     */
    const uint32_t *corners;
    /**
     * The object of each triangle, triangle_count numbers below triangle_count; or NULL. A hierarchy never divides an
     * object between clusters. Read by arb_measure and arb_build only.
     */
    const uint32_t *objects;
    /**
     * The number of triangles: at most 2^30.
     */
    size_t triangle_count;
    /**
     * The number of vertices of form 2; 0 for form 1.
     */
    size_t vertex_count;
} arb_mesh;

/**
 * Memory and work of a build.
 */
typedef struct arb_capacity {
    /**
     * Bytes of the index, exactly.
     */
    size_t index_bytes;
    /**
     * Bytes of scratch that are enough. They are free again after the build.
     */
    size_t scratch_bytes;
    /**
     * Steps of the build, in looks at a triangle; see arb_options.work_limit.
     */
    uint64_t steps;
} arb_capacity;

/**
 * Handle of an index that answers queries: 256 bytes, the caller's. arb_build and arb_open fill it; nobody else writes
 * to it. One that is not filled, of zeros for example, is refused by every function.
 *
 * It borrows the bytes of the index and, beside a mesh, the mesh's arrays: both must stay where and as they are while
 * the handle is used. It owns nothing, so it needs not be closed. It may be copied, and used by several threads at once.
 */
typedef struct arb_index {
    /**
     * Not to be read or written by the caller.
     */
    uint64_t opaque[ARB_INDEX_WORDS];
} arb_index;

/**
 * Description of an open index.
 */
typedef struct arb_description {
    /**
     * The bytes of the index, in the memory in which it was built or opened: what to write to a file, or to copy.
     */
    const void *bytes;
    /**
     * The number of these bytes.
     */
    size_t byte_count;
    /**
     * The kind, a number of arb_kind.
     */
    uint32_t kind;
    /**
     * The number of triangles.
     */
    uint32_t triangle_count;
    /**
     * The number of clusters; 1 for a kind without clusters, 0 without triangles.
     */
    uint32_t cluster_count;
    /**
     * 1 if the index lies beside a mesh, else 0.
     */
    uint32_t beside;
} arb_description;

/**
 * Run of the bytes of an index.
 */
typedef struct arb_piece {
    /**
     * The bytes: in the room, in the arrays of the mesh, or in the memory of the build; NULL if there are no more.
     */
    const void *bytes;
    /**
     * The number of bytes; 0 if there are no more pieces.
     */
    size_t byte_count;
    /**
     * The place of the first byte in the index, a multiple of 4.
     */
    size_t offset;
    /**
     * The bytes of the index, as far as it is known: its length if there are no more pieces.
     */
    size_t index_bytes;
} arb_piece;

/**
 * Ray: the points origin + t * direction for t_min <= t <= t_max. 32 bytes.
 *
 * origin is finite. direction is finite, not zero, and of any length; t counts in lengths of it, so t is a distance if
 * that length is 1. t_min is at most t_max, neither is NaN, and both may be infinite: 0 and INFINITY of math.h for a
 * half-line, 0 and 1 for a segment whose direction goes from one end to the other.
 */
typedef struct arb_ray {
    /**
     * x, y, z of the point at t = 0.
     */
    float origin[3];
    /**
     * x, y, z of the direction.
     */
    float direction[3];
    /**
     * The smallest t that counts as a hit.
     */
    float t_min;
    /**
     * The largest t that counts as a hit.
     */
    float t_max;
} arb_ray;

/**
 * Hit of a ray. 16 bytes. All numbers are exact results, rounded once: the same bits for every kind of index, on every
 * machine.
 */
typedef struct arb_hit {
    /**
     * The triangle's id; of several that are hit at the same t, the lowest. ARB_NO_TRIANGLE if nothing is hit.
     */
    uint32_t triangle;
    /**
     * Distance from the origin of the ray, in lengths of its direction; INFINITY if nothing is hit.
     */
    float t;
    /**
     * The weight of corner b, 0 to 1: the point is a + u * (b - a) + v * (c - a).
     */
    float u;
    /**
     * The weight of corner c, 0 to 1.
     */
    float v;
} arb_hit;

/**
 * Work of queries. The same for an index on every machine.
 */
typedef struct arb_counters {
    /**
     * Nodes entered.
     */
    uint64_t nodes_visited;
    /**
     * Triangles tested.
     */
    uint64_t triangle_tests;
} arb_counters;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The version of the interface that the library has.
 */
uint32_t arb_abi_version(void);

/**
 * Checks that the library has the interface of a header. Call it once, as `arb_check_abi(ARB_ABI_VERSION)`, before
 * anything else.
 *
 * Errors: ARB_OTHER_ABI if the major versions differ, or if the header's minor version is higher than the library's.
 */
arb_status arb_check_abi(uint32_t header_version);

/**
 * The name of a kind, for example "wide-bvh"; "unknown" for a number that no kind has. A static string, never NULL.
 */
const char *arb_kind_name(uint32_t kind);

/**
 * The text of a status, in English without a final stop; "unknown status" for a number that no status has. A static
 * string, never NULL.
 */
const char *arb_status_text(int32_t status);

/**
 * Fills options with the defaults. Call it as `arb_options_default(&options, sizeof options)`.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER; ARB_INVALID_OPTION if `size` is that of no version of the struct.
 */
arb_status arb_options_default(struct arb_options *options,
                               size_t size);

/**
 * Bounds the scratch of a build: writes to `scratch_bytes` how many bytes are enough for `triangle_count` triangles,
 * wherever they lie. `kind` is a number of arb_kind, `options` may be NULL for the defaults. Cost: constant.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_UNKNOWN_KIND, ARB_KIND_LEFT_OUT, ARB_INVALID_OPTION.
 */
arb_status arb_scratch_bytes(uint32_t kind,
                             size_t triangle_count,
                             const struct arb_options *options,
                             size_t *scratch_bytes,
                             struct arb_error *error);

/**
 * Measures what a build takes, by a build that only counts: the exact bytes of the index, and the steps. Cost: that of
 * the build.
 *
 * `kind`, `mesh` and `options` are those of arb_build. `scratch` starts at a multiple of ARB_ALIGNMENT bytes, and has as
 * many bytes as arb_scratch_bytes says.
 *
 * Errors: those of arb_build but ARB_INDEX_MEMORY_TOO_SMALL.
 */
arb_status arb_measure(uint32_t kind,
                       const struct arb_mesh *mesh,
                       const struct arb_options *options,
                       void *scratch,
                       size_t scratch_bytes,
                       struct arb_capacity *capacity,
                       struct arb_error *error);

/**
 * Builds an index of a mesh in the first bytes of `memory`, and opens it.
 *
 * - `index`: the handle to be filled. After an error it is not open; after ARB_OVERLAP it is as it was.
 * - `kind`: a number of arb_kind.
 * - `mesh`: copied into the index, and free again after the call, unless arb_options.beside is 1.
 * - `options`: NULL for the defaults.
 * - `memory`: starts at a multiple of ARB_ALIGNMENT bytes. arb_measure says how many bytes are needed; so does a call
 *   with fewer, NULL and 0 for example, in arb_error.needed_bytes. It belongs to the index while the handle is used.
 *   After an error, its contents are undefined.
 * - `scratch`: likewise aligned, as many bytes as arb_scratch_bytes says. Free again after the call.
 * - `error`: receives the reason of a failure; or NULL.
 *
 * The bytes that are written depend on mesh, kind and options only. Cost: at most a multiple of n log n for n
 * triangles, in the caller's thread.
 *
 * Errors: any of arb_status from 1 to 29.
 */
arb_status arb_build(struct arb_index *index,
                     uint32_t kind,
                     const struct arb_mesh *mesh,
                     const struct arb_options *options,
                     void *memory,
                     size_t memory_bytes,
                     void *scratch,
                     size_t scratch_bytes,
                     struct arb_error *error);

/**
 * Opens an index from its bytes, in place: bytes of a file, or in ROM.
 *
 * - `index`: the handle to be filled. After an error it is not open; after ARB_OVERLAP it is as it was.
 * - `bytes`: start at a multiple of ARB_ALIGNMENT bytes; what comes after the index is ignored.
 * - `mesh`: NULL; or, for an index that was built beside a mesh, one with the same triangles in either form.
 *
 * Everything on which queries rely is checked, so bytes from anywhere do no harm. Forged bytes can give wrong answers.
 * Any kind of index is opened. Bytes of any machine of the same byte order are. Cost: linear in `byte_count` and in the
 * mesh.
 *
 * Errors: any of arb_status from 1 to 19 and from 40 to 59; ARB_NON_FINITE_VERTEX and ARB_CORNER_OUT_OF_RANGE of a mesh.
 */
arb_status arb_open(struct arb_index *index,
                    const void *bytes,
                    size_t byte_count,
                    const struct arb_mesh *mesh,
                    struct arb_error *error);

/**
 * Describes an open index: its bytes, its kind, and what it consists of.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_NOT_OPEN.
 */
arb_status arb_describe(const struct arb_index *index,
                        struct arb_description *description);

/**
 * Closes a handle: any later use of it is an error. Not necessary, since a handle owns nothing; good before the memory
 * of the index is freed. Closing one that is not open does nothing.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER.
 */
arb_status arb_close(struct arb_index *index);

/**
 * Bytes of scratch that a build in pieces of `triangle_count` triangles needs, wherever they lie: some 80 to 90 a
 * triangle.
 */
size_t arb_piecewise_scratch_bytes(size_t triangle_count);

/**
 * Begins a build in pieces, and finds the clusters. See arb_piecewise_build for what has to stay alive.
 *
 * - `build`: receives the address of the build, which is that of the scratch. After an error it is NULL; after
 *   ARB_OVERLAP it is as it was.
 * - `kind`: a hierarchy of arb_kind, but for those of the wide, the compact and the lean BVH, each of which is one tree.
 * - `mesh`, `options`: as of arb_build.
 * - `scratch`: starts at a multiple of ARB_ALIGNMENT bytes, and has as many bytes as arb_piecewise_scratch_bytes says.
 * - `memory_bytes`: receives the number of bytes that arb_piecewise_join needs.
 *
 * Cost: at most a multiple of n log n for n triangles.
 *
 * Errors: any of arb_status from 1 to 29.
 */
arb_status arb_piecewise_begin(struct arb_piecewise_build **build,
                               uint32_t kind,
                               const struct arb_mesh *mesh,
                               const struct arb_options *options,
                               void *scratch,
                               size_t scratch_bytes,
                               size_t *memory_bytes,
                               struct arb_error *error);

/**
 * Joins the clusters into the cluster tree, in memory that stays with the build.
 *
 * - `memory`: starts at a multiple of ARB_ALIGNMENT bytes, and has as many bytes as arb_piecewise_begin says. It holds the
 *   header, the cluster tree and the scratch for the largest cluster. To call this again after an error is allowed.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_LENGTH_OVERFLOW, ARB_OVERLAP, ARB_SCRATCH_TOO_SMALL;
 * ARB_NOT_BEGUN, also if the clusters are joined already.
 */
arb_status arb_piecewise_join(struct arb_piecewise_build *build,
                              void *memory,
                              size_t memory_bytes,
                              struct arb_error *error);

/**
 * Makes the next piece of the index.
 *
 * - `room`: NULL if `room_bytes` is 0, or starts at a multiple of ARB_ALIGNMENT bytes. Most pieces are made there: the
 *   words of a cluster, or as many triangles as fit, 36 bytes each. What lay there before is lost.
 * - `piece`: receives the bytes, and where they belong. They are valid until the next call. If there are no more, its
 *   byte_count is 0, and the build is over.
 *
 * Pieces come in the order in which they lie in the index, but for the cluster tree and the header, which come last.
 *
 * Errors: ARB_INDEX_MEMORY_TOO_SMALL, if the room is too small for the next piece: arb_error.needed_bytes are enough for
 * it, and the next call makes the same piece. ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_LENGTH_OVERFLOW, ARB_OVERLAP;
 * ARB_NOT_BEGUN, also before arb_piecewise_join; ARB_INDEX_TOO_LARGE, ARB_TOO_MUCH_WORK. `piece` is then unchanged.
 */
arb_status arb_piecewise_next(struct arb_piecewise_build *build,
                              void *room,
                              size_t room_bytes,
                              struct arb_piece *piece,
                              struct arb_error *error);

/**
 * Bytes of scratch that a build in slices of `triangle_count` triangles needs, wherever they lie: some 13 KB for the
 * build itself, and 48 bytes a triangle.
 */
size_t arb_sliced_scratch_bytes(size_t triangle_count);

/**
 * Begins a build of a wide BVH in slices, and does none of its work. See arb_sliced_build for what has to stay alive.
 *
 * - `build`: receives the address of the build, which is that of the scratch. After an error it is NULL; after
 *   ARB_OVERLAP it is as it was.
 * - `mesh`, `options`: as of arb_build; arb_options.beside is 0.
 * - `memory`: starts at a multiple of ARB_ALIGNMENT bytes, as that of arb_build. How many bytes the index takes is known
 *   only once the triangles are sorted: mostly 50 to 60 a triangle. arb_measure says it exactly, and takes nearly as
 *   long as a build.
 * - `scratch`: likewise aligned, as many bytes as arb_sliced_scratch_bytes says.
 *
 * Errors: any of arb_status from 1 to 29, but those of the triangles and ARB_INDEX_MEMORY_TOO_SMALL, which
 * arb_sliced_step returns. ARB_KIND_LEFT_OUT if the library was built without the wide BVH.
 */
arb_status arb_sliced_begin(struct arb_sliced_build **build,
                            const struct arb_mesh *mesh,
                            const struct arb_options *options,
                            void *memory,
                            size_t memory_bytes,
                            void *scratch,
                            size_t scratch_bytes,
                            struct arb_error *error);

/**
 * Goes on with a build for about `looks` looks at a triangle, at least one.
 *
 * - `is_done`: receives true if only arb_sliced_finish is left to do, which is short then.
 *
 * Cost: a look takes 4 to 10 ns on a PC. A call takes at most `looks` looks, and what is not divided: mostly 4,000, at
 * most 20,000. A whole build takes about as long as arb_build.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_NOT_BEGUN, ARB_OVERLAP, and those of a build:
 * ARB_INDEX_MEMORY_TOO_SMALL, ARB_NON_FINITE_VERTEX, ARB_CORNER_OUT_OF_RANGE, ARB_OBJECT_OUT_OF_RANGE,
 * ARB_INDEX_TOO_LARGE, ARB_TOO_MUCH_WORK. After one of a build, each later call returns the same.
 */
arb_status arb_sliced_step(struct arb_sliced_build *build,
                           size_t looks,
                           bool *is_done,
                           struct arb_error *error);

/**
 * Does what is left of a build, and opens the index: the handle is that of arb_build. The build is over, and its scratch
 * and mesh are free again, also after an error.
 *
 * Errors: those of arb_sliced_step. The handle is then not open; after ARB_OVERLAP it is as it was, and the build goes
 * on.
 */
arb_status arb_sliced_finish(struct arb_sliced_build *build,
                             struct arb_index *index,
                             struct arb_error *error);

/**
 * Checks a ray: ARB_OK if every query takes it.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, and any of arb_status from 60 to 69.
 */
arb_status arb_check_ray(const struct arb_ray *ray);

/**
 * Finds the closest hit of a ray in t_min to t_max, both included; of several at the same t, the triangle with the
 * lowest id. A ray that hits nothing is no error: the hit's triangle is ARB_NO_TRIANGLE.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_NOT_OPEN, and any of arb_status from 60 to 69. `hit` is then unchanged.
 */
arb_status arb_closest(const struct arb_index *index,
                       const struct arb_ray *ray,
                       struct arb_hit *hit);

/**
 * Tells whether a ray hits any triangle in t_min to t_max, both included: for shadow rays. It ends at the first hit
 * that it finds, and takes less time than arb_closest.
 *
 * Errors: as arb_closest. `occluded` is then unchanged.
 */
arb_status arb_occluded(const struct arb_index *index,
                        const struct arb_ray *ray,
                        bool *occluded);

/**
 * Finds all hits of a ray, sorted by t, of the same t by id.
 *
 * - `hits`: room for `capacity` hits; NULL if that is 0.
 * - `hit_count`: receives the number of hits that were written.
 * - `truncated`: receives true if there are more hits than `capacity`. The closest ones were written then; for the
 *   others, ask again with more room.
 *
 * Errors: as arb_closest, ARB_LENGTH_OVERFLOW, ARB_OVERLAP. All outputs are then unchanged.
 */
arb_status arb_all_hits(const struct arb_index *index,
                        const struct arb_ray *ray,
                        struct arb_hit *hits,
                        size_t capacity,
                        size_t *hit_count,
                        bool *truncated);

/**
 * Finds the closest hit, as arb_closest does, and adds the work to `counters`, which the caller has set to zeros.
 *
 * Errors: as arb_closest. Hit and counters are then unchanged.
 */
arb_status arb_closest_counted(const struct arb_index *index,
                               const struct arb_ray *ray,
                               struct arb_hit *hit,
                               struct arb_counters *counters);

/**
 * Tells whether a ray hits any triangle, as arb_occluded does, and adds the work to `counters`, which the caller has
 * set to zeros.
 *
 * Errors: as arb_closest. Both outputs are then unchanged.
 */
arb_status arb_occluded_counted(const struct arb_index *index,
                                const struct arb_ray *ray,
                                bool *occluded,
                                struct arb_counters *counters);

/**
 * Bytes of scratch that arb_closest_each and arb_occluded_each use, whatever the index and the number of rays: about
 * 71 KiB on x86-64; 0 where scratch makes nothing faster.
 */
size_t arb_batch_scratch_bytes(void);

/**
 * Finds the closest hit of each ray: the same bits as arb_closest, in less time.
 *
 * - `rays`, `hits`: `ray_count` of each, in the same order.
 * - `scratch`: memory of the caller at any alignment, arb_batch_scratch_bytes() or more; its contents do not
 *   matter. (Lanes of vectors whose results are not used may read old contents: a memory checker such as valgrind wants
 *   it set to zeros once.) With fewer bytes, NULL and 0 for example, the answers are the same and take longer. Each
 *   thread needs its own.
 *
 * With a scratch, the wide, compact and lean BVH have 32 rays in flight where the processor has AVX2, from 128 rays
 * on: the fastest way.
 *
 * Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_LENGTH_OVERFLOW, ARB_OVERLAP, ARB_NOT_OPEN, and any of
 * arb_status from 60 to 69, with the ray's number in arb_error.element. All rays are checked first, so `hits` is then
 * unchanged.
 */
arb_status arb_closest_each(const struct arb_index *index,
                            const struct arb_ray *rays,
                            size_t ray_count,
                            struct arb_hit *hits,
                            void *scratch,
                            size_t scratch_bytes,
                            struct arb_error *error);

/**
 * Tells for each ray whether it hits any triangle, as arb_occluded does, in less time. Arguments and errors as of
 * arb_closest_each; `occluded` has room for `ray_count` values.
 */
arb_status arb_occluded_each(const struct arb_index *index,
                             const struct arb_ray *rays,
                             size_t ray_count,
                             bool *occluded,
                             void *scratch,
                             size_t scratch_bytes,
                             struct arb_error *error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ARBOLEDA_H */
