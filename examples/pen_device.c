/* Shows: a device as a plug-in of io_node. This one simulates a pen of 100 g on a spring that swings up and down. Yours would access
 * hardware in read and write.
 *   gcc -O2 -shared -fPIC -I PREFIX/include/hapton pen_device.c -o pen_device.so -lm
 *   io_node --device plugin:./pen_device.so:swing_m=0.03 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plugin/hapton_plugin.h"

typedef struct pen {
  double swing_m;
  double y_m, v_m_per_s, motor_n;
  int64_t begin_ns, last_ns;
} pen;

static void* open_pen(const hapton_request* request, hapton_device_limits* limits) {
  double swing_m = 0.05;
  for (size_t p = 0; p < request->parameter_count; ++p) {
    if (strcmp(request->parameters[p].key, "swing_m") == 0) {
      swing_m = strtod(request->parameters[p].value, NULL);
    } else {
      snprintf(request->why, request->why_size, "'%s' is not known; give swing_m", request->parameters[p].key);
      return NULL;
    }
  }
  limits->max_force_n = 3.0;
  limits->max_slew_n_per_s = 3000.0;
  limits->max_stiffness_n_per_m = 1000.0;
  limits->max_speed_m_per_s = 5.0;
  for (int k = 0; k < 3; ++k) limits->workspace_min_m[k] = -(limits->workspace_max_m[k] = 0.15);
  pen* made = calloc(1, sizeof *made);
  if (made != NULL) made->swing_m = swing_m;
  return made;
}

static int32_t read_pen(void* device, int64_t now_ns, hapton_device_sample* sample) {
  pen* p = device;
  if (p->begin_ns == 0) p->begin_ns = p->last_ns = now_ns;
  const double dt_s = fmin(2e-3, 1e-9 * (double)(now_ns - p->last_ns));
  const double hand_m = p->swing_m * cos(2e-9 * (double)(now_ns - p->begin_ns));
  p->last_ns = now_ns;
  p->v_m_per_s += dt_s * (p->motor_n + 200.0 * (hand_m - p->y_m) - 8.0 * p->v_m_per_s) / 0.1;
  p->y_m += dt_s * p->v_m_per_s;
  sample->position_m[1] = p->y_m;
  return HAPTON_DEVICE_READY;
}

static void write_pen(void* device, int64_t now_ns, const double force_n[3], const double torque_nm[3]) {
  (void)now_ns, (void)torque_nm; /* it has one motor, up and down */
  ((pen*)device)->motor_n = force_n[1];
}

HAPTON_DEVICE("pen", open_pen, read_pen, write_pen, free);
