/*
 * Plugins that are broken on purpose. Without a flag this is a good tracker, which shifts every stroke to the right by
 * its version; each flag breaks it in one way. The tests of plugins/loader compile it once for each.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */

#define _GNU_SOURCE
#include <marey/plugin.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Tests make builds of other versions by writing over these bytes. */
static const volatile uint32_t version[2] = {0x59524d56u, 1u};

#ifndef STATE_VERSION
#define STATE_VERSION 1u
#endif

#ifdef UNDEFINED_SYMBOL
void nobody_has_this_function(void);
#endif

#if defined(EXIT_ON_LOAD) || defined(CRASH_ON_LOAD) || defined(HANG_ON_LOAD)
__attribute__((constructor)) static void on_load(void)
{
#if defined(EXIT_ON_LOAD)
    _exit(0);
#elif defined(CRASH_ON_LOAD)
    *(volatile int *)8 = 1;
#else
    for (;;)
        sleep(1);
#endif
}
#endif

static const mry_plugin_parameter lift = {
    .struct_size = sizeof(mry_plugin_parameter),
    .kind = MRY_PLUGIN_NUMBER,
    .id = "lift",
    .label = "Lift",
    .unit = "px",
    .low = 0.0,
#ifdef NARROW_RANGE
    .high = 1.0,
#else
    .high = 50.0,
#endif
#ifdef BAD_DESCRIPTOR
    .default_value = NAN,
#endif
};

static const mry_plugin_parameter *const parameters[] = {&lift};

static const mry_plugin_descriptor descriptor = {
    .struct_size = sizeof(mry_plugin_descriptor),
    .kind = MRY_PLUGIN_TRACKER,
#ifdef ID
    .id = ID,
#else
    .id = "org.marey.bad",
#endif
    .name = "Broken on purpose",
    .version = "1.0.0",
    .parameters = parameters,
    .parameter_count = 1,
    .state_version = STATE_VERSION,
};

typedef struct {
    mry_plugin_instance face;
    float lift;
    uint32_t calls;
} tracker;

static int32_t fail(mry_plugin_error *error, int32_t status, const char *message)
{
    snprintf(error->message, sizeof error->message, "%s", message);
    return status;
}

static const mry_plugin_stroke *drawn(const mry_plugin_rig *rig, uint32_t limb)
{
    for (uint32_t i = 0; i < rig->stroke_count; i++)
        if (rig->strokes[i].limb == limb)
            return &rig->strokes[i];
    return NULL;
}

static int32_t track(const mry_plugin_instance *instance, const mry_plugin_clip *clip, const mry_plugin_rig *rig,
                     const mry_plugin_job *job, mry_plugin_error *error)
{
    tracker *self = instance->data;
    self->calls++;
    (void)error;
#if defined(ENDLESS)
    for (volatile int i = 0;; i++) {
    }
#elif defined(SLOW)
    sleep(2);
#elif defined(CRASH)
    *(volatile int *)8 = 1;
#elif defined(FAILS)
    return fail(error, MRY_PLUGIN_E_FAILED, "the model is not\nthere");
#elif defined(WRONG_STATUS)
    return 77;
#elif defined(FALSE_CANCEL)
    return MRY_PLUGIN_CANCELLED;
#elif defined(DEAF)
    for (int i = 0; i < 1000; i++) {
        job->progress(job, 0.5, "not listening");
        usleep(1000);
    }
#elif defined(PATIENT)
    for (int i = 0; job->progress(job, i / 1e6, "waiting for a cancel") == MRY_PLUGIN_CONTINUE; i++)
        usleep(1000);
    return MRY_PLUGIN_CANCELLED;
#endif
#ifdef UNDEFINED_SYMBOL
    nobody_has_this_function();
#endif
    mry_plugin_frame frame = {.struct_size = sizeof frame};
    int32_t status = job->get_frame(job, 0, &frame);
    if (status != MRY_PLUGIN_OK)
        return status;
#if defined(KEEPS_FRAMES)
    for (int i = 0; i < 5; i++)
        job->get_frame(job, 0, &frame);
#elif defined(RELEASES_TWICE)
    mry_plugin_frame again = frame;
    job->release_frame(job, &frame);
    job->release_frame(job, &again);
    job->release_frame(job, &again);
#else
    job->release_frame(job, &frame);
#endif
#ifdef ABSURD_FRAME
    if (job->get_frame(job, clip->frame_count, &frame) != MRY_PLUGIN_E_INVALID)
        return fail(error, MRY_PLUGIN_E_FAILED, "the host lent a frame that there is not");
    frame.struct_size = 3;
    status = job->get_frame(job, 0, &frame);
    return fail(error, status, "as it should be");
#endif
    for (uint32_t limb = 0; limb < rig->limb_count; limb++) {
        const mry_plugin_stroke *stroke = drawn(rig, limb);
        uint32_t count = stroke->point_count;
        mry_plugin_point points[4096];
        float confidence[4096];
        if (count > 4095)
            return MRY_PLUGIN_E_FAILED;
        for (uint32_t i = 0; i <= count; i++) {
            const mry_plugin_point *p = &stroke->points[i < count ? i : count - 1];
            points[i].x = p->x + (float)version[1];
            points[i].y = p->y + self->lift + 1000.0f * (float)(self->calls - 1);
            confidence[i] = 0.5f;
        }
#ifdef NOT_A_NUMBER
        points[count / 2].x = NAN;
#endif
#ifdef FAR_AWAY
        points[0].y = 1e30f;
#endif
#ifdef BAD_CONFIDENCE
        confidence[0] = NAN;
#endif
#ifdef WRONG_COUNT
        count += 1;
#endif
#ifdef WRONG_LIMB
        limb += 7;
#endif
        for (uint64_t f = 0; f < clip->frame_count; f++) {
#ifdef MISSING_FRAME
            if (f == clip->frame_count / 2)
                continue;
#endif
#ifdef MISSING_LIMB
            continue;
#endif
            if (job->progress(job, 0.5, NULL) != MRY_PLUGIN_CONTINUE)
                return MRY_PLUGIN_CANCELLED;
            status = job->put_stroke(job, limb, f, points, NULL, confidence, count);
#ifndef IGNORES_ANSWERS
            if (status != MRY_PLUGIN_OK)
                return status;
#endif
        }
    }
    return MRY_PLUGIN_OK;
}

static int32_t save(const mry_plugin_instance *instance, uint8_t *bytes, size_t capacity, size_t *out_size,
                    mry_plugin_error *error)
{
    const tracker *self = instance->data;
    (void)error;
    *out_size = sizeof self->calls;
    if (capacity >= sizeof self->calls)
        memcpy(bytes, &self->calls, sizeof self->calls);
    return MRY_PLUGIN_OK;
}

static int32_t load(const mry_plugin_instance *instance, uint32_t state_version, const uint8_t *bytes, size_t size,
                    mry_plugin_error *error)
{
    tracker *self = instance->data;
#ifdef REFUSES_STATE
    return fail(error, MRY_PLUGIN_E_UNSUPPORTED, "of another age");
#endif
    if (state_version > STATE_VERSION || size != sizeof self->calls)
        return fail(error, MRY_PLUGIN_E_UNSUPPORTED, "not of a version that is known here");
    memcpy(&self->calls, bytes, size);
    return MRY_PLUGIN_OK;
}

static const mry_plugin_state_1 state = {.struct_size = sizeof state, .save = save, .load = load};

static const void *get_extension(const mry_plugin_instance *instance, const char *id)
{
    (void)instance;
    return strcmp(id, MRY_PLUGIN_STATE_1) == 0 ? &state : NULL;
}

static void destroy(const mry_plugin_instance *instance)
{
    free(instance->data);
}

static int32_t init(const mry_plugin_host *host, mry_plugin_error *error)
{
    (void)host;
#ifdef INIT_FAILS
    return fail(error, MRY_PLUGIN_E_FAILED, "no licence");
#endif
#ifdef SILENT_FAILURE
    return MRY_PLUGIN_E_FAILED;
#endif
    (void)error;
    return MRY_PLUGIN_OK;
}

static uint32_t get_count(void)
{
#ifdef NO_PLUGINS
    return 0;
#else
    return 1;
#endif
}

static const mry_plugin_descriptor *get_descriptor(uint32_t index)
{
#ifdef NULL_DESCRIPTOR
    return NULL;
#endif
    return index == 0 ? &descriptor : NULL;
}

static int32_t create(uint32_t index, const mry_plugin_value *values, uint32_t value_count,
                      const mry_plugin_instance **out_instance, mry_plugin_error *error)
{
    (void)index;
#ifdef CREATE_FAILS
    return fail(error, MRY_PLUGIN_E_FAILED, "no model file");
#endif
#ifdef CREATE_HANGS
    for (;;)
        sleep(1);
#endif
#ifdef NO_INSTANCE
    return MRY_PLUGIN_OK;
#endif
    tracker *self = calloc(1, sizeof *self);
    if (self == NULL)
        return fail(error, MRY_PLUGIN_E_FAILED, "no memory");
    self->face.struct_size = sizeof self->face;
    self->face.data = self;
    self->face.destroy = destroy;
#ifndef NO_TRACK
    self->face.track = track;
#else
    (void)track;
#endif
    self->face.get_extension = get_extension;
    for (uint32_t i = 0; i < value_count; i++)
        if (strcmp(values[i].id, "lift") == 0)
            self->lift = (float)values[i].number;
    *out_instance = &self->face;
    return MRY_PLUGIN_OK;
}

#ifdef OTHER_ABI
#define MAJOR 99u
#else
#define MAJOR MRY_PLUGIN_ABI_MAJOR
#endif

#ifdef MISSING_SYMBOL
#define mry_plugin_entry_v1 something_else
#endif

MRY_PLUGIN_EXPORT const mry_plugin_entry mry_plugin_entry_v1 = {
#ifdef SMALL_ENTRY
    .struct_size = 16,
#else
    .struct_size = sizeof(mry_plugin_entry),
#endif
    .abi_major = MAJOR,
    .abi_minor = MRY_PLUGIN_ABI_MINOR,
    .init = init,
    .get_count = get_count,
#ifndef NULL_FUNCTION
    .get_descriptor = get_descriptor,
#endif
    .create = create,
};
