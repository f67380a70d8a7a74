// What the checks of all players share: cases and their truth, a painter, and scores.
const fs = require("fs"), path = require("path");
const { PNG } = require("pngjs");

exports.cases = (folder) => JSON.parse(fs.readFileSync(path.join(folder, "cases.json"))).map((name) => {
  const at = (file) => path.join(folder, name, file);
  const json = (file) => JSON.parse(fs.readFileSync(at(file)));
  return { name, at, json, truth: json("truth.json"), texture: () => PNG.sync.read(fs.readFileSync(at("texture.png"))) };
});

// Draws textured triangles in their order, each pixel whose centre they hold, into premultiplied floats.
exports.paint = (texture, points, uvs, triangles, [width, height]) => {
  const out = new Float32Array(width * height * 4);
  const texel = (x, y, c) => {
    const i = 4 * (Math.min(Math.max(y, 0), texture.height - 1) * texture.width + Math.min(Math.max(x, 0), texture.width - 1));
    return c < 3 ? (texture.data[i + c] * texture.data[i + 3]) / 255 : texture.data[i + 3];
  };
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [triangles[t], triangles[t + 1], triangles[t + 2]];
    const [ax, ay, bx, by, cx, cy] = [a, b, c].flatMap((v) => [points[2 * v], points[2 * v + 1]]);
    const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (Math.abs(area) < 1e-9) continue;
    const x0 = Math.max(0, Math.floor(Math.min(ax, bx, cx))), x1 = Math.min(width - 1, Math.ceil(Math.max(ax, bx, cx)));
    const y0 = Math.max(0, Math.floor(Math.min(ay, by, cy))), y1 = Math.min(height - 1, Math.ceil(Math.max(ay, by, cy)));
    for (let y = y0; y <= y1; y++) for (let x = x0; x <= x1; x++) {
      const px = x + 0.5, py = y + 0.5;
      const wb = ((px - ax) * (cy - ay) - (py - ay) * (cx - ax)) / area;
      const wc = ((bx - ax) * (py - ay) - (by - ay) * (px - ax)) / area;
      const wa = 1 - wb - wc;
      if (wa < 0 || wb < 0 || wc < 0) continue;
      const u = (wa * uvs[2 * a] + wb * uvs[2 * b] + wc * uvs[2 * c]) * texture.width - 0.5;
      const v = (wa * uvs[2 * a + 1] + wb * uvs[2 * b + 1] + wc * uvs[2 * c + 1]) * texture.height - 0.5;
      const iu = Math.floor(u), iv = Math.floor(v), fu = u - iu, fv = v - iv;
      const sample = [0, 1, 2, 3].map((k) =>
        (texel(iu, iv, k) * (1 - fu) + texel(iu + 1, iv, k) * fu) * (1 - fv) +
        (texel(iu, iv + 1, k) * (1 - fu) + texel(iu + 1, iv + 1, k) * fu) * fv);
      const o = 4 * (y * width + x), keep = 1 - sample[3] / 255;
      for (let k = 0; k < 4; k++) out[o + k] = sample[k] + out[o + k] * keep;
    }
  }
  return out;
};

// The same with rims that are smooth: nine samples a pixel.
exports.smooth = (texture, points, uvs, triangles, [width, height]) => {
  const fine = exports.paint(texture, points.map((p) => 3 * p), uvs, triangles, [3 * width, 3 * height]);
  const out = new Float32Array(width * height * 4);
  for (let y = 0; y < 3 * height; y++) for (let x = 0; x < 3 * width; x++) for (let k = 0; k < 4; k++)
    out[4 * (Math.floor(y / 3) * width + Math.floor(x / 3)) + k] += fine[4 * (y * 3 * width + x) + k] / 9;
  return out;
};

exports.premultiplied = (png) => Float32Array.from(png.data, (v, i) => (i % 4 < 3 ? (v * png.data[i - (i % 4) + 3]) / 255 : v));

// The mean difference over pixels that either picture shows, and over all.
exports.difference = (a, b) => {
  let sum = 0, shown = 0;
  for (let i = 0; i < a.length; i += 4) {
    if (a[i + 3] === 0 && b[i + 3] === 0) continue;
    shown++;
    for (let k = 0; k < 4; k++) sum += Math.abs(a[i + k] - b[i + k]) / 4;
  }
  return { shown: shown ? sum / shown : 0, all: sum / (a.length / 4) };
};

// Places of vertices that came along with others' coordinates in the texture: matched to the mesh's by those.
exports.match = (truth, uvs) => {
  const [width, height] = truth.size;
  const key = (x, y) => Math.round(x * 4) + "," + Math.round(y * 4);
  const cells = new Map();
  for (let v = 0; v < truth.rest.length / 2; v++) {
    const k = key(truth.rest[2 * v], truth.rest[2 * v + 1]);
    cells.set(k, [...(cells.get(k) || []), v]);
  }
  return Array.from({ length: uvs.length / 2 }, (_, i) => {
    const x = uvs[2 * i] * width, y = uvs[2 * i + 1] * height;
    let best = -1, gap = Infinity;
    for (let dx = -1; dx <= 1; dx++) for (let dy = -1; dy <= 1; dy++)
      for (const v of cells.get(key(x + dx / 4, y + dy / 4)) || []) {
        const d = Math.hypot(truth.rest[2 * v] - x, truth.rest[2 * v + 1] - y);
        if (d < gap) [best, gap] = [v, d];
      }
    if (gap > 0.05) throw new Error(`a vertex at ${x}, ${y} of the texture is none of the mesh's`);
    return best;
  });
};

// Scores of one case: `frame(f)` gives { points, uvs, triangles } in the picture's pixels.
exports.score = (name, one, frame, pictures = 8) => {
  const { truth } = one, frames = truth.frames.length;
  const truthUvs = truth.rest.map((v, i) => v / truth.size[i % 2]);
  const texture = one.texture();
  let most = 0, sum = 0, count = 0, worst = { shown: 0, all: 0 }, matched = null;
  const every = Math.max(1, Math.floor(frames / pictures));
  for (let f = 0; f < frames; f++) {
    const own = frame(f);
    matched = matched || exports.match(truth, own.uvs);
    if (new Set(matched).size !== new Set(truth.orders[0]).size) throw new Error("vertices are missing");
    matched.forEach((v, i) => {
      const off = Math.hypot(own.points[2 * i] - truth.frames[f][2 * v], own.points[2 * i + 1] - truth.frames[f][2 * v + 1]);
      if (!(off <= most)) most = off;
      sum += off;
      count++;
    });
    if (f % every === 0) {
      const mine = exports.paint(texture, truth.frames[f], truthUvs, truth.orders[truth.order_of[f]], truth.size);
      const theirs = exports.paint(texture, own.points, own.uvs, own.triangles, truth.size);
      const difference = exports.difference(mine, theirs);
      if (difference.shown > worst.shown) worst = difference;
    }
  }
  const good = most <= 0.5 && sum / count <= 0.1 && worst.shown <= 2;
  console.log(`${good ? "ok  " : "FAIL"} ${name}: ${frames} frames, vertices off by ${(sum / count).toFixed(3)} px on average, ` +
    `${most.toFixed(3)} at most; pictures by ${worst.shown.toFixed(2)} of 255 where there is a drawing, ${worst.all.toFixed(2)} overall`);
  if (!good) process.exitCode = 1;
};
