// Runs the WebAssembly program named by the first argument.
import { readFileSync } from "node:fs";

const print = (first, count) => {
  process.stdout.write(new Uint8Array(instance.exports.memory.buffer, first, count));
};
const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]), { host: { print } });
process.exitCode = instance.exports.run() ? 0 : 1;
