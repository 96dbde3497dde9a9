#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace hapton {

// A message and the time at which the hub received or sent it, s from the beginning of the recording.
template <class Message>
struct Timed {
  double t_s = 0.0;
  Message message;
};

// The number of messages until that time. Pre: `all` is sorted by time.
template <class Message>
std::size_t count_until(std::span<const Timed<Message>> all, double t_s) {
  return static_cast<std::size_t>(std::ranges::upper_bound(all, t_s, {}, &Timed<Message>::t_s) - all.begin());
}

}  // namespace hapton
