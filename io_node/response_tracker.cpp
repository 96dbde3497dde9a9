#include "io_node/response_tracker.h"

#include <algorithm>

namespace hapton {

// Moves an entry to another state and the counts with it.
void ResponseTracker::set_state(Entry& into, State state) noexcept {
  const auto add = [this](State of, std::uint64_t n) {
    if (of == State::superseded) counts_.superseded += n;
    if (of == State::lost) counts_.lost += n;
    if (of == State::excused || of == State::withheld) counts_.excused += n;
  };
  add(into.state, ~std::uint64_t{0});
  add(state, 1);
  into.state = state;
}

void ResponseTracker::take(std::uint64_t sample, std::int64_t time_ns, bool is_expected) noexcept {
  note(sample, time_ns, is_expected ? State::waiting : State::excused);
}

void ResponseTracker::withhold(std::uint64_t sample, std::int64_t time_ns) noexcept { note(sample, time_ns, State::withheld); }

void ResponseTracker::note(std::uint64_t sample, std::int64_t time_ns, State state) noexcept {
  Entry& slot = entry(sample);
  if (slot.state == State::waiting) set_state(slot, State::excused);
  slot = {sample, time_ns, State::none};
  set_state(slot, state);
  ++counts_.taken;
  newest_sample_ = sample;
}

ResponseTracker::Verdict ResponseTracker::reply(const ForceCommand& command) noexcept {
  Entry& found = entry(command.echo_sample);
  const bool is_ours = command.echo_sample != 0 && found.sample == command.echo_sample && found.time_ns == command.echo_sample_time_ns;
  if (!is_ours) {
    ++counts_.unknown;
    return Verdict::unknown;
  }
  if (found.state == State::replied) {
    ++counts_.duplicate;
    return Verdict::duplicate;
  }
  set_state(found, State::replied);
  if (command.echo_sample < newest_replied_) {
    ++counts_.reordered;
    return Verdict::reordered;
  }
  newest_replied_ = command.echo_sample;
  supersede_before(command.echo_sample, command.skipped_samples);
  if (command.echo_sample < newest_sample_) {
    ++counts_.late;
    return Verdict::late;
  }
  ++counts_.in_time;
  return Verdict::in_time;
}

// The node skipped `count` samples since its last reply: the newest that were sent to it before this one.
void ResponseTracker::supersede_before(std::uint64_t sample, std::uint32_t count) noexcept {
  for (std::uint64_t s = sample - 1; count > 0 && s > settled_until_ && s + kCapacity > newest_sample_; --s) {
    Entry& skipped = entry(s);
    if (skipped.sample != s || skipped.state == State::withheld) continue;
    if (skipped.state == State::replied) return;
    if (skipped.state == State::waiting) set_state(skipped, State::superseded);
    --count;
  }
}

// Puts every waiting sample before `end` into this state.
void ResponseTracker::settle_until(std::uint64_t end, State state) noexcept {
  if (newest_sample_ > kCapacity) settled_until_ = std::max(settled_until_, newest_sample_ - kCapacity);
  for (; settled_until_ + 1 < end; ++settled_until_) {
    Entry& next = entry(settled_until_ + 1);
    if (next.sample == settled_until_ + 1 && next.state == State::waiting) set_state(next, state);
  }
}

void ResponseTracker::excuse_waiting() noexcept {
  settle_until(newest_replied_, State::lost);
  settle_until(newest_sample_ + 1, State::excused);
}

void ResponseTracker::settle(std::int64_t now_ns) noexcept {
  std::uint64_t end = settled_until_ + 1;
  while (end < newest_replied_ && entry(end).time_ns < now_ns - kReplyTimeoutNs) ++end;
  settle_until(end, State::lost);
}

void ResponseTracker::close(bool is_alive) noexcept {
  settle_until(newest_replied_, State::lost);
  settle_until(newest_sample_ + 1, is_alive ? State::lost : State::excused);
}

}  // namespace hapton
