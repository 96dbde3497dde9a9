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

// Encodes and decodes headers and entries as messages of proto/session.proto, each with its length in front and its CRC at the end.
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

  // Appends the message alone, without length and CRC: Cycle, Event and Shape of proto/session.proto.
  void append_alone(const CycleNote& cycle, std::string& to);
  void append_alone(const SessionEvent& event, std::string& to);
  void append_alone(const SessionShape& shape, std::string& to);

  enum class Status : std::uint8_t {
    ok,
    unknown,  // complete, but of a kind that this build does not know
    cut,      // the bytes end within the message
    damaged,  // its CRC is wrong, or it is not a valid message
  };
  struct Read {
    Status status = Status::cut;
    std::size_t bytes = 0;  // size of the message with its length; 0 unless ok or unknown
  };

  // Reads the message that begins at the front of `bytes`. Post: entry.datagram and the marker's text are valid until the next call.
  Read read(std::string_view bytes, SessionHeader& header);
  Read read(std::string_view bytes, SessionEntry& entry);

 private:
  struct Wire;
  std::unique_ptr<Wire> wire_;
};

}  // namespace hapton
