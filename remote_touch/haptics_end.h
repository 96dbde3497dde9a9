#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "core/force/touch_step.h"

namespace hapton {

// A sample of the device on its way through the network, and a reply with the sample that it replies to.
struct SampleOnTheWay {
  std::int64_t time_ns = 0;
  Vec3 p_WD = Vec3::Zero();
};
struct ReplyOnTheWay {
  SampleOnTheWay sample;
  TouchOutput touch;
};

// The haptics node: computes the step on the whole scene, for each sample that is newer than those before. Units: SI, ns. RT: no.
class HapticsEnd {
 public:
  // Pre: nobody else steps the method while this object is in use.
  explicit HapticsEnd(std::shared_ptr<ForceMethod> method) : step_(std::move(method)) {}

  // None: the sample was overtaken by a newer one, or has come before.
  std::optional<ReplyOnTheWay> reply(const SampleOnTheWay& sample) {
    if (newest_ns_ && sample.time_ns <= *newest_ns_) return std::nullopt;
    TouchInput input{.p_WD = sample.p_WD};
    if (newest_ns_) {
      input.dt_s = 1e-9 * static_cast<double>(sample.time_ns - *newest_ns_);
    } else {
      step_.reset(input);
    }
    newest_ns_ = sample.time_ns;
    return ReplyOnTheWay{sample, step_.step(input)};
  }

 private:
  TouchStep step_;
  std::optional<std::int64_t> newest_ns_;
};

}  // namespace hapton
