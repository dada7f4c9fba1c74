// Scenes that are made here: whole numbers, sums, products and square roots only, so they are the same in each browser.

/** Numbers by xorshift (Marsaglia, *Xorshift RNGs*, 2003): whole numbers of 32 bits decide. */
export class Numbers {
    constructor(seed) {
        this.state = seed >>> 0 || 1;
    }

    /** A number from 0, below 1. */
    next() {
        let x = this.state;
        x ^= x << 13;
        x ^= x >>> 17;
        x ^= x << 5;
        this.state = x >>> 0;
        return this.state / 4294967296;
    }

    within(low, high) {
        return low + (high - low) * this.next();
    }

    /** A direction, evenly spread: a point of the ball, by trying points of its cube. */
    direction() {
        for (;;) {
            const [x, y, z] = [this.within(-1, 1), this.within(-1, 1), this.within(-1, 1)];
            const square = x * x + y * y + z * z;
            if (square > 1e-6 && square <= 1) return [x, y, z].map((part) => part / Math.sqrt(square));
        }
    }
}

/** Triangles on their way into one array. */
class Triangles {
    list = [];

    quad(a, b, c, d) {
        this.list.push(...a, ...b, ...c, ...a, ...c, ...d);
    }

    /** A box from its lower to its upper corner. */
    box([x0, y0, z0], [x1, y1, z1]) {
        this.quad([x0, y0, z0], [x0, y1, z0], [x1, y1, z0], [x1, y0, z0]);
        this.quad([x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]);
        this.quad([x0, y0, z0], [x0, y0, z1], [x0, y1, z1], [x0, y1, z0]);
        this.quad([x1, y0, z0], [x1, y1, z0], [x1, y1, z1], [x1, y0, z1]);
        this.quad([x0, y0, z0], [x1, y0, z0], [x1, y0, z1], [x0, y0, z1]);
        this.quad([x0, y1, z0], [x0, y1, z1], [x1, y1, z1], [x1, y1, z0]);
    }

    /** A sphere of 12 * parts^2 triangles: a cube whose points are moved to the sphere. */
    sphere(middle, radius, parts) {
        const point = (axis, side, i, j) => {
            const at = [0, 0, 0];
            at[axis] = side;
            at[(axis + 1) % 3] = (2 * i) / parts - 1;
            at[(axis + 2) % 3] = side * ((2 * j) / parts - 1);
            const length = Math.sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
            return at.map((x, k) => middle[k] + (x / length) * radius);
        };
        for (let axis = 0; axis < 3; axis += 1) {
            for (const side of [-1, 1]) {
                for (let i = 0; i < parts; i += 1) {
                    for (let j = 0; j < parts; j += 1) {
                        const at = (di, dj) => point(axis, side, i + di, j + dj);
                        this.quad(at(0, 0), at(1, 0), at(1, 1), at(0, 1));
                    }
                }
            }
        }
    }

    /** A floor of parts * parts squares at y = 0. */
    floor(side, parts) {
        const at = (i) => (i / parts - 0.5) * side;
        for (let i = 0; i < parts; i += 1) {
            for (let j = 0; j < parts; j += 1) {
                const [x0, x1, z0, z1] = [at(i), at(i + 1), at(j), at(j + 1)];
                this.quad([x0, 0, z0], [x0, 0, z1], [x1, 0, z1], [x1, 0, z0]);
            }
        }
    }
}

/** Groups of spheres, far from each other, above a floor. */
const groups = () => {
    const triangles = new Triangles();
    const numbers = new Numbers(4);
    triangles.floor(46, 10);
    for (const [x, y, z, radius, count] of [
        [-13, 6, -12, 5, 16],
        [14, 5, -13, 4, 14],
        [-13, 4, 13, 3.4, 13],
        [12, 6, 11, 5, 18],
        [0, 12, 0, 3, 12],
    ]) {
        for (let sphere = 0; sphere < count; sphere += 1) {
            const away = numbers.direction().map((part) => part * radius * Math.sqrt(numbers.next()));
            triangles.sphere([x + away[0], y + away[1], z + away[2]], radius * numbers.within(0.12, 0.3), 6);
        }
    }
    return triangles;
};

/** Blocks of houses with trees between them. */
const town = () => {
    const triangles = new Triangles();
    const numbers = new Numbers(9);
    triangles.floor(260, 8);
    for (let x = -5; x <= 5; x += 1) {
        for (let z = -5; z <= 5; z += 1) {
            const [left, back] = [22 * x - 8, 22 * z - 8];
            const away = Math.abs(x) + Math.abs(z);
            for (const [i, j] of [
                [0, 0],
                [9, 0],
                [0, 9],
                [9, 9],
            ]) {
                const height = numbers.within(3, 8) + (away < 4 ? numbers.within(0, 26) : 0);
                const [a, b] = [left + i, back + j];
                triangles.box([a, 0.02, b], [a + 7, height, b + 7]);
                triangles.box([a - 0.3, height, b - 0.3], [a + 7.3, height + 0.5, b + 7.3]);
                for (let floor = 1.5; floor + 1.5 < height; floor += 2.5) {
                    for (let window = 0.8; window < 6; window += 2) {
                        triangles.box([a + window, floor, b - 0.15], [a + window + 1.1, floor + 1.2, b - 0.02]);
                        triangles.box([a + window, floor, b + 7.02], [a + window + 1.1, floor + 1.2, b + 7.15]);
                    }
                }
            }
            for (let tree = 0; tree < 3; tree += 1) {
                const [a, b, size] = [left + 17.5, back + 1 + 6 * tree, numbers.within(0.7, 1.2)];
                triangles.box([a - 0.12, 0.02, b - 0.12], [a + 0.12, 1.6, b + 0.12]);
                triangles.sphere([a, 2.3 * size, b], size, 3);
            }
        }
    }
    return triangles;
};

/** 1,029 spheres of 972 triangles each. */
const million = () => {
    const triangles = new Triangles();
    const numbers = new Numbers(2);
    for (let sphere = 0; sphere < 1029; sphere += 1) {
        const away = numbers.direction().map((part) => part * numbers.within(8, 60));
        triangles.sphere(away, numbers.within(0.4, 1.6), 9);
    }
    return triangles;
};

/** The scenes by their names in the page. */
export const SCENES = { groups, town, million };

/** A sphere around 0 of radius 1 and 12 * parts^2 triangles. Neighbours share their corners, bit for bit. */
export const closedSphere = (parts) => {
    const triangles = new Triangles();
    triangles.sphere([0, 0, 0], 1, parts);
    return new Float32Array(triangles.list);
};

/** Makes a scene: nine numbers a triangle. */
export const make = (name) => new Float32Array(SCENES[name]().list);
