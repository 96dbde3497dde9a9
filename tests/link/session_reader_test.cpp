#include "link/session_reader.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>
#include <system_error>
#include <vector>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

SessionEntry plain_entry(SessionEntry::Kind kind, std::int64_t time_ns) {
  SessionEntry entry;
  entry.kind = kind;
  entry.time_ns = time_ns;
  return entry;
}

// has_end: the file has an end entry, as io_node writes it now; false: as io_node wrote it before there were end entries.
std::string make_file(int entries, bool has_end = false) {
  SessionCodec codec;
  std::string bytes(kSessionMagic);
  codec.append(SessionHeader{.build = "b", .settings = {{"rate", "1000"}}, .has_end = has_end}, bytes);
  const std::string padding(700, 'p');
  for (int n = 0; n < entries; ++n) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::sent;
    entry.time_ns = n;
    entry.datagram = std::as_bytes(std::span(padding.data(), padding.size()));
    codec.append(entry, bytes);
  }
  if (has_end) codec.append(plain_entry(SessionEntry::Kind::end, entries), bytes);
  return bytes;
}

// Reads to the end. Expects the entries that make_file() writes, from the first on.
int count_entries(SessionReader& reader) {
  SessionEntry entry;
  int n = 0;
  while (reader.next(entry)) EXPECT_EQ(entry.time_ns, n++);
  EXPECT_FALSE(reader.next(entry));
  return n;
}

struct SessionReaders : testing::Test {
  ScratchFolder scratch;
};

TEST_F(SessionReaders, ReadEveryEntryOfAFileLongerThanTheBuffer) {
  auto reader = SessionReader::open(scratch.write("s", make_file(5000)));
  ASSERT_TRUE(reader) << reader.error().what;
  EXPECT_EQ(reader->header().settings.at(0).second, "1000");
  EXPECT_EQ(count_entries(*reader), 5000);
  EXPECT_EQ(reader->problem(), "");
}

TEST_F(SessionReaders, ContinueAtThePositionOfASeek) {
  auto reader = SessionReader::open(scratch.write("s", make_file(3000)));
  ASSERT_TRUE(reader) << reader.error().what;
  SessionEntry entry;
  std::vector<std::uint64_t> positions;
  do {
    positions.push_back(reader->position());
  } while (reader->next(entry));
  for (const std::size_t n : {std::size_t{2900}, std::size_t{0}, std::size_t{1500}, std::size_t{1499}}) {
    reader->seek(positions[n]);
    ASSERT_TRUE(reader->next(entry));
    EXPECT_EQ(entry.time_ns, static_cast<std::int64_t>(n));
    EXPECT_EQ(reader->position(), positions[n + 1]);
  }
}

// A count that included the entries before the seek would fit no position in the file.
TEST_F(SessionReaders, CountFromThePositionOfASeek) {
  const std::string whole = make_file(10);
  auto reader = SessionReader::open(scratch.write("s", whole.substr(0, whole.size() - 1)));
  ASSERT_TRUE(reader) << reader.error().what;
  SessionEntry entry;
  for (int n = 0; n < 6; ++n) ASSERT_TRUE(reader->next(entry));
  const std::uint64_t sixth = reader->position();
  while (reader->next(entry)) continue;
  reader->seek(sixth);
  while (reader->next(entry)) continue;
  EXPECT_NE(reader->problem().find("cut short after 3 entries from byte " + std::to_string(sixth)), std::string::npos) << reader->problem();
}

TEST_F(SessionReaders, RejectAPipeWithoutWaiting) {
  const auto pipe = scratch.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::filesystem::path& path : {pipe, std::filesystem::path("/dev/null")}) {
    const auto reader = SessionReader::open(path);
    ASSERT_FALSE(reader);
    EXPECT_NE(reader.error().what.find(path.string() + ": is not a regular file"), std::string::npos);
  }
}

TEST_F(SessionReaders, GiveWhatIsBeforeACutAndSayWhereItIs) {
  const std::string whole = make_file(10);
  auto reader = SessionReader::open(scratch.write("s", whole.substr(0, whole.size() - 1)));
  ASSERT_TRUE(reader);
  EXPECT_EQ(count_entries(*reader), 9);
  EXPECT_NE(reader->problem().find("cut short after 9 entries"), std::string::npos) << reader->problem();
}

TEST_F(SessionReaders, SayThatARecordingHasNoEnd) {
  const std::string whole = make_file(3, true);
  auto reader = SessionReader::open(scratch.write("s", whole));
  ASSERT_TRUE(reader);
  EXPECT_TRUE(reader->header().has_end);
  const std::uint64_t first = reader->position();
  EXPECT_EQ(count_entries(*reader), 3);
  EXPECT_EQ(reader->problem(), "");
  reader->seek(first);
  EXPECT_EQ(count_entries(*reader), 3);
  EXPECT_EQ(reader->problem(), "");

  SessionCodec codec;
  std::string end;
  codec.append(plain_entry(SessionEntry::Kind::end, 3), end);
  auto killed = SessionReader::open(scratch.write("s", whole.substr(0, whole.size() - end.size())));
  ASSERT_TRUE(killed);
  EXPECT_EQ(count_entries(*killed), 3);
  EXPECT_NE(killed->problem().find("has no end after 3 entries"), std::string::npos) << killed->problem();
  killed->seek(first);
  EXPECT_EQ(killed->problem(), "");
  EXPECT_EQ(count_entries(*killed), 3);
  EXPECT_NE(killed->problem(), "");

  // Two recordings in one file: the end is not the last entry.
  std::string more;
  codec.append(plain_entry(SessionEntry::Kind::dropped, 3), more);
  auto longer = SessionReader::open(scratch.write("s", whole + more));
  ASSERT_TRUE(longer);
  EXPECT_EQ(count_entries(*longer), 4);
  EXPECT_NE(longer->problem(), "");
}

// Makes every further read of this file fail, through each descriptor that this process has open for it.
void break_disk_under(const std::filesystem::path& file) {
  const int broken = ::open("/proc/self/mem", O_RDONLY | O_CLOEXEC);
  for (const auto& open : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    if (std::filesystem::read_symlink(open.path(), gone) != std::filesystem::canonical(file)) continue;
    ASSERT_GE(::dup2(broken, std::stoi(open.path().filename().string())), 0);
  }
  ::close(broken);
}

// A read error is taken neither for the end of the file, where an earlier build wrote no end entry, nor for an io_node that was killed.
TEST_F(SessionReaders, SayThatAFileCannotBeReadOn) {
  for (const bool has_end : {false, true}) {
    const auto file = scratch.write("s", make_file(5000, has_end));
    auto reader = SessionReader::open(file);
    ASSERT_TRUE(reader) << reader.error().what;
    break_disk_under(file);
    const int entries = count_entries(*reader);
    EXPECT_LT(entries, 5000);
    EXPECT_NE(reader->problem().find("cannot be read after " + std::to_string(entries) + " entries"), std::string::npos)
        << reader->problem();
    EXPECT_NE(reader->problem().find("Input/output error"), std::string::npos) << reader->problem();
  }
  const auto broken = SessionReader::open("/proc/self/mem");
  ASSERT_FALSE(broken);
  EXPECT_NE(broken.error().what.find("cannot be read after 0 entries, at byte 0: Input/output error"), std::string::npos)
      << broken.error().what;
}

TEST_F(SessionReaders, GiveWhatIsBeforeADamagedEntry) {
  std::string bytes = make_file(10);
  bytes[bytes.size() - 1000] ^= 1;
  auto reader = SessionReader::open(scratch.write("s", bytes));
  ASSERT_TRUE(reader);
  EXPECT_EQ(count_entries(*reader), 8);
  EXPECT_NE(reader->problem().find("damaged after 8 entries"), std::string::npos) << reader->problem();
}

TEST_F(SessionReaders, SurviveWhateverIsInTheFile) {
  std::mt19937_64 random(20261120);
  const std::string whole = make_file(20);
  for (int n = 0; n < 500; ++n) {
    std::string bytes = whole;
    for (std::uint64_t change = 0; change < 1 + random() % 8; ++change) bytes[random() % bytes.size()] = static_cast<char>(random());
    bytes.resize(bytes.size() - random() % 1000);
    auto reader = SessionReader::open(scratch.write("s", bytes));
    if (!reader) continue;
    SessionEntry entry;
    int entries = 0;
    while (reader->next(entry)) ++entries;
    EXPECT_LE(entries, 20);
  }
}

TEST_F(SessionReaders, RejectOtherFilesInOneLine) {
  const std::string whole = make_file(1);
  const struct {
    std::string bytes;
    std::string reason;
  } kCases[] = {{"", "not a recorded session"},
                {"t_s,x_m\n", "not a recorded session"},
                {"hapton.session/2\n....", "another schema"},
                {whole.substr(0, kSessionMagic.size() + 2), "header"}};
  for (const auto& [bytes, reason] : kCases) {
    const auto reader = SessionReader::open(scratch.write("s", bytes));
    ASSERT_FALSE(reader) << bytes;
    EXPECT_NE(reader.error().what.find(reason), std::string::npos) << reader.error().what;
    EXPECT_EQ(reader.error().what.find('\n'), std::string::npos);
  }
  EXPECT_FALSE(SessionReader::open(scratch.path()));
  EXPECT_FALSE(SessionReader::open(scratch.path() / "none"));
}

}  // namespace
}  // namespace hapton
