// Component plugin alone, compiled as C++ here: a plug-in and a program that runs one step of its effect.
#include <stdio.h>

#include "plugin/hapton_plugin.h"

static void* create(const hapton_request* request) {
  (void)request;
  return NULL;
}

static void step(void* effect, const hapton_effect_input* input, hapton_effect_output* output) {
  (void)effect;
  output->force_n[0] = -input->velocity_m_per_s[0];
}

HAPTON_EFFECT("drag", 1.0, 0.0, create, NULL, step, NULL);

int main(void) {
  hapton_effect_input input = {0};
  hapton_effect_output output = {{0.0}, {0.0}};
  input.velocity_m_per_s[0] = 0.5;
  hapton_effect.step(NULL, &input, &output);
  printf("%s, version %u: %.1f N\n", hapton_effect.name, (unsigned)hapton_effect.abi, output.force_n[0]);
  return output.force_n[0] == -0.5 ? 0 : 1;
}
