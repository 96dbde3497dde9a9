#include "hapton_hid_device.h"

#include <math.h>
#include <string.h>

const uint8_t hapton_hid_descriptor[HAPTON_HID_DESCRIPTOR_BYTES] = {
    0x06, 0x48, 0xFF,             /* Usage Page (vendor: 0xFF48)            */
    0x09, 0x01,                   /* Usage (haptic device)                  */
    0xA1, 0x01,                   /* Collection (Application)               */
    0x85, 0x01,                   /*   Report ID (1): state                 */
    0x15, 0x00,                   /*   Logical Minimum (0)                  */
    0x26, 0xFF, 0x00,             /*   Logical Maximum (255)                */
    0x75, 0x08,                   /*   Report Size (8)                      */
    0x95, 0x01,                   /*   Report Count (1)                     */
    0x09, 0x10,                   /*   Usage (status)                       */
    0x81, 0x02,                   /*   Input (Data, Variable, Absolute)     */
    0x16, 0x00, 0x80,             /*   Logical Minimum (-32768)             */
    0x26, 0xFF, 0x7F,             /*   Logical Maximum (32767)              */
    0x75, 0x10,                   /*   Report Size (16)                     */
    0x09, 0x11,                   /*   Usage (sequence)                     */
    0x81, 0x02,                   /*   Input (Data, Variable, Absolute)     */
    0x17, 0x00, 0x00, 0x00, 0x80, /*   Logical Minimum (-2^31)              */
    0x27, 0xFF, 0xFF, 0xFF, 0x7F, /*   Logical Maximum (2^31 - 1)           */
    0x75, 0x20,                   /*   Report Size (32)                     */
    0x09, 0x12,                   /*   Usage (time)                         */
    0x81, 0x02,                   /*   Input (Data, Variable, Absolute)     */
    0x95, 0x03,                   /*   Report Count (3)                     */
    0x09, 0x13,                   /*   Usage (position)                     */
    0x81, 0x02,                   /*   Input (Data, Variable, Absolute)     */
    0x75, 0x10,                   /*   Report Size (16)                     */
    0x95, 0x04,                   /*   Report Count (4)                     */
    0x09, 0x14,                   /*   Usage (orientation)                  */
    0x81, 0x02,                   /*   Input (Data, Variable, Absolute)     */
    0x75, 0x20,                   /*   Report Size (32)                     */
    0x95, 0x01,                   /*   Report Count (1)                     */
    0x09, 0x15,                   /*   Usage (buttons)                      */
    0x81, 0x02,                   /*   Input (Data, Variable, Absolute)     */
    0x75, 0x10,                   /*   Report Size (16)                     */
    0x09, 0x16,                   /*   Usage (newest force received)        */
    0x81, 0x02,                   /*   Input (Data, Variable, Absolute)     */
    0x75, 0x08,                   /*   Report Size (8)                      */
    0x95, 0x02,                   /*   Report Count (2)                     */
    0x09, 0x17,                   /*   Usage (temperature, and a zero)      */
    0x81, 0x02,                   /*   Input (Data, Variable, Absolute)     */
    0x85, 0x02,                   /*   Report ID (2): force                 */
    0x95, 0x01,                   /*   Report Count (1)                     */
    0x09, 0x20,                   /*   Usage (flags)                        */
    0x91, 0x02,                   /*   Output (Data, Variable, Absolute)    */
    0x75, 0x10,                   /*   Report Size (16)                     */
    0x95, 0x03,                   /*   Report Count (3)                     */
    0x09, 0x21,                   /*   Usage (sequence, newest state, zero) */
    0x91, 0x02,                   /*   Output (Data, Variable, Absolute)    */
    0x75, 0x20,                   /*   Report Size (32)                     */
    0x09, 0x22,                   /*   Usage (force)                        */
    0x91, 0x02,                   /*   Output (Data, Variable, Absolute)    */
    0x09, 0x23,                   /*   Usage (torque)                       */
    0x91, 0x02,                   /*   Output (Data, Variable, Absolute)    */
    0x85, 0x03,                   /*   Report ID (3): limits                */
    0x75, 0x08,                   /*   Report Size (8)                      */
    0x95, 0x3F,                   /*   Report Count (63)                    */
    0x09, 0x30,                   /*   Usage (limits)                       */
    0xB1, 0x02,                   /*   Feature (Data, Variable, Absolute)   */
    0x85, 0x04,                   /*   Report ID (4): names                 */
    0x95, 0x39,                   /*   Report Count (57)                    */
    0x09, 0x31,                   /*   Usage (names)                        */
    0xB1, 0x02,                   /*   Feature (Data, Variable, Absolute)   */
    0xC0,                         /* End Collection                         */
};

enum { STATUS_CALIBRATED = 1, STATUS_ON = 2, STATUS_HELD = 4, STATUS_TRIPPED = 8, STATUS_HOT = 16, STATUS_FAULT = 32 };
enum { FLAG_ON = 1 };
enum { ABLE_ORIENTATION = 1, ABLE_HELD = 2, ABLE_TORQUE = 4 };

static void put16(uint8_t* at, uint16_t value) {
  at[0] = (uint8_t)value;
  at[1] = (uint8_t)(value >> 8);
}

static void put32(uint8_t* at, uint32_t value) {
  put16(at, (uint16_t)value);
  put16(at + 2, (uint16_t)(value >> 16));
}

static uint16_t get16(const uint8_t* at) { return (uint16_t)(at[0] | (at[1] << 8)); }

static int32_t get32(const uint8_t* at) { return (int32_t)(get16(at) | ((uint32_t)get16(at + 2) << 16)); }

/* Rounds to the nearest whole number and limits it to least .. most. NaN gives 0. */
static double counts(double value, double least, double most) {
  const double rounded = floor(value + 0.5);
  if (!(value == value)) return 0.0;
  if (rounded < least) return least;
  return rounded > most ? most : rounded;
}

static void put_signed32(uint8_t* at, double value) { put32(at, (uint32_t)(int32_t)counts(value, -2147483647.0, 2147483647.0)); }

static void put_unsigned32(uint8_t* at, double value) { put32(at, (uint32_t)counts(value, 0.0, 4294967295.0)); }

static void put_unsigned16(uint8_t* at, double value) { put16(at, (uint16_t)counts(value, 0.0, 65535.0)); }

static void put_text(uint8_t* at, const char* text, size_t room) {
  size_t n;
  for (n = 0; text != NULL && n < room && text[n] != '\0'; ++n) at[n] = (uint8_t)text[n];
}

static void let_go(struct hapton_hid_device* device) {
  memset(device->force_n, 0, sizeof device->force_n);
  memset(device->torque_nm, 0, sizeof device->torque_nm);
  device->is_on = false;
}

/* While the motors are off there is nothing to release, so the watchdog does not trip. */
static void watch(struct hapton_hid_device* device, uint32_t now_us) {
  if (!device->is_on || now_us - device->force_us <= 1000u * device->limits.watchdog_ms) return;
  let_go(device);
  device->may_arm = false;
  device->has_tripped = true;
}

/* Shortens a vector that is longer than the limit. */
static void clamp(float vector[3], float limit) {
  const double length = sqrt((double)vector[0] * vector[0] + (double)vector[1] * vector[1] + (double)vector[2] * vector[2]);
  int axis;
  for (axis = 0; length > limit && axis < 3; ++axis) vector[axis] = (float)(vector[axis] * (limit / length));
}

void hapton_hid_init(struct hapton_hid_device* device, const struct hapton_hid_limits* limits) {
  memset(device, 0, sizeof *device);
  device->limits = *limits;
}

void hapton_hid_fault(struct hapton_hid_device* device) {
  let_go(device);
  device->has_fault = true;
}

void hapton_hid_state(struct hapton_hid_device* device, const struct hapton_hid_measured* measured, uint32_t now_us,
                      uint8_t report[HAPTON_HID_STATE_BYTES]) {
  unsigned status = 0;
  int n;
  watch(device, now_us);
  if (measured->has_fault) hapton_hid_fault(device);
  if (measured->is_calibrated) status |= STATUS_CALIBRATED;
  if (device->is_on) status |= STATUS_ON;
  if (measured->is_held || !device->limits.knows_held) status |= STATUS_HELD;
  if (device->has_tripped) status |= STATUS_TRIPPED;
  if (measured->is_hot) status |= STATUS_HOT;
  if (device->has_fault) status |= STATUS_FAULT;
  memset(report, 0, HAPTON_HID_STATE_BYTES);
  report[0] = HAPTON_HID_STATE_ID;
  report[1] = (uint8_t)status;
  put16(report + 2, device->sequence++);
  put32(report + 4, now_us);
  for (n = 0; n < 3; ++n) put_signed32(report + 8 + 4 * n, 1e7 * measured->position_m[n]);
  for (n = 0; n < 4; ++n) put16(report + 20 + 2 * n, (uint16_t)(int16_t)counts(32767.0 * measured->orientation[n], -32767.0, 32767.0));
  put32(report + 28, measured->buttons);
  put16(report + 32, device->force_sequence);
  report[34] = measured->temperature < 0.0f ? 255 : (uint8_t)counts(200.0 * measured->temperature, 0.0, 254.0);
}

bool hapton_hid_take_force(struct hapton_hid_device* device, const uint8_t* report, size_t size, uint32_t now_us) {
  bool on;
  int n;
  if (size < HAPTON_HID_FORCE_BYTES || report[0] != HAPTON_HID_FORCE_ID) return false;
  watch(device, now_us);
  on = (report[1] & FLAG_ON) != 0;
  device->force_sequence = get16(report + 2);
  device->force_us = now_us;
  if (!on) {
    let_go(device);
    device->may_arm = true;
    device->has_tripped = false;
    return true;
  }
  if (!device->may_arm || device->has_fault) return true;
  device->is_on = true;
  for (n = 0; n < 3; ++n) {
    device->force_n[n] = (float)(1e-6 * get32(report + 8 + 4 * n));
    device->torque_nm[n] = (float)(1e-6 * get32(report + 20 + 4 * n));
  }
  return true;
}

bool hapton_hid_motors(struct hapton_hid_device* device, uint32_t now_us, float force_n[3], float torque_nm[3]) {
  watch(device, now_us);
  memcpy(force_n, device->force_n, sizeof device->force_n);
  memcpy(torque_nm, device->torque_nm, sizeof device->torque_nm);
  clamp(force_n, device->limits.max_force_n);
  clamp(torque_nm, device->limits.has_torque ? device->limits.max_torque_nm : 0.0f);
  return device->is_on;
}

static size_t put_limits(const struct hapton_hid_limits* limits, uint8_t* report) {
  unsigned able = 0;
  int n;
  if (limits->has_orientation) able |= ABLE_ORIENTATION;
  if (limits->knows_held) able |= ABLE_HELD;
  if (limits->has_torque) able |= ABLE_TORQUE;
  report[0] = HAPTON_HID_LIMITS_ID;
  report[1] = HAPTON_HID_VERSION;
  report[2] = (uint8_t)able;
  report[3] = limits->buttons;
  memcpy(report + 4, "HAPT", 4);
  put16(report + 8, limits->rate_hz);
  put16(report + 10, limits->watchdog_ms);
  for (n = 0; n < 3; ++n) {
    put_signed32(report + 12 + 4 * n, 1e7 * limits->workspace_min_m[n]);
    put_signed32(report + 24 + 4 * n, 1e7 * limits->workspace_max_m[n]);
  }
  put_unsigned32(report + 36, 1e6 * limits->max_force_n);
  put_unsigned32(report + 40, 1e6 * limits->continuous_force_n);
  put_unsigned32(report + 44, 1e3 * limits->max_slew_n_per_s);
  put_unsigned32(report + 48, 1e3 * limits->max_stiffness_n_per_m);
  put_unsigned32(report + 52, 1e6 * limits->max_torque_nm);
  put_unsigned32(report + 56, 1e3 * limits->max_torque_slew_nm_per_s);
  put_unsigned16(report + 60, 1e3 * limits->peak_s);
  put_unsigned16(report + 62, 1e3 * limits->max_speed_m_per_s);
  return HAPTON_HID_LIMITS_BYTES;
}

static size_t put_names(const struct hapton_hid_limits* limits, uint8_t* report) {
  memset(report, 0, HAPTON_HID_NAMES_BYTES);
  report[0] = HAPTON_HID_NAMES_ID;
  put_text(report + 2, limits->model, 24);
  put_text(report + 26, limits->serial, 16);
  put_text(report + 42, limits->firmware, 16);
  return HAPTON_HID_NAMES_BYTES;
}

size_t hapton_hid_feature(const struct hapton_hid_device* device, uint8_t id, uint8_t* report, size_t room) {
  if (id == HAPTON_HID_LIMITS_ID && room >= HAPTON_HID_LIMITS_BYTES) return put_limits(&device->limits, report);
  if (id == HAPTON_HID_NAMES_ID && room >= HAPTON_HID_NAMES_BYTES) return put_names(&device->limits, report);
  return 0;
}
