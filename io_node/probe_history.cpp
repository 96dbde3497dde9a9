#include "io_node/probe_history.h"

#include "core/force/force_method.h"
#include "core/math/contact_resumption.h"

namespace hapton {

void ProbeHistory::note_sample(std::uint64_t number, const DeviceSample& sample) noexcept {
  newest_sample_ = number;
  poses_[number % kSamples] = {sample.time_ns, sample.p_WD, sample.q_WT};
}

void ProbeHistory::note_reply(const ForceCommand& command) noexcept {
  note_resumed(command.echo_sample);
  note_local(command);
}

void ProbeHistory::note_local(const ForceCommand& command) noexcept {
  last_reply_ = command;
  const bool is_at_rest = command.contact && is_known(command.echo_sample);
  p_WP_ = is_at_rest ? std::optional<Vec3>(poses_[command.echo_sample % kSamples].p_WD + command.held_offset()) : std::nullopt;
  outward_W_ = command.held_offset();
}

std::optional<Vec3> ProbeHistory::find_resume_point(const Vec3& p_WD) const noexcept {
  if (!is_haptics_new_) return std::nullopt;
  if (was_local_ && !last_reply_.contact) return find_resume_point_without_contact(p_WD);
  if (!p_WP_ || (*p_WP_ - p_WD).norm() > kResumeReachM) return std::nullopt;
  return has_left_contact(*p_WP_, outward_W_, p_WD) ? std::nullopt : p_WP_;
}

// The haptics node begins at its contact offset beyond the returned point, as seen from the device. That must not be behind a surface that
// the hand has just left: so the point is nearer to the device by the default offset, with which the node begins at the probe itself.
std::optional<Vec3> ProbeHistory::find_resume_point_without_contact(const Vec3& p_WD) const noexcept {
  constexpr double kOffset = MethodSettings::kDefaultOffsetM;
  const std::optional<Vec3> p_WP = find_probe();
  if (!p_WP) return std::nullopt;
  const Vec3 moved = p_WD - *p_WP;
  const double moved_m = moved.norm();
  if (moved_m > kResumeReachM) return std::nullopt;
  return moved_m <= kOffset ? p_WD : Vec3(*p_WP + kOffset / moved_m * moved);
}

std::optional<Vec3> ProbeHistory::find_probe() const noexcept {
  if (!is_known(last_reply_.echo_sample)) return std::nullopt;
  return poses_[last_reply_.echo_sample % kSamples].p_WD + last_reply_.held_offset();
}

void ProbeHistory::show(bool has_timed_out, ProbeState& probe) const noexcept {
  const bool is_live = !has_timed_out && is_known(last_reply_.echo_sample);
  const std::uint64_t shown = is_live ? last_reply_.echo_sample : newest_sample_;
  if (shown < probe.sample) return;  // a reply to a sample from before the timeout is too late to be shown
  const Pose& pose = poses_[shown % kSamples];
  probe.sample = shown;
  probe.sample_time_ns = pose.time_ns;
  probe.p_WD = pose.p_WD;
  probe.q_WT = pose.q_WT;
  probe.contact = is_live && last_reply_.contact;
  probe.visual_offset_m = is_live ? last_reply_.visual_offset_m : Vec3(Vec3::Zero());
  probe.object = is_live ? last_reply_.object : -1;
  probe.scene_time_ns = last_reply_.scene_time_ns;  // without replies the scene time stands still
  probe.visual_turn = is_live ? last_reply_.visual_turn : Vec3(Vec3::Zero());
  probe.haptons = last_reply_.haptons;
  if (probe.haptons && !is_live) probe.haptons = 0;
  probe.push = last_reply_.push;
  if (probe.push && !is_live) probe.push.emplace();
}

}  // namespace hapton
