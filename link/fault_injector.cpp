#include "link/fault_injector.h"

#include <cmath>
#include <string_view>
#include <utility>

namespace hapton {
namespace {

// Largest values that a script may contain, beyond any network of interest: a delay in ns, a burst in datagrams.
constexpr std::int64_t kLongestNs = 60'000'000'000;
constexpr double kLongestBurst = 1e6;

Result<void> check_share(std::string_view name, double share) {
  if (!(share >= 0.0 && share <= 1.0)) return fail("{} is {}; a share is between 0 and 1", name, share);
  return {};
}

Result<void> check_time(std::string_view name, std::int64_t time_ns) {
  if (time_ns < 0 || time_ns > kLongestNs)
    return fail("{} is {} ms; it is between 0 and 60000 ms", name, 1e-6 * static_cast<double>(time_ns));
  return {};
}

}  // namespace

Result<void> check_faults(const LinkFaults& faults) {
  const std::pair<std::string_view, double> shares[] = {
      {"loss", faults.loss},       {"burst share", faults.burst_share}, {"burst loss", faults.burst_loss},
      {"reorder", faults.reorder}, {"duplicate", faults.duplicate},     {"corrupt", faults.corrupt},
  };
  for (const auto& [name, share] : shares) {
    if (auto checked = check_share(name, share); !checked) return checked;
  }
  const std::pair<std::string_view, std::int64_t> times[] = {
      {"delay", faults.delay_ns}, {"jitter", faults.jitter_ns}, {"reorder time", faults.reorder_by_ns}};
  for (const auto& [name, time_ns] : times) {
    if (auto checked = check_time(name, time_ns); !checked) return checked;
  }
  if (!(faults.burst_length >= 1.0 && faults.burst_length <= kLongestBurst)) {
    return fail("burst length is {}; it is between 1 and {} datagrams", faults.burst_length, kLongestBurst);
  }
  // Between two bursts there is at least one datagram in the good state.
  if (faults.burst_share > faults.burst_length / (1.0 + faults.burst_length)) {
    return fail("burst share {} is more than bursts of {} datagrams can make up; at most {:.3f}", faults.burst_share, faults.burst_length,
                faults.burst_length / (1.0 + faults.burst_length));
  }
  return {};
}

// Computed from random bits, because std::uniform_real_distribution differs between standard libraries.
double FaultInjector::draw_share() noexcept { return static_cast<double>(random_() >> 11) * 0x1p-53; }

void FaultInjector::draw_state() noexcept {
  const double leave = 1.0 / faults_.burst_length;
  const double enter = faults_.burst_share * leave / (1.0 - faults_.burst_share);
  const double drawn = draw_share();
  is_bad_state_ = is_bad_state_ ? drawn >= leave : drawn < enter;
  if (faults_.burst_share <= 0.0) is_bad_state_ = false;
}

Fate FaultInjector::draw(std::int64_t now_ns) noexcept {
  draw_state();
  const bool is_lost = draw_share() < (is_bad_state_ ? faults_.burst_loss : faults_.loss);
  Fate fate;
  fate.held_back = draw_share() < faults_.reorder;
  fate.copies = draw_share() < faults_.duplicate ? 2 : 1;
  fate.corrupt = draw_share() < faults_.corrupt;
  fate.damage = random_();
  for (std::int64_t& due_ns : fate.due_ns) {
    const auto jitter_ns = static_cast<std::int64_t>(std::llround(draw_share() * static_cast<double>(faults_.jitter_ns)));
    due_ns = now_ns + faults_.delay_ns + jitter_ns;
  }
  // Of a duplicated datagram only the first copy is held back.
  if (fate.held_back) fate.due_ns[0] += faults_.reorder_by_ns;
  if (is_lost) fate.kind = is_bad_state_ ? Fate::Kind::lost_in_burst : Fate::Kind::lost;
  if (faults_.partition) fate.kind = Fate::Kind::partitioned;
  return fate;
}

void damage_bytes(std::span<std::byte> bytes, std::uint64_t damage) noexcept {
  if (bytes.empty()) return;
  const auto change = static_cast<std::byte>(1 + (damage & 0xFF) % 255);
  bytes[(damage >> 8) % bytes.size()] ^= change;
}

}  // namespace hapton
