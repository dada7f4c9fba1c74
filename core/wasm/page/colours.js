// Colours of clusters.

/** Colour of a number: hues by the golden ratio, so that neighbours differ. */
export const colourOf = (number) => {
    const hue = (number * 0.618033988749895 + 0.08) % 1;
    const part = (offset) => {
        const at = (hue + offset) % 1;
        const ramp = Math.min(Math.max(Math.abs(at * 6 - 3) - 1, 0), 1);
        return 0.38 + 0.5 * ramp;
    };
    return [part(0), part(2 / 3), part(1 / 3)];
};

/** The colours of triangles by their clusters: nine bytes each, red, green and blue of three corners. */
export const coloursOf = (clusterOf) => {
    const colours = new Uint8Array(9 * clusterOf.length);
    const known = [];
    clusterOf.forEach((cluster, triangle) => {
        const colour = (known[cluster] ??= colourOf(cluster).map((part) => part * 255));
        for (let at = 0; at < 9; at += 1) colours[9 * triangle + at] = colour[at % 3];
    });
    return colours;
};
