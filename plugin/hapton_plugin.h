#pragma once

/*
 * Plug-ins of Hapton, in C: effects and methods for haptics_node, devices for io_node. This header is all that a plug-in needs
 * (docs/plugins.md: how to write, compile and run one).
 *
 * A plug-in is a shared library that exports one or several of these constants:
 *   hapton_effect   (HAPTON_EFFECT)   haptics_node --effect FILE.so[:KEY=VALUE,...]
 *   hapton_method   (HAPTON_METHOD)   haptics_node --method FILE.so[:KEY=VALUE,...]
 *   hapton_device   (HAPTON_DEVICE)   io_node --device plugin:FILE.so[:KEY=VALUE,...]
 *
 * Units: m, s, N, Nm, rad. Frames: W is the world (x right, y up, z towards the person), S is the frame of the scene file.
 * Quaternions: w, x, y, z. Real time: step and read are called once a sample; write when the force changes or a new one has come, by one
 * of two threads. They, reset and set_materials must not wait, use the heap, lock or print; create, open, close and destroy may. No two
 * calls of one object overlap.
 * An object is what create or open returns. Each later call gets its pointer; Hapton does not use what it points to.
 */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Raised with each change that breaks plug-ins compiled before. Hapton compares it, and the sizes, when it loads the file. */
#define HAPTON_PLUGIN_ABI 1u

/* A parameter of the command line: FILE.so:KEY=VALUE,KEY=VALUE. The texts end with a 0 character and are valid only during the call. */
typedef struct hapton_parameter {
  const char* key;
  const char* value;
} hapton_parameter;

/* The parameters, and where to write why they are rejected: one line, at most why_size - 1 characters and a 0. */
typedef struct hapton_request {
  const hapton_parameter* parameters;
  size_t parameter_count;
  char* why;
  size_t why_size;
} hapton_request;

/* ---- Effects: a force in space, added to that of the method. */

/* What an effect knows of one sample. */
typedef struct hapton_effect_input {
  uint64_t sample;             /* counts the samples of the device; some may be left out */
  double time_s;               /* time of the sample since the first one after reset */
  double dt_s;                 /* since the sample before; above 0 */
  double position_m[3];        /* device point, W */
  double orientation[4];       /* stylus in W */
  double velocity_m_per_s[3];  /* velocity of the device point, W; mean of the last 8 differences */
  double scene_position_m[3];  /* origin of S in W: the knob box turns and moves the scene */
  double scene_orientation[4]; /* S in W */
  double contact_point_m[3];   /* where the probe is held on the surface, W; the device point in free space */
  double contact_force_n[3];   /* force of the method and of the scene's effects, W */
  uint32_t buttons;            /* one bit each, the first button in the lowest */
  int32_t contact;             /* 1: a surface is touched, or an effect of the scene acts; else 0 */
} hapton_effect_input;

/* Zero when step is called. */
typedef struct hapton_effect_output {
  double force_n[3];   /* acts on the hand, W; the shares of all effects are added */
  double torque_nm[3]; /* about the device point, W; felt only with a device whose motors turn the stylus */
} hapton_effect_output;

/* An effect. */
typedef struct hapton_effect_api {
  uint32_t abi;
  uint32_t api_size;
  uint32_t input_size;
  uint32_t output_size;
  const char* name;                               /* for log and report */
  double max_force_n;                             /* the largest force it ever gives, above 0, at most 100; a larger force cuts it off */
  double max_torque_nm;                           /* likewise, 0 to 10 */
  void* (*create)(const hapton_request* request); /* NULL: rejected, for the reason in request->why */
  void (*reset)(void* effect);                    /* a session begins, or the hand is elsewhere after a gap in the samples; may be NULL */
  void (*step)(void* effect, const hapton_effect_input* input, hapton_effect_output* output);
  void (*destroy)(void* effect); /* may be NULL */
} hapton_effect_api;

/* ---- Methods: the force of the scene's surfaces. */

/* How a surface feels. */
typedef struct hapton_material {
  double stiffness_n_per_m;
  double damping_ns_per_m;
  double friction_static;
  double friction_dynamic;
  int32_t two_sided; /* 0: contact only on the side that the normals point to */
  int32_t unused;
} hapton_material;

/* A mesh of the scene, in S. The arrays live until destroy returns. */
typedef struct hapton_object {
  const double* vertices_m;  /* x, y, z, x, ... */
  const uint32_t* triangles; /* three vertices each, counted from 0; counter-clockwise seen from outside */
  size_t vertex_count;
  size_t triangle_count;
  hapton_material material;
} hapton_object;

/* One sample. */
typedef struct hapton_method_input {
  double position_m[3];       /* device point, S */
  double dt_s;                /* since the sample before; above 0 */
  double orientation[4];      /* stylus in S */
  double velocity_m_per_s[3]; /* velocity of the hand, along the axes of S; mean of the last 8 differences */
  double time_s;              /* time of the sample since the first one after reset */
  uint32_t buttons;           /* one bit each, the first button in the lowest */
  uint32_t unused;
} hapton_method_input;

/* Zero when step is called, with the proxy at the device point and object -1. */
typedef struct hapton_method_output {
  double force_n[3]; /* acts on the hand, S */
  double proxy_m[3]; /* where the probe is drawn, S */
  int32_t contact;   /* 1: force_n is felt; 0: no force */
  int32_t object;    /* number of the touched object, from 0; -1: none, or unknown */
} hapton_method_output;

/* A method. */
typedef struct hapton_method_api {
  uint32_t abi;
  uint32_t api_size;
  uint32_t input_size;
  uint32_t output_size;
  uint32_t object_size;
  uint32_t unused;
  const char* name;
  double max_force_n; /* as in hapton_effect_api */
  void* (*create)(const hapton_request* request, const hapton_object* objects, size_t object_count);
  void (*reset)(void* method, const double position_m[3]); /* forget all contact; the probe is at this position, S */
  void (*step)(void* method, const hapton_method_input* input, hapton_method_output* output);
  /* The materials have changed: one for each object. Real time, like step. NULL: the materials given to create stay. */
  void (*set_materials)(void* method, const hapton_material* materials, size_t count);
  void (*destroy)(void* method); /* may be NULL */
} hapton_method_api;

/* ---- Devices. */

/* Filled by open; zero before. */
typedef struct hapton_device_limits {
  double max_force_n;           /* 0: the device has no motors */
  double max_slew_n_per_s;      /* fastest change of force that the mechanics transmit */
  double max_stiffness_n_per_m; /* stiffer walls vibrate; the governor's damping follows from it */
  double workspace_min_m[3];    /* box that the device point stays in, W */
  double workspace_max_m[3];
  double max_torque_nm; /* 0: no motor turns the stylus */
  double max_torque_slew_nm_per_s;
  double continuous_force_n; /* 0: max_force_n */
  double peak_s;             /* how long cold motors can hold max_force_n; 0: indefinitely */
  double max_speed_m_per_s;  /* a higher measured speed means a broken encoder; 0: unknown */
} hapton_device_limits;

/* Zero when read is called, except orientation (1, 0, 0, 0) and is_held (1). */
typedef struct hapton_device_sample {
  double position_m[3];  /* W */
  double orientation[4]; /* stylus in W, of length 1 */
  uint32_t buttons;
  int32_t is_held; /* 0: the device senses that no hand holds it */
} hapton_device_sample;

/* What read returns. */
enum {
  HAPTON_DEVICE_READY = 0,
  HAPTON_DEVICE_FAULT = 1,       /* no more forces; io_node latches the fault */
  HAPTON_DEVICE_AWAY = 2,        /* not responding, being reconnected: the sample is not used */
  HAPTON_DEVICE_CALIBRATING = 3, /* the position is not valid yet */
  HAPTON_DEVICE_ENDED = 4        /* a recording is over: io_node ends */
};

/* A device. */
typedef struct hapton_device_api {
  uint32_t abi;
  uint32_t api_size;
  uint32_t limits_size;
  uint32_t sample_size;
  const char* name;
  void* (*open)(const hapton_request* request, hapton_device_limits* limits); /* NULL: rejected, for the reason in request->why */
  int32_t (*read)(void* device, int64_t now_ns, hapton_device_sample* sample);
  /* Force and torque on the motors until the next write, W. Finite, within the limits. The last write before close is zero. */
  void (*write)(void* device, int64_t now_ns, const double force_n[3], const double torque_nm[3]);
  void (*close)(void* device);
} hapton_device_api;

/* ---- What a plug-in exports. */

#ifdef __cplusplus
#define HAPTON_EXPORT extern "C" __attribute__((visibility("default")))
#else
#define HAPTON_EXPORT extern __attribute__((visibility("default")))
#endif

HAPTON_EXPORT const hapton_effect_api hapton_effect;
HAPTON_EXPORT const hapton_method_api hapton_method;
HAPTON_EXPORT const hapton_device_api hapton_device;

#define HAPTON_EFFECT(name, max_force_n, max_torque_nm, create, reset, step, destroy) \
  const hapton_effect_api hapton_effect = {HAPTON_PLUGIN_ABI,                         \
                                           (uint32_t)sizeof(hapton_effect_api),       \
                                           (uint32_t)sizeof(hapton_effect_input),     \
                                           (uint32_t)sizeof(hapton_effect_output),    \
                                           name,                                      \
                                           max_force_n,                               \
                                           max_torque_nm,                             \
                                           create,                                    \
                                           reset,                                     \
                                           step,                                      \
                                           destroy}

#define HAPTON_METHOD(name, max_force_n, create, reset, step, set_materials, destroy) \
  const hapton_method_api hapton_method = {HAPTON_PLUGIN_ABI,                         \
                                           (uint32_t)sizeof(hapton_method_api),       \
                                           (uint32_t)sizeof(hapton_method_input),     \
                                           (uint32_t)sizeof(hapton_method_output),    \
                                           (uint32_t)sizeof(hapton_object),           \
                                           0u,                                        \
                                           name,                                      \
                                           max_force_n,                               \
                                           create,                                    \
                                           reset,                                     \
                                           step,                                      \
                                           set_materials,                             \
                                           destroy}

#define HAPTON_DEVICE(name, open, read, write, close)                              \
  const hapton_device_api hapton_device = {HAPTON_PLUGIN_ABI,                      \
                                           (uint32_t)sizeof(hapton_device_api),    \
                                           (uint32_t)sizeof(hapton_device_limits), \
                                           (uint32_t)sizeof(hapton_device_sample), \
                                           name,                                   \
                                           open,                                   \
                                           read,                                   \
                                           write,                                  \
                                           close}

#ifdef __cplusplus
}
#endif
