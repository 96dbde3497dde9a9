#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/demo/demo_motion.h"

namespace hapton {

// The measurements of one step of the tour.
struct DemoEvidence {
  DemoMotion motion;
  nlohmann::ordered_json report;  // the hub's report.json, schema kReportSchema
  std::int64_t killed_ns = 0;     // when the haptics node was killed, on this machine's clock; 0: it was not
  std::int64_t restarted_ns = 0;  // when it was started again; 0: it was not
};

// Whether the step showed what it should.
struct DemoVerdict {
  bool has_contact = false;  // there was contact
  bool is_shown = false;     // the step showed what it should; true only with has_contact
  std::string text;          // one line with the numbers
};

// All functions below: RT: no.

// The probe stays on the surface while the hand presses: in contact most of the time, the device behind the surface.
DemoVerdict evaluate_rest(const DemoEvidence& evidence);
// The probe follows the bends of the groove (demo_shapes.h) while the hand moves on a straight line; in contact most of the time.
DemoVerdict evaluate_groove(const DemoEvidence& evidence);
// In at least one step the device crosses the wall's front and moves farther than the wall is thick; it gets behind, the probe never does.
DemoVerdict evaluate_wall(const DemoEvidence& evidence);
// The probe is in contact most of the time, and the median time to compute a force is below 1 ms.
DemoVerdict evaluate_heavy(const DemoEvidence& evidence);
// The probe is in contact most of the time, although the median round trip is least_round_trip_ms or more; no fault was latched.
DemoVerdict evaluate_network(const DemoEvidence& evidence, double least_round_trip_ms);
// The force is zero within 100 ms after the haptics node was killed, and comes again after its restart.
DemoVerdict evaluate_death(const DemoEvidence& evidence);

}  // namespace hapton
