// Every input that a fuzzer starts from or once tripped over, through its target again.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_target.h"

namespace hapton::fuzz {
namespace {

std::vector<std::filesystem::path> corpus_of(const std::string& target) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(HAPTON_SOURCE_DIR) + "/tests/fuzz/corpus/" + target)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::uint8_t> read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& [name, target] : targets()) all.push_back(name);
  return all;
}

class Corpus : public testing::TestWithParam<std::string> {};

TEST_P(Corpus, IsBorne) {
  const Target target = targets().at(GetParam());
  const auto files = corpus_of(GetParam());
  EXPECT_GE(files.size(), 3U);
  target({});
  for (const auto& path : files) {
    SCOPED_TRACE(path.string());
    const std::vector<std::uint8_t> bytes = read(path);
    target(bytes);
    // And cut short, in copies of their own size.
    for (const std::size_t size : {bytes.size() / 2, bytes.size() - std::min<std::size_t>(bytes.size(), 1)}) {
      target(std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
    }
  }
}

// One of the inputs with a few bytes changed, taken out or put in, or with the end of another.
std::vector<std::uint8_t> mutate(const std::vector<std::vector<std::uint8_t>>& inputs, std::mt19937_64& random) {
  std::vector<std::uint8_t> bytes = inputs[random() % inputs.size()];
  for (std::uint64_t change = 0; change < 1 + random() % 8; ++change) {
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(random() % (bytes.size() + 1));
    const auto value = static_cast<std::uint8_t>(random());
    switch (random() % 4) {
      case 0:
        if (place != bytes.end()) *place ^= static_cast<std::uint8_t>(1U << (value % 8));
        break;
      case 1:
        if (place != bytes.end()) bytes.erase(place);
        break;
      case 2:
        bytes.insert(place, value);
        break;
      default: {
        const std::vector<std::uint8_t>& other = inputs[random() % inputs.size()];
        bytes.erase(place, bytes.end());
        bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(random() % (other.size() + 1)), other.end());
      }
    }
  }
  return bytes;
}

TEST_P(Corpus, MutantsAreBorne) {
  constexpr std::uint64_t kSeed = 8;
  constexpr int kMutants = 1000;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::vector<std::vector<std::uint8_t>> inputs;
  for (const auto& path : corpus_of(GetParam())) inputs.push_back(read(path));
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
