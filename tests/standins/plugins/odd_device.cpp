// A device that moves along x at 0.1 m/s, 0.5 m forth and back; its y and z are the force and torque last written. Parameters:
// does=nan|exception|fault|away|ended|unknown|calibrating|released|q|nearly|reject|no_slew|no_box|strong|full|open_exception|
// write_exception; after=READS, until=READS: the reads in which it does that; rests=1: x stays zero.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "plugin/hapton_plugin.h"

namespace {

struct Line {
  std::string does;
  long after = 0;
  long until = 0;  // 0: no end
  long reads = 0;
  bool rests = false;
  double force_n = 0.0;
  double torque_nm = 0.0;
};

void* open_line(const hapton_request* request, hapton_device_limits* limits) {
  Line made;
  for (std::size_t p = 0; p < request->parameter_count; ++p) {
    const std::string key = request->parameters[p].key;
    if (key == "does") made.does = request->parameters[p].value;
    if (key == "after") made.after = std::atol(request->parameters[p].value);
    if (key == "until") made.until = std::atol(request->parameters[p].value);
    if (key == "rests") made.rests = std::atol(request->parameters[p].value) != 0;
  }
  if (made.does == "reject") {
    std::snprintf(request->why, request->why_size, "nothing is plugged in");
    return nullptr;
  }
  if (made.does == "open_exception") throw std::runtime_error("cable");
  limits->max_force_n = made.does == "strong" ? std::nan("") : 3.0;
  limits->max_slew_n_per_s = made.does == "no_slew" ? 0.0 : 3000.0;
  for (int k = 0; k < 3 && made.does != "no_box"; ++k) {
    limits->workspace_min_m[k] = -1.0;
    limits->workspace_max_m[k] = 1.0;
  }
  if (made.does == "full") {
    limits->max_stiffness_n_per_m = 900.0;
    limits->max_torque_nm = 0.25;
    limits->max_torque_slew_nm_per_s = 40.0;
    limits->continuous_force_n = 1.5;
    limits->peak_s = 7.0;
    limits->max_speed_m_per_s = 2.5;
  }
  return new Line(made);
}

int32_t read_line(void* device, int64_t now_ns, hapton_device_sample* sample) {
  Line& line = *static_cast<Line*>(device);
  const long number = line.reads++;
  const bool is_odd = number >= line.after && (line.until == 0 || number < line.until);
  const int64_t in_period_ns = now_ns % 10'000'000'000;
  const int64_t way_ns = in_period_ns < 5'000'000'000 ? in_period_ns : 10'000'000'000 - in_period_ns;
  sample->position_m[0] = line.rests ? 0.0 : 1e-10 * static_cast<double>(way_ns);
  sample->position_m[1] = line.force_n;
  sample->position_m[2] = line.torque_nm;
  sample->buttons = 5;
  if (!is_odd) return HAPTON_DEVICE_READY;
  if (line.does == "exception") throw std::runtime_error("cable");
  if (line.does == "nan") sample->position_m[2] = std::nan("");
  if (line.does == "q") sample->orientation[0] = 0.3;
  if (line.does == "nearly") sample->orientation[0] = 1.0001;
  if (line.does == "released") sample->is_held = 0;
  if (line.does == "calibrating") return HAPTON_DEVICE_CALIBRATING;
  if (line.does == "fault") return HAPTON_DEVICE_FAULT;
  if (line.does == "away") return line.reads % 2 == 0 ? HAPTON_DEVICE_AWAY : HAPTON_DEVICE_READY;
  if (line.does == "ended") return HAPTON_DEVICE_ENDED;
  if (line.does == "unknown") return 99;
  return HAPTON_DEVICE_READY;
}

void write_line(void* device, int64_t, const double force_n[3], const double torque_nm[3]) {
  Line& line = *static_cast<Line*>(device);
  if (line.does == "write_exception") throw std::runtime_error("cable");
  line.force_n = force_n[1];
  line.torque_nm = torque_nm[2];
}

void close_line(void* device) {
  Line* line = static_cast<Line*>(device);
  if (line->force_n != 0.0 || line->torque_nm != 0.0) std::abort();
  delete line;
}

}  // namespace

HAPTON_DEVICE("line", open_line, read_line, write_line, close_line);
