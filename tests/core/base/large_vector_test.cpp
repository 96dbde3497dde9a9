#include "core/base/large_vector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace hapton {
namespace {

constexpr std::size_t kLargePage = std::size_t{1} << 21;

TEST(LargeVector, HoldsWhatIsPutIn) {
  LargeVector<std::uint64_t> numbers;
  for (std::uint64_t i = 0; i < 2'000'000; ++i) numbers.push_back(i);
  numbers.resize(1'500'000);
  numbers.shrink_to_fit();
  const LargeVector<std::uint64_t> copy = numbers;
  EXPECT_EQ(std::accumulate(copy.begin(), copy.end(), std::uint64_t{0}), std::uint64_t{1'500'000} * 1'499'999 / 2);
}

TEST(LargeVector, BeginsAtALargePageOnceItHasTwo) {
  for (const std::size_t bytes : {2 * kLargePage, 2 * kLargePage + 1}) {
    const LargeVector<std::uint8_t> large(bytes);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(large.data()) % kLargePage, 0U) << bytes;
  }
  struct alignas(64) Line {
    std::uint8_t bytes[64];
  };
  const LargeVector<Line> small(3);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(small.data()) % alignof(Line), 0U);
}

TEST(LargeVector, ThrowsIfMoreIsReservedThanThereIs) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer ends the program where there is not enough memory";
#endif
  LargeVector<std::uint64_t> numbers;
  EXPECT_THROW(numbers.reserve(static_cast<std::size_t>(-1) / 16), std::exception);
}

// The system must not be left to join small pages later (flag hg), because a reader would wait meanwhile.
TEST(LargeVector, LeavesNothingForTheSystemToJoinLater) {
  const LargeVector<std::uint8_t> large(4 * kLargePage);
  std::ifstream maps("/proc/self/smaps");
  std::string line;
  bool is_inside = false;
  std::string flags;
  while (std::getline(maps, line)) {
    unsigned long begin = 0;
    unsigned long end = 0;
    if (std::sscanf(line.c_str(), "%lx-%lx ", &begin, &end) == 2) {
      const auto address = reinterpret_cast<std::uintptr_t>(large.data());
      is_inside = begin <= address && address < end;
    } else if (is_inside && line.starts_with("VmFlags:")) {
      flags = line;
    }
  }
  if (flags.empty()) GTEST_SKIP() << "this system does not say how its memory is used";
  EXPECT_EQ(flags.find(" hg"), std::string::npos) << flags;
}

#if defined(__linux__) && defined(MADV_POPULATE_WRITE)
// Whether the system accepts this advice.
bool takes_advice(void* memory, std::size_t bytes, int advice) { return ::madvise(memory, bytes, advice) == 0; }

// The memory is filled before it is returned: each of its pages is resident.
TEST(LargeVector, IsFilledBeforeItIsReturned) {
  void* const probe = ::mmap(nullptr, 2 * kLargePage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(probe, MAP_FAILED);
  const bool is_possible = takes_advice(probe, 2 * kLargePage, MADV_HUGEPAGE) && takes_advice(probe, 2 * kLargePage, MADV_POPULATE_WRITE);
  ::munmap(probe, 2 * kLargePage);
  if (!is_possible) GTEST_SKIP() << "this system has no large pages for programs";
  for (const std::size_t bytes : {2 * kLargePage, 8 * kLargePage}) {
    void* const memory = allocate_large(bytes, 8);
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    std::vector<unsigned char> residency(bytes / page);
    ASSERT_EQ(::mincore(memory, bytes, residency.data()), 0);
    EXPECT_EQ(std::count_if(residency.begin(), residency.end(), [](unsigned char one) { return (one & 1U) == 0; }), 0) << bytes;
    free_large(memory, bytes, 8);
  }
}
#endif

}  // namespace
}  // namespace hapton
