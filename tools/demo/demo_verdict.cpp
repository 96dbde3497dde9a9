#include "tools/demo/demo_verdict.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "tools/demo/demo_shapes.h"
#include "tools/json_number.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMinContactShare = 0.5;    // least share of the steps since the first contact that is "most of the time"
constexpr double kMinPressDepthM = 0.0005;  // least distance of the device from the probe if it pressed, and did not only brush
constexpr double kMaxReleaseMs = 100.0;  // the limit is 20 ms and a cycle, but a machine with other work to do may be late with the cycle
constexpr double kPeriodUs = 1000.0;     // period of 1 kHz: a step must take less

struct Contact {
  std::size_t steps = 0;  // since the first contact
  std::size_t contacts = 0;
  double deepest_m = 0.0;  // largest distance of the device from the probe
  double most_n = 0.0;
  double share() const { return steps == 0 ? 0.0 : static_cast<double>(contacts) / static_cast<double>(steps); }
  bool is_most_of_the_time() const { return share() >= kMinContactShare; }
};

Contact count_contact(const DemoMotion& motion) {
  Contact contact;
  for (const DemoSample& step : motion.steps) {
    if (contact.contacts == 0 && !step.contact) continue;
    ++contact.steps;
    if (!step.contact) continue;
    ++contact.contacts;
    contact.deepest_m = std::max(contact.deepest_m, (step.p_WD - step.p_WP).norm());
    contact.most_n = std::max(contact.most_n, step.force_n.norm());
  }
  return contact;
}

std::string contact_text(const Contact& contact) {
  if (contact.contacts == 0) return "touched nothing";
  return fmt::format("in contact {:.0f} % of {} steps, up to {:.1f} N", 100.0 * contact.share(), contact.steps, contact.most_n);
}

DemoVerdict make_verdict(const Contact& contact, bool is_shown, const std::string& details) {
  return {contact.contacts > 0, contact.contacts > 0 && is_shown, contact_text(contact) + details};
}

double hop_us(const Json& report, const char* hop, const char* quantile) {
  const auto hops = report.find("hops");
  return hops == report.end() || !hops->is_object() ? 0.0 : json_number_of(*hops, hop, quantile);
}

double between_ms(std::int64_t from_ns, std::int64_t to_ns) { return 1e-6 * static_cast<double>(to_ns - from_ns); }

}  // namespace

DemoVerdict evaluate_rest(const DemoEvidence& evidence) {
  const Contact contact = count_contact(evidence.motion);
  return make_verdict(contact, contact.is_most_of_the_time() && contact.deepest_m >= kMinPressDepthM,
                      fmt::format("; the hand's device up to {:.1f} mm behind the probe", 1e3 * contact.deepest_m));
}

DemoVerdict evaluate_groove(const DemoEvidence& evidence) {
  using namespace demo_groove;
  const Contact contact = count_contact(evidence.motion);
  double lowest = 0.0;
  double highest = 0.0;
  double max_offset = 0.0;
  for (const DemoSample& step : evidence.motion.steps) {
    if (!step.contact || std::abs(step.p_WP.x()) > kHalfLengthM) continue;
    lowest = std::min(lowest, step.p_WP.y());
    highest = std::max(highest, step.p_WP.y());
    max_offset = std::max(max_offset, std::abs(step.p_WP.y() - centre_m(step.p_WP.x())));
  }
  const bool is_guided = highest - lowest >= kAmplitudeM && max_offset <= kHalfWidthM;
  return make_verdict(contact, contact.is_most_of_the_time() && is_guided,
                      fmt::format("; the walls guided it over {:.1f} mm, at most {:.1f} mm from the middle of a groove {:.0f} mm wide",
                                  1e3 * (highest - lowest), 1e3 * max_offset, 2e3 * kHalfWidthM));
}

DemoVerdict evaluate_wall(const DemoEvidence& evidence) {
  using namespace demo_wall;
  const Contact contact = count_contact(evidence.motion);
  double longest_step = 0.0;
  double device_behind = 0.0;
  double probe_behind = 0.0;
  const DemoSample* previous = nullptr;
  for (const DemoSample& step : evidence.motion.steps) {
    const bool is_over_wall = step.p_WD.head<2>().cwiseAbs().maxCoeff() < kHalfSideM;
    if (is_over_wall) {
      device_behind = std::max(device_behind, kFrontM - step.p_WD.z());
      probe_behind = std::max(probe_behind, kFrontM - step.p_WP.z());
      // A step with which the device passed the front of the wall.
      if (previous != nullptr && previous->p_WD.z() >= kFrontM && step.p_WD.z() < kFrontM)
        longest_step = std::max(longest_step, previous->p_WD.z() - step.p_WD.z());
    }
    previous = &step;
  }
  // The device was behind the whole wall, but the probe stayed on its front; half the thickness is far above rounding errors.
  const bool is_held_back = device_behind > kThicknessM && probe_behind <= 0.5 * kThicknessM;
  return make_verdict(
      contact, longest_step > kThicknessM && is_held_back,
      fmt::format("; a step of {:.2f} mm through a wall of {:.1f} mm, the device up to {:.1f} mm behind its front, the probe {:.1f} mm",
                  1e3 * longest_step, 1e3 * kThicknessM, 1e3 * device_behind, 1e3 * probe_behind));
}

DemoVerdict evaluate_heavy(const DemoEvidence& evidence) {
  const Contact contact = count_contact(evidence.motion);
  const double typical_us = hop_us(evidence.report, "haptics_compute", "p50_us");
  return make_verdict(
      contact, contact.is_most_of_the_time() && typical_us > 0.0 && typical_us < kPeriodUs,
      fmt::format("; a force takes {:.1f} us (p50), {:.1f} us (p99)", typical_us, hop_us(evidence.report, "haptics_compute", "p99_us")));
}

DemoVerdict evaluate_network(const DemoEvidence& evidence, double least_round_trip_ms) {
  const Contact contact = count_contact(evidence.motion);
  const double round_trip_ms = 1e-3 * hop_us(evidence.report, "round_trip", "p50_us");
  const double faults = json_number_of(evidence.report, "counters", "faults_latched");
  return make_verdict(contact, contact.is_most_of_the_time() && round_trip_ms >= least_round_trip_ms && faults == 0.0,
                      fmt::format("; round trip {:.1f} ms (p50), {:.0f} forces computed by io_node, {:.0f} cycles damped, {:.0f} faults",
                                  round_trip_ms, json_number_of(evidence.report, "counters", "local_forces"),
                                  json_number_of(evidence.report, "counters", "energy_damped"), faults));
}

DemoVerdict evaluate_death(const DemoEvidence& evidence) {
  const Contact contact = count_contact(evidence.motion);
  bool had_force = false;
  std::int64_t released_ns = evidence.killed_ns;
  std::optional<std::int64_t> force_again_ns;
  for (const DemoForceWritten& force : evidence.motion.written_forces) {
    if (!(force.newtons > 0.0)) continue;
    if (force.time_ns < evidence.killed_ns)
      had_force = true;
    else if (force.time_ns < evidence.restarted_ns)
      released_ns = force.time_ns;
    else if (!force_again_ns)
      force_again_ns = force.time_ns;
  }
  const double released_ms = between_ms(evidence.killed_ns, released_ns);
  const std::string again = force_again_ns
                                ? fmt::format("force again {:.0f} ms after the restart", between_ms(evidence.restarted_ns, *force_again_ns))
                                : std::string("no force after the restart");
  return make_verdict(contact, had_force && force_again_ns && released_ms <= kMaxReleaseMs,
                      fmt::format("; no force {:.0f} ms after the node is killed, {}", released_ms, again));
}

}  // namespace hapton
