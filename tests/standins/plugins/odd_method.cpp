// A force method: floor and proxy at y = 0, with the stiffness of the first object's material. Parameters: does=nan|nan_proxy|odd_object|
// exception, from call number after=CALLS on; does=reject; does=tell: the force is the velocity, and the proxy's x, y and z are the time,
// the buttons and the x component of the stylus's axis y; does=reset_exception|material_exception, in these calls. It aborts if it is
// destroyed without having been created, called after it gave NaN, or given an output that is not as hapton_plugin.h says. Compiled
// with ODD_IS_BARE it has only what a method must have.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "plugin/hapton_plugin.h"

namespace {

struct Floor {
  std::string does;
  long after = 0;
  long calls = 0;
  double stiffness_n_per_m = 0.0;
  std::size_t vertices = 0;
};

void* create(const hapton_request* request, const hapton_object* objects, std::size_t object_count) {
  Floor made;
  for (std::size_t p = 0; p < request->parameter_count; ++p) {
    const std::string key = request->parameters[p].key;
    if (key == "does") made.does = request->parameters[p].value;
    if (key == "after") made.after = std::atol(request->parameters[p].value);
  }
  if (object_count != 1 || made.does == "reject") {
    std::snprintf(request->why, request->why_size, "it wants one object, not %zu", object_count);
    return nullptr;
  }
  // Read every number of the mesh: all must be finite.
  double sum = 0.0;
  for (std::size_t t = 0; t < 3 * objects[0].triangle_count; ++t) {
    for (int k = 0; k < 3; ++k) sum += objects[0].vertices_m[3 * objects[0].triangles[t] + static_cast<unsigned>(k)];
  }
  if (!std::isfinite(sum)) return nullptr;
  made.stiffness_n_per_m = objects[0].material.stiffness_n_per_m;
  return new Floor(made);
}

// A method that gave NaN must not be called again.
void refuse_after_nan(const Floor& floor) {
  if (floor.does == "nan" && floor.calls > floor.after) std::abort();
}

void reset(void* method, const double*) {
  Floor& floor = *static_cast<Floor*>(method);
  refuse_after_nan(floor);
  if (floor.does == "reset_exception") throw std::runtime_error("not now");
}

void step(void* method, const hapton_method_input* input, hapton_method_output* output) {
  Floor& floor = *static_cast<Floor*>(method);
  if (output->object != -1 || output->contact != 0 || output->force_n[2] != 0.0 || output->proxy_m[0] != input->position_m[0]) std::abort();
  const bool is_odd = floor.calls++ >= floor.after;
  if (is_odd && floor.does == "exception") throw std::runtime_error("through the boundary");
  if (input->position_m[1] < 0.0) {
    output->contact = 1;
    output->object = 0;
    output->force_n[1] = -floor.stiffness_n_per_m * input->position_m[1];
    output->proxy_m[1] = 0.0;
  }
  if (is_odd && floor.does == "nan") output->contact = 1, output->force_n[0] = std::nan("");
  if (is_odd && floor.does == "nan_proxy") output->proxy_m[2] = std::nan("");
  if (is_odd && floor.does == "odd_object") output->object = 77;
  if (floor.does != "tell") return;
  const double* q = input->orientation;
  output->contact = 1;
  for (int k = 0; k < 3; ++k) output->force_n[k] = input->velocity_m_per_s[k];
  output->proxy_m[0] = input->time_s;
  output->proxy_m[1] = input->buttons;
  output->proxy_m[2] = 2.0 * (q[1] * q[2] - q[0] * q[3]);
}

[[maybe_unused]] void set_materials(void* method, const hapton_material* materials, std::size_t) {
  Floor& floor = *static_cast<Floor*>(method);
  refuse_after_nan(floor);
  if (floor.does == "material_exception") throw std::runtime_error("not these");
  floor.stiffness_n_per_m = materials[0].stiffness_n_per_m;
}

[[maybe_unused]] void destroy(void* method) {
  if (method == nullptr) std::abort();
  delete static_cast<Floor*>(method);
}

}  // namespace

#ifdef ODD_IS_BARE
HAPTON_METHOD("floor", 50.0, create, reset, step, nullptr, nullptr);
#else
HAPTON_METHOD("floor", 50.0, create, reset, step, set_materials, destroy);
#endif
