#include "link/session_reader.h"

#include <sys/stat.h>

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

std::string make_file(int entries) {
  SessionCodec codec;
  std::string bytes(kSessionMagic);
  codec.append(SessionHeader{.build = "b", .settings = {{"rate", "1000"}}}, bytes);
  const std::string padding(700, 'p');
  for (int n = 0; n < entries; ++n) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::sent;
    entry.time_ns = n;
    entry.datagram = std::as_bytes(std::span(padding.data(), padding.size()));
    codec.append(entry, bytes);
  }
  return bytes;
}

int count(SessionReader& reader) {
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
  EXPECT_EQ(count(*reader), 5000);
  EXPECT_EQ(reader->problem(), "");
}

TEST_F(SessionReaders, GoOnReadingWhereTheyAreSent) {
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

TEST_F(SessionReaders, WaitForNoPipe) {
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
  EXPECT_EQ(count(*reader), 9);
  EXPECT_NE(reader->problem().find("cut short after 9 entries"), std::string::npos) << reader->problem();
}

TEST_F(SessionReaders, GiveWhatIsBeforeADamagedEntry) {
  std::string bytes = make_file(10);
  bytes[bytes.size() - 1000] ^= 1;
  auto reader = SessionReader::open(scratch.write("s", bytes));
  ASSERT_TRUE(reader);
  EXPECT_EQ(count(*reader), 8);
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
    std::string says;
  } kCases[] = {{"", "not a recorded session"},
                {"t_s,x_m\n", "not a recorded session"},
                {"hapton.session/2\n....", "another schema"},
                {whole.substr(0, kSessionMagic.size() + 2), "header"}};
  for (const auto& [bytes, says] : kCases) {
    const auto reader = SessionReader::open(scratch.write("s", bytes));
    ASSERT_FALSE(reader) << bytes;
    EXPECT_NE(reader.error().what.find(says), std::string::npos) << reader.error().what;
    EXPECT_EQ(reader.error().what.find('\n'), std::string::npos);
  }
  EXPECT_FALSE(SessionReader::open(scratch.path()));
  EXPECT_FALSE(SessionReader::open(scratch.path() / "none"));
}

}  // namespace
}  // namespace hapton
