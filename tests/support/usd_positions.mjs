// Reads a USD file with TinyUSDZ (the npm package tinyusdz, a library in C++ made for WebAssembly)
// and writes down what it finds.
//
//   node usd_positions.mjs PACKAGE FILE OUT FRAME...
//
// PACKAGE is the folder of the package. OUT gets a line a vertex: frame, name of the mesh, x, y, z,
// and OUT.stage what the file means as a scene: "points" or "face", name of the mesh, three numbers.

import fs from "node:fs";
import path from "node:path";
import url from "node:url";

async function tinyusdz(folder) {
  // The package is made for browsers, but needs nothing of them.
  process.type = "renderer";
  globalThis.window = globalThis;
  globalThis.document = { currentScript: null };
  const file = path.resolve(folder, "tinyusdz.js");
  const module = await import(url.pathToFileURL(file).href);
  const wasmBinary = fs.readFileSync(path.resolve(folder, "tinyusdz.wasm"));
  return module.default({ wasmBinary });
}

function read(loader, method, bytes) {
  if (!loader[method](bytes, "animation.usda")) throw new Error(`${method}: ${loader.error()}`);
}

/// "(1, 2, 3), (4, 5, 6)" -> lines
function vertexLines(head, text) {
  return [...text.matchAll(/\(([^()]*)\)/g)].map(
    (vertex) => `${head} ${vertex[1].replaceAll(",", " ")}\n`
  );
}

/// What TinyUSDZ has parsed, as it writes it down itself.
function layerPositions(text, frames) {
  const out = [];
  let mesh = "";
  let sampled = false;
  for (const line of text.split("\n")) {
    const begin = line.match(/^\s*def Mesh "([^"]*)"/);
    if (begin) mesh = begin[1];
    if (/^\s*point3f\[\] points\.timeSamples = \{/.test(line)) sampled = true;
    else if (/^\s*\}/.test(line)) sampled = false;
    const fixed = line.match(/^\s*point3f\[\] points = \[(.*)\]/);
    if (fixed) for (const frame of frames) out.push(...vertexLines(`${frame} ${mesh}`, fixed[1]));
    const sample = sampled && line.match(/^\s*([-0-9.e]+): \[(.*)\],?\s*$/);
    if (sample && frames.includes(Number(sample[1])))
      out.push(...vertexLines(`${Number(sample[1])} ${mesh}`, sample[2]));
  }
  return out.join("");
}

function stageMeshes(loader) {
  const out = [];
  const triples = (word, name, values) => {
    for (let k = 0; k < values.length; k += 3)
      out.push(`${word} ${name} ${values[k]} ${values[k + 1]} ${values[k + 2]}\n`);
  };
  for (let i = 0; i < loader.numMeshes(); ++i) {
    const mesh = loader.getMesh(i);
    triples("points", mesh.absPath, mesh.points);
    triples("face", mesh.absPath, mesh.faceVertexIndices);
  }
  return out.join("");
}

const [folder, file, out, ...frames] = process.argv.slice(2);
const library = await tinyusdz(folder);
const bytes = new Uint8Array(fs.readFileSync(file));
const layer = new library.TinyUSDZLoaderNative();
read(layer, "loadAsLayerFromBinary", bytes);
fs.writeFileSync(out, layerPositions(layer.layerToString(), frames.map(Number)));
const stage = new library.TinyUSDZLoaderNative();
read(stage, "loadFromBinary", bytes);
fs.writeFileSync(`${out}.stage`, stageMeshes(stage));
