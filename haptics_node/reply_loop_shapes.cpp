#include "haptics_node/reply_loop.h"
#include "runtime/log.h"

// The part of ReplyLoop that handles objects that programs deform.
namespace hapton {
namespace {

constexpr int kMaxShapeMessages = 4;  // at most so many between two device states, as for parts of the scene
// Time until a start is sent again, as for a setup (kSetupRepeatNs): a datagram may be lost.
constexpr std::int64_t kStartRepeatNs = 100 * kNanosecondsPerMillisecond;
constexpr int kStartRepeats = 3;
// For a slow network: bits of an IP packet with one part of a shape, and the share of the bandwidth that shapes may take.
constexpr double kPartBits = 8.0 * 920.0;
constexpr double kShapeShare = 0.5;
// Time to send a lost part again, besides the round trip: the hub requests missing parts 25 ms after a start, and polls every 2 ms.
constexpr std::int64_t kResendNs = 40 * kNanosecondsPerMillisecond;
constexpr std::int64_t kShapeLogEveryNs = kNanosecondsPerSecond;

}  // namespace

// True: the message was about shapes.
bool ReplyLoop::handle_shape(const Message& message) noexcept {
  if (const auto* part = std::get_if<ShapeRequest>(&message)) {
    if (object_shaper_ != nullptr) object_shaper_->accept(*part, hub_.receive_time_ns());
    return true;
  }
  const auto* status = std::get_if<ShapeStatus>(&message);
  if (status != nullptr && object_shaper_ != nullptr) object_shaper_->accept(*status, hub_.receive_time_ns());
  return status != nullptr;
}

// Called after the reply, and sends a few messages at a time: however many shapes come, the force never waits for them.
void ReplyLoop::deform_objects() {
  if (hub_.state() != JoinState::joined) return;
  const std::int64_t now_ns = clock_.now_ns();
  const std::int64_t lead_ns = patch_sender_ != nullptr ? patch_sender_->find_lead_ns(now_ns) : 0;
  ObjectShaper::Pace pace{.lead_ns = lead_ns};
  if (lead_ns > 0) {
    pace.part_ns = static_cast<std::int64_t>(1e9 * kPartBits / (kShapeShare * patch_sender_->bits_per_s()));
    pace.resend_ns = kResendNs + patch_sender_->round_trip_ns();
    pace.stage_ns_per_vertex = patch_sender_->shape_ns_per_vertex();
  }
  object_shaper_->set_pace(pace);
  for (int n = 0; n < kMaxShapeMessages; ++n) {
    const auto message = object_shaper_->take_due(step_, now_ns);
    if (!message) break;
    hub_.send(*message);
    if (const auto* reply = std::get_if<ShapeReply>(&*message)) report_shape(*reply);
    if (!std::holds_alternative<ShapeStart>(*message)) continue;
    if (patch_sender_ != nullptr) patch_sender_->note_shape(std::get<ShapeStart>(*message));
    start_repeats_ = kStartRepeats;
    repeat_start_ns_ = now_ns + kStartRepeatNs;
  }
  // The newest start is sent again, because its datagram may have been lost.
  if (start_repeats_ == 0 || now_ns < repeat_start_ns_) return;
  --start_repeats_;
  repeat_start_ns_ += kStartRepeatNs;
  if (const ShapeStart* newest = object_shaper_->newest()) hub_.send(*newest);
}

void ReplyLoop::send_shape_starts() noexcept {
  if (object_shaper_ == nullptr) return;
  for (std::size_t n = 0; n < object_shaper_->count(); ++n) hub_.send(object_shaper_->newest(n));
}

// A program that sends shapes without pause is logged once; its rejected shapes are logged once a second.
void ReplyLoop::report_shape(const ShapeReply& reply) {
  const std::int64_t now_ns = clock_.now_ns();
  if (reply.rejection[0] != '\0') {
    if (now_ns - shape_rejected_ns_ < kShapeLogEveryNs && shape_rejected_ns_ != 0) return;
    shape_rejected_ns_ = now_ns;
    log_warning("a shape of a program was rejected: {}", reply.rejection.data());
    return;
  }
  const bool is_first = last_shape_ns_ == 0 || now_ns - last_shape_ns_ > kShapeLogEveryNs;
  last_shape_ns_ = now_ns;
  if (is_first) log_info("a program deforms {}", object_shaper_->name_of(reply.object));
}

}  // namespace hapton
