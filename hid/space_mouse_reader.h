#pragma once

#include "core/base/mailbox.h"
#include "hid/hid_port.h"
#include "hid/hid_transport.h"
#include "hid/space_mouse.h"

namespace hapton {

// A SpaceMouse, read by a thread of its own. While it is unplugged, it counts as at rest.
// Threads: one, for all public functions. RT: state and is_there yes; the rest set-up only.
class SpaceMouseReader final : private HidListener {
 public:
  explicit SpaceMouseReader(HidOpener opener);

  // Opens the SpaceMouse. Error, one line: none is plugged in, or it cannot be opened.
  Result<void> open() { return port_.open(); }
  // In place of open(): searches for a SpaceMouse until one is plugged in; the log says when it was found.
  void start() { port_.start(); }

  // How the cap is held at now_ns (CLOCK_MONOTONIC).
  SpaceMouseState state(std::int64_t now_ns) noexcept;
  // Whether it was plugged in at the last call of state().
  bool is_there() const noexcept { return newest_.value().is_there; }

  // Description of the device that open() opened. Pre: open() succeeded.
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
  Received received_;      // used by the port's thread
  bool has_news_ = false;  // received_ has changed and is not published yet; likewise
  Mailbox<Received> newest_;
  HidPort port_;  // last member, so that its thread ends before the others are destroyed
};

}  // namespace hapton
