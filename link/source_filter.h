#pragma once

#include <linux/filter.h>

#include <array>
#include <cstddef>
#include <span>

#include "link/endpoint.h"

namespace hapton {

// A filter for a UDP socket with one peer: the kernel drops datagrams from any other address, before they cost this process a system call
// each. The caller installs it. RT: yes, no heap. Threads: one.
class SourceFilter {
 public:
  explicit SourceFilter(const Address& peer) noexcept;
  std::span<sock_filter> program() noexcept { return std::span(program_).first(size_); }

 private:
  void add(std::uint16_t code, std::uint32_t k, std::uint8_t jump_true = 0, std::uint8_t jump_false = 0) noexcept;

  std::array<sock_filter, 16> program_ = {};
  std::size_t size_ = 0;
};

}  // namespace hapton
