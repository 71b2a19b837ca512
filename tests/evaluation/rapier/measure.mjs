// Measures Rapier's soft bodies on what `time_and_error swing-soft --export FILE` writes; tests/evaluation/tradeoff calls it.
//   measure.mjs FILE          one line of JSON for each setting: CPU time of a second of motion, and error of positions
//   measure.mjs FILE --cuts   one for each curve of the file: CPU time of a cut of an uncut sheet, and the lips it left
// Rapier is WebAssembly here, in single precision and on one thread.
import { readFileSync } from "node:fs";
import RAPIER from "@dimforge/rapier3d-compat";

await RAPIER.init();
const scene = JSON.parse(readFileSync(process.argv[2], "utf8"));
const CELLS = scene.side - 1;
const BLADES = 8; // of a curve; more make the cut hardly closer, and each takes its time
const CUT_PASSES = 5; // the least time counts
const LONGEST_S = 60; // CPU time after which a run is given up
const BORDER = 1e-4; // m, within which a lip lies on the sheet's own border

// Hz, with which edges inside the sheet are springs of E t / (1 - nu^2), 1099 N/m: sqrt(k / m) / 2 pi, m of two ends.
const AS_STIFF = Math.sqrt(1000 / 0.91 / (0.2 / CELLS ** 2 / 2)) / (2 * Math.PI);
// Steps of a tick, and sweeps of each beyond the first. Without `hz` the cloth is as it comes: 30 Hz, critically damped, and
// with edges across bends, which the sheet of the file has next to no stiffness for.
const SETTINGS = [
  { name: "as it comes", steps: 4, sweeps: 3 },
  { name: "4 x 4 sweeps", steps: 4, sweeps: 3, hz: AS_STIFF },
  { name: "4 x 21 sweeps", steps: 4, sweeps: 20, hz: AS_STIFF },
  { name: "16 x 4 sweeps", steps: 16, sweeps: 3, hz: AS_STIFF },
  { name: "64 x 1 sweeps", steps: 64, sweeps: 0, hz: AS_STIFF },
  { name: "64 x 4 sweeps", steps: 64, sweeps: 3, hz: AS_STIFF },
  { name: "256 x 1 sweeps", steps: 256, sweeps: 0, hz: AS_STIFF },
];

function cpuSeconds() {
  const { user, system } = process.cpuUsage();
  return 1e-6 * (user + system);
}

// The sheet of the file with Rapier's own cloth, and where its particles are at rest, by body.
class Sheet {
  constructor(setting) {
    const [x, y, z] = scene.gravity;
    this.world = new RAPIER.World({ x, y, z });
    this.world.timestep = scene.tick_s;
    this.world.numSolverIterations = setting.steps;
    const cell = 1 / CELLS;
    const cloth = RAPIER.SoftBodyDesc.cloth({ x: 0, y: 0, z: 0 }, { x: 0, y: cell, z: 0 }, { x: cell, y: 0, z: 0 },
      scene.side, scene.side)
      .setMasses(scene.mass_kg)
      .setPinnedParticles(scene.pins)
      .setNoSurfaceCollider()
      .setCanSleep(false)
      .setAdditionalPgsIterations(setting.sweeps);
    if (setting.hz) {
      const material = new RAPIER.SoftBodyMaterial();
      material.edgeSoftness = { naturalFrequency: setting.hz, dampingRatio: 0 };
      cloth.setMaterial(material).setBendEdges([]);
    }
    const body = this.world.createSoftBody(cloth);
    const at = (i) => [(i % scene.side) / CELLS, Math.floor(i / scene.side) / CELLS];
    this.rest = new Map([[body.handle, Array.from({ length: scene.side ** 2 }, (_, i) => at(i))]]);
  }

  bodies() {
    return this.world.softBodies.getAll();
  }

  numParticles() {
    return this.bodies().reduce((sum, body) => sum + body.numParticles(), 0);
  }

  // Makes one blade of each stretch of the curve; returns the CPU time, s.
  cut(curve) {
    const stretch = (curve.length - 1) / BLADES;
    let seconds = 0;
    for (let i = 0; i < BLADES; ++i) {
      const blade = bladeThrough(curve[i * stretch], curve[(i + 1) * stretch]);
      for (const body of this.bodies()) {
        const begin = cpuSeconds();
        const event = this.world.cutSoftBody(body, blade);
        seconds += cpuSeconds() - begin;
        if (event) this.follow(body.handle, event);
      }
    }
    return seconds;
  }

  follow(handle, event) {
    const rest = this.rest.get(handle);
    const split = event.splitParticles(); // copy, source
    for (let i = 0; i < split.length; i += 2) rest[split[i]] = rest[split[i + 1]];
    for (let piece = 0; piece < event.numPieces(); ++piece) {
      this.rest.set(event.pieceSoftBody(piece), Array.from(event.pieceParticles(piece), (i) => rest[i]));
    }
    event.free();
  }

  // Triangles of all bodies: three corners at rest, and three places.
  triangles() {
    return this.bodies().flatMap((body) => {
      const rest = this.rest.get(body.handle);
      const corners = body.boundary();
      const x = body.particlePositions();
      return Array.from({ length: corners.length / 3 }, (_, t) => {
        const ids = [...corners.subarray(3 * t, 3 * t + 3)];
        return { body: body.handle, ids, rest: ids.map((i) => rest[i]), places: ids.map((i) => x.subarray(3 * i, 3 * i + 3)) };
      });
    });
  }

  // Edges with a triangle on one side alone. The sheet's own border is left out.
  lips() {
    const sides = new Map();
    for (const { body, ids, rest } of this.triangles()) {
      for (let k = 0; k < 3; ++k) {
        const next = (k + 1) % 3;
        const key = [body, Math.min(ids[k], ids[next]), Math.max(ids[k], ids[next])].join();
        sides.set(key, sides.has(key) ? null : [...rest[k], ...rest[next]]);
      }
    }
    const isBorder = ([ax, ay, bx, by]) => [[ax, bx], [ay, by]].some(([a, b]) =>
      [0, 1].some((side) => Math.abs(a - side) < BORDER && Math.abs(b - side) < BORDER));
    return [...sides.values()].filter((edge) => edge && !isBorder(edge));
  }
}

// A triangle that cuts the plane of the sheet from a to b.
function bladeThrough(a, b) {
  const [x, y] = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  return [{ x, y, z: 1 }, { x: 2 * a[0] - x, y: 2 * a[1] - y, z: -1 }, { x: 2 * b[0] - x, y: 2 * b[1] - y, z: -1 }];
}

// Weights of the corners of a triangle at a point in the plane.
function weightsAt([x, y], [a, b, c]) {
  const area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
  const second = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
  const third = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
  return [1 - second - third, second, third];
}

// Root of the mean square, and the largest, distance from the file's places, m.
function errors(sheet) {
  const triangles = sheet.triangles();
  let [sum, count, largest] = [0, 0, 0];
  scene.points.forEach((point, i) => {
    if (scene.places[i][0] === null) return;
    for (const { rest, places } of triangles) {
      const weights = weightsAt(point, rest);
      if (Math.min(...weights) < -1e-6) continue;
      const place = [0, 1, 2].map((axis) => weights.reduce((at, weight, k) => at + weight * places[k][axis], 0));
      const distance = Math.hypot(...place.map((each, axis) => each - scene.places[i][axis]));
      sum += distance ** 2;
      largest = Math.max(largest, distance);
      ++count;
      break;
    }
  });
  return { rms: Math.sqrt(sum / count), largest };
}

function swing(setting, ticks) {
  const sheet = new Sheet(setting);
  for (const curve of scene.curves) sheet.cut(curve);
  let [seconds, done] = [0, 0];
  for (; done < ticks && seconds < LONGEST_S; ++done) {
    const begin = cpuSeconds();
    sheet.world.step();
    seconds += cpuSeconds() - begin;
  }
  const row = { family: "Rapier soft body", setting: setting.name, default: false, side: scene.side, cuts: scene.cuts,
    vertices: sheet.numParticles(), cpu_s_per_s: seconds / (done * scene.tick_s) };
  if (done === ticks) {
    const { rms, largest } = errors(sheet);
    Object.assign(row, { rms_mm: 1e3 * rms, largest_mm: 1e3 * largest });
  }
  sheet.world.free();
  return row;
}

// Passes over all curves, as the first cuts of a process take twice the time of later ones.
function cutsAlone() {
  const rows = scene.curves.map((curve) => ({ family: "Rapier soft body", curve, ms: Infinity }));
  for (let pass = 0; pass < CUT_PASSES; ++pass) {
    for (const row of rows) {
      const sheet = new Sheet(SETTINGS[0]);
      row.ms = Math.min(row.ms, 1e3 * sheet.cut(row.curve));
      Object.assign(row, { lips: sheet.lips(), new_vertices: sheet.numParticles() - scene.side ** 2 });
      sheet.world.free();
    }
  }
  return rows;
}

swing(SETTINGS[0], Math.min(scene.ticks, 6)); // compiles what the first run would else pay for
const rows = process.argv.includes("--cuts") ? cutsAlone() : SETTINGS.map((setting) => swing(setting, scene.ticks));
for (const row of rows) console.log(JSON.stringify(row));
