#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/mutation.h"

// Reads the corpora of the source tree, and makes the simple changes to them that tests use.
namespace hapton::fuzz {

inline std::vector<std::filesystem::path> corpus_of(const std::string& target) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(HAPTON_SOURCE_DIR) + "/tests/fuzz/corpus/" + target)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

inline Bytes read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline std::vector<Bytes> read_corpus(const std::string& target) {
  std::vector<Bytes> inputs;
  for (const auto& path : corpus_of(target)) inputs.push_back(read_bytes(path));
  return inputs;
}

// Returns one of the inputs, in which a few bytes are changed, removed or inserted, or the end is that of another input.
inline Bytes mutate(const std::vector<Bytes>& inputs, std::mt19937_64& random) {
  Bytes bytes = inputs[random() % inputs.size()];
  const std::uint64_t change_count = 1 + random() % 8;
  for (std::uint64_t change = 0; change < change_count; ++change) {
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
        const Bytes& other = inputs[random() % inputs.size()];
        bytes.erase(place, bytes.end());
        bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(random() % (other.size() + 1)), other.end());
      }
    }
  }
  return bytes;
}

}  // namespace hapton::fuzz
