#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "link/session_entry.h"

namespace hapton {

// The first bytes of a session file.
inline constexpr std::string_view kSessionMagic = "hapton.session/1\n";

// Turns headers and entries into the messages of proto/session.proto and back, each with its length in front and its check at the end.
// RT: no. Threads: one.
class SessionCodec {
 public:
  SessionCodec();
  ~SessionCodec();
  SessionCodec(SessionCodec&&) noexcept;
  SessionCodec& operator=(SessionCodec&&) noexcept;

  // Appends one message, length first.
  void append(const SessionHeader& header, std::string& to);
  void append(const SessionEntry& entry, std::string& to);

  // Appends the message alone, without length and check: Cycle and Event of proto/session.proto.
  void append_alone(const CycleNote& cycle, std::string& to);
  void append_alone(const SessionEvent& event, std::string& to);

  enum class Status : std::uint8_t {
    ok,
    unknown,  // whole, but of a kind that this build does not know
    cut,      // the bytes end within it
    damaged,  // its check does not hold, or it is no such message
  };
  struct Read {
    Status status = Status::cut;
    std::size_t bytes = 0;  // of the whole message with its length; 0 unless ok or unknown
  };

  // Reads the message that begins at the front of `bytes`. Post: entry.datagram points into this codec, until its next call.
  Read read(std::string_view bytes, SessionHeader& header);
  Read read(std::string_view bytes, SessionEntry& entry);

 private:
  struct Wire;
  std::unique_ptr<Wire> wire_;
};

}  // namespace hapton
