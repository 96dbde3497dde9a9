// Runs every input that a fuzzer starts from, or that once made a target fail, through its target again.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/corpus.h"
#include "tests/fuzz/fuzz_target.h"

namespace hapton::fuzz {
namespace {

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& [name, target] : targets()) all.push_back(name);
  return all;
}

class Corpus : public testing::TestWithParam<std::string> {};

TEST_P(Corpus, CrashesNothing) {
  const Target target = targets().at(GetParam());
  const auto files = corpus_of(GetParam());
  EXPECT_GE(files.size(), 3U);
  target({});
  for (const auto& path : files) {
    SCOPED_TRACE(path.string());
    const Bytes bytes = read_bytes(path);
    target(bytes);
    // Also inputs that are cut short, each in a buffer of exactly its size.
    for (const std::size_t size : {bytes.size() / 2, bytes.size() - std::min<std::size_t>(bytes.size(), 1)}) {
      target(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
    }
  }
}

TEST_P(Corpus, MutantsCrashNothing) {
  constexpr std::uint64_t kSeed = 8;
  constexpr int kMutants = 1000;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  const std::vector<Bytes> inputs = read_corpus(GetParam());
  for (int i = 0; i < kMutants; ++i) {
    SCOPED_TRACE(i);
    targets().at(GetParam())(mutate(inputs, random));
  }
}

std::string name_of(const testing::TestParamInfo<std::string>& target) { return target.param; }

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, testing::ValuesIn(names()), name_of);

TEST(Corpora, BelongToTargets) {
  for (const auto& entry : std::filesystem::directory_iterator(std::string(HAPTON_SOURCE_DIR) + "/tests/fuzz/corpus")) {
    EXPECT_TRUE(targets().contains(entry.path().filename().string())) << entry.path();
  }
}

}  // namespace
}  // namespace hapton::fuzz
