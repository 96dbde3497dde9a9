#include "closed_loop/force_chain.h"

#include <algorithm>
#include <cmath>

#include "safety/vector_limit.h"

namespace hapton {

ForceChain::ForceChain(ForceLaw& law, const Options& options)
    : law_(law), options_(options), to_law_(options.seed), from_law_(options.seed + 0x9e3779b97f4a7c15) {
  to_law_.set(options.to_law);
  from_law_.set(options.from_law);
  if (options.gate == Gate::governor) governor_.emplace(options.limits);
}

std::optional<std::int64_t> ForceChain::next_ns() const noexcept {
  if (packets_.empty()) return std::nullopt;
  return packets_.front().due_ns;
}

// The order of a heap whose front is the packet that is due first; of two packets due at the same time, the one of the older sample.
bool ForceChain::is_later(const Packet& a, const Packet& b) noexcept {
  return a.due_ns != b.due_ns ? a.due_ns > b.due_ns : a.sample_ns > b.sample_ns;
}

void ForceChain::sample(const Vec3& p_WD, std::int64_t now_ns) {
  ++counters_.samples;
  const double step_m = options_.encoder_step_m;
  const Vec3 read_m = step_m > 0.0 ? Vec3((p_WD / step_m).array().round() * step_m) : p_WD;
  if (options_.stage != nullptr) options_.stage->observe(read_m, now_ns);
  if (governor_) governor_->observe({.time_ns = now_ns, .p_WD = read_m}, DeviceStatus::ready);
  send({.sample_ns = now_ns, .value = read_m}, to_law_, now_ns);
  receive(now_ns);
  run_gate(std::nullopt, now_ns);
}

void ForceChain::send(const Packet& packet, FaultInjector& link, std::int64_t now_ns) {
  const Fate fate = link.draw(now_ns);
  if (fate.kind != Fate::Kind::passed) {
    ++counters_.lost;
    return;
  }
  for (std::size_t copy = 0; copy < fate.copies; ++copy) {
    packets_.push_back(packet);
    packets_.back().due_ns = fate.due_ns[copy];
    std::push_heap(packets_.begin(), packets_.end(), is_later);
  }
}

// Also receives a reply that is sent during this call if it is due by now.
void ForceChain::receive(std::int64_t now_ns) {
  while (!packets_.empty() && packets_.front().due_ns <= now_ns) {
    std::pop_heap(packets_.begin(), packets_.end(), is_later);
    const Packet packet = packets_.back();
    packets_.pop_back();
    if (packet.is_reply) {
      accept(packet, now_ns);
    } else {
      reply(packet, now_ns);
    }
  }
}

void ForceChain::reply(const Packet& packet, std::int64_t now_ns) {
  if (packet.sample_ns <= law_sample_ns_) {
    ++counters_.overtaken;
    return;
  }
  if (law_sample_ns_ < 0) law_.reset(packet.value);
  const double dt_s = law_sample_ns_ < 0 ? 0.0 : 1e-9 * static_cast<double>(packet.sample_ns - law_sample_ns_);
  law_sample_ns_ = packet.sample_ns;
  send({.sample_ns = packet.sample_ns, .value = law_.step(packet.value, dt_s), .is_reply = true}, from_law_, now_ns);
}

void ForceChain::accept(const Packet& packet, std::int64_t now_ns) {
  ++counters_.replies;
  if (packet.sample_ns <= reply_sample_ns_) {
    ++counters_.overtaken;
    return;
  }
  reply_sample_ns_ = packet.sample_ns;
  newest_force_n_ = packet.value;
  if (options_.gate == Gate::newest) {
    write(packet.value, now_ns);
  } else {
    run_gate(WrenchCommand{{.force_n = packet.value}, packet.sample_ns}, now_ns);
  }
}

void ForceChain::run_gate(const std::optional<WrenchCommand>& command, std::int64_t now_ns) {
  switch (options_.gate) {
    case Gate::newest:
      // The newest force stays. It is written again, because the stage may shape it by the new sample.
      if (!command && options_.stage != nullptr) write(newest_force_n_, now_ns);
      return;
    case Gate::filter:
      if (command) filter_.take(*command, now_ns);
      filter_.times_out(now_ns);
      write(filter_.is_live() ? filter_.wrench().force_n : Vec3(Vec3::Zero()), now_ns);
      return;
    case Gate::governor:
      write(governor_->step(command, now_ns).force_n, now_ns);
      return;
  }
}

void ForceChain::write(const Vec3& accepted_n, std::int64_t now_ns) {
  force_n_ = options_.stage != nullptr ? options_.stage->shape(accepted_n, now_ns) : accepted_n;
  if (options_.max_force_n > 0.0) force_n_ = shortened(force_n_, options_.max_force_n);
  if (options_.stage != nullptr) options_.stage->note_written(force_n_);
}

}  // namespace hapton
