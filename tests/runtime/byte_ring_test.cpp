#include "runtime/byte_ring.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/support/allocation_guard.h"
#include "tests/support/text_bytes.h"

namespace hapton {
namespace {

std::vector<std::string> drain(ByteRing& ring) {
  std::vector<std::string> records;
  ring.drain([&](std::span<const std::byte> r) { records.emplace_back(reinterpret_cast<const char*>(r.data()), r.size()); });
  return records;
}

TEST(ByteRing, GivesBackWhatWasPushedInOrder) {
  ByteRing ring(256);
  EXPECT_TRUE(ring.push(bytes_of("head"), bytes_of("body")));
  EXPECT_TRUE(ring.push(bytes_of("x"), {}));
  EXPECT_TRUE(ring.push({}, {}));
  EXPECT_EQ(drain(ring), (std::vector<std::string>{"headbody", "x", ""}));
  EXPECT_TRUE(drain(ring).empty());
}

TEST(ByteRing, RecordsStayContiguousAcrossTheWrapAround) {
  ByteRing ring(128);
  for (int n = 0; n < 1000; ++n) {
    const std::string record(static_cast<std::size_t>(n) % 50, static_cast<char>('a' + n % 26));
    ASSERT_TRUE(ring.push(bytes_of(record), {}));
    ASSERT_EQ(drain(ring), std::vector<std::string>{record});
  }
  EXPECT_EQ(ring.dropped(), 0U);
}

TEST(ByteRing, RecordsThatDoNotFitAreDroppedAndCounted) {
  ByteRing ring(64);
  EXPECT_TRUE(ring.push(bytes_of(std::string(40, 'a')), {}));
  EXPECT_FALSE(ring.push(bytes_of(std::string(40, 'b')), {}));
  EXPECT_FALSE(ring.push(bytes_of(std::string(100, 'c')), {}));
  EXPECT_EQ(ring.dropped(), 2U);
  EXPECT_EQ(drain(ring).size(), 1U);
  EXPECT_TRUE(ring.push(bytes_of("d"), {}));
  EXPECT_EQ(drain(ring), std::vector<std::string>{"d"});
}

TEST(ByteRing, PushingUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  ByteRing ring(1024);
  const std::string record(100, 'r');
  AllocationGuard guard;
  for (int n = 0; n < 20; ++n) ring.push(bytes_of(record), bytes_of(record));
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(ring.dropped(), 0U);
}

TEST(ByteRing, EveryRecordArrivesInOrderOrIsCountedAsDropped) {
  ByteRing ring(4096);
  constexpr std::uint64_t kRecords = 200'000;
  std::thread writer([&] {
    for (std::uint64_t n = 0; n < kRecords; ++n) {
      const std::string padding(n % 37, 'p');
      ring.push(std::as_bytes(std::span(&n, 1)), bytes_of(padding));
    }
  });
  std::uint64_t record_count = 0;
  std::uint64_t last = 0;
  bool in_order = true;
  const auto visit = [&](std::span<const std::byte> record) {
    std::uint64_t n = 0;
    std::memcpy(&n, record.data(), sizeof n);
    in_order = in_order && (record_count == 0 || n > last) && record.size() == sizeof n + n % 37;
    last = n;
    ++record_count;
  };
  while (record_count + ring.dropped() < kRecords) ring.drain(visit);
  writer.join();
  ring.drain(visit);
  EXPECT_TRUE(in_order);
  EXPECT_EQ(record_count + ring.dropped(), kRecords);
}

}  // namespace
}  // namespace hapton
