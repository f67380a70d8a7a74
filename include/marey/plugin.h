/*
 * plugin.h: trackers, segmenters and deformers for Marey, written in C or C++.
 *
 * A plugin is a shared library that exports one thing, a table called mry_plugin_entry_v1. The host reads from it
 * what is inside, makes instances, and gives them work. A whole tracker in C is plugins/example-c/nearest.c; the guide
 * is docs/plugins.
 *
 *   host                                    plugin
 *   ----                                    ------
 *   dlopen, dlsym              ->           mry_plugin_entry_v1
 *   entry->init(host)          ->           once, before all else
 *   entry->get_descriptor(i)   ->           what is inside: kind, id, name, parameters
 *   entry->create(i, values)   ->           an instance, with the values that a person chose
 *   instance->track(..., job)  ->           the work
 *                              <-           job->get_frame, job->progress, job->put_stroke
 *   instance->destroy          ->
 *
 * Rules that hold everywhere:
 *
 * - Structs that start with struct_size may grow at their end. Set it to sizeof of the struct as you know it; read no
 *   field that lies past the struct_size you are given. Structs without it never change.
 * - Everything else new comes by extension: ask get_extension, of the host or of the instance, for "name/REVISION". An
 *   answer of NULL means no.
 * - Reserved fields are zero. Strings are UTF-8 and end with a NUL.
 * - What you are given is valid until your function returns, where nothing else is said, and is never yours to free.
 *   What you give is copied before the host's function returns, where nothing else is said.
 * - Statuses: 0 is done, below 0 an error whose text goes into the mry_plugin_error, 1 is cancelled.
 * - Threads: each function says on which thread it is called or may be called.
 *     [load-thread]      one thread, while the library is being loaded
 *     [instance-thread]  any thread, but one call at a time for each instance (create, the work and destroy alike)
 *     [any-thread]       any thread, several at a time
 * - Never let a C++ exception, a longjmp or an exit() out of your functions: the host cannot contain them.
 * - Never print: use host->log.
 *
 * Coordinates are pixels of the clip: x right, y down, the centre of the top-left pixel is (0.5, 0.5). Frames count
 * from 0.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */

#ifndef MAREY_PLUGIN_H
#define MAREY_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version: a host takes plugins of its own major version, older or newer in the minor one. */

#define MRY_PLUGIN_ABI_MAJOR 1u
#define MRY_PLUGIN_ABI_MINOR 0u

/** Put before the definition of mry_plugin_entry_v1; compile everything else with -fvisibility=hidden. */
#if defined(_WIN32)
#define MRY_PLUGIN_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define MRY_PLUGIN_EXPORT __attribute__((visibility("default")))
#else
#define MRY_PLUGIN_EXPORT
#endif

/* ---- Statuses ---------------------------------------------------------------------------------------------------- */

/** Done. */
#define MRY_PLUGIN_OK 0
/** Stopped because the host asked for it: pass it on when a call of yours to the host returned it. */
#define MRY_PLUGIN_CANCELLED 1
/** What was given cannot be worked on; the message says what, where, and what to do about it. */
#define MRY_PLUGIN_E_INVALID (-1)
/** Something went wrong that is not the user's fault: no memory, a model file that is missing. */
#define MRY_PLUGIN_E_FAILED (-2)
/** Not done by this plugin. */
#define MRY_PLUGIN_E_UNSUPPORTED (-3)
/** A panic or exception, contained. The instance is given no more work. */
#define MRY_PLUGIN_E_PANICKED (-4)
/** The instance panicked before. */
#define MRY_PLUGIN_E_POISONED (-5)

/** The host's words for a failure. Fill in message (snprintf) whenever you return a status below 0. */
typedef struct mry_plugin_error {
    uint32_t struct_size;
    uint32_t reserved0;
    char message[512];
} mry_plugin_error;

/* ---- What there is to work on ------------------------------------------------------------------------------------ */

/** A place in clip pixels. */
typedef struct mry_plugin_point {
    float x;
    float y;
} mry_plugin_point;

/** The clip. Its frames come from mry_plugin_job.get_frame, one by one. */
typedef struct mry_plugin_clip {
    uint32_t struct_size;
    uint32_t width;
    uint32_t height;
    uint32_t reserved0;
    uint64_t frame_count;
    /** Mean frames a second. */
    double fps;
} mry_plugin_clip;

/** One frame, lent by the host: 3 bytes a pixel, red, green, blue, sRGB; rows from the top. */
typedef struct mry_plugin_frame {
    uint32_t struct_size;
    uint32_t width;
    uint32_t height;
    /** From one row's start to the next's; at least 3 * width. */
    uint32_t stride_bytes;
    const uint8_t *pixels;
    /** The host's own. */
    void *token;
} mry_plugin_frame;

#define MRY_PLUGIN_SIDE_UNKNOWN 0
/** Of a pair, the one toward the viewer. */
#define MRY_PLUGIN_SIDE_NEAR 1
/** Of a pair, the one away from the viewer, often hidden. */
#define MRY_PLUGIN_SIDE_FAR 2
/** Not of a pair: body, neck, head, tail. */
#define MRY_PLUGIN_SIDE_MID 3

/** The first point of the limb is the end that hangs from its parent. */
#define MRY_PLUGIN_LIMB_ROOTED_AT_START 1u
/** Nothing hangs from the limb's other end. */
#define MRY_PLUGIN_LIMB_TERMINAL 2u

/** A body part that does not branch. */
typedef struct mry_plugin_limb {
    /** The user's name for it, unique in the rig. */
    const char *label;
    /** MRY_PLUGIN_SIDE_... */
    int32_t side;
    /** The limb it hangs from, or -1 for none. */
    int32_t parent;
    /** How many points the limb has, in every stroke and in every frame; at least 2. */
    uint32_t point_count;
    /** MRY_PLUGIN_LIMB_... */
    uint32_t flags;
} mry_plugin_limb;

#define MRY_PLUGIN_FACING_UNKNOWN 0
/** The stroke's end is nearer to the viewer than its start. */
#define MRY_PLUGIN_FACING_TOWARD 1
/** The stroke's end is farther from the viewer than its start. */
#define MRY_PLUGIN_FACING_AWAY 2

/** A limb as the user drew it on one frame, resampled by the host to the limb's point_count points at equal steps. */
typedef struct mry_plugin_stroke {
    const mry_plugin_point *points;
    uint64_t frame;
    uint32_t limb;
    /** limbs[limb].point_count. */
    uint32_t point_count;
    /** MRY_PLUGIN_FACING_... */
    int32_t facing;
    uint32_t reserved0;
} mry_plugin_stroke;

/** A brush stroke that says what belongs to the creature, or does not. */
typedef struct mry_plugin_paint {
    const mry_plugin_point *points;
    uint64_t frame;
    uint32_t point_count;
    /** 1 for the creature, 0 for the background. */
    uint32_t foreground;
    /** The brush's, in pixels. */
    float radius;
    uint32_t reserved0;
} mry_plugin_paint;

/** A whole mask that the user painted: a byte a pixel, 255 in and 0 out, rows of clip.width bytes from the top. */
typedef struct mry_plugin_painted {
    const uint8_t *pixels;
    uint64_t frame;
} mry_plugin_painted;

/** What the user drew. Strokes and paints rise by frame; a limb is drawn at most once on a frame. */
typedef struct mry_plugin_rig {
    uint32_t struct_size;
    uint32_t limb_count;
    const mry_plugin_limb *limbs;
    const mry_plugin_stroke *strokes;
    const mry_plugin_paint *paints;
    const mry_plugin_painted *painted;
    uint32_t stroke_count;
    uint32_t paint_count;
    uint32_t painted_count;
    uint32_t reserved0;
} mry_plugin_rig;

/** A limb in every frame. The three lists hold frame_count * point_count entries, frame after frame. */
typedef struct mry_plugin_track {
    const char *label;
    const mry_plugin_point *points;
    /** 1 where the point is seen, 0 where it is hidden or outside the image. */
    const uint8_t *visible;
    /** How far the place is to be trusted, 0 to 1. */
    const float *confidence;
    uint32_t point_count;
    uint32_t reserved0;
} mry_plugin_track;

/** The rig's limbs, tracked: one track a limb, in the rig's order. */
typedef struct mry_plugin_motion {
    uint32_t struct_size;
    uint32_t track_count;
    const mry_plugin_track *tracks;
} mry_plugin_motion;

/** A plane mesh at rest. */
typedef struct mry_plugin_mesh {
    uint32_t struct_size;
    uint32_t point_count;
    const mry_plugin_point *points;
    /** Three indices a triangle, all turned the same way. */
    const uint32_t *triangles;
    uint32_t triangle_count;
    uint32_t reserved0;
} mry_plugin_mesh;

/** A handle at point a; b is as a. */
#define MRY_PLUGIN_HANDLE_POINT 1
/** A straight bone from its root a to its tip b. */
#define MRY_PLUGIN_HANDLE_BONE 2

/** What a person moves to deform a mesh. */
typedef struct mry_plugin_handle {
    /** MRY_PLUGIN_HANDLE_... */
    int32_t kind;
    uint32_t reserved0;
    mry_plugin_point a;
    mry_plugin_point b;
} mry_plugin_handle;

/* ---- What the host does for a plugin ----------------------------------------------------------------------------- */

/** What progress answers. Neither is 0 or 1, so that a mistake shows. */
#define MRY_PLUGIN_CONTINUE 0x100
#define MRY_PLUGIN_CANCEL 0x200

typedef struct mry_plugin_job mry_plugin_job;

/** One piece of work: what the plugin may ask of the host while it lasts. Valid until the work's function returns. */
struct mry_plugin_job {
    uint32_t struct_size;
    uint32_t reserved0;
    /** The host's own. */
    void *data;

    /**
     * Says how far the work is, 0 to 1, and what is being done (a word or two; NULL for what it was before), and asks
     * whether to go on. Call it at least every 100 ms: a plugin that is silent for long is taken to hang, and is
     * switched off. It takes well under a microsecond.
     * Returns MRY_PLUGIN_CONTINUE, or MRY_PLUGIN_CANCEL: return MRY_PLUGIN_CANCELLED soon.  [any-thread]
     */
    int32_t (*progress)(const mry_plugin_job *job, double fraction, const char *stage);

    /**
     * Lends a frame, decoded now or before; nothing is copied. Set frame->struct_size. Give it back by release_frame,
     * at the latest before the work's function returns.
     * Returns MRY_PLUGIN_OK, E_INVALID (there is no such frame), E_FAILED (it is damaged), CANCELLED.  [any-thread]
     */
    int32_t (*get_frame)(const mry_plugin_job *job, uint64_t index, mry_plugin_frame *frame);

    /** Gives a frame back. Its pixels are not to be read after.  [any-thread] */
    void (*release_frame)(const mry_plugin_job *job, mry_plugin_frame *frame);

    /**
     * A tracker's result, a limb on a frame at a time, in any order: every limb on every frame, but for the frames it
     * is drawn on, which the host knows. `count` is the limb's point_count; the places must be finite. `visible` (1 or
     * 0) and `confidence` (0 to 1) hold as many entries; NULL means all seen, all certain.
     * Returns MRY_PLUGIN_OK; E_INVALID (not what was asked for: the job will fail, return it), CANCELLED.  [any-thread]
     */
    int32_t (*put_stroke)(const mry_plugin_job *job, uint32_t limb, uint64_t frame, const mry_plugin_point *points,
                          const uint8_t *visible, const float *confidence, uint32_t count);

    /**
     * A segmenter's result, a frame at a time, in any order: every frame of the clip. A byte a pixel, 0 for out and
     * anything else for in; `width` and `height` are the clip's; `stride_bytes` from one row's start to the next's.
     * Returns as put_stroke.  [any-thread]
     */
    int32_t (*put_mask)(const mry_plugin_job *job, uint64_t frame, const uint8_t *pixels, uint32_t width,
                        uint32_t height, size_t stride_bytes);
};

#define MRY_PLUGIN_LOG_ERROR 1
#define MRY_PLUGIN_LOG_WARNING 2
#define MRY_PLUGIN_LOG_INFO 3

typedef struct mry_plugin_host mry_plugin_host;

/** The host. Valid for as long as the library is loaded, which is to the end of the process. */
struct mry_plugin_host {
    uint32_t struct_size;
    /** The host's own version of this interface. */
    uint32_t abi_major;
    uint32_t abi_minor;
    uint32_t reserved0;
    /** Such as "marey" and "0.1.0". */
    const char *name;
    const char *version;
    /** The host's own. */
    void *data;
    /** A line of the log, without a line end.  [any-thread] */
    void (*log)(const mry_plugin_host *host, int32_t level, const char *message);
    /** A table of more functions, by "name/REVISION"; NULL for one that the host does not have.  [any-thread] */
    const void *(*get_extension)(const mry_plugin_host *host, const char *id);
};

/* ---- What a plugin is -------------------------------------------------------------------------------------------- */

/** Any number from low to high. */
#define MRY_PLUGIN_NUMBER 0
/** A whole number from low to high. */
#define MRY_PLUGIN_WHOLE 1
/** 0 or 1. */
#define MRY_PLUGIN_SWITCH 2
/** One of `choices`, by its index. */
#define MRY_PLUGIN_CHOICE 3
/** A line of text. */
#define MRY_PLUGIN_TEXT 4
/** The path of a file. */
#define MRY_PLUGIN_FILE 5

/** For those who know the method; a host may fold it away. */
#define MRY_PLUGIN_ADVANCED 1u
/** Not to be shown. */
#define MRY_PLUGIN_HIDDEN 2u
/** A slider does better with the logarithm. */
#define MRY_PLUGIN_LOGARITHMIC 4u

/** What a person can choose. From it any host can draw a control; values live in the host. */
typedef struct mry_plugin_parameter {
    uint32_t struct_size;
    /** MRY_PLUGIN_NUMBER, ... */
    int32_t kind;
    /** Its name for ever: a-z, 0-9, '_', '-', '.'; at most 47 characters. */
    const char *id;
    /** What a person reads beside the control. */
    const char *label;
    /** What it does, a sentence; may be NULL. */
    const char *about;
    /** Where it stands among others, "Search/Fine"; may be NULL. */
    const char *group;
    /** "px", "frames", "degrees"; may be NULL. */
    const char *unit;
    /** NUMBER and WHOLE. */
    double low;
    double high;
    double default_value;
    /** One step of a slider; 0 for none. */
    double step;
    /** CHOICE: the names. */
    const char *const *choices;
    /** TEXT and FILE; may be NULL for "". */
    const char *default_text;
    /** It is shown only while the parameter of this id has the value visible_value; NULL for always. */
    const char *visible_if;
    double visible_value;
    uint32_t choice_count;
    /** MRY_PLUGIN_ADVANCED, ... */
    uint32_t flags;
} mry_plugin_parameter;

/** The value of one parameter. */
typedef struct mry_plugin_value {
    /** The parameter's id. */
    const char *id;
    /** All kinds but TEXT and FILE. */
    double number;
    /** TEXT and FILE; otherwise NULL. */
    const char *text;
} mry_plugin_value;

#define MRY_PLUGIN_TRACKER 1
#define MRY_PLUGIN_SEGMENTER 2
#define MRY_PLUGIN_DEFORMER 3

/** What one plugin of the library is. Static: valid and the same for as long as the library is loaded. */
typedef struct mry_plugin_descriptor {
    uint32_t struct_size;
    /** MRY_PLUGIN_TRACKER, ... */
    int32_t kind;
    /** Its name for ever, in reverse DNS: "org.example.nearest". a-z, 0-9, '.', '-', '_'; at most 127 characters. */
    const char *id;
    /** What a person reads. */
    const char *name;
    /** Who made it; may be NULL. */
    const char *vendor;
    /** Such as "1.2.0". */
    const char *version;
    /** What it is good at, a sentence or two; may be NULL. */
    const char *about;
    const mry_plugin_parameter *const *parameters;
    uint32_t parameter_count;
    /** Of the bytes that mry.state/1 saves; raise it when they change. */
    uint32_t state_version;
} mry_plugin_descriptor;

typedef struct mry_plugin_instance mry_plugin_instance;

/** One tracker, segmenter or deformer at work. Functions of other kinds are NULL. */
struct mry_plugin_instance {
    uint32_t struct_size;
    uint32_t reserved0;
    /** Yours. */
    void *data;

    /** Frees the instance. Called once.  [instance-thread] */
    void (*destroy)(const mry_plugin_instance *instance);

    /** TRACKER: follows every limb through the clip, and puts the strokes (job->put_stroke).  [instance-thread] */
    int32_t (*track)(const mry_plugin_instance *instance, const mry_plugin_clip *clip, const mry_plugin_rig *rig,
                     const mry_plugin_job *job, mry_plugin_error *error);

    /** SEGMENTER: cuts the creature out of every frame, and puts the masks (job->put_mask).  [instance-thread] */
    int32_t (*segment)(const mry_plugin_instance *instance, const mry_plugin_clip *clip, const mry_plugin_rig *rig,
                       const mry_plugin_motion *motion, const mry_plugin_job *job, mry_plugin_error *error);

    /**
     * DEFORMER: prepares all that does not change while the handles move, for `handles` where they lie at rest. The
     * host calls unbind on what comes out, before it destroys the instance.  [instance-thread]
     */
    int32_t (*bind)(const mry_plugin_instance *instance, const mry_plugin_mesh *mesh, const mry_plugin_handle *handles,
                    uint32_t handle_count, const mry_plugin_job *job, void **out_bound, mry_plugin_error *error);

    /**
     * DEFORMER: moves the mesh so that every handle is where `targets` say, of the same kinds and in the same order as
     * they were bound. `points` hold the shape to start from, one for each point of the mesh, and are given the new
     * one; after a failure they may hold anything.  [instance-thread]
     */
    int32_t (*solve)(const mry_plugin_instance *instance, void *bound, const mry_plugin_handle *targets,
                     uint32_t target_count, mry_plugin_point *points, uint32_t point_count, const mry_plugin_job *job,
                     mry_plugin_error *error);

    /** DEFORMER: frees what bind made. Called once for each.  [instance-thread] */
    void (*unbind)(const mry_plugin_instance *instance, void *bound);

    /** A table of more functions, by "name/REVISION"; NULL for one you do not have. May itself be NULL.  [any-thread] */
    const void *(*get_extension)(const mry_plugin_instance *instance, const char *id);
};

/**
 * What the library is. Define it as
 *
 *   MRY_PLUGIN_EXPORT const mry_plugin_entry mry_plugin_entry_v1 = { ... };
 */
typedef struct mry_plugin_entry {
    uint32_t struct_size;
    /** MRY_PLUGIN_ABI_MAJOR and MRY_PLUGIN_ABI_MINOR. */
    uint32_t abi_major;
    uint32_t abi_minor;
    uint32_t reserved0;

    /** Called once, first. Keep `host` for logging.  [load-thread] */
    int32_t (*init)(const mry_plugin_host *host, mry_plugin_error *error);

    /** How many plugins are inside; at most 64.  [any-thread] */
    uint32_t (*get_count)(void);

    /** What plugin `index` is.  [any-thread] */
    const mry_plugin_descriptor *(*get_descriptor)(uint32_t index);

    /**
     * Makes an instance of plugin `index`. There is a value for each parameter, checked against its range. The struct
     * that *out_instance is set to is yours until the host calls its destroy.  [instance-thread]
     */
    int32_t (*create)(uint32_t index, const mry_plugin_value *values, uint32_t value_count,
                      const mry_plugin_instance **out_instance, mry_plugin_error *error);
} mry_plugin_entry;

extern MRY_PLUGIN_EXPORT const mry_plugin_entry mry_plugin_entry_v1;

/* ---- Extensions of instances ------------------------------------------------------------------------------------- */

/** The id of mry_plugin_state_1. */
#define MRY_PLUGIN_STATE_1 "mry.state/1"

/**
 * What an instance has learnt and would miss, as bytes. When a new build of the library is loaded, the host saves the
 * old instance, makes a new one with the same values, and loads the bytes into it. An instance without this extension
 * is made anew from its values.
 */
typedef struct mry_plugin_state_1 {
    uint32_t struct_size;
    uint32_t reserved0;
    /**
     * Saves into `bytes`, which has room for `capacity`; *out_size is set to the bytes that are needed, also when they
     * do not fit, and then nothing is written. NULL with 0 asks for the size.  [instance-thread]
     */
    int32_t (*save)(const mry_plugin_instance *instance, uint8_t *bytes, size_t capacity, size_t *out_size,
                    mry_plugin_error *error);
    /** Loads what a build with this state_version saved; E_UNSUPPORTED for a version you cannot read.  [instance-thread] */
    int32_t (*load)(const mry_plugin_instance *instance, uint32_t state_version, const uint8_t *bytes, size_t size,
                    mry_plugin_error *error);
} mry_plugin_state_1;

#ifdef __cplusplus
}
#endif

#endif
