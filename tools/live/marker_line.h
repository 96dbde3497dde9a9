#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/messages.h"

namespace hapton {

// An input of a serial or parallel port: "/dev/ttyS0:CTS", "/dev/parport0:ACK"; or a button of a VRPN server (vrpn_line.h).
struct LineInput {
  std::string device;
  std::string name;          // CTS, DSR, DCD or RI; ACK, BUSY, PAPEROUT, SELECT or ERROR; "button 3"
  bool is_parallel = false;  // of a parallel port
  int bit = 0;               // mask in the word of TIOCMGET, or in the parallel port's status byte; of VRPN, the number of the button
  bool is_vrpn = false;
};

// Reads DEVICE:PIN or vrpn:NAME@HOST:BUTTON. Error, one line: the text has neither form, or the port has no such pin. RT: no.
Result<LineInput> parse_line_input(std::string_view text);

// Whether the pin of the input is high, by the status byte of a parallel port, whose hardware inverts BUSY. Pre: is_parallel. RT: yes.
bool is_high(const LineInput& input, unsigned char status) noexcept;

// A line that is on or off. RT: no. Threads: one.
class DigitalLine {
 public:
  virtual ~DigitalLine() = default;
  // Error, one line: the line cannot be read any more.
  virtual Result<bool> is_on() = 0;
  // Number of changes since it was opened, including those too short to be seen; none: the driver does not count.
  virtual std::optional<std::uint64_t> changes() { return std::nullopt; }
};

// Error, one line: no such device, no permission, or it has no such input. The kernel sets RTS and DTR of a serial port when it is opened.
// A parallel port belongs to this program alone until the line is destroyed.
Result<std::unique_ptr<DigitalLine>> open_line_input(const LineInput& input);

enum class Edges : std::uint8_t { on, off, both };

// Makes a marker for each change of a line that is to be marked, and repeats it until a reply comes, since datagrams can be lost. Units:
// ns of one clock. RT: no. Threads: one.
class LineMarker {
 public:
  static constexpr std::int64_t kRepeatNs = 100'000'000;          // from one sending of a marker to the next; a free choice
  static constexpr std::int64_t kReplyTimeoutNs = 2'000'000'000;  // after which a marker counts as not recorded; a free choice
  static constexpr std::size_t kMaxPending = 16;                  // as many as the hub remembers, so that no marker is recorded twice

  struct Counts {
    std::uint64_t changes = 0;   // changes seen, marked or not
    std::uint64_t marked = 0;    // markers in the recording
    std::uint64_t rejected = 0;  // markers that the hub rejected
    std::uint64_t given_up = 0;  // markers without a reply, or not sent because too many waited
  };

  // on_text, off_text: texts of the markers. Pre: make_marker accepts both.
  LineMarker(Edges edges, std::string on_text, std::string off_text);

  // Takes the present level of the line. The first call marks nothing.
  void observe(bool is_on, std::int64_t now_ns);
  // The marker to send now: of those that are new or due again, that of the oldest change. None: nothing is due.
  std::optional<Marker> next(std::int64_t now_ns);
  // A line for a person, if the reply belongs to a marker that waits for one; none otherwise.
  std::optional<std::string> take(const MarkerReply& reply);

  const Counts& counts() const noexcept { return counts_; }
  bool has_pending() const noexcept { return !pending_.empty(); }

 private:
  struct PendingMarker {
    Marker marker;
    std::string text;
    std::int64_t made_ns = 0;
    std::int64_t next_ns = 0;
  };
  bool is_marked(bool is_on) const noexcept { return edges_ == Edges::both || (edges_ == Edges::on) == is_on; }

  Edges edges_;
  std::string on_text_;
  std::string off_text_;
  std::optional<bool> is_on_;
  std::deque<PendingMarker> pending_;
  Counts counts_;
};

// Marks the edges `edges`: on, off or both. The text of a marker is the input's name with " on" or " off" after it. text: takes the place
// of the name and, if only one edge is marked, of the whole; may be empty. Error, one line: a marker cannot have such a text. RT: no.
Result<LineMarker> make_line_marker(const LineInput& input, std::string_view edges, const std::string& text);

}  // namespace hapton
