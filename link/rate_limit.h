#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "link/endpoint.h"

namespace hapton {

// Token bucket: permits `per_second` events in the long run and `burst` at once. RT: yes. Threads: one.
class TokenBucket {
 public:
  constexpr TokenBucket() = default;
  constexpr TokenBucket(std::int64_t per_second, std::int64_t burst)
      : token_ns_(1'000'000'000 / per_second), capacity_ns_(token_ns_ * burst), level_ns_(capacity_ns_) {}

  bool take(std::int64_t now_ns) noexcept {
    // A clock that goes back adds no tokens.
    if (now_ns > last_ns_)
      level_ns_ = std::min(capacity_ns_, now_ns - last_ns_ > capacity_ns_ ? capacity_ns_ : level_ns_ + (now_ns - last_ns_));
    last_ns_ = std::max(last_ns_, now_ns);
    if (level_ns_ < token_ns_) return false;
    level_ns_ -= token_ns_;
    return true;
  }

 private:
  std::int64_t token_ns_ = 1;     // time in which one token is added; the bucket's level is counted in this time
  std::int64_t capacity_ns_ = 0;  // 0: permits nothing
  std::int64_t level_ns_ = 0;
  std::int64_t last_ns_ = 0;
};

// One limit for each source address (without port) and one for all sources. A hash assigns sources to kSources buckets; sources in one
// bucket share its limit, so the limit of a source is never exceeded. RT: yes. Threads: one.
class SourceLimit {
 public:
  struct Rates {
    std::int64_t source_per_second = 1;
    std::int64_t source_burst = 1;
    std::int64_t all_per_second = 1;
    std::int64_t all_burst = 1;
  };
  static constexpr std::size_t kSources = 64;

  // seed: for the hash; unknown to senders, so that none can aim at the bucket of another.
  SourceLimit(const Rates& rates, std::uint64_t seed) : seed_(seed), all_(rates.all_per_second, rates.all_burst) {
    buckets_.fill(TokenBucket(rates.source_per_second, rates.source_burst));
  }

  bool take(const Address& from, std::int64_t now_ns) noexcept { return buckets_[bucket_of(from)].take(now_ns) && all_.take(now_ns); }

 private:
  std::size_t bucket_of(const Address& from) const noexcept {
    std::uint64_t hash = seed_;
    for (const std::uint8_t byte : from.ip) hash = (hash ^ byte) * 0x9E3779B97F4A7C15U + (hash >> 29);
    return (hash >> 32) % kSources;
  }

  std::uint64_t seed_;
  std::array<TokenBucket, kSources> buckets_;
  TokenBucket all_;
};

}  // namespace hapton
