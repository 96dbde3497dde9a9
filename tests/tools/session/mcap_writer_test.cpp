#include "tools/session/mcap_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/file_size_limit.h"
#include "tests/support/one_line.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using std::string_literals::operator""s;

const std::vector<McapWriter::Schema> kSchemas = {{"a.B", "protobuf", "SCHEMA"}};
const std::vector<McapWriter::Channel> kChannels = {{1, "/a", "protobuf"}, {0, "/b", "json"}};

std::string read_all(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::uint64_t number_at(const std::string& bytes, std::size_t at, std::size_t size = 8) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= std::uint64_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  return value;
}

// The types of the records from `at` up to the footer. tests/python/mcap_strict.py checks their contents.
std::string record_types(const std::string& bytes, std::size_t at) {
  std::string types;
  while (types.empty() || types.back() != '\x02') {
    if (at + 9 > bytes.size()) return types + "?";
    types += bytes[at];
    at += 9 + number_at(bytes, at + 1);
  }
  return at + 8 == bytes.size() ? types : types + "!";
}

// The position at which the contents of the first record of this type begin.
std::size_t find_record(const std::string& bytes, std::size_t at, char type) {
  while (at + 9 < bytes.size() && bytes[at] != type) at += 9 + number_at(bytes, at + 1);
  return at + 9;
}

TEST(McapWriter, AnEmptyFileIsExactlyTheBytesOfTheSpecification) {
  const ScratchFolder scratch;
  const auto path = scratch.path() / "empty.mcap";
  auto writer = McapWriter::open(path, "us", {}, {});
  ASSERT_TRUE(writer) << writer.error().what;
  ASSERT_TRUE(writer->close());
  const std::string bytes = read_all(path);
  const std::string header = "\x89MCAP0\r\n\x01\x0a\0\0\0\0\0\0\0\0\0\0\0\x02\0\0\0us"s;
  EXPECT_EQ(bytes.substr(0, header.size()), header);
  EXPECT_EQ(bytes.substr(bytes.size() - 8), "\x89MCAP0\r\n"s);
  EXPECT_EQ(record_types(bytes, 8), "\x01\x0f\x0b\x0e\x02"s) << "header, end of data, statistics, summary offset, footer";
  const std::size_t footer = bytes.size() - 8 - 29;  // the magic of 8 bytes at the end, and the whole record of the footer
  EXPECT_EQ(number_at(bytes, footer + 1), 20U);
  EXPECT_EQ(number_at(bytes, footer + 9), header.size() + 13U) << "the summary begins after the end of data, a record of 13 bytes";
}

TEST(McapWriter, AChunkIsFollowedByTheIndexOfEachChannelInIt) {
  const ScratchFolder scratch;
  const auto path = scratch.path() / "two.mcap";
  auto writer = McapWriter::open(path, "us", kSchemas, kChannels);
  ASSERT_TRUE(writer);
  writer->add_metadata("m", {{"k", "v"}});
  const std::string big(McapWriter::kChunkBytes / 2, 'x');
  for (std::uint64_t n = 0; n < 5; ++n) writer->add_message(0, 10 - n, 5, big);
  writer->add_message(1, 3, 3, "{}");
  EXPECT_EQ(writer->messages(), 6U);
  ASSERT_TRUE(writer->close());
  const std::string bytes = read_all(path);
  EXPECT_EQ(record_types(bytes, 8),
            "\x01\x03\x04\x04\x0c"s          // header, schema, channels, metadata
            "\x06\x07\x06\x07\x06\x07\x07"s  // chunks with their indexes; the last has both channels
            "\x0f\x03\x04\x04\x0b\x08\x08\x08\x0d\x0e\x0e\x0e\x0e\x0e\x02"s);
  const std::size_t statistics = find_record(bytes, 8, '\x0b');
  EXPECT_EQ(number_at(bytes, statistics), 6U);
  EXPECT_EQ(number_at(bytes, statistics + 26), 3U) << "time of the first message";
  EXPECT_EQ(number_at(bytes, statistics + 34), 10U) << "... and of the last";
}

TEST(McapWriter, AFullDiskIsOneLine) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  auto writer = McapWriter::open("/dev/full", "us", kSchemas, kChannels);
  ASSERT_TRUE(writer) << writer.error().what;
  for (int n = 0; n < 100; ++n) writer->add_message(0, 1, 1, std::string(100'000, 'x'));
  const auto closed = writer->close();
  ASSERT_FALSE(closed);
  EXPECT_NE(closed.error().what.find("/dev/full: cannot be written: No space left"), std::string::npos) << closed.error().what;
  EXPECT_THAT(closed.error().what, IsOneLine());
  const auto nowhere = McapWriter::open("/proc/none/a.mcap", "us", kSchemas, kChannels);
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.error().what.find("/proc/none/a.mcap"), std::string::npos);
  EXPECT_THAT(nowhere.error().what, IsOneLine());
}

TEST(McapWriter, OnAFullDiskThereIsNoFile) {
  const ScratchFolder scratch;
  const auto path = scratch.path() / "a.mcap";
  Result<void> closed;
  {
    const FileSizeLimit full(1'500'000);
    auto writer = McapWriter::open(path, "us", kSchemas, kChannels);
    ASSERT_TRUE(writer);
    for (int i = 0; i < 3'000; ++i) writer->add_message(0, 1, 1, std::string(1'000, 'x'));
    EXPECT_FALSE(std::filesystem::exists(path)) << "the file is not complete";
    closed = writer->close();
  }
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().what, path.string() + ": cannot be written: File too large");
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

}  // namespace
}  // namespace hapton
