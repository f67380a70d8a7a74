// A reader of Spine's JSON, written from the format's public description: bones, weighted meshes, deform keys, draw order.
const fs = require("fs");
const common = require("./common.js");

const between = (keys, time, values) => {
  // The values at a time; stepped keys hold.
  let k = keys.findIndex((key) => (key.time || 0) > time + 1e-9);
  if (k === 0) return values(keys[0], keys[0], 0);
  if (k < 0) return values(keys[keys.length - 1], keys[keys.length - 1], 0);
  const a = keys[k - 1], b = keys[k], start = a.time || 0;
  return values(a, b, a.curve === "stepped" ? 0 : Math.max(0, (time - start) / (b.time - start)));
};
const mixed = (key, usual) => (a, b, t) => (a[key] ?? usual) * (1 - t) + (b[key] ?? usual) * t;

function pose(scene, time) {
  const animation = scene.animations.take, world = {};
  const list = scene.bones.map((bone) => {
    const lines = (animation.bones || {})[bone.name] || {};
    const get = (line, key, usual) => (lines[line] ? between(lines[line], time, mixed(key, usual)) : usual);
    const turn = (((bone.rotation || 0) + get("rotate", "value", 0)) * Math.PI) / 180;
    const sx = (bone.scaleX ?? 1) * get("scale", "x", 1), sy = (bone.scaleY ?? 1) * get("scale", "y", 1);
    const x = (bone.x || 0) + get("translate", "x", 0), y = (bone.y || 0) + get("translate", "y", 0);
    const own = [Math.cos(turn) * sx, -Math.sin(turn) * sy, Math.sin(turn) * sx, Math.cos(turn) * sy, x, y];
    if (!bone.parent) return (world[bone.name] = own);
    const [a, b, c, d, px, py] = world[bone.parent];
    return (world[bone.name] = [
      a * own[0] + b * own[2], a * own[1] + b * own[3], c * own[0] + d * own[2], c * own[1] + d * own[3],
      a * x + b * y + px, c * x + d * y + py]);
  });
  return { list, animation };
}

function drawOrder(scene, animation, time) {
  const count = scene.slots.length, keys = (animation.drawOrder || []).filter((k) => (k.time || 0) <= time + 1e-9);
  const offsets = keys.length ? keys[keys.length - 1].offsets || [] : [];
  const order = new Array(count).fill(-1), moved = new Set();
  for (const { slot, offset } of offsets) {
    const index = scene.slots.findIndex((s) => s.name === slot);
    order[index + offset] = index;
    moved.add(index);
  }
  const others = scene.slots.map((_, i) => i).filter((i) => !moved.has(i));
  return order.map((slot) => (slot < 0 ? others.shift() : slot));
}

for (const one of common.cases(process.argv[2])) {
  const { truth } = one, scene = one.json("spine.json"), height = truth.size[1];
  const skin = scene.skins.find((s) => s.name === "default").attachments;
  const [page, size, , region, bounds] = fs.readFileSync(one.at("spine.atlas"), "utf8").split("\n");
  const whole = truth.size.join(",");
  if (page !== "spine.png" || size !== `size:${whole}` || bounds !== `bounds:0,0,${whole}`) throw new Error("the atlas is not the picture");
  common.score(`Spine, ${one.name}, ${fs.statSync(one.at("spine.json")).size} bytes`, one, (f) => {
    const time = f / truth.fps, { list, animation } = pose(scene, time);
    const all = { points: [], uvs: [], triangles: [], base: [] };
    scene.slots.forEach((slot) => {
      const mesh = skin[slot.name][slot.attachment];
      if (mesh.type !== "mesh" || mesh.path !== region) throw new Error("an attachment is no mesh of the page");
      const keys = (((animation.attachments || {}).default || {})[slot.name] || {})[slot.attachment];
      const deform = keys ? between(keys.deform, time, (a, b, t) => {
        const told = (key, i) => (key.vertices || [])[i - (key.offset || 0)] || 0;
        return (i) => told(a, i) * (1 - t) + told(b, i) * t;
      }) : () => 0;
      all.base.push(all.points.length / 2);
      for (let i = 0, d = 0; i < mesh.vertices.length; ) {
        let x = 0, y = 0;
        for (let n = mesh.vertices[i++]; n > 0; n--, i += 4, d += 2) {
          const [a, b, c, e, px, py] = list[mesh.vertices[i]], w = mesh.vertices[i + 3];
          const vx = mesh.vertices[i + 1] + deform(d), vy = mesh.vertices[i + 2] + deform(d + 1);
          x += w * (a * vx + b * vy + px);
          y += w * (c * vx + e * vy + py);
        }
        all.points.push(x, height - y);
      }
      all.uvs.push(...mesh.uvs);
    });
    for (const slot of drawOrder(scene, animation, time)) {
      const s = scene.slots[slot];
      all.triangles.push(...skin[s.name][s.attachment].triangles.map((v) => v + all.base[slot]));
    }
    return all;
  });
}
