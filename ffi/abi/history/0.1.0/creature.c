/*
 * creature.c: the whole job through the C library, for authors of host programs.
 *
 *   creature CLIP OUT.glb [STROKES.json]
 *
 * Opens a clip, draws a rig on it call by call (or reads one), shows how work is started, watched and cancelled,
 * reconstructs the creature, looks at it, and writes it as glTF.
 *
 *   cc -std=c11 creature.c $(pkg-config --cflags --libs marey) -o creature
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <marey/marey.h>

/* Everything that has to be given back at the end. The context destroys all that is in it. */
typedef struct host {
  mry_context *context;
  mry_error error;
} host;

/* Says what went wrong and gives the status back, so that a call can be the last thing of an `if`. */
static int failed(const host *h, const char *what, mry_status status) {
  fprintf(stderr, "creature: %s: %s", what, status < 0 ? h->error.message : mry_status_text(status));
  if (status < 0 && h->error.param[0] != '\0') {
    fprintf(stderr, " (%s)", h->error.param);
  }
  fputc('\n', stderr);
  return 0;
}

/* Lines of the library's log. Called from any of its threads; stderr locks itself. */
static void log_line(int32_t level, mry_str message, void *user) {
  (void)user;
  if (level != MRY_LOG_INFO) {
    fprintf(stderr, "marey[%" PRId32 "]: %.*s\n", level, (int)message.len, message.data);
  }
}

/* A stroke as it is drawn here: a limb, its side, up to seven points in clip pixels. */
typedef struct drawn {
  const char *label;
  int32_t side;
  size_t count;
  mry_point points[7];
} drawn;

/* The first frame of the bundled camel, drawn by hand. */
static const drawn camel[] = {
  { "body", MRY_SIDE_MID, 3, { { 121, 94 }, { 192, 96 }, { 264, 102 } } },
  { "neck", MRY_SIDE_MID, 5, { { 264, 102 }, { 291, 100 }, { 305, 82 }, { 306, 63 }, { 305, 43 } } },
  { "head", MRY_SIDE_MID, 4,
    { { 305, 41 }, { 324, 36 }, { 343, 36 }, { 357, 34 } } },
  { "tail", MRY_SIDE_MID, 5,
    { { 121, 92 }, { 117, 86 }, { 102, 88 }, { 88, 85 }, { 80, 77 } } },
  { "hind_near", MRY_SIDE_NEAR, 7,
    { { 121, 95 }, { 128, 115 }, { 135, 132 }, { 137, 148 }, { 122, 179 }, { 132, 192 }, { 141, 205 } } },
  { "hind_far", MRY_SIDE_FAR, 6,
    { { 121, 95 }, { 113, 124 }, { 96, 148 }, { 80, 162 }, { 74, 181 }, { 71, 195 } } },
  { "fore_near", MRY_SIDE_NEAR, 7,
    { { 264, 102 }, { 264, 129 }, { 280, 136 }, { 298, 143 }, { 295, 165 }, { 293, 181 }, { 295, 194 } } },
  { "fore_far", MRY_SIDE_FAR, 6,
    { { 264, 102 }, { 251, 126 }, { 251, 154 }, { 253, 179 }, { 261, 198 }, { 269, 209 } } },
};

/* Draws the rig on frame 0. */
static int draw(host *h, const mry_clip_info *clip, mry_rig *rig) {
  mry_status status = mry_rig_create(h->context, clip->width, clip->height, rig, &h->error);
  if (status != MRY_OK) {
    return failed(h, "mry_rig_create", status);
  }
  for (size_t i = 0; i < sizeof camel / sizeof camel[0]; i++) {
    const drawn *d = &camel[i];
    uint32_t limb = 0;
    status = mry_rig_add_limb(h->context, *rig, MRY_STR(d->label), d->side, &limb, &h->error);
    if (status != MRY_OK) {
      return failed(h, d->label, status);
    }
    status = mry_rig_set_stroke(h->context, *rig, limb, 0, d->points, d->count, MRY_FACING_UNKNOWN, &h->error);
    if (status != MRY_OK) {
      return failed(h, d->label, status);
    }
    float length = 0.0f;
    status = mry_rig_get_length_hint(h->context, *rig, limb, &length, &h->error);
    if (status != MRY_OK) {
      return failed(h, d->label, status);
    }
    printf("drew %s, %.0f pixels long\n", d->label, (double)length);
  }
  return 1;
}

/* Watches a job to its end, a line for every stage. */
static int watch(host *h, mry_job job) {
  mry_job_state state = MRY_JOB_STATE_INIT;
  char stage[sizeof state.stage] = "";
  for (;;) {
    mry_status status = mry_job_wait(h->context, job, UINT64_C(50) * 1000 * 1000, &h->error);
    if (status != MRY_OK && status != MRY_PENDING) {
      return failed(h, "job", status);
    }
    mry_status polled = mry_job_poll(h->context, job, &state, &h->error);
    if (polled != MRY_OK) {
      return failed(h, "mry_job_poll", polled);
    }
    if (strcmp(stage, state.stage) != 0) {
      memcpy(stage, state.stage, sizeof stage);
      printf("%3.0f%% %s\n", 100.0 * state.fraction, stage);
      fflush(stdout);
    }
    if (status == MRY_OK) {
      return 1;
    }
  }
}

/* Starts tracking and changes its mind: a cancel returns at once, and the job ends soon after. */
static int cancel_one(host *h, mry_clip clip, mry_rig rig) {
  mry_track_desc desc = MRY_TRACK_DESC_INIT;
  desc.clip = clip;
  desc.rig = rig;
  mry_job job;
  mry_status status = mry_job_start_track(h->context, &desc, &job, &h->error);
  if (status != MRY_OK) {
    return failed(h, "mry_job_start_track", status);
  }
  status = mry_job_cancel(h->context, job, &h->error);
  if (status != MRY_OK) {
    return failed(h, "mry_job_cancel", status);
  }
  status = mry_job_wait(h->context, job, MRY_FOREVER, &h->error);
  if (status != MRY_CANCELLED) {
    return failed(h, "a cancelled job", status);
  }
  puts("tracking was cancelled");
  mry_job_destroy(h->context, job);
  return 1;
}

/* Tracks, and says which stroke would help most. */
static int track(host *h, mry_clip clip, mry_rig rig) {
  mry_track_desc desc = MRY_TRACK_DESC_INIT;
  desc.clip = clip;
  desc.rig = rig;
  mry_job job;
  mry_status status = mry_job_start_track(h->context, &desc, &job, &h->error);
  if (status != MRY_OK) {
    return failed(h, "mry_job_start_track", status);
  }
  if (!watch(h, job)) {
    return 0;
  }
  mry_motion motion;
  status = mry_job_take_motion(h->context, job, &motion, &h->error);
  if (status != MRY_OK) {
    return failed(h, "mry_job_take_motion", status);
  }
  mry_job_destroy(h->context, job);
  mry_correction next = MRY_CORRECTION_INIT;
  status = mry_motion_get_correction(h->context, motion, rig, 0, &next, &h->error);
  if (status == MRY_OK) {
    char name[64];
    size_t size = 0;
    status = mry_motion_get_track(h->context, motion, next.track, name, sizeof name, &size, NULL, NULL, &h->error);
    if (status != MRY_OK) {
      return failed(h, "mry_motion_get_track", status);
    }
    printf("least certain: %s on frame %" PRIu64 "\n", name, next.frame);
  } else if (status != MRY_E_NOT_FOUND) {
    return failed(h, "mry_motion_get_correction", status);
  }
  mry_motion_destroy(h->context, motion);
  return 1;
}

/* Prints the box around the creature in one frame, read part by part as a renderer would. */
static int look(host *h, mry_creature creature, const mry_creature_info *info) {
  float low[3] = { 1e30f, 1e30f, 1e30f };
  float high[3] = { -1e30f, -1e30f, -1e30f };
  for (uint32_t part = 0; part < info->part_count; part++) {
    size_t count = 0;
    mry_status status = mry_creature_read_vertices(h->context, creature, part, 0, NULL, NULL, NULL, 0, &count, &h->error);
    if (status != MRY_OK) {
      return failed(h, "mry_creature_read_vertices", status);
    }
    float *positions = malloc(count * 3 * sizeof *positions);
    if (positions == NULL) {
      fputs("creature: out of memory\n", stderr);
      return 0;
    }
    status = mry_creature_read_vertices(h->context, creature, part, 0, positions, NULL, NULL, count, &count, &h->error);
    if (status != MRY_OK) {
      free(positions);
      return failed(h, "mry_creature_read_vertices", status);
    }
    for (size_t i = 0; i < count * 3; i++) {
      low[i % 3] = positions[i] < low[i % 3] ? positions[i] : low[i % 3];
      high[i % 3] = positions[i] > high[i % 3] ? positions[i] : high[i % 3];
    }
    free(positions);
  }
  printf("frame 0 is %.0f x %.0f x %.0f units\n", (double)(high[0] - low[0]), (double)(high[1] - low[1]),
         (double)(high[2] - low[2]));
  return 1;
}

/* Reconstructs, looks, writes. */
static int reconstruct(host *h, mry_clip clip, mry_rig rig, const char *out) {
  mry_creature_desc desc = MRY_CREATURE_DESC_INIT;
  desc.clip = clip;
  desc.rig = rig;
  mry_job job;
  mry_status status = mry_job_start_creature(h->context, &desc, &job, &h->error);
  if (status != MRY_OK) {
    return failed(h, "mry_job_start_creature", status);
  }
  if (!watch(h, job)) {
    return 0;
  }
  mry_creature creature;
  status = mry_job_take_creature(h->context, job, &creature, &h->error);
  if (status != MRY_OK) {
    return failed(h, "mry_job_take_creature", status);
  }
  mry_creature_info info = MRY_CREATURE_INFO_INIT;
  status = mry_creature_get_info(h->context, creature, &info, &h->error);
  if (status != MRY_OK) {
    return failed(h, "mry_creature_get_info", status);
  }
  printf("%" PRIu32 " parts on %" PRIu32 " bones, %" PRIu64 " triangles, %" PRIu64 " frames\n", info.part_count,
         info.bone_count, info.triangle_count, info.frame_count);
  if (!look(h, creature, &info)) {
    return 0;
  }
  status = mry_creature_write_glb(h->context, creature, MRY_STR(out), 0.0f, &h->error);
  if (status != MRY_OK) {
    return failed(h, out, status);
  }
  printf("wrote %s\n", out);
  return 1;
}

static int run(host *h, const char *path, const char *out, const char *strokes) {
  mry_clip clip;
  mry_status status = mry_clip_open(h->context, MRY_STR(path), NULL, &clip, &h->error);
  if (status != MRY_OK) {
    return failed(h, path, status);
  }
  mry_clip_info info = MRY_CLIP_INFO_INIT;
  status = mry_clip_get_info(h->context, clip, &info, &h->error);
  if (status != MRY_OK) {
    return failed(h, path, status);
  }
  printf("%s: %s, %" PRIu32 "x%" PRIu32 ", %" PRIu64 " frames\n", path, info.source, info.width, info.height,
         info.frame_count);
  mry_rig rig;
  if (strokes != NULL) {
    status = mry_rig_read(h->context, MRY_STR(strokes), &rig, &h->error);
    if (status != MRY_OK) {
      return failed(h, strokes, status);
    }
  } else if (!draw(h, &info, &rig)) {
    return 0;
  }
  return cancel_one(h, clip, rig) && track(h, clip, rig) && reconstruct(h, clip, rig, out);
}

int main(int argc, char **argv) {
  if (argc != 3 && argc != 4) {
    fprintf(stderr, "usage: %s CLIP OUT.glb [STROKES.json]\n", argv[0]);
    return 2;
  }
  host h = { NULL, MRY_ERROR_INIT };
  mry_context_desc desc = MRY_CONTEXT_DESC_INIT;
  desc.log = log_line;
  mry_status status = mry_context_create(&desc, &h.context, &h.error);
  if (status != MRY_OK) {
    failed(&h, "mry_context_create", status);
    return 4;
  }
  int good = run(&h, argv[1], argv[2], argc == 4 ? argv[3] : NULL);
  mry_context_destroy(h.context);
  return good ? 0 : 4;
}
