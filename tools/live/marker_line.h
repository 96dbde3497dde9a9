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

// An input of a serial or parallel port: "/dev/ttyS0:CTS", "/dev/parport0:ACK"; or a button of VRPN (vrpn_line.h).
struct LineInput {
  std::string device;
  std::string name;          // CTS, DSR, DCD or RI; ACK, BUSY, PAPEROUT, SELECT or ERROR; "button 3"
  bool is_parallel = false;  // port
  int bit = 0;               // of TIOCMGET, or of the parallel port's status; or the button
  bool is_vrpn = false;
};

// Error, one line: not DEVICE:PIN, or no such pin. RT: no.
Result<LineInput> parse_line_input(std::string_view text);

// Whether that pin is high in the status byte of a parallel port, whose hardware inverts BUSY. Pre: is_parallel. RT: yes.
bool is_high(const LineInput& input, unsigned char status) noexcept;

// A line that is on or off. RT: no. Threads: one.
class DigitalLine {
 public:
  virtual ~DigitalLine() = default;
  // Error, one line: the line is gone.
  virtual Result<bool> is_on() = 0;
  // Changes since it was opened, those too short to be seen included; none: the driver does not count.
  virtual std::optional<std::uint64_t> changes() { return std::nullopt; }
};

// Error, one line: no such device, no right to it, or it has no such inputs. Opening a serial port turns its RTS and DTR on, as ever.
// A parallel port belongs to this program then.
Result<std::unique_ptr<DigitalLine>> open_line_input(const LineInput& input);

enum class Edges : std::uint8_t { on, off, both };

// Makes a marker of each change of a line that counts, and repeats it until it gets a reply, as a datagram may be lost. Units: ns, of one
// clock. RT: no. Threads: one.
class LineMarker {
 public:
  static constexpr std::int64_t kRepeatNs = 100'000'000;      // between two sendings of a marker; a free choice
  static constexpr std::int64_t kPatienceNs = 2'000'000'000;  // then the marker counts as not recorded; a free choice
  static constexpr std::size_t kMaxWaiting = 16;              // as many as the hub remembers, so that none is recorded twice

  struct Counts {
    std::uint64_t changes = 0;   // seen
    std::uint64_t marked = 0;    // in the recording
    std::uint64_t rejected = 0;  // by the hub
    std::uint64_t given_up = 0;  // without a reply, or too many at a time
  };

  // on_text, off_text: of the markers; both are valid.
  LineMarker(Edges edges, std::string on_text, std::string off_text);

  // The line, as it is now. The first call reads the level, and marks nothing.
  void see(bool is_on, std::int64_t now_ns);
  // What to send now: new ones first in the order of their changes, then repetitions. None: nothing is due.
  std::optional<Marker> next(std::int64_t now_ns);
  // A line for a person, of a reply that belongs to one of ours.
  std::optional<std::string> take(const MarkerReply& reply);

  const Counts& counts() const noexcept { return counts_; }
  bool is_waiting() const noexcept { return !waiting_.empty(); }

 private:
  struct Waiting {
    Marker marker;
    std::string text;
    std::int64_t made_ns = 0;
    std::int64_t next_ns = 0;
  };
  bool matters(bool is_on) const noexcept { return edges_ == Edges::both || (edges_ == Edges::on) == is_on; }

  Edges edges_;
  std::string on_text_;
  std::string off_text_;
  std::optional<bool> is_on_;
  std::deque<Waiting> waiting_;
  Counts counts_;
};

// Marks the edges that are named, on, off or both, with the input's name and " on" or " off". text: takes the place of the name, and where
// one edge is marked, of both; may be empty. Error, one line: it is not a text of a marker. RT: no.
Result<LineMarker> make_line_marker(const LineInput& input, std::string_view edges, const std::string& text);

}  // namespace hapton
