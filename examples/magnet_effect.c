/* Shows: an effect as a plug-in of haptics_node. While no button is pressed, the hand is pulled to a fixed point in space.
 *   gcc -O2 -shared -fPIC -I PREFIX/include/hapton magnet_effect.c -o magnet_effect.so -lm
 *   haptics_node --effect ./magnet_effect.so:x_m=0.03,range_m=0.04,force_n=2 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plugin/hapton_plugin.h"

typedef struct magnet {
  double at_m[3]; /* frame W */
  double range_m;
  double force_n;
} magnet;

static void* create(const hapton_request* request) {
  magnet made = {{0.0, 0.0, 0.0}, 0.02, 1.0};
  const char* const keys[] = {"x_m", "y_m", "z_m", "range_m", "force_n"};
  double* const values[] = {&made.at_m[0], &made.at_m[1], &made.at_m[2], &made.range_m, &made.force_n};
  for (size_t p = 0; p < request->parameter_count; ++p) {
    size_t k = 0;
    while (k < 5 && strcmp(keys[k], request->parameters[p].key) != 0) ++k;
    char* end = NULL;
    if (k < 5) *values[k] = strtod(request->parameters[p].value, &end);
    if (k == 5 || *end != '\0' || end == request->parameters[p].value) {
      snprintf(request->why, request->why_size, "'%s' is not one of x_m, y_m, z_m, range_m, force_n with a number",
               request->parameters[p].key);
      return NULL;
    }
  }
  if (!(made.range_m > 0.0 && made.force_n >= 0.0 && made.force_n <= 3.0)) {
    snprintf(request->why, request->why_size, "range_m must be above 0, force_n 0 to 3");
    return NULL;
  }
  magnet* kept = malloc(sizeof *kept);
  if (kept != NULL) *kept = made;
  return kept;
}

/* The force is 0 at the point, force_n at half the range, and 0 from the range on. It has no jump. */
static void step(void* effect, const hapton_effect_input* input, hapton_effect_output* output) {
  const magnet* m = effect;
  double away_m[3], square = 0.0;
  for (int k = 0; k < 3; ++k) away_m[k] = input->position_m[k] - m->at_m[k];
  for (int k = 0; k < 3; ++k) square += away_m[k] * away_m[k];
  const double u = sqrt(square) / m->range_m;
  if (u >= 1.0 || input->buttons != 0) return;
  for (int k = 0; k < 3; ++k) output->force_n[k] = -m->force_n * 4.0 * (1.0 - u) * away_m[k] / m->range_m;
}

HAPTON_EFFECT("magnet", 3.0, 0.0, create, NULL, step, free);
