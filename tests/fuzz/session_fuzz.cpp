// Any bytes as a recorded session, whose entries are then decoded as datagrams.
#include "link/codec.h"
#include "link/session_reader.h"
#include "tests/fuzz/input_file.h"
#include "tests/fuzz/session_mutator.h"

FUZZ_TARGET(session) {
  using namespace hapton;
  static fuzz::InputFile file("session.hapton");
  static Codec codec;
  auto reader = SessionReader::open(file.write(bytes));
  if (!reader) {
    fuzz::require(!reader.error().what.empty());
    return;
  }
  SessionEntry entry;
  Datagram datagram;
  std::size_t entries = 0;
  while (reader->next(entry)) {
    fuzz::require(entry.datagram.size() <= bytes.size());
    fuzz::require(++entries <= bytes.size());
    (void)codec.decode(entry.datagram, datagram);
  }
  fuzz::require(!reader->next(entry));
  if (reader->problem().empty()) fuzz::note_passage();
}

FUZZ_MUTATOR(session, hapton::fuzz::mutate_session);
FUZZ_CROSSOVER(session, hapton::fuzz::cross_sessions);
