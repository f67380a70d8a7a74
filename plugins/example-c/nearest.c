/*
 * A whole tracker in C: every limb keeps its shape and goes where the picture around it goes.
 *
 * From frame to frame each limb is shifted by the whole number of pixels that makes a strip of pixels along it look
 * most like it did (sum of absolute differences), and what is missed at the next drawn stroke is shared out evenly over
 * the frames before it. It follows what moves without turning; it is an example, not a rival of the built-in tracker.
 *
 * Build:   cc -shared -fPIC -O2 -fvisibility=hidden -I INCLUDE nearest.c -o nearest.so
 * Try:     marey plugin check nearest.so
 * Install: cp nearest.so ~/.local/share/marey/plugins/
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */

#include <marey/plugin.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What a person can choose. */

static const mry_plugin_parameter reach = {
    .struct_size = sizeof(mry_plugin_parameter),
    .kind = MRY_PLUGIN_WHOLE,
    .id = "reach",
    .label = "Reach",
    .about = "How far a limb may go from one frame to the next.",
    .group = "Search",
    .unit = "px",
    .low = 1.0,
    .high = 64.0,
    .default_value = 8.0,
    .step = 1.0,
};

static const mry_plugin_parameter *const parameters[] = {&reach};

static const mry_plugin_descriptor nearest = {
    .struct_size = sizeof(mry_plugin_descriptor),
    .kind = MRY_PLUGIN_TRACKER,
    .id = "org.marey.example-c.nearest",
    .name = "Nearest (C example)",
    .vendor = "Marey",
    .version = "1.0.0",
    .about = "Shifts each limb to where the picture around it went. An example for authors of plugins in C.",
    .parameters = parameters,
    .parameter_count = 1,
};

/* An instance. */

typedef struct {
    mry_plugin_instance face; /* what the host sees; first, so that a pointer to it is one to this */
    int reach;
} tracker;

static const mry_plugin_host *the_host;

static int32_t fail(mry_plugin_error *error, int32_t status, const char *message)
{
    if (error != NULL)
        snprintf(error->message, sizeof error->message, "%s", message);
    return status;
}

/* The pixel nearest to a place; places outside the image have the colour of its border. */
static const uint8_t *pixel(const mry_plugin_frame *frame, int x, int y)
{
    x = x < 0 ? 0 : x >= (int)frame->width ? (int)frame->width - 1 : x;
    y = y < 0 ? 0 : y >= (int)frame->height ? (int)frame->height - 1 : y;
    return frame->pixels + (size_t)y * frame->stride_bytes + 3 * (size_t)x;
}

/* How much the strip along `points` in `a` differs from the strip shifted by (dx, dy) in `b`. */
static uint64_t difference(const mry_plugin_frame *a, const mry_plugin_frame *b, const mry_plugin_point *points,
                           uint32_t count, int dx, int dy)
{
    enum { half_width = 3 };
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        int x = (int)points[i].x, y = (int)points[i].y;
        for (int v = -half_width; v <= half_width; v++)
            for (int u = -half_width; u <= half_width; u++) {
                const uint8_t *p = pixel(a, x + u, y + v), *q = pixel(b, x + u + dx, y + v + dy);
                for (int c = 0; c < 3; c++)
                    sum += (uint64_t)abs((int)p[c] - (int)q[c]);
            }
    }
    return sum;
}

/* The best shift from frame `from` to frame `to`; of equal ones the shortest. */
static int32_t best_shift(const mry_plugin_job *job, uint64_t from, uint64_t to, const mry_plugin_point *points,
                          uint32_t count, int reach_, int *out_x, int *out_y)
{
    mry_plugin_frame a = {.struct_size = sizeof a}, b = {.struct_size = sizeof b};
    int32_t status = job->get_frame(job, from, &a);
    if (status != MRY_PLUGIN_OK)
        return status;
    status = job->get_frame(job, to, &b);
    if (status == MRY_PLUGIN_OK) {
        uint64_t best = UINT64_MAX;
        for (int dy = -reach_; dy <= reach_; dy++)
            for (int dx = -reach_; dx <= reach_; dx++) {
                uint64_t cost = difference(&a, &b, points, count, dx, dy) * 1024 + (uint64_t)(dx * dx + dy * dy);
                if (cost < best)
                    best = cost, *out_x = dx, *out_y = dy;
            }
        job->release_frame(job, &b);
    }
    job->release_frame(job, &a);
    return status;
}

/* Follows a limb from a drawn stroke to the next one, or to the clip's end; `places` has room for one stroke a frame. */
static int32_t follow(const tracker *self, const mry_plugin_clip *clip, const mry_plugin_job *job,
                      const mry_plugin_stroke *from, const mry_plugin_stroke *to, mry_plugin_point *places,
                      double done, double share)
{
    uint32_t count = from->point_count;
    uint64_t last = to != NULL ? to->frame : clip->frame_count - 1;
    memcpy(places, from->points, count * sizeof *places);
    for (uint64_t f = from->frame + 1; f <= last; f++) {
        double part = (double)(f - from->frame) / (double)(last - from->frame + 1);
        if (job->progress(job, done + share * part, NULL) != MRY_PLUGIN_CONTINUE)
            return MRY_PLUGIN_CANCELLED;
        mry_plugin_point *now = places + (f - from->frame) * count;
        const mry_plugin_point *before = now - count;
        int dx = 0, dy = 0;
        int32_t status = best_shift(job, f - 1, f, before, count, self->reach, &dx, &dy);
        if (status != MRY_PLUGIN_OK)
            return status;
        for (uint32_t i = 0; i < count; i++) {
            now[i].x = before[i].x + (float)dx;
            now[i].y = before[i].y + (float)dy;
        }
    }
    /* What the last frame misses the next stroke by, each frame before it misses its share of. */
    for (uint64_t f = from->frame + 1; to != NULL && f < last; f++) {
        const mry_plugin_point *end = places + (last - from->frame) * count;
        mry_plugin_point *now = places + (f - from->frame) * count;
        float part = (float)(f - from->frame) / (float)(last - from->frame);
        for (uint32_t i = 0; i < count; i++) {
            now[i].x += part * (to->points[i].x - end[i].x);
            now[i].y += part * (to->points[i].y - end[i].y);
        }
    }
    return MRY_PLUGIN_OK;
}

static int32_t put(const mry_plugin_job *job, const mry_plugin_stroke *from, const mry_plugin_point *places,
                   uint64_t first, uint64_t end)
{
    for (uint64_t f = first; f < end; f++) {
        const mry_plugin_point *at = f < from->frame ? from->points : places + (f - from->frame) * from->point_count;
        int32_t status = job->put_stroke(job, from->limb, f, at, NULL, NULL, from->point_count);
        if (status != MRY_PLUGIN_OK)
            return status;
    }
    return MRY_PLUGIN_OK;
}

/* The next stroke of a limb in the list, from index `at` on. */
static const mry_plugin_stroke *stroke_of(const mry_plugin_rig *rig, uint32_t limb, uint32_t *at)
{
    while (*at < rig->stroke_count) {
        const mry_plugin_stroke *stroke = &rig->strokes[(*at)++];
        if (stroke->limb == limb)
            return stroke;
    }
    return NULL;
}

static int32_t track(const mry_plugin_instance *instance, const mry_plugin_clip *clip, const mry_plugin_rig *rig,
                     const mry_plugin_job *job, mry_plugin_error *error)
{
    const tracker *self = (const tracker *)instance;
    if (job->progress(job, 0.0, "shifting limbs") != MRY_PLUGIN_CONTINUE)
        return MRY_PLUGIN_CANCELLED;
    for (uint32_t limb = 0; limb < rig->limb_count; limb++) {
        uint32_t at = 0;
        const mry_plugin_stroke *from = stroke_of(rig, limb, &at);
        if (from == NULL)
            return fail(error, MRY_PLUGIN_E_INVALID, "a limb has no stroke; draw it on one frame");
        mry_plugin_point *places = calloc((size_t)clip->frame_count * from->point_count, sizeof *places);
        if (places == NULL)
            return fail(error, MRY_PLUGIN_E_FAILED, "there is no memory for a limb in all frames");
        uint64_t first = 0; /* frames before the first stroke keep it as it is */
        int32_t status = MRY_PLUGIN_OK;
        while (from != NULL && status == MRY_PLUGIN_OK) {
            const mry_plugin_stroke *to = stroke_of(rig, limb, &at);
            double share = 1.0 / (double)rig->limb_count;
            status = follow(self, clip, job, from, to, places, share * limb, share);
            if (status == MRY_PLUGIN_OK)
                status = put(job, from, places, first, to != NULL ? to->frame : clip->frame_count);
            first = to != NULL ? to->frame : clip->frame_count;
            from = to;
        }
        free(places);
        if (status < 0)
            return fail(error, status, "a frame cannot be read, or a stroke was not taken");
        if (status != MRY_PLUGIN_OK)
            return status;
    }
    return MRY_PLUGIN_OK;
}

static void destroy(const mry_plugin_instance *instance)
{
    free(instance->data);
}

/* The library. */

static int32_t init(const mry_plugin_host *host, mry_plugin_error *error)
{
    (void)error;
    the_host = host;
    return MRY_PLUGIN_OK;
}

static uint32_t get_count(void)
{
    return 1;
}

static const mry_plugin_descriptor *get_descriptor(uint32_t index)
{
    return index == 0 ? &nearest : NULL;
}

static int32_t create(uint32_t index, const mry_plugin_value *values, uint32_t value_count,
                      const mry_plugin_instance **out_instance, mry_plugin_error *error)
{
    if (index != 0)
        return fail(error, MRY_PLUGIN_E_INVALID, "there is one plugin");
    tracker *self = calloc(1, sizeof *self);
    if (self == NULL)
        return fail(error, MRY_PLUGIN_E_FAILED, "there is no memory");
    self->face.struct_size = sizeof self->face;
    self->face.data = self;
    self->face.destroy = destroy;
    self->face.track = track;
    self->reach = (int)reach.default_value;
    for (uint32_t i = 0; i < value_count; i++)
        if (strcmp(values[i].id, reach.id) == 0)
            self->reach = (int)values[i].number;
    *out_instance = &self->face;
    if (the_host->log != NULL)
        the_host->log(the_host, MRY_PLUGIN_LOG_INFO, "made a tracker");
    return MRY_PLUGIN_OK;
}

MRY_PLUGIN_EXPORT const mry_plugin_entry mry_plugin_entry_v1 = {
    .struct_size = sizeof(mry_plugin_entry),
    .abi_major = MRY_PLUGIN_ABI_MAJOR,
    .abi_minor = MRY_PLUGIN_ABI_MINOR,
    .init = init,
    .get_count = get_count,
    .get_descriptor = get_descriptor,
    .create = create,
};
