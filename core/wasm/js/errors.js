// Errors: one class, with the names of the C interface's statuses as codes.

/** Statuses of `arb_status` by number. A test compares them with the header. */
const STATUSES = {
    1: "NULL_POINTER",
    2: "MISALIGNED_POINTER",
    3: "LENGTH_OVERFLOW",
    4: "OVERLAP",
    5: "OTHER_ABI",
    6: "NOT_OPEN",
    7: "UNKNOWN_KIND",
    8: "KIND_LEFT_OUT",
    9: "INVALID_OPTION",
    10: "TWO_MESHES",
    11: "NOT_BEGUN",
    20: "INDEX_MEMORY_TOO_SMALL",
    21: "SCRATCH_TOO_SMALL",
    22: "NON_FINITE_VERTEX",
    23: "CORNER_OUT_OF_RANGE",
    24: "TOO_MANY_TRIANGLES",
    25: "HOLDS_TRIANGLES",
    26: "INDEX_TOO_LARGE",
    27: "TOO_MUCH_WORK",
    28: "OBJECT_OUT_OF_RANGE",
    29: "NOT_IN_PIECES",
    40: "TRUNCATED",
    41: "NOT_AN_INDEX",
    42: "OTHER_BYTE_ORDER",
    43: "OTHER_FORMAT",
    44: "MALFORMED",
    45: "MESH_MISSING",
    46: "MESH_NOT_WANTED",
    47: "OTHER_MESH",
    60: "RAY_ORIGIN_NOT_FINITE",
    61: "RAY_DIRECTION_NOT_FINITE",
    62: "RAY_DIRECTION_ZERO",
    63: "RAY_INTERVAL_NAN",
    64: "RAY_INTERVAL_EMPTY",
    99: "OTHER_REASON",
};

/** Codes that name an element besides those of rays. For others the C interface writes 0. A test reads the header. */
const WITH_ELEMENT = ["NON_FINITE_VERTEX", "CORNER_OUT_OF_RANGE", "OBJECT_OUT_OF_RANGE", "OTHER_FORMAT", "MALFORMED"];

/** Tells whether a code names the triangle, ray or part that is wrong. */
export const namesElement = (code) => code.startsWith("RAY_") || WITH_ELEMENT.includes(code);

/** The code of a status. */
export const codeOf = (status) => STATUSES[status] ?? "OTHER_REASON";

/** Everything that this package throws. `code` decides; the text may change. */
export class ArboledaError extends Error {
    constructor(code, message, element = null) {
        super(message);
        this.name = "ArboledaError";
        this.code = code;
        this.element = namesElement(code) ? element : null;
    }
}

/** An argument that is not what the function takes. */
export const invalid = (message) => new ArboledaError("INVALID_ARGUMENT", message);
