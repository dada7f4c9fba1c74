// Compiled by a test, not run: what the types allow, and what they refuse.
import { ArboledaError, hasSimd128, load } from "arboleda";
import type { Arboleda, Code, Hit, Index, Kind, Options, StepOptions } from "arboleda";

const kind: Kind = "octree-hierarchy";
const options: Options = { leafCapacity: 4, level: "automatic", resolution: { cells: [1, 2, 3] }, beside: false };
const memory = new WebAssembly.Memory({ initial: 64 });
const arboleda: Arboleda = await load({ memory, simd: hasSimd128() });
const index: Index = arboleda.build(kind, new Float32Array(9), null, options);
const steps: StepOptions = { onProgress: (share: number) => share, signal: new AbortController().signal, ...options };
const stepped: Promise<Index> = arboleda.buildInSteps("wide-bvh", new Float32Array(9), null, steps);
(await stepped).free();
const hit: Hit | null = index.closestHit([0, 0, -1], new Float32Array([0, 0, 1]), 0, Infinity);
const weights: [number, number] | undefined = hit ? [hit.u, hit.v] : undefined;
const { triangles, t } = index.closestHits(new Float32Array(8));
const first: [number, number] = [triangles[0]!, t[0]!];
const occluded: Uint8Array = index.occludedEach(new Float32Array(8));
const { hit: counted, nodesVisited, triangleTests } = index.closestHitCounted([0, 0, -1], [0, 0, 1]);
const numbers: number = nodesVisited + triangleTests + index.path([0, 0, -1], [0, 0, 1]).steps[0]!.bounds[5]!;
const file = new Blob([index.save()]);
const again: Index = arboleda.open(await file.arrayBuffer());
try {
    again.free();
} catch (error) {
    const code: Code | null = error instanceof ArboledaError ? error.code : null;
    const element: number | null = error instanceof ArboledaError ? error.element : null;
    console.log(element, code === "NOT_OPEN", weights, first, occluded, counted, numbers);
}

// @ts-expect-error no kind is called that
arboleda.build("quadtree", new Float32Array(9));
// @ts-expect-error this kind is not built in steps
await arboleda.buildInSteps("bvh", new Float32Array(9));
// @ts-expect-error positions are 32-bit floats
arboleda.build("bvh", [0, 1, 2]);
// @ts-expect-error a vector has three numbers
index.occluded([0, 1], [0, 0, 1]);
// @ts-expect-error an index is made by build or open
new (await import("arboleda")).Index();
// @ts-expect-error no option is called that
arboleda.build("bvh", new Float32Array(9), null, { leafSize: 4 });
