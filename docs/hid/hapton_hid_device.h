/* The device's side of Hapton HID, version 1 (docs/hid.md), for the firmware of open hardware.
 *
 * C99, no heap, no operating system, no global state. All calls of one device come from one thread, or from where they cannot interrupt
 * each other. now_us is any clock that counts microseconds and wraps at 2^32.
 *
 *   at start-up      hapton_hid_init
 *   a thousand times a second, or at the rate of your device
 *                    hapton_hid_state, and send its result as an input report
 *   on an output report            hapton_hid_take_force
 *   on a feature report request    hapton_hid_feature
 *   in the motor loop              hapton_hid_motors, and apply its result to the motors
 *   when you detect a fault        hapton_hid_fault
 */
#ifndef HAPTON_HID_DEVICE_H
#define HAPTON_HID_DEVICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTON_HID_VERSION 1u

#define HAPTON_HID_STATE_ID 1u
#define HAPTON_HID_FORCE_ID 2u
#define HAPTON_HID_LIMITS_ID 3u
#define HAPTON_HID_NAMES_ID 4u

/* Bytes of the reports, including the id. */
#define HAPTON_HID_STATE_BYTES 36u
#define HAPTON_HID_FORCE_BYTES 32u
#define HAPTON_HID_LIMITS_BYTES 64u
#define HAPTON_HID_NAMES_BYTES 58u

#define HAPTON_HID_DESCRIPTOR_BYTES 131u
extern const uint8_t hapton_hid_descriptor[HAPTON_HID_DESCRIPTOR_BYTES];

/* Properties and limits of the device. SI units, in the device's base frame: x to the user's right, y up, z towards the user. */
struct hapton_hid_limits {
  bool has_orientation; /* it measures the orientation of the stylus */
  bool knows_held;      /* it detects whether a hand holds the stylus */
  bool has_torque;      /* motors exert torques on the stylus */
  uint8_t buttons;
  uint16_t rate_hz;     /* input reports a second */
  uint16_t watchdog_ms; /* time after the last output report when the motors go off; 5 to 100 */
  float workspace_min_m[3];
  float workspace_max_m[3];
  float max_force_n;
  float continuous_force_n; /* force that it holds indefinitely; 0: max_force_n */
  float max_slew_n_per_s;
  float max_stiffness_n_per_m;
  float max_torque_nm;
  float max_torque_slew_nm_per_s;
  float peak_s;            /* time for which cold motors hold max_force_n; 0: indefinitely */
  float max_speed_m_per_s; /* no hand is faster; 0: not known */
  const char* model;       /* UTF-8, 24 bytes at most */
  const char* serial;      /* 16 bytes at most */
  const char* firmware;    /* 16 bytes at most */
};

/* Measurements of the device. */
struct hapton_hid_measured {
  bool is_calibrated;
  bool is_held;   /* true if the device cannot detect it */
  bool is_hot;    /* the device reduces its forces to cool down */
  bool has_fault; /* as hapton_hid_fault */
  float position_m[3];
  float orientation[4]; /* quaternion x, y, z, w of length 1 */
  uint32_t buttons;     /* one bit each, lowest first */
  float temperature;    /* 0 cold, 1 too hot; below 0: not known */
};

struct hapton_hid_device {
  struct hapton_hid_limits limits;
  uint16_t sequence;       /* of the next state */
  uint16_t force_sequence; /* of the newest force report */
  uint32_t force_us;       /* time of its arrival */
  float force_n[3];
  float torque_nm[3];
  bool may_arm; /* a report with the motors off arrived since start-up, or since the watchdog tripped */
  bool is_on;
  bool has_tripped;
  bool has_fault; /* until hapton_hid_init */
};

void hapton_hid_init(struct hapton_hid_device* device, const struct hapton_hid_limits* limits);

/* Makes the next input report. */
void hapton_hid_state(struct hapton_hid_device* device, const struct hapton_hid_measured* measured, uint32_t now_us,
                      uint8_t report[HAPTON_HID_STATE_BYTES]);

/* The device has detected a fault of its own: the motors are off until it is power-cycled, whatever the host sends. */
void hapton_hid_fault(struct hapton_hid_device* device);

/* Accepts an output report with its id in front. False: not a force report, or damaged; nothing has changed. */
bool hapton_hid_take_force(struct hapton_hid_device* device, const uint8_t* report, size_t size, uint32_t now_us);

/* Fills in a feature report. Returns its size, or 0 for an unknown id or too little room. */
size_t hapton_hid_feature(const struct hapton_hid_device* device, uint8_t id, uint8_t* report, size_t room);

/* Force and torque for the motors now; false, and all zero, if they must be off. Enforces the watchdog and the device's own limits. */
bool hapton_hid_motors(struct hapton_hid_device* device, uint32_t now_us, float force_n[3], float torque_nm[3]);

#ifdef __cplusplus
}
#endif

#endif
