#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/demo/demo_motion.h"

namespace hapton {

// What was recorded during a step of the tour.
struct DemoEvidence {
  DemoMotion motion;
  nlohmann::ordered_json report;  // the hub's report.json, schema kReportSchema
  std::int64_t killed_ns = 0;     // when the haptics node was killed and started again, this machine's clock; 0: it was not
  std::int64_t restarted_ns = 0;
};

// Whether the step showed what it should.
struct DemoVerdict {
  bool touched = false;  // there was contact
  bool held = false;     // it showed what it should; true only with touched
  std::string text;      // one line with the numbers
};

// RT: no.

// The probe stays on the surface while the hand presses: in contact most of the time, the device behind the surface.
DemoVerdict evaluate_rest(const DemoEvidence& evidence);
// The probe goes along the groove's bends (demo_shapes.h) while the device is pulled straight on.
DemoVerdict evaluate_groove(const DemoEvidence& evidence);
// In one haptic step at least the hand moves farther than the wall is thick; the device gets behind the wall, the probe never does.
DemoVerdict evaluate_wall(const DemoEvidence& evidence);
// In contact most of the time, and the typical force takes less than a period of 1 kHz.
DemoVerdict evaluate_heavy(const DemoEvidence& evidence);
// In contact most of the time although the typical round trip is at least that of the simulated network; no fault was latched.
DemoVerdict evaluate_network(const DemoEvidence& evidence, double least_round_trip_ms);
// The force is released soon after the haptics node was killed, and is there again after its restart.
DemoVerdict evaluate_death(const DemoEvidence& evidence);

}  // namespace hapton
