// Any bytes as a recorded session.
#include "link/session_reader.h"
#include "tests/fuzz/input_file.h"

FUZZ_TARGET(session) {
  using namespace hapton;
  static fuzz::InputFile file("session.hapton");
  auto reader = SessionReader::open(file.write(bytes));
  if (!reader) {
    fuzz::require(!reader.error().what.empty());
    return;
  }
  SessionEntry entry;
  std::size_t entries = 0;
  while (reader->next(entry)) {
    fuzz::require(entry.datagram.size() <= bytes.size());
    fuzz::require(++entries <= bytes.size());
  }
  fuzz::require(!reader->next(entry));
}
