#pragma once

#include "core/base/mailbox.h"
#include "hid/hid_port.h"
#include "hid/hid_transport.h"
#include "hid/space_mouse.h"

namespace hapton {

// A SpaceMouse, read by a thread of its own; unplugged, it is at rest until it is back.
// Threads: one owns it. RT: state yes; the rest is set-up only.
class SpaceMouseReader final : private HidListener {
 public:
  explicit SpaceMouseReader(HidOpener opener);

  // Error: none is plugged in, or it may not be opened; one line.
  Result<void> open() { return port_.open(); }
  // Instead of open(): looks for one until it is there; the log says when.
  void start() { port_.start(); }

  // How the cap is held at now_ns (CLOCK_MONOTONIC).
  SpaceMouseState state(std::int64_t now_ns) noexcept;
  // As of the last call of state().
  bool is_there() const noexcept { return newest_.value().is_there; }

  // Of the device that open() opened.
  const HidDescription& description() const noexcept { return description_; }

 private:
  struct Received {
    SpaceMouseDecoder decoder;
    bool is_there = false;
  };

  Result<void> on_opened(HidTransport& transport) override;
  void on_report(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept override;
  void on_drained(std::int64_t now_ns) noexcept override;
  void on_gone() noexcept override;

  HidDescription description_;
  Received received_;      // of the port's thread
  bool has_news_ = false;  // of the port's thread
  Mailbox<Received> newest_;
  HidPort port_;  // last: its thread ends first
};

}  // namespace hapton
