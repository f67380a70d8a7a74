/*
 * soak.c: random calls on the C library, right and wrong, in any order.
 *
 *   soak CLIP STROKES.json FOLDER SEED CALLS
 *
 * Whatever is called, with live, dead and made-up ids, NULL, NaN, short buffers, absurd counts and wrong sizes: the
 * answer must be a status that the library knows, an error must come with words, and never may it be a defect of the
 * library (MRY_E_PANIC, MRY_E_POISONED). What is more is left to who watches: sanitizers, valgrind, the exit status.
 * The same seed makes the same calls with one compiler; what jobs come to depends on time. Files are written into
 * FOLDER and the folder that it runs in.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <marey/marey.h>

enum { CLIP, RIG, MOTION, MASKS, CREATURE, JOB, MAP, SESSION, DEFORMATION, CHARACTER, POSER, POSES, TAKE, POINTS, DRAWING, BINDING, SKETCH, CROWD, SOLID, KINDS };
enum { PLACES = 6, BYTES = 1 << 15 };

typedef struct soak {
  mry_context *context;
  /* Ids that were alive once; the older half may be dead. */
  uint64_t ids[KINDS][PLACES];
  uint64_t random;
  uint64_t job_count, good, refused;
  /* Whether the lender of memory now and then has none. */
  int stingy;
  const char *clip, *strokes, *folder;
  mry_error err;
  _Alignas(16) unsigned char bytes[BYTES];
} soak;

/* SplitMix64 (Steele, Lea, Flood 2014). */
static uint64_t next(soak *s) {
  uint64_t z = s->random += UINT64_C(0x9e3779b97f4a7c15);
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return z ^ (z >> 31);
}

static uint32_t below(soak *s, uint32_t n) { return (uint32_t)(next(s) % n); }

static mry_status end(soak *s, int kind, uint64_t v) {
  switch (kind) {
    case CLIP: return mry_clip_close(s->context, (mry_clip){ v });
    case RIG: return mry_rig_destroy(s->context, (mry_rig){ v });
    case MOTION: return mry_motion_destroy(s->context, (mry_motion){ v });
    case MASKS: return mry_masks_destroy(s->context, (mry_masks){ v });
    case CREATURE: return mry_creature_destroy(s->context, (mry_creature){ v });
    case JOB: return mry_job_destroy(s->context, (mry_job){ v });
    case SESSION: return mry_session_destroy(s->context, (mry_session){ v });
    case DEFORMATION: return mry_deformation_destroy(s->context, (mry_deformation){ v });
    case CHARACTER: return mry_character_destroy(s->context, (mry_character){ v });
    case POSER: return mry_poser_destroy(s->context, (mry_poser){ v });
    case POSES: return mry_poses_destroy(s->context, (mry_poses){ v });
    case TAKE: return mry_take_destroy(s->context, (mry_take){ v });
    case POINTS: return mry_control_points_destroy(s->context, (mry_control_points){ v });
    case DRAWING: return mry_drawing_destroy(s->context, (mry_drawing){ v });
    case BINDING: return mry_binding_destroy(s->context, (mry_binding){ v });
    case SKETCH: return mry_sketch_take_destroy(s->context, (mry_sketch_take){ v });
    case CROWD: return mry_crowd_destroy(s->context, (mry_crowd){ v });
    case SOLID: return mry_solid_destroy(s->context, (mry_solid){ v });
    default: return mry_unmap(s->context, (mry_map){ v });
  }
}

/* Keeps a new object in the place of an old one. */
static void keep(soak *s, int kind, uint64_t v) {
  if (v != 0) {
    uint64_t *place = &s->ids[kind][below(s, PLACES)];
    end(s, kind, *place);
    *place = v;
  }
}

/* An id: mostly one that was alive once, now and then of another kind, null or made up. */
static uint64_t id(soak *s, int kind) {
  uint32_t dice = below(s, 64);
  if (dice == 0) {
    return 0;
  }
  if (dice == 1) {
    return next(s);
  }
  return s->ids[dice == 2 ? (int)below(s, KINDS) : kind][below(s, PLACES)];
}

/* A number: mostly small, now and then absurd. */
static uint32_t number(soak *s, uint32_t n) { return below(s, 40) == 0 ? (uint32_t)next(s) : below(s, n); }
static uint64_t frame(soak *s) { return below(s, 40) == 0 ? next(s) : below(s, 9); }
static uint64_t pose(soak *s) { return below(s, 6) == 0 ? MRY_REST_POSE : frame(s); }

static float real(soak *s) {
  static const float odd[] = { NAN, INFINITY, -INFINITY, 1e30f, -0.0f, 1e-40f };
  return below(s, 50) == 0 ? odd[below(s, 6)] : (float)below(s, 1000) / 10.0f;
}

static mry_str text(soak *s) {
  static const char *const texts[] = { "body", "hind", "fore", "tail", "\xff\xfe", "", "{}", "space-time", "layered" };
  static const char with_nul[] = { 'a', 0, 'b' };
  uint32_t dice = below(s, 12);
  if (dice == 0) {
    return (mry_str){ with_nul, sizeof with_nul };
  }
  if (dice == 1) {
    return (mry_str){ NULL, below(s, 2) == 0 ? 0 : MRY_STRZ };
  }
  return MRY_STR(texts[below(s, 9)]);
}

/* A place in FOLDER to write to; the same few, so that things get in each other's way. */
static mry_str place(soak *s, char name[300], const char *extension) {
  snprintf(name, 300, "%s/%u%s", s->folder, (unsigned)below(s, 3), extension);
  return below(s, 30) == 0 ? text(s) : MRY_STR(name);
}

static void *out(soak *s) { return below(s, 60) == 0 ? NULL : s->bytes; }
/* How many things of `size` bytes fit where out() points, or fewer. */
static size_t room(soak *s, size_t size) { return below(s, 3) == 0 ? below(s, 5) : BYTES / size; }

static const mry_point *points(soak *s, mry_point p[8]) {
  for (int i = 0; i < 8; i++) {
    p[i] = (mry_point){ real(s), real(s) };
  }
  return below(s, 60) == 0 ? NULL : p;
}

/* A struct_size: mostly right. */
#define SIZED(type, value) \
  ((value)->struct_size = below(s, 40) == 0 ? number(s, 200) % (uint32_t)(sizeof(type) + 1) : (uint32_t)sizeof(type))

#define ERR (below(s, 10) == 0 ? NULL : &s->err)

static mry_status edit_rig(soak *s) {
  mry_point p[8];
  char name[300];
  uint32_t limb = 0;
  size_t count = 0;
  float length = 0;
  mry_rig rig = { id(s, RIG) };
  switch (below(s, 19)) {
    case 16:
      return mry_rig_set_depth(s->context, rig, number(s, 4), frame(s), number(s, 4), real(s), real(s), ERR);
    case 17: return mry_rig_get_depth(s->context, rig, number(s, 4), frame(s), out(s), NULL, NULL, ERR);
    case 0: return mry_rig_add_limb(s->context, rig, text(s), (int32_t)number(s, 5), &limb, ERR);
    case 1: return mry_rig_get_limb_count(s->context, rig, out(s), ERR);
    case 2: return mry_rig_get_limb(s->context, rig, number(s, 4), out(s), room(s, 1), &count, NULL, ERR);
    case 3:
    case 4:
    case 5:
      return mry_rig_set_stroke(s->context, rig, number(s, 4), frame(s), points(s, p), below(s, 9),
                                (int32_t)number(s, 4), ERR);
    case 6: return mry_rig_remove_stroke(s->context, rig, number(s, 4), frame(s), ERR);
    case 7:
      return mry_rig_get_stroke(s->context, rig, number(s, 4), frame(s), out(s), room(s, sizeof(mry_point)), &count,
                                NULL, ERR);
    case 8: return mry_rig_get_keyframes(s->context, rig, out(s), room(s, 8), &count, ERR);
    case 9:
      return mry_rig_add_paint(s->context, rig, frame(s), (int32_t)number(s, 3), real(s), points(s, p), below(s, 9),
                               ERR);
    case 10: return mry_rig_clear_paint(s->context, rig, frame(s), ERR);
    case 11: return mry_rig_set_mask(s->context, rig, frame(s), below(s, 2) == 0 ? MRY_STR("") : place(s, name, ".png"), ERR);
    case 15:
      return mry_rig_paint_mask(s->context, rig, frame(s), out(s), room(s, 1), number(s, 200), place(s, name, ".png"), ERR);
    case 12: return mry_rig_get_length_hint(s->context, rig, number(s, 4), &length, ERR);
    case 13: return mry_rig_validate(s->context, rig, (mry_clip){ below(s, 2) == 0 ? 0 : id(s, CLIP) }, ERR);
    case 14: return mry_rig_to_json(s->context, rig, out(s), room(s, 1), &count, ERR);
    default: return mry_rig_write(s->context, rig, place(s, name, ".json"), ERR);
  }
}

static mry_status make_rig(soak *s) {
  mry_rig rig = { 0 };
  mry_status status;
  switch (below(s, 3)) {
    case 0: status = mry_rig_create(s->context, number(s, 99), number(s, 99), &rig, ERR); break;
    case 1: status = mry_rig_from_json(s->context, text(s), &rig, ERR); break;
    default: status = mry_rig_read(s->context, MRY_STR(s->strokes), &rig, ERR); break;
  }
  keep(s, RIG, rig.v);
  return status;
}

static mry_status use_clip(soak *s) {
  mry_clip clip = { id(s, CLIP) };
  mry_clip_info info = MRY_CLIP_INFO_INIT;
  mry_image_view view = MRY_IMAGE_VIEW_INIT;
  mry_clip_options options = MRY_CLIP_OPTIONS_INIT;
  double seconds = 0;
  size_t count = 0;
  mry_status status;
  switch (below(s, 7)) {
    case 0: SIZED(mry_clip_info, &info); return mry_clip_get_info(s->context, clip, &info, ERR);
    case 1: return mry_clip_get_time(s->context, clip, frame(s), &seconds, ERR);
    case 2: return mry_clip_get_warning(s->context, clip, number(s, 2), out(s), room(s, 1), &count, ERR);
    case 3: return mry_clip_read_frame(s->context, clip, frame(s), out(s), room(s, 1), number(s, 999), ERR);
    case 5: return mry_clip_read_alpha(s->context, clip, frame(s), out(s), room(s, 1), number(s, 999), ERR);
    case 4:
      SIZED(mry_image_view, &view);
      status = mry_clip_map_frame(s->context, clip, frame(s), &view, ERR);
      if (status == MRY_OK) {
        s->good += view.data[below(s, (uint32_t)view.stride_bytes * view.height)] % 2u;
        keep(s, MAP, view.map.v);
      }
      return status;
    default:
      clip.v = 0;
      SIZED(mry_clip_options, &options);
      /* Starting a program for what is no clip takes longer than a thousand calls. */
      options.no_ffmpeg = below(s, 99) == 0 ? number(s, 2) : 1;
      options.images_fps = (double)real(s);
      options.max_pixels = number(s, 100000);
      status = mry_clip_open(s->context, below(s, 4) == 0 ? text(s) : MRY_STR(s->clip), &options, &clip, ERR);
      keep(s, CLIP, clip.v);
      return status;
  }
}

static mry_status use_motion(soak *s) {
  char name[300];
  mry_motion motion = { id(s, MOTION) }, read = { 0 };
  mry_motion_info info = MRY_MOTION_INFO_INIT;
  mry_correction correction = MRY_CORRECTION_INIT;
  uint32_t a = 0, b = 0;
  size_t count = 0, capacity = room(s, sizeof(mry_point));
  mry_status status;
  switch (below(s, 10)) {
    case 0: SIZED(mry_motion_info, &info); return mry_motion_get_info(s->context, motion, &info, ERR);
    case 1: return mry_motion_get_track(s->context, motion, number(s, 4), out(s), room(s, 1), &count, NULL, NULL, ERR);
    case 2: return mry_motion_find_track(s->context, motion, text(s), &a, ERR);
    case 3:
      return mry_motion_read_frame(s->context, motion, number(s, 4), frame(s), out(s), NULL, NULL, capacity, &count, ERR);
    case 4: return mry_motion_get_bone(s->context, motion, number(s, 4), &a, &b, ERR);
    case 5:
      return mry_motion_get_correction(s->context, motion, (mry_rig){ below(s, 2) == 0 ? 0 : id(s, RIG) }, number(s, 4),
                                       &correction, ERR);
    case 6: return mry_motion_to_json(s->context, motion, out(s), room(s, 1), &count, ERR);
    case 7: return mry_motion_write(s->context, motion, place(s, name, ".json"), ERR);
    case 8:
      return mry_motion_get_report(s->context, motion, (mry_clip){ id(s, CLIP) }, (mry_rig){ id(s, RIG) }, out(s),
                                   room(s, 1), &count, ERR);
    default:
      status = mry_motion_read(s->context, place(s, name, ".json"), &read, ERR);
      keep(s, MOTION, read.v);
      return status;
  }
}

static mry_status edit_motion(soak *s) {
  mry_point p[8];
  mry_motion motion = { id(s, MOTION) }, made = { 0 };
  uint32_t track = 0;
  uint8_t visible[8] = { 1, 0, 1 };
  float confidence[8];
  mry_status status;
  switch (below(s, 8)) {
    case 0: status = mry_motion_create(s->context, number(s, 99), number(s, 99), frame(s), (double)real(s), &made, ERR); break;
    case 1: status = mry_motion_copy(s->context, motion, &made, ERR); break;
    case 2: return mry_motion_add_track(s->context, motion, text(s), (int32_t)number(s, 5), number(s, 9), &track, ERR);
    case 3: return mry_motion_remove_track(s->context, motion, number(s, 4), ERR);
    case 4: return mry_motion_add_bone(s->context, motion, number(s, 4), number(s, 4), ERR);
    case 5: return mry_motion_remove_bone(s->context, motion, number(s, 4), ERR);
    default:
      for (int i = 0; i < 8; i++) {
        confidence[i] = real(s) / 50.0f;
      }
      return mry_motion_set_frame(s->context, motion, number(s, 4), frame(s), points(s, p),
                                  below(s, 2) == 0 ? visible : NULL, below(s, 2) == 0 ? confidence : NULL,
                                  below(s, 9), ERR);
  }
  keep(s, MOTION, made.v);
  return status;
}

static mry_status retime(soak *s) {
  mry_retime_desc how = MRY_RETIME_DESC_INIT;
  const mry_time_key keys[2] = { { 0.0, 0.0, (int32_t)number(s, 6), 0 }, { (double)real(s), (double)real(s), 0, 0 } };
  mry_motion motion = { 0 };
  mry_creature creature = { 0 };
  mry_take take = { 0 };
  mry_sketch_take sketch = { 0 };
  size_t count = 0;
  mry_status status;
  how.direction = (int32_t)number(s, 4);
  how.speed = 1.0 + (double)real(s);
  how.easing = (int32_t)number(s, 6);
  how.hold = below(s, 3);
  how.closed = number(s, 2);
  how.keys = keys;
  how.key_count = below(s, 3);
  switch (below(s, 5)) {
    case 0: status = mry_motion_retime(s->context, (mry_motion){ id(s, MOTION) }, &how, &motion, ERR); break;
    case 1: status = mry_creature_retime(s->context, (mry_creature){ id(s, CREATURE) }, &how, &creature, ERR); break;
    case 2: status = mry_take_retime(s->context, (mry_take){ id(s, TAKE) }, &how, &take, ERR); break;
    case 3: status = mry_sketch_take_retime(s->context, (mry_sketch_take){ id(s, SKETCH) }, &how, &sketch, ERR); break;
    default:
      return mry_retime_read_places(s->context, number(s, 99), 24.0, below(s, 4) == 0 ? NULL : &how, out(s), room(s, sizeof(double)), &count, ERR);
  }
  keep(s, MOTION, motion.v);
  keep(s, CREATURE, creature.v);
  keep(s, TAKE, take.v);
  keep(s, SKETCH, sketch.v);
  return status;
}

static mry_status shape_motion(soak *s) {
  static const uint64_t frames[] = { 0, 2, 99 };
  mry_motion motion = { id(s, MOTION) }, creature = { id(s, MOTION) }, made = { 0 };
  mry_cycle cycle = MRY_CYCLE_INIT;
  mry_seam seam = MRY_SEAM_INIT;
  mry_loop_desc closing = MRY_LOOP_DESC_INIT;
  mry_smooth_desc smoothing = MRY_SMOOTH_DESC_INIT;
  mry_plant_desc planting = MRY_PLANT_DESC_INIT;
  mry_limb_map_desc mapping = MRY_LIMB_MAP_DESC_INIT;
  const mry_str feet[2] = { text(s), text(s) };
  size_t count = 0;
  mry_status status;
  planting.closed = number(s, 2);
  planting.ground = (double)real(s);
  planting.has_ground = number(s, 2);
  planting.feet = feet;
  planting.foot_count = below(s, 3);
  mapping.angles = (int32_t)number(s, 3);
  mapping.faces = (int32_t)number(s, 4);
  mapping.stretch = below(s, 3) == 0 ? (double)real(s) : 0.0;
  mapping.map = below(s, 9) == 0 ? text(s) : MRY_STR("");
  switch (below(s, 9)) {
    case 0: SIZED(mry_cycle, &cycle); return mry_motion_find_cycle(s->context, motion, &cycle, ERR);
    case 1: return mry_motion_read_phases(s->context, motion, out(s), NULL, room(s, sizeof(double)), &count, ERR);
    case 2:
      SIZED(mry_loop_desc, &closing);
      closing.period = (double)real(s) / 10.0;
      closing.frame_count = number(s, 20);
      status = mry_motion_loop(s->context, motion, below(s, 4) == 0 ? NULL : &closing, &made, below(s, 2) == 0 ? NULL : &seam, ERR);
      break;
    case 3:
      smoothing.period = (double)real(s);
      smoothing.only_frames = number(s, 2);
      smoothing.frames = frames;
      smoothing.frame_count = below(s, 4);
      status = mry_motion_smooth(s->context, motion, &smoothing, &made, ERR);
      break;
    case 4: status = mry_motion_plant(s->context, motion, below(s, 4) == 0 ? NULL : &planting, &made, ERR); break;
    case 5: return mry_motion_get_contacts(s->context, motion, &planting, out(s), room(s, 1), &count, ERR);
    case 6: return retime(s);
    case 7: status = mry_motion_map_limbs(s->context, motion, creature, &mapping, &made, ERR); break;
    default: return mry_motion_match_limbs(s->context, motion, creature, &mapping, out(s), room(s, 1), &count, ERR);
  }
  keep(s, MOTION, made.v);
  return status;
}

static mry_status use_masks(soak *s) {
  mry_masks masks = { id(s, MASKS) };
  mry_masks_info info = MRY_MASKS_INFO_INIT;
  size_t count = 0;
  switch (below(s, 3)) {
    case 0: SIZED(mry_masks_info, &info); return mry_masks_get_info(s->context, masks, &info, ERR);
    case 1: return mry_masks_read(s->context, masks, frame(s), out(s), room(s, 1), number(s, 200), ERR);
    default: return mry_masks_get_report(s->context, masks, out(s), room(s, 1), &count, ERR);
  }
}

/* What a picture is like, drawn without a GPU: drivers are not what is tested. */
static void picture(soak *s, mry_render_desc *desc, mry_camera *camera) {
  *camera = (mry_camera)MRY_CAMERA_INIT;
  camera->kind = (int32_t)below(s, 4);
  camera->yaw = (float)real(s);
  camera->pitch = (float)real(s);
  camera->fov = below(s, 2) ? 30.0f : (float)real(s);
  camera->distance = camera->height = (float)real(s);
  *desc = (mry_render_desc)MRY_RENDER_DESC_INIT;
  desc->width = number(s, 40);
  desc->height = number(s, 30);
  desc->style = (int32_t)below(s, 8);
  desc->adapter = MRY_ADAPTER_CPU;
  desc->shadow = below(s, 2) ? 0.5f : 0.0f;
  desc->frame = pose(s);
  desc->camera = below(s, 3) ? camera : NULL;
  if (below(s, 3) == 0) { desc->crowd.v = id(s, CROWD); }
}

static mry_status use_crowd(soak *s) {
  mry_instance instances[3];
  mry_crowd crowd = { 0 };
  mry_crowd_info info = MRY_CROWD_INFO_INIT;
  char name[300];
  mry_status status;
  for (int i = 0; i < 3; i++) {
    instances[i] = (mry_instance){ 0 };
    instances[i].creature.v = id(s, CREATURE);
    instances[i].at[below(s, 3)] = (float)real(s);
    instances[i].yaw = (float)real(s);
    instances[i].scale = below(s, 2) ? 0.0f : (float)real(s);
    instances[i].play = (int32_t)below(s, 4);
    instances[i].start = real(s);
    instances[i].speed = below(s, 2) ? 0.0 : real(s);
  }
  switch (below(s, 5)) {
    case 0: status = mry_crowd_create(s->context, instances, below(s, 4), below(s, 5), real(s), &crowd, ERR); break;
    case 1: status = mry_crowd_create_herd(s->context, instances[0].creature, number(s, 20), below(s, 5), &crowd, ERR); break;
    case 2: status = mry_crowd_read(s->context, place(s, name, ".json"), &crowd, ERR); break;
    case 3:
      return mry_crowd_write_glb(s->context, (mry_crowd){ id(s, CROWD) }, place(s, name, ".glb"), (float)real(s), ERR);
    default:
      SIZED(mry_crowd_info, &info);
      return mry_crowd_get_info(s->context, (mry_crowd){ id(s, CROWD) }, &info, ERR);
  }
  keep(s, CROWD, crowd.v);
  return status;
}

/* A limb or two drawn anew, the bones asked for or a creature made of it. */
static mry_status repose(soak *s) {
  static const char *const poses = "{\"format\":\"marey-strokes\",\"version\":1,\"size\":[%u,90],\"keyframes\":["
                                   "{\"frame\":0,\"strokes\":[{\"limb\":\"body\",\"points\":[[%u,40],[90,%u]]}]},"
                                   "{\"frame\":%u,\"easing\":\"inout\",\"strokes\":[{\"limb\":\"body\","
                                   "\"points\":[[20,%u],[70,60]],\"facing\":\"away\",\"bend\":9}]}]}";
  mry_creature creature = { id(s, CREATURE) }, made = { 0 };
  mry_motion motion = { id(s, MOTION) };
  mry_repose_desc desc = MRY_REPOSE_DESC_INIT;
  SIZED(mry_repose_desc, &desc);
  desc.lengths = (int32_t)below(s, 4);
  desc.stretch = below(s, 3) == 0 ? real(s) : 0.0f;
  desc.frames = below(s, 40);
  desc.mirror = below(s, 2);
  desc.turns = (int32_t)below(s, 4);
  char json[600];
  snprintf(json, sizeof json, poses, 120 + below(s, 2), below(s, 60), below(s, 90), 1 + below(s, 30), below(s, 90));
  const mry_repose_desc *how = below(s, 3) == 0 ? NULL : &desc;
  const mry_str map = below(s, 3) == 0 ? MRY_STR("{\"limbs\":{\"body\":{\"tracks\":[\"body\"]}}}") : MRY_STR("");
  mry_point p[8];
  size_t count = 0;
  mry_limb_pose limbs[2] = { { text(s), points(s, p), below(s, 9), (int32_t)below(s, 4), below(s, 3), real(s), real(s) },
                             { text(s), p, 2, 0, 0, 0.0f, real(s) } };
  mry_status status;
  switch (below(s, 5)) {
    case 0:
      return mry_creature_pose(s->context, creature, limbs, below(s, 3), how, out(s), room(s, sizeof(mry_transform)),
                               &count, ERR);
    case 1: status = mry_creature_repose(s->context, creature, MRY_STR(json), how, &made, ERR); break;
    case 2: status = mry_creature_drive(s->context, creature, motion, map, how, &made, ERR); break;
    case 3: return mry_creature_match(s->context, creature, motion, map, out(s), room(s, 1), &count, ERR);
    default: return mry_creature_get_strain(s->context, creature, out(s), room(s, 1), &count, ERR);
  }
  keep(s, CREATURE, made.v);
  return status;
}

/* What a creature wears, and its mesh as a modelling tool gives it back. */
static mry_status surface(soak *s) {
  mry_creature creature = { id(s, CREATURE) }, made = { 0 };
  mry_job job = { 0 };
  mry_texture_desc texture = MRY_TEXTURE_DESC_INIT;
  mry_edit_desc edit = MRY_EDIT_DESC_INIT;
  const mry_str limbs[2] = { text(s), text(s) };
  uint32_t indices[12];
  float corners[12];
  char name[300], region[300];
  mry_status status;
  SIZED(mry_texture_desc, &texture);
  texture.creature = creature;
  texture.from = (int32_t)below(s, 5);
  texture.clip.v = id(s, CLIP);
  texture.masks.v = below(s, 2) == 0 ? 0 : id(s, MASKS);
  texture.mask_clip.v = id(s, CLIP);
  texture.first_frame = below(s, 2) == 0 ? 0 : frame(s);
  texture.frame_count = below(s, 2) == 0 ? 0 : frame(s);
  texture.source.v = id(s, CREATURE);
  texture.picture = place(s, name, ".png");
  texture.width = below(s, 2) == 0 ? 0.0f : real(s);
  texture.soft = below(s, 2) == 0 ? 0.0f : real(s);
  texture.limbs = limbs;
  texture.limb_count = below(s, 3) == 0 ? 2 : 0;
  if (below(s, 4) == 0) {
    texture.region = place(s, region, ".png");
  }
  SIZED(mry_edit_desc, &edit);
  edit.creature = creature;
  edit.frame = frame(s);
  for (int i = 0; i < 12; i++) {
    indices[i] = number(s, 4);
    corners[i] = real(s);
  }
  edit.positions = below(s, 30) == 0 ? NULL : corners;
  edit.vertex_count = below(s, 5);
  edit.indices = indices;
  edit.triangle_count = below(s, 5);
  if (below(s, 3) == 0) {
    edit.path = place(s, name, ".obj");
  }
  switch (below(s, 6)) {
    case 0: return mry_creature_write_textures(s->context, creature, place(s, name, ""), ERR);
    case 1: status = mry_creature_read_textures(s->context, creature, place(s, name, ""), &made, ERR); break;
    case 2: status = mry_run_texture(s->context, &texture, &made, ERR); break;
    case 3: status = mry_run_edit(s->context, &edit, &made, ERR); break;
    case 4:
      status = mry_job_start_edit(s->context, &edit, &job, ERR);
      s->job_count += status == MRY_OK;
      keep(s, JOB, job.v);
      return status;
    default:
      status = mry_job_start_texture(s->context, &texture, &job, ERR);
      s->job_count += status == MRY_OK;
      keep(s, JOB, job.v);
      return status;
  }
  keep(s, CREATURE, made.v);
  return status;
}

static mry_status use_creature(soak *s) {
  mry_creature creature = { id(s, CREATURE) };
  mry_creature_info info = MRY_CREATURE_INFO_INIT;
  mry_part_info part = MRY_PART_INFO_INIT;
  mry_mesh_view mesh = MRY_MESH_VIEW_INIT;
  mry_image_view view = MRY_IMAGE_VIEW_INIT;
  mry_motion motion = { 0 };
  mry_masks masks = { 0 };
  mry_creature_limb limb = MRY_CREATURE_LIMB_INIT;
  mry_creature read = { 0 };
  char name[300];
  size_t count = 0;
  mry_status status;
  switch (below(s, 20)) {
    case 19: return below(s, 4) == 0 ? surface(s) : MRY_OK;
    case 16:
    case 17:
    case 18: return repose(s);
    case 14: return mry_context_get_renderer(s->context, MRY_ADAPTER_CPU, out(s), room(s, 1), &count, ERR);
    case 15: {
      mry_render_desc desc;
      mry_camera camera;
      picture(s, &desc, &camera);
      return mry_creature_render(s->context, creature, &desc, out(s), room(s, 1), &count, ERR);
    }
    case 11:
      SIZED(mry_creature_limb, &limb);
      return mry_creature_get_limb(s->context, creature, number(s, 4), out(s), room(s, 1), &count, &limb, ERR);
    case 12: return mry_creature_write_glb(s->context, creature, place(s, name, ".glb"), (float)real(s), ERR);
    case 13:
      status = mry_creature_open(s->context, place(s, name, ".glb"), &read, ERR);
      keep(s, CREATURE, read.v);
      return status;
    case 0: SIZED(mry_creature_info, &info); return mry_creature_get_info(s->context, creature, &info, ERR);
    case 1:
      status = mry_creature_get_motion(s->context, creature, &motion, ERR);
      keep(s, MOTION, motion.v);
      return status;
    case 2:
      status = mry_creature_get_masks(s->context, creature, &masks, ERR);
      keep(s, MASKS, masks.v);
      return status;
    case 3: return mry_creature_get_report(s->context, creature, out(s), room(s, 1), &count, ERR);
    case 4: return mry_creature_get_bone(s->context, creature, number(s, 9), out(s), room(s, 1), &count, NULL, ERR);
    case 5:
      return mry_creature_read_pose(s->context, creature, pose(s), out(s), room(s, sizeof(mry_transform)), &count, ERR);
    case 6:
      SIZED(mry_part_info, &part);
      return mry_creature_get_part(s->context, creature, number(s, 4), out(s), room(s, 1), &count, &part, ERR);
    case 7:
      return mry_creature_read_vertices(s->context, creature, number(s, 4), pose(s), out(s), NULL, NULL, room(s, 12),
                                        &count, ERR);
    case 8: return mry_creature_read_triangles(s->context, creature, number(s, 4), out(s), room(s, 12), &count, ERR);
    case 9:
      SIZED(mry_mesh_view, &mesh);
      status = mry_creature_map_part(s->context, creature, number(s, 4), pose(s), &mesh, ERR);
      if (status == MRY_OK) {
        s->good += mesh.positions[3 * below(s, (uint32_t)mesh.vertex_count)] > 0.0f;
        keep(s, MAP, mesh.map.v);
      }
      return status;
    default:
      status = mry_creature_map_texture(s->context, creature, number(s, 4), &view, ERR);
      keep(s, MAP, view.map.v);
      return status;
  }
}

/* A strip of triangles with a handle or two: mostly one that can be bound. */
static mry_status deform(soak *s) {
  mry_point p[10];
  uint32_t triangles[24];
  mry_handle handles[3];
  mry_deformation deformation = { id(s, DEFORMATION) }, made = { 0 };
  mry_deform_desc desc = MRY_DEFORM_DESC_INIT;
  for (uint32_t i = 0; i < 10; i++) {
    p[i] = (mry_point){ 9.0f * (float)(i / 2) + real(s) / 100.0f, 9.0f * (float)(i % 2) };
  }
  for (uint32_t i = 0; i < 8; i++) {
    triangles[3 * i] = i;
    triangles[3 * i + 1] = i % 2 == 0 ? i + 1 : i + 2;
    triangles[3 * i + 2] = i % 2 == 0 ? i + 2 : i + 1;
  }
  if (below(s, 9) == 0) {
    triangles[below(s, 24)] = number(s, 12);
  }
  for (int i = 0; i < 3; i++) {
    handles[i] = (mry_handle){ below(s, 20) == 0 ? (int32_t)number(s, 4) : 1 + (int32_t)below(s, 2), 0, p[3 * i], p[9] };
  }
  if (below(s, 2) == 0) {
    const mry_point *from = below(s, 2) == 0 ? p : NULL;
    return mry_deformation_solve(s->context, deformation, handles, below(s, 4), from, out(s),
                                 below(s, 9) == 0 ? number(s, 99) % 99 : 10, ERR);
  }
  SIZED(mry_deform_desc, &desc);
  desc.iterations = number(s, 20);
  desc.points = p;
  desc.point_count = below(s, 20) == 0 ? number(s, 11) % 11 : 10;
  desc.triangles = triangles;
  desc.triangle_count = below(s, 20) == 0 ? number(s, 9) % 9 : 8;
  desc.handles = handles;
  desc.handle_count = below(s, 4);
  desc.deformer = below(s, 3) == 0 ? text(s) : MRY_STR(below(s, 2) == 0 ? "needles" : "arap");
  mry_status status = mry_deformation_create(s->context, &desc, &made, ERR);
  keep(s, DEFORMATION, made.v);
  return status;
}

/* A drawing of two bars that cross, mostly; now and then nothing, or a whole sheet. */
static mry_status make_character(soak *s) {
  static unsigned char pixels[48 * 40 * 4];
  char name[300];
  mry_character character = { id(s, CHARACTER) }, made = { 0 };
  mry_character_desc desc = MRY_CHARACTER_DESC_INIT;
  mry_image_view view = MRY_IMAGE_VIEW_INIT;
  mry_status status;
  if (below(s, 2) == 0) {
    status = mry_character_copy(s->context, character, &made, ERR);
    keep(s, CHARACTER, made.v);
    return status;
  }
  const uint32_t what = below(s, 12), thick = 2 + below(s, 6);
  for (uint32_t i = 0; i < 48 * 40; i++) {
    const uint32_t x = i % 48, y = i / 48;
    const int inside = what == 0 ? 0 : what == 1 ? 1 : (y > 18 && y < 19 + thick && x > 3 && x < 44) || (x > 20 && x < 21 + thick && y > 3 && y < 36);
    pixels[4 * i] = (unsigned char)x;
    pixels[4 * i + 3] = inside ? 255 : 0;
  }
  SIZED(mry_image_view, &view);
  view.format = below(s, 20) == 0 ? (int32_t)number(s, 4) : MRY_FORMAT_RGBA8;
  view.width = 48;
  view.height = 40;
  view.stride_bytes = below(s, 20) == 0 ? number(s, 190) % 192 : 0;
  view.data = below(s, 60) == 0 ? NULL : pixels;
  SIZED(mry_character_desc, &desc);
  desc.vertices = below(s, 30) == 0 ? (uint32_t)next(s) | 1u << 20 : number(s, 200) % 300;
  desc.finer_at_joints = below(s, 4) == 0 ? real(s) : 0.0f;
  desc.pixels = &view;
  if (below(s, 8) == 0) {
    desc.rig = place(s, name, ".json");
  }
  if (below(s, 9) == 0) {
    desc.rig_json = text(s);
  }
  status = mry_run_character(s->context, &desc, &made, ERR);
  keep(s, CHARACTER, made.v);
  return status;
}

static mry_status use_character(soak *s) {
  mry_point p[8], at = { real(s), real(s) };
  char name[300];
  mry_character character = { id(s, CHARACTER) };
  mry_character_info info = MRY_CHARACTER_INFO_INIT;
  uint32_t a = 0, b = 0;
  size_t count = 0;
  switch (below(s, 14)) {
    case 0: SIZED(mry_character_info, &info); return mry_character_get_info(s->context, character, &info, ERR);
    case 1:
      return mry_character_read_vertices(s->context, character, out(s), NULL, NULL, room(s, sizeof(mry_point)), &count, ERR);
    case 2: return mry_character_read_triangles(s->context, character, out(s), room(s, 12), &count, ERR);
    case 3: return mry_character_to_json(s->context, character, out(s), room(s, 1), &count, ERR);
    case 4: return mry_character_write(s->context, character, place(s, name, ".json"), ERR);
    case 5: return below(s, 9) == 0 ? mry_character_write_preview(s->context, character, place(s, name, ".png"), ERR) : MRY_OK;
    case 6: return mry_character_get_joint(s->context, character, number(s, 9), out(s), room(s, 1), &count, &at, ERR);
    case 7: return mry_character_get_bone(s->context, character, number(s, 9), &a, &b, ERR);
    case 8: return mry_character_set_joints(s->context, character, points(s, p), below(s, 9), ERR);
    case 9: return mry_character_rename_joint(s->context, character, number(s, 9), text(s), ERR);
    case 10: return mry_character_add_joint(s->context, character, text(s), at, number(s, 9), &a, ERR);
    case 11: return mry_character_split_bone(s->context, character, text(s), at, number(s, 9), &a, ERR);
    case 12: return mry_character_remove_joint(s->context, character, number(s, 9), ERR);
    default: return mry_character_on_curve(s->context, character, at, &at, ERR);
  }
}

/* Joints near where they rest, mostly. */
static size_t joints(soak *s, mry_character character, mry_point p[32]) {
  mry_character_info info = MRY_CHARACTER_INFO_INIT;
  char name[8];
  size_t size = 0;
  if (mry_character_get_info(s->context, character, &info, NULL) != MRY_OK || info.joint_count > 32) {
    return below(s, 9);
  }
  for (uint32_t i = 0; i < info.joint_count; i++) {
    mry_character_get_joint(s->context, character, i, name, 0, &size, &p[i], NULL);
    p[i].x += real(s) / 9.0f;
    p[i].y += real(s) / 9.0f;
  }
  return below(s, 20) == 0 ? number(s, 9) % 32 : info.joint_count;
}

static mry_status animate(soak *s) {
  mry_point p[32], ways[8];
  char name[300];
  uint32_t vertices[8];
  memset(p, 0, sizeof p);
  memset(ways, 0, sizeof ways);
  mry_character character = { id(s, CHARACTER) };
  mry_poser poser = { id(s, POSER) };
  mry_poses poses = { id(s, POSES) };
  mry_poses_info info = MRY_POSES_INFO_INIT;
  uint64_t key_frame = 0;
  size_t key_count = 0;
  int32_t depths[32] = { 0 };
  int32_t easing = 0;
  size_t count = joints(s, character, p);
  mry_status status;
  for (int i = 0; i < 8; i++) {
    vertices[i] = number(s, 99);
  }
  switch (below(s, 17)) {
    case 14: {
      uint32_t lengths[2] = { below(s, 8), number(s, 8) };
      return mry_character_sketch(s->context, character, below(s, 2) == 0 ? NULL : p, count, points(s, ways), lengths, 1 + below(s, 2), out(s), ERR);
    }
    case 15: {
      static mry_point shape[4096];
      mry_character_read_vertices(s->context, character, shape, NULL, NULL, 4096, &key_count, NULL);
      return below(s, 2) == 0 ? mry_character_read_overlaps(s->context, character, shape, key_count, NULL, 0, out(s), room(s, sizeof(mry_overlap)), &count, ERR)
                              : mry_character_bring_forward(s->context, character, shape, key_count, depths, number(s, 32) % 32, ways[0], vertices, ERR);
    }
    case 16: {
      static mry_point shape[4096];
      mry_poser_pose(s->context, poser, p, count, shape, 4096, NULL);
      mry_character_read_vertices(s->context, character, NULL, NULL, NULL, 0, &key_count, NULL);
      return mry_poser_redraw(s->context, poser, p, count, shape, key_count % 4096, points(s, ways), below(s, 9) % 8, out(s), NULL, room(s, 4), &count, ERR);
    }
    case 0:
      poser.v = 0;
      status = mry_poser_create(s->context, character, below(s, 4) == 0 ? text(s) : MRY_STR(below(s, 2) == 0 ? "" : "arap"),
                                (int32_t)number(s, 4), &poser, ERR);
      keep(s, POSER, poser.v);
      return status;
    case 1:
    case 2:
      if (below(s, 2) == 0) {
        return mry_poser_drag(s->context, poser, p, count, out(s), room(s, sizeof(mry_point)), ERR);
      }
      return mry_poser_pose(s->context, poser, p, count, out(s), room(s, sizeof(mry_point)), ERR);
    case 3:
      poses.v = 0;
      status = mry_poses_create(s->context, character, (double)real(s), number(s, 4), &poses, ERR);
      keep(s, POSES, poses.v);
      return status;
    case 4: return mry_poses_set_rate(s->context, poses, (double)real(s), number(s, 4), ERR);
    case 5:
    case 6: return mry_poses_set_key(s->context, poses, frame(s), p, count, (int32_t)number(s, 6), ERR);
    case 7: return mry_poses_remove_key(s->context, poses, frame(s), ERR);
    case 8:
      return mry_poses_get_key(s->context, poses, frame(s), &key_frame, &easing, out(s), room(s, sizeof(mry_point)), &count, ERR);
    case 9: return mry_poses_set_moved(s->context, poses, frame(s), vertices, points(s, ways), below(s, 8), ERR);
    case 10: return mry_poses_get_moved(s->context, poses, frame(s), out(s), NULL, room(s, 4), &count, ERR);
    case 11: return mry_poses_set_depth(s->context, poses, frame(s), number(s, 9), (int32_t)next(s), ERR);
    case 12: SIZED(mry_poses_info, &info); return mry_poses_get_info(s->context, poses, &info, ERR);
    default:
      if (below(s, 2) == 0) {
        return mry_poses_write(s->context, poses, place(s, name, ".json"), ERR);
      }
      poses.v = 0;
      status = mry_poses_read(s->context, character, place(s, name, ".json"), &poses, ERR);
      keep(s, POSES, poses.v);
      return status;
  }
}

static mry_retarget_desc retargeting(soak *s, mry_str planted[2]) {
  mry_retarget_desc desc = MRY_RETARGET_DESC_INIT;
  SIZED(mry_retarget_desc, &desc);
  desc.angles = (int32_t)number(s, 3);
  desc.reference = below(s, 3) == 0 ? frame(s) : 0;
  desc.stretch = below(s, 3) == 0 ? real(s) : 0.0f;
  desc.root_scale = below(s, 3) == 0 ? real(s) : 0.0f;
  desc.map = below(s, 9) == 0 ? text(s) : MRY_STR("");
  planted[0] = text(s);
  planted[1] = text(s);
  desc.planted = planted;
  desc.planted_count = below(s, 9) == 0 ? below(s, 3) : 0;
  return desc;
}

static mry_status use_take(soak *s) {
  char name[300];
  mry_str planted[2];
  mry_take take = { id(s, TAKE) };
  mry_take_info info = MRY_TAKE_INFO_INIT;
  mry_take_desc desc = MRY_TAKE_DESC_INIT;
  mry_motion motion = { id(s, MOTION) }, made = { 0 };
  mry_character character = { id(s, CHARACTER) };
  const mry_retarget_desc how = retargeting(s, planted);
  size_t count = 0;
  mry_status status;
  switch (below(s, 11)) {
    case 0: SIZED(mry_take_info, &info); return mry_take_get_info(s->context, take, &info, ERR);
    case 1: return mry_take_read_points(s->context, take, frame(s), out(s), room(s, sizeof(mry_point)), &count, ERR);
    case 2: return mry_take_read_joints(s->context, take, frame(s), out(s), room(s, sizeof(mry_point)), &count, ERR);
    case 3: return mry_take_read_depths(s->context, take, frame(s), out(s), room(s, 4), &count, ERR);
    case 10:
      return mry_take_draw_frame(s->context, take, frame(s), below(s, 9) == 0 ? real(s) : 0.5f, number(s, 2), out(s), room(s, 1), number(s, 400), ERR);
    case 4: return mry_take_get_report(s->context, take, out(s), room(s, 1), &count, ERR);
    case 5: status = mry_motion_retarget(s->context, motion, character, &how, &made, ERR); break;
    case 6: return mry_motion_match(s->context, motion, character, &how, out(s), room(s, 1), &count, ERR);
    case 7: return mry_motion_write_bvh(s->context, motion, place(s, name, ".bvh"), ERR);
    case 8: status = mry_motion_read_bvh(s->context, place(s, name, ".bvh"), (int32_t)number(s, 5), number(s, 99), &made, ERR); break;
    default:
      take.v = 0;
      SIZED(mry_take_desc, &desc);
      desc.area = (int32_t)number(s, 4);
      if (below(s, 2) == 0) {
        desc.poses.v = id(s, POSES);
      } else {
        desc.character = character;
        desc.motion = motion;
      }
      desc.deformer = below(s, 9) == 0 ? text(s) : MRY_STR("");
      desc.retarget = below(s, 2) == 0 ? &how : NULL;
      status = mry_run_take(s->context, &desc, &take, ERR);
      keep(s, TAKE, take.v);
      return status;
  }
  keep(s, MOTION, made.v);
  return status;
}

/* A drawing that a pen drew, or a few lines of SVG, and how paths hold it. */
static mry_status make_sketch(soak *s) {
  static const char *const svgs[] = {
    "<svg xmlns='http://www.w3.org/2000/svg' width='90' height='60'><path id='body' d='M5 30 C30 5 60 55 85 30' fill='none' stroke='#000' stroke-width='4'/>"
    "<g opacity='.5'><path id='leg' d='M40 30 V55 H50 Z' fill='#c00'/></g></svg>",
    "<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'><text>a</text></svg>",
    "<svg", "",
  };
  static const char *const paths =
    "{\"format\":\"marey-paths\",\"version\":1,\"size\":[90,60],\"fps\":4,\"seconds\":1,\"points\":["
    "{\"name\":\"hind\",\"path\":\"M5 30 V40\"},{\"name\":\"fore\",\"path\":\"M85 30 V20\"},{\"name\":\"tail\",\"path\":\"M45 55 H50\"}]}";
  static const char *const binds[] = {
    "{\"format\":\"marey-bind\",\"version\":1,\"size\":[90,60],\"motions\":[{\"name\":\"a\"}],\"points\":["
    "{\"track\":\"hind\",\"at\":[5,30]},{\"track\":\"fore\",\"at\":[85,30]},{\"track\":\"tail\",\"at\":[45,50]}]}",
    "{}",
  };
  static const unsigned char colour[4] = { 1, 2, 3, 255 };
  mry_pen_sample pen[8];
  char name[300];
  mry_drawing drawing = { 0 };
  mry_binding binding = { 0 };
  mry_control_points marks = { 0 };
  mry_motion motion = { 0 };
  mry_sketch_take sketch = { 0 };
  mry_status status;
  mry_motion motions[2] = { { id(s, MOTION) }, { id(s, MOTION) } };
  mry_sketch_take_desc desc = MRY_SKETCH_TAKE_DESC_INIT;
  for (int i = 0; i < 8; i++) {
    pen[i] = (mry_pen_sample){ real(s), real(s), real(s) / 100.0f };
  }
  switch (below(s, 11)) {
    case 0: status = mry_drawing_from_svg(s->context, MRY_STR(svgs[below(s, 3) == 0 ? below(s, 4) : 0]), &drawing, ERR); break;
    case 1: status = mry_drawing_create(s->context, real(s), real(s), &drawing, ERR); break;
    case 2: status = mry_drawing_read_svg(s->context, place(s, name, ".svg"), &drawing, ERR); break;
    case 3: return mry_drawing_add_stroke(s->context, (mry_drawing){ id(s, DRAWING) }, text(s), pen, below(s, 9), real(s), below(s, 20) == 0 ? NULL : colour, ERR);
    case 4: status = mry_binding_create(s->context, (mry_drawing){ id(s, DRAWING) }, &binding, ERR); break;
    case 5: status = mry_binding_from_json(s->context, MRY_STR(binds[below(s, 9) == 0]), &binding, ERR); break;
    case 6: status = mry_binding_read(s->context, place(s, name, ".bind"), &binding, ERR); break;
    case 7: status = mry_control_points_create(s->context, number(s, 400), number(s, 300), &marks, ERR); break;
    case 8: status = mry_control_points_read(s->context, place(s, name, ".points"), &marks, ERR); break;
    case 9: status = mry_motion_from_paths(s->context, below(s, 9) == 0 ? text(s) : MRY_STR(paths), &motion, ERR); break;
    default:
      SIZED(mry_sketch_take_desc, &desc);
      desc.drawing.v = id(s, DRAWING);
      desc.binding.v = id(s, BINDING);
      desc.motions = motions;
      desc.motion_count = 1 + below(s, 2);
      status = mry_run_sketch_take(s->context, &desc, &sketch, ERR);
      break;
  }
  keep(s, DRAWING, drawing.v);
  keep(s, BINDING, binding.v);
  keep(s, POINTS, marks.v);
  keep(s, MOTION, motion.v);
  keep(s, SKETCH, sketch.v);
  return status;
}

static mry_status use_drawing(soak *s) {
  char name[300];
  size_t count = 0;
  mry_point at = { real(s), real(s) };
  mry_drawing drawing = { id(s, DRAWING) };
  mry_control_points marks = { id(s, POINTS) };
  mry_drawing_info info = MRY_DRAWING_INFO_INIT;
  mry_drawing_stroke stroke = MRY_DRAWING_STROKE_INIT;
  switch (below(s, 13)) {
    case 0: SIZED(mry_drawing_info, &info); return mry_drawing_get_info(s->context, drawing, &info, ERR);
    case 1: return mry_drawing_get_stroke(s->context, drawing, number(s, 4), out(s), room(s, 1), &count, &stroke, ERR);
    case 2: return mry_drawing_get_left_out(s->context, drawing, number(s, 2), out(s), room(s, 1), &count, ERR);
    case 3: return mry_drawing_to_svg(s->context, drawing, out(s), room(s, 1), &count, ERR);
    case 4: return below(s, 8) == 0 ? mry_drawing_read_outline(s->context, drawing, out(s), room(s, sizeof(mry_point)), &count, ERR) : MRY_OK;
    case 5: return below(s, 8) == 0 ? mry_drawing_write_svg(s->context, drawing, place(s, name, ".svg"), ERR) : MRY_OK;
    case 6: return mry_drawing_remove_stroke(s->context, drawing, text(s), ERR);
    case 7: return mry_control_points_to_json(s->context, marks, out(s), room(s, 1), &count, ERR);
    case 8: return below(s, 8) == 0 ? mry_control_points_write(s->context, marks, place(s, name, ".points"), ERR) : MRY_OK;
    case 9: return mry_control_points_unmark(s->context, marks, text(s), frame(s), ERR);
    case 10: return mry_control_points_validate(s->context, marks, (mry_clip){ id(s, CLIP) }, ERR);
    case 11: return mry_motion_get_point_report(s->context, (mry_motion){ id(s, MOTION) }, marks, out(s), room(s, 1), &count, ERR);
    default: return mry_control_points_mark(s->context, marks, text(s), frame(s), at, ERR);
  }
}

static mry_status use_binding(soak *s) {
  mry_point p[8], at = { real(s), real(s) };
  char name[300];
  size_t count = 0;
  uint32_t a = 0;
  float rigidity = 0;
  mry_binding binding = { id(s, BINDING) };
  mry_drawing drawing = { id(s, DRAWING) };
  mry_binding_info info = MRY_BINDING_INFO_INIT;
  mry_motion_use how = MRY_MOTION_USE_INIT;
  mry_str layers[2] = { text(s), text(s) };
  how.scale = real(s);
  how.travel = real(s) / 100.0f;
  how.frame = frame(s);
  how.mirror = number(s, 2);
  switch (below(s, 22)) {
    case 0: SIZED(mry_binding_info, &info); return mry_binding_get_info(s->context, binding, &info, ERR);
    case 1: SIZED(mry_motion_use, &how); return mry_binding_set_motion(s->context, binding, text(s), &how, ERR);
    case 2: return mry_binding_get_motion(s->context, binding, number(s, 3), out(s), room(s, 1), &count, &how, ERR);
    case 3: return mry_binding_set_point(s->context, binding, MRY_STR(""), text(s), number(s, 2), at, MRY_STR(""), ERR);
    case 4: return mry_binding_remove_point(s->context, binding, MRY_STR(""), text(s), number(s, 2), ERR);
    case 5: return mry_binding_get_point(s->context, binding, number(s, 4), out(s), room(s, 1), &count, &a, &at, ERR);
    case 6: return mry_binding_add_pin(s->context, binding, at, text(s), ERR);
    case 7: return mry_binding_remove_pin(s->context, binding, number(s, 3), ERR);
    case 8: return mry_binding_get_pin(s->context, binding, number(s, 3), &at, ERR);
    case 9: return mry_binding_set_stroke(s->context, binding, text(s), real(s), number(s, 2), ERR);
    case 10: return mry_binding_get_stroke(s->context, binding, text(s), &rigidity, &a, ERR);
    case 11: return below(s, 8) == 0 ? mry_binding_paint_layer(s->context, binding, drawing, text(s), points(s, p), below(s, 9), real(s), &a, ERR) : MRY_OK;
    case 12: return mry_binding_set_layer(s->context, binding, drawing, text(s), layers, below(s, 3), ERR);
    case 13: return mry_binding_remove_layer(s->context, binding, text(s), ERR);
    case 14: return mry_binding_get_layer(s->context, binding, number(s, 3), out(s), room(s, 1), &count, ERR);
    case 15: return below(s, 20) == 0 ? mry_binding_propose_joints(s->context, binding, drawing, ERR) : MRY_OK;
    case 16: return mry_binding_add_joint(s->context, binding, text(s), text(s), at, ERR);
    case 17: return mry_binding_set_joint(s->context, binding, number(s, 3), at, ERR);
    case 18: return mry_binding_remove_joint(s->context, binding, number(s, 3), ERR);
    case 19: return mry_binding_get_joint(s->context, binding, number(s, 3), &at, ERR);
    case 20: return below(s, 8) == 0 ? mry_binding_write(s->context, binding, place(s, name, ".bind"), ERR) : mry_binding_validate(s->context, binding, drawing, ERR);
    default: return mry_binding_to_json(s->context, binding, out(s), room(s, 1), &count, ERR);
  }
}

static mry_status use_sketch(soak *s) {
  mry_sketch_take take = { id(s, SKETCH) };
  mry_sketch_take_info info = MRY_SKETCH_TAKE_INFO_INIT;
  uint32_t width = 0, height = 0;
  size_t count = 0;
  switch (below(s, 5)) {
    case 0: SIZED(mry_sketch_take_info, &info); return mry_sketch_take_get_info(s->context, take, &info, ERR);
    case 1: return mry_sketch_take_read_order(s->context, take, out(s), room(s, 4), &count, ERR);
    case 2: return mry_sketch_take_measure(s->context, take, real(s), number(s, 2), &width, &height, NULL, ERR);
    case 3: return mry_sketch_take_draw_frame(s->context, take, frame(s), below(s, 9) == 0 ? real(s) : 0.5f, number(s, 2), out(s), room(s, 1), number(s, 400), ERR);
    default: return mry_sketch_take_read_stroke(s->context, take, frame(s), number(s, 3), out(s), room(s, sizeof(mry_path_element)), &count, ERR);
  }
}

static mry_status start_job(soak *s) {
  char name[300];
  mry_job job = { 0 };
  mry_status status;
  mry_clip clip = { id(s, CLIP) };
  mry_rig rig = { id(s, RIG) };
  switch (below(s, 12)) {
    case 0: status = mry_job_start_open(s->context, MRY_STR(s->clip), NULL, &job, ERR); break;
    case 1: {
      mry_track_desc desc = MRY_TRACK_DESC_INIT;
      desc.clip = clip;
      desc.rig = rig;
      if (below(s, 2) == 0) {
        desc.earlier.v = id(s, MOTION);
        desc.earlier_rig.v = id(s, RIG);
      }
      status = mry_job_start_track(s->context, &desc, &job, ERR);
      break;
    }
    case 2: {
      mry_segment_desc desc = MRY_SEGMENT_DESC_INIT;
      desc.clip = clip;
      desc.rig = rig;
      desc.motion.v = below(s, 2) == 0 ? 0 : id(s, MOTION);
      status = mry_job_start_segment(s->context, &desc, &job, ERR);
      break;
    }
    case 3: {
      mry_export_desc desc = MRY_EXPORT_DESC_INIT;
      desc.creature.v = id(s, CREATURE);
      desc.what = (int32_t)number(s, 6);
      desc.path = place(s, name, ".out");
      desc.scale = real(s);
      status = mry_job_start_export(s->context, &desc, &job, ERR);
      break;
    }
    case 11: status = mry_job_start_propose_points(s->context, clip, frame(s), number(s, 9), &job, ERR); break;
    case 6: {
      mry_point_track_desc desc = MRY_POINT_TRACK_DESC_INIT;
      desc.clip = clip;
      desc.points.v = id(s, POINTS);
      desc.keep = number(s, 2);
      status = mry_job_start_point_track(s->context, &desc, &job, ERR);
      break;
    }
    case 7: {
      mry_bind_desc desc = MRY_BIND_DESC_INIT;
      desc.drawing.v = id(s, DRAWING);
      desc.motion.v = id(s, MOTION);
      desc.clip.v = below(s, 2) == 0 ? 0 : clip.v;
      desc.faces = (int32_t)number(s, 4);
      desc.frame_from_one = frame(s);
      status = mry_job_start_bind(s->context, &desc, &job, ERR);
      break;
    }
    case 8: {
      static const char *const formats[] = { "svg", "lottie", "png-dir", "sprite-sheet", "gif", "apng", "webp", "mp4", "mp4-alpha" };
      mry_sketch_file_desc desc = MRY_SKETCH_FILE_DESC_INIT;
      desc.take.v = id(s, SKETCH);
      desc.path = place(s, name, ".sketch");
      desc.format = MRY_STR(formats[below(s, 9)]);
      desc.scale = below(s, 9) == 0 ? real(s) : 0.0f;
      status = mry_job_start_sketch_file(s->context, &desc, &job, ERR);
      break;
    }
    case 4: {
      mry_take_desc desc = MRY_TAKE_DESC_INIT;
      desc.poses.v = id(s, POSES);
      status = mry_job_start_take(s->context, &desc, &job, ERR);
      break;
    }
    case 5: {
      static const char *const formats[] = { "png-dir", "sprite-sheet", "gif", "apng", "webp", "mp4", "glb", "lottie", "spine", "dragonbones" };
      mry_take_file_desc desc = MRY_TAKE_FILE_DESC_INIT;
      desc.take.v = id(s, TAKE);
      desc.path = place(s, name, ".take");
      desc.format = MRY_STR(formats[below(s, 10)]);
      desc.scale = below(s, 9) == 0 ? real(s) : 0.0f;
      status = mry_job_start_take_file(s->context, &desc, &job, ERR);
      break;
    }
    case 9: {
      static const char *const formats[] = { "png", "png-dir", "sprite-sheet", "gif", "apng", "webp", "mp4", "" };
      mry_render_desc look;
      mry_camera camera;
      mry_render_file_desc desc = MRY_RENDER_FILE_DESC_INIT;
      desc.creature.v = id(s, CREATURE);
      picture(s, &look, &camera);
      if (below(s, 4) == 0) {
        desc.clip.v = id(s, CLIP);
        desc.masks.v = below(s, 2) ? id(s, MASKS) : 0;
        desc.mask_clip.v = below(s, 4) ? 0 : id(s, CLIP);
        desc.alone = below(s, 2);
      }
      desc.picture = &look;
      desc.path = place(s, name, ".film");
      desc.format = MRY_STR(formats[below(s, 8)]);
      desc.frame_count = below(s, 4);
      desc.still = below(s, 2);
      desc.turns = below(s, 9) == 0 ? (float)real(s) : 1.0f;
      status = mry_job_start_render(s->context, &desc, &job, ERR);
      break;
    }
    default: {
      mry_creature_desc desc = MRY_CREATURE_DESC_INIT;
      desc.clip = clip;
      desc.rig = rig;
      status = mry_job_start_creature(s->context, &desc, &job, ERR);
      break;
    }
  }
  s->job_count += status == MRY_OK;
  keep(s, JOB, job.v);
  return status;
}

static mry_status use_solid(soak *s) {
  char name[300];
  mry_solid solid = { id(s, SOLID) };
  mry_solid_info info = MRY_SOLID_INFO_INIT;
  mry_print_desc desc = MRY_PRINT_DESC_INIT;
  mry_status status;
  size_t count = 0;
  switch (below(s, 8)) {
    case 0: SIZED(mry_solid_info, &info); return mry_solid_get_info(s->context, solid, &info, ERR);
    case 1: return mry_solid_read_vertices(s->context, solid, below(s, 2) == 0 ? NULL : out(s), NULL, room(s, 12), &count, ERR);
    case 2: return mry_solid_read_triangles(s->context, solid, out(s), room(s, 12), &count, ERR);
    case 3: return below(s, 8) == 0 ? mry_solid_write(s->context, solid, place(s, name, below(s, 2) == 0 ? ".stl" : ".3mf"), ERR) : MRY_OK;
    default:
      if (below(s, 20) != 0) {
        return MRY_OK;
      }
      SIZED(mry_print_desc, &desc);
      desc.creature.v = id(s, CREATURE);
      desc.frame = frame(s);
      desc.size_kind = (int32_t)number(s, 3);
      /* Mostly coarse, and so quick. */
      desc.size = below(s, 9) == 0 ? real(s) : 20.0f;
      desc.detail = below(s, 9) == 0 ? real(s) : 1.0f;
      desc.min_thickness = below(s, 3) == 0 ? real(s) : -1.0f;
      desc.base = number(s, 2);
      desc.max_triangles = number(s, 400);
      if (below(s, 4) == 0) {
        desc.path = place(s, name, ".stl");
      }
      status = mry_run_print(s->context, &desc, &solid, ERR);
      keep(s, SOLID, status == MRY_OK ? solid.v : 0);
      return status;
  }
}

static mry_status use_job(soak *s) {
  mry_job job = { id(s, JOB) };
  mry_job_state state = MRY_JOB_STATE_INIT;
  mry_clip clip = { 0 };
  mry_motion motion = { 0 };
  mry_masks masks = { 0 };
  mry_creature creature = { 0 };
  mry_character character = { 0 };
  mry_take take = { 0 };
  mry_binding binding = { 0 };
  mry_sketch_take sketch = { 0 };
  mry_solid solid = { 0 };
  mry_control_points points = { 0 };
  size_t count = 0;
  mry_status status;
  switch (below(s, 15)) {
    case 0: return below(s, 20) == 0 ? mry_job_cancel(s->context, job, ERR) : MRY_OK;
    case 1: return mry_job_wait(s->context, job, below(s, 4) == 0 ? UINT64_C(20000000) : 0, ERR);
    case 2: status = mry_job_take_clip(s->context, job, &clip, ERR); break;
    case 3: status = mry_job_take_motion(s->context, job, &motion, ERR); break;
    case 4: status = mry_job_take_masks(s->context, job, &masks, ERR); break;
    case 5: status = mry_job_take_creature(s->context, job, &creature, ERR); break;
    case 6: status = mry_job_take_character(s->context, job, &character, ERR); break;
    case 7: status = mry_job_take_take(s->context, job, &take, ERR); break;
    case 9: status = mry_job_take_binding(s->context, job, &binding, ERR); break;
    case 10: status = mry_job_take_sketch_take(s->context, job, &sketch, ERR); break;
    case 11: status = mry_job_take_solid(s->context, job, &solid, ERR); break;
    case 12: status = mry_job_take_control_points(s->context, job, &points, ERR); break;
    case 8: return mry_job_get_report(s->context, job, out(s), room(s, 1), &count, ERR);
    default: SIZED(mry_job_state, &state); return mry_job_poll(s->context, job, &state, ERR);
  }
  keep(s, CLIP, clip.v);
  keep(s, MOTION, motion.v);
  keep(s, MASKS, masks.v);
  keep(s, CREATURE, creature.v);
  keep(s, CHARACTER, character.v);
  keep(s, TAKE, take.v);
  keep(s, BINDING, binding.v);
  keep(s, SKETCH, sketch.v);
  keep(s, SOLID, solid.v);
  keep(s, POINTS, points.v);
  return status;
}

/* Edits of a session are on the disk when they return, so that they take their time. */
static mry_status use_session(soak *s) {
  mry_point p[8];
  char name[300];
  mry_session session = { id(s, SESSION) }, made = { 0 };
  mry_session_state state = MRY_SESSION_STATE_INIT;
  mry_clip clip = { id(s, CLIP) };
  mry_rig rig = { id(s, RIG) };
  mry_job job = { 0 };
  uint32_t limb = 0;
  size_t count = 0;
  double value = 0;
  mry_status status;
  uint64_t fingerprint = 0;
  uint8_t bytes[64];
  switch (below(s, 31)) {
    case 0: status = mry_session_create(s->context, place(s, name, ".marey"), &made, ERR); break;
    case 1: status = mry_session_create_untitled(s->context, MRY_STR(s->folder), &made, ERR); break;
    case 2: status = mry_session_open(s->context, place(s, name, ".marey"), (int32_t)number(s, 3), &made, ERR); break;
    case 3: SIZED(mry_session_state, &state); return mry_session_get_state(s->context, session, &state, ERR);
    case 4: return mry_session_save(s->context, session, ERR);
    case 5: return mry_session_save_as(s->context, session, place(s, name, ".marey"), ERR);
    case 6: return mry_session_get_path(s->context, session, out(s), room(s, 1), &count, ERR);
    case 7: return mry_session_begin_gesture(s->context, session, text(s), ERR);
    case 8: return mry_session_end_gesture(s->context, session, ERR);
    case 9: return mry_session_cancel_gesture(s->context, session, ERR);
    case 10:
    case 11: return mry_session_undo(s->context, session, ERR);
    case 12: return mry_session_redo(s->context, session, ERR);
    case 13: return mry_session_set_clip(s->context, session, clip, ERR);
    case 14: return mry_session_set_rig(s->context, session, rig, ERR);
    case 15: return mry_session_add_limb(s->context, session, text(s), (int32_t)number(s, 5), &limb, ERR);
    case 16: return mry_session_remove_limb(s->context, session, number(s, 4), ERR);
    case 17:
    case 18:
      if (below(s, 4) == 0) {
        return mry_session_set_depth(s->context, session, number(s, 4), frame(s), number(s, 4), real(s), real(s), ERR);
      }
      return mry_session_set_stroke(s->context, session, number(s, 4), frame(s), points(s, p), below(s, 9),
                                    (int32_t)number(s, 4), ERR);
    case 19: return mry_session_set_parameter(s->context, session, text(s), (double)real(s), ERR);
    case 20: return mry_session_get_parameter(s->context, session, text(s), &value, ERR);
    case 21: return mry_session_discard(s->context, session, ERR);
    case 23: return mry_session_set_embedded(s->context, session, number(s, 3), ERR);
    case 24: return mry_session_start_recording(s->context, session, place(s, name, ".recording"), ERR);
    case 25: return mry_session_stop_recording(s->context, session, ERR);
    case 26: return mry_session_get_fingerprint(s->context, session, &fingerprint, ERR);
    case 27: status = mry_session_replay(s->context, place(s, name, ".recording"), frame(s), &made, ERR); break;
    case 28:
      return mry_session_set_part(s->context, session, (int32_t)number(s, 10), (const uint8_t *)"a note", below(s, 7),
                                  ERR);
    case 29:
      return mry_session_get_part(s->context, session, (int32_t)number(s, 10), bytes, below(s, sizeof bytes + 1),
                                  &count, ERR);
    case 22: return mry_session_take(s->context, session, (mry_job){ id(s, JOB) }, ERR);
    default:
      status = mry_session_start_track(s->context, session, &job, ERR);
      keep(s, JOB, job.v);
      return status;
  }
  keep(s, SESSION, made.v);
  return status;
}

static mry_status one(soak *s) {
  uint32_t dice = below(s, 200);
  if (dice < 2) {
    int kind = (int)below(s, KINDS);
    return end(s, kind, id(s, kind));
  }
  /* Work is rare, or nothing else would be done. */
  if (dice < 3) {
    return below(s, 8) == 0 ? start_job(s) : MRY_OK;
  }
  if (dice < 6) {
    return make_rig(s);
  }
  if (dice < 8) {
    return use_session(s);
  }
  if (dice < 10) {
    return make_character(s);
  }
  if (dice < 12) {
    return make_sketch(s);
  }
  if (dice < 30) {
    return dice < 16 ? use_drawing(s) : dice < 26 ? use_binding(s) : below(s, 2) == 0 ? use_sketch(s) : use_solid(s);
  }
  if (dice < 56) {
    return dice < 36 ? use_character(s) : dice < 46 ? animate(s) : use_take(s);
  }
  switch (dice % 8) {
    case 7: return deform(s);
    case 0: return edit_rig(s);
    case 6: return edit_motion(s);
    case 1: return use_clip(s);
    case 2: return below(s, 2) == 0 ? use_motion(s) : shape_motion(s);
    case 3: return use_masks(s);
    case 4: return below(s, 4) == 0 ? use_crowd(s) : use_creature(s);
    default: return use_job(s);
  }
}

/* Lends memory for frames, and now and then has none. */
static void *lend(size_t size, size_t alignment, void *user) {
  static _Thread_local uint32_t asked;
  const soak *s = user;
  return s->stingy && ++asked % 97 == 0 ? NULL : aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void take_back(void *memory, size_t size, size_t alignment, void *user) {
  (void)size, (void)alignment, (void)user;
  free(memory);
}

/* Fills every place once, so that calls have something to work on. */
static int begin(soak *s) {
  mry_context_desc desc = MRY_CONTEXT_DESC_INIT;
  desc.threads = 1 + below(s, 3);
  mry_allocator allocator = MRY_ALLOCATOR_INIT;
  allocator.alloc = lend;
  allocator.free = take_back;
  allocator.user = s;
  s->stingy = 0;
  desc.allocator = below(s, 2) == 0 ? &allocator : NULL;
  memset(s->ids, 0, sizeof s->ids);
  if (mry_context_create(&desc, &s->context, &s->err) != MRY_OK) {
    return 0;
  }
  mry_clip clip;
  mry_rig rig;
  mry_creature creature;
  mry_creature_desc what = MRY_CREATURE_DESC_INIT;
  int good = mry_clip_open(s->context, MRY_STR(s->clip), NULL, &clip, &s->err) == MRY_OK &&
             mry_rig_read(s->context, MRY_STR(s->strokes), &rig, &s->err) == MRY_OK;
  if (good) {
    what.clip = clip;
    what.rig = rig;
    good = mry_run_creature(s->context, &what, &creature, &s->err) == MRY_OK;
  }
  if (good) {
    s->ids[CLIP][0] = clip.v;
    s->ids[RIG][0] = rig.v;
    s->ids[CREATURE][0] = creature.v;
  }
  s->stingy = 1;
  return good;
}

int main(int argc, char **argv) {
  if (argc != 6) {
    fprintf(stderr, "usage: %s CLIP STROKES.json FOLDER SEED CALLS\n", argv[0]);
    return 2;
  }
  static soak all;
  soak *s = &all;
  s->clip = argv[1];
  s->strokes = argv[2];
  s->folder = argv[3];
  s->random = strtoull(argv[4], NULL, 10);
  const uint64_t calls = strtoull(argv[5], NULL, 10);
  const uint64_t context_calls = 20000;
  s->err = (mry_error)MRY_ERROR_INIT;
  for (uint64_t i = 0; i < calls; i++) {
    if (i % context_calls == 0) {
      /* Now and then all at once, over whatever runs. */
      mry_context_destroy(s->context);
      if (!begin(s)) {
        fprintf(stderr, "soak: cannot begin: %s\n", s->err.message);
        return 1;
      }
    }
    memset(s->err.message, 0, sizeof s->err.message);
    mry_status status = one(s);
    s->good += status >= 0;
    s->refused += status < 0;
    int known = strcmp(mry_status_text(status), "unknown status") != 0;
    if (!known || status == MRY_E_PANIC || status == MRY_E_POISONED) {
      fprintf(stderr, "soak: call %" PRIu64 ": status %" PRId32 ": %s\n", i, status, s->err.message);
      return 1;
    }
  }
  mry_context_destroy(s->context);
  printf("%" PRIu64 " calls: %" PRIu64 " refused; %" PRIu64 " jobs\n", calls, s->refused, s->job_count);
  return 0;
}
